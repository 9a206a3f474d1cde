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
