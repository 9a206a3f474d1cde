//! Occlusion interval maps as a technique.

use bevy_ecs::prelude::*;
use bevy_transform::TransformSystems;

use super::component::{OcclusionInterval, follow_light_paths};
#[cfg(feature = "render")]
use super::gpu::{self, recorder::IntervalNode};
use super::intervals::PER_PAIR;
use super::library::{IntervalFolder, IntervalLibrary};
use super::matching::IntervalScene;
use super::scenes::{IntervalLight, IntervalScenes, match_interval_maps};
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::Light;
use crate::sets::{FrameLights, LeftObjects, Needs};
use crate::techniques::registry::{FileError, LeavingSystems, Refusal, Statistics, Technique, TexelLookup};
use crate::techniques::shared::texture_memory::{Storage, TextureMemory, TextureMemorySystems, TextureWant};

/// Code of the report about receivers that are not in the maps.
const STRANGERS: u32 = 6;

/// Code of the report about a light that shares the maps of another one, for which memory is short.
const NO_MEMORY: u32 = 7;

/// Code of the report about a [`ShadowOrigin`](crate::scene::ShadowOrigin), which baked shadows do not follow.
const ORIGIN: u32 = 8;

/// Code of the report about receivers that are seen from both sides, while the maps hold one.
const BACKS: u32 = 9;

