//! Import of materials. Those of other models are converted to metallic-roughness.

use std::sync::Arc;

use glam::{Affine2, Mat2, Vec2, Vec3, Vec4};
use gltf::json::extensions::material::Material as Extensions;
use gltf::json::extensions::texture::TextureTransform;
use gltf::json::material::{AlphaMode as JsonAlphaMode, Material as JsonMaterial};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;
use gltf::json::{Index, Texture, Value, deserialize};

use super::accessors::Accessors;
use super::clearcoat::{self, CLEARCOAT};
use super::specular_glossiness::{SpecularGlossiness, Surface};
use super::texture::Textures;
use super::transmission::{self, Transmission};
use super::vertex_alpha::VertexAlpha;
use super::{Element, GltfError, Report, SkipKind};
use crate::scene::{AlphaMode, Material, TextureSlot};

/// All materials of the file, and what the alpha of vertex colours means under each.
pub(super) fn load(
    accessors: &Accessors<'_>,
    textures: &mut Textures<'_>,
    report: &mut Report,
) -> Result<(Vec<Arc<Material>>, Vec<VertexAlpha>), GltfError> {
    let mut materials = Vec::with_capacity(accessors.root.materials.len());
    let mut vertex_alpha = Vec::with_capacity(materials.capacity());
    for (index, material) in accessors.root.materials.iter().enumerate() {
        let mut import = Import {
            element: Element::Material(index),
            textures,
            report,
        };
        let (material, alpha) = import.material(material)?;
        materials.push(Arc::new(material));
        vertex_alpha.push(alpha);
    }
    Ok((materials, vertex_alpha))
}

struct Import<'i, 'a> {
    element: Element,
    textures: &'i mut Textures<'a>,
    report: &'i mut Report,
}

