//! Faults in how glTF files were read: sheared transforms, scaled cameras and compressed data.

use antumbra::prelude::*;
use antumbra::scene::camera_place;
use antumbra::scene::gltf_import::spawn_scene;
use antumbra::sets::View;
use bevy_ecs::schedule::IntoScheduleConfigs;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DMat4, Mat4, Quat, Vec3};
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

/// A camera on a node below a parent, each given by its parts or by a matrix.
fn camera_file(parent_scale: [f32; 3], own_scale: [f32; 3], as_matrix: bool) -> Builder {
    let mut builder = quad();
    let node = |translation: [f32; 3], turn: Quat, scale: [f32; 3]| {
        let transform = Transform::from_translation(translation.into())
            .with_rotation(turn)
            .with_scale(scale.into());
        if as_matrix {
            json!({"matrix": transform.to_matrix().to_cols_array()})
        } else {
            json!({"translation": translation, "rotation": turn.to_array(), "scale": scale})
        }
    };
    builder.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1, "aspectRatio": 1.5}}),
    );
    let mut camera = node([0.3, 0.2, 0.4], Quat::from_rotation_x(-0.3), own_scale);
    camera["camera"] = json!(0);
    let child = builder.push("nodes", camera);
    let mut parent = node([1.0, 2.0, 6.0], Quat::from_rotation_y(0.5), parent_scale);
    parent["children"] = json!([child]);
    builder.root_node(parent);
    builder
}

/// The view through the camera of a file, the camera's place, and its transform with scale.
fn seen_through(builder: &Builder) -> (Option<DMat4>, GlobalTransform, GlobalTransform) {
    let (mut world, mut schedule) = frame();
    antumbra::schedule::init_resources(&mut world);
    world.insert_resource(ViewportSize(glam::UVec2::new(96, 64)));
    schedule.add_systems(antumbra::sets::collect_sets().after(antumbra::scene::update_world_bounds));
    let spawned = spawn_scene(&mut world, &builder.load(), None).unwrap();
    schedule.run(&mut world);
    let camera = spawned.cameras[0];
    let place = camera_place(&world, camera).unwrap();
    let view = world.resource::<View>().data.as_ref();
    let view = view.map(|view| {
        assert_eq!(view.near, f64::from(0.1f32));
        view.view_from_world
    });
    (view, place, *world.get::<GlobalTransform>(camera).unwrap())
}

/// Scales of which nothing but the length of axes is seen in the direction of a camera, and what else a file may hold.
const SCALES: [[f32; 3]; 9] = [
    [100.0; 3],
    [0.01; 3],
    [0.0; 3],
    [1.0, 0.0, 1.0],
    [1.0, 2.0, 0.5],
    [-1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [-1.0; 3],
    [-3.0, 0.5, 0.2],
];

#[test]
fn the_scale_of_a_camera_and_its_parents_is_ignored() {
    let one = [1.0; 3];
    let (_, unit, _) = seen_through(&camera_file(one, one, false));
    for scale in SCALES {
        for (parent, own) in [(scale, one), (one, scale), (scale, scale)] {
            let (view, place, scaled) = seen_through(&camera_file(parent, own, false));
            let view = view.unwrap_or_else(|| panic!("no view with {parent:?}, {own:?}"));
            let turn = place.affine().matrix3;
            assert!((turn.determinant() - 1.0).abs() < 1e-5, "{parent:?} {own:?}");
            assert_eq!(place.translation(), scaled.translation());
            let inverse = place.to_matrix().as_dmat4().inverse();
            assert!(view.abs_diff_eq(inverse, 1e-5), "{parent:?} {own:?}: {view}");
            let is_lost = scale.contains(&0.0);
            if is_lost || scale.iter().all(|factor| *factor == scale[0] && *factor > 0.0) {
                assert!(
                    turn.abs_diff_eq(unit.affine().matrix3, 1e-5),
                    "{parent:?} {own:?}"
                );
            }
            if !is_lost {
                // It looks at what its −Z axis points at, and what its Y axis points at is straight above that.
                let scaled = scaled.affine().matrix3;
                assert!(
                    turn.z_axis.distance(scaled.z_axis.normalize()) < 1e-5,
                    "{parent:?} {own:?}"
                );
                assert!(turn.x_axis.dot(scaled.y_axis.normalize()).abs() < 1e-5);
                assert!(turn.y_axis.dot(scaled.y_axis) > 0.0, "{parent:?} {own:?}");
            }
        }
    }
    // A flat axis of its own is one that the rotation tells.
    for own in [[1.0, 1.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0]] {
        for as_matrix in [false, true] {
            let (_, place, _) = seen_through(&camera_file(one, own, as_matrix));
            let back = place.affine().matrix3.z_axis.dot(unit.affine().matrix3.z_axis);
            assert!(
                (back - 1.0).abs() < 1e-5,
                "{own:?}, matrix {as_matrix}: {place:?}"
            );
        }
    }
    // A camera without the mark keeps its scale.
    let gltf = camera_file([100.0; 3], one, false).load();
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    schedule.run(&mut world);
    let camera = spawned.cameras[0];
    world.entity_mut(camera).remove::<antumbra::scene::IgnoresScale>();
    let place = camera_place(&world, camera).unwrap();
    assert!(place.affine().matrix3.determinant() > 1e5);
}

#[test]
fn a_camera_sees_the_same_if_its_transforms_are_matrices() {
    for scale in SCALES.into_iter().filter(|scale| !scale.contains(&0.0)) {
        for (parent, own) in [(scale, [1.0; 3]), ([1.0; 3], scale), (scale, scale)] {
            let [parts, matrix] =
                [false, true].map(|as_matrix| seen_through(&camera_file(parent, own, as_matrix)).0.unwrap());
            assert!(
                parts.abs_diff_eq(matrix, 1e-3),
                "{parent:?} {own:?}: {parts} {matrix}"
            );
        }
    }
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
