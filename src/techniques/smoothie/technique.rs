//! Smoothies as a technique.

use bevy_ecs::prelude::*;

use super::component::Smoothie;
#[cfg(feature = "render")]
use super::gpu::{self, recorder::SmoothieNode};
use crate::debug_lines::DebugLines;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::{FrameLights, NeededSilhouettes, Needs};
use crate::silhouettes::Silhouettes;
use crate::techniques::maps::request::{MapRequests, MapSystems};
use crate::techniques::maps::{self, Maps, systems};
use crate::techniques::registry::{Refusal, Statistics, Technique, TexelLookup};

/// Lists the map requests of the lights that a [`Smoothie`] shadows.
///
/// Set: `BuildTechniques`, before `build_maps`. Reads [`FrameLights`]; writes [`MapRequests`].
pub fn request_smoothie_maps(
    mut requests: ResMut<MapRequests>,
    lights: Res<FrameLights>,
    smoothies: Query<&Smoothie>,
) {
    requests.list::<Smoothie>(&lights, &smoothies, |smoothie, light| {
        let softened = light
            .model
            .softness
            .map(|softness| smoothie.softened(softness, &light.light));
        let request = softened.as_ref().unwrap_or(smoothie).request(&light.light);
        request.map(|request| request.placed(light))
    });
}

impl Technique for Smoothie {
    const NAME: &'static str = "smoothie";
    const NEEDS: Needs = Needs {
        silhouettes: NeededSilhouettes::Reached,
        ..maps::NEEDS
    };

    fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.request(light).map(drop)
    }

    fn init(world: &mut World) {
        systems::init(world);
    }

    fn add_systems(schedule: &mut Schedule) {
        systems::add(schedule);
        schedule.add_systems(request_smoothie_maps.in_set(MapSystems::Request));
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        systems::statistics(world, light, out);
        let frame_light = &world.resource::<FrameLights>().lights[light];
        if !frame_light.is_shadowed_by::<Self>() {
            return;
        }
        let map = world.resource::<Maps>().of_light(light);
        let silhouettes = world.resource::<Silhouettes>().of_light(frame_light.entity);
        let edges = map.zip(silhouettes).map(|(map, silhouettes)| {
            let of_caster = |object| {
                let contour = &silhouettes.of_object(object)?.1.contour;
                Some(contour.edges.len() + contour.double_edges.len())
            };
            map.casters().ones().filter_map(of_caster).sum::<usize>()
        });
        // Casters with holes have silhouettes too, and no smoothies.
        out.set("silhouette_edges", edges);
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
    type Recorder = SmoothieNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        SmoothieNode::new(gpu)
    }
}
