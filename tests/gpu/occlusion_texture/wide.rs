//! A box and a post on grounds and under sky domes of many kilometres, without a range.

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::techniques::OcclusionTexture;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{SUN_TANGENT, Scene, lamp, rendered, rmse, square, staged, truth};
use crate::harness::strict_context;

/// The error of a light's shadow of a box and a post on a ground, that without a shadow, and the reports.
fn error(kind: LightKind, ground: f32, around: Vec<(MeshData, Transform)>) -> (f64, f64, Vec<String>) {
    let context = strict_context();
    let mut parts = vec![
        (MeshData::plane(ground), Transform::IDENTITY),
        (
            MeshData::cuboid(Vec3::new(0.25, 0.5, 0.25)),
            Transform::from_xyz(0.3, 0.5, 0.0),
        ),
        (
            MeshData::cuboid(Vec3::new(0.05, 0.7, 0.05)),
            Transform::from_xyz(-0.8, 0.7, 0.5),
        ),
    ];
    parts.extend(around);
    let scene = Scene {
        name: "a wide scene",
        parts,
        eye: Vec3::new(3.0, 2.2, 4.5),
    };
    let mut stage = staged(&context, &scene);
    let from = Vec3::new(0.5, 4.0, 1.0);
    let (mut light, place) = lamp(kind, from);
    light.range = f32::INFINITY;
    // A rectangle that is not level meets the ground in kilometres.
    let place = place.looking_at(from + Vec3::new(-0.1, -1.0, -0.2), Vec3::Z);
    let settings = OcclusionTexture {
        angle_deg: 2.0 * SUN_TANGENT.atan().to_degrees() as f32,
        ..Default::default()
    };
    stage.spawn_light(light, place, Some(settings));
    let got = rendered(&mut stage);
    let truth = truth(&mut stage, 64);
    let all_lit = vec![1.0; got.len()];
    let reports = stage.world.resource::<Reports>().iter();
    let messages = reports.map(|report| report.message.clone()).collect();
    (rmse(&truth, &got), rmse(&truth, &all_lit), messages)
}

/// The shadow of a box stays as it is on a small ground, on one of many kilometres and under a dome, and nothing is reported.
#[test]
fn grounds_and_domes_of_kilometres_leave_shadows_as_they_are() {
    let sphere = LightKind::Sphere { radius: 0.3 };
    for kind in [square(0.6), sphere, LightKind::Directional] {
        let (near, lit, _) = error(kind, 4.0, vec![]);
        assert!(lit > 0.01 && near < 0.4 * lit, "{kind:?}: {near}, {lit}");
        for (ground, dome) in [(3e3, None), (1e4, None), (3e5, None), (50.0, Some(1e3))] {
            if dome.is_some() && kind == LightKind::Directional {
                continue; // a dome shadows the sun
            }
            let dome_mesh = dome.map(|radius| (MeshData::icosphere(radius, 2), Transform::IDENTITY));
            let around = dome_mesh.into_iter().collect();
            let (wide, lit, messages) = error(kind, ground, around);
            println!(
                "{kind:?}, ground {ground}, dome {dome:?}: error {wide:.4}, {near:.4} near, {lit:.4} without"
            );
            assert!(wide < 1.25 * near + 0.004, "{kind:?}: {wide}, {near}");
            assert_eq!(messages, [""; 0], "{kind:?}");
        }
    }
}

/// A mountain 6 km away with a ground below that of a lamp, or a moon, take neither slices nor texels from what is near.
#[test]
fn mountains_and_moons_leave_shadows_as_they_are() {
    let mountain = (
        MeshData::cuboid(Vec3::new(1428.0, 1000.0, 1428.0)),
        Transform::from_xyz(-4166.0, -166.0, -6666.0),
    );
    let lower_ground = (MeshData::plane(1e4), Transform::from_xyz(0.0, -1.0, 0.0));
    let moon = (MeshData::icosphere(2e4, 2), Transform::from_xyz(2e5, 1e5, -3e5));
    for kind in [square(0.6), LightKind::Sphere { radius: 0.3 }] {
        let (near, lit, _) = error(kind, 4.0, vec![]);
        assert!(lit > 0.01 && near < 0.4 * lit, "{kind:?}: {near}, {lit}");
        for far in [vec![mountain.clone(), lower_ground.clone()], vec![moon.clone()]] {
            let (wide, lit, messages) = error(kind, 4.0, far);
            println!("{kind:?}: error {wide:.4}, {near:.4} near, {lit:.4} without");
            assert!(wide < 0.45 * lit, "{kind:?}: {wide}, {lit}");
            assert_eq!(messages, [""; 0], "{kind:?}");
        }
    }
}

/// A pit of a kilometre is a caster that takes all slices; a report says so.
#[test]
fn surroundings_that_take_all_slices_are_reported() {
    let ball = MeshData::icosphere(1e3, 2);
    let (mut positions, mut indices) = (ball.positions, ball.indices);
    indices.truncate(indices.len() / 6 * 3);
    indices.extend([0, 1, positions.len() as u32]);
    positions.push(Vec3::new(0.0, 300.0, 0.0));
    let pit = MeshData::from_triangles("pit", positions, indices);
    let (_, _, messages) = error(square(0.6), 4.0, vec![(pit, Transform::IDENTITY)]);
    let told = messages
        .iter()
        .any(|text| text.contains("shadows are coarse") && text.contains("range"));
    assert!(told, "{messages:?}");
    let (_, _, messages) = error(square(0.6), 4.0, vec![]);
    assert_eq!(messages, [""; 0]);
}
