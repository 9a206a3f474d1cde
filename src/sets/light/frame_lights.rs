//! The lights of the frame.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;

use super::candidate::Candidate;
use super::companion::CompanionOf;
use super::frame_light::FrameLight;
use super::placing::place;
use crate::scene::{
    Cookie, Light, LightError, LightModel, LightModelFault, LightModelParts, LightProfile, LightSelection,
    LightTextures,
};

/// The lights of the frame. Written by [`collect_frame_lights`] and the systems after it.
#[derive(Resource, Clone, Debug, Default)]
pub struct FrameLights {
    /// All usable lights of the scene, in ascending order of their entities, and after them the companions
    /// ([`FrameLight::companion_of`]), in the order of the lights that they complete.
    pub lights: Vec<FrameLight>,
    /// All lights that cannot shine now, in ascending order of their entities.
    pub skipped: Vec<SkippedLight>,
    /// Parts of lights' models that are left out because their numbers cannot be used, in ascending order of
    /// the lights' entities.
    pub faults: Vec<(Entity, LightModelFault)>,
    /// Increases when lights were added to or removed from the list, which changes the meaning of indices
    /// into `lights`.
    pub generation: u64,
    /// The usable lights in the order of the query. A light whose values did not change is not placed again.
    candidates: Vec<Candidate>,
    /// Indices into the candidates, in the order of the lights of the frame.
    ascending: Vec<usize>,
    previous: Vec<FrameLight>,
}

/// A light that cannot shine, and the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SkippedLight {
    /// Entity of the light.
    pub entity: Entity,
    /// Why the light cannot shine.
    pub error: LightError,
}

impl FrameLights {
    /// The light of an entity, if it shines in this frame.
    pub fn of_entity(&self, entity: Entity) -> Option<&FrameLight> {
        let (of_scene, companions) = self.lights.split_at(self.scene_count());
        match of_scene.binary_search_by_key(&entity, |light| light.entity) {
            Ok(at) => Some(&of_scene[at]),
            Err(_) => companions.iter().find(|light| light.entity == entity),
        }
    }

    /// The number of lights of the scene, without companions. They are the first in the list.
    pub fn scene_count(&self) -> usize {
        self.lights.partition_point(|light| light.companion_of.is_none())
    }

    /// The lights of the scene, without companions.
    pub fn of_scene(&self) -> &[FrameLight] {
        &self.lights[..self.scene_count()]
    }

    /// The companions that complete the shadow of a light in this frame, with their indices in the list.
    pub fn companions_of(&self, light: Entity) -> impl Iterator<Item = (usize, &FrameLight)> {
        let first = self.scene_count();
        let companions = self.lights[first..].iter().enumerate();
        companions
            .map(move |(at, companion)| (first + at, companion))
            .filter(move |(_, companion)| {
                companion.technique.is_some() && companion.companion_of.is_some_and(|of| of.light == light)
            })
    }
}

/// The components that [`collect_frame_lights`] reads of one light.
type LightItem<'a> = (
    Entity,
    &'a Light,
    &'a GlobalTransform,
    Option<&'a LightSelection>,
    LightModelParts<'a>,
    Option<&'a Cookie>,
    Option<&'a LightProfile>,
);

