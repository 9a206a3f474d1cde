//! Scenes that list children, hidden nodes, instances.

use antumbra::prelude::*;
use antumbra::scene::gltf_import::{SkipKind, spawn_scene};
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, Vec3};
use serde_json::json;

use crate::gltf_builder::*;

#[test]
fn a_scene_may_list_a_node_that_has_a_parent() {
    let mut builder = quad();
    builder.json["nodes"][0]["translation"] = json!([0.0, 1.0, 0.0]);
    builder.push("nodes", json!({"children": [0], "translation": [5.0, 0.0, 0.0]}));
    let gltf = builder.load();
    assert_eq!(
        (
            gltf.scenes[0].roots.clone(),
            gltf.report.count(SkipKind::SceneRoot)
        ),
        (vec![0], 1)
    );
    assert!(gltf.report.to_string().contains("scene 0"), "{}", gltf.report);
    let place = |gltf: &antumbra::scene::gltf_import::LoadedGltf| {
        let (mut world, mut schedule) = frame();
        let spawned = spawn_scene(&mut world, gltf, None).unwrap();
        schedule.run(&mut world);
        assert_eq!(spawned.meshes.len(), 1);
        world
            .get::<GlobalTransform>(spawned.meshes[0])
            .unwrap()
            .translation()
    };
    assert_eq!(place(&gltf), Vec3::Y);
    // Where the scene lists both, in either order, the parent moves its child and nothing is drawn twice.
    for roots in [json!([0, 1]), json!([1, 0]), json!([1, 0, 0, 1])] {
        builder.json["scenes"][0]["nodes"] = roots;
        let gltf = builder.load();
        assert_eq!(gltf.scenes[0].roots, [1]);
        assert!(gltf.report.count(SkipKind::SceneRoot) >= 1);
        assert_eq!(place(&gltf), Vec3::new(5.0, 1.0, 0.0));
    }
    // A grandparent in the scene counts too, and a list without faults is not reported.
    builder.push("nodes", json!({"children": [1]}));
    builder.json["scenes"][0]["nodes"] = json!([2, 0]);
    assert_eq!(builder.load().scenes[0].roots, [2]);
    builder.json["scenes"][0]["nodes"] = json!([2]);
    assert!(builder.load().report.is_empty());
}

#[test]
fn hidden_nodes_and_those_below_them_neither_show_nor_shine() {
    let mut builder = animated();
    builder.json["extensionsUsed"] = json!(["KHR_lights_punctual", "KHR_node_visibility"]);
    let visible = |visible: bool| json!({"KHR_node_visibility": {"visible": visible}});
    builder.push("nodes", json!({"children": [0, 3], "extensions": visible(false)}));
    builder.json["scenes"][0]["nodes"] = json!([1, 4]);
    builder.json["nodes"][0]["extensions"] = visible(true);
    let counts = |builder: &Builder| {
        let gltf = builder.load();
        assert!(gltf.report.is_empty(), "{}", gltf.report);
        let (mut world, _) = frame();
        let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
        let drawn = world.query::<&SceneMesh>().iter(&world).count();
        let casting = world.query::<&ShadowCaster>().iter(&world).count();
        assert_eq!((spawned.meshes.len(), casting), (drawn, drawn));
        (drawn, spawned.lights.len(), spawned.cameras.len())
    };
    assert_eq!(counts(&builder), (0, 0, 1));
    builder.json["nodes"][4]["extensions"] = visible(true);
    assert_eq!(counts(&builder), (1, 1, 1));
    builder.json["nodes"][3]["extensions"]["KHR_node_visibility"] = json!({"visible": false});
    assert_eq!(counts(&builder), (1, 0, 1));
}

/// An extension with a value of the wrong type changes nothing. The report names it and its node.
#[test]
fn extensions_of_nodes_that_cannot_be_read_are_reported() {
    let values = [json!(null), json!(5), json!("x"), json!([1])];
    let wrong = |name: &str, value: serde_json::Value| {
        let mut builder = quad();
        builder.json["extensionsUsed"] = json!([name]);
        builder.json["nodes"][0]["extensions"] = json!({ name: value });
        let gltf = builder.load();
        let (mut world, _) = frame();
        let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
        assert_eq!(spawned.meshes.len(), 1, "{name}");
        let report = gltf.report.to_string();
        assert!(report.contains("node 0") && report.contains(name), "{report}");
        gltf.report
    };
    for value in &values {
        let shown = wrong("KHR_node_visibility", value.clone());
        assert_eq!(shown.count(SkipKind::Extension), 1);
        let shown = wrong("KHR_node_visibility", json!({"visible": value}));
        assert_eq!(shown.count(SkipKind::Extension), 1);
        let once = wrong("EXT_mesh_gpu_instancing", value.clone());
        assert_eq!(once.count(SkipKind::Instance), 1);
        let once = wrong("EXT_mesh_gpu_instancing", json!({"attributes": value}));
        assert_eq!(once.count(SkipKind::Instance), 1);
    }
    let once = wrong("EXT_mesh_gpu_instancing", json!({}));
    assert_eq!(once.count(SkipKind::Instance), 1);
}

