//! Lamps on and near casters that are flattened, and lit faces of such casters.

use antumbra::prelude::*;
use antumbra::scene::FaceCulling;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{EulerRot, Quat, Vec3};

use super::placements::Random;
use super::scenes::{HARD, dark, draw, error_of, ground, lamp, object, set_technique, stage};
use crate::harness::support::stage::Stage;

const MAPS: [&str; 3] = ["map", "perspective", "smoothie"];

/// A unit cube without height, `width` metres wide.
fn flat_cube(width: f32) -> (MeshData, Transform) {
    let scale = Vec3::new(width, 0.0, width);
    (MeshData::cuboid(Vec3::splat(0.5)), Transform::from_scale(scale))
}

/// A floor with a box on it, seen from below the height of a lamp.
fn room() -> Stage {
    let (eye, target) = (Vec3::new(2.2, 1.9, 2.4), Vec3::new(-0.2, 0.2, -0.2));
    let mut room = stage(eye, target, Camera::default());
    room.world
        .spawn(object(MeshData::plane(3.0), Transform::IDENTITY));
    room.world.spawn(object(
        MeshData::cuboid(Vec3::new(0.4, 0.5, 0.3)),
        Transform::from_xyz(-0.8, 0.5, -0.6),
    ));
    room
}

/// Draws the scene with each technique; the first light has the shadows that rays find.
fn assert_as_rays_find(stage: &mut Stage, light: Entity, techniques: &[&str], name: &str) {
    for technique in techniques {
        set_technique(stage, light, technique);
        let rendered = draw(stage);
        let error = error_of(stage, &rendered);
        let most = if HARD.contains(technique) {
            0
        } else {
            error.inner / 200
        };
        assert!(
            error.wrong_inner <= most && error.inner > 4000,
            "{name}, {technique}: {error:?}"
        );
        let darker = rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
        assert!(
            darker > 30,
            "{name}, {technique}: the box casts on {darker} pixels"
        );
    }
}

#[test]
fn a_lamp_flush_with_a_flattened_ceiling_lights_the_room() {
    for width in [6.0, 100.0, 3000.0] {
        for tilt in [0.0, 0.05] {
            let mut stage = room();
            let at = Vec3::new(0.2, 2.5, 0.15);
            let (mesh, flat) = flat_cube(width);
            let turned = Quat::from_euler(EulerRot::XYZ, tilt, 0.4 * tilt, -tilt);
            // So far is the middle of the ceiling from the lamp.
            let middle = at + turned * Vec3::new(-0.2, 0.0, -0.15);
            let ceiling = flat.with_rotation(turned).with_translation(middle);
            stage.world.spawn(object(mesh, ceiling));
            let light = lamp(&mut stage, LightKind::Point, at, 10.0);
            let techniques = [&HARD[..], &MAPS].concat();
            let name = format!("a ceiling of {width} m, tilted by {tilt}");
            assert_as_rays_find(&mut stage, light, &techniques, &name);
        }
    }
}

#[test]
fn a_lamp_low_over_a_flattened_ground_lights_it() {
    for (width, height) in [(400.0, 0.001), (2000.0, 0.005), (2000.0, 0.05)] {
        let mut stage = stage(
            Vec3::new(2.2, 1.9, 2.4),
            Vec3::new(0.0, 0.2, 0.0),
            Camera::default(),
        );
        let (mesh, flat) = flat_cube(width);
        stage.world.spawn(object(mesh, flat));
        stage.world.spawn(object(
            MeshData::cuboid(Vec3::new(0.4, 0.5, 0.3)),
            Transform::from_xyz(-0.8, 0.5, -0.6),
        ));
        let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.5, height, 0.5), 20.0);
        for technique in HARD {
            set_technique(&mut stage, light, technique);
            let rendered = draw(&mut stage);
            // The light grazes the ground, so the judge counts few of its pixels: behind the box it is dark, elsewhere lit.
            let dark = dark(&rendered);
            let all = rendered.visibility[0].len();
            assert!(
                dark > 100 && 3 * dark < all,
                "{width} m, {height} m, {technique}: {dark} of {all}"
            );
            let error = error_of(&mut stage, &rendered);
            assert!(
                200 * error.wrong_inner <= error.inner,
                "{width} m, {height} m, {technique}: {error:?}"
            );
        }
    }
}

/// The two sides of a flat solid have one depth, but other triangles.
#[test]
fn lit_faces_of_flat_objects_are_not_in_their_own_shadow() {
    let mut random = Random::new(11);
    for round in 0..12 {
        let mut stage = ground();
        stage.world.insert_resource(if round % 2 == 0 {
            FaceCulling::SingleSided
        } else {
            FaceCulling::None
        });
        let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.4, 4.0, 0.6), 30.0);
        for mesh in [
            MeshData::cuboid(Vec3::splat(0.5)),
            MeshData::icosphere(0.6, 2),
            MeshData::cuboid(Vec3::splat(0.6)),
        ] {
            let mut within = |from: f32, to: f32| from + (to - from) * random.unit() as f32;
            let turn = Quat::from_euler(
                EulerRot::XYZ,
                within(-0.7, 0.7),
                within(-3.0, 3.0),
                within(-0.7, 0.7),
            );
            let at = Vec3::new(within(-1.8, 1.2), within(0.6, 1.5), within(-1.5, 1.5));
            let scale = Vec3::new(within(0.4, 1.6), 0.0, within(0.4, 1.6));
            let place = Transform::from_translation(at)
                .with_rotation(turn)
                .with_scale(scale);
            stage.world.spawn(object(mesh, place));
        }
        assert_as_rays_find(&mut stage, light, &HARD, &format!("round {round}"));
    }
}
