//! Silhouettes of (light, caster) pairs, kept until the light, the caster or its pose moves.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DMat4, DVec4, Vec4};

use super::casters::{CasterEdges, CasterMesh, PosedPlanes};
use super::grazed::{GrazingLight, LightClearance, find_grazed, take_out_of_contour};
use super::stacks::stacked_boxes;
use super::{CapMode, Contour, FacingBits, classify, extract_contour};
use crate::geometry::Aabb;
use crate::scene::placement::Placement;
use crate::scene::{PosedMesh, SceneMesh};
use crate::sets::{FrameLights, Objects, SeenInto};

/// Marks lights whose technique is built on silhouettes.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct NeedsSilhouettes;

/// Frames that a pair's silhouette outlives its last use: a light that flickers in and out of view does not pay each
/// time, and memory follows what is looked at. By eye.
const KEPT_FRAMES: u64 = 120;

/// No silhouette.
const NONE: u32 = u32::MAX;

/// The silhouette of one caster in one light.
#[derive(Debug)]
pub struct Silhouette {
    /// The caster.
    pub entity: Entity,
    /// The light as a homogeneous point in the caster's space: what it was extracted for.
    pub light_local: Vec4,
    /// Which triangles stand for the caster.
    pub mode: CapMode,
    /// Metres from the light within which surfaces do not block it.
    pub clearance: f64,
    /// Pieces of the caster that lie one behind the other, about; both sides of a piece where all triangles are caps.
    pub stacked: u32,
    /// Edges and caps.
    pub contour: Contour,
    /// Unique among all silhouettes ever extracted; tells a copy of it whether it is stale. 0: the slot is free.
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
    /// The sum of [`Silhouette::stacked`] over casters that lie one behind the other, about: what a technique that counts
    /// needs room for. It says so from boxes, and knows nothing of a piece that is folded.
    pub stacked: u32,
    stacked_of: Option<(usize, u64)>,
    slot_of: Vec<u32>,
    free: Vec<u32>,
    layout_generation: u64,
}

/// The silhouettes of this frame. Written by [`build_silhouettes`].
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
    /// The silhouettes in a light; `None` if it never needed any.
    pub fn of_light(&self, light: Entity) -> Option<&LightSilhouettes> {
        let at = self
            .lights
            .binary_search_by_key(&light, |entry| entry.light)
            .ok()?;
        Some(&self.lights[at])
    }

    /// All lights, by entity.
    pub fn lights(&self) -> &[LightSilhouettes] {
        &self.lights
    }
}

impl LightSilhouettes {
    /// Slot and silhouette of the caster at a dense index, if it has one with something to cast.
    pub fn of_object(&self, object: usize) -> Option<(usize, &Silhouette)> {
        let slot = *self.slot_of.get(object).filter(|slot| **slot != NONE)? as usize;
        Some((slot, &self.slots[slot]))
    }

    /// Maps slots to dense indices anew when objects came or went.
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

type CasterItem<'a> = (
    &'a CasterEdges,
    &'a SceneMesh,
    Placement,
    Option<(&'a PosedMesh, &'a PosedPlanes)>,
);

