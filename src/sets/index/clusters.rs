//! Boxes around boxes: a hierarchy of fan-out 64 over the dense object index.
//!
//! A cluster is one word of every bitset over the objects; a block is 64 clusters. Since [`Objects`](crate::sets::Objects) puts
//! objects into spatial order, the 64 objects of a word are neighbours, and a light
//! that is far from their common box has zeros there. A query tests the boxes of all blocks, then the clusters of those it
//! touches, then the objects of those it touches: eight boxes at a time throughout, and without any pointer.
//!
//! Objects that move refit the boxes of their words; the order stays until it has become poor.
//!
//! Measured: 100,000 unit boxes in 400×20×400 m, 64 point lights of 20 m that all move; L, I and S of all, one thread,
//! release:
//!
//! | order of the index | query | ms |
//! | --- | --- | --- |
//! | median splits (`spatial_order.rs`) | blocks, clusters, objects | 1.03 |
//! | cells of a grid along a Z-curve | same | 1.22 |
//! | median splits | all objects, flat | 3.63 |
//! | by entity | all objects, flat | 11.5 |
//! | by entity | blocks, clusters, objects | 11.5 |
//!
//! So the order matters more than the levels: in the order of entities nearly every word holds some object near any
//! light, and all that follows must look at every word. A grid with lists of objects in its cells was not pursued, since its
//! answer has to be scattered into the bitsets bit by bit; nor was a binary hierarchy of single objects, which
//! has to be refitted from every object upward.

use fixedbitset::FixedBitSet;

use super::box_tests::Touch;
use super::boxes::{Boxes, Group, WORD};
use super::word_bounds::word_bounds;
use crate::geometry::Aabb;

/// Share of the coordinates by which a cluster grows: thrice what tests of its objects may lose by rounding, so that none
/// of them can pass where the cluster does not.
const PAD: f32 = 24.0 * f32::EPSILON;

/// Boxes around the words of [`Boxes`], and around the words of those.
#[derive(Clone, Debug, Default)]
pub struct Clusters {
    /// A box around each word of objects.
    pub words: Boxes,
    /// A box around each word of `words`.
    pub blocks: Boxes,
}

/// A word of objects that a query found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Found {
    /// Index of the word.
    pub word: usize,
    /// Whether its box lies wholly in the volume, and so all of its objects touch it.
    pub inside: bool,
}

impl Clusters {
    /// Makes room for the words of `objects` boxes, all absent.
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

    /// Calls `visit` for every word whose box passes the test at both levels, ascending. With `among`, only for words
    /// whose bit is set there. The test takes boxes, a word of them and candidates.
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

    /// Sum of the half areas of all words' boxes, m²: in proportion to how many of them a small light touches. Words with
    /// objects of no end are left out.
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

/// Calls `visit` for every set bit, ascending.
pub(in crate::sets) fn for_bits(mut bits: usize, mut visit: impl FnMut(usize)) {
    while bits != 0 {
        visit(bits.trailing_zeros() as usize);
        bits &= bits - 1;
    }
}

/// The box around the boxes of a word, grown by [`PAD`]; empty if all are absent.
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
