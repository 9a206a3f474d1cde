//! Shadow maps in orthographic views.

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use glam::Vec3;

use super::scenes::{ground, light, rays};
use crate::harness::maps::judge_map;
use crate::harness::support::stage::Stage;
use crate::harness::{judge, strict_context};

/// Share of wrong pixels further than a texel from an edge.
const ALLOWED: f64 = 0.001;

/// Places of the light: high, and low with long shadows.
const FROM: [Vec3; 2] = [Vec3::new(0.6, 4.5, 0.8), Vec3::new(2.2, 1.7, 1.3)];

/// A cube map, a map of a spot and cascades.
const MAPS: [(&str, LightKind, f32); 3] = [
    ("cube", LightKind::Point, 20.0),
    (
        "spot",
        LightKind::Spot {
            inner_angle: 0.5,
            outer_angle: 0.8,
        },
        20.0,
    ),
    ("cascades", LightKind::Directional, f32::INFINITY),
];

fn scene(context: &RenderContext) -> (Stage, RayScene) {
    let mut stage = ground(context, 3.6, -2.0, 30.0);
    let scene = rays(&mut stage);
    (stage, scene)
}

/// The visibility of a light with a map, whose frame ran last.
fn draw(stage: &mut Stage, kind: LightKind, range: f32, from: Vec3) -> Vec<f32> {
    match kind {
        LightKind::Point => light(stage, kind, from, range, OmniMap::default()),
        _ => light(stage, kind, from, range, ShadowMap::default()),
    }
    stage.render().expect("the frame renders").visibility.remove(0)
}

#[test]
fn maps_differ_from_the_ray_caster_by_texels() {
    let context = strict_context();
    let (mut stage, scene) = scene(&context);
    for ((name, kind, range), from) in MAPS.into_iter().flat_map(|map| FROM.map(|from| (map, from))) {
        let visibility = draw(&mut stage, kind, range, from);
        let by_texel = judge_map(&stage, &scene, 0, &visibility);
        let hard = judge(&stage, &scene, 0, &visibility);
        let dark = visibility.iter().filter(|v| **v < 0.5).count();
        println!("{name} at {from}: {by_texel:?}; off the edges {hard:?}; {dark} dark");
        assert!(by_texel.share() < ALLOWED, "{name}: {by_texel:?}");
        assert!(dark > 150, "{name}: {dark}");
    }
}

/// Shadows of a light 20 cm beside, none at all, and those of the same view in perspective: each is told.
#[test]
fn wrong_pictures_are_told() {
    let context = strict_context();
    let (mut stage, scene) = scene(&context);
    for (name, kind, range) in MAPS {
        let moved = draw(&mut stage, kind, range, FROM[1] + Vec3::X * 0.2);
        let orthographic = *stage.world.get::<Camera>(stage.camera).expect("a camera");
        // As high where the camera looks.
        let perspective = Camera {
            orthographic: None,
            vertical_fov: 0.6,
            near: 0.1,
            ..orthographic
        };
        stage.world.entity_mut(stage.camera).insert(perspective);
        let perspective = draw(&mut stage, kind, range, FROM[1]);
        stage.world.entity_mut(stage.camera).insert(orthographic);
        let right = draw(&mut stage, kind, range, FROM[1]);
        let lit = vec![1.0; right.len()];
        for (what, wrong) in [("moved", moved), ("perspective", perspective), ("lit", lit)] {
            let error = judge_map(&stage, &scene, 0, &wrong);
            println!("{name}, {what}: {error:?}");
            assert!(error.share() > 3.0 * ALLOWED, "{name}, {what}: {error:?}");
        }
        assert!(judge_map(&stage, &scene, 0, &right).share() < ALLOWED);
    }
}