impl Import<'_, '_> {
    fn material(&mut self, json: &JsonMaterial) -> Result<(Material, VertexAlpha), GltfError> {
        let extensions = json.extensions.as_ref();
        let is_unlit = extensions.is_some_and(|extensions| extensions.unlit.is_some());
        let strength = extensions
            .and_then(|extensions| extensions.emissive_strength.as_ref())
            .map_or(1.0, |strength| strength.emissive_strength.0);
        let strength = self.number("emissive strength", strength, f32::MAX);
        let emissive = json
            .emissive_factor
            .0
            .map(|channel| self.number("emissive factor", channel, 1.0));
        let cutoff = json.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0);
        let name = json.name.clone().unwrap_or_else(|| self.element.to_string());
        let surface = match extensions.and_then(|extensions| extensions.pbr_specular_glossiness.as_ref()) {
            Some(_) => self.specular_glossiness(json, &name)?,
            None => self.metallic_roughness(json)?,
        };
        let mut material = Material {
            name,
            base_color: surface.base_color,
            base_color_texture: surface.base_color_texture,
            metallic: surface.metallic,
            roughness: surface.roughness,
            metallic_roughness_texture: surface.metallic_roughness_texture,
            normal_texture: self.slot(json.normal_texture.as_ref().map(|normal| {
                let others = normal.extensions.as_ref().map(|extensions| &extensions.others);
                (normal.index, normal.tex_coord, others.and_then(transform_of))
            }))?,
            normal_scale: json
                .normal_texture
                .as_ref()
                .map(|normal| normal.scale)
                .filter(|scale| scale.is_finite())
                .unwrap_or(1.0),
            occlusion_texture: self.slot(json.occlusion_texture.as_ref().map(|occlusion| {
                let others = occlusion.extensions.as_ref().map(|extensions| &extensions.others);
                (
                    occlusion.index,
                    occlusion.tex_coord,
                    others.and_then(transform_of),
                )
            }))?,
            occlusion_strength: json.occlusion_texture.as_ref().map_or(1.0, |occlusion| {
                self.number("occlusion strength", occlusion.strength.0, 1.0)
            }),
            // Source: KHR_materials_unlit: what is not the base colour serves readers that do not know the extension.
            emissive: if is_unlit {
                Vec3::ZERO
            } else {
                (Vec3::from(emissive) * strength).min(Vec3::MAX)
            },
            emissive_texture: self.slot(json.emissive_texture.as_ref().map(info).filter(|_| !is_unlit))?,
            alpha_mode: match json.alpha_mode {
                Checked::Valid(JsonAlphaMode::Mask) => {
                    AlphaMode::Mask(self.number("alpha cutoff", cutoff, f32::MAX))
                }
                Checked::Valid(JsonAlphaMode::Blend) => AlphaMode::Blend,
                Checked::Valid(JsonAlphaMode::Opaque) => AlphaMode::Opaque,
                Checked::Invalid => {
                    let reason = "its alphaMode is unknown, OPAQUE is used";
                    self.skip(SkipKind::MaterialValue, reason);
                    AlphaMode::Opaque
                }
            },
            double_sided: json.double_sided,
            unlit: is_unlit,
            ..Material::default()
        };
        let mut vertex_alpha = VertexAlpha::default();
        if let Some(extensions) = extensions {
            self.clearcoat(extensions, &mut material)?;
            vertex_alpha = self.transmission(extensions, &mut material)?;
        }
        Ok((material, vertex_alpha))
    }

    fn metallic_roughness(&mut self, json: &JsonMaterial) -> Result<Surface, GltfError> {
        let pbr = &json.pbr_metallic_roughness;
        let base_color = pbr
            .base_color_factor
            .0
            .map(|channel| self.number("base colour factor", channel, 1.0));
        Ok(Surface {
            base_color: Vec4::from(base_color),
            base_color_texture: self.slot(pbr.base_color_texture.as_ref().map(info))?,
            metallic: self.number("metallic factor", pbr.metallic_factor.0, 1.0),
            roughness: self.number("roughness factor", pbr.roughness_factor.0, 1.0),
            metallic_roughness_texture: self.slot(pbr.metallic_roughness_texture.as_ref().map(info))?,
        })
    }

    fn specular_glossiness(&mut self, json: &JsonMaterial, name: &str) -> Result<Surface, GltfError> {
        let extensions = json.extensions.as_ref();
        let Some(pbr) = extensions.and_then(|extensions| extensions.pbr_specular_glossiness.as_ref()) else {
            return self.metallic_roughness(json);
        };
        let diffuse = pbr
            .diffuse_factor
            .0
            .map(|channel| self.number("diffuse factor", channel, 1.0));
        let specular = pbr
            .specular_factor
            .0
            .map(|channel| self.number("specular factor", channel, 1.0));
        let stated = SpecularGlossiness {
            diffuse: Vec4::from(diffuse),
            diffuse_texture: self.slot(pbr.diffuse_texture.as_ref().map(info))?,
            specular: Vec3::from(specular),
            glossiness: self.number("glossiness factor", pbr.glossiness_factor.0, 1.0),
            specular_texture: self.slot(pbr.specular_glossiness_texture.as_ref().map(info))?,
        };
        if stated.is_split() {
            let reason = "its specular texture lies otherwise than the diffuse one, its mean is used";
            self.report.add(SkipKind::Texture, self.element, 1, reason);
        }
        Ok(stated.surface(name))
    }

    fn transmission(
        &mut self,
        extensions: &Extensions,
        material: &mut Material,
    ) -> Result<VertexAlpha, GltfError> {
        let Some(json) = &extensions.transmission else {
            return Ok(VertexAlpha::default());
        };
        let factor = self.number("transmission factor", json.transmission_factor.0, 1.0);
        if factor == 0.0 {
            return Ok(VertexAlpha::default());
        }
        let ior = extensions.ior.as_ref().map_or(1.5, |ior| ior.ior.0);
        let volume = extensions.volume.as_ref();
        let stated = Transmission {
            factor,
            texture: self.slot(json.transmission_texture.as_ref().map(info))?,
            ior: if ior.is_finite() && ior >= 0.0 { ior } else { 1.5 },
            passing: volume.map_or(Vec3::ONE, |volume| {
                let color = Vec3::from(volume.attenuation_color.0);
                transmission::passing(volume.thickness_factor.0, volume.attenuation_distance.0, color)
            }),
        };
        if stated.is_split(material) {
            let reason = "its transmission texture lies otherwise than the base colour, its mean is used";
            self.report.add(SkipKind::Texture, self.element, 1, reason);
        }
        Ok(stated.apply(material))
    }

    fn clearcoat(&mut self, extensions: &Extensions, material: &mut Material) -> Result<(), GltfError> {
        let Some(json) = extensions.others.get(CLEARCOAT) else {
            return Ok(());
        };
        let Some(stated) = clearcoat::parse(json) else {
            self.skip(
                SkipKind::MaterialValue,
                format!("{CLEARCOAT} is not an object, it is ignored"),
            );
            return Ok(());
        };
        for name in stated.unread_numbers {
            self.skip(
                SkipKind::MaterialValue,
                format!("{name} is not a number, it becomes 0"),
            );
        }
        material.clearcoat = self.number("clearcoat factor", stated.factor, 1.0);
        material.clearcoat_roughness = self.number("clearcoat roughness factor", stated.roughness, 1.0);
        if material.clearcoat == 0.0 {
            return Ok(());
        }
        for name in stated.unread_textures {
            self.skip(
                SkipKind::Texture,
                format!("{name} cannot be read, the coat does without it"),
            );
        }
        if stated.has_normals {
            let reason = "clearcoatNormalTexture is not read, the coat has the normals of the mesh";
            self.skip(SkipKind::Texture, reason);
        }
        material.clearcoat_texture = self.slot(stated.texture.as_ref().map(info))?;
        material.clearcoat_roughness_texture = self.slot(stated.roughness_texture.as_ref().map(info))?;
        Ok(())
    }

    fn skip(&mut self, kind: SkipKind, reason: impl Into<String>) {
        self.report.add(kind, self.element, 1, reason);
    }

    /// Returns `value` if it lies in 0..=`largest`. Otherwise returns the nearest number that does, and
    /// reports it.
    fn number(&mut self, what: &str, value: f32, largest: f32) -> f32 {
        if (0.0..=largest).contains(&value) {
            return value;
        }
        let clamped = value.clamp(0.0, largest);
        let clamped = if clamped.is_finite() { clamped } else { 0.0 };
        self.report.add(
            SkipKind::MaterialValue,
            self.element,
            1,
            format!("{what} {value} becomes {clamped}"),
        );
        clamped
    }

    fn slot(
        &mut self,
        used: Option<(Index<Texture>, u32, Option<TextureTransform>)>,
    ) -> Result<Option<TextureSlot>, GltfError> {
        let Some((index, uv_set, transform)) = used else {
            return Ok(None);
        };
        let Some(texture) = self.textures.load(index, self.element, self.report)? else {
            return Ok(None);
        };
        let uv_set = transform
            .as_ref()
            .and_then(|transform| transform.tex_coord)
            .unwrap_or(uv_set);
        if uv_set > 1 {
            let reason = format!("TEXCOORD_{uv_set} is not supported, 0 and 1 are");
            self.report.add(SkipKind::Texture, self.element, 1, reason);
            return Ok(None);
        }
        let uv_transform = transform
            .map(|transform| texture_affine(&transform))
            .filter(|uv_transform| uv_transform.is_finite())
            .unwrap_or(Affine2::IDENTITY);
        Ok(Some(TextureSlot {
            texture,
            uv_set,
            uv_transform,
        }))
    }
}

