//! Walks through scenes: places where a person can stand, in an order in which each is visible from the one before.

use antumbra::geometry::Aabb;
use antumbra::reference::{Ray, RayScene};
use bevy_transform::prelude::Transform;
use glam::{DVec3, Vec3};

use super::spread::spread;

/// Height of the eyes above the floor, metres.
pub const EYE_HEIGHT: f64 = 1.6;

/// Returns at most `count` eye positions, each `height` above a floor on which a person can stand, in a fixed order.
/// A scene without floors has fewer, or none.
pub fn standing_points(scene: &RayScene, bounds: Aabb, count: usize, height: f64) -> Vec<DVec3> {
    let (min, size) = (bounds.min.as_dvec3(), 2.0 * bounds.half_size().as_dvec3());
    let hit = |origin: DVec3, direction: DVec3, reach: f64| {
        scene.closest_hit(&Ray { origin, direction }, 1e-4, reach, |_| true)
    };
    (1..40_000)
        .filter_map(|index| {
            let from = min + size * spread(index);
            let floor = hit(from, DVec3::NEG_Y, f64::INFINITY)?;
            let corners = scene.triangles()[floor.triangle as usize].corners;
            let normal = (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize_or_zero();
            let foot = from - DVec3::Y * floor.t;
            let is_free = [DVec3::Y, DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z]
                .into_iter()
                .all(|side| hit(foot + DVec3::Y * height * 0.99, side, 0.25).is_none());
            let clear = hit(foot + DVec3::Y * 1e-3, DVec3::Y, height).is_none();
            (normal.y.abs() > 0.9 && is_free && clear).then_some(foot + DVec3::Y * height)
        })
        .take(count)
        .collect()
}

/// Returns a walk of `frames` views. From each standing point, it goes to the nearest unvisited one that is visible
/// from there, or else to the nearest unvisited one. Each view looks ahead, turned aside by a little more each time.
/// In a scene with too few standing points, the walk is a circle around everything.
pub fn walk(scene: &RayScene, bounds: Aabb, frames: usize) -> Vec<Transform> {
    let mut open = standing_points(scene, bounds, frames, EYE_HEIGHT);
    if open.len() < frames {
        return circle(bounds, frames);
    }
    let mut here = open.swap_remove(0);
    let mut views = Vec::with_capacity(frames);
    while views.len() < frames {
        let rank = |there: &DVec3| {
            let way = *there - here;
            let blocked = scene.blocks_segment(here, *there, None, u32::MAX);
            (blocked, way.length_squared())
        };
        let next = (0..open.len()).min_by(|a, b| {
            let (a, b) = (rank(&open[*a]), rank(&open[*b]));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        });
        let there = next.map_or(here + DVec3::X, |next| open.swap_remove(next));
        let way = (there - here).with_y(0.0).normalize_or(DVec3::X).as_vec3();
        let aside = (views.len() as f32 * 0.7).sin() * 0.6;
        let look = glam::Quat::from_rotation_y(aside) * way - Vec3::Y * 0.05;
        views.push(Transform::from_translation(here.as_vec3()).looking_to(look, Vec3::Y));
        here = there;
    }
    views
}

fn circle(bounds: Aabb, frames: usize) -> Vec<Transform> {
    let (center, radius) = if bounds.is_empty() {
        (Vec3::ZERO, 1.0)
    } else {
        (bounds.center(), bounds.half_size().length().max(1e-3))
    };
    (0..frames)
        .map(|frame| {
            let turn = std::f32::consts::TAU * frame as f32 / frames as f32;
            let aside = Vec3::new(turn.cos(), 0.4, turn.sin()) * 1.4 * radius;
            Transform::from_translation(center + aside).looking_at(center, Vec3::Y)
        })
        .collect()
}
