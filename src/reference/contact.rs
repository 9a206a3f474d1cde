//! Which triangles touch a surface point, and so cannot shadow it.

use glam::DVec3;

/// A point this near to a triangle's plane touches it, in units of the larger of their coordinates.
///
/// Derived: a surface point is a convex sum of three corners, wrong by at most 8 roundings (8 · 2⁻⁵³) of the
/// largest coordinate; corners come from `f32` locals by an affine map in `f64`, 4 more. 2⁻⁴⁰ leaves a factor
/// of 600, and is 9 picometres at 10 m: far below any gap that `f32` positions can express there.
const TOUCHING: f64 = 1.0 / (1u64 << 40) as f64;

/// Rounding of a triangle's normal, in units of the product of its edges: twice the 8 roundings (8 · 2⁻⁵³) that
/// two edges and their cross product take. Matters for slivers alone.
const NORMAL_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Whether `point` lies on the triangle's plane, up to rounding ([`TOUCHING`]).
///
/// A shadow ray from a point on a triangle's plane meets that plane nowhere else, unless it runs within the
/// plane, where an edge-on triangle blocks nothing. So this one rule leaves out the receiving triangle, its
/// duplicates whichever way they wind, and all that is coplanar with it or touches it there, without moving
/// the ray's start and without a least distance along the ray. A plane rather than a distance along the ray is
/// compared, because the latter would grow without bound towards grazing light.
pub(super) fn touches(corners: &[DVec3; 3], point: DVec3) -> bool {
    let [a, b, c] = *corners;
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let normal = ab.cross(ac);
    let coordinate = [a, b, c, point]
        .into_iter()
        .map(|p| p.abs().max_element())
        .fold(0.0, f64::max);
    let rounding = NORMAL_ROUNDING * ab.length() * ac.length() * ap.length();
    normal.dot(ap).abs() <= TOUCHING * coordinate * normal.length() + rounding
}