/// The texture of a slot, its set of coordinates and its transform.
fn info(info: &Info) -> (Index<Texture>, u32, Option<TextureTransform>) {
    let extensions = info.extensions.as_ref();
    let transform = extensions.and_then(|extensions| extensions.texture_transform.clone());
    (info.index, info.tex_coord, transform)
}

/// The transform of a normal or occlusion texture, which `gltf::json` leaves unparsed. A transform that does
/// not parse counts as absent.
fn transform_of<'v>(others: impl IntoIterator<Item = (&'v String, &'v Value)>) -> Option<TextureTransform> {
    let (_, value) = others
        .into_iter()
        .find(|(name, _)| *name == "KHR_texture_transform")?;
    deserialize::from_value(value.clone()).ok()
}

/// The transform of texture coordinates: scale, then a rotation counter-clockwise as seen with v pointing
/// down, then an offset.
///
/// The matrix printed in the extension's text turns the other way from its words. This function follows the
/// words; so do Khronos' own test model TextureTransformTest, three.js and Bevy.
fn texture_affine(transform: &TextureTransform) -> Affine2 {
    Affine2::from_mat2_translation(
        Mat2::from_angle(-transform.rotation.0) * Mat2::from_diagonal(Vec2::from(transform.scale.0)),
        Vec2::from(transform.offset.0),
    )
}
