//! Barn doors: the superellipse that bounds what a light lights.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::{Vec2, Vec3};

/// Barn doors of a light: the light shines inside of a superellipse on the plane one metre before it, and fades
/// to nothing across an edge around it. The axes are local X and Y of the light, and the light shines along −Z.
///
/// It shapes point, spot, rectangle and sphere lights, from the light's centre. A spot light shines in its cone
/// and in its shape. Directional lights ignore it, because they have no such plane. Nothing is lit behind the
/// plane of a shaped light. Default: no shape.
///
/// Costs: one pass over the light's pixels. Objects, pixels and shadow casters outside of the shape cost
/// nothing, so a shape can make a light cheaper.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Serialize, serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LightShape {
    /// Half the width of the region of full intensity, metres on the plane one metre before the light; at least
    /// 0. Infinity does not limit the width. Default: infinity.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub width: f32,
    /// Half the height of the region of full intensity, metres on the same plane; at least 0. Infinity does not
    /// limit the height. Default: infinity.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub height: f32,
    /// Width of the edge across which the light fades, metres beyond `width`; at least 0. At 0 the edge is
    /// sharp. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub width_edge: f32,
    /// Height of the edge across which the light fades, metres beyond `height`; at least 0. At 0 the edge is
    /// sharp. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub height_edge: f32,
    /// Roundness of the region, 0 to 1. At 0 the region is a rectangle, at 1 an ellipse, and between them a
    /// rectangle with round corners. Default: 1.
    #[cfg_attr(feature = "schema", schemars(range(min = 0, max = 1)))]
    pub round: f32,
}

impl Default for LightShape {
    fn default() -> Self {
        Self {
            width: f32::INFINITY,
            height: f32::INFINITY,
            width_edge: 0.0,
            height_edge: 0.0,
            round: 1.0,
        }
    }
}

/// Semi-axes from this value on count as infinite, metres on the plane one metre before the light.
pub const WIDEST: f32 = 1e15;

/// The least roundness that the formula takes. Its exponent, 2 over the roundness, then still gives a power that
/// an `f32` holds, and the superellipse differs from a rectangle by less than a millionth.
pub const LEAST_ROUND: f32 = 1e-5;

/// The largest value of the superellipse's radius. Products of two radii then fit an `f32`.
const LARGEST_RADIUS: f32 = 1e8;

impl LightShape {
    /// Returns whether the shape bounds nothing.
    pub fn is_unbounded(&self) -> bool {
        self.width >= WIDEST && self.height >= WIDEST
    }

    /// Returns the semi-axes of the region of full intensity.
    pub fn inner(&self) -> Vec2 {
        Vec2::new(self.width, self.height).min(Vec2::splat(WIDEST))
    }

    /// Returns the semi-axes of the region outside of which nothing is lit.
    pub fn outer(&self) -> Vec2 {
        (self.inner() + Vec2::new(self.width_edge, self.height_edge)).min(Vec2::splat(WIDEST))
    }

    /// Returns the exponent of the superellipse: 2 for an ellipse, and a large number for a rectangle.
    pub fn exponent(&self) -> f32 {
        2.0 / self.round.max(LEAST_ROUND)
    }

    /// The share of the light that passes the doors towards a point, 0 to 1. `point` is in light space: x and y
    /// along the doors, z the depth in front of the light.
    ///
    /// The listing divides by powers that may be 0. Here the superellipse is evaluated as a radius, the factor by
    /// which the superellipse must grow to pass through the point: `1 / inner` and `1 / outer` of the listing. It
    /// has no singular point, neither on the axes nor at a roundness of 0.
    /// Source: Pellacini & Vidimce 2004, GPU Gems ch. 10, listing 10-2, `computeSuperellipseShaping`.
    pub fn factor(&self, point: Vec3) -> f32 {
        if point.z <= 0.0 {
            return 0.0;
        }
        let at = point.truncate().abs() / point.z.max(1e-20);
        let inner = if self.inner().min_element() > 0.0 {
            radius(at, self.inner(), self.exponent())
        } else {
            LARGEST_RADIUS
        };
        let outer = radius(at, self.outer(), self.exponent());
        let t = ((inner - 1.0) * outer / (inner - outer).max(1e-20)).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    }
}

