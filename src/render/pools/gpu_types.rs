//! `#[repr(C)]` mirrors of WGSL structs; `tests/gpu/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Mirror of `View` in `shaders/common/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct View {
    /// Linear RGB radiance; w unused.
    pub ambient: [f32; 4],
    /// Columns; from a pixel's NDC position and depth to eye-relative, to be divided by w. Computed in f64.
    pub relative_from_ndc: [[f32; 4]; 4],
    /// Width and height of the picture, pixels, and their reciprocals.
    pub size: [f32; 4],
    /// Upper left corner of the picture in its targets, pixels; z, w unused.
    pub origin: [f32; 4],
    /// w = 1: the eye is at the origin; w = 0: unit direction towards an orthographic view.
    pub eye: [f32; 4],
}

/// Mirror of `Object` in `shaders/common/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Object {
    /// Columns; computed in f64.
    pub clip_from_local: [[f32; 4]; 4],
    /// First row of the affine map from local to world axes with the origin at the eye.
    pub relative_from_local_x: [f32; 4],
    /// Second row.
    pub relative_from_local_y: [f32; 4],
    /// Third row.
    pub relative_from_local_z: [f32; 4],
    /// x: sign of the determinant.
    pub handedness: [f32; 4],
}

/// Mirror of `HostDepth` in `shaders/passes/host_depth.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HostDepth {
    /// Our depth is the quotient of the two, dotted with NDC, the host's depth, and 1.
    pub numerator: [f32; 4],
    /// See `numerator`.
    pub denominator: [f32; 4],
    /// What depths of one surface may differ by: factors of 1, of our depth and of its square; w unused.
    pub rounding: [f32; 4],
}

/// Mirror of `Light` in `shaders/common/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// w = 1: position relative to the eye; w = 0: unit direction towards the light.
    pub point_relative: [f32; 4],
    /// Linear RGB times intensity; w: 1 / range², 0 without one.
    pub emission: [f32; 4],
    /// Unit direction of shining; w: 1 where emission falls with the cosine.
    pub axis: [f32; 4],
    /// Scale and offset of a spot's falloff.
    pub cone: [f32; 4],
    /// Half the width of a rectangle, along it; w: radius of a sphere.
    pub half_right: [f32; 4],
    /// Half its height; w: 1 for rectangles and spheres that have an extent.
    pub half_up: [f32; 4],
}

/// Mirror of `Slot` in `shaders/common/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Slot {
    /// Columns of the 2×2 part.
    pub uv_matrix: [f32; 4],
    /// Translation.
    pub uv_offset: [f32; 2],
    /// 0 or 1.
    pub uv_set: u32,
    /// 0: the texture is a placeholder.
    pub present: u32,
}

/// Mirror of `Material` in `shaders/common/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Linear RGBA.
    pub base_color: [f32; 4],
    /// Linear RGB.
    pub emissive: [f32; 3],
    /// 0 unless alpha-masked.
    pub alpha_cutoff: f32,
    /// 0..=1.
    pub metallic: f32,
    /// Perceptual, 0..=1.
    pub roughness: f32,
    /// Scales the normal texture's X and Y.
    pub normal_scale: f32,
    /// 0..=1.
    pub occlusion_strength: f32,
    /// 1: shows the base colour and takes no light.
    pub unlit: u32,
    /// 1: alpha is ignored.
    pub opaque: u32,
    /// Unused.
    pub padding_a: u32,
    /// Unused.
    pub padding_b: u32,
    /// Base colour texture.
    pub base_color_slot: Slot,
    /// Metallic-roughness texture.
    pub metallic_roughness_slot: Slot,
    /// Normal texture.
    pub normal_slot: Slot,
    /// Occlusion texture.
    pub occlusion_slot: Slot,
    /// Emissive texture.
    pub emissive_slot: Slot,
}

/// What a vertex has beside its position; vertex buffer 1 of drawn surfaces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SurfaceVertex {
    /// Unit, local.
    pub normal: [f32; 3],
    /// Unit, local; w the bitangent's sign, 0: none.
    pub tangent: [f32; 4],
    /// Set 0 in xy, set 1 in zw.
    pub uv: [f32; 4],
    /// Linear RGBA.
    pub color: [f32; 4],
}
