//! The table of soft shadows. For every model below a folder, under a light of 0.5 m at 4 m, it gives the errors of
//! wedges, split wedges, occlusion textures and accumulated hard shadows against ray-cast truth, and the time of a frame with each.
//!
//! Models are scaled to a radius of 1 m and stand on a ground.

use std::path::{Path, PathBuf};
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, RayScene, SoftError, VisibilityImage, compare_soft, primary_hits, soft_visibility,
};
use antumbra::techniques::penumbra_wedge::{
    CoverageMaths, Overlap, WedgeBounds, WedgeCulling, WedgeSilhouette,
};
use antumbra::techniques::{OcclusionTexture, SliceFilter};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use super::support::model::Model;
use super::support::stage::{Stage, one_line};

/// Number of samples of the truth.
const SAMPLES: u32 = 1024;

/// Number of frames of which a time is the median.
const RUNS: usize = 3;

/// Side of the light, and its distance from the model's centre, metres.
const LIGHT: (f32, f32) = (0.5, 4.0);

/// A way to draw soft shadows.
enum Way {
    Wedges(&'static str, PenumbraWedge),
    Slices(&'static str, OcclusionTexture),
    /// Accumulated hard shadows; the number is the count along a side of the light.
    Hard(&'static str, u32),
}

impl Way {
    fn name(&self) -> &'static str {
        let (Self::Wedges(name, _) | Self::Slices(name, _) | Self::Hard(name, _)) = self;
        name
    }
}

fn ways() -> Vec<Way> {
    let wedge = PenumbraWedge::default();
    vec![
        Way::Wedges("wedges", wedge),
        Way::Wedges(
            "additive",
            PenumbraWedge {
                overlap: Overlap::Additive,
                ..wedge
            },
        ),
        Way::Wedges(
            "eq. 1",
            PenumbraWedge {
                overlap: Overlap::Paper,
                ..wedge
            },
        ),
        Way::Wedges(
            "2x1",
            PenumbraWedge {
                split: [2, 1],
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
            "center",
            PenumbraWedge {
                silhouette: WedgeSilhouette::Center,
                ..wedge
            },
        ),
        Way::Wedges(
            "center 2x2",
            PenumbraWedge {
                split: [2, 2],
                silhouette: WedgeSilhouette::Center,
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
        Way::Slices("16 slices", slices(16, SliceFilter::NBuffers)),
        Way::Slices("8 slices", slices(8, SliceFilter::NBuffers)),
        Way::Slices("4 slices", slices(4, SliceFilter::NBuffers)),
        Way::Slices("8 mipmaps", slices(8, SliceFilter::Mipmaps)),
        Way::Slices("8 sums", slices(8, SliceFilter::SummedAreas)),
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

fn slices(slices: u32, filter: SliceFilter) -> OcclusionTexture {
    OcclusionTexture {
        slices,
        filter,
        ..Default::default()
    }
}

/// Selects rows and columns of the table.
pub struct Choice<'a> {
    /// Parts of the paths of the models to show, separated by commas. Default: all.
    pub only: Option<&'a str>,
    /// Names of the ways to show, separated by commas. Default: all.
    pub ways: Option<&'a str>,
}

/// Prints the table of the models below `folder`.
///
/// # Errors
/// One line that names the file and the element.
pub fn print(context: &RenderContext, folder: &Path, size: UVec2, choice: &Choice) -> Result<(), String> {
    let mut files = Vec::new();
    collect(folder, &mut files)?;
    files.sort();
    if let Some(only) = choice.only {
        let is_wanted = |file: &PathBuf| only.split(',').any(|part| file.to_string_lossy().contains(part));
        files.retain(is_wanted);
        if files.is_empty() {
            return Err(format!(
                "--only {only}: no model below {} has this in its path",
                folder.display()
            ));
        }
    }
    println!(
        "RMSE over all receivers / over the penumbra, milliseconds of a frame (wall clock, median), {size}, {}",
        context.adapter
    );
    let mut ways = ways();
    if let Some(named) = choice.ways {
        ways.retain(|way| named.split(',').any(|name| name == way.name()));
    }
    let mut header = format!("{:<26}", "model");
    for way in &ways {
        header += &format!(" {:>23}", way.name());
    }
    println!("{header}");
    let mut sums: Vec<Vec<(f64, Option<f64>, f64)>> = vec![Vec::new(); ways.len()];
    let mut rows = Vec::new();
    let mut failures = Vec::new();
    for file in &files {
        let Some(mut subject) = Subject::load(context, file, size)? else {
            continue;
        };
        let truth = subject.truth()?;
        let name = file.file_stem().unwrap_or_default().to_string_lossy();
        let mut line = format!("{name:<26}");
        let mut row = Vec::new();
        for (way, sums) in ways.iter().zip(&mut sums) {
            match subject.judge(way, &truth) {
                Ok((error, milliseconds)) => {
                    let penumbra = error.penumbra_rmse();
                    let shown =
                        penumbra.map_or_else(|| format!("{:>6}", "–"), |penumbra| format!("{penumbra:.4}"));
                    line += &format!(" {:.4} / {shown} {milliseconds:>6.1}", error.rmse);
                    sums.push((error.rmse, penumbra, milliseconds));
                    row.push(penumbra.map(|penumbra| [penumbra, milliseconds]));
                }
                Err(reason) => {
                    row.push(None);
                    subject.clear();
                    line += &format!(" {:>23}", "-");
                    failures.push(format!("{}: {}: {reason}", file.display(), way.name()));
                }
            }
        }
        println!("{line}");
        rows.push((name.into_owned(), row));
    }
    let mut line = format!("{:<26}", "mean");
    for sums in sums {
        let mean = |values: Vec<f64>| values.iter().sum::<f64>() / values.len() as f64;
        line += &format!(
            " {:.4} / {:.4} {:>6.1}",
            mean(sums.iter().map(|sum| sum.0).collect()),
            mean(sums.iter().filter_map(|sum| sum.1).collect()),
            mean(sums.iter().map(|sum| sum.2).collect())
        );
    }
    println!("{line}");
    print_against_hard(&ways, &rows);
    for failure in failures {
        println!("{failure}");
    }
    Ok(())
}

/// Compares each way with 64 hard shadows, if they are in the table. Prints the share of their frame's time that the
/// way takes, and on how many models it has a smaller error in less than a quarter of that time. Lists the models on
/// which no way does.
fn print_against_hard(ways: &[Way], rows: &[(String, Vec<Option<[f64; 2]>>)]) {
    let Some(hard) = ways.iter().position(|way| way.name() == "hard 64") else {
        return;
    };
    let mut without: Vec<&str> = Vec::new();
    let mut shares = vec![Vec::new(); ways.len()];
    let mut better = vec![0; ways.len()];
    let mut judged = 0;
    for (name, row) in rows {
        let Some([hard_error, hard_time]) = row[hard] else {
            continue;
        };
        judged += 1;
        let mut found = false;
        for (i, cell) in row.iter().enumerate().filter(|(i, _)| *i != hard) {
            if let Some([error, time]) = *cell {
                shares[i].push(time / hard_time);
                let is_better = error < hard_error && time < 0.25 * hard_time;
                better[i] += usize::from(is_better);
                found |= is_better;
            }
        }
        if !found {
            without.push(name);
        }
    }
    println!("of {judged} models with 64 hard shadows:");
    for ((way, shares), better) in ways.iter().zip(&mut shares).zip(better) {
        shares.sort_by(f64::total_cmp);
        if let Some(median) = shares.get(shares.len() / 2) {
            println!(
                "{:<16} median share of their frame {median:.2}; less error over the penumbra for less than a quarter: {better}",
                way.name()
            );
        }
    }
    println!("no way: {}", without.join(", "));
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
    /// The model's radius, metres.
    unit: f32,
}

impl Subject {
    /// Loads a model; `None` if it has no triangles.
    fn load(context: &RenderContext, file: &Path, size: UVec2) -> Result<Option<Self>, String> {
        let Some(Model {
            mut stage, bounds, ..
        }) = Model::load(file, context, size)?
        else {
            return Ok(None);
        };
        let unit = bounds.half_size().length().max(1e-3);
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
        stage.run();
        let scene = RayScene::from_world(&mut stage.world);
        let light = Transform::from_translation(at(Vec3::new(0.5, 1.0, 0.35), LIGHT.1))
            .looking_at(bounds.center(), Vec3::Z);
        Ok(Some(Self {
            stage,
            scene,
            light,
            unit,
        }))
    }

    fn kind(&self) -> LightKind {
        let side = LIGHT.0 * self.unit;
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
            range: 20.0 * self.unit,
        };
        self.stage.spawn_light(light, transform, shadow);
    }

    fn clear(&mut self) {
        for light in std::mem::take(&mut self.stage.lights) {
            self.stage.world.despawn(light);
        }
    }

    fn truth(&mut self) -> Result<VisibilityImage, String> {
        self.spawn(self.kind(), self.light, None::<PenumbraWedge>);
        self.stage.run();
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

    /// Returns the error, and the milliseconds of a frame in which nothing moves.
    fn judge(&mut self, way: &Way, truth: &VisibilityImage) -> Result<(SoftError, f64), String> {
        match *way {
            Way::Wedges(_, wedge) => self.spawn(self.kind(), self.light, Some(wedge)),
            Way::Slices(_, slices) => self.spawn(self.kind(), self.light, Some(slices)),
            Way::Hard(_, side) => {
                let extent = LIGHT.0 * self.unit;
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
