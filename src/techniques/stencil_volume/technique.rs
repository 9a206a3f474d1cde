//! Stencil shadow volumes as a technique.

use bevy_ecs::prelude::*;

use super::component::{MOST_STACKED, StencilVolume};
#[cfg(feature = "render")]
use super::gpu::recorder::StencilVolumeNode;
use super::volumes::{StencilVolumes, build_stencil_volumes};
use crate::debug_lines::DebugLines;
#[cfg(feature = "render")]
use crate::render::shaders::{ShaderFile, shader_files};
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::sets::{FrameLights, NeededSilhouettes, Needs};
use crate::silhouettes::Silhouettes;
use crate::techniques::registry::{Statistics, Technique, TechniqueSystems};
use crate::techniques::shared::shadow_lines::volume_lines;

impl Technique for StencilVolume {
    const NAME: &'static str = "stencil_volume";
    const NEEDS: Needs = Needs {
        silhouettes: NeededSilhouettes::Shadowing,
        light_occlusion: true,
        ..Needs::NOTHING
    };

    fn init(world: &mut World) {
        world.init_resource::<StencilVolumes>();
    }

    fn add_systems(schedule: &mut Schedule) {
        schedule.add_systems(build_stencil_volumes.in_set(TechniqueSystems));
    }

    fn report(world: &World, round: &mut Round) {
        let silhouettes = world.resource::<Silhouettes>();
        for light in &world.resource::<FrameLights>().lights {
            let known = light
                .is_shadowed_by::<Self>()
                .then(|| silhouettes.of_light(light.entity))
                .flatten();
            let Some(known) = known.filter(|known| known.stacked > MOST_STACKED) else {
                continue;
            };
            let casters = light.sets.s.ones().filter_map(|object| known.of_object(object));
            for (_, caster) in casters.filter(|(_, caster)| caster.stacked > MOST_STACKED) {
                round.state(
                    Some(caster.entity),
                    1,
                    format_args!(
                        "Up to {} sheets of this mesh lie one behind the other in a light. StencilVolume counts \
                         {MOST_STACKED} of one mesh, so pixels behind more may be lit. Split the mesh.",
                        caster.stacked
                    ),
                );
            }
        }
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        let volumes = world.resource::<StencilVolumes>().of_light(light);
        let count = |depth_pass: bool| {
            let casters = volumes.map_or(&[][..], |volumes| &volumes.casters);
            casters
                .iter()
                .filter(|caster| caster.depth_pass == depth_pass)
                .count()
        };
        out.set("casters_depth_pass", count(true));
        out.set("casters_depth_fail", count(false));
        out.set("casters_culled", volumes.map_or(0, |volumes| volumes.culled));
    }

    fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
        volume_lines(world, light, out);
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
    const SHADERS: &'static [ShaderFile] = shader_files!["techniques/stencil_volume/volume.wgsl"];

    #[cfg(feature = "render")]
    type Recorder = StencilVolumeNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        StencilVolumeNode::new(gpu)
    }
}