fn instanced(attributes: serde_json::Value) -> Builder {
    let mut builder = quad();
    builder.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing"]);
    builder.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": attributes}});
    builder
}

#[test]
fn every_instance_is_drawn_and_casts() {
    let mut builder = instanced(json!({}));
    builder.json["nodes"][0]["translation"] = json!([10.0, 0.0, 0.0]);
    let translations = builder.floats(&[[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 3.0]]);
    let half = i16::MAX;
    let quarter = ((f32::from(half)) * std::f32::consts::FRAC_1_SQRT_2) as i16;
    let turns = [[0, 0, 0, half], [0, quarter, 0, quarter], [0, 0, 0, half]];
    let bytes: Vec<u8> = turns
        .iter()
        .flatten()
        .flat_map(|x: &i16| x.to_le_bytes())
        .collect();
    let rotations = builder.accessor(&bytes, 5122, "VEC4", 3);
    builder.json["accessors"][rotations]["normalized"] = json!(true);
    let scales = builder.floats(&[[1.0; 3], [2.0; 3], [1.0, 1.0, -1.0]]);
    builder.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = json!({"TRANSLATION": f64::from(translations as u32), "ROTATION": rotations, "SCALE": scales, "_ID": 0});
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    schedule.run(&mut world);
    assert_eq!(spawned.meshes.len(), 3);
    let node = spawned.nodes.nodes[0].unwrap();
    assert!(
        world.get::<SceneMesh>(node).is_none(),
        "the node itself draws nothing"
    );
    let wanted = [
        Transform::IDENTITY,
        Transform::from_xyz(0.0, 2.0, 0.0)
            .with_rotation(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2))
            .with_scale(Vec3::splat(2.0)),
        Transform::from_xyz(0.0, 0.0, 3.0).with_scale(Vec3::new(1.0, 1.0, -1.0)),
    ];
    for (&entity, wanted) in spawned.meshes.iter().zip(wanted) {
        let got = world
            .get::<GlobalTransform>(entity)
            .unwrap()
            .transform_point(Vec3::ONE);
        let wanted = wanted.transform_point(Vec3::ONE) + Vec3::X * 10.0;
        assert!(got.distance(wanted) < 1e-3, "{got} {wanted}");
        assert!(world.get::<ShadowCaster>(entity).is_some() && world.get::<ShadowReceiver>(entity).is_some());
    }
    // All draw the same mesh, once in memory.
    let meshes: Vec<_> = spawned
        .meshes
        .iter()
        .map(|&mesh| world.get::<SceneMesh>(mesh).unwrap().0.clone())
        .collect();
    assert!(meshes.iter().all(|mesh| std::sync::Arc::ptr_eq(mesh, &meshes[0])));
    world.despawn(spawned.root);
    assert_eq!(world.query::<&SceneMesh>().iter(&world).count(), 0);
}

#[test]
fn instances_without_a_meaning_are_errors_or_reported() {
    for (attributes, parts) in [
        (json!({"TRANSLATION": 99}), ["node 0", "TRANSLATION"]),
        (json!({"SCALE": "big"}), ["node 0", "SCALE"]),
        (json!({"TRANSLATION": 2}), ["accessor 2", "3 numbers"]),
    ] {
        let error = instanced(attributes).error();
        assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    }
    let mut unequal = instanced(json!({}));
    let (two, three) = (unequal.floats(&[[0.0; 3]; 2]), unequal.floats(&[[1.0; 3]; 3]));
    let instancing = json!({"attributes": {"TRANSLATION": two, "SCALE": three}});
    unequal.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] = instancing;
    let error = unequal.error();
    assert!(
        error.contains("SCALE has 3 elements") && error.contains("has 2"),
        "{error}"
    );

    let mut nowhere = instanced(json!({}));
    let scales = nowhere.floats(&[[1.0; 3], [0.0; 3], [f32::NAN; 3]]);
    nowhere.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] =
        json!({"attributes": {"SCALE": scales}});
    assert_eq!(nowhere.load().report.count(SkipKind::Instance), 2);
    // Transforms of another application only: once, and reported.
    let gltf = instanced(json!({"_MATRIX": 0})).load();
    assert_eq!(
        (
            gltf.nodes[0].instances.clone(),
            gltf.report.count(SkipKind::Instance)
        ),
        (None, 1)
    );
    // A file of a few bytes cannot ask for all memory.
    let mut bomb = instanced(json!({}));
    let zeros = bomb.push(
        "accessors",
        json!({"componentType": F32, "type": "VEC3", "count": 1u64 << 40}),
    );
    bomb.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"] =
        json!({"attributes": {"TRANSLATION": zeros}});
    let error = bomb.error();
    assert!(error.contains("node 0") && error.contains("limit"), "{error}");
}

#[test]
fn a_skinned_mesh_is_drawn_once() {
    let mut builder = animated();
    let two = builder.floats(&[[0.0; 3]; 2]);
    builder.json["nodes"][0]["extensions"] =
        json!({"EXT_mesh_gpu_instancing": {"attributes": {"TRANSLATION": two}}});
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::Instance), 2);
    let (mut world, _) = frame();
    assert_eq!(spawn_scene(&mut world, &gltf, None).unwrap().meshes.len(), 1);
}
