//! Which way the pictures of a sphere look: one picture towards its casters, or six all around.

use glam::DVec3;

use super::scene_box::SceneBox;
use super::sliced_light::SlicedLight;

/// The directions of six pictures around a sphere.
pub(super) const CUBE: [DVec3; 6] = [
    DVec3::NEG_Y,
    DVec3::Y,
    DVec3::X,
    DVec3::NEG_X,
    DVec3::Z,
    DVec3::NEG_Z,
];

/// Largest tangent of the directions to casters in one picture.
const WIDEST: f64 = 4.0;

/// Largest cost of one picture. Measured on 54 random scenes: from 4 on six pictures err less than one, and less than half as
/// much in most.
const MOST: f64 = 4.0;

/// Cost of casters that all lie in one plane, seen straight on.
const FLAT: f64 = 0.1;

/// Returns the direction of the one picture that shows all casters of a sphere; `None` if six pictures are better, as they are
/// for casters all around the light.
///
/// Slices that stand upright cut low casters edge-on, and kernels pass between their strips. So the direction is not merely one
/// in which everything is before the light, but the best of 98 that are spread evenly: towards sides, edges and corners of a
/// cube, and between them. They are few enough that slices stay where they are while casters move a little.
///
/// O(directions × casters); most directions are dropped at one of the first casters.
pub(super) fn axis_of_one(light: &SlicedLight, scene: &[SceneBox]) -> Option<DVec3> {
    let (mut best, mut least) = (None, MOST);
    for axis in CUBE.into_iter().chain(between_cube()) {
        if let Some(cost) = cost_along(axis, light, scene, least) {
            (best, least) = (Some(axis), cost);
        }
    }
    best
}

/// Directions with whole coordinates up to 2 that are not those of [`CUBE`].
fn between_cube() -> impl Iterator<Item = DVec3> {
    let steps = || (-2..=2).map(f64::from);
    let all = steps().flat_map(move |x| steps().flat_map(move |y| steps().map(move |z| DVec3::new(x, y, z))));
    let is_new = |place: &DVec3| {
        let doubles_another = (*place * 0.5).fract() == DVec3::ZERO;
        place.length_squared() > 1.0 && !doubles_another
    };
    all.filter(is_new).map(DVec3::normalize)
}

/// Returns the cost of a picture along an axis: how thick its slices are compared with their distance, times the squared secant
/// of the widest angle to a caster. Errors of rendered pictures follow it. `None` if it is not less than `most`, or not all
/// casters are before the light.
fn cost_along(axis: DVec3, light: &SlicedLight, scene: &[SceneBox], most: f64) -> Option<f64> {
    let radius = light.half.max_element();
    let (right, up) = axis.any_orthonormal_pair();
    let (mut top, mut bottom, mut widest) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
    let mut cost = FLAT; // without casters
    for caster in scene.iter().filter(|scene| scene.casts) {
        let [near, far] = caster.range(axis, light.origin);
        if near <= radius {
            return None;
        }
        let sides = [right, up].map(|side| caster.range(side, light.origin));
        let beside = sides
            .as_flattened()
            .iter()
            .fold(0.0_f64, |most, side| most.max(side.abs()));
        // Near casters may be a little wider.
        widest = widest.max(beside / far).max(beside / (2.0 * near));
        (top, bottom) = (top.min(near), bottom.max(far));
        cost = ((bottom - top) / top + FLAT) * (1.0 + widest * widest);
        if !(widest <= WIDEST && cost < most) {
            return None;
        }
    }
    (cost < most).then_some(cost)
}

#[cfg(test)]
mod tests {
    use super::super::sliced_light::SlicedKind;
    use super::*;
    use crate::geometry::Aabb;
    use glam::{DVec2, Vec3};

    fn axis(casters: &[(Vec3, Vec3)]) -> Option<DVec3> {
        let light = SlicedLight {
            origin: DVec3::ZERO,
            axes: DVec3::AXES,
            half: DVec2::splat(0.15),
            kind: SlicedKind::Sphere,
        };
        let boxes = casters
            .iter()
            .map(|(at, half)| SceneBox::of_bounds(Aabb::around(*at, *half), true));
        axis_of_one(&light, &boxes.collect::<Vec<_>>())
    }

    #[test]
    fn pictures_look_down_on_low_casters_that_stand_beside_the_light() {
        let plate = |x: f32, z: f32| (Vec3::new(x, -1.2, z), Vec3::new(0.5, 0.1, 0.5));
        let post = |x: f32, z: f32| (Vec3::new(x, -1.1, z), Vec3::new(0.1, 0.4, 0.1));
        // A hanging lamp over its casters looks down.
        assert_eq!(
            axis(&[plate(0.0, 0.0), plate(0.9, 0.0), plate(-0.9, 0.3)]),
            Some(DVec3::NEG_Y)
        );
        // Beside them, along the slope to them.
        let slope = axis(&[plate(1.5, 0.0), post(2.2, 0.4), post(1.8, -0.6)]).expect("one picture");
        assert!(slope.x > 0.5 && slope.y < -0.3 && slope.z.abs() < 0.4, "{slope}");
        // Plates in one plane are seen straight on, although they are beside the light.
        assert_eq!(
            axis(&[(Vec3::new(1.5, -1.0, 0.5), Vec3::new(0.5, 0.005, 0.5))]),
            Some(DVec3::NEG_Y)
        );
        assert_eq!(
            axis(&[plate(1.5, 0.0), plate(-1.5, 0.0), post(0.3, 1.0), post(0.0, -1.0)]),
            None
        );
        let ceiling = (Vec3::Y, Vec3::new(2.0, 0.1, 2.0));
        assert_eq!(axis(&[plate(1.5, 0.0), ceiling]), None, "casters above and below");
        assert_eq!(axis(&[]), Some(DVec3::NEG_Y), "no casters");
    }

    #[test]
    fn directions_are_98_unit_vectors() {
        let all: Vec<DVec3> = CUBE.into_iter().chain(between_cube()).collect();
        assert_eq!(all.len(), 98);
        let is_alone = |at: usize| all[..at].iter().all(|other| other.distance(all[at]) > 0.2);
        assert!((0..98).all(|at| all[at].is_normalized() && is_alone(at)));
    }
}
