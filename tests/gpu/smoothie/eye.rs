//! A light at the eye: casters hide their own shadows, and their smoothies are rims around them.

use antumbra::prelude::*;
use antumbra::techniques::SmoothieWidth;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec2, Vec3};

use super::scenes::{SPOT, empty, hits, rendered, smoothie, spawn};
use crate::harness::strict_context;

/// Distances of the plate's front and of the wall from the eye, metres.
const PLATE: f32 = 2.0;
const WALL: f32 = 4.0;

/// Half the side of the plate, and the width of its smoothies, metres.
const HALF: f32 = 0.3;
const WIDTH: f32 = 0.25;

/// Turn of the plate about the line of sight, radians.
const TURN: f32 = 0.4;

/// Visibility of the wall by the source's formula. Alpha grows with the distance from the plate's outline, as the light and
/// the eye see it.
fn expected(on_wall: Vec2, width: f32) -> f32 {
    let beside = Vec2::from_angle(-TURN).rotate(on_wall * (PLATE / WALL)).abs() - HALF;
    let alpha = beside.max(Vec2::ZERO).length() / width;
    (alpha / (1.0 - PLATE / WALL)).min(1.0)
}

#[test]
fn smoothies_of_a_light_at_the_eye_are_rims_around_their_casters() {
    let eye = Vec3::new(0.3, 1.2, 5.0);
    for kind in [SPOT, LightKind::Point] {
        let place = Transform::from_translation(eye);
        let mut stage = empty(&strict_context(), place);
        let wall = Transform::from_translation(eye - Vec3::Z * WALL)
            .with_rotation(Quat::from_rotation_x(std::f32::consts::FRAC_PI_2));
        spawn(&mut stage, MeshData::plane(6.0), wall);
        let thickness = 0.01;
        let plate = Transform::from_translation(eye - Vec3::Z * (PLATE + thickness))
            .with_rotation(Quat::from_rotation_z(TURN));
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(HALF, HALF, thickness)),
            plate,
        );
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 10.0, 20.0)
        };
        stage.spawn_light(light, place, Some(smoothie(SmoothieWidth::Metres(WIDTH))));
        let values = rendered(&mut stage);
        let (mut soft, mut wrong, mut wrong_of_wide, mut dark) = (0, 0, 0, 0);
        for (hit, &value) in hits(&stage).hits.iter().zip(&values) {
            let Some(hit) = hit else { continue };
            let from_eye = hit.position.as_vec3() - eye;
            let is_wall = from_eye.z < -WALL + 0.01;
            let should = if is_wall {
                expected(from_eye.truncate(), WIDTH)
            } else {
                1.0
            };
            dark += usize::from(value < 0.05 && should > 0.1);
            wrong += usize::from((value - should).abs() > 0.12);
            soft += usize::from((0.1..0.9).contains(&should));
            let wide = if is_wall {
                expected(from_eye.truncate(), 2.0 * WIDTH)
            } else {
                1.0
            };
            wrong_of_wide += usize::from((value - wide).abs() > 0.12);
        }
        println!(
            "{kind:?}: {soft} soft, {wrong} wrong, {dark} dark, {wrong_of_wide} wrong for twice the width"
        );
        assert!(
            soft > 150 && wrong <= 3 && dark == 0,
            "{kind:?}: {soft} soft, {wrong} wrong, {dark} dark"
        );
        assert!(wrong_of_wide > 150, "{kind:?}: {wrong_of_wide}");
    }
}
