//! Distance shaping: the depths between which a light shines.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::Vec3;

/// The depths between which a light shines, whatever its falloff. It fades to nothing before the nearest and
/// beyond the farthest depth.
///
/// Under barn doors ([`LightShape`](super::LightShape)) depth is measured along the axis on which the light
/// shines; without them it is the distance from the light's centre. Directional lights ignore it, because they
/// are nowhere. Default: no limits.
///
/// Costs: one pass over the light's pixels, which the light's shape shares. What lies beyond `far` and its edge
/// costs nothing.
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
pub struct LightDistance {
    /// Depth from which the light has its full intensity, metres; at most `far`. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub near: f32,
    /// Depth up to which the light has its full intensity, metres. Infinity sets no limit. Default: infinity.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub far: f32,
    /// Length of the edge before `near` across which the light fades in, metres; at least 0. At 0 the edge is
    /// sharp. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub near_edge: f32,
    /// Length of the edge beyond `far` across which the light fades out, metres; at least 0. At 0 the edge is
    /// sharp. Default: 0.
    #[cfg_attr(feature = "schema", schemars(range(min = 0)))]
    pub far_edge: f32,
}

impl Default for LightDistance {
    fn default() -> Self {
        Self {
            near: 0.0,
            far: f32::INFINITY,
            near_edge: 0.0,
            far_edge: 0.0,
        }
    }
}

/// Depths from this value on count as infinite, metres.
pub const FARTHEST: f32 = 1e15;

/// The shortest edge, metres. Shorter edges, and those of length 0, count as this long.
pub const SHORTEST_EDGE: f32 = 1e-6;

impl LightDistance {
    /// Returns whether the distances bound nothing.
    pub fn is_unbounded(&self) -> bool {
        self.near <= 0.0 && self.far >= FARTHEST
    }

    /// Returns the depth beyond which nothing is lit, metres; it may be infinite.
    pub fn reach(&self) -> f32 {
        let reach = self.far + self.far_edge.max(SHORTEST_EDGE);
        if reach >= FARTHEST { f32::INFINITY } else { reach }
    }

    /// Returns the numbers of the formula: the depth at which the light begins to fade in and the inverse length of
    /// that edge, then the depth at which it begins to fade out and the inverse length of that edge.
    pub fn edges(&self) -> [f32; 4] {
        let [near_edge, far_edge] =
            [self.near_edge, self.far_edge].map(|edge| edge.clamp(SHORTEST_EDGE, FARTHEST));
        // A light without a nearest depth has no edge there: its centre is lit too.
        let start = if self.near <= 0.0 {
            -FARTHEST
        } else {
            self.near - near_edge
        };
        [start, near_edge.recip(), self.far.min(FARTHEST), far_edge.recip()]
    }

    /// The share of the light that arrives at a depth, 0 to 1.
    ///
    /// Source: Pellacini & Vidimce 2004, GPU Gems ch. 10, listing 10-2, `computeDistanceShaping`.
    pub fn factor(&self, depth: f32) -> f32 {
        let [start, inverse_near, far, inverse_far] = self.edges();
        let smooth = |t: f32| {
            let t = t.clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        };
        smooth((depth - start) * inverse_near) * (1.0 - smooth((depth - far) * inverse_far))
    }

    /// The depth of a point in light space (x and y across, z in front of the light), as this shaping measures it:
    /// along the axis for a light with barn doors, and as a distance without. The listing's `length(Plight.z)`
    /// means the length of the vector.
    pub fn depth_of(point: Vec3, has_barn_doors: bool) -> f32 {
        if has_barn_doors { point.z } else { point.length() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_1_between_its_ends_and_0_beyond_their_edges() {
        let distance = LightDistance {
            near: 1.0,
            far: 6.0,
            near_edge: 0.5,
            far_edge: 2.0,
        };
        let at = |depth| distance.factor(depth);
        assert_eq!([at(0.0), at(0.5), at(8.0), at(1e9)], [0.0; 4]);
        assert_eq!([at(1.0), at(3.0), at(6.0)], [1.0; 3]);
        assert!((at(0.75) - 0.5).abs() < 1e-6 && (at(7.0) - 0.5).abs() < 1e-6);
        assert_eq!(distance.reach(), 8.0);
    }

    #[test]
    fn limits_are_finite_and_as_they_look() {
        let all = LightDistance::default();
        assert_eq!([0.0, 1e-30, 1.0, 1e14].map(|depth| all.factor(depth)), [1.0; 4]);
        assert_eq!(all.reach(), f32::INFINITY);
        let sharp = LightDistance {
            near: 1.0,
            far: 2.0,
            ..all
        };
        assert_eq!(
            [0.999, 1.001, 1.999, 2.001].map(|depth| sharp.factor(depth)),
            [0.0, 1.0, 1.0, 0.0]
        );
    }
}
