//! Finds the surfaces of one set of maps among the objects of the world.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use smallvec::SmallVec;

use super::intervals::{Intervals, shining};
use super::maps::IntervalMaps;
use super::surface::{is_same_place, surface_hash};
use crate::scene::placement::Placement;
use crate::scene::{
    FaceCulling, Material, MeshData, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster,
};
use crate::sets::Objects;

/// A surface of the maps and the submesh that it belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MatchedSurface {
    /// Index in [`IntervalMaps::surfaces`].
    pub surface: u32,
    /// Entity of the object.
    pub entity: Entity,
    /// Index of the submesh.
    pub submesh: u32,
}

/// The surfaces of one set of maps in the world.
#[derive(Clone, Debug)]
pub struct IntervalScene {
    /// The maps.
    pub maps: Arc<IntervalMaps>,
    /// Mask of the layers that block the lights which use the maps.
    pub casts_for: u32,
    /// The surfaces that were found, in ascending order.
    pub matched: Vec<MatchedSurface>,
    /// Dense index in [`Objects`] of each matched surface's object.
    pub objects: Vec<u32>,
    /// Number of surfaces that were not found.
    pub missing: usize,
    /// Index of the first surface that was not found.
    pub first_missing: Option<usize>,
    /// Receivers of the world of which a submesh shows shadows that the maps do not hold: it is not in them, or it showed no
    /// shadows when they were baked.
    pub strangers: usize,
    /// Receivers of the world of which a submesh is seen from both sides, while the maps hold what its fronts see alone.
    pub without_backs: usize,
    /// Dense indices in [`Objects`] of the objects that are not in the maps with all of their submeshes, receivers or not, and of
    /// those that show shadows on more submeshes than when the maps were baked.
    pub outside: Vec<u32>,
    /// Objects that cast and are not in the maps with all of their submeshes, by dense index in [`Objects`].
    pub strange_casters: FixedBitSet,
    /// The objects of `outside`, by dense index in [`Objects`].
    pub strange_receivers: FixedBitSet,
    /// Whether memory was granted for the textures when it was shared last.
    pub(super) has_memory: bool,
    /// Increases when `matched` changed. It stays while other objects come and go.
    pub generation: u64,
    /// Index in [`FrameLights`](crate::sets::FrameLights) of the light that asks for the memory of the textures: the most
    /// visible one of those that share them. `None` if no light uses the maps in this frame.
    pub payer: Option<usize>,
    /// When the light shines at all, as intervals of its path.
    pub(super) shining: Intervals,
    pub(super) is_used: bool,
    /// Generations of the layout and of the flags of [`Objects`], and the faces that were seen, when the surfaces were looked
    /// for.
    searched: Option<([u64; 2], FaceCulling)>,
    by_hash: HashMap<u64, SmallVec<[u32; 2]>>,
    /// Memory that is kept for its allocation.
    found: Vec<(MatchedSurface, u32)>,
}

/// Hashes of meshes by the address of their data. An entry keeps the address from being used again, but not the data.
#[derive(Debug, Default)]
pub(super) struct MeshHashes(HashMap<usize, (Weak<MeshData>, SmallVec<[u64; 2]>)>);

impl MeshHashes {
    fn of(&mut self, mesh: &Arc<MeshData>) -> &[u64] {
        let entry = self.0.entry(Arc::as_ptr(mesh) as usize).or_insert_with(|| {
            let hashes = mesh.submeshes.iter().map(|submesh| surface_hash(mesh, submesh));
            (Arc::downgrade(mesh), hashes.collect())
        });
        &entry.1
    }

    /// Forgets meshes that are gone.
    pub(super) fn forget_unused(&mut self) {
        self.0.retain(|_, (mesh, _)| mesh.strong_count() > 0);
    }

    /// Number of meshes whose hashes are known.
    #[cfg(test)]
    pub(super) fn len(&self) -> usize {
        self.0.len()
    }
}

/// The components by which surfaces are recognized. They say whether an object casts, because [`Objects`] leave out casters
/// that a view culls, and those were baked. Materials tell which submeshes show shadows, and on which sides.
pub(super) type Meshes<'w, 's> = Query<
    'w,
    's,
    (
        &'static SceneMesh,
        Placement,
        Has<ShadowCaster>,
        Option<&'static SelectionLayers>,
        Option<&'static SceneMaterials>,
    ),
>;

/// Whether a material is known and shows shadows. The bake lays only such submeshes onto pages.
fn is_lit(material: Option<&Arc<Material>>) -> bool {
    material.is_some_and(|material| !material.unlit)
}

fn generations(objects: &Objects) -> [u64; 2] {
    [objects.layout_generation, objects.flags_generation]
}

impl IntervalScene {
    pub(super) fn new(maps: &Arc<IntervalMaps>, casts_for: u32) -> Self {
        let mut by_hash: HashMap<u64, SmallVec<[u32; 2]>> = HashMap::new();
        for (index, surface) in (0u32..).zip(&maps.surfaces) {
            by_hash.entry(surface.hash).or_default().push(index);
        }
        Self {
            maps: maps.clone(),
            casts_for,
            matched: Vec::new(),
            objects: Vec::new(),
            missing: maps.surfaces.len(),
            first_missing: None,
            strangers: 0,
            without_backs: 0,
            outside: Vec::new(),
            strange_casters: FixedBitSet::new(),
            strange_receivers: FixedBitSet::new(),
            has_memory: true,
            generation: 0,
            payer: None,
            shining: shining(&maps.path),
            is_used: true,
            searched: None,
            by_hash,
            found: Vec::new(),
        }
    }

