//! Finds the triangles that a ray may hit: a tree of boxes, traversed in `f64`.

use std::ops::Range;

use glam::{DVec3, Vec3};
use obvhs::{BvhBuildParams, aabb::Aabb as BuildBox, bvh2::builder::build_bvh2};
use smallvec::SmallVec;

use super::ray::Ray;

/// Share of the largest coordinate in play by which boxes grow for each ray, so that no box misses a triangle
/// that the intersection hits because of its own rounding. That rounding moves a corner by at most 10
/// roundings (10 · 2⁻⁵³) of the largest coordinate; 2⁻⁴⁶ leaves a factor of 12.
const GROWTH: f64 = 1.0 / (1u64 << 46) as f64;

/// Factor that covers the rounding of the slab test's three operations. Source: Ize 2013, "Robust BVH Ray
/// Traversal".
const FAR_ROUNDING: f64 = 1.0 + 4.0 * f64::EPSILON;

/// Largest inverse of a direction's component. It keeps `0 · ∞` out of the slab test.
const MAX_INVERSE: f64 = 1e300;

/// A node of the tree. An inner node has `count` 0 and its two children at `first` and `first + 1`. A leaf
/// has `count` slots that begin at `first`.
#[derive(Clone, Copy, Debug)]
struct Node {
    min: Vec3,
    max: Vec3,
    first: u32,
    count: u32,
}

/// The tree. Leaves hold ranges of *slots*; [`build`](Self::build) returns the triangle of each slot.
#[derive(Clone, Debug, Default)]
pub(super) struct Bvh {
    nodes: Vec<Node>,
    largest_coordinate: f64,
}

impl Bvh {
    /// Builds the tree over triangles with coordinates of at most [`MAX_COORDINATE`](super::MAX_COORDINATE).
    /// Also returns the order in which to store the triangles: the index of each slot's triangle.
    ///
    /// `obvhs` was chosen for the build because its trees are good (PLOC with reinsertion), its nodes are
    /// public, so that the traversal can be our own in `f64`, and it uses `glam`. `bvh` and `parry3d` bring a
    /// second mathematics library, the latter a whole collision engine, and the traversal of `obvhs` rounds
    /// in `f32`.
    pub fn build(triangles: &[[DVec3; 3]]) -> (Self, Vec<u32>) {
        if triangles.is_empty() {
            return (Self::default(), Vec::new());
        }
        let boxes: Vec<BuildBox> = triangles.iter().map(grown_box).collect();
        let tree = build_bvh2(&boxes, BvhBuildParams::medium_build(), &mut Default::default());
        let nodes = tree
            .nodes
            .iter()
            .map(|node| Node {
                min: node.aabb().min.to_array().into(),
                max: node.aabb().max.to_array().into(),
                first: node.first_index,
                count: node.prim_count,
            })
            .collect();
        let largest_coordinate = triangles
            .as_flattened()
            .iter()
            .map(|p| p.abs().max_element())
            .fold(0.0, f64::max);
        let bvh = Self {
            nodes,
            largest_coordinate,
        };
        (bvh, tree.primitive_indices)
    }

    /// Passes the slots of every leaf that the ray reaches before `t_max` to `visit`, nearer boxes first.
    /// `visit` returns the new `t_max`; −∞ ends the traversal.
    pub fn walk(&self, ray: &Ray, mut t_max: f64, mut visit: impl FnMut(Range<usize>) -> f64) {
        let slabs = Slabs::new(ray, self.largest_coordinate);
        let Some(mut node) = self.nodes.first() else {
            return;
        };
        let mut near = slabs.near(node);
        let mut waiting: SmallVec<[(f64, &Node); 64]> = SmallVec::new();
        loop {
            let is_reached = near < f64::INFINITY && near <= t_max;
            let first = node.first as usize;
            if is_reached && node.count == 0 {
                let (left, right) = (&self.nodes[first], &self.nodes[first + 1]);
                let (near_left, near_right) = (slabs.near(left), slabs.near(right));
                let farther;
                (node, near, farther) = if near_left <= near_right {
                    (left, near_left, (near_right, right))
                } else {
                    (right, near_right, (near_left, left))
                };
                if farther.0 < f64::INFINITY {
                    waiting.push(farther);
                }
                continue;
            }
            if is_reached {
                t_max = visit(first..first + node.count as usize);
                if t_max == f64::NEG_INFINITY {
                    return;
                }
            }
            let Some(next) = waiting.pop() else { return };
            (near, node) = next;
        }
    }

