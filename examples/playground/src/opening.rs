//! Completes a document that is opened with the lights and the camera of its scene.

use antumbra::prelude::*;
use antumbra::scene::gltf_import::{LoadedGltf, spawn_scene};
use antumbra::scene::{apply_animation, camera_place};
use antumbra::techniques::Techniques;
use antumbra_stage::stage::{Stage, blur_grounds, framing_camera, one_line};
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};
use serde_json::Value;

use crate::app::MOST_LIGHTS;
use crate::document::{Document, Eye, LightDoc, light_name, light_value, shadow_of};

/// Gives a document the camera and the lights of its scene where it has none of its own, as they are in the document's
/// pose. Returns the scene's centre and radius.
///
/// # Errors
/// One line that names what the scene does not have.
pub fn complete(
    document: &mut Document,
    loaded: &LoadedGltf,
    techniques: &Techniques,
) -> Result<(Vec3, f32), String> {
    let mut stage = Stage::empty(UVec2::ONE, Camera::default(), Transform::IDENTITY);
    let spawned = spawn_scene(&mut stage.world, loaded, None).map_err(|error| one_line(&error))?;
    blur_grounds(&mut stage.world, (loaded, &spawned), &document.blurred_grounds)?;
    if let Some(pose) = document.pose
        && let Some(clip) = loaded.clips.get(pose.clip)
    {
        apply_animation(&mut stage.world, &spawned, clip, pose.time);
    }
    stage.run();
    let bounds = stage.scene_bounds();
    let (center, radius) = if bounds.is_empty() {
        (Vec3::ZERO, 1.0)
    } else {
        (bounds.center(), bounds.half_size().length().max(1e-3))
    };
    if document.view.is_none() {
        let own = spawned.cameras.first().and_then(|&entity| {
            let camera = *stage.world.get::<Camera>(entity)?;
            let place = camera_place(&stage.world, entity)?;
            Some((camera, place.compute_transform()))
        });
        let (camera, place) = own.unwrap_or_else(|| framing_camera(bounds, 16.0 / 9.0));
        let ahead = (center - place.translation).dot(place.forward().as_vec3());
        document.view = Some(Eye::at(camera, &place, ahead.max(radius * 0.1)));
    }
    if document.lights.is_none() {
        let first = techniques.rows().first().map_or("none", |row| row.name());
        let lights = spawned.lights.iter().enumerate().filter_map(|(index, &entity)| {
            let light = stage.world.get::<Light>(entity)?;
            let place = stage.world.get::<GlobalTransform>(entity)?;
            let mut keys = light_value(light, &place.compute_transform());
            keys.insert("shadow".to_owned(), Value::Object(shadow_of(first)));
            Some(LightDoc::new(light_name(index, &keys), keys, techniques))
        });
        document.lights = Some(lights.take(MOST_LIGHTS).collect());
    }
    Ok((center, radius))
}
