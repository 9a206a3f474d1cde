//! Costs of frames with one, nine and sixty-four lights, as ratios to the same frame without shadows. There is a row for each
//! technique that takes the light by default; one that needs baked maps takes none. The last row replaces a light that has a
//! size by 64 lights with hard shadows, spread over it.
//!
//! ```sh
//! cargo bench --bench techniques -- [--short] [--size 640x360] [--lights 1,9,64] [--repetitions 9] [--models FOLDER] [SCENE.glb …]
//! ```
//!
//! A time is wall clock from the start of the frame to the end of the GPU's work, and the median of the repetitions. The
//! techniques take turns, so that drift affects all of them equally. All lights move in every frame, so that nothing is
//! kept from frame to frame but what a technique keeps of the scene.

use antumbra_stage as support;

use std::path::{Path, PathBuf};
use std::time::Instant;

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::techniques::{Row, Settings, Techniques};
use bevy_transform::prelude::Transform;
use clap::Parser;
use glam::{UVec2, Vec3};
use support::model::Model;
use support::spread::spread;
use support::stage::Stage;

/// Measures frames.
#[derive(Parser)]
struct Arguments {
    /// Runs few repetitions on small pictures, with few lights.
    #[arg(long)]
    short: bool,
    /// Width and height of the pictures, pixels.
    #[arg(long, default_value = "640x360")]
    size: String,
    /// Numbers of lights, each with a column.
    #[arg(long, value_delimiter = ',', default_values_t = [1, 9, 64])]
    lights: Vec<usize>,
    /// Number of measured frames of each row; their median is printed.
    #[arg(long, default_value_t = 9, value_parser = clap::value_parser!(u16).range(1..))]
    repetitions: u16,
    /// Folder that has the scenes, at any depth.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models"))]
    models: PathBuf,
    /// Scenes; those that are not in the folder are left out.
    #[arg(default_values_t = ["interior.glb", "dungeon_A.glb", "town_A.glb"].map(str::to_owned))]
    scenes: Vec<String>,
    /// Cargo passes this to every bench; it has no effect.
    #[arg(long, hide = true)]
    bench: bool,
}

/// Side of the rectangles, as a share of the scene's height.
const SIDE: f32 = 0.1;

/// Spot lights that light a part of the scene.
const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.6,
    outer_angle: 0.8,
};

/// A light without and with a technique.
struct Way {
    name: String,
    shadow: Option<Settings>,
    /// Number of lights with hard shadows that stand for each light.
    samples: usize,
}

fn main() {
    let arguments = Arguments::parse();
    let size = if arguments.short { "96x54" } else { &arguments.size };
    let (width, height) = size.split_once('x').expect("--size is WIDTHxHEIGHT");
    let size = UVec2::new(
        width.parse().expect("width in pixels"),
        height.parse().expect("height in pixels"),
    );
    let repetitions = if arguments.short { 1 } else { arguments.repetitions };
    let counts = if arguments.short {
        &[2][..]
    } else {
        &arguments.lights
    };
    let scenes = if arguments.short {
        &arguments.scenes[..1]
    } else {
        &arguments.scenes
    };
    let context = pollster::block_on(RenderContext::headless(RequestedFeatures::default()))
        .expect("a GPU adapter is needed");
    println!("{}, {size}, median of {repetitions}", context.adapter);
    for scene in scenes {
        let Some(path) = find(&arguments.models, scene) else {
            println!("\n{scene}: not below {}, left out", arguments.models.display());
            continue;
        };
        let mut model = Model::load(&path, &context, size)
            .expect("the scene loads")
            .expect("it has triangles");
        look(&mut model, size);
        let height = model.bounds.half_size().y * 2.0;
        let side = SIDE * height;
        let rect = LightKind::Rect {
            width: side,
            height: side,
        };
        for (title, kind) in [
            ("point lights", LightKind::Point),
            ("spot lights", SPOT),
            ("rectangles of a tenth of the scene's height", rect),
        ] {
            println!("\n{scene}, {title}: ms a frame, and times the unshadowed frame");
            measure(&mut model, kind, counts, repetitions);
        }
    }
}

/// Finds a file below a folder.
fn find(folder: &Path, name: &str) -> Option<PathBuf> {
    let entries = folder.read_dir().ok()?;
    let mut paths: Vec<PathBuf> = entries.flatten().map(|entry| entry.path()).collect();
    paths.sort();
    paths.iter().find_map(|path| {
        if path.is_dir() {
            find(path, name)
        } else {
            path.ends_with(name).then(|| path.clone())
        }
    })
}

/// Lets the camera see the scene from above, from a side.
fn look(model: &mut Model, size: UVec2) {
    let bounds = model.bounds;
    let extent = bounds.half_size() * 2.0;
    let camera = Camera {
        aspect: size.x as f32 / size.y as f32,
        ..Default::default()
    };
    let eye = bounds.center() + Vec3::new(0.0, extent.y + 0.4 * extent.x, 0.55 * extent.z);
    let view = Transform::from_translation(eye).looking_at(bounds.center(), Vec3::Y);
    let entity = model.stage.camera;
    model.stage.world.entity_mut(entity).insert((camera, view));
}

