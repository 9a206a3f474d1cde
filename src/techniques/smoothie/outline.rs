//! The smoothie edges of one caster, from its silhouette.

use glam::{DMat4, DVec3, Vec3};

use super::records::{DISC, DISC_ALONE, SECTOR, SmoothieEdge};
use crate::silhouettes::Contour;
use crate::techniques::maps::request::Beside;

/// Sine of the angle between an edge and the ray to the light below which the edge points at the light. It is some
/// hundred roundings of an `f32` position.
const POINTS_AT_LIGHT: f32 = 1e-5;

/// Ratio of an edge's interpolated width to the width at its point nearest to the light, from which on the edge is divided
/// there. In between the ratio is then at most √2.
const TOO_WIDE: f32 = 1.25;

/// Where the edges of a caster stand, as seen from a light.
#[derive(Clone, Copy, Debug)]
pub struct Stand<'a> {
    /// Positions of the caster's vertices, local space.
    pub positions: &'a [Vec3],
    /// The matrix from the caster's local space to world space.
    pub world_from_local: &'a DMat4,
    /// Origin of the records: the light or, for a directional light, the origin of the map's first face. World space.
    pub anchor: DVec3,
    /// Direction in which a directional light shines; `None` for a light at a position.
    pub along: Option<Vec3>,
    /// Width of the smoothies.
    pub beside: &'a Beside,
}

impl Stand<'_> {
    fn place(&self, vertex: u32) -> Option<Vec3> {
        let local = self.positions.get(vertex as usize)?;
        let world = self.world_from_local.transform_point3(local.as_dvec3());
        Some((world - self.anchor).as_vec3()).filter(|place| place.is_finite())
    }

    fn record(&self, [start, end, next]: [Vec3; 3], kind: f32) -> SmoothieEdge {
        SmoothieEdge {
            start: start.to_array(),
            width_start: self.width(start),
            end: end.to_array(),
            width_end: self.width(end),
            next: next.to_array(),
            kind,
        }
    }

    fn width(&self, place: Vec3) -> f32 {
        let distance = if self.along.is_some() { 0.0 } else { place.length() };
        self.beside.metres + self.beside.share * distance
    }

    /// Returns the point of an edge nearest to the light if the width of the smoothie, which is interpolated along the edge,
    /// would be too great there.
    fn nearest(&self, start: Vec3, end: Vec3) -> Option<Vec3> {
        let edge = end - start;
        let at = -start.dot(edge) / edge.length_squared();
        if self.along.is_some() || !(at > 0.0 && at < 1.0) {
            return None;
        }
        let nearest = start + edge * at;
        let interpolated = self.width(start) * (1.0 - at) + self.width(end) * at;
        (interpolated > TOO_WIDE * self.width(nearest)).then_some(nearest)
    }

    fn points_at_light(&self, start: Vec3, end: Vec3) -> bool {
        let ray = self.along.unwrap_or(start);
        let edge = end - start;
        let sine = ray.cross(edge).length();
        // Written so that an edge without length, or one that starts at the light, counts as well.
        !(sine > POINTS_AT_LIGHT * ray.length() * edge.length())
    }
}

/// Appends the smoothie edges of one caster. `edges` is working memory.
///
/// An edge counts once, whatever its multiplicity. Where exactly one edge follows an edge, the corner between them is
/// a sector; elsewhere it is a whole disc, which leaves no gap however the edges are paired. An edge that passes close by
/// the light is divided where it is nearest, because its width is a share of the distance. Edges of a surface on which
/// the light lies have no smoothie. O(n log n) for n edges.
pub fn push_smoothies(
    contour: &Contour,
    stand: &Stand,
    edges: &mut Vec<[u32; 2]>,
    out: &mut Vec<SmoothieEdge>,
) {
    edges.clear();
    edges.extend(contour.edges.iter().chain(&contour.double_edges));
    // A transform that mirrors swaps left and right.
    if stand.world_from_local.determinant() < 0.0 {
        edges.iter_mut().for_each(|edge| edge.reverse());
    }
    edges.sort_unstable();
    edges.dedup();
    for &[first, second] in edges.iter().filter(|edge| !contour.is_flush(**edge)) {
        let (Some(start), Some(end)) = (stand.place(first), stand.place(second)) else {
            continue;
        };
        let from = edges.partition_point(|edge| edge[0] < second);
        let following = || edges[from..].iter().take_while(|edge| edge[0] == second);
        let mut outlining = following().filter(|edge| !contour.is_flush(**edge));
        let only = match (outlining.next(), outlining.next()) {
            (Some(edge), None) => stand.place(edge[1]),
            // At the surface on which the light lies there is no corner.
            (None, None) if following().next().is_some() => Some(end + (end - start)),
            _ => None,
        };
        let next = only.filter(|&next| !stand.points_at_light(end, next));
        let kind = if stand.points_at_light(start, end) {
            DISC_ALONE
        } else if next.is_some() {
            SECTOR
        } else {
            DISC
        };
        let middle = stand.nearest(start, end).filter(|_| kind != DISC_ALONE);
        if let Some(middle) = middle {
            out.push(stand.record([start, middle, end], SECTOR));
        }
        out.push(stand.record([middle.unwrap_or(start), end, next.unwrap_or(end)], kind));
    }
}
