//! The table of soft shadows: for every model below a folder, a light of 0.5 m at 4 m, what wedges, split wedges and
//! accumulated hard shadows err against ray-cast truth, and what a frame with them takes.
//!
//! Models are scaled to a radius of 1 m and stand on a ground.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, RayScene, SoftError, VisibilityImage, compare_soft, primary_hits, soft_visibility,
};
use antumbra::scene::animation::apply_animation;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::techniques::penumbra_wedge::{CoverageMaths, Overlap, WedgeBounds, WedgeCulling};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use super::support::solid::make_alpha_solid;
use super::support::stage::{Stage, one_line};

/// Samples of the truth.
const SAMPLES: u32 = 1024;

/// Frames that a time is the median of.
const RUNS: usize = 3;

/// Side of the light and its distance from the model's centre, metres.
const LIGHT: (f32, f32) = (0.5, 4.0);

/// What is compared.
enum Way {
    Wedges(&'static str, PenumbraWedge),
    /// So many hard shadows a side of the light.
    Hard(&'static str, u32),
}

fn ways() -> Vec<Way> {
    let wedge = PenumbraWedge::default();
    vec![
        Way::Wedges("wedges", wedge),
        Way::Wedges(
            "eq. 1",
            PenumbraWedge {
                overlap: Overlap::Paper,
                ..wedge
            },
        ),
        Way::Wedges(
            "2x2",
            PenumbraWedge {
                split: [2, 2],
                ..wedge
            },
        ),
        Way::Wedges(
            "3x3",
            PenumbraWedge {
                split: [3, 3],
                ..wedge
            },
        ),
        Way::Hard("hard 4", 2),
        Way::Hard("hard 16", 4),
        Way::Hard("hard 64", 8),
        Way::Wedges(
            "stencil culled",
            PenumbraWedge {
                culling: WedgeCulling::Stencil,
                ..wedge
            },
        ),
        Way::Wedges(
            "tables",
            PenumbraWedge {
                maths: CoverageMaths::Tables,
                ..wedge
            },
        ),
        Way::Wedges(
            "sphere bounds",
            PenumbraWedge {
                bounds: WedgeBounds::Sphere,
                ..wedge
            },
        ),
        Way::Wedges(
            "plain",
            PenumbraWedge {
                culling: WedgeCulling::None,
                bounds: WedgeBounds::Sphere,
                ..wedge
            },
        ),
    ]
}

/// Prints the table of all models below `folder` whose path contains `only`.
///
/// # Errors
/// One line that names the file and the element.
pub fn print(context: &RenderContext, folder: &Path, size: UVec2, only: Option<&str>) -> Result<(), String> {
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    files.retain(|file| only.is_none_or(|only| file.to_string_lossy().contains(only)));
    println!(
        "RMSE over all receivers / over the penumbra, milliseconds of a frame, {size}, {}",
        context.adapter
    );
    let ways = ways();
    let mut header = format!("{:<26}", "model");
    for way in &ways {
        let (Way::Wedges(name, _) | Way::Hard(name, _)) = way;
        header += &format!(" {name:>23}");
    }
    println!("{header}");
    let mut sums = vec![[0.0; 3]; ways.len()];
    let mut models = 0.0;
    for file in &files {
        let Some(mut subject) = Subject::load(context, file, size)? else {
            continue;
        };
        let truth = subject.truth()?;
        let mut line = format!("{:<26}", file.file_stem().unwrap_or_default().to_string_lossy());
        for (way, sum) in ways.iter().zip(&mut sums) {
            let (error, milliseconds) = subject.judge(way, &truth)?;
            line += &format!(
                " {:.4} / {:.4} {milliseconds:>6.1}",
                error.rmse, error.rmse_penumbra
            );
            for (sum, value) in sum
                .iter_mut()
                .zip([error.rmse, error.rmse_penumbra, milliseconds])
            {
                *sum += value;
            }
        }
        models += 1.0;
        println!("{line}");
    }
    let mut line = format!("{:<26}", "mean");
    for [rmse, penumbra, milliseconds] in sums {
        line += &format!(
            " {:.4} / {:.4} {:>6.1}",
            rmse / models,
            penumbra / models,
            milliseconds / models
        );
    }
    println!("{line}");
    Ok(())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    let entries = std::fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for entry in entries {
        let path = entry
            .map_err(|error| format!("{}: {error}", folder.display()))?
            .path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path
            .extension()
            .is_some_and(|extension| extension == "glb" || extension == "gltf")
        {
            files.push(path);
        }
    }
    Ok(())
}

/// A model under its light.
struct Subject {
    stage: Stage,
    scene: RayScene,
    light: Transform,
    range: f32,
}

impl Subject {
    /// `None` for a model without triangles.
    fn load(context: &RenderContext, file: &Path, size: UVec2) -> Result<Option<Self>, String> {
        let mut stage = Stage::empty(size, Camera::default(), Transform::IDENTITY);
        stage.world.insert_resource(FaceCulling::None);
        let added = stage.add_renderer(context.clone(), RenderSettings::default());
        added.map_err(|error| one_line(&error))?;
        let loaded = load_gltf(file).map_err(|error| one_line(&error))?;
        let spawned = spawn_scene(&mut stage.world, &loaded, None).map_err(|error| one_line(&error))?;
        if let Some(clip) = loaded.clips.first() {
            apply_animation(&mut stage.world, &spawned, clip, 0.37 * clip.duration());
        }
        for &light in &spawned.lights {
            stage.world.entity_mut(light).remove::<Light>();
        }
        for &camera in &spawned.cameras {
            stage.world.entity_mut(camera).remove::<Camera>();
        }
        make_alpha_solid(&mut stage);
        stage.schedule.run(&mut stage.world);
        let bounds = stage.scene_bounds();
        if bounds.is_empty() {
            return Ok(None);
        }
        let unit = bounds.half_size().length().max(1e-6);
        stage.spawn_ground(bounds, unit);
        let at = |direction: Vec3, distance: f32| bounds.center() + direction.normalize() * (distance * unit);
        let camera = Camera {
            vertical_fov: 0.9,
            near: 0.01 * unit,
            aspect: size.x as f32 / size.y as f32,
            ..Camera::default()
        };
        let view = Transform::from_translation(at(Vec3::new(0.5, 0.45, 0.9), 2.8))
            .looking_at(bounds.center(), Vec3::Y);
        let entity = stage.camera;
        stage.world.entity_mut(entity).insert((camera, view));
        stage.schedule.run(&mut stage.world);
        let scene = RayScene::from_world(&mut stage.world);
        let light = Transform::from_translation(at(Vec3::new(0.5, 1.0, 0.35), LIGHT.1))
            .looking_at(bounds.center(), Vec3::Z);
        Ok(Some(
            Self {
                stage,
                scene,
                light,
                range: 20.0 * unit,
            }
            .with_unit(unit),
        ))
    }

    fn with_unit(mut self, unit: f32) -> Self {
        self.light.scale = Vec3::splat(unit); // kept here: lights do not look at it
        self
    }

    fn kind(&self) -> LightKind {
        let side = LIGHT.0 * self.light.scale.x;
        LightKind::Rect {
            width: side,
            height: side,
        }
    }

    fn spawn(&mut self, kind: LightKind, transform: Transform, shadow: Option<impl Bundle>) {
        let light = Light {
            kind,
            color: Vec3::ONE,
            intensity: 10.0,
            range: self.range,
        };
        self.stage
            .spawn_light(light, transform.with_scale(Vec3::ONE), shadow);
    }

    fn clear(&mut self) {
        for light in std::mem::take(&mut self.stage.lights) {
            self.stage.world.despawn(light);
        }
    }

    fn truth(&mut self) -> Result<VisibilityImage, String> {
        self.spawn(self.kind(), self.light, None::<PenumbraWedge>);
        self.stage.schedule.run(&mut self.stage.world);
        let world = &self.stage.world;
        let (Some(camera), Some(transform)) = (
            world.get::<Camera>(self.stage.camera),
            world.get::<GlobalTransform>(self.stage.camera),
        ) else {
            return Err("the stage has no camera".to_owned());
        };
        let size = world.resource::<ViewportSize>().0;
        let hits = primary_hits(&self.scene, camera, transform, size).map_err(|error| one_line(&error))?;
        let source = LightSource::of_entity(world, self.stage.lights[0]).map_err(|error| one_line(&error))?;
        let truth = soft_visibility(&self.scene, &hits, &source, SAMPLES, 7);
        self.clear();
        Ok(truth)
    }

    /// Error, and milliseconds of a frame in which nothing moves.
    fn judge(&mut self, way: &Way, truth: &VisibilityImage) -> Result<(SoftError, f64), String> {
        match *way {
            Way::Wedges(_, wedge) => self.spawn(self.kind(), self.light, Some(wedge)),
            Way::Hard(_, side) => {
                let extent = LIGHT.0 * self.light.scale.x;
                for cell in 0..side * side {
                    let share = |cell: u32| ((cell as f32 + 0.5) / side as f32 - 0.5) * extent;
                    let offset = Vec3::new(share(cell % side), share(cell / side), 0.0);
                    let at = self.light.translation + self.light.rotation * offset;
                    self.spawn(
                        LightKind::Point,
                        Transform::from_translation(at),
                        Some(StencilVolume::default()),
                    );
                }
            }
        }
        let rendered = self.stage.render().map_err(|error| one_line(&error))?;
        let count = rendered.visibility.len() as f32;
        let pixels = truth.values().len();
        let mean = (0..pixels)
            .map(|pixel| {
                let values = rendered.visibility.iter().map(|values| values[pixel]);
                values.sum::<f32>() / count
            })
            .collect();
        let got = VisibilityImage::new(truth.size(), mean).map_err(|error| one_line(&error))?;
        let error = compare_soft(truth, &got).map_err(|error| one_line(&error))?;
        let error = error.ok_or("no pixel counts")?;
        let mut times = Vec::new();
        for _ in 0..=RUNS {
            let begin = Instant::now();
            self.stage.time_passes().map_err(|error| one_line(&error))?;
            times.push(begin.elapsed().as_secs_f64() * 1e3);
        }
        times.remove(0);
        times.sort_by(f64::total_cmp);
        self.clear();
        Ok((error, times[RUNS / 2]))
    }
}

impl Stage {
    fn spawn_ground(&mut self, bounds: Aabb, unit: f32) {
        self.world.spawn((
            SceneMesh(Arc::new(MeshData::plane(6.0 * unit))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(bounds.center().with_y(bounds.min.y - 0.01 * unit)),
        ));
    }
}
