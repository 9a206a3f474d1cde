//! Faults in how glTF files were read: sheared transforms, scaled cameras and compressed data.

use antumbra::prelude::*;
use antumbra::scene::camera_place;
use antumbra::scene::gltf_import::spawn_scene;
use antumbra::sets::View;
use bevy_ecs::schedule::IntoScheduleConfigs;
use bevy_transform::prelude::GlobalTransform;
use glam::{Mat4, Vec3};
use serde_json::json;

use crate::gltf_builder::{Builder, QUAD, frame, quad};

/// Columns of matrices that no translation, rotation and scale make: sheared, sheared and mirrored, sheared and flat.
const SHEARS: [[f32; 16]; 4] = [
    [
        1.0, 0.0, 0.0, 0.0, 1.2, 1.0, 0.5, 0.0, 0.0, 0.0, 1.0, 0.0, -1.2, 0.0, 0.0, 1.0,
    ],
    [
        0.5, 0.0, 0.4, 0.0, 0.0, 1.0, 0.0, 0.0, 0.4, 0.0, 0.5, 0.0, 2.0, 0.0, 0.5, 1.0,
    ],
    [
        -1.0, 0.3, 0.0, 0.0, 0.2, 2.0, 0.0, 0.0, 0.0, 0.7, 1.0, 0.0, 1.0, 2.0, 3.0, 1.0,
    ],
    [
        1.0, 0.0, 0.0, 0.0, 0.5, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0,
    ],
];

#[test]
fn sheared_matrices_are_kept() {
    for columns in SHEARS {
        let mut builder = quad();
        builder.json["nodes"][0]["matrix"] = json!(columns);
        let gltf = builder.load();
        assert!(gltf.report.is_empty(), "{}", gltf.report);
        assert!(gltf.nodes[0].stretch.is_some());
        let (mut world, mut schedule) = frame();
        let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
        schedule.run(&mut world);
        let node = spawned.nodes.nodes[0].unwrap();
        let affine = world.get::<GlobalTransform>(node).unwrap().affine();
        let matrix = Mat4::from_cols_array(&columns);
        for corner in QUAD {
            let (got, wanted) = (
                affine.transform_point3(Vec3::from(corner)),
                matrix.transform_point3(Vec3::from(corner)),
            );
            assert!(got.distance(wanted) < 3e-6, "{got} {wanted}");
        }
        // Its own turn alone is another matrix.
        let alone = gltf.nodes[0].transform.compute_affine();
        assert!(Vec3::from(alone.matrix3.y_axis).distance(matrix.y_axis.truncate()) > 0.1);
    }
}

/// A camera on a node below a parent.
fn camera_file(parent_scale: [f32; 3], own_scale: [f32; 3]) -> Builder {
    let mut builder = quad();
    let turn = glam::Quat::from_rotation_y(0.5).to_array();
    let tilt = glam::Quat::from_rotation_x(-0.3).to_array();
    builder.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5}}),
    );
    let child = builder.push(
        "nodes",
        json!({"camera": 0, "rotation": tilt, "scale": own_scale}),
    );
    builder.root_node(json!({
        "translation": [1.0, 2.0, 6.0], "rotation": turn, "scale": parent_scale, "children": [child],
    }));
    builder
}

#[test]
fn the_scale_of_a_camera_and_its_parents_is_ignored() {
    let one = [1.0; 3];
    let view_of = |parent, own| {
        let gltf = camera_file(parent, own).load();
        let (mut world, mut schedule) = frame();
        antumbra::schedule::init_resources(&mut world);
        world.insert_resource(ViewportSize(glam::UVec2::new(96, 64)));
        schedule.add_systems(antumbra::sets::collect_sets().after(antumbra::scene::update_world_bounds));
        let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
        schedule.run(&mut world);
        let place = camera_place(&world, spawned.cameras[0]).unwrap();
        let view = world.resource::<View>().data.clone();
        (view.map(|view| (view.view_from_world, view.near)), place)
    };
    let (unit, _) = view_of(one, one);
    let unit = unit.unwrap();
    for scale in [
        [100.0; 3],
        [0.01; 3],
        [1.0, 2.0, 0.5],
        [-1.0, 1.0, 1.0],
        [-1.0; 3],
        [0.0; 3],
        [1.0, 0.0, 1.0],
    ] {
        for (parent, own) in [(scale, one), (one, scale), (scale, scale)] {
            let (view, place) = view_of(parent, own);
            let view = view.unwrap_or_else(|| panic!("no view with {parent:?}, {own:?}"));
            let same = view.0.abs_diff_eq(unit.0, 1e-5);
            assert!(same && view.1 == unit.1, "{parent:?} {own:?}: {view:?} {unit:?}");
            assert!((place.affine().matrix3.determinant() - 1.0).abs() < 1e-5);
        }
    }
    // A camera without the mark keeps its scale.
    let gltf = camera_file([100.0; 3], one).load();
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    schedule.run(&mut world);
    let camera = spawned.cameras[0];
    world.entity_mut(camera).remove::<antumbra::scene::IgnoresScale>();
    let place = camera_place(&world, camera).unwrap();
    assert!(place.affine().matrix3.determinant() > 1e5);
}

#[cfg(not(feature = "gltf-draco"))]
#[test]
fn compressed_data_without_a_fallback_is_an_error_that_names_it() {
    let draco = json!({"KHR_draco_mesh_compression": {"bufferView": 0, "attributes": {"POSITION": 0}}});
    let mut builder = quad();
    builder.json["extensionsUsed"] = json!(["KHR_draco_mesh_compression"]);
    builder.json["meshes"][0]["primitives"][0]["extensions"] = draco;
    // With data of its own it loads.
    assert_eq!(builder.load().triangle_count(), 2);
    for accessor in [0, 2] {
        let mut builder = Builder {
            json: builder.json.clone(),
            binary: builder.binary.clone(),
        };
        let accessor = &mut builder.json["accessors"][accessor];
        accessor.as_object_mut().unwrap().remove("bufferView");
        let error = builder.error();
        for part in [
            "mesh 0",
            "primitive 0",
            "KHR_draco_mesh_compression",
            "gltf-draco",
        ] {
            assert!(error.contains(part), "{error}");
        }
    }
    // Zeros are data where nothing is compressed.
    let mut zeros = quad();
    zeros.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(zeros.load().triangle_count(), 2);
}
