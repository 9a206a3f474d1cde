//! The shell of a penumbra wedge: it encloses all points that see an edge in front of the light.
//!
//! Light space has its origin at the light's centre, world scale and the light's own axes. For a point `y` on
//! the edge, `x` on the light and `s ≥ 0`, the point `y + s (y − x)` sees a part of the light behind the
//! edge. For a convex light, these points form a convex set: the hull of the edge and of the rays from its
//! ends away from each corner of the light. The separator is the plane through edge and centre. It cuts the
//! hull into an outer half, which the hard shadow leaves out, and an inner half, which it darkens.
//!
//! An edge between two triangles whose planes cut the light is a silhouette edge only from a part of the
//! light, between the planes. Its shell is that of this part, a sliver ([`Sight`]). If the centre is not in
//! the part, the whole shell is in one half, and its rim of the other half is flat.
//!
//! Source: Assarsson et al. 2003, section 4.1 and figures 1 and 2. The paper's tight wedge takes two
//! triangles of each end pyramid; ours takes those of the hull, one to three. Its wedge of a sphere moves an
//! end to make front and back planar; our tangent planes through the line of the edge are planar as they are,
//! and tighter.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use super::sight::{SLIVER_MARGIN, Sight, distance_of_line, passes_clear, side, towards_center, turned};
use crate::geometry::convex_polygon::{chord, clip};

/// Number of points of a half's rim, which is where its shell ends at infinity, from one side of the
/// separator to the other.
pub const RIM: usize = 6;

/// A point at infinity and the end of the edge from which its ray starts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RimPoint {
    /// Direction of the ray, light space.
    pub direction: DVec3,
    /// Index of the end of the edge: 0 or 1.
    pub apex: usize,
}

/// Rims of the outer and the inner half.
///
/// Both rims start on one ray and end on another. These two rays lie in the separator, one on the side of the
/// edge's start and one on the side of its end. Neighbouring rays from the same end span a triangle, rays
/// from different ends a quad.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shell {
    /// Rim of the outer half, then of the inner half.
    pub rims: [[RimPoint; RIM]; 2],
    /// The half that contains the whole shell, if one does. The rays that both rims share are then not in the
    /// separator.
    pub only: Option<Half>,
}

/// A half of a wedge, as index into [`Shell::rims`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Half {
    /// Outside of the hard shadow.
    Outer,
    /// Within it.
    Inner,
}

/// Smallest sine of the angle between the ends of an edge, seen from the light's centre. Below it, the edge
/// points at the centre and covers no sector of the light.
const POINTING: f64 = 1e-9;

/// Returns the shell of the edge between `ends` for a light that is a parallelogram around the origin.
/// `corners` are in order around it. Both ends must be on the same side of its plane.
///
/// `None` for an edge that points at the centre, which covers nothing and has no separator, and for an edge
/// that is a silhouette edge from no point of the light.
pub fn quad_shell(ends: [DVec3; 2], corners: [DVec3; 4], sight: &Sight) -> Option<Shell> {
    let normal = separator_normal(ends)?.extend(0.0);
    let whole = |polygon: &[DVec3]| {
        let base = Base::new(ends, chord(polygon, side(normal))?, normal.truncate())?;
        let rims = [-normal, normal].map(|inward| base.rim(&clip(polygon, side(inward))));
        Some(Shell {
            rims: [rims[0]?, rims[1]?],
            only: None,
        })
    };
    // A line that passes near the light has slivers on both sides of it.
    if !passes_clear(ends, corners) {
        return whole(&corners);
    }
    let reach = corners.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let angle = SLIVER_MARGIN * reach / distance_of_line(ends).max(reach);
    let cuts = || sight.planes.iter().flatten().map(|plane| towards_center(*plane));
    if !sight.is_beside {
        let mut kept = SmallVec::from_slice(&corners);
        for cut in cuts() {
            kept = clip(&kept, side(turned(cut, ends, angle, true)));
        }
        return whole(&kept).or_else(|| whole(&corners));
    }
    // The part lies between the plane nearer to the centre and the other plane.
    let mut cuts: SmallVec<[DVec4; 2]> = cuts().collect();
    if let [first, second] = cuts[..]
        && let Some([a, b]) = chord(&corners, side(second))
        && side(first)((a + b) * 0.5) >= 0.0
    {
        cuts.swap(0, 1);
    }
    let near = turned(*cuts.first()?, ends, angle, false);
    let mut part = clip(&corners, side(-near));
    if let Some(&far) = cuts.get(1) {
        part = clip(&part, side(turned(far, ends, angle, true)));
    }
    let middle = part.iter().sum::<DVec3>();
    if part.len() < 3 {
        return None;
    }
    let half = if normal.truncate().dot(middle) < 0.0 {
        Half::Outer
    } else {
        Half::Inner
    };
    let beside = || {
        let base = Base::new(ends, chord(&corners, side(near))?, near.truncate())?;
        let (all, flat) = (base.rim(&part)?, base.rim(&[])?);
        Some(Shell {
            rims: match half {
                Half::Outer => [all, flat],
                Half::Inner => [flat, all],
            },
            only: Some(half),
        })
    };
    beside().or_else(|| whole(&corners))
}

