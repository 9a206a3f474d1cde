//! Silhouettes of (light, caster) pairs, kept until the light, the caster or its pose moves.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::{DMat4, DVec4, Vec4};

use super::caster_shape::CasterShape;
use super::casters::CasterMesh;
use super::grazed::{GrazingLight, LightClearance, find_grazed, take_out_of_contour};
use super::stacks::stacked_boxes;
use super::{CapMode, Contour, FacingBits, classify, extract_contour};
use crate::geometry::Aabb;
use crate::sets::{FrameLights, NeededSilhouettes, Objects, SeenInto};

/// Frames that a silhouette is kept after its last use. A light that flickers in and out of view does not pay
/// each time, and memory follows what is looked at. Chosen by eye.
const KEPT_FRAMES: u64 = 120;

/// Marks an object without a silhouette.
const NONE: u32 = u32::MAX;

/// The silhouette of one caster in one light.
#[derive(Debug)]
pub struct Silhouette {
    /// The caster.
    pub entity: Entity,
    /// The light as a homogeneous point in the caster's space, for which the silhouette was extracted.
    pub light_local: Vec4,
    /// Which triangles stand for the caster.
    pub mode: CapMode,
    /// Metres from the light within which surfaces do not block it.
    pub clearance: f64,
    /// Number of pieces of the caster that lie one behind the other, estimated from bounding boxes. Both sides of a
    /// piece count where all triangles are caps.
    pub stacked: u32,
    /// Edges and caps.
    pub contour: Contour,
    /// Unique among all silhouettes ever extracted, so a copy can detect that it is stale. 0 marks a free
    /// slot.
    pub revision: u64,
    source: Option<Arc<CasterMesh>>,
    last_used: u64,
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
    /// Set S and the layout of its indices for which `stacked` was computed.
    stacked_of: (FixedBitSet, u64),
    slot_of: Vec<u32>,
    free: Vec<u32>,
    layout_generation: u64,
}

/// The silhouettes of this frame. Written by `build_silhouettes`.
#[derive(Resource, Debug, Default)]
pub struct Silhouettes {
    lights: Vec<LightSilhouettes>,
    bits: FacingBits,
    grazed: Vec<u64>,
    boxes: Vec<(Aabb, u32)>,
    frame: u64,
    last_revision: u64,
    /// Silhouettes extracted in this frame; 0 when nothing moved.
    pub extracted: usize,
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
    /// Returns slot and silhouette of the object with this dense index, if it has a silhouette in this light.
    pub fn of_object(&self, object: usize) -> Option<(usize, &Silhouette)> {
        let slot = *self.slot_of.get(object).filter(|slot| **slot != NONE)? as usize;
        Some((slot, &self.slots[slot]))
    }

    /// Rebuilds the map from dense indices to slots when objects came or went.
    fn remap(&mut self, objects: &Objects) {
        if self.layout_generation == objects.layout_generation && self.slot_of.len() == objects.len() {
            return;
        }
        self.layout_generation = objects.layout_generation;
        self.slot_of.clear();
        self.slot_of.resize(objects.len(), NONE);
        for (slot, silhouette) in self.slots.iter_mut().enumerate() {
            if silhouette.revision == 0 {
                continue;
            }
            match objects.index_of(silhouette.entity) {
                Some(object) => self.slot_of[object] = slot as u32,
                None => {
                    silhouette.revision = 0;
                    self.free.push(slot as u32);
                }
            }
        }
    }

