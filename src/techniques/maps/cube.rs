//! The six faces around a light.

use glam::DVec3;

use super::face::{FaceProjection, MapFace};
use crate::geometry::Cone;

/// The axis of each face, in the order of cube textures; the shader's `cube_face` returns these indices.
pub const DIRECTIONS: [DVec3; 6] = [
    DVec3::X,
    DVec3::NEG_X,
    DVec3::Y,
    DVec3::NEG_Y,
    DVec3::Z,
    DVec3::NEG_Z,
];

/// Texels that a face shows beyond a right angle on each side, so that all four texels of a tap lie in one
/// face.
pub const GUARD_TEXELS: u32 = 2;

/// Returns the faces around `origin`. Their axes are those of the world, so a light that turns keeps its map.
pub fn cube_faces(origin: DVec3, near: f64, resolution: u32) -> [MapFace; 6] {
    let guard = GUARD_TEXELS.min(resolution / 4);
    let tangent = f64::from(resolution) / f64::from(resolution - 2 * guard);
    DIRECTIONS.map(|z| {
        let x = if z.y == 0.0 { DVec3::Y.cross(z) } else { DVec3::X };
        MapFace {
            origin,
            axes: [x, z.cross(x), z],
            projection: FaceProjection::Perspective { tangent, near },
        }
    })
}

/// Which faces a cone of light shines into. Conservative.
pub fn faces_of_cone(cone: &Cone) -> [bool; 6] {
    // Half the angle between opposite corners of a face, plus what the guard adds.
    let corner = 3.0_f64.sqrt().recip().acos() + 0.05;
    let axis = cone.axis.as_dvec3();
    DIRECTIONS.map(|z| z.dot(axis).clamp(-1.0, 1.0).acos() <= f64::from(cone.half_angle) + corner)
}
