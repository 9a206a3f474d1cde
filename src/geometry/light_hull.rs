//! Convex hull of a light and a convex solid. No caster outside it can throw a shadow into the solid.

use glam::{DVec3, DVec4};

use super::convex_solid::{HalfSpace, SolidEdge};
use super::{Aabb, Frustum, PlaneSet};

/// The place that light comes from: a homogeneous point, and the extent of the source around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emitter {
    /// Place of the light in world space: its centre with `w = 1`, or the unit direction towards a light at
    /// infinity with `w = 0`.
    pub point: DVec4,
    /// Half of each side of a rectangular source, as vectors; zero for other lights.
    pub half_sides: [DVec3; 2],
    /// Radius of a spherical source, metres; zero for other lights.
    pub radius: f64,
}

impl Emitter {
    /// A source without extent.
    pub fn point(point: DVec4) -> Self {
        Self {
            point,
            half_sides: [DVec3::ZERO; 2],
            radius: 0.0,
        }
    }

    /// How far the source extends from its centre along a unit vector, metres.
    pub fn extent(&self, direction: DVec3) -> f64 {
        let [a, b] = self.half_sides;
        direction.dot(a).abs() + direction.dot(b).abs() + self.radius
    }

    /// Radius of the sphere around the whole source, metres.
    pub fn bounding_radius(&self) -> f64 {
        let [a, b] = self.half_sides;
        (a + b).length().max((a - b).length()) + self.radius
    }
}

/// Convex hull of a light and a convex solid, in world space.
///
/// The hull never excludes what matters. Each of its planes is a supporting plane, pushed out until all
/// corners of the solid and the whole light are inside. An ill-conditioned plane therefore only makes the
/// hull larger.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightHull {
    /// The bounding planes, moved outward by as much as `f32` rounding can lose in tests of boxes that are
    /// [padded](Aabb::padded).
    pub planes: PlaneSet,
    /// Whether the whole light lies in the solid. The hull is then the solid itself.
    pub inside: bool,
}

impl LightHull {
    /// The hull of a light and the view frustum.
    pub fn of_frustum(frustum: &Frustum, light: &Emitter) -> Self {
        hull(
            &Solid {
                origin: frustum.eye(),
                planes: frustum.half_spaces(),
                corners: frustum.corners_eye(),
                edges: &Frustum::EDGES,
                mirrored: frustum.is_mirrored(),
            },
            light,
        )
    }

    /// The hull of a light and a box. An empty box gives the hull that excludes nothing.
    pub fn of_aabb(aabb: &Aabb, light: &Emitter) -> Self {
        if aabb.is_empty() || !aabb.min.is_finite() || !aabb.max.is_finite() {
            return Self::default();
        }
        let origin = aabb.center().as_dvec3();
        let (min, max) = (aabb.min.as_dvec3() - origin, aabb.max.as_dvec3() - origin);
        let planes: [HalfSpace; 6] = std::array::from_fn(|i| {
            let (axis, upper) = (i / 2, i % 2 == 1);
            let mut normal = DVec3::ZERO;
            normal[axis] = if upper { -1.0 } else { 1.0 };
            HalfSpace {
                normal,
                offset: if upper { max[axis] } else { -min[axis] },
            }
        });
        let corners: [DVec4; 8] = std::array::from_fn(|i| {
            DVec3::select(glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0), max, min).extend(1.0)
        });
        hull(
            &Solid {
                origin,
                planes: &planes,
                corners: &corners,
                edges: &AABB_EDGES,
                mirrored: false,
            },
            light,
        )
    }
}

/// Edges of a box. Corner `i` of the box has bit `k` set at the upper end of axis `k`, and plane `2k + 1` is
/// the upper plane of axis `k`.
const AABB_EDGES: [SolidEdge; 12] = {
    let mut edges = [SolidEdge::new(0, 0, 0, 0); 12];
    let mut i = 0;
    while i < 12 {
        let axis = i / 4;
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let (upper_b, upper_c) = (i & 1, (i >> 1) & 1);
        let from = (upper_b << b) | (upper_c << c);
        let to = from | (1 << axis);
        // Along +axis, the edge runs counter-clockwise around face b if both faces are at the same end (both
        // upper or both lower).
        edges[i] = if upper_b == upper_c {
            SolidEdge::new(from, to, 2 * b + upper_b, 2 * c + upper_c)
        } else {
            SolidEdge::new(from, to, 2 * c + upper_c, 2 * b + upper_b)
        };
        i += 1;
    }
    edges
};