    fn slot_for(&mut self, object: usize, entity: Entity) -> usize {
        if self.slot_of[object] != NONE {
            return self.slot_of[object] as usize;
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
        self.slot_of[object] = slot as u32;
        slot
    }

    fn forget(&mut self, object: usize) {
        let slot = std::mem::replace(&mut self.slot_of[object], NONE);
        if slot != NONE {
            self.slots[slot as usize].revision = 0;
            self.free.push(slot);
        }
    }

    fn forget_unused(&mut self, frame: u64, objects: &Objects) {
        for (slot, silhouette) in self.slots.iter_mut().enumerate() {
            if silhouette.revision != 0 && silhouette.last_used + KEPT_FRAMES < frame {
                silhouette.revision = 0;
                silhouette.source = None;
                silhouette.contour = Contour::default();
                self.free.push(slot as u32);
                if let Some(object) = objects.index_of(silhouette.entity) {
                    self.slot_of[object] = NONE;
                }
            }
        }
    }
}

/// Extracts the silhouettes that the technique of each light needs, of set S or of all casters that the light reaches
/// ([`NeededSilhouettes`]), where they are not known yet or are stale.
///
/// Set: `BuildSilhouettes`. Reads [`FrameLights`], [`Objects`], [`SeenInto`]; writes [`Silhouettes`].
///
/// A silhouette is stale when the caster was posed, when its mesh was exchanged, when the camera or the light
/// entered or left its bounds ([`CapMode`]), or when the light has another position in the caster's space.
/// Change ticks of light and caster select the pairs to check; the check itself compares values, so a light
/// and a caster that move together keep their silhouette.
pub fn build_silhouettes(
    mut silhouettes: ResMut<Silhouettes>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    seen_into: Res<SeenInto>,
    clearance: Res<LightClearance>,
    casters: Query<CasterShape>,
) {
    let Silhouettes {
        lights: kept,
        bits,
        grazed,
        boxes,
        frame,
        last_revision,
        extracted,
    } = &mut *silhouettes;
    *frame += 1;
    *extracted = 0;
    for light in &lights.lights {
        let needed = light.needs().silhouettes;
        if needed == NeededSilhouettes::None {
            continue;
        }
        let at = kept
            .binary_search_by_key(&light.entity, |entry| entry.light)
            .unwrap_or_else(|at| {
                kept.insert(
                    at,
                    LightSilhouettes {
                        light: light.entity,
                        slots: Vec::new(),
                        stacked: 0,
                        stacked_of: Default::default(),
                        slot_of: Vec::new(),
                        free: Vec::new(),
                        layout_generation: 0,
                    },
                );
                at
            });
        let entry = &mut kept[at];
        entry.remap(&objects);
        let mut changed = false;
        let shadowing = (needed == NeededSilhouettes::Shadowing).then(|| light.sets.s.ones());
        let reached = (needed == NeededSilhouettes::Reached).then(|| light.reached_casters(&objects));
        for object in shadowing
            .into_iter()
            .flatten()
            .chain(reached.into_iter().flatten())
        {
            let entity = objects.entities[object];
            let Ok(caster) = casters.get(entity) else {
                continue;
            };
            let point = light.point_world;
            let bounds = objects.boxes.get(object);
            let clearance = clearance.metres(point, light.light.range, &bounds);
            let light_within = light_is_within(&bounds, point, clearance);
            let mode = cap_mode(light_within || seen_into.0.contains(object));
            let slot = entry.slot_for(object, entity);
            let silhouette = &mut entry.slots[slot];
            // Change ticks cover this frame only, so a silhouette that was not used in the last frame is
            // checked by value.
            let watched = silhouette.last_used + 1 == *frame;
            silhouette.last_used = *frame;
            let known = silhouette.revision != 0
                && silhouette.mode == mode
                && silhouette.clearance == clearance
                && silhouette
                    .source
                    .as_ref()
                    .is_some_and(|source| Arc::ptr_eq(source, &caster.edges.0));
            if known && watched && !light.moved && !objects.moved.contains(object) {
                continue;
            }
            let in_local = caster
                .world_from_local()
                .and_then(|matrix| Some((matrix, light_in_local(&matrix, light.point_world)?)));
            let Some((world_from_local, light_local)) = in_local else {
                entry.forget(object);
                continue;
            };
            if known && !caster.is_posed() && silhouette.light_local == light_local {
                continue;
            }
            let edges = caster.edges;
            classify(&edges.0.edges, caster.planes(), light_local, bits);
            extract_contour(&edges.0.edges, bits, mode, &mut silhouette.contour);
            grazed.clear();
            if light_within {
                let grazing = GrazingLight {
                    light_world: point,
                    light_local,
                    world_from_local: &world_from_local,
                    clearance,
                };
                let (planes, positions) = (caster.planes(), caster.positions());
                find_grazed(&edges.0.edges, planes, positions, &grazing, grazed);
                take_out_of_contour(&edges.0.edges, bits, mode, grazed, &mut silhouette.contour);
            }
            *last_revision += 1;
            *extracted += 1;
            silhouette.revision = *last_revision;
            silhouette.light_local = light_local;
            silhouette.mode = mode;
            silhouette.clearance = clearance;
            let sides = match mode {
                CapMode::AllTriangles if edges.0.edges.closed_cluster_count() > 0 => 2,
                _ => 1,
            };
            silhouette.stacked = stacked_boxes(light_local.as_dvec4(), &edges.0.pieces).max(1) * sides;
            changed = true;
            silhouette.source = Some(edges.0.clone());
        }
        let (set, layout) = &mut entry.stacked_of;
        let same_members = *layout == objects.layout_generation && *set == light.sets.s;
        // The silhouette of a caster that moves along a directional light stays, but its box does not.
        if changed || !same_members || !objects.moved.is_disjoint(&light.sets.s) {
            set.clone_from(&light.sets.s);
            *layout = objects.layout_generation;
            boxes.clear();
            boxes.extend(light.sets.s.ones().filter_map(|object| {
                let (_, silhouette) = entry.of_object(object)?;
                Some((objects.boxes.get(object), silhouette.stacked))
            }));
            entry.stacked = stacked_boxes(light.point_world, boxes);
        }
        entry.forget_unused(*frame, &objects);
    }
    // Lights that are gone, and those whose technique needs none any more, take their silhouettes with them.
    kept.retain(|entry| {
        lights
            .of_entity(entry.light)
            .is_some_and(|light| light.needs().silhouettes != NeededSilhouettes::None)
    });
}

/// Whether a light is within a caster's bounds, or nearer to them than its clearance.
pub fn light_is_within(bounds: &Aabb, light_world: DVec4, clearance: f64) -> bool {
    let light = light_world.truncate();
    light_world.w != 0.0
        && (bounds.contains(light.as_vec3())
            || light.distance(light.clamp(bounds.min.as_dvec3(), bounds.max.as_dvec3())) <= clearance)
}

/// Back-facing triangles suffice for a caster unless the camera or the light may be inside it; then all
/// triangles are caps. A light inside matters for pieces that are partly wound inward, which cannot be
/// detected from a volume.
fn cap_mode(looked_or_lit_from_within: bool) -> CapMode {
    if looked_or_lit_from_within {
        CapMode::AllTriangles
    } else {
        CapMode::ClosedBackFacing
    }
}

/// Transforms the light to a homogeneous point in a caster's space, in `f64`; `None` for a transform without
/// inverse.
pub fn light_in_local(world_from_local: &DMat4, light_world: DVec4) -> Option<Vec4> {
    let determinant = world_from_local.determinant();
    if !(determinant.is_finite() && determinant != 0.0) {
        return None;
    }
    let local = (world_from_local.inverse() * light_world).as_vec4();
    // An affine map keeps w; this removes its rounding error.
    let local = Vec4::new(local.x, local.y, local.z, light_world.w as f32);
    local.is_finite().then_some(local)
}
