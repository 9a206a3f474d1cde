//! Nodes, lights and cameras as entities.

use antumbra::scene::gltf_import::{SkipKind, spawn_scene};
use antumbra::scene::{Camera, Light, LightKind};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, Vec3};
use serde_json::json;

use super::assert_near;
use crate::gltf_builder::*;

#[test]
fn scenes_lights_and_cameras_are_spawned_in_node_order() {
    let mut builder = animated();
    builder.push("scenes", json!({"name": "second", "nodes": [4]}));
    builder.push("scenes", json!({}));
    builder.push("nodes", json!({"scale": [-1, 1, 1], "name": "mirror"}));
    builder.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {
        "xmag": 2.0, "ymag": 1.0, "zfar": 10.0, "znear": 0.0}}),
    );
    builder.push(
        "cameras",
        json!({"type": "orthographic", "orthographic": {
        "xmag": 1.0, "ymag": 1.0, "zfar": 0.1, "znear": 10.0}}),
    );
    let lights = builder.json["extensions"]["KHR_lights_punctual"]["lights"]
        .as_array_mut()
        .unwrap();
    lights
        .push(json!({"type": "spot", "range": 7.0, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}}));
    lights.push(json!({"type": "directional", "color": [1.0, 0.5, 0.25]}));
    lights.push(json!({"type": "spot", "spot": {"innerConeAngle": 0.5, "outerConeAngle": 0.3}}));
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::Camera), 1);
    assert_eq!(gltf.cameras[1], Some(Camera::orthographic(2.0, 0.0, 10.0, 2.0)));
    assert_eq!(gltf.cameras[2], None);
    assert_eq!(gltf.lights[0], Light::point(Vec3::ONE, 12.5, f32::INFINITY));
    let spot = LightKind::Spot {
        inner_angle: 0.1,
        outer_angle: 0.2,
    };
    assert_eq!((gltf.lights[1].kind, gltf.lights[1].range), (spot, 7.0));
    assert_eq!(gltf.lights[2], Light::directional(Vec3::new(1.0, 0.5, 0.25), 1.0));
    // Crossed angles make a cone with a sharp edge instead of a light that is skipped.
    let sharp = LightKind::Spot {
        inner_angle: 0.3,
        outer_angle: 0.3,
    };
    assert_eq!(gltf.lights[3].kind, sharp);
    assert!(gltf.lights[3].validate().is_ok());
    let report = gltf.report.to_string();
    assert_eq!(gltf.report.count(SkipKind::LightValue), 1, "{report}");
    assert!(
        report.contains("inner angle, 0.5, is larger than its outer one, 0.3"),
        "{report}"
    );

    let (mut world, mut schedule) = frame();
    let first = spawn_scene(&mut world, &gltf, None).unwrap();
    let second = spawn_scene(&mut world, &gltf, Some(1)).unwrap();
    assert!(
        spawn_scene(&mut world, &gltf, Some(2))
            .unwrap()
            .nodes
            .nodes
            .iter()
            .all(Option::is_none)
    );
    let node = first.nodes.nodes[3].unwrap();
    assert_eq!(
        (&first.lights[..], &first.cameras[..]),
        (&[node][..], &[node][..])
    );
    assert_eq!(world.get::<Camera>(node).unwrap().vertical_fov, 0.8);
    assert_eq!(first.nodes.nodes[4], None);
    assert_eq!(
        world.get::<Name>(first.nodes.nodes[1].unwrap()).unwrap().as_str(),
        "hip"
    );
    assert_eq!(
        world
            .get::<ChildOf>(first.nodes.nodes[2].unwrap())
            .unwrap()
            .parent(),
        first.nodes.nodes[1].unwrap()
    );
    let mirror = second.nodes.nodes[4].unwrap();
    schedule.run(&mut world);
    assert!(
        world
            .get::<GlobalTransform>(mirror)
            .unwrap()
            .affine()
            .matrix3
            .determinant()
            < 0.0
    );
    let message = spawn_scene(&mut world, &gltf, Some(3)).unwrap_err().to_string();
    assert!(
        message.contains("test.glb: file: scene 3 does not exist, the file has 3"),
        "{message}"
    );
}

#[test]
fn matrices_become_transforms_even_when_they_flatten() {
    let mut builder = quad();
    let expected = Transform {
        translation: Vec3::new(1.0, 2.0, 3.0),
        rotation: Quat::from_rotation_y(0.5),
        scale: Vec3::new(-2.0, 3.0, 4.0),
    };
    builder.json["nodes"][0]["matrix"] = json!(glam::Mat4::from(expected.compute_affine()).to_cols_array());
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let transform = gltf.nodes[0].transform;
    assert_near(
        transform.transform_point(Vec3::ONE),
        expected.transform_point(Vec3::ONE),
    );

    let flat = Transform {
        scale: Vec3::new(2.0, 0.0, 4.0),
        ..expected
    };
    builder.json["nodes"][0]["matrix"] = json!(glam::Mat4::from(flat.compute_affine()).to_cols_array());
    let gltf = builder.load();
    // A plate, which is drawn.
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    assert_near(
        gltf.nodes[0].transform.transform_point(Vec3::ONE),
        flat.transform_point(Vec3::ONE),
    );
    builder.json["nodes"][0]["matrix"] = json!(glam::Mat4::ZERO.to_cols_array());
    assert_eq!(builder.load().report.count(SkipKind::NodeTransform), 1);
}