/// The factor by which the superellipse of the given semi-axes must grow to pass through a point of the first
/// quadrant: 1 on the superellipse, less than 1 inside.
fn radius(at: Vec2, semi_axes: Vec2, exponent: f32) -> f32 {
    let relative = (at / semi_axes.max(Vec2::splat(1e-12))).min(Vec2::splat(LARGEST_RADIUS));
    let longest = relative.max_element();
    let ratio = (relative.min_element() / longest.max(1e-20)).max(1e-20);
    (longest * (1.0 + ratio.powf(exponent)).powf(exponent.recip())).min(LARGEST_RADIUS)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listing(shape: &LightShape, point: Vec3) -> f64 {
        let [a, b] = shape.inner().as_dvec2().to_array();
        let [outer_a, outer_b] = shape.outer().as_dvec2().to_array();
        let round = f64::from(shape.round);
        let at = (point.truncate() / point.z).abs().as_dvec2();
        let (exp1, exp2) = (2.0 / round, -round / 2.0);
        let inner = a * b * ((b * at.x).powf(exp1) + (a * at.y).powf(exp1)).powf(exp2);
        let outer =
            outer_a * outer_b * ((outer_b * at.x).powf(exp1) + (outer_a * at.y).powf(exp1)).powf(exp2);
        let t = ((1.0 - inner) / (outer - inner)).clamp(0.0, 1.0);
        1.0 - t * t * (3.0 - 2.0 * t)
    }

    #[test]
    fn it_is_the_listing_where_that_is_finite() {
        let shape = LightShape {
            width: 0.4,
            height: 0.3,
            width_edge: 0.1,
            height_edge: 0.2,
            round: 0.5,
        };
        let mut between = 0;
        for step in 0..400 {
            let at = Vec2::from_angle(step as f32 * 0.7) * (0.1 + step as f32 * 0.002);
            let point = at.extend(1.0) * 3.0;
            let (got, expected) = (f64::from(shape.factor(point)), listing(&shape, point));
            assert!((got - expected).abs() < 1e-5, "{point}: {got}, not {expected}");
            between += usize::from((0.05..0.95).contains(&got));
        }
        assert!(between > 20, "{between} points are on the edge");
    }

    #[test]
    fn limits_are_finite_and_as_they_look() {
        let rectangle = LightShape {
            width: 0.4,
            height: 0.3,
            round: 0.0,
            ..LightShape::default()
        };
        let at = |x: f32, y: f32| rectangle.factor(Vec3::new(x, y, 1.0));
        assert_eq!([at(0.0, 0.0), at(0.399, 0.299), at(0.0, 0.299)], [1.0; 3]);
        assert_eq!([at(0.401, 0.0), at(0.0, 0.301), at(0.401, 0.301)], [0.0; 3]);
        assert_eq!(
            rectangle.factor(Vec3::new(0.0, 0.0, -1.0)),
            0.0,
            "behind the light"
        );
        for round in [0.0, 1e-20, 0.5, 1.0] {
            for size in [0.0, 1e-20, 0.5, 1e20, f32::INFINITY] {
                for edge in [0.0, 1e-20, 0.5, f32::INFINITY] {
                    for x in [0.0, 1e-30, 0.5, 1e30] {
                        let shape = LightShape {
                            width: size,
                            height: 0.5,
                            width_edge: edge,
                            height_edge: edge,
                            round,
                        };
                        for z in [-1.0, 0.0, 1e-30, 1.0, 1e30] {
                            let factor = shape.factor(Vec3::new(x, 0.0, z));
                            assert!((0.0..=1.0).contains(&factor), "{shape:?} at {x}, {z}: {factor}");
                        }
                    }
                }
            }
        }
    }
}
