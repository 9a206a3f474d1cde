//! How near to a light a surface must be so as not to block it.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectResource;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::DVec4;

use crate::conventions::LIGHT_CLEARANCE;
use crate::geometry::Aabb;

/// Largest distance, metres, of which the clearance is a share. Farther parts of a caster, such as a sky or the rim of a
/// ground without end, say nothing about how exactly its nearer parts are placed.
pub const CLEARANCE_REACH: f64 = 1e3;

/// Distance from a light within which surfaces do not block it. It is a share of the light's range, of the distance to
/// the caster's farthest point or of 1000 m, whichever is least. Maps hold many casters, so for them it is the largest
/// clearance of the casters whose bounds the light touches, up to two times less because they take steps. In a
/// perspective map it is the mean of a distance that varies over the picture.
///
/// Higher values let light pass surfaces on which the light was placed less exactly, and finally surfaces that should
/// block it. Lower values leave it to rounding on which side of a surface a light is. The range is 0 to 0.01, the default
/// 10⁻⁵: a fifth of a millimetre for a range of 20 metres. It costs a test of each triangle of the casters on or in which
/// the light stands.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Resource, Default, Debug, Clone, PartialEq)
)]
pub struct LightClearance(pub f32);

impl Default for LightClearance {
    fn default() -> Self {
        Self(LIGHT_CLEARANCE)
    }
}

impl LightClearance {
    /// The share, within its bounds; the default for NaN.
    pub fn share(self) -> f64 {
        if self.0.is_nan() {
            f64::from(LIGHT_CLEARANCE)
        } else {
            f64::from(self.0.clamp(0.0, 0.01))
        }
    }

    /// The clearance of a light in metres, for a caster with these bounds; 0 for a directional light.
    pub fn metres(self, light_world: DVec4, range: f32, bounds_world: &Aabb) -> f64 {
        if light_world.w == 0.0 || bounds_world.is_empty() {
            return 0.0;
        }
        let center = bounds_world.center().as_dvec3();
        let half = bounds_world.half_size().as_dvec3();
        let farthest = ((center - light_world.truncate()).abs() + half).length();
        self.share() * farthest.min(f64::from(range)).min(CLEARANCE_REACH)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn far_parts_of_a_caster_do_not_widen_the_clearance() {
        let clearance = |half: f32| {
            let bounds = Aabb {
                min: Vec3::new(-half, 0.0, -half),
                max: Vec3::new(half, 0.0, half),
            };
            LightClearance::default().metres(DVec4::new(1.0, 4.0, 1.5, 1.0), f32::INFINITY, &bounds)
        };
        assert!(clearance(3.0) < 1e-4 && clearance(3.0) > 3e-5);
        assert!((clearance(300_000.0) - 0.01).abs() < 1e-6);
    }
}
