//! `#[repr(C)]` mirrors of WGSL structs; `tests/gpu/layout_contract.rs` compares names, offsets and sizes.

use bytemuck::{Pod, Zeroable};

/// Mirror of `View` in `shaders/common/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct View {
    /// Linear RGB radiance of ambient light; w unused.
    pub ambient: [f32; 4],
    /// Columns of the map from a pixel's NDC position and depth to an eye-relative position, which must be
    /// divided by w. It is computed in f64.
    pub relative_from_ndc: [[f32; 4]; 4],
    /// Width and height of the picture in pixels, and their reciprocals.
    pub size: [f32; 4],
    /// Upper left corner of the picture in its targets, pixels; zw unused.
    pub origin: [f32; 4],
    /// Place of the eye. With w = 1 the eye is at the origin. With w = 0, xyz is the unit direction towards
    /// the viewer of an orthographic view.
    pub eye: [f32; 4],
}

/// Mirror of `Object` in `shaders/common/view.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Object {
    /// Columns of the map from local space to clip space, computed in f64.
    pub clip_from_local: [[f32; 4]; 4],
    /// First row of the affine map from local space to world axes with the origin at the eye.
    pub relative_from_local_x: [f32; 4],
    /// Second row of the affine map from local space to world axes with the origin at the eye.
    pub relative_from_local_y: [f32; 4],
    /// Third row of the affine map from local space to world axes with the origin at the eye.
    pub relative_from_local_z: [f32; 4],
    /// x: sign of the determinant of the object's transform; yzw: weights of ambient, diffuse and specular light.
    pub handedness: [f32; 4],
}

/// Mirror of `HostDepth` in `shaders/passes/host_depth.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct HostDepth {
    /// Numerator of our depth, to be dotted with (NDC x, NDC y, the host's depth, 1). Our depth is
    /// `numerator` over `denominator`.
    pub numerator: [f32; 4],
    /// Denominator of our depth, to be dotted with (NDC x, NDC y, the host's depth, 1). Our depth is
    /// `numerator` over `denominator`.
    pub denominator: [f32; 4],
    /// Largest difference between two depths of one surface, as factors of 1, of our depth and of its square;
    /// w unused.
    pub rounding: [f32; 4],
}

/// Mirror of `Light` in `shaders/common/light.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Light {
    /// Place of the light. With w = 1, xyz is the position relative to the eye. With w = 0, xyz is the unit
    /// direction towards the light.
    pub point_relative: [f32; 4],
    /// Linear RGB times intensity; w: 1 / range², 0 without a range.
    pub emission: [f32; 4],
    /// Unit direction in which the light shines; w: 1 if the emission falls with the cosine, else 0.
    pub axis: [f32; 4],
    /// Scale and offset of a spot's falloff; zw unused.
    pub cone: [f32; 4],
    /// Vector along a rectangle's width with half its length; w: radius of a sphere.
    pub half_right: [f32; 4],
    /// Vector along a rectangle's height with half its length; w: 1 for rectangles and spheres that have an
    /// extent, else 0.
    pub half_up: [f32; 4],
    /// Weights of ambient, diffuse and specular light; w: darkness of shadows.
    pub weights: [f32; 4],
    /// Linear RGB times intensity, in shadows; w unused.
    pub shadow_emission: [f32; 4],
    /// Shape and distances of the light.
    pub shape: LightShape,
}

/// Mirror of `LightShape` in `shaders/common/light_shape.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightShape {
    /// First row of the affine map from eye-relative positions to light space.
    pub light_from_relative_x: [f32; 4],
    /// Second row of the affine map from eye-relative positions to light space.
    pub light_from_relative_y: [f32; 4],
    /// Third row of the affine map from eye-relative positions to light space: the depth in front of the light.
    pub light_from_relative_z: [f32; 4],
    /// Semi-axes of the superellipse: of the region of full intensity in xy, of the whole region in zw.
    pub semi_axes: [f32; 4],
    /// Depth at which the light begins to fade in, inverse length of that edge, depth at which it begins to fade
    /// out, inverse length of that edge.
    pub distance: [f32; 4],
    /// Exponent of the superellipse; its inverse; 1 if the light has barn doors, else 0; 1 if the region of full
    /// intensity has an area, else 0.
    pub form: [f32; 4],
}

/// Mirror of `LightModel` in `shaders/passes/light_model.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightModel {
    /// Shape and distances of the light.
    pub shape: LightShape,
    /// From a place in the shape, in units of its outer semi-axes, to texture coordinates of the barn map: factor and
    /// offset; from texels to places: factor; w unused. All 0 without a map.
    pub barn_map: [f32; 4],
}

