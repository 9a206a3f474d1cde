//! What the shadow techniques cannot do, as reports.

use bevy_ecs::component::ComponentId;
use bevy_ecs::prelude::*;

use super::maps::{MapError, Maps};
use super::penumbra_wedge::light_parts::LEAST_EXTENT;
use super::penumbra_wedge::{SPLIT_CAPACITY, WedgeOverflow};
use super::{OmniMap, PenumbraWedge, ShadowMap, StencilVolume};
use crate::reports::Reports;
use crate::scene::Light;
use crate::sets::{FrameLights, View};

/// Raises the topic `technique` and those of the techniques, which have their names.
pub fn report_techniques(world: &World, reports: &mut Reports) {
    let known = [
        ("StencilVolume", world.component_id::<StencilVolume>()),
        ("PenumbraWedge", world.component_id::<PenumbraWedge>()),
        ("ShadowMap", world.component_id::<ShadowMap>()),
        ("OmniMap", world.component_id::<OmniMap>()),
    ];
    report_components(world, &known, reports);
    report_wedges(world, reports);
    let has_shadow_map = |light| world.get::<ShadowMap>(light).is_some();
    report_maps(world, "shadow_map", has_shadow_map, reports);
    report_maps(world, "omni_map", |light| !has_shadow_map(light), reports);
}

/// Techniques without a light, and several on one: of those the first that is named here shadows the light. Asks
/// archetypes, not entities.
fn report_components(world: &World, known: &[(&str, Option<ComponentId>)], reports: &mut Reports) {
    let mut round = reports.round("technique");
    let light = world.component_id::<Light>();
    for archetype in world.archetypes().iter() {
        let has = |id: Option<ComponentId>| id.is_some_and(|id| archetype.contains(id));
        let names = || known.iter().filter(|(_, id)| has(*id)).map(|(name, _)| *name);
        let Some(first) = names().next() else {
            continue;
        };
        for entity in archetype.entities().iter().map(|entity| Some(entity.id())) {
            if !has(light) {
                round.raise(entity, 1, || {
                    format!("{first} has no effect: the entity is no light. Put it on the entity that has the light.")
                });
            } else if names().count() > 1 {
                round.raise(entity, 2, || {
                    let all: Vec<&str> = names().collect();
                    format!(
                        "The light has {} shadow techniques, {}; {first} is used. Remove the others.",
                        all.len(),
                        all.join(" and ")
                    )
                });
            }
        }
    }
}

fn report_wedges(world: &World, reports: &mut Reports) {
    let mut round = reports.round("penumbra_wedge");
    for light in &world.resource::<FrameLights>().lights {
        let entity = light.entity;
        if light.emitter.bounding_radius() < LEAST_EXTENT && world.get::<PenumbraWedge>(entity).is_some() {
            round.raise(Some(entity), 1, || {
                "PenumbraWedge gives a hard shadow here: the light has no size. Give a point light a radius greater than \
                 0 m, use a rectangle, or use StencilVolume, which is cheaper."
                    .to_owned()
            });
        }
    }
    let pixels = world.resource::<WedgeOverflow>().pixels();
    if pixels > 0 {
        let view = world.resource::<View>().data.as_ref();
        round.state(
            view.map(|view| view.camera),
            2,
            format_args!(
                "Soft shadows are too light in {pixels} pixels: more than {SPLIT_CAPACITY} hard faces meet there, which \
                 `VisibilityBuffer::Split8` cannot add up. Use `VisibilityBuffer::Float`, or split the light less."
            ),
        );
    }
}

fn report_maps(
    world: &World,
    topic: &'static str,
    is_of_topic: impl Fn(Entity) -> bool,
    reports: &mut Reports,
) {
    let mut round = reports.round(topic);
    let maps = world.resource::<Maps>();
    for report in maps.reports.iter().filter(|report| is_of_topic(report.entity)) {
        let (code, advice) = map_advice(&report.error);
        let effect = if report.error.is_fatal() {
            "The light casts no shadow"
        } else {
            "The light's shadow is poorer than asked for"
        };
        let error = report.error;
        round.state(
            Some(report.entity),
            code,
            format_args!("{effect}: {error}.{advice}"),
        );
    }
}

/// Number of a map's fault, and what to do about it; nothing where the fault itself says it.
fn map_advice(error: &MapError) -> (u32, &'static str) {
    match error {
        MapError::Kind { .. } => (1, ""),
        MapError::Resolution(_) => (2, " Set the resolution in texels along a side."),
        MapError::Near { .. } => (3, " Set `near` in metres, or leave it `None`."),
        MapError::Softness(_) => (4, " Set the filter's softness."),
        MapError::Bias(_) => (5, " Set the bias, or use `MapBias::Auto`."),
        MapError::CascadeCount(_) => (6, " Set `Cascades::count`."),
        MapError::Cascades { .. } => (
            7,
            " The distance must be greater than 0 m, the log share 0 to 1 and the blend 0 to 0.5.",
        ),
        MapError::Largest { .. } => (
            8,
            " Ask for less, or raise `MapSettings::largest` if the device allows.",
        ),
        MapError::Coarser { .. } => (
            9,
            " Raise `MapSettings::memory_limit`, or ask for lower resolutions.",
        ),
        MapError::Uncached { .. } => (10, " Raise `MapSettings::memory_limit`, or use fewer maps."),
    }
}
