//! Debug lines of shadow volumes.

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::debug_lines::lights::scene_box;
use crate::debug_lines::{DebugLines, objects::for_each_edge};
use crate::sets::{FrameLight, FrameLights};

const VOLUME: [u8; 3] = [200, 110, 250];

/// Adds the sides of the shadow volumes of a light of [`FrameLights`]: its silhouette edges, and the same edges where they
/// leave the scene or the light's range.
pub fn volume_lines(world: &World, light: usize, out: &mut DebugLines) {
    let Some(light) = world.resource::<FrameLights>().lights.get(light) else {
        return;
    };
    let ray = shadow_ray(world, light);
    for_each_edge(world, light, |[a, b]| {
        let [far_a, far_b] = [a, b].map(&ray);
        for [from, to] in [[a, b], [a, far_a], [b, far_b], [far_a, far_b]] {
            out.line(VOLUME, from, to);
        }
    });
}

/// Returns a function that moves a point of world space away from the light, as far as shadows are drawn.
pub fn shadow_ray(world: &World, light: &FrameLight) -> impl Fn(Vec3) -> Vec3 + use<> {
    let scene = scene_box(world, light);
    let (center, radius) = (scene.center(), scene.half_size().length());
    let place = light.point_world.truncate().as_vec3();
    let is_directional = light.point_world.w == 0.0;
    let range = light.light.range;
    move |from: Vec3| {
        if is_directional {
            // The plane behind the scene.
            let depth = (radius + place.dot(from - center)).max(0.0);
            return from - place * depth;
        }
        let length = (center.distance(place) + radius).min(range);
        let away = (from - place).normalize_or_zero();
        place + away * length.max(from.distance(place))
    }
}
