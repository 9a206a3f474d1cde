//! Metallic-roughness materials and their textures, on the CPU.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{Affine2, Vec3, Vec4};
use smallvec::SmallVec;

use super::MeshData;
use super::churn::count_churn;

/// A surface in the metallic-roughness model of glTF 2.0.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// For messages.
    pub name: String,
    /// Linear RGBA, each 0..=1.
    pub base_color: Vec4,
    /// Multiplies `base_color`; sRGB colour, linear alpha.
    pub base_color_texture: Option<TextureSlot>,
    /// 0..=1.
    pub metallic: f32,
    /// Perceptual roughness, 0..=1.
    pub roughness: f32,
    /// Green multiplies `roughness`, blue multiplies `metallic`.
    pub metallic_roughness_texture: Option<TextureSlot>,
    /// Tangent-space normals.
    pub normal_texture: Option<TextureSlot>,
    /// Scales the X and Y of the normal texture.
    pub normal_scale: f32,
    /// Red is the share of ambient light that arrives.
    pub occlusion_texture: Option<TextureSlot>,
    /// 0 ignores the occlusion texture, 1 applies it fully.
    pub occlusion_strength: f32,
    /// Linear RGB, ≥ 0.
    pub emissive: Vec3,
    /// Multiplies `emissive`; sRGB.
    pub emissive_texture: Option<TextureSlot>,
    /// What alpha means.
    pub alpha_mode: AlphaMode,
    /// Drawn from both sides.
    pub double_sided: bool,
    /// Shows the base colour and takes no light.
    pub unlit: bool,
}

impl Default for Material {
    fn default() -> Self {
        Self {
            name: String::new(),
            base_color: Vec4::ONE,
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: Vec3::ZERO,
            emissive_texture: None,
            alpha_mode: AlphaMode::Opaque,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// A rough dielectric of one colour.
    pub fn matte(color: Vec3) -> Self {
        Self {
            base_color: color.extend(1.0),
            metallic: 0.0,
            roughness: 0.9,
            ..Self::default()
        }
    }
}

/// What a material's alpha means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Nothing; the surface is opaque.
    #[default]
    Opaque,
    /// The surface is absent where alpha is below the cutoff. It still blocks light whole in shadow volumes.
    Mask(f32),
    /// The surface is blended over what lies behind, after the lights, without receiving shadows.
    Blend,
}

/// A texture and how a material looks it up.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSlot {
    /// The image and its sampler.
    pub texture: Arc<Texture>,
    /// 0 or 1: which texture coordinates.
    pub uv_set: u32,
    /// Applied to the coordinates first (`KHR_texture_transform`).
    pub uv_transform: Affine2,
}

/// An image of 8-bit RGBA and how it is sampled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// For messages.
    pub name: String,
    /// Texels; > 0.
    pub width: u32,
    /// Texels; > 0.
    pub height: u32,
    /// `width · height · 4` bytes, rows from the top.
    pub rgba8: Vec<u8>,
    /// Wrapping along u and v.
    pub wrap: [TextureWrap; 2],
    /// Linear magnification; nearest if not.
    pub linear_magnify: bool,
    /// Linear minification and mipmapping; nearest if not.
    pub linear_minify: bool,
}

/// What lies beyond a texture's border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TextureWrap {
    /// It repeats.
    #[default]
    Repeat,
    /// It repeats mirrored.
    Mirror,
    /// Its border goes on.
    Clamp,
}

/// The materials of an entity, one for each of the mesh's submeshes.
#[derive(Component, Clone, Debug)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct SceneMaterials(pub SmallVec<[Arc<Material>; 1]>);

impl SceneMaterials {
    /// Whether every triangle of the mesh is drawn with them, and opaque.
    pub fn are_opaque(&self, mesh: &MeshData) -> bool {
        let drawn: usize = mesh
            .submeshes
            .iter()
            .map(|part| mesh.submesh_range(part).len())
            .sum();
        drawn >= mesh.indices.len()
            && self.0.get(..mesh.submeshes.len()).is_some_and(|used| {
                used.iter()
                    .all(|material| material.alpha_mode == AlphaMode::Opaque)
            })
    }
}
