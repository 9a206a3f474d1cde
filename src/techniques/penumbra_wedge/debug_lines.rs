//! Debug lines of penumbra wedges: their edges and the rays of their shells.

use bevy_ecs::prelude::*;
use glam::{DMat4, DVec3, Vec3};

use super::geometry::records::{CUT, SOFT, Wedge};
use super::geometry::shell::RIM;
use super::wedges::PenumbraWedges;
use crate::debug_lines::DebugLines;
use crate::debug_lines::lights::scene_box;
use crate::sets::FrameLights;
use crate::techniques::shared::shadow_lines::volume_lines;

const EDGE: [u8; 3] = [240, 240, 240];
const OUTER: [u8; 3] = [120, 170, 250];
const INNER: [u8; 3] = [250, 120, 150];

/// Adds the shells of a light's wedges: edges in white, the rays of the outer halves in blue, those of the inner halves in
/// red. A light without extent has the lines of its shadow volumes.
pub fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
    let wedges = world.resource::<PenumbraWedges>();
    let Some(of_light) = wedges.lights.iter().find(|of_light| of_light.light == light) else {
        return;
    };
    let Some(frame_light) = world.resource::<FrameLights>().lights.get(light) else {
        return;
    };
    let scene = scene_box(world, frame_light);
    let radius = f64::from(scene.half_size().length());
    let mut any = false;
    for part in &wedges.parts[of_light.parts.clone()] {
        let world_from_light = part.part.world_from_light;
        for group in &wedges.groups[part.groups.clone()] {
            let range = group.wedges();
            let records = &wedges.wedges[range.start as usize..range.end as usize];
            for wedge in records.iter().filter(|wedge| wedge.flags & SOFT != 0) {
                any = true;
                if wedge.flags & CUT != 0 {
                    cut(wedge, world_from_light, out);
                } else {
                    shell(wedge, world_from_light, radius, out);
                }
            }
        }
    }
    if !any {
        volume_lines(world, light, out);
    }
}

/// Adds the sides of a polygon that cuts the light.
fn cut(wedge: &Wedge, world_from_light: DMat4, out: &mut DebugLines) {
    let [[x, y, z, _], [a, b, c, _], ..] = wedge.rims;
    let corners = [wedge.start_light, wedge.end_light, [x, y, z], [a, b, c]];
    let corners = corners.map(|corner| {
        world_from_light
            .transform_point3(Vec3::from(corner).as_dvec3())
            .as_vec3()
    });
    for side in 0..4 {
        out.line(EDGE, corners[side], corners[(side + 1) % 4]);
    }
}

/// Adds an edge and the rays from its ends.
fn shell(wedge: &Wedge, world_from_light: DMat4, length: f64, out: &mut DebugLines) {
    let ends = [wedge.start_light, wedge.end_light].map(|end| Vec3::from(end).as_dvec3());
    let place = |point: DVec3| world_from_light.transform_point3(point).as_vec3();
    out.line(EDGE, place(ends[0]), place(ends[1]));
    for (half, color) in wedge.rims.chunks(RIM).zip([OUTER, INNER]) {
        for (index, &[x, y, z, apex]) in half.iter().enumerate() {
            let from = ends[usize::from(apex != 0.0)];
            let along = DVec3::new(f64::from(x), f64::from(y), f64::from(z)).normalize_or_zero();
            // Both halves begin and end with the same rays, and rays of a rim may coincide.
            if along != DVec3::ZERO && (index == 0 || half[index - 1] != half[index]) {
                out.line(color, place(from), place(from + along * length));
            }
        }
    }
}