/// Mirror of `LightTexture` in `shaders/common/light_texture.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct LightTexture {
    /// First row of the affine map from eye-relative positions to light space: to the right, seen from the light.
    pub light_from_relative_x: [f32; 4],
    /// Second row of the affine map from eye-relative positions to light space: upwards.
    pub light_from_relative_y: [f32; 4],
    /// Third row of the affine map from eye-relative positions to light space: the depth before the light.
    pub light_from_relative_z: [f32; 4],
    /// Columns of the linear map from coordinates on the surface of the cookie's picture to texture coordinates.
    pub uv_matrix: [f32; 4],
    /// Texture coordinates of the surface's origin.
    pub uv_origin: [f32; 2],
    /// Density of the cookie, 0 to 1.
    pub density: f32,
    /// Unused padding.
    pub unused: f32,
    /// Direction in light space that a cube's picture shows to the right; w unused.
    pub light_from_cube_x: [f32; 4],
    /// Direction in light space that a cube's picture shows above; w unused.
    pub light_from_cube_y: [f32; 4],
    /// Direction in light space that a cube's picture shows ahead; w unused.
    pub light_from_cube_z: [f32; 4],
    /// Direction of the profile's polar angle 0, in light space; w: first polar angle, radians.
    pub profile_axes_pole: [f32; 4],
    /// Direction of the profile's azimuth 0, in light space; w: first azimuth, radians.
    pub profile_axes_zero: [f32; 4],
    /// Direction of the profile's azimuth of 90 degrees, in light space; w unused.
    pub profile_axes_quarter: [f32; 4],
    /// Steps of the profile's table in a radian: of the polar angle, of the azimuth.
    pub profile_steps: [f32; 2],
    /// Last index of the profile's table: of polar angles, of azimuths.
    pub profile_last: [f32; 2],
}

/// Mirror of `Slot` in `shaders/common/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Slot {
    /// Columns of the 2×2 part of the transform of texture coordinates.
    pub uv_matrix: [f32; 4],
    /// Translation of texture coordinates.
    pub uv_offset: [f32; 2],
    /// Set of texture coordinates, 0 or 1.
    pub uv_set: u32,
    /// 1 if the material has the texture, 0 if the texture is a placeholder.
    pub present: u32,
}

/// Mirror of `Material` in `shaders/common/surface.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct Material {
    /// Base colour, linear RGBA.
    pub base_color: [f32; 4],
    /// Emitted radiance, linear RGB.
    pub emissive: [f32; 3],
    /// Alpha below which an alpha-masked surface has holes; 0 for other surfaces.
    pub alpha_cutoff: f32,
    /// Share of metal, 0 to 1.
    pub metallic: f32,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f32,
    /// Scale of the normal texture's X and Y.
    pub normal_scale: f32,
    /// Strength of the occlusion texture, 0 to 1.
    pub occlusion_strength: f32,
    /// 1 if the surface shows its base colour and takes no light, else 0.
    pub unlit: u32,
    /// 1 if alpha is ignored, else 0.
    pub opaque: u32,
    /// Share of a clearcoat above the surface, 0 to 1.
    pub clearcoat: f32,
    /// Perceptual roughness of the clearcoat, 0 to 1.
    pub clearcoat_roughness: f32,
    /// The base colour texture.
    pub base_color_slot: Slot,
    /// The metallic-roughness texture.
    pub metallic_roughness_slot: Slot,
    /// The normal texture.
    pub normal_slot: Slot,
    /// The occlusion texture.
    pub occlusion_slot: Slot,
    /// The emissive texture.
    pub emissive_slot: Slot,
    /// The texture of the clearcoat's share.
    pub clearcoat_slot: Slot,
    /// The texture of the clearcoat's roughness.
    pub clearcoat_roughness_slot: Slot,
}

/// The attributes of a vertex beside its position. They are the vertex buffer 1 of drawn surfaces.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub struct SurfaceVertex {
    /// Unit normal, in local space.
    pub normal: [f32; 3],
    /// Unit tangent, in local space; w: sign of the bitangent, 0 without a tangent.
    pub tangent: [f32; 4],
    /// Texture coordinates: set 0 in xy, set 1 in zw.
    pub uv: [f32; 4],
    /// Vertex colour, linear RGBA.
    pub color: [f32; 4],
}
