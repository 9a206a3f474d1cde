//! The region of space that a light reaches.

use glam::Vec3;

use crate::geometry::{Aabb, Cone, Sphere};
use crate::scene::LightKind;
use crate::sets::index::box_tests::Touch;
use crate::sets::index::boxes::Boxes;
use crate::sets::view::screen::{Projector, ScreenBounds};

/// The region of space in which a light lights, and in which its casters must be. The region is convex and
/// holds the light, so every segment from a lit point to the light stays inside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum LightVolume {
    /// All of space: directional lights, and point and sphere lights without a range.
    #[default]
    Infinite,
    /// A ball, for point and sphere lights: the range, grown by the sphere's radius.
    Ball(Sphere),
    /// A cone, for spot lights.
    Cone(Cone),
    /// Half a ball, for rectangles: the space in front of them, up to the range grown by the rectangle's half
    /// diagonal. It is stored as a cone of half-angle π/2.
    HalfBall(Cone),
}

/// Ranges from this value on count as infinite, metres. Their squares still fit `f32`, and boxes are clamped
/// to the same value.
const INFINITE_RANGE: f32 = 1e15;

impl LightVolume {
    /// The volume of a light with the given kind, range and place. `extent` is the radius of the sphere
    /// around the source.
    pub fn new(kind: LightKind, range: f32, center: Vec3, direction: Vec3, extent: f32) -> Self {
        let range = if range >= INFINITE_RANGE {
            f32::INFINITY
        } else {
            (range + extent) * (1.0 + 4.0 * f32::EPSILON)
        };
        let cone = |half_angle: f32| Cone {
            apex: center,
            axis: direction,
            half_angle,
            range,
        };
        match kind {
            LightKind::Directional => Self::Infinite,
            LightKind::Spot { outer_angle, .. } => Self::Cone(cone(outer_angle)),
            LightKind::Rect { .. } => Self::HalfBall(cone(std::f32::consts::FRAC_PI_2)),
            LightKind::Point | LightKind::Sphere { .. } if range == f32::INFINITY => Self::Infinite,
            LightKind::Point | LightKind::Sphere { .. } => Self::Ball(Sphere {
                center,
                radius: range,
            }),
        }
    }

    /// The volume of a light with barn doors, which lets light into a cone of the given half-angle alone; without
    /// one it is that of [`LightVolume::new`]. A cone around a source with an extent begins behind the source, where
    /// it holds all of it.
    pub fn shaped(
        kind: LightKind,
        range: f32,
        center: Vec3,
        direction: Vec3,
        extent: f32,
        doors: Option<f32>,
    ) -> Self {
        let whole = Self::new(kind, range, center, direction, extent);
        let Some(doors) = doors.filter(|_| kind != LightKind::Directional) else {
            return match whole {
                Self::Cone(cone) if extent > 0.0 => Self::Cone(holding(cone, extent)),
                whole => whole,
            };
        };
        let (half_angle, range) = match whole {
            Self::Cone(cone) | Self::HalfBall(cone) => (cone.half_angle.min(doors), cone.range),
            Self::Ball(ball) => (doors, ball.radius),
            Self::Infinite => (doors, f32::INFINITY),
        };
        let cone = Cone {
            apex: center,
            axis: direction,
            half_angle,
            range,
        };
        match whole {
            // A rectangle lies in the plane where its half ball ends, and doors as wide bound nothing else.
            Self::HalfBall(_) if half_angle >= std::f32::consts::FRAC_PI_2 => whole,
            _ => Self::Cone(holding(cone, extent)),
        }
    }

    /// The box around the volume, padded. It is infinite where the volume is.
    pub fn aabb(&self) -> Aabb {
        let aabb = match self {
            Self::Infinite => {
                return Aabb {
                    min: Vec3::NEG_INFINITY,
                    max: Vec3::INFINITY,
                };
            }
            Self::Ball(ball) => ball.aabb(),
            Self::Cone(cone) | Self::HalfBall(cone) => cone.aabb(),
        };
        let padded = aabb.padded();
        Aabb {
            min: Vec3::select(aabb.min.is_finite_mask(), padded.min, aabb.min),
            max: Vec3::select(aabb.max.is_finite_mask(), padded.max, aabb.max),
        }
    }

    /// Bits of those boxes of a word, among `candidates`, that may touch the volume.
    pub(in crate::sets) fn touching(&self, boxes: &Boxes, word: usize, candidates: usize) -> usize {
        match self {
            Self::Infinite => candidates,
            Self::Ball(ball) => boxes.touching_sphere(word, candidates, ball),
            Self::Cone(cone) | Self::HalfBall(cone) => boxes.touching_cone(word, candidates, cone),
        }
    }

    /// The clusters that may touch the volume, and those that certainly lie inside it.
    pub(in crate::sets) fn clusters_touching(&self, boxes: &Boxes, word: usize, candidates: usize) -> Touch {
        match self {
            Self::Infinite => Touch {
                touching: candidates,
                inside: candidates,
            },
            Self::Ball(ball) => boxes.clusters_touching_sphere(word, candidates, ball),
            Self::Cone(cone) | Self::HalfBall(cone) => boxes.clusters_touching_cone(word, candidates, cone),
        }
    }

    /// Bounds on the screen of the part of the volume that lies behind the near plane.
    pub(in crate::sets) fn screen_bounds(&self, projector: &Projector) -> ScreenBounds {
        match self {
            Self::Infinite => ScreenBounds::ALL,
            Self::Ball(ball) => projector.bounds_of_ball(ball.center.as_dvec3(), f64::from(ball.radius)),
            Self::Cone(cone) | Self::HalfBall(cone) => cone_screen_bounds(cone, projector),
        }
    }
}

/// Moves the apex of a cone back until the cone holds a ball of the given radius around its old apex.
fn holding(cone: Cone, radius: f32) -> Cone {
    if radius <= 0.0 {
        return cone;
    }
    let back = radius / cone.half_angle.sin().max(1e-3) * (1.0 + 1e-5);
    Cone {
        apex: cone.apex - cone.axis * back,
        range: cone.range + back + radius,
        ..cone
    }
}

fn cone_screen_bounds(cone: &Cone, projector: &Projector) -> ScreenBounds {
    let mut bounds = ScreenBounds::ALL;
    let apex = cone.apex.as_dvec3();
    if cone.range.is_finite() {
        let aabb = cone.aabb().padded();
        bounds = projector.bounds_of_box(aabb.center().as_dvec3(), aabb.half_size().as_dvec3());
    }
    if let Some(points) = cone.bounding_points() {
        bounds = bounds.intersection(projector.bounds_of_hull(points));
    }
    let gradient = projector.depth_gradient();
    let length = gradient.length();
    let depth = projector.depth(apex);
    let reach = |sign: f64| {
        let extent = f64::from(cone.extent((gradient / length * sign).as_vec3()));
        if cone.range.is_finite() {
            (extent + 1e-6 * f64::from(cone.range)) * length
        } else {
            extent * length
        }
    };
    bounds.near = bounds.near.max(depth - reach(-1.0));
    bounds.far = bounds.far.min(depth + reach(1.0));
    bounds
}
