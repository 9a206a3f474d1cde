//! Boxes around boxes: a hierarchy of fan-out 64 over the dense object index.
//!
//! A cluster is one word of every bitset over the objects; a block is 64 clusters.
//! [`Objects`](crate::sets::Objects) puts objects into spatial order, so the 64 objects of a word are
//! neighbours, and a light far from their common box has zeros there. A query tests the boxes of all blocks,
//! then the clusters of the blocks that it touches, then the objects of the clusters that it touches. All
//! tests take eight boxes at a time and follow no pointers.
//!
//! When objects move, the boxes of their words are refitted. The order stays until it has become poor.
//!
//! Measured: 100,000 unit boxes in 400×20×400 m, 64 point lights of 20 m that all move; L, I and S of all,
//! one thread, release:
//!
//! | order of the index | query | ms |
//! | --- | --- | --- |
//! | median splits (`spatial_order.rs`) | blocks, clusters, objects | 1.03 |
//! | cells of a grid along a Z-curve | blocks, clusters, objects | 1.22 |
//! | median splits | all objects, flat | 3.63 |
//! | by entity | all objects, flat | 11.5 |
//! | by entity | blocks, clusters, objects | 11.5 |
//!
//! The order thus matters more than the levels. In the order of entities nearly every word holds some object
//! near any light, and all later steps must look at every word. Two alternatives were not pursued: a grid
//! with lists of objects in its cells, because its answer has to be scattered into the bitsets bit by bit;
//! and a binary hierarchy of single objects, because it has to be refitted from every object upward.

use fixedbitset::FixedBitSet;

use super::box_tests::Touch;
use super::boxes::{Boxes, Group, WORD};
use super::word_bounds::word_bounds;
use crate::geometry::Aabb;

/// Share of the coordinates by which a cluster grows. It is three times what tests of its objects may lose by
/// rounding, so no object can pass a test that its cluster fails.
const PAD: f32 = 24.0 * f32::EPSILON;

/// Boxes around the words of [`Boxes`], and boxes around words of those.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// A box around each word of objects.
    pub words: Boxes,
    /// A box around each word of `words`, that is around each block of 64 × 64 objects.
    pub blocks: Boxes,
}

/// A word of objects that a query found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// Index of the word.
    pub word: usize,
    /// Whether the word's box lies wholly in the volume, so that all of its objects touch the volume.
    pub inside: bool,
}

impl Clusters {
    /// Makes room for the words of `objects` boxes, all of them absent.
    pub fn reset(&mut self, objects: usize) {
        self.words.reset(objects.div_ceil(WORD));
        self.blocks.reset(self.words.words());
    }

    /// Recomputes the boxes around blocks from those around words.
    pub fn refit_blocks(&mut self) {
        for block in 0..self.words.words() {
            self.blocks.set_unpadded(block, &around(self.words.word(block)));
        }
    }

    /// Calls `visit` for every word whose box passes the test at both levels, ascending. With `among`, only
    /// words whose bit is set there are considered. The arguments of `test` are the boxes, the index of a
    /// word of them, and the candidates in that word.
    pub fn find(
        &self,
        among: Option<&FixedBitSet>,
        test: impl Fn(&Boxes, usize, usize) -> Touch,
        mut visit: impl FnMut(Found),
    ) {
        let wanted = |block: usize| match among {
            Some(words) => words.as_slice()[block],
            None => usize::MAX,
        };
        for blocks in 0..self.blocks.words() {
            let first = blocks * WORD;
            let count = WORD.min(self.blocks.len() - first);
            let mut candidates = 0;
            for bit in 0..count {
                candidates |= usize::from(wanted(first + bit) != 0) << bit;
            }
            let touch = test(&self.blocks, blocks, candidates);
            for_bits(touch.touching, |bit| {
                let block = first + bit;
                let valid = usize::MAX >> (WORD - WORD.min(self.words.len() - block * WORD));
                let candidates = wanted(block) & valid;
                let touch = if touch.inside >> bit & 1 == 1 {
                    Touch {
                        touching: candidates,
                        inside: candidates,
                    }
                } else {
                    test(&self.words, block, candidates)
                };
                for_bits(touch.touching, |bit| {
                    visit(Found {
                        word: block * WORD + bit,
                        inside: touch.inside >> bit & 1 == 1,
                    });
                });
            });
        }
    }

    /// Sum of the half areas of all words' boxes, m². It is proportional to the number of words that a small
    /// light touches. Words that hold an unbounded object are left out.
    ///
    /// Source: MacDonald & Booth 1990, "Heuristics for ray tracing using space subdivision".
    pub fn cost(&self) -> f64 {
        let area = |word: usize| {
            let (_, half) = self.words.center_half(word);
            let bounded = half.x >= 0.0 && half.max_element() < f64::from(Aabb::LIMIT) * 0.5;
            let area = half.x * half.y + half.y * half.z + half.z * half.x;
            if bounded { area } else { 0.0 }
        };
        (0..self.words.len()).map(area).sum()
    }
}

/// Yields every set bit, ascending.
pub(in crate::sets) fn bits_of(bits: usize) -> impl Iterator<Item = usize> {
    let first = (bits != 0).then_some(bits);
    let rests = std::iter::successors(first, |bits| Some(bits & (bits - 1)).filter(|rest| *rest != 0));
    rests.map(|bits| bits.trailing_zeros() as usize)
}

/// Calls `visit` for every set bit, ascending.
pub(in crate::sets) fn for_bits(mut bits: usize, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// The box around the boxes of a word, grown by [`PAD`]. It is empty if all boxes are absent.
pub(in crate::sets) fn around(groups: &[Group]) -> Aabb {
    let aabb = word_bounds(groups);
    if aabb.is_empty() {
        return Aabb::EMPTY;
    }
    let pad = aabb.min.abs().max(aabb.max.abs()) * PAD;
    Aabb {
        min: aabb.min - pad,
        max: aabb.max + pad,
    }
}
