//! The perspective map as a technique.

use bevy_ecs::prelude::*;

use super::component::{PerspectiveFaces, PerspectiveMap};
use super::fit::{Fit, FitInput, Scratch, fit_faces};
#[cfg(feature = "render")]
use super::gpu::{self, recorder::PerspectiveNode};
use super::grounds::{BLUR_REACH, BlurredGrounds, LeftOut, collect_blurred_grounds};
use super::parts::{MeshParts, Receiver, collect_boxes};
use crate::debug_lines::DebugLines;
use crate::geometry::Aabb;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::{Light, LightKind};
use crate::sets::{FrameLights, Needs, Objects, View, VisibleParts};
use crate::silhouettes::LightClearance;
use crate::techniques::maps::request::{LightRequest, MapFaces, MapRequests, MapSystems};
use crate::techniques::maps::{self, systems};
use crate::techniques::registry::{Refusal, Statistics, Technique, TexelLookup};

/// How the perspective maps of this frame were fitted. Written by `request_perspective_maps`.
#[derive(Resource, Clone, Debug, Default)]
pub struct PerspectiveMaps {
    /// Indices of lights in [`FrameLights`], ascending, and how the light's map was fitted. Lights whose map
    /// has nothing to show are left out.
    pub fits: Vec<(usize, Fit)>,
    scratch: Scratch,
    parts: MeshParts,
    boxes: Vec<Aabb>,
}

impl PerspectiveMaps {
    /// Returns how a light's map was fitted.
    pub fn of_light(&self, light: usize) -> Option<&Fit> {
        let at = self.fits.binary_search_by_key(&light, |(light, _)| *light).ok()?;
        Some(&self.fits[at].1)
    }
}

/// Fits the faces of the lights that a [`PerspectiveMap`] shadows to what the view shows, and lists their
/// requests.
///
/// Set: `BuildTechniques`, before `ask_for_maps`. Reads [`FrameLights`], [`Objects`] and [`View`]; writes
/// [`MapRequests`] and [`PerspectiveMaps`]. Cost: O(receivers + casters) for each light, some ten times.
pub fn request_perspective_maps(
    mut requests: ResMut<MapRequests>,
    mut fitted: ResMut<PerspectiveMaps>,
    lights: Res<FrameLights>,
    objects: Res<Objects>,
    view: Res<View>,
    clearance: Res<LightClearance>,
    grounds: Res<BlurredGrounds>,
    visible: Res<VisibleParts>,
    meshes: Query<Receiver>,
    maps: Query<&PerspectiveMap>,
) {
    let fitted = &mut *fitted;
    fitted.fits.clear();
    for (index, light) in lights.lights.iter().enumerate() {
        if !light.is_shadowed_by::<PerspectiveMap>() {
            continue;
        }
        let Ok(&settings) = maps.get(light.entity) else {
            continue;
        };
        let settings = match light.model.softness {
            Some(softness) => PerspectiveMap {
                filter: settings.filter.softened(softness),
                ..settings
            },
            None => settings,
        };
        let Ok(mut request) = settings.request(&light.light) else {
            continue; // a refused light has no technique in this frame
        };
        let blurs = grounds
            .receivers
            .iter()
            .any(|(object, _)| light.sets.i.contains(*object));
        let widest = grounds
            .grounds
            .iter()
            .map(|ground| ground.radius)
            .fold(0.0, f64::max);
        request.pictures = blurs;
        request.cached &= !blurs;
        let view = view.data.as_ref().filter(|_| light.region.scissor.is_some());
        let fit = view.and_then(|view| {
            let (parts, boxes) = (&mut fitted.parts, &mut fitted.boxes);
            collect_boxes(
                light,
                &objects,
                &visible,
                view.eye.as_vec3(),
                &meshes,
                parts,
                boxes,
            );
            let input = FitInput {
                boxes: &fitted.boxes,
                view,
                light,
                objects: &objects,
                settings: &settings,
                blur_metres: if blurs { BLUR_REACH * widest } else { 0.0 },
                near_share: clearance.share().max(1e-7), // a perspective needs some near plane
            };
            fit_faces(&input, &mut fitted.scratch)
        });
        let mut faces = MapFaces::new();
        if let Some((fitted_faces, fit)) = fit {
            faces = fitted_faces;
            fitted.fits.push((index, fit));
        }
        // The number of layers changes rarely, so that textures are not replaced.
        request.layers = if settings.faces == PerspectiveFaces::One && faces.len() <= 1 {
            1
        } else if light.light.kind == LightKind::Directional {
            5
        } else {
            6
        };
        requests.push(LightRequest {
            light: index,
            request,
            faces,
        });
    }
}

impl Technique for PerspectiveMap {
    const NAME: &'static str = "perspective_map";
    const NEEDS: Needs = maps::NEEDS;

    fn check(&self, light: &Light) -> Result<(), Refusal> {
        self.request(light).map(drop)
    }

    fn init(world: &mut World) {
        systems::init(world);
        world.init_resource::<PerspectiveMaps>();
        world.init_resource::<BlurredGrounds>();
    }

    fn add_systems(schedule: &mut Schedule) {
        systems::add(schedule);
        schedule.add_systems(
            (collect_blurred_grounds, request_perspective_maps)
                .chain()
                .in_set(MapSystems::Request),
        );
    }

    fn statistics(world: &World, light: usize, out: &mut Statistics) {
        systems::statistics(world, light, out);
        let fit = world.resource::<PerspectiveMaps>().of_light(light).map(|fit| {
            let mut of_fit = Statistics::default();
            of_fit.set("near", fit.near);
            of_fit.set("far", fit.far);
            of_fit.set("slide", fit.slide.is_finite().then_some(fit.slide));
            of_fit.set("faces", fit.faces);
            of_fit
        });
        out.set("perspective", fit);
    }

    fn frame_statistics(world: &World, out: &mut Statistics) {
        systems::frame_statistics(world, out);
    }

    fn report(world: &World, round: &mut Round) {
        systems::report::<Self>(world, round);
        for &(entity, left_out) in &world.resource::<BlurredGrounds>().left_out {
            let (code, why) = match left_out {
                LeftOut::TooMany => (
                    2,
                    "four other grounds are blurred already. Remove the component from some, or put grounds into one plane",
                ),
                LeftOut::Radius => (3, "its radius must be finite and greater than 0"),
            };
            round.raise(Some(entity), code, || {
                format!("The shadows of perspective maps are not blurred on this `BlurredGround`: {why}.")
            });
        }
        let view = world.resource::<View>();
        if !view.data.as_ref().is_some_and(|view| view.is_orthographic()) {
            return;
        }
        let lights = &world.resource::<FrameLights>().lights;
        for light in lights.iter().filter(|light| light.is_shadowed_by::<Self>()) {
            round.raise(Some(light.entity), 1, || {
                "The light's perspective map is a uniform one: the view is orthographic, and shows near and far \
                 alike. A ShadowMap or OmniMap is kept from frame to frame and looks the same."
                    .to_owned()
            });
        }
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
    type Recorder = PerspectiveNode;

    #[cfg(feature = "render")]
    fn recorder(gpu: &Gpu) -> Result<Self::Recorder, RenderError> {
        PerspectiveNode::new(gpu)
    }
}
