//! Tests of boxes against volumes. Each yields a word of a bitset at a time.
//!
//! Each test comes in two strengths: for objects, whose padding covers rounding, and for the clusters around
//! them. The second never drops a cluster that contains an object which the first would keep, rounding
//! included, so that sets do not depend on which objects share a cluster.

use glam::Vec3;
use wide::f32x8;

use super::boxes::{Boxes, GROUPS, Group, LANES};
use crate::geometry::{Aabb, Cone, PlaneSet, Sphere};

/// The result of a test of clusters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Touch {
    /// Bits of the boxes that may touch the volume.
    pub touching: usize,
    /// Bits of the boxes that lie wholly inside the volume, so that their contents need no test.
    pub inside: usize,
}

/// Share of its squared radius by which a ball grows for clusters. It covers the slack of the objects' test,
/// and the rounding of squares and sums on both sides.
const CLUSTER_SLACK: f32 = 64.0 * f32::EPSILON;

impl Boxes {
    /// Bits of those boxes of a word, among `candidates`, that no plane excludes.
    pub fn touching_planes(&self, word: usize, candidates: usize, volume: &PlaneSet) -> usize {
        self.test(word, candidates, |group| {
            let mut inside = u32::MAX;
            for plane in &volume.planes {
                let (distance, reach) = along(group, plane.normal);
                inside &= (distance + reach + f32x8::splat(plane.offset))
                    .simd_ge(f32x8::ZERO)
                    .to_bitmask();
                if inside == 0 {
                    break;
                }
            }
            inside
        })
    }

    /// The clusters that the planes do not exclude, and those that lie inside all planes.
    pub fn clusters_touching_planes(&self, word: usize, candidates: usize, volume: &PlaneSet) -> Touch {
        self.classify(word, candidates, |group| {
            let (mut touching, mut inside) = (u32::MAX, u32::MAX);
            for plane in &volume.planes {
                let (distance, reach) = along(group, plane.normal);
                let distance = distance + f32x8::splat(plane.offset);
                touching &= (distance + reach).simd_ge(f32x8::ZERO).to_bitmask();
                inside &= (distance - reach).simd_ge(f32x8::ZERO).to_bitmask();
                if touching == 0 {
                    break;
                }
            }
            (touching, inside)
        })
    }

    /// Bits of those boxes of a word, among `candidates`, that share a point with the ball.
    ///
    /// Source: Arvo 1990, "A Simple Method for Box-Sphere Intersection Testing", Graphics Gems.
    pub fn touching_sphere(&self, word: usize, candidates: usize, ball: &Sphere) -> usize {
        let center = splat(ball.center);
        // The boxes' padding covers the rounding of the differences. The rounding of the squares is relative
        // to the radius.
        let radius_sq = f32x8::splat(ball.radius * ball.radius * (1.0 + 8.0 * f32::EPSILON));
        self.test(word, candidates, |group| {
            nearest_sq(group, &center).simd_le(radius_sq).to_bitmask()
        })
    }

    /// Bits of those boxes of a word, among `candidates`, whose centres lie outside the ball.
    pub fn centered_beyond(&self, word: usize, candidates: usize, ball: &Sphere) -> usize {
        let center = splat(ball.center);
        let radius_sq = f32x8::splat(ball.radius * ball.radius);
        self.test(word, candidates, |group| {
            let offset = [0, 1, 2].map(|i| group.center[i] - center[i]);
            !dot(&offset, &offset).simd_le(radius_sq).to_bitmask()
        })
    }

    /// The clusters that share a point with the ball, and those that have no point outside it.
    pub fn clusters_touching_sphere(&self, word: usize, candidates: usize, ball: &Sphere) -> Touch {
        let center = splat(ball.center);
        let radius_sq = ball.radius * ball.radius;
        let outer = f32x8::splat(radius_sq * (1.0 + CLUSTER_SLACK));
        let inner = f32x8::splat(radius_sq * (1.0 - CLUSTER_SLACK));
        self.classify(word, candidates, |group| {
            let touching = nearest_sq(group, &center).simd_le(outer).to_bitmask();
            let inside = farthest_sq(group, &center).simd_le(inner).to_bitmask();
            (touching, inside)
        })
    }

    /// Bits of those boxes of a word, among `candidates`, that may touch the cone. Tests like
    /// [`Cone::excludes_aabb`], eight boxes at once.
    pub fn touching_cone(&self, word: usize, candidates: usize, cone: &Cone) -> usize {
        let ball = Sphere {
            center: cone.apex,
            radius: cone.range,
        };
        let candidates = if cone.range.is_finite() {
            self.touching_sphere(word, candidates, &ball)
        } else {
            candidates
        };
        let axes = ConeAxes::new(cone);
        self.test(word, candidates, |group| {
            let place = axes.place(group, f32x8::ZERO);
            // On the axis any tangent plane serves. `px` and `py` are then far below the floor, and the plane
            // leans in.
            let scale = axes.cos / place.radial.fast_max(f32x8::splat(1e-18));
            let normal = [0, 1, 2]
                .map(|i| axes.axis[i] * axes.sin - (axes.x[i] * place.px + axes.y[i] * place.py) * scale);
            let beside =
                dot(&place.to_center, &normal) + dot(&normal.map(f32x8::abs), &group.half) + place.slack;
            place.in_front & beside.simd_ge(f32x8::ZERO).to_bitmask()
        })
    }

    /// Bits of those boxes of a word, among `candidates`, that share a point with the box.
    pub fn touching_box(&self, word: usize, candidates: usize, aabb: &Aabb) -> usize {
        let (center, half) = (splat(aabb.center()), splat(aabb.half_size()));
        self.test(word, candidates, |group| {
            let apart = [0, 1, 2].map(|i| (group.center[i] - center[i]).abs() - group.half[i] - half[i]);
            let apart = apart[0].fast_max(apart[1]).fast_max(apart[2]);
            apart.simd_le(f32x8::ZERO).to_bitmask()
        })
    }

