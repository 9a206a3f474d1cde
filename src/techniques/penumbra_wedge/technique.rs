//! Penumbra wedges as a technique.

use bevy_ecs::prelude::*;

use super::build_wedges::build_penumbra_wedges;
use super::component::{MAX_SPLIT, MOST_STACKED, Overlap, PenumbraWedge, VisibilityBuffer};
use super::debug_lines;
use super::geometry::cut::MOST_CUTS;
#[cfg(feature = "render")]
use super::gpu::recorder::PenumbraWedgeNode;
use super::light_parts::LEAST_EXTENT;
use super::overflow::{ReducedSums, SPLIT_CAPACITY, WedgeOverflow};
use super::wedges::{LightWedges, PenumbraWedges};
use crate::debug_lines::DebugLines;
#[cfg(feature = "render")]
use crate::render::shaders::{ShaderFile, shader_files};
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::{Light, LightKind};
use crate::sets::{FrameLights, NeededSilhouettes, Needs, View};
use crate::techniques::registry::{Refusal, Technique, TechniqueSystems};

impl Technique for PenumbraWedge {
    const NAME: &'static str = "penumbra_wedge";
    const NEEDS: Needs = Needs {
        silhouettes: NeededSilhouettes::Shadowing,
        receiver_planes: true,
        emitter_texture: true,
        ..Needs::NOTHING
    };

    fn check(&self, _: &Light) -> Result<(), Refusal> {
        match self
            .split
            .into_iter()
            .find(|parts| !(1..=MAX_SPLIT).contains(parts))
        {
            Some(parts) => Err(Refusal::setting(
                "split",
                parts as f32,
                "it must be two numbers of 1 to 8, parts along width and height",
            )),
            None => Ok(()),
        }
    }

    fn init(world: &mut World) {
        world.init_resource::<PenumbraWedges>();
        world.init_resource::<WedgeOverflow>();
        world.init_resource::<ReducedSums>();
    }

    fn add_systems(schedule: &mut Schedule) {
        schedule.add_systems(build_penumbra_wedges.in_set(TechniqueSystems));
    }

    fn report(world: &World, round: &mut Round) {
        for light in &world.resource::<FrameLights>().lights {
            if light.is_shadowed_by::<Self>() && light.emitter.bounding_radius() < LEAST_EXTENT {
                let advice = if light.light.kind == LightKind::Directional {
                    "A directional light has none: use Smoothie or OcclusionTexture for a soft shadow"
                } else {
                    "Use a sphere or a rectangle, give Bevy's PointLight a radius, or add ShadowSoftness"
                };
                round.state(
                    Some(light.entity),
                    1,
                    format_args!(
                        "PenumbraWedge gives a hard shadow here: the light has no size. {advice}, or use StencilVolume, which \
                         is cheaper."
                    ),
                );
            }
        }
        for light in &world.resource::<PenumbraWedges>().lights {
            let counts = light.settings.overlap == Overlap::Sampled
                && light.settings.buffer == VisibilityBuffer::Float
                && light.texture.is_none();
            if counts && light.stacked > MOST_STACKED {
                round.state(
                    Some(light.entity),
                    3,
                    format_args!(
                        "Up to {} surfaces lie one behind the other in this light. PenumbraWedge counts {MOST_STACKED}, \
                         so shadows may be too light. Take ShadowCaster off what is hidden. `Overlap::Additive` counts \
                         more, but errs more wherever penumbrae overlap.",
                        light.stacked
                    ),
                );
            }
            if light.cuts_left_out > 0 {
                round.state(
                    Some(light.entity),
                    4,
                    format_args!(
                        "{} pieces of surfaces that reach into this light block nothing: a caster is cut into at most \
                         {MOST_CUTS} flat pieces, the nearest. Make the light smaller than what is around it, or take \
                         ShadowCaster off what is within it.",
                        light.cuts_left_out
                    ),
                );
            }
        }
        let sums_floats =
            |light: &LightWedges| light.settings.buffer == VisibilityBuffer::Float && light.texture.is_none();
        if world.resource::<ReducedSums>().get()
            && world.resource::<PenumbraWedges>().lights.iter().any(sums_floats)
        {
            round.raise(None, 5, || {
                "Penumbrae that overlap are added up, so soft shadows err several times as much: the device does not blend \
                 32-bit floats. Make it with the feature FLOAT32_BLENDABLE, as `RequestedFeatures::descriptor` does. If the \
                 adapter lacks it, set the buffer to `VisibilityBuffer::Split8`, which says that this is meant."
                    .to_owned()
            });
        }
        let pixels = world.resource::<WedgeOverflow>().pixels();
        if pixels > 0 {
            let view = world.resource::<View>().data.as_ref();
            round.state(
                view.map(|view| view.camera),
                2,
                format_args!(
                    "Soft shadows are too light in {pixels} pixels: more than {SPLIT_CAPACITY} hard faces meet there, \
                     which `VisibilityBuffer::Split8` cannot add up. Use `VisibilityBuffer::Float` or, on a device that \
                     cannot blend 32-bit floats, `VisibilityBuffer::Half`. Or split the light less."
                ),
            );
        }
    }

    fn debug_lines(world: &World, light: usize, out: &mut DebugLines) {
        debug_lines::debug_lines(world, light, out);
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
    const SHADERS: &'static [ShaderFile] = shader_files![
        "common/coverage.wgsl",
        "common/wedge_light.wgsl",
        "common/light_places.wgsl",
        "common/wedge_faces.wgsl",
        "common/wedge_sums.wgsl",
        "common/cut_surface.wgsl",
        "techniques/penumbra_wedge/wedge.wgsl",
        "techniques/penumbra_wedge/resolve.wgsl",
    ];

    #[cfg(feature = "render")]
    type Recorder = PenumbraWedgeNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        PenumbraWedgeNode::new(gpu)
    }
}
