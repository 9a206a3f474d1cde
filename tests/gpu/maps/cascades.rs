//! Cascades hold what the view shows, stand still while it turns, and move by whole texels.

use std::sync::Arc;

use antumbra::insides::{DepthRange, split_depths};
use antumbra::prelude::*;
use antumbra::techniques::maps::{FaceProjection, MapFace, MapResolution, Maps};
use antumbra::techniques::shadow_map::Cascades;
use bevy_ecs::prelude::Entity;
use bevy_transform::prelude::Transform;
use glam::{DVec3, UVec2, Vec3};

use crate::harness::support::stage::Stage;

const RESOLUTION: u32 = 512;

/// An open field of cubes under the sun, without a device.
fn field() -> (Stage, Entity) {
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(160, 90), camera, Transform::default());
    let add = |stage: &mut Stage, mesh: MeshData, at: Transform| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            (ShadowCaster, ShadowReceiver),
            at,
        ));
    };
    add(&mut stage, MeshData::plane(200.0), Transform::default());
    for i in 0..100 {
        let (x, z) = ((i % 10) as f32 * 20.0 - 100.0, (i / 10) as f32 * 20.0 - 100.0);
        add(
            &mut stage,
            MeshData::cuboid(Vec3::ONE),
            Transform::from_xyz(x, 1.0, z),
        );
    }
    let place = Transform::default().looking_to(Vec3::new(-0.5, -1.0, -0.3), Vec3::Y);
    let map = ShadowMap {
        resolution: MapResolution::Fixed(RESOLUTION),
        ..Default::default()
    };
    let sun = stage.spawn_light(Light::directional(Vec3::ONE, 3.0), place, Some(map));
    (stage, sun)
}

fn faces(stage: &mut Stage, eye: Vec3, target: Vec3) -> Vec<MapFace> {
    let camera = stage.camera;
    let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    stage.world.entity_mut(camera).insert(view);
    stage.schedule.run(&mut stage.world);
    let maps = stage.world.resource::<Maps>();
    maps.of_light(0)
        .expect("the sun has a map")
        .faces
        .iter()
        .map(|face| face.face)
        .collect()
}

fn half(face: &MapFace) -> f64 {
    match face.projection {
        FaceProjection::Parallel { half, .. } => half,
        _ => panic!("the sun has cascades"),
    }
}

#[test]
fn every_surface_in_view_lies_in_a_cascade() {
    let (mut stage, _) = field();
    for i in 0..24 {
        let (sin, cos) = (i as f32 * 0.4).sin_cos();
        let eye = Vec3::new(7.0 * cos, 3.0, 5.0 * sin);
        let target = eye + Vec3::new(cos, -0.1 - 0.02 * i as f32, sin);
        let faces = faces(&mut stage, eye, target);
        assert_eq!(faces.len(), 4);
        let forward = (target - eye).normalize();
        // Points of the ground that the view's middle column shows.
        for step in 1..60 {
            let point = eye + forward * (step as f32 * 0.5);
            let ground = point.with_y(0.0).as_dvec3();
            let view = stage.world.resource::<antumbra::sets::View>();
            let seen = view
                .data
                .as_ref()
                .expect("there is a view")
                .frustum
                .contains(ground.extend(1.0));
            let inside = faces.iter().any(|face| {
                let [x, y, z] = face.axes.map(|axis| axis.dot(ground - face.origin));
                let FaceProjection::Parallel { half, length } = face.projection else {
                    return false;
                };
                x.abs() < half && y.abs() < half && z > 0.0 && z < length
            });
            assert!(!seen || inside, "eye {eye}, point {ground}");
        }
    }
}

#[test]
fn turning_changes_no_size_and_moving_moves_whole_texels() {
    let (mut stage, _) = field();
    let eye = Vec3::new(3.0, 4.0, 5.0);
    let first = faces(&mut stage, eye, eye + Vec3::new(1.0, -0.3, 0.2));
    let mut moved = 0;
    for i in 0..200 {
        let angle = i as f32 * 0.05;
        let eye = eye + Vec3::new(0.03 * i as f32, 0.0, 0.01 * i as f32);
        let now = faces(&mut stage, eye, eye + Vec3::new(angle.cos(), -0.3, angle.sin()));
        for (a, b) in first.iter().zip(&now) {
            assert_eq!(a.axes, b.axes, "the light stands still");
            // The view's far end decides: sizes are steps of a quarter of a power of two.
            let steps = (half(b) / half(a)).log2() * 4.0;
            if steps.abs() < 1e-9 {
                let texel = 2.0 * half(a) / f64::from(RESOLUTION);
                for axis in &a.axes[..2] {
                    let texels: f64 = axis.dot(b.origin - a.origin) / texel;
                    assert!((texels - texels.round()).abs() < 1e-6, "{texels}");
                    moved += usize::from(texels.round() != 0.0);
                }
            }
        }
    }
    assert!(moved > 50, "{moved}");
}

#[test]
fn a_small_move_changes_nothing() {
    let (mut stage, _) = field();
    let eye = Vec3::new(3.0, 4.0, 5.0);
    let at = |offset: f32| eye + Vec3::new(offset, 0.0, 0.0);
    let look = Vec3::new(1.0, -0.3, 0.2);
    let (mut same, mut frames) = (0, 0);
    let mut last = faces(&mut stage, at(0.0), at(0.0) + look);
    for i in 1..100 {
        let eye = at(0.01 * i as f32);
        let now = faces(&mut stage, eye, eye + look);
        same += last.iter().zip(&now).filter(|(a, b)| a == b).count();
        frames += now.len();
        last = now;
    }
    assert!(same * 10 > frames * 8, "{same} of {frames} cascades stood still");
    assert!(same < frames, "they follow in the end");
}

#[test]
fn splits_run_from_uniform_to_logarithmic() {
    let of = |log_share| {
        let cascades = Cascades {
            log_share,
            ..Default::default()
        };
        let range = DepthRange {
            near: 1.0,
            nearest: 1.0,
            far: 256.0,
            ..Default::default()
        };
        split_depths(&cascades, &range)
    };
    let (uniform, log) = (of(0.0), of(1.0));
    for i in 1..4 {
        assert!((uniform[i + 1] - uniform[i] - 63.75).abs() < 1e-9);
        assert!((log[i + 1] / log[i] - 4.0).abs() < 1e-9);
        assert!(log[i] < of(0.5)[i] && of(0.5)[i] < uniform[i]);
    }
    assert_eq!(
        DVec3::new(uniform[0], uniform[4], log[4]),
        DVec3::new(1.0, 256.0, 256.0)
    );
}
