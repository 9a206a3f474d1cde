//! The properties of Bevy's materials that matter to shadows: whether a surface is opaque, and from which
//! sides it is seen.
//!
//! An opaque object may hide others from the camera and from lights, and its surface may hide the near cap of
//! its own shadow volume. An object that is not surely opaque does neither.

use std::sync::Arc;

use bevy::asset::{AssetEvent, AssetId, Assets, VisitAssetDependencies};
use bevy::ecs::prelude::*;
use bevy::ecs::world::EntityRef;
use bevy::image::Image;
use bevy::material::AlphaMode as BevyAlphaMode;
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::platform::collections::{HashMap, HashSet};
use bevy::render::Extract;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_resource::Face;
use bevy::render::texture::GpuImage;

use super::cut_outs::{CutMaterial, CutOut};
use crate::render::Gpu;
use crate::scene::{AlphaMode, Material, MeshData, SceneMaterials};

/// The kind of an object's surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// The surface is opaque, and its back faces are culled.
    OneSided,
    /// The surface is opaque from both sides.
    TwoSided,
    /// The surface is opaque, and its front faces are culled.
    BackAlone,
    /// The surface may be seen through: it is alpha-masked, blended or transmissive, its material is not a
    /// `StandardMaterial`, or its material is not known yet.
    SeenThrough,
    /// Bevy does not draw the surface: a texture of its material is not loaded.
    NotDrawn,
}

impl Surface {
    /// Returns the surface of a material.
    pub fn of_material(material: &StandardMaterial) -> Self {
        if material.alpha_mode != BevyAlphaMode::Opaque || material.specular_transmission > 0.0 {
            return Self::SeenThrough;
        }
        match material.cull_mode {
            Some(Face::Back) => Self::OneSided,
            Some(Face::Front) => Self::BackAlone,
            None => Self::TwoSided,
        }
    }

    /// Returns the surface of an object that a transform turns inside out. Bevy culls by the winding on the
    /// screen, whatever the transform, so such an object shows its other side.
    pub fn turned(self) -> Self {
        match self {
            Self::OneSided => Self::BackAlone,
            Self::BackAlone => Self::OneSided,
            other => other,
        }
    }
}

/// The surfaces of the game's materials, and the materials of this crate that stand for them. The resource is
/// in the render world.
#[derive(Resource, Debug)]
pub struct Surfaces {
    known: HashMap<AssetId<StandardMaterial>, Surface>,
    /// Materials that are alpha-masked or blended.
    pub(super) cut_outs: HashMap<AssetId<StandardMaterial>, CutMaterial>,
    /// Materials with a texture that is not loaded yet.
    unloaded: HashSet<AssetId<StandardMaterial>>,
    /// Materials that got another texture on the device since the last frame was extracted.
    pub(super) renewed: Vec<AssetId<StandardMaterial>>,
    /// Materials whose surface changed in this frame.
    changed: HashSet<AssetId<StandardMaterial>>,
    one_sided: SceneMaterials,
    two_sided: SceneMaterials,
    seen_through: SceneMaterials,
}

impl Default for Surfaces {
    fn default() -> Self {
        // Bevy shades the objects, so only these two fields matter.
        let material = |alpha_mode, double_sided| {
            SceneMaterials(
                [Arc::new(Material {
                    alpha_mode,
                    double_sided,
                    ..Material::default()
                })]
                .into(),
            )
        };
        Self {
            known: HashMap::default(),
            cut_outs: HashMap::default(),
            unloaded: HashSet::default(),
            renewed: Vec::new(),
            changed: HashSet::default(),
            one_sided: material(AlphaMode::Opaque, false),
            two_sided: material(AlphaMode::Opaque, true),
            // A cutoff of 0 cuts nothing: how the surface is seen through is not known.
            seen_through: material(AlphaMode::Mask(0.0), true),
        }
    }
}

/// An object's `StandardMaterial`; `None` if its material is of another type.
pub fn standard_material(object: &EntityRef) -> Option<AssetId<StandardMaterial>> {
    let material = object.get::<MeshMaterial3d<StandardMaterial>>()?;
    Some(material.0.id())
}

impl Surfaces {
    /// Returns the surface of a material; `None` stands for a material of another type.
    pub fn get(&self, material: Option<AssetId<StandardMaterial>>) -> Surface {
        let known = material.and_then(|material| self.known.get(&material));
        known.copied().unwrap_or(Surface::SeenThrough)
    }

    /// Gives the materials with cut-outs their textures on the device. A steady frame only compares ids.
    pub(super) fn bind_cut_outs(&mut self, images: &RenderAssets<GpuImage>, gpu: &Gpu) {
        for (&id, material) in &mut self.cut_outs {
            if material.bind(images, gpu) {
                self.renewed.push(id);
            }
        }
    }

    /// Whether a texture cuts holes with sharp edges into a material.
    pub fn is_cut_out(&self, material: AssetId<StandardMaterial>) -> bool {
        let cut = self.cut_outs.get(&material).map(|known| known.cut);
        cut.is_some_and(|cut| cut.is_sharp && cut.image.is_some())
    }

