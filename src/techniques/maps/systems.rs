//! Resources, systems, statistics and reports that all techniques with maps share.

use bevy_ecs::prelude::*;

use super::ask_for_maps::ask_for_maps;
use super::build_maps::{Maps, build_maps};
use super::map_error::MapError;
use super::request::{MapRequests, MapShape, MapSystems};
use super::settings::{MapResolution, MapSettings};
use crate::reports::Round;
use crate::sets::FrameLights;
use crate::techniques::registry::{Statistics, TechniqueSystems};
use crate::techniques::shared::texture_memory::TextureMemorySystems;

/// Inserts the missing ones of the resources of maps.
pub fn init(world: &mut World) {
    world.init_resource::<MapSettings>();
    world.init_resource::<MapRequests>();
    world.init_resource::<Maps>();
}

/// Adds the systems of maps to a schedule, unless the schedule has them already.
pub fn add(schedule: &mut Schedule) {
    if schedule.graph().system_sets.contains(MapSystems::Build) {
        return;
    }
    schedule.configure_sets((
        MapSystems::Request
            .in_set(TechniqueSystems)
            .before(TextureMemorySystems::Ask),
        MapSystems::Build.in_set(TextureMemorySystems::Build),
        // The order does not matter: each system lists its own lights, and `ask_for_maps` sorts the requests.
        MapSystems::Request.ambiguous_with(MapSystems::Request),
    ));
    schedule.add_systems((
        ask_for_maps.in_set(TextureMemorySystems::Ask),
        build_maps.in_set(MapSystems::Build),
    ));
    #[cfg(feature = "render")]
    schedule.add_systems(
        super::gpu::limit_to_device
            .run_if(resource_exists::<crate::render::Renderer>)
            .in_set(TechniqueSystems)
            .before(TextureMemorySystems::Ask),
    );
}

/// Sets the statistic `map`: values of the light's map, or no value if the light has no map that is looked
/// up.
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

/// Sets the statistics of all maps together: `map_bytes` and `map_reports`.
pub fn frame_statistics(world: &World, out: &mut Statistics) {
    let maps = world.resource::<Maps>();
    let reports = maps.reports.iter().map(|report| report.error.to_string());
    out.set("map_bytes", maps.bytes);
    out.set("map_reports", reports.collect::<Vec<String>>());
}

/// Returns advice on how a light's map gets finer.
fn finer(maps: &Maps, light: Entity) -> &'static str {
    let map = maps.lights.iter().find(|map| map.entity == light);
    match map.map(|map| (map.request.shape, map.request.resolution)) {
        Some((MapShape::Cascades, MapResolution::Fixed(_))) => {
            "Give its cascades a shorter `distance`, or raise `resolution`."
        }
        Some((MapShape::Cascades, _)) => {
            "Give its cascades a shorter `distance`, or raise `most` of the resolution."
        }
        Some((MapShape::Spot, _)) => {
            "Narrow the light's cone, move it closer to what it shadows, or raise `most` of the resolution."
        }
        _ => {
            "Move the light closer to what it shadows, raise `most` of the resolution, or use a `PerspectiveMap`."
        }
    }
}

/// Raises reports about maps that are poorer than asked for, for the lights that the technique `T` shadows.
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
            MapError::Coarse { .. } => (9, finer(world.resource::<Maps>(), report.entity)),
            MapError::Steps { .. } => (10, "Give the light a shorter range, or choose another `format`."),
        };
        round.state(
            Some(report.entity),
            code,
            format_args!(
                "The light's shadow is poorer than asked for: {}. {advice}",
                report.error
            ),
        );
    }
}