    /// Passes the slots of every leaf that a segment from `origin` to some point of the box may reach to `visit`, until that
    /// returns `false`. Finds all leaves that [`walk`](Self::walk) finds for any such segment up to `t_max` of 1.
    pub fn gather(&self, origin: DVec3, ends: [DVec3; 2], mut visit: impl FnMut(Range<usize>) -> bool) {
        let Some(root) = self.nodes.first() else { return };
        let fan = Fan::new(origin, ends, self.largest_coordinate);
        let mut waiting: SmallVec<[&Node; 64]> = SmallVec::new();
        waiting.push(root);
        while let Some(node) = waiting.pop() {
            if !fan.reaches(node) {
                continue;
            }
            let first = node.first as usize;
            if node.count == 0 {
                waiting.extend([&self.nodes[first], &self.nodes[first + 1]]);
            } else if !visit(first..first + node.count as usize) {
                return;
            }
        }
    }
}

/// The segments from a point to all points of a box, in the form that their slab test needs. At the share t of their way they are
/// in a box whose sides are between t times `least` and t times `most` of the way from the point.
struct Fan {
    origin_low: DVec3,
    origin_high: DVec3,
    least: DVec3,
    most: DVec3,
}

impl Fan {
    fn new(origin: DVec3, [low, high]: [DVec3; 2], largest_coordinate: f64) -> Self {
        let largest = [origin, low, high]
            .into_iter()
            .fold(largest_coordinate, |largest, p| {
                largest.max(p.abs().max_element())
            });
        let growth = GROWTH * largest;
        Self {
            origin_low: origin - growth,
            origin_high: origin + growth,
            least: low - origin - growth,
            most: high - origin + growth,
        }
    }

    /// Whether some segment may meet the box. Along each axis, t · `least` must be at most the box's end, and t · `most` at least
    /// its start; that leaves one range of t.
    fn reaches(&self, node: &Node) -> bool {
        let start = node.min.as_dvec3() - self.origin_high;
        let end = node.max.as_dvec3() - self.origin_low;
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for axis in 0..3 {
            // The second is the first, mirrored.
            for (speed, limit) in [(self.least[axis], end[axis]), (-self.most[axis], -start[axis])] {
                if speed > 0.0 {
                    to = to.min(limit / speed);
                } else if speed < 0.0 {
                    from = from.max(limit / speed);
                } else if limit < 0.0 {
                    return false;
                }
            }
        }
        from <= to * FAR_ROUNDING
    }
}

/// The ray in the form that the slab test needs. The origin is split in two, moved apart by the growth of the
/// boxes.
struct Slabs {
    origin_low: DVec3,
    origin_high: DVec3,
    inverse: DVec3,
}

impl Slabs {
    fn new(ray: &Ray, largest_coordinate: f64) -> Self {
        let growth = GROWTH * ray.origin.abs().max_element().max(largest_coordinate);
        let inverse = DVec3::from_array(ray.direction.to_array().map(|d| {
            // A zero keeps its sign and gives ±MAX_INVERSE, so the slab holds either all of the ray or
            // nothing, as it should.
            (1.0 / d).clamp(-MAX_INVERSE, MAX_INVERSE)
        }));
        Self {
            origin_low: ray.origin - growth,
            origin_high: ray.origin + growth,
            inverse,
        }
    }

