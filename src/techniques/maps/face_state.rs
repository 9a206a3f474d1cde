//! What one face shows, what it should show, and the difference.

use fixedbitset::FixedBitSet;

use super::face::MapFace;
use super::movers::{Movers, Remap};

/// What one face shows.
#[derive(Clone, Debug)]
pub struct FaceState {
    /// Position and projection of the face, as drawn.
    pub face: MapFace,
    /// Casters of the still layer, by dense object index.
    pub still: FixedBitSet,
    /// Casters drawn over the still layer, by dense object index.
    pub moving: FixedBitSet,
    /// Changes when the still layer must be drawn again; 0: there is none.
    pub still_revision: u64,
    /// Changes when any part of the face must be drawn again; 0: it shows nothing yet.
    pub revision: u64,
    /// Frames whose transforms the two layers show; 0: they show a caster that is gone.
    still_at: u64,
    drawn_at: u64,
    pub(super) next: Next,
}

/// What a face should show.
#[derive(Clone, Debug)]
pub(super) struct Next {
    pub face: MapFace,
    pub still: FixedBitSet,
    pub moving: FixedBitSet,
    pub stale: Stale,
}

/// Which part of a face is out of date.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stale {
    Nothing,
    /// The moving layer.
    Moving,
    /// Both layers.
    Still,
}

impl FaceState {
    pub(super) fn new(face: MapFace) -> Self {
        Self {
            face,
            still: FixedBitSet::new(),
            moving: FixedBitSet::new(),
            still_revision: 0,
            revision: 0,
            still_at: 0,
            drawn_at: 0,
            next: Next {
                face,
                still: FixedBitSet::new(),
                moving: FixedBitSet::new(),
                stale: Stale::Still,
            },
        }
    }

    /// Determines which part of the face is out of date.
    pub(super) fn compare(&mut self, movers: &Movers, cached: bool) {
        let moved_since = |set: &FixedBitSet, at: u64| set.ones().any(|index| movers.moved_at[index] > at);
        let next = &self.next;
        let still = !cached
            || self.revision == 0
            || self.face != next.face
            || self.still_at == 0
            || self.still != next.still
            || moved_since(&next.still, self.still_at);
        self.next.stale = if still {
            Stale::Still
        } else if self.drawn_at == 0 || self.moving != next.moving || moved_since(&next.moving, self.drawn_at)
        {
            Stale::Moving
        } else {
            Stale::Nothing
        };
    }

    /// Takes over what the face should show, to be drawn.
    pub(super) fn take_in(&mut self, cached: bool, now: u64, revision: &mut u64, all: bool) {
        *revision += 1;
        self.face = self.next.face;
        std::mem::swap(&mut self.still, &mut self.next.still);
        std::mem::swap(&mut self.moving, &mut self.next.moving);
        self.revision = *revision;
        self.drawn_at = now;
        if !cached {
            self.still_revision = 0;
        } else if all || self.next.stale == Stale::Still {
            self.still_revision = *revision;
            self.still_at = now;
        }
        self.next.stale = Stale::Nothing;
    }

    /// Applies a change of the dense indices.
    pub(super) fn remap(&mut self, remap: &Remap) {
        let (still, still_lost) = remap.apply(&self.still);
        let (moving, moving_lost) = remap.apply(&self.moving);
        // The layer still shows what is gone, and no set records that any more.
        if still_lost {
            self.still_at = 0;
        }
        if moving_lost {
            self.drawn_at = 0;
        }
        (self.still, self.moving) = (still, moving);
    }
}
