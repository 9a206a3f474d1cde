//! Materials of `KHR_materials_pbrSpecularGlossiness`, converted to metallic-roughness.
//!
//! Source: Khronos, "KHR_materials_pbrSpecularGlossiness", the example "convert-between-workflows" that belongs to it.
//! What was changed: textures are converted texel by texel, on the grid of the larger one.

use glam::{Vec3, Vec4};

use super::bake::{self, are_aligned};
use crate::scene::TextureSlot;

/// Reflectance of a dielectric that looks straight at the light, as metallic-roughness has it.
const DIELECTRIC: f32 = 0.04;

/// The part of a material that its model decides.
pub(super) struct Surface {
    pub base_color: Vec4,
    pub base_color_texture: Option<TextureSlot>,
    pub metallic: f32,
    pub roughness: f32,
    pub metallic_roughness_texture: Option<TextureSlot>,
}

/// What the extension states, with its textures loaded.
pub(super) struct SpecularGlossiness {
    pub diffuse: Vec4,
    pub diffuse_texture: Option<TextureSlot>,
    pub specular: Vec3,
    pub glossiness: f32,
    pub specular_texture: Option<TextureSlot>,
}

impl SpecularGlossiness {
    /// Whether the two textures cover the surface differently. The conversion then takes the mean of the specular one.
    pub fn is_split(&self) -> bool {
        let both = self.diffuse_texture.as_ref().zip(self.specular_texture.as_ref());
        both.is_some_and(|(diffuse, specular)| !are_aligned(diffuse, specular))
    }

    /// The same surface by base colour, metalness and roughness.
    pub fn surface(mut self, name: &str) -> Surface {
        if self.is_split() {
            let mean = bake::mean(self.specular_texture.as_ref());
            self.specular *= mean.truncate();
            self.glossiness *= mean.w;
            self.specular_texture = None;
        }
        let diffuse = self.diffuse.truncate();
        // Without metal anywhere the diffuse texture is scaled by a factor alone and stays as it is.
        let is_dielectric = self.specular_texture.is_none() && brightness(self.specular) <= DIELECTRIC;
        let slots = [self.diffuse_texture.as_ref(), self.specular_texture.as_ref()];
        let grid = bake::grid(slots).filter(|_| !is_dielectric).cloned();
        let Some(grid) = grid else {
            let (base, metallic) = metallic_roughness(diffuse, self.specular);
            return Surface {
                base_color: base.extend(self.diffuse.w),
                base_color_texture: self.diffuse_texture,
                metallic,
                roughness: 1.0 - self.glossiness,
                metallic_roughness_texture: None,
            };
        };
        let specular_at = |x, y| bake::linear(bake::texel(self.specular_texture.as_ref(), &grid, x, y));
        let diffuse_at = |x, y| bake::linear(bake::texel(self.diffuse_texture.as_ref(), &grid, x, y));
        let converted = |x, y| {
            let (texel, specular) = (diffuse_at(x, y), specular_at(x, y).truncate());
            metallic_roughness(diffuse * texel.truncate(), self.specular * specular)
        };
        let base = bake::texture(&grid, format!("base colour of {name}"), |x, y| {
            bake::encoded(converted(x, y).0, self.diffuse.w * diffuse_at(x, y).w)
        });
        let surface = bake::texture(&grid, format!("metalness and roughness of {name}"), |x, y| {
            let roughness = 1.0 - self.glossiness * specular_at(x, y).w;
            [255, bake::byte(roughness), bake::byte(converted(x, y).1), 255]
        });
        Surface {
            base_color: Vec4::ONE,
            base_color_texture: Some(base),
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: Some(surface),
        }
    }
}

/// Brightness as the eye sees it.
fn brightness(color: Vec3) -> f32 {
    (color * color).dot(Vec3::new(0.299, 0.587, 0.114)).sqrt()
}

/// Base colour and metalness that reflect as the diffuse and specular colours do.
fn metallic_roughness(diffuse: Vec3, specular: Vec3) -> (Vec3, f32) {
    let below_specular = 1.0 - specular.max_element();
    let metallic = metalness(brightness(diffuse), brightness(specular), below_specular);
    let tiny = 1e-4;
    let from_diffuse = diffuse * (below_specular / (1.0 - DIELECTRIC) / (1.0 - metallic).max(tiny));
    let from_specular = (specular - DIELECTRIC * (1.0 - metallic)) / metallic.max(tiny);
    let base = from_diffuse.lerp(from_specular, metallic * metallic);
    (base.clamp(Vec3::ZERO, Vec3::ONE), metallic)
}

/// The metalness at which both models reflect as much. It solves a quadratic equation.
fn metalness(diffuse: f32, specular: f32, below_specular: f32) -> f32 {
    if specular <= DIELECTRIC {
        return 0.0;
    }
    let a = DIELECTRIC;
    let b = diffuse * below_specular / (1.0 - DIELECTRIC) + specular - 2.0 * DIELECTRIC;
    let c = DIELECTRIC - specular;
    let root = (b * b - 4.0 * a * c).max(0.0).sqrt();
    ((root - b) / (2.0 * a)).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_and_dielectrics_come_back() {
        // What metallic-roughness reflects, written as specular-glossiness.
        for (base, metallic) in [
            (Vec3::new(0.8, 0.4, 0.1), 0.0),
            (Vec3::new(1.0, 0.71, 0.29), 1.0),
            (Vec3::splat(0.5), 0.5),
            (Vec3::ZERO, 0.0),
        ] {
            let diffuse = base * (1.0 - DIELECTRIC) * (1.0 - metallic);
            let specular = Vec3::splat(DIELECTRIC).lerp(base, metallic);
            let stated = diffuse / (1.0 - specular.max_element()).max(1e-6);
            let (got, got_metallic) = metallic_roughness(stated, specular);
            assert!(
                (got_metallic - metallic).abs() < 0.01,
                "{base} {metallic}: {got_metallic}"
            );
            assert!(got.distance(base) < 0.02, "{base} {metallic}: {got}");
        }
    }
}
