//! Metallic-roughness materials and their textures, on the CPU.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{Affine2, Vec3, Vec4};
use smallvec::SmallVec;

use super::MeshData;
use super::caster::Submeshes;
use super::churn::count_churn;

/// A surface in the metallic-roughness model of glTF 2.0.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name of the material, used in messages.
    pub name: String,
    /// Base colour, linear RGBA, each component 0..=1; default white.
    pub base_color: Vec4,
    /// Texture that multiplies `base_color`; sRGB colour and linear alpha.
    pub base_color_texture: Option<TextureSlot>,
    /// Metalness: 0 is a dielectric, 1 a metal; default 1.
    pub metallic: f32,
    /// Perceptual roughness: 0 is a mirror, 1 is fully rough; default 1.
    pub roughness: f32,
    /// Texture whose green channel multiplies `roughness` and whose blue channel multiplies `metallic`.
    pub metallic_roughness_texture: Option<TextureSlot>,
    /// Texture of tangent-space normals.
    pub normal_texture: Option<TextureSlot>,
    /// Factor on X and Y of the normals in the texture. Higher values make bumps look steeper; default 1.
    pub normal_scale: f32,
    /// Texture whose red channel is the share of ambient light that arrives.
    pub occlusion_texture: Option<TextureSlot>,
    /// Strength of the occlusion texture: 0 ignores it, 1 (the default) applies it fully.
    pub occlusion_strength: f32,
    /// Emitted radiance, linear RGB, each component ≥ 0; default black.
    pub emissive: Vec3,
    /// Texture that multiplies `emissive`; sRGB.
    pub emissive_texture: Option<TextureSlot>,
    /// Share of a clear, smooth coat above the surface, as of lacquer: 0 (the default) is none, 1 a whole one. The coat
    /// reflects 4 % of the light that meets it straight on and all of it at grazing angles, and dims what is below it by
    /// as much, emission too. Its normal is that of the mesh, without [`Material::normal_texture`]. Surfaces with a coat are drawn with
    /// a pipeline of their own; the others pay nothing for it.
    pub clearcoat: f32,
    /// Texture whose red channel multiplies `clearcoat`.
    pub clearcoat_texture: Option<TextureSlot>,
    /// Perceptual roughness of the coat: 0 (the default) is a mirror, 1 is fully rough.
    pub clearcoat_roughness: f32,
    /// Texture whose green channel multiplies `clearcoat_roughness`.
    pub clearcoat_roughness_texture: Option<TextureSlot>,
    /// Meaning of the alpha channel.
    pub alpha_mode: AlphaMode,
    /// Whether the surface is drawn from both sides; default `false`.
    pub double_sided: bool,
    /// Whether the surface shows its base colour and takes no light; default `false`.
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
            clearcoat: 0.0,
            clearcoat_texture: None,
            clearcoat_roughness: 0.0,
            clearcoat_roughness_texture: None,
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

    /// Whether a clearcoat takes part in the look of the surface.
    #[cfg(feature = "render")]
    pub(crate) fn is_coated(&self) -> bool {
        self.clearcoat > 0.0 && !self.unlit
    }
}

impl AlphaMode {
    /// Whether a point of this alpha is absent.
    fn hides(self, alpha: f32) -> bool {
        match self {
            Self::Opaque => false,
            Self::Mask(cutoff) => alpha < cutoff,
            Self::Blend => alpha <= 0.0,
        }
    }
}

/// The meaning of a material's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum AlphaMode {
    /// Alpha is ignored and the surface is opaque.
    #[default]
    Opaque,
    /// The surface is absent where alpha is below the cutoff, which is the value given here. In shadow
    /// volumes it still blocks light as a whole.
    Mask(f32),
    /// The surface is blended over what lies behind it; where alpha is 0 everywhere, the submesh casts nothing. Of the blended surfaces at a pixel only the nearest
    /// receives shadows; farther ones are lit without.
    Blend,
}

/// A texture and the way in which a material samples it.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureSlot {
    /// The image and its sampler.
    pub texture: Arc<Texture>,
    /// Which set of texture coordinates is used: 0 or 1.
    pub uv_set: u32,
    /// Transform of the texture coordinates, applied before sampling (`KHR_texture_transform`).
    pub uv_transform: Affine2,
}

