//! A day of the sun on a ladder against a wall: twelve pictures with the shadows of occlusion interval maps, and a strip of
//! ray-cast truth beside them.
//!
//! After Donnelly and Demers 2004, "Generating Soft Shadows Using Occlusion Interval Maps", GPU Gems, figure 13-4.

use std::path::Path;
use std::sync::Arc;

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, SurfaceHit};
use antumbra::scene::PathPoint;
use antumbra::techniques::{IntervalLibrary, IntervalMaps};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};
use serde_json::{Value, json};

use super::cost::{isolate, restore};
use super::judge::Workbench;
use super::panels::{reduce, tonemapped};
use super::support::picture::write_png;
use super::support::stage::{Stage, one_line};
use super::truth::surfaces;

/// Name for `--only`, file names and links.
pub const NAME: &str = "day";

/// Number of pictures.
const PICTURES: u32 = 12;

/// First and last hour of the sun's path: that part of the shortest day at 40° north in which it shines.
const HOURS: [f32; 2] = [7.4, 16.6];

/// Length of the light, as a share of the path: 20 minutes.
const WIDTH: f32 = 0.036;

/// Texels per metre of the maps, for pictures of [`FULL_HEIGHT`] pixels. Smaller pictures need fewer.
const DENSITY: f32 = 40.0;

/// Height of pictures from which on the maps have [`DENSITY`], pixels.
const FULL_HEIGHT: f32 = 360.0;

/// Number of rays to the light at each pixel of a picture of the truth.
const SAMPLES: u32 = 16;

fn path() -> LightPath {
    LightPath::Sun {
        latitude_degrees: 40.0,
        day: 355.0,
        hours: HOURS,
    }
}

/// Renders the day, and writes its pictures to `out`. Returns a scene of the page, whose pictures have no
/// numbers.
///
/// # Errors
/// One line that names the file and the element.
pub fn draw(bench: &Workbench, out: &Path) -> Result<Value, String> {
    let size = bench.shown();
    let failed = |error: antumbra::render::RenderError| format!("page {NAME}: {}", one_line(&error));
    let mut stage = stage(size);
    let density = DENSITY * (size.y as f32 / FULL_HEIGHT).clamp(0.3, 1.0);
    let settings = BakeSettings {
        texels_per_metre: density,
        ..Default::default()
    };
    let bake = bench
        .beside(|| bake_intervals(&mut stage.world, &path(), &settings, |_| ()))
        .map_err(|error| format!("page {NAME}: {}", one_line(&error)))?;
    let scene = RayScene::from_world(&mut stage.world);
    let settings = RenderSettings {
        ambient: Vec3::new(0.10, 0.12, 0.16),
        background: Vec3::new(0.3, 0.42, 0.6),
        ..Default::default()
    };
    stage
        .add_renderer(bench.context.clone(), settings)
        .map_err(failed)?;
    let maps = Arc::new(bake.maps);
    let mut library = stage.world.resource_mut::<IntervalLibrary>();
    library.insert(NAME, maps.clone());
    let sun = Light::directional(Vec3::new(1.0, 0.95, 0.86), 3.0);
    let light = stage.spawn_light(sun, Transform::IDENTITY, Some(path()));
    let (mut drawn, mut truths) = (Vec::new(), Vec::new());
    for index in 0..PICTURES {
        let time = (index as f32 + 0.5) / PICTURES as f32;
        let minutes = ((HOURS[0] + time * (HOURS[1] - HOURS[0])) * 60.0) as u32;
        let clock = format!("{:02}:{:02}", minutes / 60, minutes % 60);
        let shadow = OcclusionInterval {
            maps: NAME.to_owned(),
            time,
            width: WIDTH,
            ..Default::default()
        };
        stage.world.entity_mut(light).insert(shadow);
        stage.world.insert_resource(ViewportSize(2 * size));
        let picture = bench.beside(|| stage.picture()).map_err(failed)?;
        let picture = reduce(2 * size, &picture, size);
        stage.world.insert_resource(ViewportSize(size));
        let truth = bench.beside(|| truth(&mut stage, light, &scene, (&maps, time)))?;
        for (ways, what, pixels) in [(&mut drawn, "maps", picture), (&mut truths, "truth", truth)] {
            let file = format!("{NAME}-{what}-{index:02}.png");
            write_png(&out.join(&file), size, &pixels)?;
            ways.push(json!({"name": format!("{what}-{index:02}"), "title": clock, "caption": "", "pictures": {"picture": file}}));
        }
    }
    let bytes = maps.bytes() as f64 / 1024.0;
    let caption = format!(
        "Occlusion interval maps at {density} texels a metre, {bytes:.0} KiB. Time is a setting of the frame."
    );
    Ok(json!({
        "name": NAME,
        "title": "A day of the sun",
        "about": "A ladder against a wall, from sunrise to sunset of the shortest day. The sun is a stretch of its path: shadows are soft along it \
                  and hard across it. Compare the maps with the ray-cast truth below.",
        "shots": [
            {"name": "maps", "caption": caption, "truth": null, "ways": drawn},
            {"name": "truth", "caption": "Ray-cast truth of the same stretch of the path", "truth": null, "ways": truths},
        ],
    }))
}

