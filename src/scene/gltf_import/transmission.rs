//! Materials of `KHR_materials_transmission`, with `KHR_materials_ior` and `KHR_materials_volume`: surfaces that are seen
//! through, without refraction.
//!
//! Such a surface becomes a blended one. Its alpha is the share of light that does not pass, which is what it reflects
//! by its index of refraction, what its base colour and its volume absorb, and what is not transmitted at all. Behind it
//! nothing is bent, blurred or tinted. It casts shadows as every blended surface does.

use glam::Vec3;

use super::bake;
use super::vertex_alpha::VertexAlpha;
use crate::scene::{AlphaMode, Material, TextureSlot};

/// What the extensions state, with the texture loaded.
pub(super) struct Transmission {
    /// Share of the light that enters and passes, 0..=1.
    pub factor: f32,
    /// Texture whose red channel multiplies `factor`.
    pub texture: Option<TextureSlot>,
    /// Index of refraction, at least 1; 0 stands for a perfect mirror.
    pub ior: f32,
    /// Share of each colour that passes the volume behind the surface.
    pub passing: Vec3,
}

/// The share of each colour that passes a volume of this thickness. Distances are metres.
///
/// Source: Beer's law, as in glTF extension `KHR_materials_volume`.
pub(super) fn passing(thickness: f32, distance: f32, color: Vec3) -> Vec3 {
    if thickness > 0.0 && distance > 0.0 && distance.is_finite() && thickness.is_finite() {
        color
            .clamp(Vec3::splat(1e-6), Vec3::ONE)
            .powf(thickness / distance)
    } else {
        Vec3::ONE
    }
}

impl Transmission {
    /// Whether the texture covers the surface in another way than that of the base colour. Its mean is used then.
    pub fn is_split(&self, material: &Material) -> bool {
        let both = self.texture.as_ref().zip(material.base_color_texture.as_ref());
        both.is_some_and(|(own, base)| !bake::are_aligned(own, base))
    }

    /// Makes a material one that is seen through. Returns what the alpha of vertex colours means under it.
    pub fn apply(mut self, material: &mut Material) -> VertexAlpha {
        if self.is_split(material) {
            let reds = self.texture.as_ref().map_or(&[][..], |slot| &slot.texture.rgba8);
            let texels = reds.as_chunks::<4>().0;
            let sum: f64 = texels.iter().map(|texel| f64::from(texel[0]) / 255.0).sum();
            self.factor *= (sum / texels.len().max(1) as f64) as f32;
            self.texture = None;
        }
        self.factor *= 1.0 - material.metallic; // metals let nothing pass
        let factor = material.base_color;
        let mode = material.alpha_mode;
        let coverage = move |alpha: f32| match mode {
            AlphaMode::Opaque => 1.0,
            AlphaMode::Mask(cutoff) => f32::from(alpha >= cutoff),
            AlphaMode::Blend => alpha,
        };
        let vertex_alpha = match mode {
            AlphaMode::Opaque => VertexAlpha::Ignored,
            AlphaMode::Blend => VertexAlpha::Multiplies,
            AlphaMode::Mask(_) if material.base_color_texture.is_some() => VertexAlpha::CutWithTexture,
            AlphaMode::Mask(cutoff) => VertexAlpha::Cut {
                base: factor.w,
                cutoff,
            },
        };
        material.alpha_mode = AlphaMode::Blend;
        let slots = [material.base_color_texture.as_ref(), self.texture.as_ref()];
        let Some(grid) = bake::grid(slots).cloned() else {
            material.base_color.w = coverage(factor.w) * self.opacity(1.0, factor.truncate());
            return vertex_alpha;
        };
        let base = material.base_color_texture.take();
        let baked = bake::texture(&grid, format!("base colour of {}", material.name), |x, y| {
            let texel = bake::texel(base.as_ref(), &grid, x, y);
            let color = bake::linear(texel) * factor;
            let share = f32::from(bake::texel(self.texture.as_ref(), &grid, x, y)[0]) / 255.0;
            let alpha = coverage(color.w) * self.opacity(share, color.truncate());
            [texel[0], texel[1], texel[2], bake::byte(alpha)]
        });
        material.base_color_texture = Some(baked);
        material.base_color.w = 1.0;
        vertex_alpha
    }

    /// The share of light that does not pass, where `share` of the factor is transmitted through this colour.
    fn opacity(&self, share: f32, color: Vec3) -> f32 {
        let through = (color * self.passing).element_sum() / 3.0;
        (1.0 - self.factor * share * (1.0 - self.reflectance()) * through).clamp(0.0, 1.0)
    }

    /// Share of the light that is reflected, seen straight. Source: Fresnel's equations at normal incidence.
    fn reflectance(&self) -> f32 {
        if self.ior == 0.0 {
            return 1.0;
        }
        let ior = self.ior.max(1.0);
        ((ior - 1.0) / (ior + 1.0)).powi(2)
    }
}