/// An image of 8-bit RGBA texels and its sampler settings.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Name of the texture, used in messages.
    pub name: String,
    /// Width, texels; greater than 0.
    pub width: u32,
    /// Height, texels; greater than 0.
    pub height: u32,
    /// The texels, `width · height · 4` bytes, rows from the top.
    pub rgba8: Vec<u8>,
    /// Wrapping along u and along v.
    pub wrap: [TextureWrap; 2],
    /// Whether magnification is linear; if not, it takes the nearest texel.
    pub linear_magnify: bool,
    /// Whether minification and mipmapping are linear; if not, they take the nearest texel.
    pub linear_minify: bool,
}

impl Texture {
    /// Returns the greatest alpha of its texels, 0..=1.
    ///
    /// Cost: linear in the texels up to the first that is opaque.
    pub fn greatest_alpha(&self) -> f32 {
        let mut greatest = 0;
        for &alpha in self.rgba8.iter().skip(3).step_by(4) {
            greatest = greatest.max(alpha);
            if greatest == u8::MAX {
                break;
            }
        }
        f32::from(greatest) / 255.0
    }
}

/// The parts of a mesh that nobody can see because of its materials' alpha.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Hidden {
    /// Every submesh may be seen.
    Nothing,
    /// These submeshes are hidden, and others are not.
    Submeshes(Submeshes),
    /// Every submesh is hidden.
    Everything,
}

/// How a texture continues beyond its border.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum TextureWrap {
    /// The texture repeats.
    #[default]
    Repeat,
    /// The texture repeats, mirrored every other time.
    Mirror,
    /// The texels of the border extend outward.
    Clamp,
}

/// The materials of an entity, one for each submesh of its mesh.
#[derive(Component, Clone, Debug)]
#[component(on_add = count_churn, on_remove = count_churn)]
pub struct SceneMaterials(pub SmallVec<[Arc<Material>; 1]>);

impl SceneMaterials {
    /// Whether these materials hide every triangle that they would draw of the mesh, by their alpha. `greatest_alpha` returns
    /// that of a texture. A mesh of which nothing would be drawn is not invisible: it may stand for something else.
    pub fn are_invisible(&self, mesh: &MeshData, greatest_alpha: impl FnMut(&Arc<Texture>) -> f32) -> bool {
        self.hidden(mesh, greatest_alpha) == Hidden::Everything
    }

    /// The parts of the mesh that these materials hide by their alpha. `greatest_alpha` returns that of a texture. A mesh of which
    /// nothing would be drawn is not hidden: it may stand for something else.
    pub(crate) fn hidden(
        &self,
        mesh: &MeshData,
        mut greatest_alpha: impl FnMut(&Arc<Texture>) -> f32,
    ) -> Hidden {
        let mut hidden = Submeshes::new();
        let mut drawn_count = 0;
        for ((part, material), index) in mesh.submeshes.iter().zip(&self.0).zip(0u32..) {
            if part.index_count == 0 {
                continue;
            }
            drawn_count += 1;
            if material.alpha_mode == AlphaMode::Opaque {
                continue;
            }
            let corners = &mesh.indices[mesh.submesh_range(part)];
            let alphas = corners
                .iter()
                .filter_map(|&corner| mesh.colors.get(corner as usize));
            let of_vertices = alphas.map(|color| color.w).reduce(f32::max).unwrap_or(1.0);
            let texture = material.base_color_texture.as_ref();
            let of_texture = texture.map_or(1.0, |slot| greatest_alpha(&slot.texture));
            let alpha = material.base_color.w * of_vertices * of_texture;
            if material.alpha_mode.hides(alpha) {
                hidden.push(index);
            }
        }
        match hidden.len() {
            0 => Hidden::Nothing,
            count if count == drawn_count => Hidden::Everything,
            _ => Hidden::Submeshes(hidden),
        }
    }

    /// Whether these materials draw every triangle of the mesh, all of them opaque.
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
