//! `#[repr(C)]` mirrors of WGSL structs; `tests/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Mirror of `MapFace` in `shaders/common/map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MapFace {
    /// Rows of face from eye-relative.
    pub row_x: [f32; 4],
    /// Second row.
    pub row_y: [f32; 4],
    /// Third row.
    pub row_z: [f32; 4],
    /// Half side at distance 1, near plane, texel at distance 1, unused; parallel: half side, length, texel, unused.
    pub projection: [f32; 4],
}

/// Mirror of `MapLight` in `shaders/common/map.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MapLight {
    /// Faces.
    pub faces: [MapFace; 6],
    /// Texels along a side and their reciprocal, radius of the filter (at distance 1; parallel: metres), unused.
    pub size: [f32; 4],
    /// Share of a texel along the normal, relative and absolute slack, metres towards the light.
    pub bias: [f32; 4],
    /// Nearest and farthest depth that the light reaches, 1 / reach², share of a cascade that passes into the next.
    pub limits: [f32; 4],
}

/// Mirror of `MapCaster` in `shaders/techniques/maps/caster.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct MapCaster {
    /// Columns; computed in f64.
    pub clip_from_local: [[f32; 4]; 4],
}
