//! The perspective map as a technique.

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;

use super::component::{PerspectiveFaces, PerspectiveMap};
use super::fit::{Fit, Scratch, fit_faces};
use super::fit_input::FitInput;
#[cfg(feature = "render")]
use super::gpu::{self, recorder::PerspectiveNode};
use super::grounds::{BLUR_REACH, BlurredGrounds, collect_blurred_grounds};
use super::parts::{MeshParts, Receiver, collect_boxes};
use super::reports;
use crate::debug_lines::DebugLines;
use crate::geometry::Aabb;
#[cfg(feature = "render")]
use crate::render::shaders::ShaderFile;
#[cfg(feature = "render")]
use crate::render::{Gpu, RenderError};
use crate::reports::Round;
use crate::scene::changes::any_changed;
use crate::scene::{Light, LightKind, SceneMesh};
use crate::sets::{FrameLight, FrameLights, Needs, Objects, View, VisibleParts};
use crate::silhouettes::KEPT_FRAMES;
use crate::techniques::maps::request::{LightRequest, MapFaces, MapRequests, MapSystems};
use crate::techniques::maps::{self, systems};
use crate::techniques::registry::{Refusal, Statistics, Technique, TexelLookup};

/// How the perspective maps of this frame were fitted. Written by `request_perspective_maps`.
#[derive(Resource, Clone, Debug, Default)]
pub struct PerspectiveMaps {
    /// Indices of lights in [`FrameLights`], ascending, and how the light's map was fitted. Lights whose map
    /// has nothing to show are left out.
    pub fits: Vec<(usize, Fit)>,
    /// Number of lights whose faces were fitted in this frame. Other lights keep theirs, because nothing changed.
    pub fitted_anew: usize,
    /// Sorted by entity.
    known: Vec<Known>,
    scratch: Scratch,
    parts: MeshParts,
    boxes: Vec<Aabb>,
}

/// The faces of one light, which are kept while nothing changes.
#[derive(Clone, Debug)]
struct Known {
    light: Entity,
    /// The input of the fit beside the light, the view and the objects.
    input: Option<Input>,
    fitted: Option<(MapFaces, Fit)>,
    /// Number of frames since the light needed several faces.
    idle: u64,
    in_use: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Input {
    settings: PerspectiveMap,
    blur_metres: f64,
    clearance: f64,
}

impl Known {
    fn new(light: Entity) -> Self {
        Self {
            light,
            input: None,
            fitted: None,
            idle: KEPT_FRAMES,
            in_use: true,
        }
    }

    /// Returns whether the texture has layers for several faces. It gets them at once and loses them late, so that a light
    /// which needs them now and then does not replace its texture each time.
    fn has_several(&mut self, is_directional: bool) -> bool {
        self.idle = match &self.fitted {
            // The distance between the two limits of the fit keeps these from coming and going.
            Some((_, fit)) if fit.replaces_one && is_directional => KEPT_FRAMES,
            Some((_, fit)) if fit.faces > 1 => 0,
            _ => self.idle.saturating_add(1),
        };
        let needs_several = self.fitted.as_ref().is_some_and(|(_, fit)| fit.faces > 1);
        needs_several || self.idle < KEPT_FRAMES
    }
}

impl PerspectiveMaps {
    /// Returns how a light's map was fitted.
    pub fn of_light(&self, light: usize) -> Option<&Fit> {
        let at = self.fits.binary_search_by_key(&light, |(light, _)| *light).ok()?;
        Some(&self.fits[at].1)
    }

