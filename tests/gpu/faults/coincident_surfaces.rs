//! Surfaces in one place: what is placed twice, modelled twice, or lies in the plane of something else. Each pixel gets each
//! light once.

use antumbra::prelude::*;
use antumbra::scene::{LightDistance, ShadowTint};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{draw, lamp, object, stage};

/// Adds a light with each kind of result: none, stencil, mask, mask of functions, coloured shadow.
fn add_lights(stage: &mut crate::harness::support::stage::Stage) {
    let at = |k: f32| Vec3::new(1.5 - 0.4 * k, 2.6, 1.0 + 0.3 * k);
    let lamps: Vec<Entity> = (0..6)
        .map(|k| {
            let kind = if k == 3 {
                LightKind::Sphere { radius: 0.2 }
            } else {
                LightKind::Point
            };
            lamp(stage, kind, at(k as f32), 20.0)
        })
        .collect();
    let world = &mut stage.world;
    world.entity_mut(lamps[1]).insert(StencilVolume::default());
    world.entity_mut(lamps[2]).insert(OmniMap::default());
    world.entity_mut(lamps[3]).insert(PenumbraWedge::default());
    let distance = LightDistance {
        far: 30.0,
        ..LightDistance::default()
    };
    world
        .entity_mut(lamps[4])
        .insert((StencilVolume::default(), distance));
    let tint = ShadowTint {
        color: Vec3::new(0.2, 0.1, 0.0),
        ..ShadowTint::default()
    };
    world
        .entity_mut(lamps[5])
        .insert((StencilVolume::default(), tint));
}

/// The radiance of a floor and these objects.
fn radiance(objects: &[(MeshData, Transform)], shows_shadows: bool) -> Vec<f32> {
    let mut stage = stage(
        Vec3::new(2.0, 1.7, 2.8),
        Vec3::new(0.0, 0.4, 0.0),
        Camera::default(),
    );
    let floor = (MeshData::plane(3.0), Transform::IDENTITY);
    for (mesh, place) in [floor].iter().chain(objects) {
        let spawned = stage.world.spawn(object(mesh.clone(), *place)).id();
        if !shows_shadows {
            stage.world.entity_mut(spawned).remove::<ShadowReceiver>();
        }
    }
    add_lights(&mut stage);
    draw(&mut stage).radiance
}

/// Number of values that differ by more than rounding.
fn differing(a: &[f32], b: &[f32]) -> usize {
    let differs = |(a, b): &(&f32, &f32)| (*a - *b).abs() > 0.01 * a.abs().max(b.abs());
    a.iter().zip(b).filter(differs).count()
}

fn cuboid(half: Vec3, at: Vec3) -> (MeshData, Transform) {
    (MeshData::cuboid(half), Transform::from_translation(at))
}

/// A mesh with each of its triangles twice.
fn doubled(mesh: &MeshData) -> MeshData {
    let mut twice = mesh.clone();
    twice.indices.extend_from_slice(&mesh.indices);
    twice.submeshes[0].index_count *= 2;
    twice
}

#[test]
fn surfaces_in_one_place_are_lit_once() {
    let half = Vec3::new(0.4, 0.5, 0.4);
    let [one, right] = [-0.1, 0.2].map(|x| cuboid(half, Vec3::new(x, 0.5, 0.0)));
    let both = cuboid(half + Vec3::X * 0.15, Vec3::new(0.05, 0.5, 0.0));
    let pairs = [
        ("placed twice", vec![one.clone()], vec![one.clone(), one.clone()]),
        (
            "modelled twice",
            vec![one.clone()],
            vec![(doubled(&one.0), one.1)],
        ),
        (
            "a plate on the floor",
            vec![one.clone()],
            vec![
                one.clone(),
                (MeshData::plane(1.1), Transform::from_xyz(0.2, 0.0, 0.3)),
            ],
        ),
        ("two boxes in line", vec![both], vec![one, right]),
    ];
    for (name, expected, scene) in pairs {
        for shows_shadows in [true, false] {
            let (expected, got) = (
                radiance(&expected, shows_shadows),
                radiance(&scene, shows_shadows),
            );
            let wrong = differing(&expected, &got);
            // Edges between two boxes may round to either side.
            assert!(
                wrong <= 40,
                "{name}, shadows {shows_shadows}: {wrong} of {} values",
                got.len()
            );
            let brighter: Vec<f32> = expected.iter().map(|value| value * 1.1).collect();
            assert!(
                differing(&expected, &brighter) > expected.len() / 4,
                "the judge sees a tenth more light"
            );
        }
    }
}
