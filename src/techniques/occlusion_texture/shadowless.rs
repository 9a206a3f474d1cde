//! Casters that cannot shadow anything, such as a flat ground. Slices are not spent on them.

use glam::{DVec3, Vec3};

use super::scene_box::SceneBox;
use crate::geometry::{Aabb, Emitter};

/// How thick a ground that shadows nothing may be, how deep any object may be sunk into it, and how far it may fall short of
/// everything lit on each side, as a share of the extent of everything lit. It is less than a slice, within which nothing is shadowed either.
const SUNK: f64 = 0.05;

/// Objects that are narrower than this share of the ground, both ways, may be sunk into it by half of their own height: posts,
/// trees and rocks. A floor that runs on behind a wall is as wide as the wall.
const NARROW: f64 = 0.5;

/// Rounding of two padded boxes, as a share of their largest coordinate.
const ROUNDING: f64 = 4.0 * Aabb::PAD as f64;

/// Coordinates beyond which those along an axis alone count towards its rounding, metres. Rounding beside the axis would be as
/// high as a house on a ground of many kilometres.
const NEAR: f32 = 1e3;

/// Sides of a caster whose direction along an axis is less than this count as beside the axis: those within 45° of it do not.
const BESIDE: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Everything that a light shines on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lit<'a> {
    /// The objects that the light reaches.
    pub scene: &'a [SceneBox],
    /// Box around all of them.
    pub all: Aabb,
    /// Place and extent of the light.
    pub emitter: &'a Emitter,
    /// Sine of half the angle of a directional light.
    pub sun: f64,
}

/// Least and greatest coordinate of a box along a world axis, or against it.
fn span(bounds: &Aabb, axis: usize, is_negative: bool) -> [f64; 2] {
    let [least, greatest] = [bounds.min[axis], bounds.max[axis]].map(f64::from);
    if is_negative {
        [-greatest, -least]
    } else {
        [least, greatest]
    }
}

