//! Table 15-1 of GPU Gems for any scene: the batches and frame time that each kind of visibility saves over a walk.
//!
//! ```sh
//! cargo run --release --all-features --example visibility_table -- SCENE.glb ... [--frames N] [--json] [--out DIR --light N]
//! ```
//!
//! Each row has everything that the rows before it have. The scene's own lights shine, all with stencil shadow
//! volumes, and the camera walks from room to room. `--out` writes a picture of the sets, seen from above, for one
//! light and one frame. What cannot be done for a scene is a line on stderr, and the other scenes are still measured. Source of the chapter's numbers: O'Rorke 2004, GPU Gems ch. 15, table 15-1.

use antumbra_stage as support;
mod top_view;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Duration;

use antumbra::prelude::*;
use antumbra::schedule::SetTimes;
use clap::Parser;
use glam::UVec2;
use serde_json::json;
use support::stage::one_line;
use support::stats::Batches;
use support::table::{Row, Walked, rows};

/// Prints the batches and the frame time that each kind of visibility saves over a walk through a scene.
#[derive(Parser)]
struct Arguments {
    /// glTF files.
    #[arg(required = true)]
    scenes: Vec<PathBuf>,
    /// Number of views along the walk.
    #[arg(long, default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..=100_000))]
    frames: u32,
    /// Width of the picture, pixels; it is 16 : 9.
    #[arg(long, default_value_t = 320, value_parser = clap::value_parser!(u32).range(16..=4096))]
    width: u32,
    /// Prints JSON instead of a table.
    #[arg(long)]
    json: bool,
    /// Folder for pictures of the sets, one for each scene; created if missing.
    #[arg(long)]
    out: Option<PathBuf>,
    /// Light of the pictures, by its index in the file. Default: the light that lights most.
    #[arg(long)]
    light: Option<usize>,
    /// Frame of the pictures.
    #[arg(long, default_value_t = 0)]
    frame: u32,
}

/// One row of one scene, measured.
struct Measured {
    row: Row,
    batches: Batches,
    time: Duration,
    /// CPU time of the sets in all frames.
    sets: Duration,
}

/// One scene, measured.
struct Scene {
    name: String,
    frames: usize,
    rows: Vec<Measured>,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(line) => {
            tell(&line);
            ExitCode::FAILURE
        }
    }
}

/// Prints an error as one line.
fn tell(line: &str) {
    eprintln!("{}", line.replace('\n', " "));
}

/// Measures all scenes, and prints those that could be measured. Returns whether nothing failed; what did has been told.
fn run(arguments: &Arguments) -> Result<bool, String> {
    let context = pollster::block_on(RenderContext::headless(RequestedFeatures::default()))
        .map_err(|error| one_line(&error))?;
    let size = UVec2::new(arguments.width, (arguments.width * 9 / 16).max(1));
    let mut scenes = Vec::new();
    let mut is_done = true;
    for path in &arguments.scenes {
        let (mut walked, measured) = match walk(path, &context, size, arguments.frames as usize) {
            Ok(walk) => walk,
            Err(error) => {
                tell(&error);
                is_done = false;
                continue;
            }
        };
        if !arguments.json {
            print(&measured);
        }
        if let Some(out) = &arguments.out {
            let frame = (arguments.frame as usize).min(walked.views.len() - 1);
            let picture = out.join(format!("{}.png", measured.name));
            if let Err(error) = top_view::write(&mut walked, frame, arguments.light, &picture) {
                tell(&error);
                is_done = false;
            }
        }
        scenes.push(measured);
    }
    if arguments.json {
        let all: Vec<_> = scenes.iter().map(to_json).collect();
        println!("{:#}", json!({ "adapter": context.adapter, "scenes": all }));
    }
    Ok(is_done)
}

/// Walks through a scene and measures it.
fn walk(path: &Path, context: &RenderContext, size: UVec2, frames: usize) -> Result<(Walked, Scene), String> {
    let mut walked = Walked::new(path, context, size, frames, |_| true)?;
    let name = path.file_stem().unwrap_or_default().to_string_lossy();
    let measured =
        measure(&name, &mut walked).map_err(|error| format!("{}: {}", path.display(), one_line(&error)))?;
    Ok((walked, measured))
}