    /// The clusters that may touch the cone. None counts as inside.
    ///
    /// The signed distance to a cone changes by at most the distance that a point moves. Take an object at
    /// offset `a` from the cluster's centre, with half sizes `b`. The far corner that its own test uses is at
    /// most |a| + |b| ≤ √2·|a + b| ≤ √2·|half size of the cluster| away from that centre. If the centre lies
    /// farther outside the cone than that, no object can be kept.
    pub fn clusters_touching_cone(&self, word: usize, candidates: usize, cone: &Cone) -> Touch {
        let ball = Sphere {
            center: cone.apex,
            radius: cone.range,
        };
        let candidates = if cone.range.is_finite() {
            self.clusters_touching_sphere(word, candidates, &ball).touching
        } else {
            candidates
        };
        let axes = ConeAxes::new(cone);
        let reach = f32x8::splat(std::f32::consts::SQRT_2 * (1.0 + 1e-5));
        self.classify(word, candidates, |group| {
            // Objects of the cluster may lie farther from the apex than its centre, and then have more slack.
            let size = group.half[0] + group.half[1] + group.half[2];
            let place = axes.place(group, size * f32x8::splat(4.0));
            let distance = place.along * axes.sin - place.radial * axes.cos;
            let beside = distance + dot(&group.half, &group.half).sqrt() * reach + place.slack;
            (place.in_front & beside.simd_ge(f32x8::ZERO).to_bitmask(), 0)
        })
    }

    fn test(&self, word: usize, candidates: usize, inside: impl Fn(&Group) -> u32) -> usize {
        let tested = self.classify(word, candidates, |group| (inside(group), 0));
        tested.touching
    }

    #[inline]
    pub(in crate::sets) fn classify(
        &self,
        word: usize,
        candidates: usize,
        test: impl Fn(&Group) -> (u32, u32),
    ) -> Touch {
        let (mut touching, mut inside) = (0, 0);
        let groups = self.word(word);
        for (at, group) in groups.iter().enumerate().take(GROUPS) {
            let shift = at * LANES;
            if (candidates >> shift) & 0xff == 0 {
                continue;
            }
            let (group_touching, group_inside) = test(group);
            touching |= ((group_touching & 0xff) as usize) << shift;
            inside |= ((group_inside & 0xff) as usize) << shift;
        }
        let touching = touching & candidates;
        Touch {
            touching,
            inside: inside & touching,
        }
    }
}

pub(in crate::sets) fn splat(v: Vec3) -> [f32x8; 3] {
    v.to_array().map(f32x8::splat)
}

#[inline]
fn dot(a: &[f32x8; 3], b: &[f32x8; 3]) -> f32x8 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Distance of the boxes' centres along a normal, and the extent of the boxes along it.
#[inline]
fn along(group: &Group, normal: Vec3) -> (f32x8, f32x8) {
    let normal = splat(normal);
    (
        dot(&group.center, &normal),
        dot(&group.half, &normal.map(f32x8::abs)),
    )
}

#[inline]
fn nearest_sq(group: &Group, point: &[f32x8; 3]) -> f32x8 {
    let beyond = [0, 1, 2].map(|i| (group.center[i] - point[i]).abs() - group.half[i]);
    let beyond = beyond.map(|gap| gap.fast_max(f32x8::ZERO));
    dot(&beyond, &beyond)
}

#[inline]
fn farthest_sq(group: &Group, point: &[f32x8; 3]) -> f32x8 {
    let beyond = [0, 1, 2].map(|i| (group.center[i] - point[i]).abs() + group.half[i]);
    dot(&beyond, &beyond)
}

/// A cone in vector registers.
struct ConeAxes {
    apex: [f32x8; 3],
    axis: [f32x8; 3],
    x: [f32x8; 3],
    y: [f32x8; 3],
    sin: f32x8,
    cos: f32x8,
}

/// The places of eight boxes relative to a cone.
struct InCone {
    to_center: [f32x8; 3],
    along: f32x8,
    px: f32x8,
    py: f32x8,
    /// Distance of each box's centre from the axis.
    radial: f32x8,
    slack: f32x8,
    /// Bits of the boxes that reach in front of the apex.
    in_front: u32,
}

impl ConeAxes {
    fn new(cone: &Cone) -> Self {
        let (x, y) = cone.axis.any_orthonormal_pair();
        let (sin, cos) = cone.half_angle.sin_cos();
        Self {
            apex: splat(cone.apex),
            axis: splat(cone.axis),
            x: splat(x),
            y: splat(y),
            sin: f32x8::splat(sin),
            cos: f32x8::splat(cos),
        }
    }

    /// The places of eight boxes. `extra` is a length that the slack for rounding adds to the distance of the
    /// centre.
    #[inline]
    fn place(&self, group: &Group, extra: f32x8) -> InCone {
        let to_center = [0, 1, 2].map(|i| group.center[i] - self.apex[i]);
        let size = to_center[0].abs() + to_center[1].abs() + to_center[2].abs() + extra;
        let slack = (size + extra) * f32x8::splat(8.0 * f32::EPSILON);
        let along = dot(&to_center, &self.axis);
        let in_front = along + dot(&self.axis.map(f32x8::abs), &group.half) + slack;
        let (px, py) = (dot(&to_center, &self.x), dot(&to_center, &self.y));
        InCone {
            to_center,
            along,
            px,
            py,
            radial: (px * px + py * py).sqrt(),
            slack,
            in_front: in_front.simd_ge(f32x8::ZERO).to_bitmask(),
        }
    }
}
