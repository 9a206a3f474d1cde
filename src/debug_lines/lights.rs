//! Lines of lights: their reach, their hulls, and what they can change.

use bevy_ecs::prelude::*;
use glam::{DVec3, DVec4, Vec3};

use super::DebugLines;
use crate::geometry::Aabb;
use crate::scene::LightKind;
use crate::sets::{FrameLight, Objects, View, ViewData};

const REACH: [u8; 3] = [250, 220, 120];
const VIEW_HULL: [u8; 3] = [90, 200, 110];
const RECEIVER_HULL: [u8; 3] = [170, 170, 80];
const REGION: [u8; 3] = [250, 160, 60];

/// Length of the arrow of a directional light, and of a spot light without a range, metres.
const ARROW: f32 = 3.0;

/// Greatest slope of the sides of a cone that is drawn.
const STEEPEST: f32 = 50.0;

/// Share of the scene's size by which lines end beyond the scene.
const BEYOND: f32 = 0.1;

/// Adds the place, the extent, the range and the cone of a light.
pub fn reach(light: &FrameLight, out: &mut DebugLines) {
    let at = Vec3::from(light.world_from_light.affine().translation);
    let axes = light.shining.axes.map(|axis| axis.as_vec3());
    let [x, y, along] = axes;
    let range = light.shining.range;
    match light.light.kind {
        LightKind::Point | LightKind::Sphere { .. } if range.is_finite() => {
            out.sphere(REACH, at, range, axes);
        }
        LightKind::Spot { outer_angle, .. } => {
            let depth = if range.is_finite() {
                range * outer_angle.cos()
            } else {
                ARROW
            };
            let radius = depth * outer_angle.tan().clamp(0.0, STEEPEST);
            let end = at + along * depth;
            out.ellipse(REACH, end, [x * radius, y * radius]);
            for side in [x, -x, y, -y] {
                out.line(REACH, at, end + side * radius);
            }
        }
        LightKind::Directional => {
            let end = at + along * ARROW;
            out.line(REACH, at, end);
            for side in [x, -x, y, -y] {
                out.line(REACH, end, end + (side * 0.5 - along) * (0.1 * ARROW));
            }
        }
        _ => {}
    }
    let emitter = &light.shining.emitter;
    if emitter.radius > 0.0 && emitter.point.w != 0.0 {
        out.sphere(REACH, at, emitter.radius as f32, axes);
    }
    let [x, y] = emitter.half_sides.map(|side| side.as_vec3());
    if x != Vec3::ZERO || y != Vec3::ZERO {
        out.polygon(REACH, &[x + y, y - x, -x - y, x - y].map(|corner| at + corner));
        out.line(REACH, at, at + along * x.length().max(y.length()));
    }
}

/// Adds the hulls of a light, within the scene and the light.
pub fn hulls(world: &World, light: &FrameLight, out: &mut DebugLines) {
    let within = scene_box(world, light);
    out.convex(VIEW_HULL, &light.hulls.view.planes.planes, &within);
    out.convex(RECEIVER_HULL, &light.hulls.receivers.planes.planes, &within);
}

/// Adds the scissor of a light between its depth bounds. A depth without end is cut behind the scene.
pub fn region(world: &World, light: &FrameLight, out: &mut DebugLines) {
    let view = world.get_resource::<View>().and_then(|view| view.data.as_ref());
    let (Some(view), Some(scissor), Some(bounds)) = (view, light.region.scissor, light.region.depth_bounds)
    else {
        return;
    };
    let farthest = scene_box(world, light)
        .corners()
        .into_iter()
        .map(|corner| -view.view_from_world.transform_point3(corner.as_dvec3()).z)
        .fold(f64::from(bounds.near), f64::max);
    let columns = [scissor.x, scissor.x + scissor.width].map(f64::from);
    let rows = [scissor.y, scissor.y + scissor.height].map(f64::from);
    let depths = [bounds.near, bounds.far].map(|depth| f64::from(depth).min(farthest));
    let corner = |bits: usize| {
        let [x, y, depth] = [columns[bits & 1], rows[bits >> 1 & 1], depths[bits >> 2]];
        unproject(view, [x, y], depth).as_vec3()
    };
    out.hexahedron(REGION, std::array::from_fn(corner));
}

/// Returns the point of world space at a place of the picture, pixels, and at a view depth, metres.
fn unproject(view: &ViewData, [x, y]: [f64; 2], depth: f64) -> DVec3 {
    let size = view.viewport.as_dvec2();
    let (x, y) = (2.0 * x / size.x - 1.0, 1.0 - 2.0 * y / size.y);
    let view_from_clip = view.clip_from_view.inverse();
    // Two points on the ray of the pixel, which need not leave from the eye.
    let [near, inner] = [1.0, 0.5].map(|stored| {
        let point = view_from_clip * DVec4::new(x, y, stored, 1.0);
        point.truncate() / point.w
    });
    let share = (-depth - near.z) / (inner.z - near.z);
    view.view_from_world
        .inverse()
        .transform_point3(near + (inner - near) * share)
}

/// Returns the box around all objects and the light, somewhat enlarged.
pub fn scene_box(world: &World, light: &FrameLight) -> Aabb {
    let mut all = Aabb::EMPTY;
    if let Some(objects) = world.get_resource::<Objects>() {
        for object in objects.present.ones() {
            let aabb = objects.boxes.get(object);
            if aabb.min.is_finite() && aabb.max.is_finite() {
                all = all.union(aabb);
            }
        }
    }
    if light.point_world.w != 0.0 {
        all = all.including(light.point_world.truncate().as_vec3());
    }
    if all.is_empty() {
        return all;
    }
    Aabb::around(all.center(), all.half_size() * (1.0 + BEYOND))
}