/// A ladder against a wall below a roof, and a camera in the south.
fn stage(size: UVec2) -> Stage {
    let view = Transform::from_xyz(1.4, 1.7, 3.4).looking_at(Vec3::new(0.0, 0.85, -0.2), Vec3::Y);
    let camera = Camera {
        aspect: size.x as f32 / size.y as f32,
        ..Default::default()
    };
    let mut stage = Stage::empty(size, camera, view);
    let mut spawn = |mesh: MeshData, color: [f32; 3], place: Transform| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(color.into()))].into()),
            (ShadowCaster, ShadowReceiver),
            place,
        ));
    };
    let (ground, wall, wood) = ([0.42, 0.38, 0.32], [0.75, 0.7, 0.62], [0.5, 0.3, 0.14]);
    spawn(MeshData::plane(4.0), ground, Transform::IDENTITY);
    let at = Transform::from_xyz;
    spawn(
        MeshData::cuboid(Vec3::new(1.5, 1.0, 0.1)),
        wall,
        at(0.0, 1.0, -0.8),
    );
    let roof = MeshData::cuboid(Vec3::new(1.6, 0.05, 0.35));
    spawn(roof, wood, at(0.0, 2.05, -0.7));
    let leaning = at(0.0, 0.0, 0.1).with_rotation(Quat::from_rotation_x(-0.35));
    for x in [-0.3, 0.3] {
        let rail = MeshData::cuboid(Vec3::new(0.03, 0.9, 0.03));
        spawn(rail, wood, leaning * at(x, 0.9, 0.0));
    }
    for rung in 0..6 {
        let mesh = MeshData::cuboid(Vec3::new(0.28, 0.02, 0.02));
        spawn(mesh, wood, leaning * at(0.0, 0.2 + 0.27 * rung as f32, 0.0));
    }
    stage.run();
    stage
}

/// Draws the picture that the renderer would draw with ray-cast visibility: the frame without the light, and what the light
/// adds to it without shadows, multiplied by its visibility.
fn truth(
    stage: &mut Stage,
    light: Entity,
    scene: &RayScene,
    (maps, time): (&IntervalMaps, f32),
) -> Result<Vec<u8>, String> {
    let failed = |error: antumbra::render::RenderError| one_line(&error);
    // Without the technique the light keeps its place.
    stage.run();
    stage.world.entity_mut(light).remove::<OcclusionInterval>();
    let lit = stage.render().map_err(failed)?.radiance;
    let hits = surfaces(stage, scene)?;
    let taken = isolate(stage, stage.lights.len());
    let mut sum = stage.render().map_err(failed)?.radiance;
    restore(stage, taken);
    for (pixel, seen) in seen_shares(scene, &hits, maps, time).into_iter().enumerate() {
        for channel in 4 * pixel..4 * pixel + 3 {
            sum[channel] += (lit[channel] - sum[channel]) * seen;
        }
    }
    Ok(tonemapped(&sum, 1.0))
}

/// The share of the light that each pixel sees.
fn seen_shares(scene: &RayScene, hits: &HitImage, maps: &IntervalMaps, time: f32) -> Vec<f32> {
    let [start, end] = maps.window(time, WIDTH).spans[0];
    let at = |sample: u32| start + (end - start) * (sample as f32 + 0.5) / SAMPLES as f32;
    let towards: Vec<_> = (0..SAMPLES)
        .filter(|&sample| maps.path.shines(at(sample)))
        .filter_map(|sample| match maps.path.at(at(sample)) {
            PathPoint::Direction(direction) => Some(-direction.as_dvec3()),
            PathPoint::Position(_) => None,
        })
        .collect();
    let seen = |hit: &SurfaceHit| {
        let seen = towards.iter().filter(|towards| {
            hit.normal.dot(**towards) > 0.0
                && !scene.blocks_direction(hit.position, **towards, Some(hit.triangle), u32::MAX)
        });
        seen.count() as f32 / SAMPLES as f32
    };
    hits.hits
        .iter()
        .map(|hit| hit.as_ref().map_or(0.0, seen))
        .collect()
}