/// A plane through the edge, the chord in which it cuts the light, and the rays that bound the points which
/// see the edge in front of the chord.
struct Base {
    ends: [DVec3; 2],
    /// Ends of the chord: on the side of the edge's start, and of its end.
    chord: [DVec3; 2],
    /// The end of the edge from which the ray away from each end of the chord starts.
    apexes: [usize; 2],
}

impl Base {
    fn new(ends: [DVec3; 2], mut chord: [DVec3; 2], normal: DVec3) -> Option<Self> {
        let middle = (chord[0] + chord[1]) * 0.5;
        let [a, b] = ends.map(|end| end - middle);
        let (half, along) = {
            let half = (chord[0] - chord[1]) * 0.5;
            (half.length(), half.normalize_or_zero())
        };
        let mut away = along.cross(normal).normalize_or_zero();
        if away.dot(a + b) < 0.0 {
            away = -away;
        }
        let slope = |end: DVec3, point: f64| (end.dot(along) - point) / end.dot(away).max(f64::MIN_POSITIVE);
        let mut apexes = [
            usize::from(slope(b, half) < slope(a, half)),
            usize::from(slope(b, -half) > slope(a, -half)),
        ];
        if slope(a, 0.0) > slope(b, 0.0) {
            chord.reverse();
            apexes.reverse();
        }
        (half > 0.0).then_some(Self { ends, chord, apexes })
    }

    fn ray(&self, apex: usize, light: DVec3) -> RimPoint {
        RimPoint {
            direction: self.ends[apex] - light,
            apex,
        }
    }

    /// Returns the rim of the half whose rays come from a polygon beside the chord; without a polygon the rim
    /// is flat. `None` if the polygon has more corners than a rim has room for.
    fn rim(&self, polygon: &[DVec3]) -> Option<[RimPoint; RIM]> {
        let [from, to] = self.chord;
        let [left, right] = self.apexes;
        let (start, end) = (self.ray(left, from), self.ray(right, to));
        let mut rim = [end; RIM];
        rim[..RIM / 2].fill(start);
        // Orders the polygon's corners from one end of the chord to the other, by the angle about its middle.
        let middle = (from + to) * 0.5;
        let along = (from - to).normalize_or_zero();
        let across = |point: DVec3| (point - middle) - along * along.dot(point - middle);
        let size = (from - to).length();
        let mut chain: SmallVec<[(f64, DVec3); 8]> = polygon
            .iter()
            .filter(|point| across(**point).length() > 1e-9 * size)
            .map(|&point| (across(point).length().atan2(along.dot(point - middle)), point))
            .collect();
        chain.sort_by(|a, b| a.0.total_cmp(&b.0));
        chain.dedup_by(|a, b| a.1.distance_squared(b.1) <= 1e-18 * size * size);
        if chain.is_empty() {
            return Some(rim);
        }
        if chain.len() > RIM - 3 {
            return None;
        }
        // Finds the corner through which the front or back plane goes.
        let [a, b] = self.ends;
        let mut turn = chain.len() - 1;
        if left != right {
            turn = 0;
            for (i, (_, point)) in chain.iter().enumerate().skip(1) {
                let mut tangent = (b - a).cross(chain[turn].1 - a);
                if tangent.dot(middle - a) > 0.0 {
                    tangent = -tangent;
                }
                if tangent.dot(point - a) > 0.0 {
                    turn = i;
                }
            }
        }
        let by_left = chain[..=turn].iter().map(|(_, point)| self.ray(left, *point));
        let by_right = chain[turn..].iter().map(|(_, point)| self.ray(right, *point));
        let last = 1 + by_left.len();
        for (rim, ray) in rim[1..].iter_mut().zip(by_left) {
            *rim = ray;
        }
        let first = RIM - 1 - by_right.len();
        let turned = rim[last - 1];
        rim[last..first].fill(turned);
        if left != right {
            for (rim, ray) in rim[first..RIM - 1].iter_mut().zip(by_right) {
                *rim = ray;
            }
        } else {
            // The line of the edge meets the light, so the cone of the nearer end contains everything.
            rim[last..RIM - 1].fill(turned);
        }
        rim[RIM - 1] = end;
        Some(rim)
    }
}

