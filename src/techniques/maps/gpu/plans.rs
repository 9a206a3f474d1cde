//! The draws of the passes of a map in a frame.

use std::ops::Range;

use super::pipelines::{Key, Peel};
use super::pool::MapTexturesKey;
use crate::techniques::maps::request::MapRequest;

/// The draws that one face needs.
#[derive(Debug)]
pub(in crate::techniques) struct FacePlan {
    pub face: usize,
    pub still: Option<Range<usize>>,
    /// Draws of moving casters over a copy of the still layer.
    pub moving: Option<Range<usize>>,
    /// Draws of all casters for the second surface. They are empty if the map holds the nearest surface.
    pub peeled: [Range<usize>; 2],
    /// How the first surface is distinguished from the second.
    pub peel: Peel,
    pub still_revision: u64,
    pub revision: u64,
}

/// The passes and draws that one light needs.
#[derive(Debug)]
pub(in crate::techniques) struct LightPlan {
    pub light: usize,
    pub request: MapRequest,
    pub key: MapTexturesKey,
    /// The lookup's pipeline; `None` if another recorder looks the map up.
    pub lookup: Option<Key>,
    pub faces: Range<usize>,
    /// True if several lights use one texture in turn, because none of them keeps its map. The texture is
    /// then drawn just before each lookup.
    pub takes_turns: bool,
    pub draw_count: usize,
    /// Range of the matrices for the debug view.
    pub frusta: Range<u32>,
}
