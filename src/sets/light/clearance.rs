//! How near to a light a surface must be so as not to block it.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectResource;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use glam::DVec3;

use crate::conventions::LIGHT_CLEARANCE;
use crate::geometry::Aabb;

/// The surroundings of a light in an ordinary scene, metres: a room.
const ROOM: f64 = 8.0;

/// The largest surroundings of a light, metres. Surfaces of a larger scene are placed no less exactly.
const LARGEST: f64 = 128.0;

/// Precision of coordinates, as a share of the largest. A surface is not placed more exactly than that.
const ROUNDING: f64 = 4e-7;

/// Distance from a light within which surfaces do not block it, as a share of the size of the light's
/// [`Surroundings`]. It is the same for all casters and under every technique.
///
/// Higher values let light pass surfaces on which the light was placed less exactly, and finally surfaces that should
/// block it. With lower values, rounding decides on which side of a surface a light is. The range is 0 to 0.01, the default
/// 4 · 10⁻⁵: a third of a millimetre in a room. It costs a test of each triangle of the casters on or in which the light
/// stands.
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

    /// The clearance of a light at a position, metres. It is at least the precision of the position's coordinates.
    pub fn metres(self, surroundings: &Surroundings) -> f64 {
        let rounding = ROUNDING * surroundings.position.abs().max_element();
        (self.share() * surroundings.size()).max(rounding)
    }
}

/// The size of the scene around a light, as far as it says how exactly surfaces are placed there.
///
/// The size is that of a room, 8 m. It is smaller where the light's range, or everything that the light reaches, is
/// smaller: a scene of a centimetre has a clearance of less than a micrometre. It is larger where no caster lies within
/// 8 m of the light as a whole, as in a scene whose unit is a centimetre: the distance within which the first caster
/// does, at most 128 m. A ground or a sky of kilometres therefore says nothing about a room that stands in it. Distances
/// count as rounded up to a power of two, so that what moves changes the clearance rarely.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    position: DVec3,
    range: f64,
    /// Distance to the farthest point of all objects, metres.
    farthest: f64,
    /// Least distance within which a caster lies as a whole, metres.
    whole_caster: f64,
}

impl Surroundings {
    /// Empty surroundings of a light. `range` is the distance up to which it reaches, metres, and may be infinite.
    pub fn new(position: DVec3, range: f64) -> Self {
        Self {
            position,
            range,
            farthest: 0.0,
            whole_caster: f64::INFINITY,
        }
    }

    /// Adds an object by its bounds in world space. Returns whether further objects can no longer change the size.
    pub fn add(&mut self, bounds_world: &Aabb, casts: bool) -> bool {
        if !bounds_world.is_empty() {
            let center = bounds_world.center().as_dvec3();
            let half = bounds_world.half_size().as_dvec3();
            let farthest = ((center - self.position).abs() + half).length();
            self.farthest = self.farthest.max(farthest);
            if casts {
                self.whole_caster = self.whole_caster.min(farthest);
            }
        }
        let most = self.range.min(ROOM);
        self.farthest >= most && (self.whole_caster <= ROOM || self.range <= ROOM)
    }

    /// The size of the surroundings, metres.
    pub fn size(&self) -> f64 {
        let rounded = |distance: f64| distance.log2().ceil().exp2();
        let around = rounded(self.whole_caster).clamp(ROOM, LARGEST);
        around.min(rounded(self.farthest)).min(self.range)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn clearance(range: f64, boxes: &[(f32, f32)]) -> f64 {
        let mut around = Surroundings::new(DVec3::new(0.1, 0.0, 0.0), range);
        for &(at, half) in boxes {
            let bounds = Aabb {
                min: Vec3::new(at - half, -half, -half),
                max: Vec3::new(at + half, half, half),
            };
            around.add(&bounds, true);
        }
        LightClearance::default().metres(&around)
    }

    /// Ten micrometres behind a surface of 0.3 to 10 m the light is free; a millimetre behind it, in a room, it is not.
    #[test]
    fn lights_ten_micrometres_behind_surfaces_of_ordinary_size_are_free() {
        for half in [0.15, 0.5, 1.5, 5.0] {
            assert!(clearance(f64::INFINITY, &[(0.0, half)]) > 1.5e-5, "{half}");
            assert!(
                clearance(f64::INFINITY, &[(0.0, half), (2.0, 0.3)]) < 5e-4,
                "{half}"
            );
        }
        assert!(clearance(f64::INFINITY, &[(0.0, 0.005), (0.01, 0.02)]) < 1e-5);
    }

    /// Distant objects do not widen the clearance of a room. It never reaches a centimetre.
    #[test]
    fn the_far_does_not_widen_the_clearance() {
        let room = clearance(f64::INFINITY, &[(0.0, 3.0)]);
        assert!(room > 1e-4 && room < 5e-4, "{room}");
        for far in [100.0, 3e3, 3e5] {
            assert_eq!(clearance(f64::INFINITY, &[(0.0, far), (1.0, 0.5)]), room);
            assert_eq!(clearance(1e6, &[(0.0, far), (1.0, 0.5)]), room);
        }
        let alone = clearance(f64::INFINITY, &[(0.0, 3e5)]);
        assert!(alone > 2e-3 && alone < 0.01, "{alone}");
        // A room modelled in centimetres.
        let scaled = clearance(f64::INFINITY, &[(0.0, 300.0), (50.0, 50.0)]);
        assert!(scaled > 1e-3 && scaled < 0.01, "{scaled}");
        assert!(clearance(0.1, &[(0.0, 3.0)]) < 5e-6);
    }

    /// Once [`Surroundings::add`] returns true, more objects do not change the size.
    #[test]
    fn further_objects_do_not_change_what_is_known() {
        let objects = [
            (900.0, 5.0, true),
            (40.0, 20.0, false),
            (30.0, 20.0, true),
            (0.2, 0.1, true),
            (2.0, 3.0, true),
            (0.0, 1e4, true),
        ];
        for range in [0.5, 8.0, 30.0, f64::INFINITY] {
            let mut around = Surroundings::new(DVec3::ZERO, range);
            let mut known = None;
            for (at, half, casts) in objects {
                let bounds = Aabb {
                    min: Vec3::splat(at - half),
                    max: Vec3::splat(at + half),
                };
                let is_known = around.add(&bounds, casts);
                assert!(known.is_none_or(|size| size == around.size()), "{range}");
                if is_known {
                    known = Some(around.size());
                }
            }
            assert!(known.is_some(), "{range}");
        }
    }
}