/// Place of one light among `count`, of which a square number stands on a grid over the ground plan.
fn place(bounds: &Aabb, index: usize, count: usize) -> Transform {
    let columns = (count as f64).sqrt().ceil() as usize;
    let share = |k: usize| (k as f32 + 0.5) / columns as f32;
    let extent = bounds.half_size() * 2.0;
    let at = Vec3::new(share(index % columns), 0.8, share(index / columns));
    let down = Transform::default().looking_to(Vec3::NEG_Y, Vec3::Z);
    down.with_translation(bounds.min + extent * at)
}

/// The unshadowed lights, all techniques that take this kind, and 64 hard shadows in place of each rectangle.
fn ways(stage: &mut Stage, kind: LightKind) -> Vec<Way> {
    let way = |name: &str, shadow, samples| Way {
        name: name.to_owned(),
        shadow,
        samples,
    };
    let rows: Vec<Row> = stage.world.resource::<Techniques>().rows().to_vec();
    let mut ways = vec![way("unshadowed", None, 1)];
    for row in &rows {
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 1.0, 1.0)
        };
        if row.defaults().check(&light).is_ok() {
            ways.push(way(row.name(), Some(row.defaults()), 1));
        }
    }
    if matches!(kind, LightKind::Rect { .. }) {
        let hard = rows.iter().find(|row| row.name() == "stencil_volume");
        ways.extend(hard.map(|row| way("64 hard shadows each", Some(row.defaults()), 64)));
    }
    ways
}

fn measure(model: &mut Model, kind: LightKind, counts: &[usize], repetitions: u16) {
    let ways = ways(&mut model.stage, kind);
    for &count in counts {
        let mut times = vec![Vec::new(); ways.len()];
        for repetition in 0..=repetitions {
            for (way, times) in ways.iter().zip(&mut times) {
                if way.samples * count > 64 {
                    continue;
                }
                light_up(model, kind, way, count);
                // Uploads, pictures of the first frames and new pipelines are not measured.
                for frame in 0..2 {
                    shift(&mut model.stage, frame);
                    draw(&mut model.stage);
                }
                if repetition == 0 {
                    print_reports(&mut model.stage, &format!("{}, {count} lights", way.name));
                }
                shift(&mut model.stage, 2);
                let start = Instant::now();
                draw(&mut model.stage);
                if repetition > 0 {
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
        let medians: Vec<Option<f64>> = times
            .iter_mut()
            .map(|times| {
                times.sort_by(f64::total_cmp);
                times.get(times.len() / 2).copied()
            })
            .collect();
        println!("{count} lights");
        for (way, time) in ways.iter().zip(&medians) {
            if let (Some(time), Some(base)) = (time, medians[0]) {
                println!("  {:<24} {time:>9.2} {:>7.2}", way.name, time / base);
            }
        }
    }
}

/// Says what is reported of a way: a light that is short of memory, say, costs less than it should.
fn print_reports(stage: &mut Stage, way: &str) {
    let mut reports = stage.world.resource_mut::<Reports>();
    let new: Vec<_> = reports.drain_new().collect();
    if let Some(first) = new.first() {
        println!("  {way}: {} reports, the first: {}", new.len(), first.message);
    }
}

/// Puts lights in place of those that there are.
fn light_up(model: &mut Model, kind: LightKind, way: &Way, count: usize) {
    let stage = &mut model.stage;
    for light in stage.lights.drain(..) {
        stage.world.despawn(light);
    }
    let extent = model.bounds.half_size() * 2.0;
    let range = if count == 1 {
        extent.length()
    } else {
        0.3 * extent.x.max(extent.z)
    };
    for index in 0..count {
        let place = place(&model.bounds, index, count);
        for sample in 0..way.samples {
            let light = Light {
                kind: if way.samples > 1 { LightKind::Point } else { kind },
                ..Light::point(Vec3::ONE, 10.0 / way.samples as f32, range)
            };
            let mut at = place;
            if let (LightKind::Rect { width, height }, true) = (kind, way.samples > 1) {
                let share = spread(sample).as_vec3() - 0.5;
                at.translation += Vec3::new(share.x * width, 0.0, share.y * height);
            }
            stage.spawn_shadowed(light, at, way.shadow.as_ref());
        }
    }
}

/// Moves every light a little to and fro.
fn shift(stage: &mut Stage, frame: usize) {
    let step = if frame.is_multiple_of(2) { 0.01 } else { -0.01 };
    for &light in &stage.lights {
        if let Some(mut transform) = stage.world.get_mut::<Transform>(light) {
            transform.translation.x += step;
        }
    }
}

/// Draws one frame without reading anything back, and waits for its end.
fn draw(stage: &mut Stage) {
    stage.draw().expect("the frame is drawn");
}