fn measure(name: &str, walked: &mut Walked) -> Result<Scene, antumbra::render::RenderError> {
    let mut scene = Scene {
        name: name.to_owned(),
        frames: walked.views.len(),
        rows: Vec::new(),
    };
    for row in rows() {
        walked.set_row(&row);
        // A game makes pipelines, silhouettes and the lights' depth buffers only once, so this frame is not timed.
        walked.draw(0)?;
        let mut measured = Measured {
            row,
            batches: Batches::default(),
            time: Duration::ZERO,
            sets: Duration::ZERO,
        };
        for frame in 0..scene.frames {
            let (batches, time) = walked.draw(frame)?;
            measured.batches += batches;
            measured.time += time;
            let times = walked.stage.world.resource::<SetTimes>();
            let at = AntumbraSystems::ALL
                .iter()
                .position(|set| *set == AntumbraSystems::CollectSets);
            measured.sets += at.map_or(Duration::ZERO, |at| times.durations[at]);
        }
        scene.rows.push(measured);
    }
    Ok(scene)
}

impl Scene {
    /// Returns the frame rate of a row, relative to that of the last row.
    fn rate(&self, row: &Measured) -> f64 {
        let last = self.rows.last().map_or(Duration::ZERO, |last| last.time);
        last.as_secs_f64() / row.time.as_secs_f64()
    }

    fn per_frame(&self, sum: usize) -> f64 {
        sum as f64 / self.frames as f64
    }
}

fn print(scene: &Scene) {
    println!("{}, mean of {} frames", scene.name, scene.frames);
    println!(
        "{:<26} {:>10} {:>9} {:>8} {:>8} {:>8} {:>8} {:>8}   {:>16} {:>16}",
        "",
        "Normalized",
        "Batches",
        "ambient",
        "shadow",
        "light",
        "blended",
        "sets ms",
        "chapter, scene 1",
        "chapter, scene 2"
    );
    println!("{:<26} {:>10}", "", "frame rate");
    for row in &scene.rows {
        let [one, two] = row
            .row
            .chapter
            .map(|(rate, batches)| format!("{rate:.2} {batches:>5}"));
        println!(
            "{:<26} {:>10.2} {:>9.1} {:>8.1} {:>8.1} {:>8.1} {:>8.1} {:>8.2}   {one:>16} {two:>16}",
            row.row.name,
            scene.rate(row),
            scene.per_frame(row.batches.total()),
            scene.per_frame(row.batches.ambient),
            scene.per_frame(row.batches.shadow),
            scene.per_frame(row.batches.light),
            scene.per_frame(row.batches.blended),
            row.sets.as_secs_f64() * 1e3 / scene.frames as f64,
        );
    }
    let (first, last) = (&scene.rows[0], &scene.rows[scene.rows.len() - 1]);
    println!(
        "{:.1} % fewer batches than by the frustum alone; {:.1} ms a frame became {:.1} ms\n",
        100.0 * (1.0 - last.batches.total() as f64 / first.batches.total().max(1) as f64),
        first.time.as_secs_f64() * 1e3 / scene.frames as f64,
        last.time.as_secs_f64() * 1e3 / scene.frames as f64,
    );
}

fn to_json(scene: &Scene) -> serde_json::Value {
    let rows: Vec<_> = scene
        .rows
        .iter()
        .map(|row| {
            json!({
                "name": row.row.name,
                "normalized_frame_rate": scene.rate(row),
                "frame_ms": row.time.as_secs_f64() * 1e3 / scene.frames as f64,
                "sets_ms": row.sets.as_secs_f64() * 1e3 / scene.frames as f64,
                "batches": scene.per_frame(row.batches.total()),
                "ambient": scene.per_frame(row.batches.ambient),
                "shadow": scene.per_frame(row.batches.shadow),
                "light": scene.per_frame(row.batches.light),
                "blended": scene.per_frame(row.batches.blended),
                "chapter": row.row.chapter.map(|(rate, batches)| {
                    json!({ "normalized_frame_rate": rate, "batches": batches })
                }),
            })
        })
        .collect();
    json!({ "scene": scene.name, "frames": scene.frames, "rows": rows })
}
