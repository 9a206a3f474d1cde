//! The barn map: a texture of what passes the barn doors of a light.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::{Vec2, Vec3};

use super::shape::{LightShape, WIDEST};

/// Takes what passes a light's [`LightShape`] from a texture instead of computing it at each pixel.
///
/// The texture is made in the frame in which the shape changes, and kept until it changes again; a light that moves keeps
/// it. It holds one quarter of the shape, which is symmetric. Its error is at most [`BarnMap::ERROR`] of the light. Edges
/// and openings that are too small for that ([`BarnMap::holds`]) are computed as without the component, so sharp edges
/// stay sharp. Distances ([`LightDistance`](super::LightDistance)) are always computed, and so is the shape on blended
/// surfaces.
///
/// Without the component the shape is computed at each pixel. Use it for lights with soft edges that cover many pixels.
/// On a software rasterizer the evaluation alone took 0.44 to 0.62 of the time, and a frame with nine shaped lights 0.96
/// (`tests/gpu/barn_map.rs`, `tests/gpu/light_model/cost.rs`). It takes `resolution²` × 2 bytes for each view, half a
/// megabyte by default. Lights of one shape share a map.
///
/// Source: Pellacini & Vidimce 2004, GPU Gems ch. 10, §10.4.2.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
#[cfg_attr(
    feature = "serde",
    derive(serde::Deserialize),
    serde(default, deny_unknown_fields)
)]
pub struct BarnMap {
    /// Texels along a side, 1 to 2048. Higher values hold narrower edges; each doubling takes four times the memory.
    /// Default: 512, which holds edges and openings of an eighth of the shape's width and height.
    pub resolution: u32,
}

impl Default for BarnMap {
    fn default() -> Self {
        Self { resolution: 512 }
    }
}

impl BarnMap {
    /// Largest difference between map and formula, as a share of the light.
    pub const ERROR: f32 = 0.01;

    /// Fewest texels across an edge or across half an opening. Found by trying 3,000 shapes with such edges, at 6,000
    /// places each: the largest error was 0.0092.
    const LEAST_TEXELS: f32 = 64.0;

    /// Largest resolution, texels.
    const LARGEST: u32 = 2048;

    /// Returns whether the resolution can be used.
    pub fn is_valid(&self) -> bool {
        (1..=Self::LARGEST).contains(&self.resolution)
    }

    /// Returns whether a map of this resolution holds the edges and the opening of a shape.
    pub fn holds(&self, shape: &LightShape) -> bool {
        let steps = self.resolution.saturating_sub(1) as f32;
        let (inner, outer) = (shape.inner(), shape.outer());
        let has_opening = inner.min_element() > 0.0;
        let axis = |inner: f32, outer: f32| {
            let texels = |part: f32| part / outer * steps;
            let edge = texels(outer - inner);
            let opening = if has_opening { texels(inner) } else { edge };
            inner >= WIDEST || (edge >= Self::LEAST_TEXELS && opening >= Self::LEAST_TEXELS)
        };
        axis(inner.x, outer.x) && axis(inner.y, outer.y)
    }

    /// The share of the light that passes the doors towards a point, as the map holds it. `point` is in light space: x
    /// and y along the doors, z the depth in front of the light. Twin of `mapped` in `shaders/passes/light_model.wgsl`.
    pub fn sample(&self, shape: &LightShape, point: Vec3) -> f32 {
        if point.z <= 0.0 {
            return 0.0;
        }
        let last = self.resolution.saturating_sub(1) as f32;
        let at = point.truncate().abs() / point.z.max(1e-20);
        let texel = (at / shape.outer().max(Vec2::splat(1e-12))).min(Vec2::ONE) * last;
        let low = texel.floor();
        let part = texel - low;
        let high = (low + 1.0).min(Vec2::splat(last));
        let value = |x: f32, y: f32| {
            let at = Vec2::new(x, y) / last.max(1.0) * shape.outer();
            shape.factor(at.extend(1.0))
        };
        let row = |y: f32| value(low.x, y) * (1.0 - part.x) + value(high.x, y) * part.x;
        row(low.y) * (1.0 - part.y) + row(high.y) * part.y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in 0..1 that repeat from run to run.
    fn random(state: &mut u32) -> f32 {
        *state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (*state >> 8) as f32 / (1 << 24) as f32
    }

    fn random_shape(state: &mut u32) -> LightShape {
        let mut number = |scale: f32| random(state) * scale;
        LightShape {
            width: 0.02 + number(1.0),
            height: 0.02 + number(1.0),
            width_edge: 0.01 + number(0.6),
            height_edge: 0.01 + number(0.6),
            round: if number(1.0) < 0.3 { 0.0 } else { number(1.0) },
        }
    }

    fn largest_error(map: BarnMap, shape: &LightShape, state: &mut u32) -> f32 {
        let mut largest = 0.0f32;
        for _ in 0..200 {
            let at = shape.outer() * Vec2::new(random(state), random(state)) * 1.1;
            let point = (at.extend(1.0)) * 3.0;
            largest = largest.max((map.sample(shape, point) - shape.factor(point)).abs());
        }
        largest
    }

    #[test]
    fn the_map_errs_by_at_most_its_stated_error() {
        let (mut state, mut held, mut worst) = (1, 0, 0.0f32);
        for _ in 0..4000 {
            let shape = random_shape(&mut state);
            let map = BarnMap {
                resolution: 160 + (random(&mut state) * 400.0) as u32,
            };
            if map.holds(&shape) {
                held += 1;
                worst = worst.max(largest_error(map, &shape, &mut state));
            }
        }
        assert!(held > 300, "{held} shapes");
        assert!(worst <= BarnMap::ERROR, "{worst}");
    }

    #[test]
    fn what_the_map_does_not_hold_errs_more() {
        let mut state = 7;
        let sharp = LightShape {
            width: 0.4,
            height: 0.3,
            width_edge: 0.002,
            height_edge: 0.002,
            round: 0.3,
        };
        let map = BarnMap::default();
        assert!(!map.holds(&sharp));
        assert!((0..20).any(|_| largest_error(map, &sharp, &mut state) > 2.0 * BarnMap::ERROR));
    }

    #[test]
    fn limits_are_finite_and_openings_without_bounds_fit() {
        let strip = LightShape {
            height: 0.3,
            height_edge: 0.2,
            ..LightShape::default()
        };
        let map = BarnMap::default();
        assert!(map.holds(&strip));
        for y in [0.0, 0.1, 0.37, 0.49, 0.7] {
            let point = Vec3::new(5.0, y, 1.0);
            let error = (map.sample(&strip, point) - strip.factor(point)).abs();
            assert!(error <= BarnMap::ERROR, "{y}: {error}");
        }
        let closed = LightShape {
            width: 0.0,
            height: 0.0,
            width_edge: 0.5,
            height_edge: 0.5,
            round: 1.0,
        };
        assert!(map.holds(&closed), "a light that fades from its middle on");
        for shape in [
            LightShape {
                width_edge: 0.0,
                ..closed
            },
            LightShape {
                width: 0.001,
                height: 0.001,
                ..closed
            },
        ] {
            assert!(!map.holds(&shape), "{shape:?}");
        }
        for resolution in [0, 1, 2] {
            let tiny = BarnMap { resolution };
            assert!(!tiny.holds(&closed));
            assert!((0.0..=1.0).contains(&tiny.sample(&closed, Vec3::new(0.1, 0.2, 1.0))));
        }
        assert!(!BarnMap { resolution: 0 }.is_valid() && !BarnMap { resolution: 4096 }.is_valid());
    }
}
