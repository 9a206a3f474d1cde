//! Transforms that flatten, and skins whose own transform has no volume.

use antumbra::prelude::*;
use antumbra::scene::Skin;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Mat4, Quat, Vec3, Vec4};

use super::scenes::{HARD, dark, draw, error_of, ground, lamp, object, set_technique};

/// Flattened boxes and balls, also turned, mirrored, and below a parent that flattens.
fn spawn_plates(world: &mut World, flat: f32) {
    let turned = Quat::from_rotation_z(0.35);
    let boxed = || MeshData::cuboid(Vec3::splat(0.5));
    world.spawn(object(
        boxed(),
        Transform::from_xyz(-1.6, 1.2, 0.0).with_scale(Vec3::new(1.0, flat, 1.0)),
    ));
    world.spawn(object(
        MeshData::icosphere(0.5, 3),
        Transform::from_xyz(0.0, 0.7, -0.5).with_scale(Vec3::new(1.0, 1.0, -flat)),
    ));
    world.spawn(object(
        boxed(),
        Transform::from_xyz(1.7, 1.0, 0.2)
            .with_rotation(turned)
            .with_scale(Vec3::new(-1.0, flat, 1.0)),
    ));
    let above = Transform::from_xyz(0.3, 1.6, 1.0).with_scale(Vec3::new(1.0, flat, 1.0));
    let parent = world.spawn(above).id();
    let inner = Transform::from_rotation(Quat::from_euler(glam::EulerRot::XYZ, 0.5, 0.3, 0.8));
    let inner = inner.with_scale(Vec3::splat(0.6));
    world.spawn((object(boxed(), inner), ChildOf(parent)));
}

#[test]
fn flattened_objects_are_plates_that_are_drawn_and_cast() {
    let mut stage = ground();
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.4, 4.0, 0.6), 30.0);
    set_technique(&mut stage, light, "stencil");
    let empty = draw(&mut stage);
    assert_eq!(dark(&empty), 0);
    spawn_plates(&mut stage.world, 0.0);
    for technique in HARD {
        set_technique(&mut stage, light, technique);
        let rendered = draw(&mut stage);
        let error = error_of(&mut stage, &rendered);
        assert!(
            error.wrong_inner == 0 && error.inner > 5000,
            "{technique}: {error:?}"
        );
        assert!(dark(&rendered) > 500, "{technique}: {}", dark(&rendered));
        assert_ne!(rendered.radiance, empty.radiance);
        // The judge sees it when they do not cast.
        assert!(error_of(&mut stage, &empty).wrong_inner > 300);
    }
    set_technique(&mut stage, light, "map");
    let rendered = draw(&mut stage);
    let error = error_of(&mut stage, &rendered);
    assert!(error.wrong_inner * 100 < error.inner, "map: {error:?}");
    assert!(dark(&rendered) > 400, "map: {}", dark(&rendered));
}

/// A box that follows one joint.
fn skinned_box() -> MeshData {
    let mut mesh = MeshData::cuboid(Vec3::splat(0.5));
    mesh.joints = vec![[0; 4]; mesh.positions.len()];
    mesh.joint_weights = vec![Vec4::X; mesh.positions.len()];
    mesh
}

#[test]
fn joints_alone_place_a_skinned_mesh_without_a_scale_of_its_own() {
    let mut stage = ground();
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.4, 4.0, 0.6), 30.0);
    let joint = Transform::from_xyz(0.2, 1.0, 0.1).with_rotation(Quat::from_rotation_y(0.4));
    let joint = stage.world.spawn(joint).id();
    let skin = Skin {
        joints: vec![joint],
        inverse_bind: [Mat4::IDENTITY].into(),
    };
    let skinned = stage
        .world
        .spawn((object(skinned_box(), Transform::IDENTITY), skin))
        .id();
    for technique in HARD {
        set_technique(&mut stage, light, technique);
        stage.world.entity_mut(skinned).insert(Transform::IDENTITY);
        let usual = draw(&mut stage);
        assert!(dark(&usual) > 200, "{}", dark(&usual));
        for scale in [Vec3::ZERO, Vec3::X, Vec3::new(1.0, 0.0, 1.0)] {
            let own = Transform::from_xyz(3.0, 0.0, -2.0).with_scale(scale);
            stage.world.entity_mut(skinned).insert(own);
            let rendered = draw(&mut stage);
            let error = error_of(&mut stage, &rendered);
            assert_eq!(error.wrong_inner, 0, "{technique}, scale {scale}: {error:?}");
            let pairs = rendered.visibility[0].iter().zip(&usual.visibility[0]);
            let other = pairs.filter(|(a, b)| a != b).count();
            assert!(other < 30, "{technique}, scale {scale}: {other} pixels changed");
        }
    }
    // Without a skin nothing is left of it.
    stage.world.entity_mut(skinned).remove::<Skin>();
    stage
        .world
        .entity_mut(skinned)
        .insert(Transform::from_scale(Vec3::ZERO));
    assert_eq!(dark(&draw(&mut stage)), 0);
}

#[test]
fn equal_cone_angles_make_a_sharp_spot() {
    let mut stage = ground();
    let kind = |inner_angle, outer_angle| LightKind::Spot {
        inner_angle,
        outer_angle,
    };
    let narrow = f32::to_radians(20.0);
    let light = lamp(&mut stage, kind(narrow, narrow), Vec3::new(0.0, 4.0, 0.0), 30.0);
    stage.world.get_mut::<Light>(light).unwrap().intensity = 0.0;
    let ambient = draw(&mut stage).radiance;
    stage.world.get_mut::<Light>(light).unwrap().intensity = 40.0;
    let sharp = draw(&mut stage);
    // As bright as one of which that is all inside, and nothing beyond.
    stage.world.get_mut::<Light>(light).unwrap().kind = kind(narrow, f32::to_radians(40.0));
    let wide = draw(&mut stage);
    let (mut lit, mut same, mut none) = (0, 0, 0);
    for (at, around) in ambient.chunks(4).enumerate() {
        let [a, b] = [&sharp, &wide].map(|picture| picture.radiance[4 * at] - around[0]);
        if a > 0.0 {
            lit += 1;
            same += usize::from((a - b).abs() <= 0.01 * b);
        } else {
            none += usize::from(b > 0.0);
        }
    }
    assert!(same + 8 >= lit && lit > 500, "{same} of {lit}");
    assert!(none > 300, "{none}");
    let crossed = Light {
        kind: kind(0.5, 0.4),
        ..Light::point(Vec3::ONE, 1.0, 1.0)
    };
    assert!(crossed.validate().is_err());
    let closed = Light {
        kind: kind(0.0, 0.0),
        ..Light::point(Vec3::ONE, 1.0, 1.0)
    };
    assert!(closed.validate().is_err());
}
