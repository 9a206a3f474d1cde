//! The records of a light's pictures and slices that shaders read.
//!
//! Each struct mirrors the one of the same name in `shaders/techniques/occlusion_texture/kernel.wgsl`
//! (`tests/gpu/layout_contract.rs`).

/// One picture of the casters: the place of its slices, and its projection.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct OcclusionFace {
    /// First row of the transform from eye-relative positions to light space.
    pub row_x: [f32; 4],
    /// Second row of the transform from eye-relative positions to light space.
    pub row_y: [f32; 4],
    /// Third row of the transform from eye-relative positions to light space.
    pub row_z: [f32; 4],
    /// Projection to normalized device coordinates: scales of x and y, then offsets of x and y.
    pub projection: [f32; 4],
    /// Divisor of the projection at depth z is `x z + y`. z: depth at which the first slice begins, metres; w: thickness of
    /// an imaginary slice behind the last, metres.
    pub depth: [f32; 4],
    /// Depth at which each slice ends, metres; slices that do not exist end where the last one does.
    pub bottoms: [[f32; 4]; 4],
}

/// All pictures of one light.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[cfg_attr(feature = "render", derive(bytemuck::Pod, bytemuck::Zeroable))]
pub struct OcclusionLight {
    /// The faces. A light with one face leaves the rest unused.
    pub faces: [OcclusionFace; 6],
    /// Half of the kernel's sides on the light, x and y, metres; for a directional light tangents. z: 1 for a light at a
    /// position, 0 for a directional one; w: 1 for a sphere, which looks the same from everywhere.
    pub kernel: [f32; 4],
    /// The light as a homogeneous point: its position relative to the eye, or the direction towards it.
    pub point_relative: [f32; 4],
    /// Half of the first side as a vector, world axes; w: radius of a sphere, or the sine of half the angle of a directional
    /// light.
    pub half_right: [f32; 4],
    /// Half of the second side as a vector, world axes; w unused.
    pub half_up: [f32; 4],
    /// Nearest and farthest depth that the light reaches, texels along a side of a picture, and the number of levels of
    /// N-buffers that are built.
    pub limits: [f32; 4],
}
