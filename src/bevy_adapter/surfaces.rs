//! The properties of Bevy's materials that matter to shadows: whether a surface is opaque, and from which
//! sides it is seen.
//!
//! An opaque object may hide others from the camera and from lights, and its surface may hide the near cap of
//! its own shadow volume. An object that is not surely opaque does neither.

use std::sync::Arc;

use bevy::asset::{AssetEvent, AssetId, Assets};
use bevy::ecs::prelude::*;
use bevy::ecs::world::EntityRef;
use bevy::material::AlphaMode as BevyAlphaMode;
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::platform::collections::HashMap;
use bevy::render::Extract;
use bevy::render::render_resource::Face;

use crate::scene::{AlphaMode, Material, SceneMaterials};

/// The kind of an object's surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// The surface is opaque, and its back faces are culled.
    OneSided,
    /// The surface is opaque from both sides.
    TwoSided,
    /// The surface may be seen through: it is alpha-masked, blended, transmissive or culled in front, its
    /// material is not a `StandardMaterial`, or its material is not known yet.
    SeenThrough,
}

impl Surface {
    /// Returns the surface of a material.
    pub fn of_material(material: &StandardMaterial) -> Self {
        if material.alpha_mode != BevyAlphaMode::Opaque || material.specular_transmission > 0.0 {
            return Self::SeenThrough;
        }
        match material.cull_mode {
            Some(Face::Back) => Self::OneSided,
            Some(Face::Front) => Self::SeenThrough, // only faces that are turned away are seen
            None => Self::TwoSided,
        }
    }
}

/// The surfaces of the game's materials, and three materials of this crate that stand for them. The resource
/// is in the render world.
#[derive(Resource, Debug)]
pub struct Surfaces {
    known: HashMap<AssetId<StandardMaterial>, Surface>,
    /// Materials whose surface changed in this frame.
    changed: Vec<AssetId<StandardMaterial>>,
    materials: [SceneMaterials; 3],
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
            changed: Vec::new(),
            materials: [
                material(AlphaMode::Opaque, false),
                material(AlphaMode::Opaque, true),
                material(AlphaMode::Mask(0.5), true),
            ],
        }
    }
}

impl Surfaces {
    /// Returns the surface of an object of the game.
    pub fn of_object(&self, object: &EntityRef) -> Surface {
        let material = object.get::<MeshMaterial3d<StandardMaterial>>();
        let known = material.and_then(|material| self.known.get(&material.0.id()));
        known.copied().unwrap_or(Surface::SeenThrough)
    }

    /// Returns the materials for a surface. All objects with the same surface share them.
    pub fn materials(&self, surface: Surface) -> &SceneMaterials {
        &self.materials[surface as usize]
    }

    /// Whether the surface of a material changed in this frame.
    pub fn changed(&self, material: AssetId<StandardMaterial>) -> bool {
        self.changed.contains(&material)
    }

    /// Whether the surface of any material changed in this frame.
    pub fn any_changed(&self) -> bool {
        !self.changed.is_empty()
    }
}

/// Reads the surfaces of materials that were added or changed. A change of colour alone does not change the
/// surface.
///
/// Runs in `ExtractSchedule`. Set: [`Collect`](super::AntumbraExtractSystems::Collect).
pub(super) fn collect_surfaces(
    mut surfaces: ResMut<Surfaces>,
    mut events: Extract<MessageReader<AssetEvent<StandardMaterial>>>,
    materials: Extract<Res<Assets<StandardMaterial>>>,
) {
    let surfaces = &mut *surfaces;
    surfaces.changed.clear();
    for event in events.read() {
        match *event {
            AssetEvent::Added { id } | AssetEvent::Modified { id } => {
                let Some(material) = materials.get(id) else {
                    continue;
                };
                let surface = Surface::of_material(material);
                if surfaces.known.insert(id, surface) != Some(surface) {
                    surfaces.changed.push(id);
                }
            }
            AssetEvent::Removed { id } | AssetEvent::Unused { id } => {
                if surfaces.known.remove(&id).is_some() {
                    surfaces.changed.push(id);
                }
            }
            AssetEvent::LoadedWithDependencies { .. } => {}
        }
    }
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
        assert_eq!(of(|m| m.cull_mode = Some(Face::Front)), Surface::SeenThrough);
        assert_eq!(
            of(|m| m.alpha_mode = BevyAlphaMode::Mask(0.5)),
            Surface::SeenThrough
        );
        assert_eq!(of(|m| m.alpha_mode = BevyAlphaMode::Blend), Surface::SeenThrough);
        assert_eq!(of(|m| m.specular_transmission = 0.5), Surface::SeenThrough);
    }
}
