//! The extraction of silhouettes, kept until the light, the caster or its pose moves.

use std::sync::Arc;

use bevy_ecs::prelude::*;
use glam::{DMat4, DVec4, Vec4};

use super::caster_shape::{CasterShape, CasterShapeItem};
use super::coincident::CoincidentCasters;
use super::flush::find_flush_edges;
use super::grazed::{GrazingLight, find_grazed, take_out_of_contour};
use super::light_silhouettes::{LightSilhouettes, Scratch, Silhouette, Silhouettes};
use super::stacks::stacked_boxes;
use super::{CapMode, classify, extract_contour};
use crate::geometry::Aabb;
use crate::sets::{FrameLight, FrameLights, NeededSilhouettes, Objects, SeenInto};

/// Extracts the silhouettes that the technique of each light needs, of set S or of all casters that the light reaches
/// ([`NeededSilhouettes`]), where they are not known yet or are stale.
///
/// Casters that coincide with another one of the light are left out ([`CoincidentCasters`]).
///
/// Set: `BuildSilhouettes`. Reads [`FrameLights`], [`Objects`], [`SeenInto`]; writes [`Silhouettes`].
///
/// A silhouette is stale when the caster was posed, when its mesh was exchanged, when the camera or the light
/// entered or left its bounds or its transform began or ceased to flatten it ([`CapMode`]), or when the light has
/// another position in the caster's space.
/// Change ticks of light and caster select the pairs to check; the check itself compares values, so a light
/// and a caster that move together keep their silhouette.
pub fn build_silhouettes(
    mut silhouettes: ResMut<Silhouettes>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    seen_into: Res<SeenInto>,
    coincident: Res<CoincidentCasters>,
    casters: Query<CasterShape>,
) {
    let Silhouettes {
        lights: kept,
        scratch,
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
                kept.insert(at, LightSilhouettes::new(light.entity));
                at
            });
        let entry = &mut kept[at];
        entry.remap(&objects);
        let before = *extracted;
        let is_shadowing = needed == NeededSilhouettes::Shadowing;
        let shadowing = is_shadowing.then(|| light.sets.s.ones());
        let reached = (needed == NeededSilhouettes::Reached).then(|| light.reached_casters(&objects));
        let needed = shadowing
            .into_iter()
            .flatten()
            .chain(reached.into_iter().flatten());
        let reached = if is_shadowing {
            &light.sets.s
        } else {
            &light.sets.l
        };
        for object in needed {
            if coincident
                .stands_for(object)
                .is_some_and(|kept| reached.contains(kept))
            {
                entry.forget(object);
                continue;
            }
            let entity = objects.entities[object];
            let Ok(caster) = casters.get(entity) else {
                entry.forget(object); // its mesh was exchanged for one without edges
                continue;
            };
            let bounds = objects.boxes.get(object);
            let light_within = light_is_within(&bounds, light.point_world, light.clearance);
            let pair = Pair {
                light_world: light.point_world,
                clearance: if light_within { light.clearance } else { 0.0 },
                light_within,
                mode: cap_mode(light_within || seen_into.0.contains(object), caster.is_flat()),
                may_have_moved: light.moved || objects.moved.contains(object),
            };
            let slot = entry.slot_for(object, entity);
            match update(&mut entry.slots[slot], &pair, &caster, *frame, scratch) {
                Updated::Current => {}
                Updated::Extracted => {
                    *last_revision += 1;
                    *extracted += 1;
                    entry.slots[slot].revision = *last_revision;
                }
                Updated::Impossible => entry.forget(object),
            }
        }
        count_stacked(entry, light, &objects, *extracted > before, &mut scratch.boxes);
        entry.forget_unused(*frame, &objects);
        if std::mem::take(&mut entry.is_changed) || *extracted > before {
            *last_revision += 1;
            entry.revision = *last_revision;
        }
    }
    // Lights that are gone, and those whose technique needs none any more, take their silhouettes with them.
    kept.retain(|entry| {
        lights
            .of_entity(entry.light)
            .is_some_and(|light| light.needs().silhouettes != NeededSilhouettes::None)
    });
}

/// One caster in one light, as far as its silhouette depends on them.
struct Pair {
    light_world: DVec4,
    /// Metres from the light within which surfaces do not block it; 0 if none of the caster's can be there.
    clearance: f64,
    light_within: bool,
    mode: CapMode,
    /// Whether the light or the caster may have moved in this frame.
    may_have_moved: bool,
}

