//! `#[repr(C)]` mirrors of WGSL structs; `tests/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Mirror of `Caster` in `shaders/techniques/stencil_volume/volume.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Caster {
    /// w = 1: a position; w = 0: xyz points towards the light.
    pub light_local: [f32; 4],
    /// Index into the objects of the frame.
    pub object: u32,
    /// Factor on the distance from the light; 0: to infinity.
    pub extrusion: f32,
    /// 4 for quads, 3 for triangles.
    pub corners_per_edge: u32,
    /// In the pool.
    pub first_edge: u32,
    /// Edges that count once; those after them count twice.
    pub single_count: u32,
    /// Unused.
    pub padding_a: u32,
    /// Unused.
    pub padding_b: u32,
    /// Unused.
    pub padding_c: u32,
}
