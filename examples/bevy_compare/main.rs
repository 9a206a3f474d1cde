//! Bevy's shadow maps and our shadows in the same rooms, side by side: what they look like, how far each is from the truth
//! of a ray caster, and what each costs.
//!
//! ```sh
//! cargo run --example bevy_compare --features bevy,reference -- --headless --out DIR
//! cargo run --example bevy_compare --features bevy-window,reference
//! ```
//!
//! Without a window it writes pictures, prints errors, and then times frames of 1 to 64 shadowed point lights:
//! `frame LIGHTS bevy_cpu_ms bevy_gpu_ms antumbra_cpu_ms antumbra_gpu_ms`, medians in milliseconds. CPU is all of a frame up
//! to its submission, GPU what the device needs from there on; each frame begins when the device is idle.

mod costs;
mod errors;
#[path = "../support/bevy_frames.rs"]
mod frames;
mod game;
mod rooms;
use antumbra_stage::spread;
#[cfg(feature = "bevy-window")]
mod window;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::Parser;
use glam::UVec2;

/// Bevy's shadow maps beside our shadows.
#[derive(Parser)]
pub struct Arguments {
    /// Without a window: pictures, errors and costs.
    #[arg(long)]
    headless: bool,
    /// Where the pictures go.
    #[arg(long, default_value = "out/bevy_compare")]
    out: PathBuf,
    /// The rooms: a glTF file.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models/interior.glb"))]
    scene: PathBuf,
    /// Width and height of the pictures, pixels.
    #[arg(long, default_value = "320x180", value_parser = parse_size)]
    size: UVec2,
    /// How many lights to time, one row each.
    #[arg(long, default_value = "1,4,9,32,64", value_delimiter = ',')]
    lights: Vec<usize>,
    /// Frames that are timed for each row.
    #[arg(long, default_value_t = 15)]
    frames: usize,
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    let parts = text.split_once('x').map(|(x, y)| (x.parse(), y.parse()));
    match parts {
        Some((Ok(x), Ok(y))) if x > 0 && y > 0 => Ok(UVec2::new(x, y)),
        _ => Err("it must be WIDTHxHEIGHT, both greater than 0".to_owned()),
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let rooms = rooms::Rooms::load(&arguments.scene, arguments.size)?;
    if !arguments.headless {
        #[cfg(feature = "bevy-window")]
        {
            window::run(&rooms);
            return Ok(());
        }
        #[cfg(not(feature = "bevy-window"))]
        return Err(
            "this was built without windows: add --headless, or build with --features bevy-window".to_owned(),
        );
    }
    std::fs::create_dir_all(&arguments.out)
        .map_err(|error| format!("{}: {error}", arguments.out.display()))?;
    errors::compare(rooms, arguments)?;
    let rooms = rooms::Rooms::load(&arguments.scene, arguments.size)?;
    costs::compare(&rooms, arguments);
    Ok(())
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("bevy_compare: {error}");
            ExitCode::FAILURE
        }
    }
}