/// Extracts the silhouettes of every light's set S that are not known yet or are stale.
///
/// Set: `BuildSilhouettes`. Reads [`FrameLights`], [`Objects`], [`SeenInto`]; writes [`Silhouettes`].
///
/// A pair is stale when the light or the caster moved (by change ticks) and the light stands elsewhere in the caster's
/// space for it (by value: what moves together keeps its silhouette), when the caster was posed or its mesh exchanged,
/// or when the camera or the light went into or out of its bounds ([`CapMode`]).
pub fn build_silhouettes(
    mut silhouettes: ResMut<Silhouettes>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    seen_into: Res<SeenInto>,
    clearance: Res<LightClearance>,
    wanting: Query<(), With<NeedsSilhouettes>>,
    casters: Query<CasterItem<'static>>,
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
        if !wanting.contains(light.entity) {
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
                        stacked_of: None,
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
        for object in light.s.ones() {
            let entity = objects.entities[object];
            let Ok((edges, mesh, place, posed)) = casters.get(entity) else {
                continue;
            };
            let point = light.point_world;
            let bounds = objects.boxes.get(object);
            let clearance = clearance.metres(point, light.light.range, &bounds);
            let light_within = light_is_within(&bounds, point, clearance);
            let mode = cap_mode(light_within || seen_into.0.contains(object));
            let slot = entry.slot_for(object, entity);
            let silhouette = &mut entry.slots[slot];
            // Change ticks tell of this frame only: what was not looked at in the last one is checked by value.
            let watched = silhouette.last_used + 1 == *frame;
            silhouette.last_used = *frame;
            let known = silhouette.revision != 0
                && silhouette.mode == mode
                && silhouette.clearance == clearance
                && silhouette
                    .source
                    .as_ref()
                    .is_some_and(|source| Arc::ptr_eq(source, &edges.0));
            if known && watched && !light.moved && !objects.moved.contains(object) {
                continue;
            }
            let in_local = place
                .world_from_local()
                .and_then(|matrix| Some((matrix, light_in_local(&matrix, light.point_world)?)));
            let Some((world_from_local, light_local)) = in_local else {
                entry.forget(object);
                continue;
            };
            if known && posed.is_none() && silhouette.light_local == light_local {
                continue;
            }
            let planes = match posed {
                Some((posed, planes)) if posed.positions.len() >= edges.0.edges.vertex_count() => &planes.0,
                _ => &edges.0.planes,
            };
            classify(&edges.0.edges, planes, light_local, bits);
            extract_contour(&edges.0.edges, bits, mode, &mut silhouette.contour);
            grazed.clear();
            if light_within {
                let positions = posed
                    .map(|(posed, _)| &posed.positions)
                    .filter(|positions| positions.len() >= edges.0.edges.vertex_count());
                let grazing = GrazingLight {
                    light_world: point,
                    light_local,
                    world_from_local: &world_from_local,
                    clearance,
                };
                let positions = positions.unwrap_or(&mesh.0.positions);
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
        let key = Some((light.s.count_ones(..), objects.layout_generation));
        if changed || entry.stacked_of != key {
            entry.stacked_of = key;
            boxes.clear();
            boxes.extend(light.s.ones().filter_map(|object| {
                let (_, silhouette) = entry.of_object(object)?;
                Some((objects.boxes.get(object), silhouette.stacked))
            }));
            entry.stacked = stacked_boxes(light.point_world, boxes);
        }
        entry.forget_unused(*frame, &objects);
    }
    // Lights that are gone take their silhouettes with them.
    kept.retain(|entry| wanting.contains(entry.light));
}

/// Whether a light is in a caster's bounds, or nearer to them than its clearance.
pub fn light_is_within(bounds: &Aabb, light_world: DVec4, clearance: f64) -> bool {
    let light = light_world.truncate();
    light_world.w != 0.0
        && (bounds.contains(light.as_vec3())
            || light.distance(light.clamp(bounds.min.as_dvec3(), bounds.max.as_dvec3())) <= clearance)
}

/// Back-facing triangles suffice for a caster unless the camera or the light may be inside of it: then all count.
/// Whether the light is inside matters to pieces that are wound inward in part, which no volume tells.
fn cap_mode(looked_or_lit_from_within: bool) -> CapMode {
    if looked_or_lit_from_within {
        CapMode::AllTriangles
    } else {
        CapMode::ClosedBackFacing
    }
}

/// The light as a homogeneous point in a caster's space, by way of f64; `None` for a transform without inverse.
pub fn light_in_local(world_from_local: &DMat4, light_world: DVec4) -> Option<Vec4> {
    let determinant = world_from_local.determinant();
    if !(determinant.is_finite() && determinant != 0.0) {
        return None;
    }
    let local = (world_from_local.inverse() * light_world).as_vec4();
    // An affine map keeps w, but for rounding.
    let local = Vec4::new(local.x, local.y, local.z, light_world.w as f32);
    local.is_finite().then_some(local)
}
