//! Finds the triangles that touch a surface point and therefore cannot shadow it.

use glam::DVec3;

/// A point touches a triangle's plane if it is nearer to it than this, in units of the largest of their
/// coordinates.
///
/// Derived: a surface point is a convex sum of three corners, wrong by at most 8 roundings (8 · 2⁻⁵³) of the
/// largest coordinate. Corners come from `f32` locals by an affine map in `f64`, which adds 4 more. 2⁻⁴⁰
/// leaves a factor of 600. It is 9 picometres at 10 m, far below any gap that `f32` positions can express
/// there.
const TOUCHING: f64 = 1.0 / (1u64 << 40) as f64;

/// Rounding of a triangle's normal, in units of the product of its edges. It is twice the 8 roundings (8 ·
/// 2⁻⁵³) that two edges and their cross product take, and matters only for slivers.
const NORMAL_ROUNDING: f64 = 8.0 * f64::EPSILON;

/// Whether `point` lies on the triangle's plane, up to rounding ([`TOUCHING`]).
///
/// A shadow ray from a point on a triangle's plane meets that plane nowhere else, unless the ray runs within
/// the plane, where an edge-on triangle blocks nothing. This single rule therefore excludes the receiving
/// triangle, its duplicates of either winding, and every triangle that is coplanar with it or touches it
/// there. It needs neither an offset of the ray's start nor a minimum distance along the ray. The distance is
/// measured to the plane instead of along the ray, because the latter would grow without bound towards
/// grazing light.
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
