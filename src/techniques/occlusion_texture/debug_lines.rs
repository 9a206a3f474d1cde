//! Debug lines of occlusion textures: their slices.

use bevy_ecs::prelude::*;
use glam::{DVec2, DVec3, Vec3};

use super::build::OcclusionTextures;
use super::face::SliceFace;
use crate::debug_lines::DebugLines;

const SLICE: [u8; 3] = [120, 200, 250];

/// Adds the planes between the slices of a light's pictures.
pub fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
    let Some(slices) = world.resource::<OcclusionTextures>().of_light(light) else {
        return;
    };
    for face in &slices.faces {
        face_lines(face, out);
    }
}

fn face_lines(face: &SliceFace, out: &mut DebugLines) {
    let slices = &face.slices;
    let depths = [slices.top]
        .into_iter()
        .chain(slices.bottoms[..slices.count].iter().copied());
    let mut before: Option<[Vec3; 4]> = None;
    for depth in depths {
        let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(x, y)| unproject(face, DVec2::new(x, y), depth).as_vec3());
        out.polygon(SLICE, &corners);
        if let Some(before) = before {
            for (from, to) in before.into_iter().zip(corners) {
                out.line(SLICE, from, to);
            }
        }
        before = Some(corners);
    }
}

/// Returns the point of world space at a place of the picture, normalized device coordinates, and at a depth, metres.
fn unproject(face: &SliceFace, place: DVec2, depth: f64) -> DVec3 {
    let divisor = face.divisor.x * depth + face.divisor.y;
    let flat = (place - face.offset) * divisor / face.scale;
    let [x, y, z] = face.axes;
    face.origin + x * flat.x + y * flat.y + z * depth
}
