//! What all techniques with maps bring into the frame, once for all of them.

use bevy_ecs::prelude::*;

use super::build_maps::{Maps, build_maps};
use super::request::{MapRequests, MapSystems};
use super::settings::{MapError, MapSettings};
use crate::reports::Round;
use crate::sets::FrameLights;
use crate::techniques::registry::{Statistics, TechniqueSystems};

/// Inserts the resources of maps, those that are missing.
pub fn init(world: &mut World) {
    world.init_resource::<MapSettings>();
    world.init_resource::<MapRequests>();
    world.init_resource::<Maps>();
}

/// Adds the systems of maps to a schedule that has none.
pub fn add(schedule: &mut Schedule) {
    if schedule.graph().system_sets.contains(MapSystems::Build) {
        return;
    }
    schedule.configure_sets((
        (MapSystems::Request, MapSystems::Build)
            .chain()
            .in_set(TechniqueSystems),
        // Each lists its own lights, and `build_maps` sorts them.
        MapSystems::Request.ambiguous_with(MapSystems::Request),
    ));
    schedule.add_systems(build_maps.in_set(MapSystems::Build));
    #[cfg(feature = "render")]
    schedule.add_systems(
        super::gpu::limit_to_device
            .run_if(resource_exists::<crate::render::Renderer>)
            .before(MapSystems::Build)
            .in_set(TechniqueSystems),
    );
}

/// Sets `map`, what is known of the map of a light; nothing if the light has none that is looked up.
pub fn statistics(world: &World, light: usize, out: &mut Statistics) {
    let map = world.resource::<Maps>().of_light(light).map(|map| {
        let mut of_map = Statistics::default();
        of_map.set("resolution", map.resolution);
        of_map.set("faces", map.faces.len());
        of_map.set("kept", map.cached);
        of_map.set("casters", map.casters().count_ones(..));
        of_map
    });
    out.set("map", map);
}

/// Sets what is known of all maps together.
pub fn frame_statistics(world: &World, out: &mut Statistics) {
    let maps = world.resource::<Maps>();
    let reports = maps.reports.iter().map(|report| report.error.to_string());
    out.set("map_bytes", maps.bytes);
    out.set("map_reports", reports.collect::<Vec<String>>());
}

/// Raises what is less than was asked for, of the lights with a component `T`.
pub fn report<T: 'static>(world: &World, round: &mut Round) {
    let lights = world.resource::<FrameLights>();
    for report in &world.resource::<Maps>().reports {
        let light = lights.of_entity(report.entity);
        if !light.is_some_and(|light| light.is_shadowed_by::<T>()) {
            continue;
        }
        let (code, advice) = match report.error {
            MapError::Largest { .. } => (
                8,
                "Ask for less, or raise `MapSettings::largest` if the device allows.",
            ),
            MapError::Coarser { .. } => (
                9,
                "Raise `MapSettings::memory_limit`, or ask for lower resolutions.",
            ),
            MapError::Uncached { .. } => (10, "Raise `MapSettings::memory_limit`, or use fewer maps."),
        };
        round.raise(Some(report.entity), code, || {
            format!(
                "The light's shadow is poorer than asked for: {}. {advice}",
                report.error
            )
        });
    }
}