    /// Whether the surfaces must be looked for again.
    pub(super) fn is_stale(
        &self,
        objects: &Objects,
        meshes: &Meshes,
        (culling, is_changed): (FaceCulling, bool),
    ) -> bool {
        if self.searched != Some((generations(objects), culling)) || is_changed {
            return true;
        }
        if !objects.any_moved() {
            return false;
        }
        let has_left = |(matched, object): (&MatchedSurface, &u32)| {
            objects.moved.contains(*object as usize) && {
                let baked = &self.maps.surfaces[matched.surface as usize];
                let place = meshes.get(matched.entity).ok();
                let place = place.and_then(|(_, place, ..)| place.exact_affine());
                !place.is_some_and(|place| is_same_place(&baked.world_from_local, &place))
            }
        };
        // Missing objects may have come back.
        self.missing > 0 || self.matched.iter().zip(&self.objects).any(has_left)
    }

    /// Looks for the surfaces among all objects. Returns whether others are matched than before.
    pub(super) fn find(
        &mut self,
        objects: &Objects,
        meshes: &Meshes,
        culling: FaceCulling,
        hashes: &mut MeshHashes,
    ) -> bool {
        self.searched = Some((generations(objects), culling));
        self.strangers = 0;
        self.without_backs = 0;
        self.outside.clear();
        self.strange_casters.clear();
        self.strange_casters.grow(objects.len());
        let mut found = std::mem::take(&mut self.found);
        found.clear();
        let mut is_found = vec![false; self.maps.surfaces.len()];
        for (object, &entity) in objects.entities.iter().enumerate() {
            let object_of = meshes.get(entity).ok();
            let placed = object_of.and_then(|(mesh, place, is_caster, layers, materials)| {
                Some((mesh, place.exact_affine()?, is_caster, layers, materials))
            });
            let Some((mesh, place, is_caster, layers, materials)) = placed else {
                self.outside.push(object as u32);
                self.strange_casters.insert(object);
                continue;
            };
            let casts = is_caster && layers.copied().unwrap_or_default().0 & self.casts_for != 0;
            let shows_shadows = objects.receivers.contains(object) && objects.drawn.contains(object);
            let (mut is_stranger, mut lacks_backs) = (false, false);
            for (submesh, hash) in hashes.of(&mesh.0).iter().enumerate() {
                let candidates = self.by_hash.get(hash).map_or(&[][..], |found| found);
                let here = |&&at: &&u32| {
                    let baked = &self.maps.surfaces[at as usize];
                    baked.casts == casts && is_same_place(&baked.world_from_local, &place)
                };
                // Two equal surfaces at one place see the same.
                let fresh = candidates.iter().filter(here).find(|&&at| !is_found[at as usize]);
                let Some(&surface) = fresh.or_else(|| candidates.iter().find(here)) else {
                    is_stranger = true;
                    self.strange_casters.insert(object);
                    continue;
                };
                is_found[surface as usize] = true;
                let baked = &self.maps.surfaces[surface as usize];
                let material = materials.and_then(|materials| materials.0.get(submesh));
                if shows_shadows
                    && is_lit(material)
                    && !mesh.0.submesh_range(&mesh.0.submeshes[submesh]).is_empty()
                {
                    let shows_backs = culling == FaceCulling::None
                        || material.is_some_and(|material| material.double_sided);
                    is_stranger |= baked.corners.is_empty();
                    lacks_backs |= shows_backs && !baked.is_two_sided && !baked.corners.is_empty();
                }
                let submesh = submesh as u32;
                let matched = MatchedSurface {
                    surface,
                    entity,
                    submesh,
                };
                found.push((matched, object as u32));
            }
            if is_stranger {
                self.outside.push(object as u32);
            }
            self.strangers += usize::from(is_stranger && shows_shadows);
            self.without_backs += usize::from(lacks_backs);
        }
        self.strange_receivers.clear();
        self.strange_receivers.grow(objects.len());
        self.strange_receivers
            .extend(self.outside.iter().map(|object| *object as usize));
        found.sort_unstable();
        self.missing = is_found.iter().filter(|found| !**found).count();
        self.first_missing = is_found.iter().position(|found| !found);
        self.objects.clear();
        self.objects.extend(found.iter().map(|(_, object)| object));
        let matched = || found.iter().map(|(matched, _)| *matched);
        let is_changed = !matched().eq(self.matched.iter().copied());
        if is_changed {
            self.matched.clear();
            self.matched.extend(matched());
        }
        self.found = found;
        is_changed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_keep_no_mesh_alive() {
        let mut hashes = MeshHashes::default();
        let mesh = Arc::new(MeshData::plane(1.0));
        let kept = Arc::new(MeshData::plane(1.0));
        assert_eq!(hashes.of(&mesh).to_vec(), hashes.of(&kept).to_vec());
        let watched = Arc::downgrade(&mesh);
        drop(mesh);
        assert!(watched.upgrade().is_none(), "its data is freed");
        hashes.forget_unused();
        assert_eq!(hashes.len(), 1);
    }
}
