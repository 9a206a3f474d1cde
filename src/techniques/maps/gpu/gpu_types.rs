//! `#[repr(C)]` mirrors of WGSL structs; `tests/gpu/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Mirror of `MapFace` in `shaders/common/map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MapFace {
    /// First row of the map from eye-relative positions to the face's space.
    pub row_x: [f32; 4],
    /// Second row of the map from eye-relative positions to the face's space.
    pub row_y: [f32; 4],
    /// Third row of the map from eye-relative positions to the face's space.
    pub row_z: [f32; 4],
    /// Projection of a perspective face: half side at distance 1, near plane, size of a texel at distance 1,
    /// unused. For a parallel face: half side, length, size of a texel, unused.
    pub projection: [f32; 4],
    /// Columns of the map from eye-relative positions to the clip space of a face with a matrix; 0 for other
    /// faces.
    pub clip_from_relative: [[f32; 4]; 4],
    /// Columns of the inverse of `clip_from_relative`. The third is the light, as a homogeneous point.
    pub relative_from_clip: [[f32; 4]; 4],
}

/// Mirror of `MapLight` in `shaders/common/map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MapLight {
    /// The faces of the map. A map with fewer faces leaves the rest unused.
    pub faces: [MapFace; 6],
    /// Texels along a side, their reciprocal, radius of the filter (at distance 1; for parallel faces in
    /// metres), number of faces.
    pub size: [f32; 4],
    /// Share of a texel along the normal, relative and absolute slack of the comparison, metres towards the
    /// light.
    pub bias: [f32; 4],
    /// Nearest and farthest depth that the light reaches, 1 / reach² (for cascades with a picture beside them
    /// [`Beside::drop`](crate::techniques::maps::request::Beside::drop)), share of a cascade that is blended into the
    /// next.
    pub limits: [f32; 4],
    /// The share of a cascade's shadow that is left at an eye-relative position `p` is `w − dot(xyz, p)`, clamped to 0..=1.
    pub ending: [f32; 4],
}

/// Mirror of `MapCaster` in `shaders/techniques/maps/map_caster.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MapCaster {
    /// Columns of the map from positions relative to `center_local` to the face's clip space, computed in f64.
    pub clip_from_centered: [[f32; 4]; 4],
    /// The point of the caster's local space from which positions are taken; w is unused.
    pub center_local: [f32; 4],
}
