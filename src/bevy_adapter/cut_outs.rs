//! Casters with holes: materials whose alpha removes a part of their surface.
//!
//! Techniques that draw maps leave the holes out of a caster's shadow. They read the texture of Bevy's
//! material where it is, on the same device, so nothing is loaded or uploaded twice. Volumes and wedges are
//! made from triangles alone, so under them such a caster blocks light with its whole triangles.

use std::sync::Arc;

use bevy::asset::AssetId;
use bevy::ecs::prelude::*;
use bevy::ecs::world::EntityRef;
use bevy::image::Image;
use bevy::material::AlphaMode as BevyAlphaMode;
use bevy::mesh::UvChannel;
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::platform::collections::HashMap;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::{SamplerId, TextureViewId};
use bevy::render::texture::GpuImage;
use glam::{Affine2, Vec4};

use super::mirror::{Mirror, Mirrors};
use crate::render::{Gpu, HostTexture};
use crate::reports::Reports;
use crate::scene::{AlphaMode, Material, MeshData, SceneMaterials};
use crate::sets::{FrameLights, NeededSilhouettes, Needs};
use crate::techniques::{Row, Techniques};

/// Alpha below which Bevy leaves a blended surface out of its shadow maps.
const BLENDED_CUTOFF: f32 = 0.05;

/// The numbers of a material that decide where its surface has holes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutOut {
    /// Alpha below which the surface is absent.
    pub cutoff: f32,
    /// Alpha of the material's base colour, which multiplies that of the texture.
    pub alpha: f32,
    /// The base colour texture, if the material has one.
    pub image: Option<AssetId<Image>>,
    /// Which set of texture coordinates is used: 0 or 1.
    pub uv_set: u32,
    /// Transform of the texture coordinates.
    pub uv_transform: Affine2,
    /// Whether the picture shows the holes with sharp edges. If not, the surface is blended, and what is hardly
    /// seen counts as a hole.
    pub is_sharp: bool,
}

impl CutOut {
    /// Returns the holes of a material; `None` if its alpha makes no holes.
    pub fn of_material(material: &StandardMaterial) -> Option<Self> {
        let (cutoff, is_sharp) = match material.alpha_mode {
            BevyAlphaMode::Mask(cutoff) => (cutoff, true),
            BevyAlphaMode::AlphaToCoverage => (BLENDED_CUTOFF, true),
            BevyAlphaMode::Blend | BevyAlphaMode::Add => (BLENDED_CUTOFF, false),
            BevyAlphaMode::Opaque | BevyAlphaMode::Premultiplied | BevyAlphaMode::Multiply => return None,
        };
        Some(Self {
            cutoff,
            alpha: material.base_color.to_linear().alpha,
            image: material.base_color_texture.as_ref().map(|image| image.id()),
            uv_set: u32::from(material.base_color_channel == UvChannel::Uv1),
            uv_transform: material.uv_transform,
            is_sharp,
        })
    }

    /// Whether the whole surface is a hole, because no texture can raise its alpha to the cutoff.
    pub fn is_everywhere(&self) -> bool {
        self.alpha < self.cutoff
    }

    /// Whether a mesh has the texture coordinates of the texture. Bevy draws a mesh without them as if the
    /// material had no texture.
    pub fn has_coordinates(&self, mesh: &MeshData) -> bool {
        let coordinates = if self.uv_set == 0 { &mesh.uv0 } else { &mesh.uv1 };
        !coordinates.is_empty()
    }
}

/// A cut-out and the materials by which our techniques know it.
#[derive(Clone, Debug)]
pub struct CutMaterial {
    /// The numbers of the game's material.
    pub cut: CutOut,
    /// The materials of objects with this cut-out.
    pub materials: SceneMaterials,
    /// Bevy's texture view and sampler that the material has on the device; `None` before it has any.
    bound: Option<(TextureViewId, SamplerId)>,
    /// Whether the image of the texture changed since the material got it. Bevy writes the new pixels into the
    /// same texture, so view and sampler do not tell.
    pub(super) is_outdated: bool,
}

impl CutMaterial {
    /// Makes the material of a cut-out.
    pub fn new(cut: CutOut) -> Self {
        // Bevy shades the objects, so only alpha matters.
        let material = Material {
            base_color: Vec4::ONE.truncate().extend(cut.alpha),
            alpha_mode: AlphaMode::Mask(cut.cutoff),
            double_sided: true,
            ..Material::default()
        };
        Self {
            cut,
            materials: SceneMaterials([Arc::new(material)].into()),
            bound: None,
            is_outdated: false,
        }
    }

