//! Ray-cast visibility of the lights of a stage, and the picture that the renderer would draw with it.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    HitImage, LightSource, RayScene, VisibilityImage, hard_visibility, primary_hits, soft_visibility,
};
use antumbra::techniques::Settings;
use bevy_transform::prelude::GlobalTransform;

use super::support::given::{GivenPicture, GivenVisibility, opaque_alone};
use super::support::stage::{Stage, one_line};
use super::way::shadow;

/// Number of samples of a light with a size at each judged pixel.
pub const SAMPLES: u32 = 1024;

/// Number of samples of a light with a size at each pixel of a picture, which has many pixels for each judged one.
const PICTURE_SAMPLES: u32 = 16;

/// Seed of all samples.
const SEED: u64 = 7;

/// Ray-cast visibility of a light.
pub struct Truth {
    /// Visibility of each pixel; NaN where the pixel does not count.
    pub image: VisibilityImage,
    /// Whether the light has a size, so that its shadows are soft.
    pub is_soft: bool,
}

/// The scene as rays see it.
pub struct RayScenes {
    /// All surfaces.
    pub all: RayScene,
    /// The scene with blended surfaces that the camera does not see; `None` if there are none.
    pub opaque: Option<RayScene>,
}

impl RayScenes {
    /// Returns the scene of a stage.
    pub fn of(stage: &mut Stage) -> Self {
        let all = RayScene::from_world(&mut stage.world);
        let opaque = opaque_alone(&stage.world, &all);
        Self { all, opaque }
    }
}

/// Returns the surfaces that the camera saw in the last frame.
///
/// # Errors
/// The stage has no camera, or one that sees nothing.
pub fn surfaces(stage: &Stage, scene: &RayScene) -> Result<HitImage, String> {
    let world = &stage.world;
    let (Some(camera), Some(transform)) = (
        world.get::<Camera>(stage.camera),
        world.get::<GlobalTransform>(stage.camera),
    ) else {
        return Err("the stage has no camera".to_owned());
    };
    let size = world.resource::<ViewportSize>().0;
    primary_hits(scene, camera, transform, size).map_err(|error| one_line(&error))
}

/// Casts rays to every light of the last frame; `None` for a light that cannot shine.
///
/// # Errors
/// The stage has no camera, or one that sees nothing.
pub fn of_lights(stage: &Stage, scene: &RayScene, samples: u32) -> Result<Vec<Option<Truth>>, String> {
    let hits = surfaces(stage, scene)?;
    let of_light = |&light| {
        let source = LightSource::of_entity(&stage.world, light).ok()?;
        let is_soft = has_size(stage.world.get::<Light>(light)?);
        let image = if is_soft {
            soft_visibility(scene, &hits, &source, samples, SEED)
        } else {
            hard_visibility(scene, &hits, &source)
        };
        Some(Truth { image, is_soft })
    };
    Ok(stage.lights.iter().map(of_light).collect())
}

/// Whether a light has a size, so that it has penumbrae.
pub fn has_size(light: &Light) -> bool {
    match light.kind {
        LightKind::Rect { width, height } => width > 0.0 || height > 0.0,
        LightKind::Sphere { radius } => radius > 0.0,
        LightKind::Point | LightKind::Spot { .. } | LightKind::Directional => false,
    }
}

/// Draws the picture that the renderer would draw with ray-cast visibility. Opaque surfaces have their own shadows, behind
/// glass too. Of blended surfaces, only the nearest at a pixel has shadows, as in every frame. Removes the techniques from
/// the lights.
///
/// # Errors
/// Something that the device refuses, or a camera that sees nothing.
pub fn picture(stage: &mut Stage, scenes: &RayScenes) -> Result<Vec<u8>, String> {
    stage.run();
    let nearest = given(of_lights(stage, &scenes.all, PICTURE_SAMPLES)?);
    let opaque = match &scenes.opaque {
        Some(scene) => given(of_lights(stage, scene, PICTURE_SAMPLES)?),
        None => vec![None; nearest.len()],
    };
    for (light, (nearest, opaque)) in stage
        .lights
        .clone()
        .into_iter()
        .zip(nearest.into_iter().zip(opaque))
    {
        let settings = Settings::of(GivenVisibility { nearest, opaque });
        shadow(stage, light, Some(&settings));
    }
    let picture = stage.picture().map_err(|error| one_line(&error))?;
    for light in stage.lights.clone() {
        shadow(stage, light, None);
    }
    Ok(picture)
}

fn given(truths: Vec<Option<Truth>>) -> Vec<Option<Arc<GivenPicture>>> {
    let of_light = |truth: Option<Truth>| Some(Arc::new(GivenPicture::of(&truth?.image)));
    truths.into_iter().map(of_light).collect()
}
