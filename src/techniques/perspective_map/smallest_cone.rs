//! The smallest cone around directions.

use glam::DVec3;

/// A cone with its tip at the origin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Unit vector along the axis.
    pub axis: DVec3,
    /// Cosine of the angle between axis and surface.
    pub cos: f64,
}

impl Cone {
    /// Whether a unit direction lies in the cone, up to rounding.
    pub fn holds(&self, direction: DVec3) -> bool {
        self.axis.dot(direction) >= self.cos - 1e-12
    }

    fn of_one(a: DVec3) -> Self {
        Self { axis: a, cos: 1.0 }
    }

    fn of_two(a: DVec3, b: DVec3) -> Self {
        let axis = (a + b).normalize_or(a);
        Self {
            axis,
            cos: axis.dot(a),
        }
    }

    /// The cone with three directions on its surface.
    fn of_three(a: DVec3, b: DVec3, c: DVec3) -> Self {
        let normal = (b - a).cross(c - a);
        match normal.try_normalize() {
            Some(axis) if axis.dot(a) < 0.0 => Self {
                axis: -axis,
                cos: -axis.dot(a),
            },
            Some(axis) => Self {
                axis,
                cos: axis.dot(a),
            },
            None => Self::of_two(a, b),
        }
    }
}

/// Returns the smallest cone around unit directions, or `None` if no half-space holds them all; an empty slice
/// has none either. The order of the directions changes: it is shuffled by a fixed seed.
///
/// Directions of one cone lie in a cap of the unit sphere. The smallest ball around them meets the sphere in
/// that cap, so the search for the smallest ball applies, with at most three directions on the border.
/// Source: Welzl 1991, "Smallest Enclosing Disks (Balls and Ellipsoids)", in the form with nested loops, whose
/// expected time is linear; Gärtner 1999, "Fast and Robust Smallest Enclosing Balls", which Kozlov 2004, GPU
/// Gems ch. 14, §14.2.2, proposes for the light's camera.
pub fn smallest_cone(directions: &mut [DVec3]) -> Option<Cone> {
    let count = directions.len();
    let mut random: u64 = 0x9e37_79b9_7f4a_7c15;
    for i in (1..count).rev() {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        directions.swap(i, (random >> 33) as usize % (i + 1));
    }
    let mut cone = Cone::of_one(*directions.first()?);
    for i in 1..count {
        if cone.holds(directions[i]) {
            continue;
        }
        cone = Cone::of_one(directions[i]);
        for j in 0..i {
            if cone.holds(directions[j]) {
                continue;
            }
            cone = Cone::of_two(directions[i], directions[j]);
            for k in 0..j {
                if !cone.holds(directions[k]) {
                    cone = Cone::of_three(directions[i], directions[j], directions[k]);
                }
            }
        }
        // Directions that fill more than a half-space have no cone, and the search would take cubic time.
        let seen = &directions[..=i];
        if seen.iter().any(|d| cone.axis.dot(*d) < cone.cos - NO_CONE) {
            return None;
        }
    }
    let holds_all = directions.iter().all(|d| cone.axis.dot(*d) >= cone.cos - 1e-9);
    (cone.cos > 0.0 && holds_all).then_some(cone)
}

/// Violation of a cone around a part of the directions that rounding does not explain.
const NO_CONE: f64 = 1e-6;

#[cfg(test)]
mod tests {
    use super::*;

    /// The smallest of all cones through two or three of the directions that hold the rest.
    fn brute_force(directions: &[DVec3]) -> Option<Cone> {
        let mut best: Option<Cone> = None;
        let mut offer = |cone: Cone| {
            let holds = directions.iter().all(|d| cone.axis.dot(*d) >= cone.cos - 1e-9);
            if cone.cos > 0.0 && holds && best.is_none_or(|best| cone.cos > best.cos) {
                best = Some(cone);
            }
        };
        for (i, &a) in directions.iter().enumerate() {
            for (j, &b) in directions[..i].iter().enumerate() {
                offer(Cone::of_two(a, b));
                for &c in &directions[..j] {
                    offer(Cone::of_three(a, b, c));
                }
            }
        }
        best
    }

    #[test]
    fn it_is_the_cone_that_brute_force_finds() {
        let (mut wide, mut none) = (0, 0);
        for i in 0..400_i32 {
            let mut random = f64::from(i) + 1.0;
            let mut next = || {
                random = (random * 997.13 + 0.371).fract() * 1000.0 + 1.0;
                random.fract() * 2.0 - 1.0
            };
            let spread = [0.01, 0.3, 1.0, 3.0][i as usize % 4];
            let middle = DVec3::new(next(), next(), next()).normalize_or(DVec3::Z);
            let count = 3 + i as usize % 12;
            let mut directions: Vec<DVec3> = (0..count)
                .map(|_| (middle + DVec3::new(next(), next(), next()) * spread).normalize_or(middle))
                .collect();
            let expected = brute_force(&directions);
            match (smallest_cone(&mut directions), expected) {
                (Some(found), Some(best)) => {
                    assert!((found.cos - best.cos).abs() < 1e-7, "{i}: {found:?} {best:?}");
                    assert!(found.axis.distance(best.axis) < 1e-3, "{i}: {found:?} {best:?}");
                    wide += usize::from(found.cos < 0.5);
                }
                (None, None) => none += 1,
                (found, best) => {
                    // Directions that just fill a half-space may go either way.
                    let cos = found.or(best).map_or(0.0, |cone| cone.cos);
                    assert!(cos < 1e-3, "{i}: {found:?} {best:?}");
                }
            }
        }
        assert!(wide > 20 && none > 20, "{wide} {none}");
    }

    /// Without an early end this takes hours.
    #[test]
    fn a_million_directions_all_around_have_none() {
        let direction = |i: i32| {
            let (height, turn) = (
                (f64::from(i) * 0.618_034).fract() * 2.0 - 1.0,
                f64::from(i) * 0.754_877,
            );
            let (sin, cos) = (turn.fract() * std::f64::consts::TAU).sin_cos();
            let radius = (1.0 - height * height).sqrt();
            DVec3::new(radius * cos, radius * sin, height)
        };
        let mut all: Vec<DVec3> = (0..1_000_000).map(direction).collect();
        assert_eq!(smallest_cone(&mut all), None);
        let mut half: Vec<DVec3> = all.into_iter().filter(|direction| direction.y > 0.1).collect();
        let cone = smallest_cone(&mut half).expect("they are in front of a plane");
        assert!(cone.axis.y > 0.999 && cone.cos > 0.09, "{cone:?}");
    }

    #[test]
    fn few_and_equal_directions_have_cones() {
        assert_eq!(smallest_cone(&mut []), None);
        let one = smallest_cone(&mut [DVec3::X; 5]).expect("one direction is a cone");
        assert_eq!((one.axis, one.cos), (DVec3::X, 1.0));
        assert_eq!(smallest_cone(&mut [DVec3::X, -DVec3::X]), None);
    }
}
