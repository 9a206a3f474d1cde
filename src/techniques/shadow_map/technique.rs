//! The shadow map of spot and directional lights as a technique.

use bevy_ecs::prelude::*;

use super::component::ShadowMap;
use crate::debug_lines::DebugLines;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::{FrameLights, Needs};
#[cfg(feature = "render")]
use crate::techniques::maps::gpu::{self, recorder::MapNode};
use crate::techniques::maps::request::{MapRequests, MapSystems};
use crate::techniques::maps::{self, systems};
use crate::techniques::registry::{Refusal, Statistics, Technique, TexelLookup};

/// Lists the map requests of the lights that a [`ShadowMap`] shadows.
///
/// Set: `BuildTechniques`, before `ask_for_maps`. Reads [`FrameLights`]; writes [`MapRequests`].
pub fn request_shadow_maps(
    mut requests: ResMut<MapRequests>,
    lights: Res<FrameLights>,
    maps: Query<&ShadowMap>,
) {
    requests.list::<ShadowMap>(&lights, &maps, |map, light| {
        map.request(&light.light)
            .map(|request| request.placed(light).softened(light))
    });
}

impl Technique for ShadowMap {
    const NAME: &'static str = "shadow_map";
    const NEEDS: Needs = maps::NEEDS;

    fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.request(light).map(drop)
    }

    fn init(world: &mut World) {
        systems::init(world);
    }

    fn add_systems(schedule: &mut Schedule) {
        systems::add(schedule);
        schedule.add_systems(request_shadow_maps.in_set(MapSystems::Request));
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        systems::statistics(world, light, out);
    }

    fn frame_statistics(world: &World, out: &mut Statistics) {
        systems::frame_statistics(world, out);
    }

    fn report(world: &World, round: &mut Round) {
        systems::report::<Self>(world, round);
    }

    fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
        maps::debug_lines::debug_lines(world, light, out);
    }

    fn texels(world: &World, light: usize) -> Option<TexelLookup<'_>> {
        maps::texels::texels(world, light)
    }

    #[cfg(feature = "serde")]
    fn parse(from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        erased_serde::deserialize(from)
    }

    #[cfg(feature = "schema")]
    fn schema(of: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
        Some(<Self as schemars::JsonSchema>::json_schema(of))
    }

    #[cfg(feature = "bevy")]
    fn register_type(types: &mut bevy_reflect::TypeRegistry) {
        types.register::<Self>();
    }

    #[cfg(feature = "render")]
    const SHADERS: &'static [ShaderFile] = gpu::SHADERS;

    #[cfg(feature = "render")]
    type Recorder = MapNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        MapNode::new(gpu)
    }
}
