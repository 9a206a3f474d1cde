//! Turns a shot file into a picture, the visibility of each light, and statistics.
//!
//! ```sh
//! cargo run --release --example render -- SHOT.json --out DIR
//! ```
//!
//! Writes `image.png` (tonemapped), `image.exr` (linear), `light<i>.visibility.exr` and `stats.json`. Any error is
//! one line on stderr that names the file and the element. The exit status is then 1, and nothing is
//! written; only files before one that the disk does not take stay. A fault of a light or an object is not an error: it
//! is reported in a line on stderr and in `stats.json`.

use antumbra_stage as support;

use std::path::PathBuf;
use std::process::ExitCode;

use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use clap::Parser;
use support::shot::Shot;
use support::stage::{Stage, one_line};
use support::{picture, stats};

/// Renders a shot file.
#[derive(Parser)]
struct Arguments {
    /// The shot file.
    shot: PathBuf,
    /// Folder for the results; created if missing.
    #[arg(long)]
    out: PathBuf,
    /// Factor that multiplies radiance before the tonemap; 0 to 1e6.
    #[arg(long, default_value_t = 1.0, value_parser = exposure)]
    exposure: f32,
    /// Shows only the front faces of materials that are not double-sided. By default every surface is visible from
    /// both sides, because it blocks light from both.
    #[arg(long)]
    cull_back_faces: bool,
    /// Draws the shadow volumes over the picture: depth-pass blue and green, depth-fail orange and magenta.
    #[arg(long)]
    show_volumes: bool,
    /// Requests no device feature beyond WebGPU's baseline.
    #[arg(long)]
    baseline: bool,
    /// Folder with the results of the same shot from another device or version; says how many pixels of the picture
    /// differ from those.
    #[arg(long)]
    against: Option<PathBuf>,
}

fn exposure(text: &str) -> Result<f32, String> {
    let factor: f32 = text.parse().map_err(|error| format!("{error}"))?;
    if (0.0..=1e6).contains(&factor) {
        Ok(factor)
    } else {
        Err(format!("{factor} is not from 0 to 1e6"))
    }
}

fn main() -> ExitCode {
    match render(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            eprintln!("{}", line.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn render(arguments: &Arguments) -> Result<(), String> {
    let shot = Shot::load(&arguments.shot, Techniques::default())?;
    if shot.size.contains(&0) {
        return Err(format!(
            "{}: size: {:?} has no pixels",
            arguments.shot.display(),
            shot.size
        ));
    }
    let mut stage = Stage::of_shot(&shot)?;
    stage
        .load_files()
        .map_err(|error| format!("{}: {error}", arguments.shot.display()))?;
    stage.world.insert_resource(if arguments.cull_back_faces {
        FaceCulling::SingleSided
    } else {
        FaceCulling::None
    });
    let requested = if arguments.baseline {
        RequestedFeatures::BASELINE
    } else {
        RequestedFeatures {
            timestamps: true,
            ..Default::default()
        }
    };
    let in_shot =
        |error: antumbra::render::RenderError| format!("{}: {}", arguments.shot.display(), one_line(&error));
    let context = pollster::block_on(RenderContext::headless(requested)).map_err(in_shot)?;
    let largest = context.device.limits().max_texture_dimension_2d;
    if shot.size.iter().any(|side| *side > largest) {
        return Err(format!(
            "{}: size: {:?} is more than the device allows, {largest} pixels along a side",
            arguments.shot.display(),
            shot.size
        ));
    }
    let settings = RenderSettings {
        ambient: shot.ambient.into(),
        exposure: arguments.exposure,
        debug_volumes: arguments.show_volumes,
        ..Default::default()
    };
    stage.add_renderer(context, settings).map_err(in_shot)?;
    let rendered = stage.render().map_err(in_shot)?;
    stats::print_new_reports(&arguments.shot.display().to_string(), &mut stage);
    let stats = stats::collect(&mut stage, &rendered);

    // Before anything is written: the other picture may be the one that this run replaces.
    if let Some(other) = &arguments.against {
        let path = other.join("image.png");
        let difference = picture::difference(&path, rendered.size, &rendered.picture)?;
        println!("{}: {difference}", path.display());
    }
    let out = &arguments.out;
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    picture::write_png(&out.join("image.png"), rendered.size, &rendered.picture)?;
    picture::write_rgb_exr(&out.join("image.exr"), rendered.size, &rendered.radiance)?;
    for (light, visibility) in rendered.visibility.iter().enumerate() {
        let path = out.join(format!("light{light}.visibility.exr"));
        picture::write_channel_exr(&path, rendered.size, visibility)?;
    }
    let path = out.join("stats.json");
    let text =
        serde_json::to_string_pretty(&stats).map_err(|error| format!("{}: {error}", path.display()))?;
    std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))
}
