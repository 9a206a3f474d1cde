//! Judges the light that a picture shows. A mask is 1 wherever a scissor, depth bounds or a set cut its light off; the
//! radiance is 0 there.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    HardError, LightShape, LightSource, RayScene, SurfaceHit, VisibilityImage, compare_hard, hard_visibility,
    primary_hits,
};
use bevy_transform::prelude::GlobalTransform;
use glam::Vec3;

use super::support::stage::Stage;

/// Least cosine between a triangle's normal and the direction to the light from which a lit pixel is judged. Normals of
/// vertices may turn a surface away that its triangle turns to the light.
const LEAST_COSINE: f64 = 0.5;

/// Share of range and cone up to which a lit pixel is judged: light fades out towards both.
const REACH_SHARE: f64 = 0.9;

/// Leaves nothing in the picture but the lights: surfaces are matte, nothing glows, and there is no ambient light.
pub fn show_lights_alone(stage: &mut Stage) {
    let matte = Arc::new(Material::matte(Vec3::ONE));
    let mut query = stage.world.query::<&mut SceneMaterials>();
    for mut materials in query.iter_mut(&mut stage.world) {
        materials
            .0
            .iter_mut()
            .for_each(|material| *material = matte.clone());
    }
    let mut renderer = stage.world.resource_mut::<Renderer>();
    renderer.settings.ambient = Vec3::ZERO;
    renderer.settings.background = Vec3::ZERO;
}

/// Compares the radiance of the frame that ran last with the truth for its only light: a surface in shadow has none, and
/// a surface that the light sees well has some.
pub fn judge_radiance(stage: &Stage, scene: &RayScene, radiance: &[f32]) -> HardError {
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("the stage has a camera");
    let transform = world
        .get::<GlobalTransform>(stage.camera)
        .expect("and it stands somewhere");
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(scene, camera, transform, size).expect("the camera is usable");
    let source = LightSource::of_entity(world, stage.lights[0]).expect("the light is usable");
    let visibility = hard_visibility(scene, &hits, &source);
    let judged = |(value, hit): (&f32, &Option<SurfaceHit>)| match hit {
        Some(hit) if *value < 0.5 || is_well_lit(hit, &source) => *value,
        _ => f32::NAN,
    };
    let truth = visibility.values().iter().zip(&hits.hits).map(judged).collect();
    let lit = |pixel: &[f32]| f32::from(u8::from(pixel[..3].iter().any(|channel| *channel > 0.0)));
    let got = radiance.chunks_exact(4).map(lit).collect();
    let image = |values: Vec<f32>| VisibilityImage::new(size, values).expect("a whole picture");
    compare_hard(&image(truth), &image(got)).expect("pictures of one size")
}

/// Whether a surface that the light sees must receive some of it.
fn is_well_lit(hit: &SurfaceHit, source: &LightSource) -> bool {
    let (to_light, axis) = match source.shape {
        LightShape::Directional { towards } => return towards.dot(hit.normal) > LEAST_COSINE,
        LightShape::Point { position } => (position - hit.position, None),
        LightShape::Spot {
            position,
            direction,
            outer_angle,
        } => (position - hit.position, Some((direction, outer_angle))),
        LightShape::Rect { center, .. } | LightShape::Sphere { center, .. } => (center - hit.position, None),
    };
    let Some(towards) = to_light.try_normalize() else {
        return false;
    };
    let in_cone = axis.is_none_or(|(axis, angle)| axis.angle_between(-towards) < REACH_SHARE * angle);
    in_cone && to_light.length() < REACH_SHARE * source.range && towards.dot(hit.normal) > LEAST_COSINE
}
