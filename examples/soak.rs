//! A scene that changes in every frame, for thousands of frames: objects and lights come and go, techniques, meshes and
//! materials are swapped, targets shrink to nothing, the device is lost. Prints the memory of the process, and fails if
//! it grows.
//!
//! ```sh
//! cargo run --release --example soak -- --frames 10000
//! ```
//!
//! Set `MALLOC_ARENA_MAX` to 1 for it on Linux: glibc has an arena for each thread, and keeps the memory of threads that are
//! gone with their device.

use std::error::Error;

use antumbra::prelude::*;
use antumbra_stage::soak::Soak;
use clap::Parser;
use glam::UVec2;

/// Share by which the least memory of the last frames may exceed that of the frames before, after the first fifth.
const ALLOWED_GROWTH: f64 = 0.01;

/// Number of frames without objects after which nothing is kept of those that were there.
const REST: u64 = 200;

#[derive(Parser)]
struct Arguments {
    /// Number of frames.
    #[arg(long, default_value_t = 10_000)]
    frames: u64,
    /// Seed of the changes.
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

/// Memory of the process, bytes.
fn memory() -> usize {
    memory_stats::memory_stats().map_or(0, |stats| stats.physical_mem)
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { frames, seed } = Arguments::parse();
    let size = UVec2::new(96, 54);
    let device =
        || pollster::block_on(RenderContext::headless(RequestedFeatures::default())).expect("an adapter");
    let mut soak = Soak::new(size, seed, device)?;
    let (settled, tenth) = (frames / 5, (frames / 10).max(1));
    // Frames take as much memory as their scene needs, so it is compared where the scene is empty. There it still varies with
    // the largest buffers since the last loss of the device, but never falls below what has leaked.
    let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
    let (mut highest, mut at_rest) = (0, Vec::new());
    for frame in 1..=frames {
        soak.step()?;
        highest = highest.max(memory());
        if frame % tenth == 0 {
            soak.clear(REST)?;
            let (most, left) = (mib(highest), memory());
            println!(
                "frame {frame}: at most {most:.1} MiB so far, {:.1} MiB without objects",
                mib(left)
            );
            if frame >= settled {
                at_rest.push(left);
            }
        }
    }
    let (earlier, later) = at_rest.split_at(at_rest.len() / 2);
    let least = |bytes: &[usize]| bytes.iter().copied().min().unwrap_or(1).max(1) as f64;
    let growth = least(later) / least(earlier) - 1.0;
    println!(
        "{} frames with a picture, {} devices lost, memory grew by {:.2} %",
        soak.drawn,
        soak.lost,
        100.0 * growth
    );
    if growth > ALLOWED_GROWTH {
        return Err(format!("memory grew by {:.2} %", 100.0 * growth).into());
    }
    Ok(())
}
