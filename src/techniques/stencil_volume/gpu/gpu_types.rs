//! `#[repr(C)]` mirrors of WGSL structs; `tests/gpu/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Mirror of `Caster` in `shaders/techniques/stencil_volume/volume.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Caster {
    /// Place of the light in the caster's space. With w = 1, xyz is a position. With w = 0, xyz points
    /// towards the light.
    pub light_local: [f32; 4],
    /// Index of the caster among the objects of the frame.
    pub object: u32,
    /// Factor on the distance from the light, by which far ends are pushed away. The value 0 pushes them to
    /// infinity.
    pub extrusion: f32,
    /// Vertices of the side of one edge: 4 for a quad, 3 for a triangle.
    pub corners_per_edge: u32,
    /// Index of the first edge in the pool of silhouettes.
    pub first_edge: u32,
    /// Number of edges that count once. The edges after them count twice.
    pub single_count: u32,
    /// Unused padding.
    pub padding_a: u32,
    /// Unused padding.
    pub padding_b: u32,
    /// Unused padding.
    pub padding_c: u32,
}
