//! Lamps close to a floor, a ceiling or a wall of a room light what they see of it.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::techniques::Settings;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::support::stage::Stage;
use crate::harness::{strict_context, truth};

const SIZE: UVec2 = UVec2::new(96, 54);

/// A room of 6 m with a crate and a post.
fn room() -> Stage {
    let camera = Camera {
        vertical_fov: 70_f32.to_radians(),
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(2.2, 1.8, 2.6).looking_at(Vec3::new(-0.6, 0.6, -0.4), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    for (at, half) in [
        ([0.0, 1.25, 0.0], [3.0, 1.25, 3.0]),
        ([-0.6, 0.4, 0.2], [0.4, 0.4, 0.4]),
        ([0.8, 0.5, 0.3], [0.1, 0.5, 0.1]),
    ] {
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::cuboid(half.into()))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at.into()),
        ));
    }
    stage
}

/// Pixels that differ from the truth by more than a half, for each technique.
fn wrong(at: Vec3, maps: &[Settings]) -> Vec<usize> {
    let mut stage = room();
    for map in maps {
        let light = Light::point(Vec3::ONE, 20.0, 60.0);
        stage.spawn_shadowed(light, Transform::from_translation(at), Some(map));
    }
    let rendered = stage.render().expect("the frame renders");
    let rays = RayScene::from_world(&mut stage.world);
    let truth = truth(&stage, &rays, 0);
    let count = |got: &Vec<f32>| {
        let pairs = truth.values().iter().zip(got);
        pairs.filter(|(truth, got)| (*truth - *got).abs() > 0.5).count()
    };
    rendered.visibility.iter().map(count).collect()
}

#[test]
fn lamps_close_to_a_surface_light_the_room() {
    let maps = [
        Settings::of(OmniMap::default()),
        Settings::of(PerspectiveMap::default()),
        Settings::of(Smoothie::default()),
    ];
    let mut bad = Vec::new();
    for at in [
        Vec3::new(0.3, 0.1, 0.2),
        Vec3::new(0.3, 0.01, 0.2),
        Vec3::new(0.3, 0.001, 0.2),
        Vec3::new(0.3, 2.499_99, 0.2),
        Vec3::new(0.3, 2.500_001, 0.2),
        Vec3::new(0.3, 2.49, 0.2),
        Vec3::new(-2.99, 1.0, 0.3),
    ] {
        let wrong = wrong(at, &maps);
        println!(
            "{at}: omni, perspective, smoothie {wrong:?} of {}",
            SIZE.x * SIZE.y
        );
        // Edges are wrong by up to a texel, and a lamp that touches a wall sees it in a texel or two.
        if wrong[1] > wrong[0] + 20 || wrong[2] > wrong[0] + 30 {
            bad.push(format!("{at}: {wrong:?}"));
        }
    }
    assert!(bad.is_empty(), "{}", bad.join("\n"));
}
