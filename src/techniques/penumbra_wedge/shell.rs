//! The shell of a penumbra wedge: what encloses all points that see an edge before the light.
//!
//! In light space: origin at the light's centre, world scale, the light's own axes. A point `y + s (y − x)` with `y` on
//! the edge, `x` on the light and `s ≥ 0` has part of its view of the light behind the edge. For a convex light these
//! points are convex: the hull of the edge and of the rays from its ends away from each corner of the light. The plane
//! through edge and centre, the separator, cuts the hull in an outer half, which the hard shadow leaves out, and an
//! inner half, which it darkens.
//!
//! Source: Assarsson et al. 2003, section 4.1 and figures 1 and 2. The paper's tight wedge takes two triangles of each
//! end pyramid; here those that the hull has, one to three. Its wedge of a sphere relocates an end to make front and
//! back planar; tangent planes through the line of the edge are planar as it is, and tighter.

use glam::DVec3;

/// Points of a half's rim: where its shell ends at infinity, from one side of the separator to the other.
pub const RIM: usize = 6;

/// A point at infinity and the end of the edge that its ray starts from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RimPoint {
    /// Direction, light space.
    pub direction: DVec3,
    /// Index of the end: 0 or 1.
    pub apex: usize,
}

/// Rims of the outer and the inner half. Both start on the same ray and end on the same ray, which lie in the
/// separator, to the side of the edge's start and of its end; rays of the same end span triangles, a change of the end spans a quad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// Outer, inner.
    pub rims: [[RimPoint; RIM]; 2],
}

/// Least sine of the angle between the ends of an edge, seen from the light's centre: below, the edge points at the
/// centre and covers no sector of the light.
const POINTING: f64 = 1e-9;

/// The shell of the edge between `ends` for a light that is a parallelogram around the origin; `corners` in order
/// around it. The ends must lie on one side of its plane.
///
/// `None` for an edge that points at the centre: it covers nothing, and has no separator.
pub fn quad_shell(ends: [DVec3; 2], corners: [DVec3; 4]) -> Option<Shell> {
    let [a, b] = ends;
    let normal = separator_normal(ends)?;
    // The outer half lies where the separator's normal points to, its rays come from where it points away.
    let side = corners.map(|corner| normal.dot(corner));
    let first =
        (0..4).min_by(|&i, &j| (side[i] + side[(i + 1) % 4]).total_cmp(&(side[j] + side[(j + 1) % 4])))?;
    let (r0, r1) = (corners[first], corners[(first + 1) % 4]);
    let (v0, v1) = (side[first], side[(first + 1) % 4]);
    let share = if v0 + v1 < 0.0 { v1 / (v0 + v1) } else { 0.5 };
    let middle = -r1 + (r0 + r1) * share; // where the separator leaves the light
    // In the separator: along the light and away from it.
    let along = middle.normalize_or_zero();
    let mut away = along.cross(normal);
    if away.dot(a + b) < 0.0 {
        away = -away;
    }
    let half = middle.length();
    let slope = |end: DVec3, point: f64| (end.dot(along) - point) / end.dot(away).max(f64::MIN_POSITIVE);
    let left = usize::from(slope(b, half) < slope(a, half));
    let right = usize::from(slope(b, -half) > slope(a, -half));
    let ray = |apex: usize, light: DVec3| RimPoint {
        direction: ends[apex] - light,
        apex,
    };
    let rim = |c0: DVec3, c1: DVec3| {
        let (start, end) = (ray(left, middle), ray(right, -middle));
        if left == right {
            // The line of the edge meets the light: all is within the cone of the nearer end.
            return [
                start,
                ray(left, c0),
                ray(left, c1),
                ray(left, c1),
                ray(left, c1),
                end,
            ];
        }
        let mut tangent = (b - a).cross(c0 - a);
        if tangent.dot(a) < 0.0 {
            tangent = -tangent;
        }
        if tangent.dot(c1 - a) <= 0.0 {
            [
                start,
                ray(left, c0),
                ray(left, c0),
                ray(right, c0),
                ray(right, c1),
                end,
            ]
        } else {
            [
                start,
                ray(left, c0),
                ray(left, c1),
                ray(right, c1),
                ray(right, c1),
                end,
            ]
        }
    };
    let mut rims = [rim(r0, r1), rim(-r1, -r0)];
    if slope(a, 0.0) > slope(b, 0.0) {
        rims.iter_mut().for_each(|rim| rim.reverse());
    }
    Some(Shell { rims })
}

/// The shell of the edge between `ends` for a sphere around the origin. The ends must lie outside of it.
///
/// Front and back are the planes through the edge that touch the sphere; left and right go through an end, along the
/// separator's normal, and touch it too. If the line of the edge meets the sphere, the cone of the nearer end holds all
/// of the penumbra, and four planes hold the cone.
///
/// `None` for an edge that points at the centre.
pub fn sphere_shell(ends: [DVec3; 2], radius: f64) -> Option<Shell> {
    /// Nearer, the tangent planes would open too wide to be of use; by eye.
    const TOUCHING: f64 = 1.001;
    let [a, b] = ends;
    let normal = separator_normal(ends)?;
    let along = (b - a).normalize_or_zero();
    let (at_a, at_b) = (a.dot(along), b.dot(along));
    let foot = a - along * at_a;
    let height = foot.length();
    if height <= radius * TOUCHING {
        let near = if a.length_squared() <= b.length_squared() {
            a
        } else {
            b
        };
        let distance_sq = near.length_squared();
        // A little more than the cone of the nearer end, for the line may pass just outside of the sphere.
        let half = 1.01
            * radius
            * (distance_sq / (distance_sq - radius * radius).max(1e-6 * radius * radius)).sqrt();
        let across = normal.cross(near).normalize_or_zero() * half;
        let up = normal * half;
        return quad_shell(ends, [across + up, up - across, -across - up, across - up]);
    }
    let half = radius * height / (height * height - radius * radius).sqrt();
    let reach = |at: f64, side: f64| {
        let to_center = height.atan2(-at);
        let tangent = to_center + side * (radius / height.hypot(at)).asin();
        at + height / tangent.tan()
    };
    let (left, right) = (along * reach(at_a, -1.0), along * reach(at_b, 1.0));
    let rim = |sideways: DVec3| {
        let ray = |apex: usize, light: DVec3| RimPoint {
            direction: ends[apex] - light,
            apex,
        };
        let (c0, c1) = (ray(0, left + sideways), ray(1, right + sideways));
        [ray(0, left), c0, c0, c1, c1, ray(1, right)]
    };
    Some(Shell {
        rims: [rim(-normal * half), rim(normal * half)],
    })
}

/// Unit normal of the plane through the ends and the origin, to the outside of the hard shadow.
fn separator_normal([a, b]: [DVec3; 2]) -> Option<DVec3> {
    let normal = a.cross(b);
    let length = normal.length();
    (length > POINTING * a.length() * b.length() && length.is_finite()).then(|| normal / length)
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