/// A convex solid, relative to `origin`. An edge's plane index past the end of `planes` means the plane at
/// infinity; every light is on its inner side.
struct Solid<'a> {
    origin: DVec3,
    planes: &'a [HalfSpace],
    corners: &'a [DVec4],
    edges: &'a [SolidEdge],
    mirrored: bool,
}

/// Least sine of the angle between an edge and the direction to the light. Below it the two span no plane,
/// because the normal would be wrong by more than 1e-11.
const MIN_SINE: f64 = 1e-4;

/// A light that lies outside a plane by less than this share of its distance counts as on the plane. The
/// plane, pushed out to hold the light, and the planes through its silhouette edges then hardly differ as
/// bounds, and the former is the better one.
const ON_PLANE: f64 = 1e-6;

/// Adds a light to a convex solid. Planes that have the light on their inner side stay. An edge between such
/// a plane and one that has the light outside is a silhouette edge, and contributes the plane through it and
/// the light.
///
/// Source: O'Rorke 2004, GPU Gems ch. 15, §15.4.4; Everitt & Kilgard 2003, "Optimized Stencil Shadow
/// Volumes". New here: homogeneous corners and lights (far plane and sun at infinity), lights with an extent,
/// and moving each plane until it supports what it must hold.
fn hull(solid: &Solid<'_>, light: &Emitter) -> LightHull {
    let mut result = LightHull {
        planes: PlaneSet::default(),
        inside: true,
    };
    let at_infinity = light.point.w == 0.0;
    let center = light.point - solid.origin.extend(0.0) * light.point.w;
    let distance = center.truncate().length();
    let mut outside = [false; 8];
    for (i, plane) in solid.planes.iter().enumerate() {
        let side = plane.side(center);
        let nearly = if at_infinity {
            0.0
        } else {
            ON_PLANE * (distance + plane.offset.abs())
        };
        let extent = if at_infinity {
            0.0
        } else {
            light.extent(plane.normal)
        };
        result.inside &= side >= extent;
        outside[i] = side < -nearly;
        if !outside[i] {
            push_supporting(&mut result, solid, plane.normal, center, light);
        }
    }
    for edge in solid.edges {
        let [first, second] = edge.planes.map(|plane| outside[plane]);
        if first == second {
            continue;
        }
        let [a, b] = edge.corners.map(|corner| solid.corners[corner]);
        let normal = match (a.w, b.w) {
            // An edge of the plane at infinity contributes the plane through the light that is parallel to
            // the side plane. If the light is at infinity too, that would be the plane at infinity.
            (0.0, 0.0) if at_infinity => continue,
            (0.0, 0.0) => {
                let side_plane = edge.planes[usize::from(!first)];
                solid.planes[side_plane].normal
            }
            _ => {
                // If the edge runs to infinity, `a` is its finite end: the corners are listed in that order.
                let along = if b.w == 0.0 {
                    b.truncate()
                } else {
                    (b - a).truncate()
                };
                let to_light = center.truncate() - a.truncate() * center.w;
                let normal = to_light.cross(along);
                let lengths = to_light.length() * along.length();
                if normal.length() < MIN_SINE * lengths || lengths == 0.0 {
                    continue;
                }
                let sign = if first != solid.mirrored { 1.0 } else { -1.0 };
                normal.normalize() * sign
            }
        };
        push_supporting(&mut result, solid, normal, center, light);
    }
    result
}

/// Adds the plane with this normal that supports both solid and light. Adds nothing if they are unbounded on
/// that side.
fn push_supporting(
    hull: &mut LightHull,
    solid: &Solid<'_>,
    normal: DVec3,
    light_center: DVec4,
    light: &Emitter,
) {
    let mut offset = f64::NEG_INFINITY;
    let lights = std::iter::once((light_center, light.extent(normal)));
    for (point, extent) in solid.corners.iter().map(|&corner| (corner, 0.0)).chain(lights) {
        let along = normal.dot(point.truncate());
        if point.w == 0.0 {
            if along < -1e-11 {
                return;
            }
        } else {
            offset = offset.max(extent - along);
        }
    }
    if normal.is_finite() && offset.is_finite() {
        let half_space = HalfSpace { normal, offset };
        hull.planes.planes.push(half_space.to_world(solid.origin));
    }
}
