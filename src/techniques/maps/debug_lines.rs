//! Debug lines of maps: their faces.

use bevy_ecs::prelude::*;
use glam::DVec4;

use super::Maps;
use super::face::{FaceProjection, MapFace};
use crate::debug_lines::DebugLines;

/// Colours of faces and cascades, in turn.
const FACES: [[u8; 3]; 6] = [
    [240, 120, 120],
    [120, 220, 120],
    [120, 160, 250],
    [240, 220, 110],
    [220, 130, 240],
    [110, 220, 230],
];

/// Least homogeneous coordinate of a corner, as a share of the others, that is not at infinity.
const LEAST_W: f64 = 1e-6;

/// Adds the solids that the faces of a light's map show, as they were drawn last.
pub fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
    let Some(map) = world.resource::<Maps>().of_light(light) else {
        return;
    };
    let drawn = map.faces.iter().filter(|face| face.revision != 0);
    for (face, color) in drawn.zip(FACES.into_iter().cycle()) {
        face_lines(&face.face, map.reach, color, out);
    }
}

/// Adds the edges of the solid that a face shows. Edges to corners at infinity, and beyond, are left out.
fn face_lines(face: &MapFace, reach: f64, color: [u8; 3], out: &mut DebugLines) {
    let world_from_clip = face.clip_from_world().inverse();
    let farthest = match face.projection {
        FaceProjection::Perspective { near, .. } => near / reach,
        FaceProjection::Parallel { .. } | FaceProjection::Matrix { .. } => 0.0,
    };
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let corners: [Option<_>; 8] = std::array::from_fn(|bits| {
        let depth = if bits >> 2 == 0 { 1.0 } else { farthest };
        let corner = world_from_clip * DVec4::new(sign(bits & 1), sign(bits >> 1 & 1), depth, 1.0);
        let at_infinity = corner.w <= LEAST_W * corner.truncate().length();
        (!at_infinity).then(|| (corner.truncate() / corner.w).as_vec3())
    });
    for from in 0..8_usize {
        for axis in (0..3).filter(|axis| from >> axis & 1 == 0) {
            if let (Some(a), Some(b)) = (corners[from], corners[from | 1 << axis]) {
                out.line(color, a, b);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DVec3, Vec3};

    #[test]
    fn faces_are_boxes_and_pyramids() {
        let face = |projection| MapFace {
            origin: DVec3::new(1.0, 5.0, 0.0),
            axes: [DVec3::X, -DVec3::Z, -DVec3::Y],
            projection,
        };
        let bounds = |projection, reach| {
            let mut lines = DebugLines::default();
            face_lines(&face(projection), reach, [0; 3], &mut lines);
            assert_eq!(lines.lines().len(), 12);
            let ends = lines.lines().iter().flat_map(|line| line.ends);
            crate::geometry::Aabb::from_points(ends)
        };
        let is_near = |a: Vec3, b: [f32; 3]| assert!(a.distance(Vec3::from(b)) < 1e-3, "{a} {b:?}");
        let parallel = bounds(
            FaceProjection::Parallel {
                half: 2.0,
                length: 9.0,
            },
            1.0,
        );
        is_near(parallel.min, [-1.0, -4.0, -2.0]);
        is_near(parallel.max, [3.0, 5.0, 2.0]);
        let perspective = bounds(
            FaceProjection::Perspective {
                tangent: 0.5,
                near: 0.1,
            },
            4.0,
        );
        is_near(perspective.min, [-1.0, 1.0, -2.0]);
        is_near(perspective.max, [3.0, 4.9, 2.0]);
    }
}