impl Lit<'_> {
    /// Whether an object of the scene shadows nothing, because the light and everything lit lie on one side of it.
    ///
    /// A few objects may be sunk into a wide ground: one that reaches below everything lit.
    pub fn is_shadowless(&self, caster: usize) -> bool {
        let own = &self.scene[caster].bounds;
        let sides = (0..3).flat_map(|axis| [(axis, false), (axis, true)]);
        sides.into_iter().any(|(axis, is_negative)| {
            let [bottom, top] = span(own, axis, is_negative);
            let [lowest, highest] = span(&self.all, axis, is_negative);
            let slack = SUNK * (highest - lowest);
            let rounding = self.rounding_along(axis);
            if lowest >= top - rounding {
                return self.shines_from_above(axis, is_negative, top + rounding);
            }
            bottom >= top - slack
                && self.shines_from_above(axis, is_negative, top + slack)
                && self.is_ground(caster, axis)
                && self.is_nothing_behind(caster, (axis, is_negative), (top, slack), rounding)
        })
    }

    /// Rounding of all coordinates, metres.
    pub fn rounding(&self) -> f64 {
        ROUNDING * f64::from(self.largest().max_element())
    }

    /// Rounding of coordinates along a world axis, metres.
    fn rounding_along(&self, axis: usize) -> f64 {
        let largest = self.largest();
        ROUNDING * f64::from(largest.max_element().min(NEAR).max(largest[axis]))
    }

    fn largest(&self) -> Vec3 {
        self.all.min.abs().max(self.all.max.abs())
    }

    /// Returns the box around everything lit but one caster, if that caster's box is around it.
    pub fn all_but_shell(&self, caster: usize) -> Option<Aabb> {
        let own = &self.scene[caster].bounds;
        if !(own.min.cmple(self.all.min).all() && own.max.cmpge(self.all.max).all()) {
            return None;
        }
        let others = self
            .scene
            .iter()
            .enumerate()
            .filter(|(index, _)| *index != caster);
        Some(others.fold(Aabb::EMPTY, |all, (_, other)| all.union(other.bounds)))
    }

    /// Whether the whole light lies beyond a height along a world axis, or against it.
    fn shines_from_above(&self, axis: usize, is_negative: bool, height: f64) -> bool {
        let mut outward = DVec3::AXES[axis];
        if is_negative {
            outward = -outward;
        }
        let point = self.emitter.point;
        let light = outward.dot(point.truncate());
        if point.w == 0.0 {
            light > self.sun
        } else {
            light - self.emitter.extent(outward) > height
        }
    }

    /// Whether an object reaches under everything lit, but for a small share on each side.
    fn is_ground(&self, caster: usize, axis: usize) -> bool {
        let own = &self.scene[caster].bounds;
        (0..3).filter(|beside| *beside != axis).all(|beside| {
            let [own_least, own_greatest] = span(own, beside, false);
            let [least, greatest] = span(&self.all, beside, false);
            let slack = SUNK * (greatest - least);
            own_least <= least + slack && own_greatest >= greatest - slack
        })
    }

    /// Whether all other objects stand above a height, or are sunk into the caster that ends there: by the slack at most, or
    /// by half of their height if they are narrow.
    fn is_nothing_behind(
        &self,
        caster: usize,
        (axis, is_negative): (usize, bool),
        (top, slack): (f64, f64),
        rounding: f64,
    ) -> bool {
        self.scene.iter().enumerate().all(|(index, other)| {
            let [low, high] = span(&other.bounds, axis, is_negative);
            let is_held = |share: f64| self.holds_beside(caster, other, axis, (share, rounding));
            let is_sunk = || {
                let (above, below) = (high - top, top - low);
                let is_shallow = above > rounding && below <= slack && is_held(1.0);
                is_shallow || (below <= above && is_held(NARROW))
            };
            index == caster || low >= top - rounding || is_sunk()
        })
    }

    /// Whether another object lies within a caster across a world axis, and is at most this share as wide.
    fn holds_beside(
        &self,
        caster: usize,
        other: &SceneBox,
        axis: usize,
        (share, rounding): (f64, f64),
    ) -> bool {
        let caster = &self.scene[caster];
        let halves = caster.own.map_or(DVec3::AXES, |own| own.halves);
        let directions = halves.map(DVec3::normalize_or_zero);
        let lies_beside = |along: &DVec3| *along != DVec3::ZERO && along[axis].abs() < BESIDE;
        directions.into_iter().filter(lies_beside).all(|beside| {
            let [least, greatest] = other.range(beside, DVec3::ZERO);
            let [own_least, own_greatest] = caster.range(beside, DVec3::ZERO);
            let is_within = own_least <= least + rounding && greatest <= own_greatest + rounding;
            is_within && greatest - least <= share * (own_greatest - own_least) + rounding
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::scene_box::OwnBox;
    use super::*;
    use glam::{Affine3A, Quat};

    fn scene_box(center: Vec3, half: Vec3) -> SceneBox {
        SceneBox::of_bounds(Aabb::around(center, half), true)
    }

    fn lamp(at: DVec3) -> Emitter {
        Emitter {
            radius: 0.5,
            ..Emitter::point(at.extend(1.0))
        }
    }

    /// Whether each object is shadowless.
    fn shadowless(scene: &[SceneBox], emitter: &Emitter) -> Vec<bool> {
        let all = scene.iter().fold(Aabb::EMPTY, |all, one| all.union(one.bounds));
        let lit = Lit {
            scene,
            all,
            emitter,
            sun: 0.1,
        };
        (0..scene.len()).map(|caster| lit.is_shadowless(caster)).collect()
    }

    fn ground() -> SceneBox {
        scene_box(Vec3::ZERO, Vec3::new(10.0, 0.0, 10.0))
    }

    #[test]
    fn grounds_shadow_nothing_and_what_stands_on_them_does() {
        let cube = scene_box(Vec3::Y, Vec3::ONE);
        let sun = |y: f64| Emitter::point(DVec3::new(0.6, y, 0.0).normalize().extend(0.0));
        for high in [lamp(DVec3::new(3.0, 4.0, 0.0)), sun(1.0)] {
            assert_eq!(shadowless(&[ground(), cube], &high), [true, false]);
            let cellar = scene_box(Vec3::NEG_Y, Vec3::ONE);
            assert_eq!(shadowless(&[ground(), cube, cellar], &high), [false; 3]);
        }
        // Some of the light is below the ground.
        for low in [lamp(DVec3::new(3.0, 0.4, 0.0)), sun(0.05)] {
            assert_eq!(shadowless(&[ground(), cube], &low), [false; 2]);
        }
        let wall = scene_box(Vec3::new(-10.0, 5.0, 0.0), Vec3::new(0.0, 5.0, 10.0));
        let inside = lamp(DVec3::new(3.0, 4.0, 0.0));
        assert_eq!(shadowless(&[ground(), cube, wall], &inside), [true, false, true]);
    }

    /// Casters that lie near an end of everything lit shadow what lies beyond them.
    #[test]
    fn casters_near_an_end_of_the_scene_cast() {
        let light = lamp(DVec3::new(0.0, 120.0, 0.0));
        let at_edge = scene_box(Vec3::new(-9.8, 0.1, 0.0), Vec3::splat(0.1));
        let low = lamp(DVec3::new(0.3, 3.0, 0.2));
        assert_eq!(shadowless(&[at_edge, ground()], &low), [false, true]);
        let tower = scene_box(Vec3::new(5.0, 50.0, 0.0), Vec3::new(2.0, 50.0, 2.0));
        let car = scene_box(Vec3::new(-3.0, 0.7, 0.0), Vec3::new(2.0, 0.7, 1.0));
        assert_eq!(shadowless(&[ground(), tower, car], &light), [true, false, false]);
        let shelf = scene_box(Vec3::Y, Vec3::new(10.0, 0.1, 10.0));
        assert_eq!(
            shadowless(&[ground(), tower, shelf], &light),
            [true, false, false]
        );
        // A slab over a cellar, and over a column that reaches down into it beside the slab.
        let slab = scene_box(Vec3::new(0.0, -0.5, 0.0), Vec3::new(10.0, 0.5, 10.0));
        let cellar = scene_box(Vec3::new(0.0, -2.0, 0.0), Vec3::new(9.0, 1.0, 9.0));
        assert_eq!(shadowless(&[slab, tower], &light), [true, false]);
        assert_eq!(shadowless(&[slab, tower, cellar], &light), [false, false, true]);
        let column = scene_box(Vec3::new(10.2, 1.0, 0.0), Vec3::new(0.3, 2.0, 0.3));
        assert_eq!(shadowless(&[slab, tower, column], &light), [false; 3]);
    }

    /// A thick ground holds what is sunk into it, also where it is turned about the vertical.
    #[test]
    fn objects_may_be_sunk_into_a_ground() {
        let light = lamp(DVec3::new(0.0, 120.0, 0.0));
        let half = Vec3::new(10.0, 0.5, 10.0);
        let turned = Affine3A::from_rotation_translation(Quat::from_rotation_y(0.7), Vec3::NEG_Y * 0.5);
        let local = Aabb::around(Vec3::ZERO, half);
        let slab = SceneBox {
            own: OwnBox::new(&local, &turned),
            ..SceneBox::of_bounds(local.transformed(&turned), true)
        };
        let tower = |x: f32, z: f32| scene_box(Vec3::new(x, 49.8, z), Vec3::new(1.0, 50.0, 1.0));
        assert_eq!(shadowless(&[slab, tower(1.0, 2.0)], &light), [true, false]);
        // A thick object shadows itself, so it is no ground.
        let boulder = scene_box(Vec3::ZERO, Vec3::ONE);
        assert_eq!(shadowless(&[boulder], &light), [false]);
        // A post may be sunk by half of its height, wherever nothing lies below the ground.
        let post = |down: f32| scene_box(Vec3::new(3.0, 1.0 - down, 0.0), Vec3::new(0.1, 1.0, 0.1));
        assert_eq!(shadowless(&[ground(), post(0.9)], &light), [true, false]);
        assert_eq!(shadowless(&[ground(), post(1.1)], &light), [false; 2]);
        let below = scene_box(Vec3::new(-5.0, -2.0, 0.0), Vec3::splat(0.5));
        assert_eq!(shadowless(&[ground(), post(0.9), below], &light), [false; 3]);
        // A wall shadows the part of the floor behind it.
        let wall = scene_box(Vec3::new(-3.0, 5.0, 0.0), Vec3::new(0.0, 5.0, 10.0));
        let inside = lamp(DVec3::new(3.0, 4.0, 0.0));
        assert_eq!(shadowless(&[ground(), wall], &inside), [true, false]);
        // The world bounds of the slab reach to ±14, but there is no ground at their corners.
        assert_eq!(shadowless(&[slab, tower(12.0, 12.0)], &light), [false; 2]);
    }
}
