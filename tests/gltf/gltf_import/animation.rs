//! Clips between their keys.

use antumbra::scene::apply_animation;
use antumbra::scene::gltf_import::spawn_scene;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};
use serde_json::json;

use super::assert_near;
use crate::gltf_builder::*;

/// The translation of node 1 at a time, with the keys 0 s and 2 s.
fn translation_at(interpolation: &str, values: &[[f32; 3]], seconds: f32) -> Vec3 {
    let mut builder = animated();
    let output = builder.floats(values);
    builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    builder.json["animations"][0]["samplers"][0]["interpolation"] = json!(interpolation);
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    apply_animation(&mut world, &spawned, &gltf.clips[0], seconds);
    world
        .get::<Transform>(spawned.nodes.nodes[2].unwrap())
        .unwrap()
        .translation
}

#[test]
fn step_linear_and_cubic_spline_interpolate() {
    let ends = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0]];
    assert_near(translation_at("STEP", &ends, 1.9), Vec3::ZERO);
    assert_near(translation_at("STEP", &ends, 2.0), Vec3::X * 4.0);
    assert_near(translation_at("LINEAR", &ends, 0.5), Vec3::X);
    assert_near(translation_at("LINEAR", &ends, -1.0), Vec3::ZERO);
    // at u = 1/2 the Hermite weights are 1/2, 1/8, 1/2, −1/8; tangents count times the 2 s between the keys
    let spline = [
        [9.0, 9.0, 9.0],
        [0.0; 3],
        [0.0, 8.0, 0.0],
        [0.0, 0.0, 8.0],
        [4.0, 0.0, 0.0],
        [9.0, 9.0, 9.0],
    ];
    assert_near(
        translation_at("CUBICSPLINE", &spline, 1.0),
        Vec3::new(2.0, 2.0, -2.0),
    );
    assert_near(translation_at("CUBICSPLINE", &spline, 0.0), Vec3::ZERO);
    assert_near(translation_at("CUBICSPLINE", &spline, 5.0), Vec3::X * 4.0);
}

#[test]
fn rotations_take_the_shorter_arc() {
    let mut builder = animated();
    let turn = Quat::from_rotation_z(1.0);
    let output = builder.floats(&[[0.0, 0.0, 0.0, 1.0], (-turn).to_array()]);
    builder.json["animations"][0]["samplers"][0]["output"] = json!(output);
    builder.json["animations"][0]["channels"][0]["target"]["path"] = json!("rotation");
    let gltf = builder.load();
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    apply_animation(&mut world, &spawned, &gltf.clips[0], 0.5);
    let rotation = world
        .get::<Transform>(spawned.nodes.nodes[2].unwrap())
        .unwrap()
        .rotation;
    assert!(
        rotation.dot(Quat::from_rotation_z(0.25)).abs() > 1.0 - 1e-6,
        "{rotation}"
    );
}
