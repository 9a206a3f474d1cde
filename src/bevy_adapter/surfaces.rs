//! What of Bevy's materials matters to shadows: whether one looks through a surface, and from which sides it is seen.
//!
//! Opaque objects may hide others from the camera and from lights, and their own surface may hide the near cap of their
//! shadow volume. Whatever is not surely opaque does neither.

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

/// How an object shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surface {
    /// Opaque, and culled from behind.
    OneSided,
    /// Opaque from both sides.
    TwoSided,
    /// With holes, blended, of another material than Bevy's standard one, or not known yet.
    SeenThrough,
}

impl Surface {
    /// That of a material.
    pub fn of_material(material: &StandardMaterial) -> Self {
        if material.alpha_mode != BevyAlphaMode::Opaque || material.specular_transmission > 0.0 {
            return Self::SeenThrough;
        }
        match material.cull_mode {
            Some(Face::Back) => Self::OneSided,
            Some(Face::Front) => Self::SeenThrough, // what is seen is not what faces us
            None => Self::TwoSided,
        }
    }
}

/// The surfaces of the game's materials, and three materials of ours that stand for them. In the render world.
#[derive(Resource, Debug)]
pub struct Surfaces {
    known: HashMap<AssetId<StandardMaterial>, Surface>,
    /// Materials that became another surface in this frame.
    changed: Vec<AssetId<StandardMaterial>>,
    materials: [SceneMaterials; 3],
}

impl Default for Surfaces {
    fn default() -> Self {
        // Bevy shades: only these two fields matter.
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
    /// How an object of the game shows.
    pub fn of_object(&self, object: &EntityRef) -> Surface {
        let material = object.get::<MeshMaterial3d<StandardMaterial>>();
        let known = material.and_then(|material| self.known.get(&material.0.id()));
        known.copied().unwrap_or(Surface::SeenThrough)
    }

    /// Our materials for it; one for all objects that show alike.
    pub fn materials(&self, surface: Surface) -> &SceneMaterials {
        &self.materials[surface as usize]
    }

    /// Whether a material became another surface in this frame.
    pub fn changed(&self, material: AssetId<StandardMaterial>) -> bool {
        self.changed.contains(&material)
    }

    /// Whether any did.
    pub fn any_changed(&self) -> bool {
        !self.changed.is_empty()
    }
}

/// Reads materials that were added or changed. A material whose colour alone is animated changes nothing.
///
/// `ExtractSchedule`, [`Collect`](super::AntumbraExtractSystems::Collect).
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
