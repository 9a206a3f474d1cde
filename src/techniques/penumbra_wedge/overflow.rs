//! Sums that are less exact than a light asks for: in eight bits, some of which ran out of room.

use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};

use bevy_ecs::prelude::*;

/// Number of faces that [`VisibilityBuffer::Split8`](super::VisibilityBuffer::Split8) can add at a pixel
/// whatever their values. The leading byte holds 255, and a face of the hard shadow adds 8 to it. Coverage
/// adds at most 4 to that byte and 7 to the others, so 36 faces of coverage alone fit.
pub const SPLIT_CAPACITY: u32 = 255 / 8;

/// Number of pixels of a recent frame in which more faces met than [`SPLIT_CAPACITY`] allows, so their sum in
/// eight bits may be too small. It is 0 while all sums are right. It arrives some frames late, because
/// nothing waits for the GPU.
#[derive(Resource, Debug, Default)]
pub struct WedgeOverflow(AtomicU32);

impl WedgeOverflow {
    /// Returns the number of pixels.
    pub fn pixels(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    /// Sets the number of pixels.
    pub fn set(&self, pixels: u32) {
        self.0.store(pixels, Ordering::Relaxed);
    }
}

/// Whether the device cannot blend 32-bit floats, so sums are in bytes although lights ask for floats. It is false without
/// a renderer.
#[derive(Resource, Debug, Default)]
pub struct ReducedSums(AtomicBool);

impl ReducedSums {
    /// Returns whether the device cannot blend 32-bit floats.
    pub fn get(&self) -> bool {
        self.0.load(Ordering::Relaxed)
    }

    /// Sets whether the device cannot blend 32-bit floats.
    pub fn set(&self, is_reduced: bool) {
        self.0.store(is_reduced, Ordering::Relaxed);
    }
}
