//! What one face shows, and how much of that is not what it should.

use fixedbitset::FixedBitSet;

use super::face::MapFace;
use super::movers::{Movers, Remap};

/// What one face shows.
#[derive(Clone, Debug)]
pub struct FaceState {
    /// Where it stands and how it projects; as drawn.
    pub face: MapFace,
    /// Casters of the still layer, by dense object index.
    pub still: FixedBitSet,
    /// Casters drawn over it.
    pub moving: FixedBitSet,
    /// Changes when the still layer is to be drawn anew; 0: there is none.
    pub still_revision: u64,
    /// Changes when anything of the face is to be drawn anew; 0: it shows nothing yet.
    pub revision: u64,
    /// Frames whose transforms the layers show; 0: they show what is gone.
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

/// How much of a face is not what it should be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Stale {
    Nothing,
    /// What moves.
    Moving,
    /// All of it.
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

    /// Finds how stale the face is.
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

    /// Makes the face show what it should.
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

    /// Follows a new dense index.
    pub(super) fn remap(&mut self, remap: &Remap) {
        let (still, still_lost) = remap.apply(&self.still);
        let (moving, moving_lost) = remap.apply(&self.moving);
        // What is gone stands in the layer still: no set tells any more.
        if still_lost {
            self.still_at = 0;
        }
        if moving_lost {
            self.drawn_at = 0;
        }
        (self.still, self.moving) = (still, moving);
    }
}