    /// Returns where the faces of a light are kept.
    fn known_index(&mut self, light: Entity) -> usize {
        match self.known.binary_search_by_key(&light, |known| known.light) {
            Ok(at) => at,
            Err(at) => {
                self.known.insert(at, Known::new(light));
                at
            }
        }
    }
}

/// The scene and the view for which maps are fitted.
#[derive(SystemParam)]
pub struct FitScene<'w, 's> {
    lights: Res<'w, FrameLights>,
    objects: Res<'w, Objects>,
    view: Res<'w, View>,
    grounds: Res<'w, BlurredGrounds>,
    visible: Res<'w, VisibleParts>,
    meshes: Query<'w, 's, Receiver>,
    every_mesh: Query<'w, 's, Ref<'static, SceneMesh>>,
}

impl FitScene<'_, '_> {
    /// Distance to which the blur of the grounds that a light lights reaches, metres; 0 if it lights none.
    fn blur_metres(&self, light: &FrameLight) -> f64 {
        let lit = self.grounds.receivers.iter();
        let lit = lit.filter(|(object, _)| light.sets.i.contains(*object));
        let radius = |channel: u32| self.grounds.grounds[channel as usize].radius;
        BLUR_REACH * lit.map(|(_, channel)| radius(*channel)).fold(0.0, f64::max)
    }
}

/// Mean side of a texel on the screen, pixels, with as many texels along a side as there are pixels. Fits that are worse get
/// more texels. Chosen so that usual fits have no more.
const MOST_SIDE: f64 = 8.0;

/// The side that takes the place of [`MOST_SIDE`] where the slide is set: it is then not measured, and may be far from the best.
const MOST_SIDE_OF_SET: f64 = 2.0;

/// The side that takes the place of [`MOST_SIDE`] for a light at a position. Where texels are larger, creases of rooms are dark.
const MOST_SIDE_AT_POSITION: f64 = 2.0;

/// Fits the faces of the lights that a [`PerspectiveMap`] shadows to what the view shows, and lists their
/// requests.
///
/// Set: `BuildTechniques`, before `ask_for_maps`. Reads [`FrameLights`], [`Objects`] and [`View`]; writes
/// [`MapRequests`] and [`PerspectiveMaps`]. Cost for each light whose sets were computed again: some ten times the number
/// of casters and of the receivers' boxes; the samples, 144, meet each box once. Other lights keep their faces.
pub fn request_perspective_maps(
    mut requests: ResMut<MapRequests>,
    mut maps: ResMut<PerspectiveMaps>,
    scene: FitScene,
    components: Query<&PerspectiveMap>,
) {
    let maps = &mut *maps;
    maps.fits.clear();
    maps.fitted_anew = 0;
    maps.known.iter_mut().for_each(|known| known.in_use = false);
    let is_exchanged = any_changed(&scene.every_mesh);
    for (index, light) in scene.lights.lights.iter().enumerate() {
        if !light.is_shadowed_by::<PerspectiveMap>() {
            continue;
        }
        let Ok(&settings) = components.get(light.entity) else {
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
        let input = Input {
            settings,
            blur_metres: scene.blur_metres(light),
            clearance: light.clearance,
        };
        request.pictures = input.blur_metres > 0.0;
        request.cached &= !request.pictures;
        let at = maps.known_index(light.entity);
        maps.known[at].in_use = true;
        if light.is_recomputed() || is_exchanged || maps.known[at].input != Some(input) {
            let replaced_one = maps.known[at]
                .fitted
                .as_ref()
                .is_some_and(|(_, fit)| fit.replaces_one);
            maps.known[at].fitted = fit_light(maps, &scene, light, &input, replaced_one);
            maps.known[at].input = Some(input);
            maps.fitted_anew += 1;
        }
        let known = &mut maps.known[at];
        let is_directional = light.light.kind == LightKind::Directional;
        let has_several = known.has_several(is_directional);
        let mut faces = MapFaces::new();
        let mut stretch = 1.0;
        if let Some((fitted_faces, fit)) = &known.fitted {
            faces.clone_from(fitted_faces);
            maps.fits.push((index, *fit));
            let most = match (settings.slide, is_directional) {
                (Some(_), _) => MOST_SIDE_OF_SET,
                (None, true) => MOST_SIDE,
                (None, false) => MOST_SIDE_AT_POSITION,
            };
            stretch = (fit.texel_side / most).max(1.0);
            // The faces of a light at a position are as fine as those of a light in the middle of its receivers.
            if fit.replaces_one && is_directional {
                request.resolution = request.resolution.halved();
            }
        }
        // The number of layers changes rarely, so that textures are not replaced.
        request.layers = if settings.faces == PerspectiveFaces::One && !has_several {
            1
        } else if is_directional {
            5
        } else {
            6
        };
        requests.push(LightRequest {
            light: index,
            request,
            faces,
            stretch,
        });
    }
    maps.known.retain(|known| known.in_use);
}

/// Fits the faces of one light. `None` if there is nothing to show.
fn fit_light(
    maps: &mut PerspectiveMaps,
    scene: &FitScene,
    light: &FrameLight,
    input: &Input,
    replaced_one: bool,
) -> Option<(MapFaces, Fit)> {
    let view = scene.view.data.as_ref();
    let view = view.filter(|_| light.region.scissor.is_some())?;
    collect_boxes(
        light,
        &scene.objects,
        &scene.visible,
        view.eye.as_vec3(),
        &scene.meshes,
        &mut maps.parts,
        &mut maps.boxes,
    );
    let input = FitInput {
        boxes: &maps.boxes,
        view,
        light,
        objects: &scene.objects,
        settings: &input.settings,
        blur_metres: input.blur_metres,
        replaced_one,
    };
    fit_faces(&input, &mut maps.scratch)
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
            of_fit.set("texel_side", fit.texel_side);
            of_fit
        });
        out.set("perspective", fit);
    }

    fn frame_statistics(world: &World, out: &mut Statistics) {
        systems::frame_statistics(world, out);
    }

    fn report(world: &World, round: &mut Round) {
        systems::report::<Self>(world, round);
        reports::report(world, &world.resource::<PerspectiveMaps>().fits, round);
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