    /// Returns the materials of an object with this surface and this mesh; `None` if the object is not drawn.
    /// Objects whose surfaces are alike share them.
    pub fn materials(
        &self,
        surface: Surface,
        material: Option<AssetId<StandardMaterial>>,
        mesh: Option<&MeshData>,
    ) -> Option<&SceneMaterials> {
        match surface {
            Surface::OneSided => Some(&self.one_sided),
            Surface::TwoSided => Some(&self.two_sided),
            Surface::NotDrawn => None,
            Surface::BackAlone => Some(&self.seen_through),
            Surface::SeenThrough => {
                let cut = material.and_then(|material| self.cut_outs.get(&material));
                let cut = cut.filter(|known| {
                    known.cut.image.is_none() || mesh.is_some_and(|mesh| known.cut.has_coordinates(mesh))
                });
                Some(cut.map_or(&self.seen_through, |known| &known.materials))
            }
        }
    }

    /// Whether the surface of a material changed in this frame.
    pub fn changed(&self, material: AssetId<StandardMaterial>) -> bool {
        self.changed.contains(&material)
    }

    /// Whether the surface of any material changed in this frame.
    pub fn any_changed(&self) -> bool {
        !self.changed.is_empty()
    }

    /// Reads a material. Returns whether all its textures are loaded.
    fn look_at(
        &mut self,
        id: AssetId<StandardMaterial>,
        material: &StandardMaterial,
        images: &Assets<Image>,
    ) -> bool {
        let cut = CutOut::of_material(material);
        let is_loaded = is_loaded(material, images);
        let surface = if !is_loaded || cut.is_some_and(|cut| cut.is_everywhere()) {
            Surface::NotDrawn
        } else {
            Surface::of_material(material)
        };
        let known_cut = self.cut_outs.get(&id).map(|known| known.cut);
        if known_cut != cut {
            match cut {
                Some(cut) => self.cut_outs.insert(id, CutMaterial::new(cut)),
                None => self.cut_outs.remove(&id),
            };
        }
        if self.known.insert(id, surface) != Some(surface) || known_cut != cut {
            self.changed.insert(id);
        }
        is_loaded
    }

    /// Marks the cut-outs whose texture is one of these images, whose pixels may have changed.
    fn outdate(&mut self, images: &HashSet<AssetId<Image>>) {
        for material in self.cut_outs.values_mut() {
            let image = material.cut.image;
            material.is_outdated |= image.is_some_and(|image| images.contains(&image));
        }
    }

    fn forget(&mut self, id: AssetId<StandardMaterial>) {
        self.cut_outs.remove(&id);
        if self.known.remove(&id).is_some() {
            self.changed.insert(id);
        }
    }
}

/// Whether all textures of a material are loaded. Bevy draws nothing with a material before they are.
fn is_loaded(material: &StandardMaterial, images: &Assets<Image>) -> bool {
    let mut is_loaded = true;
    material.visit_dependencies(&mut |texture| {
        is_loaded &= texture
            .try_typed::<Image>()
            .is_ok_and(|image| images.contains(image));
    });
    is_loaded
}

/// Reads the surfaces of materials that were added or changed, and of those whose textures were not loaded. A
/// change of colour alone does not change the surface. Cut-outs whose image changed take its texture anew.
///
/// Runs in `ExtractSchedule`. Set: [`Collect`](super::AntumbraExtractSystems::Collect).
pub(super) fn collect_surfaces(
    mut surfaces: ResMut<Surfaces>,
    mut events: Extract<MessageReader<AssetEvent<StandardMaterial>>>,
    mut image_events: Extract<MessageReader<AssetEvent<Image>>>,
    materials: Extract<Res<Assets<StandardMaterial>>>,
    images: Extract<Res<Assets<Image>>>,
    mut changed_images: Local<HashSet<AssetId<Image>>>,
) {
    let surfaces = &mut *surfaces;
    surfaces.changed.clear();
    surfaces.changed.extend(surfaces.renewed.drain(..));
    changed_images.clear();
    for event in image_events.read() {
        if let AssetEvent::Added { id } | AssetEvent::Modified { id } = *event {
            changed_images.insert(id);
        }
    }
    if !changed_images.is_empty() {
        surfaces.outdate(&changed_images);
    }
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                if let Some(material) = materials.get(id)
                    && !surfaces.look_at(id, material, &images)
                {
                    surfaces.unloaded.insert(id);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => surfaces.forget(id),
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
    let mut unloaded = std::mem::take(&mut surfaces.unloaded);
    unloaded.retain(|&id| {
        let material = materials.get(id);
        material.is_some_and(|material| !surfaces.look_at(id, material, &images))
    });
    surfaces.unloaded = unloaded; // keeps its allocation
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_is_surely_opaque_is() {
        let of = |change: fn(&mut StandardMaterial)| {
            let mut material = StandardMaterial::default();
            change(&mut material);
            Surface::of_material(&material)
        };
        assert_eq!(of(|_| ()), Surface::OneSided);
        assert_eq!(of(|m| m.cull_mode = None), Surface::TwoSided);
        assert_eq!(of(|m| m.cull_mode = Some(Face::Front)), Surface::BackAlone);
        assert_eq!(
            of(|m| m.alpha_mode = BevyAlphaMode::Mask(0.5)),
            Surface::SeenThrough
        );
        assert_eq!(of(|m| m.alpha_mode = BevyAlphaMode::Blend), Surface::SeenThrough);
        assert_eq!(of(|m| m.specular_transmission = 0.5), Surface::SeenThrough);
    }
}
