//! Clipping of edges against a light, in light space.

use glam::DVec3;

/// Returns the part of an edge that is more than `margin` in front of the light's plane (`z < 0`).
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

/// Returns the parts of an edge outside of a sphere around the origin, at most two.
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
