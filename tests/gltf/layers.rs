//! The extras of glTF nodes put meshes on named selection layers.

use crate::gltf_builder::Builder;
use antumbra::scene::gltf_import::{layer_of_name, load_gltf_slice, spawn_scene};
use antumbra::scene::{LayerNames, SelectionLayers};
use bevy_ecs::prelude::*;
use serde_json::{Value, json};

/// A group with a mesh below it, and a mesh beside it.
fn file(group: Value, child: Value) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
    let mesh = builder.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions}}]}),
    );
    let child = builder.push("nodes", json!({"name": "child", "mesh": mesh, "extras": child}));
    builder.root_node(json!({"name": "group", "children": [child], "extras": group}));
    builder.root_node(json!({"name": "beside", "mesh": mesh}));
    builder
}

fn layers(names: &[&str]) -> Value {
    json!({"antumbra": {"layers": names}})
}

#[test]
fn a_mesh_is_on_its_own_layers_and_on_those_above_it() {
    let builder = file(layers(&["set"]), layers(&["hero", "set"]));
    let gltf = load_gltf_slice(&builder.glb(), None, "layers.glb").expect("the file loads");
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).expect("the scene spawns");
    let names = world.resource::<LayerNames>();
    let (hero, set) = (
        names.bit("hero").expect("named"),
        names.bit("set").expect("named"),
    );
    assert_eq!(names.iter().count(), 2);
    let on = |world: &World, mesh: usize| {
        world
            .get::<SelectionLayers>(spawned.meshes[mesh])
            .expect("a mesh")
            .0
    };
    assert_eq!(on(&world, 0), 1 | hero | set);
    assert_eq!(on(&world, 1), 1);

    // A node's name is a layer as soon as somebody asks for it.
    let layer =
        |world: &mut World, name| layer_of_name(world, &gltf, &spawned.nodes, name).expect("a layer is left");
    let beside = layer(&mut world, "beside").expect("a node has the name");
    assert_eq!((on(&world, 0) & beside, on(&world, 1)), (0, 1 | beside));
    let group = layer(&mut world, "group").expect("a node has the name");
    assert_ne!(on(&world, 0) & group, 0, "what is below a node is on its layer");
    assert_eq!(layer(&mut world, "hero"), Some(hero));
    assert_eq!(layer(&mut world, "nobody"), None);
}

#[test]
fn a_name_for_which_no_layer_is_left_is_told_from_one_that_nothing_has() {
    let builder = file(json!({}), json!({}));
    let gltf = load_gltf_slice(&builder.glb(), None, "layers.glb").expect("the file loads");
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).expect("the scene spawns");
    let mut names = LayerNames::default();
    while names.add(&format!("layer {}", names.iter().count())).is_ok() {}
    world.insert_resource(names);
    let error = layer_of_name(&mut world, &gltf, &spawned.nodes, "beside").expect_err("all are taken");
    assert!(
        error
            .to_string()
            .contains("no layer is left for the name `beside`"),
        "{error}"
    );
    assert_eq!(
        layer_of_name(&mut world, &gltf, &spawned.nodes, "nobody"),
        Ok(None)
    );
}

#[test]
fn what_is_no_list_of_names_is_reported_and_selects_nothing() {
    for wrong in [json!("set"), json!([1]), json!([""])] {
        let builder = file(json!({"antumbra": {"layers": wrong}}), json!({}));
        let gltf = load_gltf_slice(&builder.glb(), None, "layers.glb").expect("the file loads");
        let mut world = World::new();
        spawn_scene(&mut world, &gltf, None).expect("the scene spawns");
        assert!(world.get_resource::<LayerNames>().is_none(), "{wrong}");
        let told = gltf.report.to_string();
        assert!(told.contains("layer"), "{told}");
    }
}