/// Asks for the memory of the maps' textures, once for all lights that share them.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Ask`]. Reads [`FrameLights`]; writes [`IntervalScenes`] and
/// [`TextureMemory`].
pub fn ask_for_interval_maps(
    mut scenes: ResMut<IntervalScenes>,
    mut memory: ResMut<TextureMemory>,
    lights: Res<FrameLights>,
) {
    scenes.choose_payers(&lights);
    for scene in &scenes.scenes {
        let Some(payer) = scene.payer else { continue };
        let size = scene.maps.size.max(1);
        memory.ask(
            payer,
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

/// Notes which maps have memory for their textures, for the sets of the next frame.
///
/// Set: `BuildTechniques`, in [`TextureMemorySystems::Build`]. Reads [`TextureMemory`]; writes [`IntervalScenes`].
pub fn note_interval_memory(mut scenes: ResMut<IntervalScenes>, memory: Res<TextureMemory>) {
    for scene in &mut scenes.scenes {
        if let Some(payer) = scene.payer {
            scene.has_memory = memory.grant(payer, OcclusionInterval::NAME).is_some();
        }
    }
}

/// Whether another technique shadows by what is not in the maps of a light.
fn has_companion(world: &World, light: &IntervalLight) -> bool {
    let lights = world.resource::<FrameLights>();
    lights.companions_of(light.entity).next().is_some()
}

/// Reports what is missing under a light whose maps are usable.
fn report_scene(world: &World, light: &IntervalLight, scene: &IntervalScene, round: &mut Round) {
    let memory = world.resource::<TextureMemory>();
    let is_granted = |payer: usize| memory.grant(payer, OcclusionInterval::NAME).is_some();
    // The payer itself is reported under the topic `texture_memory`.
    if scene
        .payer
        .is_some_and(|payer| payer != light.light && !is_granted(payer))
    {
        round.state(
            Some(light.entity),
            NO_MEMORY,
            format_args!(
                "The light has no shadow: memory is short for the textures that it shares with other lights."
            ),
        );
    }
    let lights = &world.resource::<FrameLights>().lights;
    if lights
        .get(light.light)
        .is_some_and(|light| light.model.origin.is_some())
    {
        round.state(
            Some(light.entity),
            ORIGIN,
            format_args!(
                "The origin of the light's shadows has no effect: its maps were baked for its path. Bake them for another path, or remove the origin."
            ),
        );
    }
    if scene.strangers > 0 && !has_companion(world, light) {
        round.state(
            Some(light.entity),
            STRANGERS,
            format_args!(
                "{} receivers are not in the light's maps and show no shadow of it. If they stand still, bake the maps again.",
                scene.strangers
            ),
        );
    }
    if scene.without_backs > 0 {
        round.state(
            Some(light.entity),
            BACKS,
            format_args!(
                "{} receivers are seen from both sides, but the light's maps were baked for their fronts alone: their backs are dark. Bake the maps again.",
                scene.without_backs
            ),
        );
    }
}

impl Technique for OcclusionInterval {
    const NAME: &'static str = "occlusion_interval";
    const NEEDS: Needs = Needs {
        light_path: true,
        draws_receivers: true,
        ..Needs::NOTHING
    };
    const LEAVES_OTHERS: bool = true;
    const PATHS: &'static [&'static str] = &["maps"];

    fn left_to_others(world: &World, light: usize) -> LeftObjects<'_> {
        let scene = world.resource::<IntervalScenes>().scene_of(light);
        scene
            .filter(|scene| scene.has_memory)
            .map_or(LeftObjects::All, |scene| LeftObjects::Some {
                casters: &scene.strange_casters,
                receivers: &scene.strange_receivers,
            })
    }

    fn load_files(world: &mut World, light: Entity) -> Result<(), FileError> {
        let Some(settings) = world.get::<Self>(light) else {
            return Ok(());
        };
        let name = settings.maps.clone();
        let folder = world
            .get_resource::<IntervalFolder>()
            .cloned()
            .unwrap_or_default();
        let mut library = world.get_resource_or_init::<IntervalLibrary>();
        library.read_again(&name, &folder).map_err(|problem| FileError {
            setting: "maps",
            problem,
        })
    }

    fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.check_settings(light)
    }

    #[cfg(feature = "schema")]
    fn schema(of: &mut schemars::SchemaGenerator) -> Option<schemars::Schema> {
        Some(<Self as schemars::JsonSchema>::json_schema(of))
    }

    fn init(world: &mut World) {
        world.init_resource::<IntervalFolder>();
        world.init_resource::<IntervalLibrary>();
        world.init_resource::<IntervalScenes>();
    }

    fn add_systems(schedule: &mut Schedule) {
        schedule.add_systems((
            follow_light_paths.before(TransformSystems::Propagate),
            match_interval_maps.in_set(LeavingSystems),
            ask_for_interval_maps.in_set(TextureMemorySystems::Ask),
            note_interval_memory.in_set(TextureMemorySystems::Build),
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
                group.set("shining", f64::from(light.shining));
                group
            });
        out.set("interval_maps", group);
    }

    /// Texels lie on the surfaces, all equally large. Receivers that are not in the maps are counted as if they were.
    fn texels(world: &World, light: usize) -> Option<TexelLookup<'_>> {
        let scene = world.get_resource::<IntervalScenes>()?.scene_of(light)?;
        let per_square_metre = f64::from(scene.maps.texels_per_metre).powi(2);
        Some(Box::new(move |patch| Some(patch.area() * per_square_metre)))
    }

    fn report(world: &World, round: &mut Round) {
        let scenes = world.resource::<IntervalScenes>();
        for light in &scenes.lights {
            match &light.scene {
                Err(fault) => {
                    let effect = if has_companion(world, light) {
                        "The light's other technique alone shadows it"
                    } else {
                        "The light has no shadow"
                    };
                    round.state(
                        Some(light.entity),
                        fault.code(),
                        format_args!("{effect}: {fault}."),
                    );
                }
                Ok(scene) => {
                    if let Some(scene) = scenes.scenes.get(*scene) {
                        report_scene(world, light, scene, round);
                    }
                }
            }
        }
    }

    #[cfg(feature = "serde")]
    fn parse(from: &mut dyn erased_serde::Deserializer) -> Result<Self, erased_serde::Error> {
        let settings: Self = erased_serde::deserialize(from)?;
        // A clock that runs on may go beyond the path. A file that does is a mistake.
        if !(0.0..=1.0).contains(&settings.time) {
            let message = format!(
                "time is {}, it must be a share of the path, 0 to 1",
                settings.time
            );
            return Err(serde::de::Error::custom(message));
        }
        Ok(settings)
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
