//! A ground of two triangles that ends beyond the horizon does not shadow itself.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::Settings;
use antumbra::techniques::maps::MapResolution;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(96, 54);

/// Visibility under each light and map, with a ground of some half side, divided along one of its diagonals.
fn pictures(half: f32, turned: bool, lights: &[(LightKind, Settings)]) -> Vec<Vec<f32>> {
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(-2.2, 2.6, 2.2).looking_at(Vec3::new(0.0, 0.2, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let mut ground = MeshData::plane(half);
    if turned {
        ground.indices = vec![0, 1, 3, 1, 2, 3];
    }
    let block = MeshData::cuboid(Vec3::new(0.4, 0.5, 0.4));
    for (mesh, height) in [(ground, 0.0), (block, 1.3)] {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(0.3, height, 0.0),
        ));
    }
    let place = Transform::from_xyz(1.0, 4.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y);
    for (kind, map) in lights {
        let light = Light {
            kind: *kind,
            ..Light::point(Vec3::ONE, 60.0, f32::INFINITY)
        };
        stage.spawn_shadowed(light, place, Some(map));
    }
    stage.render().expect("the frame renders").visibility
}

#[test]
fn maps_do_not_depend_on_how_far_the_ground_reaches() {
    let spot = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    let resolution = MapResolution::Fixed(512);
    let plain = |resolution| ShadowMap {
        resolution,
        ..Default::default()
    };
    let perspective = Settings::of(PerspectiveMap {
        resolution,
        ..Default::default()
    });
    let smoothie = Settings::of(Smoothie {
        resolution,
        ..Default::default()
    });
    // The perspective maps are the third to the fifth.
    let lights = [
        (spot, Settings::of(plain(resolution))),
        (LightKind::Directional, Settings::of(plain(resolution))),
        (spot, perspective.clone()),
        (LightKind::Point, perspective.clone()),
        (LightKind::Directional, perspective),
        (spot, smoothie.clone()),
        (LightKind::Point, smoothie),
    ];
    let near = pictures(30.0, false, &lights);
    for picture in &near {
        let dark = picture.iter().filter(|value| **value < 0.1).count();
        assert!(dark > 60, "{dark} dark");
    }
    for half in [10_000.0, 30_000.0, 100_000.0, 300_000.0] {
        for turned in [false, true] {
            let far = pictures(half, turned, &lights);
            let off = |(near, far): (&Vec<f32>, &Vec<f32>)| {
                let pairs = near.iter().zip(far);
                pairs.filter(|(a, b)| (*a - *b).abs() > 0.5).count()
            };
            let off: Vec<usize> = near.iter().zip(&far).map(off).collect();
            println!("{half} m, turned {turned}: pixels that differ {off:?}");
            // Beyond 30 km, a perspective map rounds more than its comparison allows for.
            let is_judged = |index: usize| half <= 30_000.0 || !(2..5).contains(&index);
            let allowed = if half > 100_000.0 { 30 } else { 8 };
            let mut judged = off.iter().enumerate().filter(|(index, _)| is_judged(*index));
            assert!(
                judged.all(|(_, off)| *off <= allowed),
                "{half} m, turned {turned}: {off:?}"
            );
        }
    }
}
