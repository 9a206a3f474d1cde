//! Silhouettes by light and caster, in slots that stay valid from frame to frame.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::Vec4;

use super::casters::CasterMesh;
use super::object_slots::ObjectSlots;
use super::{CapMode, Contour, FacingBits};
use crate::geometry::Aabb;
use crate::sets::Objects;

/// Number of frames that a silhouette, and everything that a technique derives from it, is kept after its last use.
/// A light that flickers in and out of view does not pay each time, and memory follows the view. Chosen by eye.
pub const KEPT_FRAMES: u64 = 120;

/// The silhouette of one caster in one light.
#[derive(Debug)]
pub struct Silhouette {
    /// The caster.
    pub entity: Entity,
    /// The light as a homogeneous point in the caster's space, for which the silhouette was extracted.
    pub light_local: Vec4,
    /// Which triangles stand for the caster.
    pub mode: CapMode,
    /// Metres from the light within which surfaces do not block it; 0 if none of the caster's can be there.
    pub clearance: f64,
    /// Number of pieces of the caster that lie one behind the other, estimated from bounding boxes. Both sides of a
    /// piece count where all triangles are caps.
    pub stacked: u32,
    /// Edges and caps.
    pub contour: Contour,
    /// Unique among all silhouettes ever extracted, so a copy can detect that it is stale. 0 marks a free
    /// slot.
    pub revision: u64,
    pub(super) source: Option<Arc<CasterMesh>>,
    pub(super) last_used: u64,
}

impl Silhouette {
    /// Marks the slot as free, and gives back the memory of what it held.
    fn clear(&mut self) {
        self.revision = 0;
        self.source = None;
        self.contour = Contour::default();
    }
}

/// The silhouettes in one light.
#[derive(Debug)]
pub struct LightSilhouettes {
    /// The light.
    pub light: Entity,
    /// Slots, used and free; an index stays valid until its pair is forgotten.
    pub slots: Vec<Silhouette>,
    /// Largest sum of [`Silhouette::stacked`] over casters that lie one behind the other: the range of counts that a
    /// technique needs. It is an estimate from bounding boxes, so it does not know of folds within a piece.
    pub stacked: u32,
    /// Changes when a silhouette of the light is extracted or forgotten, and is unique among all lights and frames. So whoever
    /// copied the light's silhouettes need not look at each of them to find that the copies are up to date.
    pub revision: u64,
    /// Whether a silhouette was extracted or forgotten since `revision` changed.
    pub(super) is_changed: bool,
    /// Set S and the layout of its indices for which `stacked` was computed.
    pub(super) stacked_of: (FixedBitSet, u64),
    slot_of: ObjectSlots,
    free: Vec<u32>,
    layout_generation: u64,
}

/// The silhouettes of this frame. Written by `build_silhouettes`.
#[derive(Resource, Debug, Default)]
pub struct Silhouettes {
    pub(super) lights: Vec<LightSilhouettes>,
    pub(super) scratch: Scratch,
    pub(super) frame: u64,
    pub(super) last_revision: u64,
    /// Silhouettes extracted in this frame; 0 when nothing moved.
    pub extracted: usize,
}

/// Working memory of the extraction, kept for its allocations.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    pub bits: FacingBits,
    pub grazed: Vec<u64>,
    pub boxes: Vec<(Aabb, u32)>,
}

impl Silhouettes {
    /// Returns the silhouettes in a light; `None` if the light never needed any.
    pub fn of_light(&self, light: Entity) -> Option<&LightSilhouettes> {
        let at = self
            .lights
            .binary_search_by_key(&light, |entry| entry.light)
            .ok()?;
        Some(&self.lights[at])
    }

    /// Returns the silhouettes of all lights, ascending by light.
    pub fn lights(&self) -> &[LightSilhouettes] {
        &self.lights
    }
}

impl LightSilhouettes {
    pub(super) fn new(light: Entity) -> Self {
        Self {
            light,
            slots: Vec::new(),
            stacked: 0,
            revision: 0,
            is_changed: false,
            stacked_of: Default::default(),
            slot_of: ObjectSlots::default(),
            free: Vec::new(),
            layout_generation: 0,
        }
    }

    /// Returns slot and silhouette of the object with this dense index, if it has a silhouette in this light.
    pub fn of_object(&self, object: usize) -> Option<(usize, &Silhouette)> {
        let slot = self.slot_of.get(object)?;
        Some((slot, &self.slots[slot]))
    }

    /// Rebuilds the map from dense indices to slots when objects came or went. Cost then: O(objects / 64), and the silhouettes.
    pub(super) fn remap(&mut self, objects: &Objects) {
        if self.layout_generation == objects.layout_generation && self.slot_of.len() == objects.len() {
            return;
        }
        self.layout_generation = objects.layout_generation;
        self.slot_of.reset(objects.len());
        for (slot, silhouette) in self.slots.iter_mut().enumerate() {
            if silhouette.revision == 0 {
                continue;
            }
            match objects.index_of(silhouette.entity) {
                Some(object) => self.slot_of.set(object, slot),
                None => {
                    self.is_changed = true;
                    silhouette.clear();
                    self.free.push(slot as u32);
                }
            }
        }
    }

    pub(super) fn slot_for(&mut self, object: usize, entity: Entity) -> usize {
        if let Some(slot) = self.slot_of.get(object) {
            return slot;
        }
        let slot = self.free.pop().map_or(self.slots.len(), |slot| slot as usize);
        if slot == self.slots.len() {
            self.slots.push(Silhouette {
                entity,
                light_local: Vec4::ZERO,
                mode: CapMode::default(),
                clearance: 0.0,
                stacked: 0,
                contour: Contour::default(),
                revision: 0,
                source: None,
                last_used: 0,
            });
        }
        self.slots[slot].entity = entity;
        self.slots[slot].source = None;
        self.slot_of.set(object, slot);
        slot
    }

    pub(super) fn forget(&mut self, object: usize) {
        if let Some(slot) = self.slot_of.take(object) {
            self.is_changed |= self.slots[slot].revision != 0;
            self.slots[slot].clear();
            self.free.push(slot as u32);
        }
    }

    pub(super) fn forget_unused(&mut self, frame: u64, objects: &Objects) {
        for (slot, silhouette) in self.slots.iter_mut().enumerate() {
            if silhouette.revision != 0 && silhouette.last_used + KEPT_FRAMES < frame {
                self.is_changed = true;
                silhouette.clear();
                self.free.push(slot as u32);
                if let Some(object) = objects.index_of(silhouette.entity) {
                    self.slot_of.take(object);
                }
            }
        }
    }
}
