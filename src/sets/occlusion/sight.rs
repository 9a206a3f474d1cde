//! The region that is visible from a point: a convex cone of directions.

use glam::{DVec2, DVec3, Vec3};
use smallvec::SmallVec;

use crate::geometry::{Plane, PlaneSet, convex_polygon};

/// Sine by which a direction may miss a plane and still count as inside.
const ANGLE_SLACK: f64 = 1e-6;

/// Distance by which planes are moved outward: a length in metres, and a share of the eye's coordinates.
const PLANE_SLACK: (f64, f64) = (1e-4, 1e-6);

/// Cosine of the angle to the middle of an outline, below which a direction is too oblique to be projected
/// onto a plane.
const MIN_COSINE: f64 = 0.05;

/// A convex cone of directions from an eye, limited to what lies beyond some planes.
#[derive(Clone, Debug)]
pub(super) struct Sight {
    eye: DVec3,
    /// Corners of the cone, in order. `None` means all directions.
    corners: Option<SmallVec<[DVec3; 8]>>,
    /// Half-spaces that hold everything seen, each as a unit normal and a point on its plane.
    beyond: SmallVec<[(DVec3, DVec3); 8]>,
}

impl Sight {
    /// All directions from an eye.
    pub(super) fn everywhere(eye: DVec3) -> Self {
        Self {
            eye,
            corners: None,
            beyond: SmallVec::new(),
        }
    }

    /// The cone around the given directions.
    pub(super) fn towards(eye: DVec3, corners: &[DVec3]) -> Self {
        Self {
            corners: convex_cone(corners),
            ..Self::everywhere(eye)
        }
    }

    /// The part of this cone that passes through the convex hull of points; `None` if it is empty. With a
    /// plane, the points lie on that plane and everything seen lies beyond it.
    pub(super) fn through(&self, points: &[DVec3], plane: Option<DVec3>) -> Option<Self> {
        let directions: SmallVec<[DVec3; 8]> = points.iter().map(|point| *point - self.eye).collect();
        let mut seen = self.clone();
        if let Some(mut opening) = convex_cone(&directions) {
            if let Some(corners) = &self.corners {
                for normal in normals(corners) {
                    opening = clip(&opening, normal);
                    if opening.len() < 3 {
                        return None;
                    }
                }
            }
            seen.corners = Some(opening);
        }
        if let Some(normal) = plane {
            let away = normal.dot(points[0] - self.eye).signum();
            seen.beyond.push((normal * away, points[0]));
        }
        Some(seen)
    }

    /// The half-spaces that hold everything seen.
    pub(super) fn planes(&self) -> PlaneSet {
        let slack = PLANE_SLACK.0 + PLANE_SLACK.1 * self.eye.abs().max_element();
        let plane = |normal: DVec3, point: DVec3| {
            let normal: Vec3 = normal.as_vec3();
            Plane {
                normal,
                offset: (slack - normal.as_dvec3().dot(point)) as f32,
            }
        };
        let sides = self.corners.iter().flat_map(|corners| normals(corners));
        PlaneSet {
            planes: sides
                .map(|normal| plane(normal, self.eye))
                .chain(self.beyond.iter().map(|(normal, point)| plane(*normal, *point)))
                .collect(),
        }
    }
}

/// Inward unit normals of the sides of a cone. Sides without an angle are left out.
fn normals(corners: &[DVec3]) -> SmallVec<[DVec3; 8]> {
    let middle: DVec3 = corners.iter().map(|corner| corner.normalize_or_zero()).sum();
    (0..corners.len())
        .filter_map(|i| {
            let normal = corners[i]
                .cross(corners[(i + 1) % corners.len()])
                .try_normalize()?;
            Some(if normal.dot(middle) < 0.0 { -normal } else { normal })
        })
        .collect()
}

/// Clips a cone of directions by a plane through the eye.
fn clip(corners: &[DVec3], normal: DVec3) -> SmallVec<[DVec3; 8]> {
    convex_polygon::clip(corners, |corner| {
        normal.dot(corner) + ANGLE_SLACK * corner.length()
    })
}

/// Corners of the convex cone around directions, in order. `None` if they do not lie within 87° of their
/// middle. It is the convex hull in a plane across the middle.
fn convex_cone(directions: &[DVec3]) -> Option<SmallVec<[DVec3; 8]>> {
    let middle: DVec3 = directions.iter().map(|d| d.normalize_or_zero()).sum();
    let axis = middle.try_normalize()?;
    let (right, up) = axis.any_orthonormal_pair();
    let mut flat: SmallVec<[DVec2; 8]> = SmallVec::new();
    for direction in directions {
        let along = axis.dot(*direction);
        if !(along > MIN_COSINE * direction.length()) {
            return None;
        }
        flat.push(DVec2::new(right.dot(*direction), up.dot(*direction)) / along);
    }
    let corners = convex_polygon::hull(&flat);
    let direction = |at: usize| axis + right * flat[at].x + up * flat[at].y;
    Some(corners.into_iter().map(direction).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(z: f64, half: f64, x: f64) -> [DVec3; 4] {
        [(-1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (1.0, -1.0)]
            .map(|(a, b)| DVec3::new(x + a * half, b * half, z))
    }

    fn sees(sight: &Sight, point: DVec3) -> bool {
        let planes = sight.planes().planes;
        planes.iter().all(|plane| plane.distance(point.as_vec3()) >= 0.0)
    }

    #[test]
    fn openings_are_clipped_one_by_the_other() {
        let sight = Sight::everywhere(DVec3::ZERO);
        let first = sight.through(&square(-1.0, 1.0, 0.0), Some(DVec3::Z)).unwrap();
        assert!(sees(&first, DVec3::new(1.9, 0.0, -2.0)));
        assert!(!sees(&first, DVec3::new(2.1, 0.0, -2.0)));
        assert!(!sees(&first, DVec3::new(0.0, 0.0, -0.5)), "before the opening");
        let second = first.through(&square(-2.0, 1.0, 2.0), Some(DVec3::Z)).unwrap();
        assert!(sees(&second, DVec3::new(3.0, 0.0, -4.0)));
        assert!(!sees(&second, DVec3::new(1.0, 0.0, -4.0)));
        assert!(!sees(&second, DVec3::new(4.2, 0.0, -4.0)));
        assert!(second.through(&square(-3.0, 0.4, -2.0), Some(DVec3::Z)).is_none());
    }

    #[test]
    fn an_outline_around_the_eye_clips_nothing() {
        let sight = Sight::everywhere(DVec3::ZERO);
        let wide = sight.through(&square(-0.01, 5.0, 0.0), Some(DVec3::Z)).unwrap();
        assert!(sees(&wide, DVec3::new(50.0, 0.0, -0.1)));
    }
}
