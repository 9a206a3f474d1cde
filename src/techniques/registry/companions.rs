//! Companions: the second technique of a light, which shadows by what the first one does not know.
//!
//! ```text
//! light with two techniques ─► two entities with the second one ─► lights of the frame ─► sets, silhouettes, … as any light
//!                                                                  └─ limited to what the first technique leaves
//! ```
//!
//! One companion shadows the receivers that the first technique knows, from the casters that it does not know; the darker of
//! both visibilities counts. The other shadows all other receivers, from all casters. Both are lights to every stage but the
//! last: the renderer adds no light for them, and darkens the mask of their light instead.

use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;

use super::row::Row;
use super::techniques::Techniques;
use crate::scene::Light;
use crate::sets::{ActsOn, CompanionOf, CompanionPart, FrameLights};

/// A light with two techniques, and its entities.
#[derive(Clone, Copy, Debug)]
struct Pair {
    light: Entity,
    /// The second technique.
    second: Row,
    /// The companions for receivers that the first technique knows, and for all others.
    companions: [Option<Entity>; 2],
}

/// Memory of [`keep_companions`] that is kept for its allocation.
#[derive(Debug, Default)]
pub struct CompanionScratch {
    pairs: Vec<Pair>,
    gone: Vec<Entity>,
}

/// The techniques of a light that work together.
pub(super) struct Chosen<'a> {
    /// The technique of the light.
    pub first: (usize, &'a Row),
    /// The technique that shadows by what the first one leaves.
    pub second: Option<(usize, &'a Row)>,
}

/// Chooses the techniques of a light among those whose components are on it, in the order of the list. A technique that leaves
/// objects to another one comes first.
pub(super) fn chosen<'a>(rows: impl Iterator<Item = (usize, &'a Row)> + Clone) -> Option<Chosen<'a>> {
    let leaving = rows.clone().find(|(_, row)| row.leaves_others());
    let others = || rows.clone().find(|(_, row)| !row.leaves_others());
    match leaving {
        Some(first) => Some(Chosen {
            first,
            second: others(),
        }),
        None => Some(Chosen {
            first: others()?,
            second: None,
        }),
    }
}

/// Spawns the companions of lights with two techniques, keeps their settings equal to those of the second technique, and
/// despawns them with the light or one of the techniques.
///
/// Set: `CollectSets`, before `collect_frame_lights`. The system is exclusive, because the list of techniques determines which
/// components it reads. It tests archetypes, not single entities, and a frame in which no setting changes writes nothing.
pub fn keep_companions(
    world: &mut World,
    companions: &mut QueryState<(Entity, &CompanionOf)>,
    mut scratch: Local<CompanionScratch>,
) {
    let CompanionScratch { pairs, gone } = &mut *scratch;
    pairs.clear();
    gone.clear();
    find_pairs(world, pairs);
    pairs.sort_unstable_by_key(|pair| pair.light);
    for (entity, of) in companions.iter(world) {
        let pair = pairs.binary_search_by_key(&of.light, |pair| pair.light);
        match pair {
            Ok(at) if pairs[at].companions[of.part as usize].is_none() => {
                pairs[at].companions[of.part as usize] = Some(entity);
            }
            _ => gone.push(entity),
        }
    }
    for entity in gone.drain(..) {
        world.despawn(entity);
    }
    for pair in pairs.iter() {
        for part in [CompanionPart::Known, CompanionPart::Others] {
            let of = CompanionOf {
                light: pair.light,
                part,
            };
            let entity = pair.companions[part as usize].unwrap_or_else(|| world.spawn(of).id());
            follow(world, pair, entity);
        }
    }
}

/// Lists the lights with two techniques of which the first leaves objects to the second.
fn find_pairs(world: &World, pairs: &mut Vec<Pair>) {
    let techniques = world.resource::<Techniques>();
    let components = world.components();
    let id_of = |row: &Row| components.get_id(row.component());
    let (Some(light), true) = (
        world.component_id::<Light>(),
        techniques
            .rows
            .iter()
            .any(|row| row.leaves_others() && id_of(row).is_some()),
    ) else {
        return;
    };
    for archetype in world
        .archetypes()
        .iter()
        .filter(|archetype| archetype.contains(light))
    {
        let has = |id: Option<ComponentId>| id.is_some_and(|id| archetype.contains(id));
        let rows = techniques.rows.iter().enumerate();
        let on_light = rows.filter(|(_, row)| has(id_of(row)));
        if let Some((_, second)) = chosen(on_light).and_then(|chosen| chosen.second) {
            pairs.extend(archetype.entities().iter().map(|entity| Pair {
                light: entity.id(),
                second: *second,
                companions: [None; 2],
            }));
        }
    }
}

/// Makes the techniques of a companion equal to the second one of its light.
fn follow(world: &mut World, pair: &Pair, companion: Entity) {
    let techniques = world.resource::<Techniques>();
    let (Ok(light), Ok(entity)) = (world.get_entity(pair.light), world.get_entity(companion)) else {
        return;
    };
    let is_other = |row: &&Row| **row != pair.second && row.is_on(&entity);
    let other = techniques.rows.iter().copied().find(|row| is_other(&row));
    let settings = if pair.second.is_same(&light, &entity) {
        None
    } else {
        pair.second.settings_of(&light)
    };
    if other.is_none() && settings.is_none() {
        return;
    }
    let Ok(mut entity) = world.get_entity_mut(companion) else {
        return;
    };
    if let Some(row) = other {
        row.remove(&mut entity); // a companion has one at a time
    }
    if let Some(settings) = settings {
        settings.insert(&mut entity);
    }
}

/// Limits every companion to the objects that the technique of its light leaves.
///
/// Set: `CollectSets`, after [`LeavingSystems`](super::LeavingSystems) and before the sets of lights. The system is exclusive,
/// because a technique reads whatever it likes. Writes [`FrameLight::acts_on`](crate::sets::FrameLight::acts_on) where that
/// changed. Cost: the words of two sets of all objects for each companion.
pub fn limit_companions(world: &mut World) {
    let count = world.resource::<FrameLights>().lights.len();
    let first = world.resource::<FrameLights>().scene_count();
    for at in first..count {
        let mut acts_on = {
            let mut frame = world.resource_mut::<FrameLights>();
            let frame = frame.bypass_change_detection();
            std::mem::take(&mut frame.lights[at].acts_on)
        };
        let changed = limit(world, at, &mut acts_on);
        let mut frame = world.resource_mut::<FrameLights>();
        let light = &mut frame.bypass_change_detection().lights[at];
        light.acts_on = acts_on;
        if changed {
            light.moved = true; // everything that is known of it must be computed again
            frame.set_changed();
        }
    }
}

/// Brings the choice of objects of the light at `at` up to date. Returns whether it changed.
fn limit(world: &World, at: usize, acts_on: &mut ActsOn) -> bool {
    let frame = world.resource::<FrameLights>();
    let Some(of) = frame.lights[at]
        .companion_of
        .filter(|_| frame.lights[at].technique.is_some())
    else {
        return false;
    };
    let of_light = frame
        .of_scene()
        .binary_search_by_key(&of.light, |light| light.entity);
    let Some((light, technique)) = of_light
        .ok()
        .and_then(|light| Some((light, frame.lights[light].technique?)))
    else {
        return false;
    };
    let row = world.resource::<Techniques>().rows[technique.row];
    acts_on.follow(of.part, row.left_to_others(world, light))
}
