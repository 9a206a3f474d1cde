//! What became of carries that found no room.

use std::sync::atomic::{AtomicU32, Ordering};

use bevy_ecs::prelude::*;

/// Faces that [`VisibilityBuffer::Split8`](super::VisibilityBuffer::Split8) can add at a pixel whatever their values:
/// the leading byte holds 255, a hard shadow's face adds 8 to it. Coverage alone adds 4 there and 7 elsewhere: 36.
pub const SPLIT_CAPACITY: u32 = 255 / 8;

/// Pixels of a recent frame where more faces met than [`SPLIT_CAPACITY`] allows, so that the sum in eight bits may be
/// too small; 0 while all sums are right. Comes some frames late, for nobody waits for the GPU.
#[derive(Resource, Debug, Default)]
pub struct WedgeOverflow(AtomicU32);

impl WedgeOverflow {
    /// The count.
    pub fn pixels(&self) -> u32 {
        self.0.load(Ordering::Relaxed)
    }

    /// Reports a count.
    pub fn set(&self, pixels: u32) {
        self.0.store(pixels, Ordering::Relaxed);
    }
}
