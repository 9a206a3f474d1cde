//! Occlusion textures as a technique.

use bevy_ecs::prelude::*;

use super::build::{OcclusionTextures, ask_for_slices, build_slices};
use super::coarse::Metres;
use super::component::OcclusionTexture;
use super::debug_lines;
use super::face::Slices;
#[cfg(feature = "render")]
use super::gpu::{self, recorder::SliceNode};
use crate::debug_lines::DebugLines;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::{FrameLights, Needs};
use crate::techniques::registry::{Refusal, Statistics, Technique, TexelLookup};
use crate::techniques::shared::pictures::{Chosen, Picture, texel_lookup};
use crate::techniques::shared::texture_memory::TextureMemorySystems;

impl Technique for OcclusionTexture {
    const NAME: &'static str = "occlusion_texture";
    const NEEDS: Needs = Needs {
        receiver_planes: true,
        ..Needs::NOTHING
    };

    fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.validated(light)
    }

    #[cfg(feature = "schema")]
    fn schema(of: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
        Some(<Self as schemars::JsonSchema>::json_schema(of))
    }

    fn init(world: &mut World) {
        world.init_resource::<OcclusionTextures>();
    }

    fn add_systems(schedule: &mut Schedule) {
        schedule.add_systems((
            ask_for_slices.in_set(TextureMemorySystems::Ask),
            build_slices.in_set(TextureMemorySystems::Build),
        ));
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        let slices = world.resource::<OcclusionTextures>().of_light(light);
        let statistics = slices.map(|slices| {
            let mut of_light = Statistics::default();
            of_light.set("slices", slices.settings.slices);
            of_light.set("resolution", slices.resolution);
            of_light.set("pictures", slices.faces.len());
            of_light.set("casters", slices.casters.count_ones(..));
            let bytes = slices.bytes_per_square() * u64::from(slices.resolution).pow(2);
            of_light.set("bytes", bytes);
            let extent = slices.extent().to_array().map(f64::from);
            of_light.set("extent_metres", extent.to_vec());
            of_light
        });
        out.set("occlusion_texture", statistics);
    }

    fn report(world: &World, round: &mut Round) {
        let lights = world.resource::<FrameLights>();
        let textures = world.resource::<OcclusionTextures>();
        for slices in textures.lights.iter().filter(|slices| slices.is_active) {
            let light = &lights.lights[slices.light];
            let casts = slices.faces.iter().any(|face| face.slices.top < 1e29);
            // Casters of S that are none of the pictures', like a flat ground, shadow nothing anyway.
            if !casts && !light.sets.s.is_disjoint(&slices.casters) {
                round.raise(Some(slices.entity), 1, || {
                    "The light has no shadow: all casters lie behind it or in its plane. Move or turn the light.".to_owned()
                });
            }
            if let Some(coarse) = slices.coarse {
                round.state(
                    Some(slices.entity),
                    2,
                    format_args!(
                        "The light's shadows are coarse: its slices are {} thick and its texels up to {} wide, too much for \
                         {} of {} casters. Give the light a range, or let large surroundings cast no shadows.",
                        Metres(coarse.thickness), Metres(coarse.texel), coarse.lost, coarse.casters
                    ),
                );
            }
        }
    }

    fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
        debug_lines::debug_lines(world, light, out);
    }

    fn texels(world: &World, light: usize) -> Option<TexelLookup<'_>> {
        let slices = world.get_resource::<OcclusionTextures>()?.of_light(light)?;
        let drawn = slices.faces.iter().filter(|face| face.slices != Slices::NONE);
        let pictures = drawn.map(|face| Picture {
            clip_from_world: face.drawn().clip_from_world(),
            resolution: slices.resolution,
        });
        Some(texel_lookup(pictures.collect(), Chosen::Innermost))
    }

    #[cfg(feature = "serde")]
    fn parse(from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        erased_serde::deserialize(from)
    }

    #[cfg(feature = "bevy")]
    fn register_type(types: &mut bevy_reflect::TypeRegistry) {
        types.register::<Self>();
    }

    #[cfg(feature = "render")]
    const SHADERS: &'static [ShaderFile] = gpu::SHADERS;

    #[cfg(feature = "render")]
    type Recorder = SliceNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        SliceNode::new(gpu)
    }
}
