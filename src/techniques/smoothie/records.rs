//! Records that the GPU expands into smoothies. They mirror the structs of the same names in
//! `shaders/techniques/smoothie/edge.wgsl` (`tests/gpu/layout_contract.rs`).

use glam::DVec3;

use crate::techniques::maps::face::{FaceProjection, MapFace};
use crate::techniques::maps::request::Beside;

/// [`SmoothieEdge::kind`] of an edge with the sector that joins it to the next edge.
pub const SECTOR: f32 = 0.0;

/// [`SmoothieEdge::kind`] of an edge with a whole disc at its end, because more than one edge follows it.
pub const DISC: f32 = 1.0;

/// [`SmoothieEdge::kind`] of an edge that points at the light. Only the disc at its end is drawn.
pub const DISC_ALONE: f32 = 2.0;

/// Scale of reciprocals of distances from a light at a position, as a share of the distance of the near plane. Nothing is
/// nearer, so scaled reciprocals stay below the greatest half float.
pub const SCALE_OF_NEAR: f32 = 32_768.0;

/// One silhouette edge and the corner at its end. Positions have world axes and their origin at the light or, for
/// a directional light, at the origin of the map's first face.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct SmoothieEdge {
    /// Start of the edge. The caster is on the left of the edge, as seen from the light.
    pub start: [f32; 3],
    /// Width of the smoothie at the start, metres.
    pub width_start: f32,
    /// End of the edge.
    pub end: [f32; 3],
    /// Width of the smoothie at the end, metres.
    pub width_end: f32,
    /// End of the next edge of the loop.
    pub next: [f32; 3],
    /// What is drawn: [`SECTOR`], [`DISC`] or [`DISC_ALONE`].
    pub kind: f32,
}

/// One face of a map, as smoothies are drawn into it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct SmoothieFace {
    /// First row of the transform from the edges' space to the face's space.
    pub row_x: [f32; 4],
    /// Second row of the transform from the edges' space to the face's space.
    pub row_y: [f32; 4],
    /// Third row of the transform from the edges' space to the face's space.
    pub row_z: [f32; 4],
    /// Projection of a perspective face: half side at distance 1, near plane, texel at distance 1, 0. For a parallel
    /// face: half side, length, texel, 1.
    pub projection: [f32; 4],
    /// Scale of reciprocals of distances in metres ([`SCALE_OF_NEAR`]), drop of a directional light in metres, unused,
    /// unused.
    pub limits: [f32; 4],
}

impl SmoothieFace {
    /// Makes the record of a face for edges whose origin is `anchor`.
    pub fn new(face: &MapFace, anchor: DVec3, resolution: u32, beside: &Beside) -> Self {
        let [row_x, row_y, row_z] = face.rows_from_relative(anchor).map(|row| row.to_array());
        let texel = face.texel_metres(resolution) as f32;
        let projection = match face.projection {
            FaceProjection::Perspective { tangent, near } => [tangent as f32, near as f32, texel, 0.0],
            FaceProjection::Parallel { half, length } => [half as f32, length as f32, texel, 1.0],
            // No request of smoothies has such faces. Everything is clipped at the near plane.
            FaceProjection::Matrix { .. } => [1.0, f32::MAX, texel, 0.0],
        };
        Self {
            row_x,
            row_y,
            row_z,
            projection,
            limits: [projection[1] * SCALE_OF_NEAR, beside.drop, 0.0, 0.0],
        }
    }

    /// Whether the face belongs to a directional light.
    pub fn is_parallel(&self) -> bool {
        self.projection[3] == 1.0
    }
}