/// The outcome of updating a silhouette.
enum Updated {
    /// The silhouette is the one of the last frame.
    Current,
    /// The silhouette is new and needs a revision.
    Extracted,
    /// The caster has no silhouette, because its transform has no inverse.
    Impossible,
}

/// Extracts the silhouette of one pair, unless it is known.
fn update(
    silhouette: &mut Silhouette,
    pair: &Pair,
    caster: &CasterShapeItem,
    frame: u64,
    scratch: &mut Scratch,
) -> Updated {
    // Change ticks cover this frame only, so a silhouette that was not used in the last frame is checked by value.
    let watched = silhouette.last_used + 1 == frame;
    silhouette.last_used = frame;
    let known = silhouette.revision != 0
        && silhouette.mode == pair.mode
        && silhouette.clearance == pair.clearance
        && silhouette
            .source
            .as_ref()
            .is_some_and(|source| Arc::ptr_eq(source, &caster.edges.0));
    if known && watched && !pair.may_have_moved {
        return Updated::Current;
    }
    let in_local = caster
        .world_from_local()
        .and_then(|matrix| Some((matrix, light_in_local(&matrix, pair.light_world)?)));
    let Some((world_from_local, light_local)) = in_local else {
        return Updated::Impossible;
    };
    if known && !caster.is_posed() && silhouette.light_local == light_local {
        return Updated::Current;
    }
    extract(silhouette, pair, caster, &world_from_local, light_local, scratch);
    Updated::Extracted
}

fn extract(
    silhouette: &mut Silhouette,
    pair: &Pair,
    caster: &CasterShapeItem,
    world_from_local: &DMat4,
    light_local: Vec4,
    scratch: &mut Scratch,
) {
    let Scratch { bits, grazed, .. } = scratch;
    let (mesh, mode) = (&caster.edges.0, pair.mode);
    classify(&mesh.edges, caster.planes(), light_local, bits);
    extract_contour(&mesh.edges, bits, mode, &mut silhouette.contour);
    grazed.clear();
    if pair.light_within {
        let grazing = GrazingLight {
            light_world: pair.light_world,
            light_local,
            world_from_local,
            clearance: pair.clearance,
        };
        let (planes, positions) = (caster.planes(), caster.positions());
        find_grazed(&mesh.edges, planes, positions, &grazing, grazed);
        take_out_of_contour(&mesh.edges, bits, mode, grazed, &mut silhouette.contour);
        let flush = &mut silhouette.contour.flush_edges;
        find_flush_edges(&mesh.edges, planes, positions, &grazing, grazed, flush);
    }
    let sides = match mode {
        CapMode::AllTriangles if mesh.edges.closed_cluster_count() > 0 => 2,
        _ => 1,
    };
    silhouette.stacked = stacked_boxes(light_local.as_dvec4(), &mesh.pieces).max(1) * sides;
    silhouette.light_local = light_local;
    silhouette.mode = mode;
    silhouette.clearance = pair.clearance;
    silhouette.source = Some(mesh.clone());
}

/// Updates [`LightSilhouettes::stacked`], unless nothing that it depends on has changed.
fn count_stacked(
    entry: &mut LightSilhouettes,
    light: &FrameLight,
    objects: &Objects,
    extracted: bool,
    boxes: &mut Vec<(Aabb, u32)>,
) {
    let s = &light.sets.s;
    let (set, layout) = &mut entry.stacked_of;
    let same_members = *layout == objects.layout_generation && set == s;
    // The silhouette of a caster that moves along a directional light stays, but its box does not.
    if !extracted && same_members && objects.moved.is_disjoint(s) {
        return;
    }
    set.clone_from(s);
    *layout = objects.layout_generation;
    boxes.clear();
    boxes.extend(s.ones().filter_map(|object| {
        let (_, silhouette) = entry.of_object(object)?;
        Some((objects.boxes.get(object), silhouette.stacked))
    }));
    entry.stacked = stacked_boxes(light.point_world, boxes);
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
/// detected from a volume. Nothing is inside of a flat caster.
fn cap_mode(looked_or_lit_from_within: bool, is_flat: bool) -> CapMode {
    if is_flat {
        CapMode::ClosedFacing
    } else if looked_or_lit_from_within {
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
