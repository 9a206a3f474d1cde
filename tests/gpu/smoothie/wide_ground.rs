//! A ground that ends beyond the horizon looks like one that ends at the edge of the picture.

use antumbra::prelude::*;
use antumbra::techniques::SmoothieWidth;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{SPOT, empty, rendered, smoothie, spawn};
use crate::harness::strict_context;

/// Visibility under a lamp without a range, 4 m over a ground of some half side.
fn picture(kind: LightKind, half: f32) -> Vec<f32> {
    let view = Transform::from_xyz(-2.2, 2.6, 2.2).looking_at(Vec3::new(0.0, 0.2, 0.0), Vec3::Y);
    let mut stage = empty(&strict_context(), view);
    spawn(&mut stage, MeshData::plane(half), Transform::IDENTITY);
    let block = Transform::from_xyz(0.3, 1.3, 0.0);
    spawn(&mut stage, MeshData::cuboid(Vec3::new(0.4, 0.5, 0.4)), block);
    let lamp = Light {
        kind,
        ..Light::point(Vec3::ONE, 60.0, f32::INFINITY)
    };
    let place = Transform::from_xyz(1.0, 4.0, 1.5).looking_at(Vec3::ZERO, Vec3::Y);
    stage.spawn_light(lamp, place, Some(smoothie(SmoothieWidth::Light)));
    rendered(&mut stage)
}

#[test]
fn smoothies_do_not_depend_on_how_far_the_ground_reaches() {
    for kind in [SPOT, LightKind::Point] {
        let near = picture(kind, 30.0);
        let soft = near.iter().filter(|value| (0.1..0.9).contains(*value)).count();
        let dark = near.iter().filter(|value| **value < 0.1).count();
        assert!(soft > 20 && dark > 60, "{kind:?}: {soft} soft, {dark} dark");
        for half in [10_000.0, 100_000.0, 300_000.0] {
            let far = picture(kind, half);
            let pairs = near.iter().zip(&far);
            let off = pairs.filter(|(a, b)| (*a - *b).abs() > 0.1).count();
            println!("{kind:?}, {half} m: {off} of {} pixels differ", near.len());
            // What is seen beyond the smaller ground is a row or two at the horizon.
            assert!(off <= 4, "{kind:?}, {half} m: {off} pixels differ");
        }
    }
}
