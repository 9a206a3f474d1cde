//! Clipping of edges and of convex polygons, in light space.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

/// Signed distance of a plane, times the length of its normal.
pub fn side(plane: DVec4, point: DVec3) -> f64 {
    plane.truncate().dot(point) + plane.w
}

/// What of a convex polygon lies where the plane is positive.
pub fn clipped(polygon: &[DVec3], plane: DVec4) -> SmallVec<[DVec3; 8]> {
    let mut kept = SmallVec::new();
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let (at_from, at_to) = (side(plane, from), side(plane, to));
        if at_from >= 0.0 {
            kept.push(from);
        }
        if (at_from >= 0.0) != (at_to >= 0.0) {
            kept.push(from + (to - from) * (at_from / (at_from - at_to)));
        }
    }
    kept
}

/// Where a plane crosses the border of a convex polygon; `None` unless it does twice.
pub fn chord(polygon: &[DVec3], plane: DVec4) -> Option<[DVec3; 2]> {
    let mut crossings = SmallVec::<[DVec3; 4]>::new();
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let (at_from, at_to) = (side(plane, from), side(plane, to));
        if (at_from >= 0.0) != (at_to >= 0.0) {
            crossings.push(from + (to - from) * (at_from / (at_from - at_to)));
        }
    }
    <[DVec3; 2]>::try_from(&crossings[..]).ok()
}

/// The part of an edge that lies more than `margin` before the light's plane (`z < 0`).
pub fn clip_before_plane([a, b]: [DVec3; 2], margin: f64) -> Option<[DVec3; 2]> {
    let (da, db) = (-a.z - margin, -b.z - margin);
    let crossing = || a + (b - a) * (da / (da - db));
    match (da > 0.0, db > 0.0) {
        (true, true) => Some([a, b]),
        (false, false) => None,
        (true, false) => Some([a, crossing()]),
        (false, true) => Some([crossing(), b]),
    }
}

/// The parts of an edge outside of a sphere around the origin, up to two.
pub fn clip_outside_sphere([a, b]: [DVec3; 2], radius: f64) -> [Option<[DVec3; 2]>; 2] {
    let d = b - a;
    let (dd, ad, c) = (d.length_squared(), a.dot(d), a.length_squared() - radius * radius);
    let discriminant = ad * ad - dd * c;
    if !(discriminant > 0.0) || dd == 0.0 {
        return [(c > 0.0).then_some([a, b]), None];
    }
    let root = discriminant.sqrt();
    let (enter, leave) = ((-ad - root) / dd, (-ad + root) / dd);
    if leave <= 0.0 || enter >= 1.0 {
        return [Some([a, b]), None];
    }
    [
        (enter > 0.0).then(|| [a, a + d * enter]),
        (leave < 1.0).then(|| [a + d * leave, b]),
    ]
}