/// Lists the usable lights and companions, and compares each with the frame before.
///
/// Set: `CollectSets`. Reads [`Light`], `GlobalTransform`, [`LightSelection`], the light model and [`CompanionOf`]. O(lights), and
/// O(lights log lights) when one came or went. Lights are in the order of their entities, and keep their sets
/// and allocations as long as they exist.
pub fn collect_frame_lights(
    mut frame: ResMut<FrameLights>,
    lights: Query<LightItem<'static>>,
    companions: Query<(Entity, &'static CompanionOf)>,
) {
    let frame = &mut *frame;
    frame.skipped.clear();
    frame.faults.clear();
    let same_order = collect_candidates(frame, &lights, &companions);
    frame.skipped.sort_unstable_by_key(|skipped| skipped.entity);
    frame.faults.sort_by_key(|(entity, _)| *entity);
    let FrameLights {
        candidates,
        ascending,
        ..
    } = frame;
    if !same_order {
        ascending.clear();
        ascending.extend(0..candidates.len());
        ascending.sort_unstable_by_key(|&at| candidates[at].order());
    }
    let in_order = ascending.iter().map(|&at| &candidates[at]);
    let same_members = same_order
        || (candidates.len() == frame.lights.len()
            && in_order
                .clone()
                .zip(&frame.lights)
                .all(|(new, old)| new.order() == old.order()));
    if same_members {
        for (light, candidate) in frame.lights.iter_mut().zip(in_order) {
            light.refresh(candidate);
        }
        return;
    }
    frame.generation += 1;
    std::mem::swap(&mut frame.lights, &mut frame.previous);
    let mut old = frame.previous.drain(..).peekable();
    for candidate in in_order {
        while old.next_if(|light| light.order() < candidate.order()).is_some() {}
        let light = match old.next_if(|light| light.order() == candidate.order()) {
            Some(mut light) => {
                light.refresh(candidate);
                light
            }
            None => FrameLight::new(candidate),
        };
        frame.lights.push(light);
    }
}

/// The lights of the scene in the order of the query, and then companions, each with what is known of its light.
fn items<'a>(
    lights: &'a Query<LightItem<'static>>,
    companions: &'a Query<(Entity, &'static CompanionOf)>,
) -> impl Iterator<Item = (Option<CompanionOf>, LightItem<'a>)> {
    let of_companions = companions.iter().filter_map(|(entity, of)| {
        let mut item = lights.get(of.light).ok()?;
        item.0 = entity;
        Some((Some(*of), item))
    });
    lights.iter().map(|item| (None, item)).chain(of_companions)
}

/// Brings the candidates up to date. Returns whether they are those of the frame before, in the same order.
fn collect_candidates(
    frame: &mut FrameLights,
    lights: &Query<LightItem<'static>>,
    companions: &Query<(Entity, &'static CompanionOf)>,
) -> bool {
    let FrameLights {
        candidates,
        faults,
        skipped,
        ..
    } = frame;
    let mut count = 0;
    let mut same_order = true;
    for (companion_of, item) in items(lights, companions) {
        let (entity, light, world_from_light, selection, parts, cookie, profile) = item;
        // The faults of a companion are those of its light, which has them already.
        let mut fault = |fault| {
            if companion_of.is_none() {
                faults.push((entity, fault));
            }
        };
        let mut model = LightModel::of(parts, light.kind, &mut fault);
        let textures = LightTextures::of(cookie, profile, light.kind, &mut fault);
        if companion_of.is_some() {
            model.origin = None; // what it completes does not follow an origin
        }
        let selection = selection.copied().unwrap_or_default();
        let last = candidates.get_mut(count);
        let order = (companion_of, entity);
        if let Some(last) = last.filter(|last| last.is_placed_by(order, light, world_from_light, &model)) {
            last.is_kept = last.selection == selection;
            last.selection = selection;
            last.textures = textures;
        } else {
            let placed = match place(light, world_from_light, &model) {
                Ok(placed) => placed,
                Err(error) => {
                    if companion_of.is_none() {
                        skipped.push(SkippedLight { entity, error });
                    }
                    continue;
                }
            };
            let candidate = Candidate {
                entity,
                companion_of,
                source: light.clone(),
                light: Light {
                    range: placed.range,
                    ..light.clone()
                },
                world_from_light: *world_from_light,
                selection,
                model,
                textures,
                placed,
                is_kept: false,
            };
            match candidates.get_mut(count) {
                Some(last) => {
                    same_order &= last.order() == order;
                    *last = candidate;
                }
                None => {
                    same_order = false;
                    candidates.push(candidate);
                }
            }
        }
        if companion_of.is_none() && candidates[count].placed.casts_from_behind(light.kind) {
            faults.push((entity, LightModelFault::OriginBehind));
        }
        count += 1;
    }
    same_order &= candidates.len() == count;
    candidates.truncate(count);
    same_order
}
