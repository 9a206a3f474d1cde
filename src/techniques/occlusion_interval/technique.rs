//! Occlusion interval maps as a technique.

use bevy_ecs::prelude::*;
use bevy_transform::TransformSystems;

use super::component::{OcclusionInterval, follow_light_paths};
#[cfg(feature = "render")]
use super::gpu::{self, recorder::IntervalNode};
use super::intervals::PER_PAIR;
use super::library::IntervalLibrary;
use super::scenes::{IntervalScenes, match_interval_maps};
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::Needs;
use crate::techniques::registry::{Refusal, Statistics, Technique};
use crate::techniques::shared::texture_memory::{Storage, TextureMemory, TextureMemorySystems, TextureWant};

/// Code of the report about receivers that are not in the maps.
const STRANGERS: u32 = 6;

/// Asks for the memory of the maps' textures.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Ask`]. Reads [`IntervalScenes`]; writes [`TextureMemory`].
pub fn ask_for_interval_maps(scenes: Res<IntervalScenes>, mut memory: ResMut<TextureMemory>) {
    for light in &scenes.lights {
        let Some(scene) = scenes.scene_of(light.light) else {
            continue;
        };
        let size = scene.maps.size.max(1);
        memory.ask(
            light.light,
            OcclusionInterval::NAME,
            TextureWant {
                bytes_per_square: (2 * PER_PAIR * scene.maps.layer_count()) as u64,
                resolution: size,
                least: size, // texels cannot be merged
                storage: Storage::OwnElseNothing,
            },
        );
    }
}

impl Technique for OcclusionInterval {
    const NAME: &'static str = "occlusion_interval";
    const NEEDS: Needs = Needs::NOTHING;

    fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.check_settings(light)
    }

    #[cfg(feature = "schema")]
    fn schema(of: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
        Some(<Self as schemars::JsonSchema>::json_schema(of))
    }

    fn init(world: &mut World) {
        world.init_resource::<IntervalLibrary>();
        world.init_resource::<IntervalScenes>();
    }

    fn add_systems(schedule: &mut Schedule) {
        schedule.add_systems((
            follow_light_paths.before(TransformSystems::Propagate),
            (match_interval_maps, ask_for_interval_maps)
                .chain()
                .in_set(TextureMemorySystems::Ask),
        ));
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        let scenes = world.resource::<IntervalScenes>();
        let group = scenes
            .of_light(light)
            .zip(scenes.scene_of(light))
            .map(|(light, scene)| {
                let maps = &scene.maps;
                let mut group = Statistics::default();
                group.set("surfaces", scene.matched.len());
                group.set("receivers_not_in_maps", scene.strangers);
                group.set("pages", maps.pages.len());
                group.set("page_size", maps.size);
                group.set("pairs", maps.pair_count());
                group.set("most_intervals", maps.statistics.most_intervals);
                group.set("texels", maps.statistics.texels);
                group.set("texels_per_metre", f64::from(maps.texels_per_metre));
                group.set("bytes", maps.bytes());
                let per_texel = maps.bytes() as f64 / maps.statistics.texels.max(1) as f64;
                group.set("bytes_per_texel", per_texel);
                group.set("time", f64::from(light.time));
                group.set("width", f64::from(light.width));
                group
            });
        out.set("interval_maps", group);
    }

    fn report(world: &World, round: &mut Round) {
        let scenes = world.resource::<IntervalScenes>();
        for light in &scenes.lights {
            match &light.scene {
                Err(fault) => round.raise(Some(light.entity), fault.code(), || {
                    format!("The light has no shadow: {fault}.")
                }),
                Ok(scene) => {
                    let strangers = scenes.scenes.get(*scene).map_or(0, |scene| scene.strangers);
                    if strangers > 0 {
                        round.state(
                            Some(light.entity),
                            STRANGERS,
                            format_args!(
                                "{strangers} receivers are not in the light's maps and show no shadow of it. If they \
                                 stand still, bake the maps again."
                            ),
                        );
                    }
                }
            }
        }
    }

    #[cfg(feature = "serde")]
    fn parse(from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        erased_serde::deserialize(from)
    }

    #[cfg(feature = "bevy")]
    fn register_type(types: &mut bevy_reflect::TypeRegistry) {
        types.register::<Self>();
        types.register::<crate::scene::LightPath>();
    }

    #[cfg(feature = "render")]
    const SHADERS: &'static [ShaderFile] = gpu::SHADERS;

    #[cfg(feature = "render")]
    type Recorder = IntervalNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        IntervalNode::new(gpu)
    }
}