/// Returns the shell of the edge between `ends` for a sphere around the origin. Both ends must be outside of
/// the sphere.
///
/// Front and back are the planes through the edge that touch the sphere or bound its sight. Left and right go
/// through an end along the separator's normal and touch the sphere too. If the line of the edge meets the
/// sphere, the cone of the nearer end contains the whole penumbra, and four planes contain the cone.
///
/// `None` for an edge that points at the centre, and for an edge that is a silhouette edge from no point of
/// the light.
pub fn sphere_shell(ends: [DVec3; 2], radius: f64, sight: &Sight) -> Option<Shell> {
    /// For a nearer line, the tangent planes would open too wide to be useful. Chosen by eye.
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
        // A little more than the cone of the nearer end, because the line may pass just outside of the
        // sphere.
        let half = 1.01
            * radius
            * (distance_sq / (distance_sq - radius * radius).max(1e-6 * radius * radius)).sqrt();
        let across = normal.cross(near).normalize_or_zero() * half;
        let up = normal * half;
        let around = [across + up, up - across, -across - up, across - up];
        return quad_shell(ends, around, &Sight::default());
    }
    let half = radius * height / (height * height - radius * radius).sqrt();
    let reach = |at: f64, side: f64| {
        let to_center = height.atan2(-at);
        let tangent = to_center + side * (radius / height.hypot(at)).asin();
        at + height / tangent.tan()
    };
    let (left, right) = (along * reach(at_a, -1.0), along * reach(at_b, 1.0));
    let ray = |apex: usize, light: DVec3| RimPoint {
        direction: ends[apex] - light,
        apex,
    };
    // Places where a plane through the edge crosses the separator's normal.
    let crossings = sight.planes.iter().flatten().map(|plane| {
        let at = -plane.w / plane.truncate().dot(normal);
        at.clamp(-half, half)
    });
    let mut crossings: SmallVec<[f64; 2]> = crossings.collect();
    let margin = SLIVER_MARGIN * half;
    let rim = |from: f64, to: f64| {
        let (from, to) = (normal * from, normal * to);
        let (c0, c1) = (ray(0, left + to), ray(1, right + to));
        [ray(0, left + from), c0, c0, c1, c1, ray(1, right + from)]
    };
    if !sight.is_beside {
        let outer = crossings
            .iter()
            .copied()
            .filter(|at| *at < 0.0)
            .fold(-half, f64::max);
        let inner = crossings
            .iter()
            .copied()
            .filter(|at| *at >= 0.0)
            .fold(half, f64::min);
        return Some(Shell {
            rims: [
                rim(0.0, (outer - margin).max(-half)),
                rim(0.0, (inner + margin).min(half)),
            ],
            only: None,
        });
    }
    crossings.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    let &near = crossings.first()?;
    let far = crossings.get(1).copied().filter(|far| far * near > 0.0);
    let sign = 1f64.copysign(near);
    let from = sign * (near.abs() - margin).max(0.0);
    let to = sign * far.map_or(half, |far| (far.abs() + margin).min(half));
    let (all, flat) = (rim(from, to), rim(from, from));
    Some(if near < 0.0 {
        Shell {
            rims: [all, flat],
            only: Some(Half::Outer),
        }
    } else {
        Shell {
            rims: [flat, all],
            only: Some(Half::Inner),
        }
    })
}

/// Returns the unit normal of the plane through the ends and the origin. It points out of the hard shadow.
fn separator_normal([a, b]: [DVec3; 2]) -> Option<DVec3> {
    let normal = a.cross(b);
    let length = normal.length();
    (length > POINTING * a.length() * b.length() && length.is_finite()).then(|| normal / length)
}
