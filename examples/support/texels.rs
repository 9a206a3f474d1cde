//! Texels per pixel of the screen, for each of some maps and for the light's angle to the view: a table for people, a plot,
//! and tests.

use std::path::Path;
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{HitImage, LightSource, Ray, RayScene, camera_rays, hard_visibility, primary_hits};
use antumbra::techniques::Settings;
use antumbra::techniques::maps::{LightMap, MapFace, MapResolution, Maps};
use antumbra::techniques::perspective_map::PerspectiveFaces;
use antumbra::techniques::shadow_map::Cascades;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec2, DVec3, UVec2, Vec3};

use super::model::Model;
use super::stage::{Stage, one_line};

/// Pixels of the views.
pub const SIZE: UVec2 = UVec2::new(96, 54);

/// Texels along a side of a map with all texels in one square.
const SIDE: u32 = 1024;

/// The maps that are compared, with as many texels each, as far as sides are whole.
pub fn maps() -> [(&'static str, Settings); 5] {
    let fixed = |share: f64| MapResolution::Fixed((f64::from(SIDE) * share.sqrt()) as u32);
    let perspective = |slide, faces, share| {
        Settings::of(PerspectiveMap {
            resolution: fixed(share),
            slide,
            faces,
            ..Default::default()
        })
    };
    let cascades = |count| {
        Settings::of(ShadowMap {
            resolution: fixed(1.0 / f64::from(count)),
            cascades: Cascades {
                count,
                ..Default::default()
            },
            ..Default::default()
        })
    };
    [
        ("perspective", perspective(None, PerspectiveFaces::One, 1.0)),
        ("cube", perspective(None, PerspectiveFaces::Cube, 0.25)),
        ("uniform", perspective(Some(1e9), PerspectiveFaces::One, 1.0)),
        ("4 cascades", cascades(4)),
        ("1 cascade", cascades(1)),
    ]
}

/// Texels per pixel: percentiles over the pixels that face the light, and the mean over the nearest tenth.
#[derive(Clone, Copy, Debug, Default)]
pub struct Texels {
    /// 5th percentile.
    pub p5: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// Mean over the nearest tenth.
    pub near: f64,
    /// Number of pixels.
    pub pixels: usize,
}

/// Position of a point in the first face that shows it, texels.
fn texel_of(map: &LightMap, face: &MapFace, point: DVec3) -> Option<DVec2> {
    let clip = face.clip_from_relative(point) * glam::DVec4::W;
    let ndc = clip.truncate() / clip.w;
    let shown = clip.w > 0.0 && ndc.x.abs().max(ndc.y.abs()) <= 1.0 && ndc.z >= 0.0;
    shown.then(|| DVec2::new(ndc.x, ndc.y) * 0.5 * f64::from(map.resolution))
}

fn texels(stage: &Stage, hits: &HitImage, rays: &[Ray], towards: DVec3) -> Texels {
    let Some(map) = stage.world.resource::<Maps>().of_light(0) else {
        return Texels::default();
    };
    let width = SIZE.x as usize;
    let mut all: Vec<(f64, f64)> = Vec::new();
    for (index, hit) in hits.hits.iter().enumerate() {
        let Some(hit) = hit else { continue };
        if hit.normal.dot(towards) < 0.02 || index % width + 1 == width || index + width >= rays.len() {
            continue;
        }
        let on_plane = |ray: &Ray| {
            let t = hit.normal.dot(hit.position - ray.origin) / hit.normal.dot(ray.direction);
            ray.origin + ray.direction * t
        };
        // A hundredth of a pixel to the right, and one down.
        let beside = |other: usize| hit.position + (on_plane(&rays[other]) - hit.position) * 0.01;
        let density = map.faces.iter().find_map(|state| {
            let at = |point: DVec3| texel_of(map, &state.face, point);
            let here = at(hit.position)?;
            let (right, down) = (at(beside(index + 1))?, at(beside(index + width))?);
            Some((right - here).perp_dot(down - here).abs() * 1e4)
        });
        all.push((hit.distance, density.unwrap_or(0.0)));
    }
    if all.is_empty() {
        return Texels::default();
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    let tenth = all.len().div_ceil(10);
    let near = all[..tenth].iter().map(|(_, texels)| texels).sum::<f64>() / tenth as f64;
    let mut sorted: Vec<f64> = all.iter().map(|(_, texels)| *texels).collect();
    sorted.sort_by(f64::total_cmp);
    let at = |share: f64| sorted[((sorted.len() - 1) as f64 * share) as usize];
    Texels {
        p5: at(0.05),
        p50: at(0.5),
        p95: at(0.95),
        near,
        pixels: sorted.len(),
    }
}

/// A plain of 4 km with boxes that are denser near the eye.
pub fn plain() -> Stage {
    let camera = Camera {
        vertical_fov: 0.9,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let view = Transform::from_xyz(0.0, 1.7, 0.0).looking_at(Vec3::new(0.0, 0.0, -10.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    let mut add = |mesh: MeshData, at: Transform| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            (ShadowCaster, ShadowReceiver),
            at,
        ));
    };
    add(MeshData::plane(2000.0), Transform::default());
    for i in 0..40 {
        let distance = 3.0 * 1.18_f32.powi(i);
        let x = ((i * 7) % 11) as f32 / 5.0 - 1.0;
        let half = 0.2 + 0.02 * distance;
        add(
            MeshData::cuboid(Vec3::splat(half)),
            Transform::from_xyz(x * distance * 0.6, half, -distance),
        );
    }
    stage
}

/// Light directions whose angle to the view axis goes from 0° (from behind the viewer) to 180° (towards it).
fn directions(forward: Vec3) -> Vec<(u32, Vec3)> {
    let right = forward.cross(Vec3::Y).normalize();
    let down = -right.cross(forward).normalize();
    let across = (down + right * 0.4).normalize();
    (0..=12)
        .map(|step| {
            let (sin, cos) = (step as f32 * 15.0).to_radians().sin_cos();
            (step * 15, forward * cos + across * sin)
        })
        .collect()
}

/// A scene and a view, judged by a ray caster.
pub struct Judged {
    /// The scene and its view.
    pub stage: Stage,
    rays: RayScene,
    hits: HitImage,
    lines: Vec<Ray>,
    forward: Vec3,
}

impl Judged {
    /// Runs a frame and traces what each pixel shows.
    ///
    /// # Errors
    /// One line, if the view cannot be used.
    pub fn new(mut stage: Stage) -> Result<Self, String> {
        stage.run();
        let rays = RayScene::from_world(&mut stage.world);
        let camera = stage.world.get::<Camera>(stage.camera).ok_or("no camera")?;
        let transform = stage
            .world
            .get::<GlobalTransform>(stage.camera)
            .ok_or("the camera stands nowhere")?;
        let hits = primary_hits(&rays, camera, transform, SIZE).map_err(|error| one_line(&error))?;
        let lines = camera_rays(camera, transform, SIZE).map_err(|error| one_line(&error))?;
        let forward = transform.forward().as_vec3();
        Ok(Self {
            stage,
            rays,
            hits,
            lines,
            forward,
        })
    }

    /// Shines from a direction through a map, and measures texels and, with a renderer, RMSE to the ray caster.
    fn measure(&mut self, direction: Vec3, map: &Settings, with_rmse: bool) -> Result<(Texels, f64), String> {
        let up = if direction.y.abs() > 0.95 {
            Vec3::X
        } else {
            Vec3::Y
        };
        let place = Transform::default().looking_to(direction, up);
        let stage = &mut self.stage;
        for light in stage.lights.drain(..) {
            stage.world.despawn(light);
        }
        let light = stage.spawn_shadowed(Light::directional(Vec3::ONE, 3.0), place, Some(map));
        let mut rmse = 0.0;
        if with_rmse {
            let rendered = stage.render().map_err(|error| one_line(&error))?;
            let source = LightSource::of_entity(&stage.world, light).map_err(|error| one_line(&error))?;
            let truth = hard_visibility(&self.rays, &self.hits, &source);
            let pairs = truth.values().iter().zip(&rendered.visibility[0]);
            let errors = pairs
                .filter(|(truth, _)| !truth.is_nan())
                .map(|(a, b)| f64::from(a - b).powi(2));
            let (sum, count) = errors.fold((0.0, 0), |(sum, count), error| (sum + error, count + 1));
            rmse = (sum / f64::from(count.max(1))).sqrt();
        } else {
            stage.run();
        }
        let towards = -direction.as_dvec3();
        Ok((texels(stage, &self.hits, &self.lines, towards), rmse))
    }

    /// Measures all maps under a light at all angles to the view, with their RMSE if there is a renderer.
    ///
    /// # Errors
    /// One line, if a frame cannot be rendered.
    pub fn rows(&mut self, with_rmse: bool) -> Result<Vec<Row>, String> {
        let mut rows = Vec::new();
        for (angle, direction) in directions(self.forward) {
            let of = |(_, map): &(&str, Settings)| self.measure(direction, map, with_rmse);
            let maps = maps().iter().map(of).collect::<Result<Vec<_>, String>>()?;
            rows.push(Row { angle, maps });
        }
        Ok(rows)
    }
}

/// One angle of the light to the view.
#[derive(Clone, Debug)]
pub struct Row {
    /// Degrees; 0: the light shines along the view, 180: towards the viewer.
    pub angle: u32,
    /// Texels and RMSE of each of [`maps`].
    pub maps: Vec<(Texels, f64)>,
}

/// A model under its ground, seen from within its bounds.
///
/// # Errors
/// One line that names the file.
pub fn model_view(path: &Path, context: &RenderContext) -> Result<Stage, String> {
    let Model {
        mut stage, bounds, ..
    } = Model::load(path, context, SIZE)?.ok_or("the model has no triangles")?;
    let (center, half) = (bounds.center(), bounds.half_size());
    let eye = center + Vec3::new(0.55 * half.x, 0.35 * half.y, 0.75 * half.z);
    let view = Transform::from_translation(eye).looking_at(center - Vec3::Y * (0.4 * half.y), Vec3::Y);
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.002 * half.length(),
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let entity = stage.camera;
    stage.world.entity_mut(entity).insert((camera, view));
    for light in stage.lights.drain(..) {
        stage.world.despawn(light);
    }
    Ok(stage)
}
