//! The triangles that may block the rays of one pixel.

use smallvec::SmallVec;

/// Triangles that may block some segments.
#[derive(Debug)]
pub(super) enum Suspects {
    /// No others can.
    Few(SmallVec<[u32; FEW]>),
    /// They are so many that a search for each segment is faster than a look at all.
    Many,
}

impl Suspects {
    /// Whether nothing blocks any of the segments.
    pub fn is_empty(&self) -> bool {
        matches!(self, Self::Few(few) if few.is_empty())
    }
}

/// Largest number of [`Suspects::Few`].
pub(super) const FEW: usize = 24;
