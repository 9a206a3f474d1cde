//! A scene that changes in every frame, for thousands of frames: objects and lights come and go, techniques, meshes and
//! materials are swapped, targets shrink to nothing, the device is lost. Prints the memory that is in use, and fails if it grows
//! after the first fifth of the frames.
//!
//! ```sh
//! cargo run --release --example soak -- --frames 10000
//! ```

use std::error::Error;

use antumbra::prelude::*;
use antumbra_stage::soak::Soak;
use cap::Cap;
use clap::Parser;
use glam::UVec2;

/// Counts what Rust code has allocated. The memory of the process is no measure: it keeps the gaps that the driver and the
/// threads of lost devices leave in the heap of C.
#[global_allocator]
static HEAP: Cap<std::alloc::System> = Cap::new(std::alloc::System, usize::MAX);

/// Share by which the memory of an empty scene on a new device may grow after the first fifth of the frames, while lists grow
/// for larger scenes.
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

/// Memory that is in use, bytes: on the heap of Rust, and of buffers and textures where the backend tells.
fn memory(soak: &Soak) -> usize {
    let report = soak.context().device.generate_allocator_report();
    HEAP.allocated() + report.map_or(0, |report| report.total_allocated_bytes as usize)
}

fn main() -> Result<(), Box<dyn Error>> {
    let Arguments { frames, seed } = Arguments::parse();
    let size = UVec2::new(96, 54);
    let device =
        || pollster::block_on(RenderContext::headless(RequestedFeatures::default())).expect("an adapter");
    let mut soak = Soak::new(size, seed, device)?;
    // Frames take as much memory as their scene needs, and a device keeps the largest buffers and all pipelines that its
    // scenes needed. Memory is therefore compared where the scene is empty and the device is new.
    let mib = |bytes: usize| bytes as f64 / f64::from(1 << 20);
    let tenth = (frames / 10).max(1);
    let (mut highest, mut first, mut most_later) = (0, None, 0);
    for frame in 1..=frames {
        soak.step()?;
        highest = highest.max(memory(&soak));
        if frame % tenth != 0 {
            continue;
        }
        soak.clear(REST)?;
        soak.lose_the_device()?;
        soak.clear(REST)?;
        let left = memory(&soak);
        if frame == 2 * tenth {
            first = Some(left);
        } else if first.is_some() {
            most_later = left.max(most_later);
        }
        let process = memory_stats::memory_stats().map_or(0, |stats| stats.physical_mem);
        let (most, left, process) = (mib(highest), mib(left), mib(process));
        println!(
            "frame {frame}: at most {most:.2} MiB so far, {left:.2} MiB in an empty scene, process {process:.0} MiB"
        );
    }
    let growth = first.map_or(0.0, |first| most_later as f64 / first as f64 - 1.0);
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