    /// Parameter at which the ray enters the box; 0 if it starts inside, ∞ if it misses.
    ///
    /// Source: Kay & Kajiya 1986, "Ray Tracing Complex Scenes".
    fn near(&self, node: &Node) -> f64 {
        let at_min = (node.min.as_dvec3() - self.origin_high) * self.inverse;
        let at_max = (node.max.as_dvec3() - self.origin_low) * self.inverse;
        let near = at_min.min(at_max).max_element().max(0.0);
        let far = at_min.max(at_max).min_element() * FAR_ROUNDING;
        if near <= far { near } else { f64::INFINITY }
    }
}

/// The smallest box in `f32` that holds the triangle, grown by one representable step on each side.
fn grown_box([a, b, c]: &[DVec3; 3]) -> BuildBox {
    let min = a.min(*b).min(*c).as_vec3().to_array().map(f32::next_down);
    let max = a.max(*b).max(*c).as_vec3().to_array().map(f32::next_up);
    BuildBox {
        min: min.into(),
        max: max.into(),
    }
}

#[cfg(test)]
pub(super) mod random {
    use glam::DVec3;
    use proptest::prelude::*;

    /// Points of a cube around the origin, whose side is twice `reach`.
    pub fn point(reach: f64) -> impl Strategy<Value = DVec3> {
        [-reach..reach, -reach..reach, -reach..reach].prop_map(DVec3::from_array)
    }
}

#[cfg(test)]
mod tests {
    use super::random::point;
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Every leaf that a segment meets is gathered for a box that holds the segment's end, also for a flat box.
        #[test]
        fn gathering_finds_what_every_segment_finds(
            corners in prop::collection::vec([point(2.0), point(2.0), point(2.0)], 1..40),
            origin in point(3.0),
            ends in [point(3.0), point(3.0)],
            flat in 0..4usize,
            shares in prop::collection::vec([0.0..=1.0, 0.0..=1.0, 0.0..=1.0], 20),
        ) {
            let triangles: Vec<[DVec3; 3]> = corners.iter().map(|[a, b, c]| [*a, *a + *b * 0.2, *a + *c * 0.2]).collect();
            let (bvh, _) = Bvh::build(&triangles);
            let (low, mut high) = (ends[0].min(ends[1]), ends[0].max(ends[1]));
            if flat < 3 {
                high[flat] = low[flat];
            }
            let mut gathered = vec![false; triangles.len()];
            bvh.gather(origin, [low, high], |slots| {
                gathered[slots].fill(true);
                true
            });
            for share in shares {
                let end = low + (high - low) * DVec3::from_array(share);
                let ray = Ray { origin, direction: end - origin };
                bvh.walk(&ray, 1.0, |slots| {
                    for slot in slots {
                        assert!(gathered[slot], "slot {slot} of {}", triangles.len());
                    }
                    1.0
                });
            }
        }
    }

    #[test]
    fn gathering_leaves_out_what_no_segment_reaches() {
        let far = |x: f64| {
            [
                DVec3::new(x, 0.0, 0.0),
                DVec3::new(x, 0.1, 0.0),
                DVec3::new(x, 0.0, 0.1),
            ]
        };
        let triangles: Vec<_> = (-50..50).map(|step| far(f64::from(step) + 0.5)).collect();
        let (bvh, _) = Bvh::build(&triangles);
        let mut count = 0;
        bvh.gather(
            DVec3::ZERO,
            [DVec3::new(4.0, -0.1, -0.1), DVec3::new(4.0, 0.1, 0.1)],
            |slots| {
                count += slots.len();
                true
            },
        );
        assert!((4..=6).contains(&count), "{count}");
        let mut visits = 0;
        bvh.gather(DVec3::ZERO, [DVec3::splat(-60.0), DVec3::splat(60.0)], |_| {
            visits += 1;
            false
        });
        assert_eq!(visits, 1);
    }
}