    /// Gives the material its texture on the device. Returns `true` if objects must take the materials anew.
    pub(super) fn bind(&mut self, images: &RenderAssets<GpuImage>, gpu: &Gpu) -> bool {
        let Some(image) = self.cut.image.and_then(|image| images.get(image)) else {
            return false;
        };
        let wanted = Some((image.texture_view.id(), image.sampler.id()));
        if self.bound == wanted && !self.is_outdated {
            return false;
        }
        let texture = HostTexture {
            view: (*image.texture_view).clone(),
            sampler: (*image.sampler).clone(),
            uv_set: self.cut.uv_set,
            uv_transform: self.cut.uv_transform,
        };
        let is_first = self.bound.is_none() && gpu.host_texture(&self.materials.0[0], texture.clone());
        if !is_first {
            // Other pixels, another texture, or one that comes late: the old material stays as it is on the device.
            *self = Self::new(self.cut);
            gpu.host_texture(&self.materials.0[0], texture);
        }
        self.bound = wanted;
        self.is_outdated = false;
        !is_first
    }
}

/// Casters with textured holes that are in use, by material. The resource is in the render world.
#[derive(Resource, Debug, Default)]
pub struct CutOutCasters {
    entries: HashMap<AssetId<StandardMaterial>, CutOutCaster>,
}

#[derive(Debug)]
struct CutOutCaster {
    /// First entity that was found to use the material. It may have been despawned since.
    user: Entity,
    /// Path of the asset, or its id if it has no path.
    name: String,
}

impl CutOutCasters {
    /// Records that a caster uses a material whose texture cuts holes. The report names the first caster.
    pub(super) fn insert(&mut self, object: &EntityRef) {
        let Some(material) = object.get::<MeshMaterial3d<StandardMaterial>>() else {
            return;
        };
        self.entries
            .entry(material.0.id())
            .or_insert_with(|| CutOutCaster {
                user: object.id(),
                name: material
                    .0
                    .path()
                    .map_or_else(|| material.0.id().to_string(), ToString::to_string),
            });
    }

    /// Removes the materials for which `is_cut_out` is false.
    pub(super) fn retain(&mut self, is_cut_out: impl Fn(AssetId<StandardMaterial>) -> bool) {
        self.entries.retain(|&material, _| is_cut_out(material));
    }

    /// Raises the reports of the topic `material`, one for each material, if a technique of some light makes
    /// shadows from triangles alone.
    pub(super) fn raise(&self, mirrors: &Mirrors, reports: &mut Reports) {
        let mut round = reports.round("material");
        let mut mirrors = mirrors.iter().map(|(_, mirror)| mirror);
        let Some(mirror) = mirrors.find(|mirror| !self.entries.is_empty() && has_light_of_triangles(mirror))
        else {
            return;
        };
        let named = |is_meant: fn(Needs) -> bool, word: &str| {
            let rows = mirror.world.resource::<Techniques>().rows().iter();
            let meant = rows.filter(|row| is_meant(row.needs()));
            meant.map(Row::component_name).collect::<Vec<_>>().join(word)
        };
        for CutOutCaster { user, name } in self.entries.values() {
            round.raise(Some(*user), 1, || {
                let triangles = named(makes_shadows_of_triangles, " and ");
                let pictures = named(|needs| needs.receiver_planes, " or ");
                format!(
                    "The material {name} cuts holes by alpha, but {triangles} make shadows from triangles: under them its \
                     meshes block light as a whole. Give lights that shine through the holes another technique: {pictures}."
                )
            });
        }
    }
}

/// Whether a light of a mirror is shadowed from triangles alone. Techniques that need the silhouettes of all
/// casters that the light reaches draw pictures beside them, which have the holes.
fn has_light_of_triangles(mirror: &Mirror) -> bool {
    let lights = mirror.world.resource::<FrameLights>();
    let techniques = lights.lights.iter().filter_map(|light| light.technique);
    techniques
        .map(|technique| technique.needs)
        .any(makes_shadows_of_triangles)
}

fn makes_shadows_of_triangles(needs: Needs) -> bool {
    needs.silhouettes == NeededSilhouettes::Shadowing
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::color::{Alpha, Color};

    #[test]
    fn alpha_makes_holes_as_in_bevys_shadow_maps() {
        let of = |alpha_mode, alpha: f32| {
            CutOut::of_material(&StandardMaterial {
                alpha_mode,
                base_color: Color::WHITE.with_alpha(alpha),
                ..Default::default()
            })
        };
        assert_eq!(of(BevyAlphaMode::Opaque, 0.0), None);
        assert_eq!(of(BevyAlphaMode::Multiply, 0.0), None);
        let mask = of(BevyAlphaMode::Mask(0.3), 0.5).expect("a mask");
        assert!(mask.cutoff == 0.3 && mask.alpha == 0.5 && mask.is_sharp && !mask.is_everywhere());
        assert!(of(BevyAlphaMode::Mask(0.6), 0.5).expect("a mask").is_everywhere());
        let glass = of(BevyAlphaMode::Blend, 0.2).expect("a blend");
        assert!(!glass.is_sharp && !glass.is_everywhere());
        assert!(of(BevyAlphaMode::Blend, 0.0).expect("a blend").is_everywhere());
    }
}
