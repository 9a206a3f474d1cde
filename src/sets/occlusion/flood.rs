//! Finds what is visible from a place in a cell: that cell, and others through open portals one after
//! another.

use glam::DVec3;
use smallvec::SmallVec;

use super::cells::{Cells, Opening};
use super::sight::Sight;
use crate::geometry::{Aabb, PlaneSet};
use crate::sets::index::objects::Objects;

/// Most cells entered from one viewpoint, counting a cell once for every way into it. Beyond this, everything
/// counts as visible.
const MAX_VISITS: usize = 2048;

/// Most portals on one way. Beyond this, everything counts as visible.
const MAX_WAY: usize = 48;

/// The place from which a camera or a light looks.
#[derive(Clone, Debug)]
pub(in crate::sets) struct Standpoint {
    /// The eye of a camera, or the middle of a light.
    pub eye: DVec3,
    /// All points from which the viewer looks. Each must be in a cell.
    pub points: SmallVec<[DVec3; 8]>,
    /// Distance, metres, within which the viewer stands in a portal. Such a portal clips nothing.
    pub reach: f64,
    /// Corners of the convex cone of directions that the viewer sees. If it is empty, the viewer sees all
    /// directions.
    pub corners: SmallVec<[DVec3; 4]>,
    /// Whether the viewer is a single point, so that portals clip the view.
    pub clips: bool,
    /// Distance up to which the viewer sees, metres.
    pub range: f64,
}

/// The cells that were seen, each with the planes around the part of it that was seen.
#[derive(Clone, Debug, Default)]
pub(in crate::sets) struct Sightings {
    /// Whether anything may be unseen. If `false`, everything counts as seen.
    limited: bool,
    visits: Vec<(u32, PlaneSet)>,
}

impl Sightings {
    /// Declares that everything is seen.
    pub(in crate::sets) fn forget(&mut self) {
        self.limited = false;
        self.visits.clear();
    }

    /// Whether anything may be unseen.
    pub(in crate::sets) fn is_limited(&self) -> bool {
        self.limited
    }

    /// Finds the cells that are seen from a standpoint.
    pub(in crate::sets) fn flood(&mut self, cells: &Cells, from: &Standpoint) {
        self.visits.clear();
        let bounds = Aabb::from_points(from.points.iter().map(|point| point.as_vec3())).padded();
        let in_a_cell = |point: &DVec3| cells.cells.iter().any(|cell| cell.contains(*point));
        self.limited = cells.are_sound() && !from.points.is_empty() && from.points.iter().all(in_a_cell);
        if !self.limited {
            return;
        }
        let sight = if from.corners.is_empty() {
            Sight::everywhere(from.eye)
        } else {
            Sight::towards(from.eye, &from.corners)
        };
        let mut way = SmallVec::new();
        for (at, cell) in cells.cells.iter().enumerate() {
            if cell.touches(&bounds) && !self.enter(cells, from, at as u32, &sight, &mut way) {
                self.forget();
                return;
            }
        }
    }

    /// Enters a cell, and continues through its portals. Returns `false` to give up.
    fn enter(
        &mut self,
        cells: &Cells,
        from: &Standpoint,
        cell: u32,
        sight: &Sight,
        way: &mut SmallVec<[u32; MAX_WAY]>,
    ) -> bool {
        if self.visits.len() >= MAX_VISITS || way.len() >= MAX_WAY {
            return false;
        }
        self.visits.push((cell, sight.planes()));
        for (index, portal) in cells.portals.iter().enumerate() {
            let index = index as u32;
            // A straight line crosses the plane of a portal only once.
            if !portal.open || !portal.leads_out_of(cells, cell) || way.contains(&index) {
                continue;
            }
            let Some(beyond) = look_through(portal, from, sight) else {
                continue;
            };
            let [Some(first), Some(second)] = portal.joins else {
                return false;
            };
            let other = if first == cell { second } else { first };
            if other == cell {
                continue;
            }
            way.push(index);
            let whole = self.enter(cells, from, other, &beyond, way);
            way.pop();
            if !whole {
                return false;
            }
        }
        true
    }

    /// Whether an object may be seen.
    pub(in crate::sets) fn sees(&self, cells: &Cells, objects: &Objects, object: usize) -> bool {
        let word = object / usize::BITS as usize;
        let bit = 1 << (object % usize::BITS as usize);
        self.seen_of_word(cells, objects, word, bit) != 0
    }

    /// Bits of those objects of a word, among `candidates`, that may be seen.
    pub(in crate::sets) fn seen_of_word(
        &self,
        cells: &Cells,
        objects: &Objects,
        word: usize,
        candidates: usize,
    ) -> usize {
        if !self.limited {
            return candidates;
        }
        let mut seen = candidates & cells.loose.as_slice()[word];
        for (cell, planes) in &self.visits {
            let open = candidates & cells.members[*cell as usize].as_slice()[word] & !seen;
            if open != 0 {
                seen |= objects.boxes.touching_planes(word, open, planes);
            }
        }
        seen
    }
}

/// The directions that remain after looking through a portal. `None` if nothing is visible through it.
fn look_through(portal: &Opening, from: &Standpoint, sight: &Sight) -> Option<Sight> {
    if portal.points.is_empty() {
        return Some(sight.clone());
    }
    let bounds = portal
        .points
        .iter()
        .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), point| {
            (min.min(*point), max.max(*point))
        });
    let outside = (bounds.0 - from.eye).max(from.eye - bounds.1).max(DVec3::ZERO);
    if outside.length() > from.range + from.reach {
        return None;
    }
    if !from.clips {
        return Some(sight.clone());
    }
    let stands_in = match portal.normal {
        Some(normal) => normal.dot(from.eye - portal.points[0]).abs() <= from.reach,
        None => outside.length() <= from.reach,
    };
    if stands_in {
        return Some(sight.clone());
    }
    sight.through(&portal.points, portal.normal)
}
