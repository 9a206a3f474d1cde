//! How deep orthographic views are drawn, and what is exact in them.

use antumbra::prelude::*;
use antumbra::sets::{View, ViewDepth};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::scenes::{ground, light, rays, spawn};
use crate::harness::{judge, strict_context};

fn far(stage: &crate::harness::support::stage::Stage) -> f64 {
    let view = stage.world.resource::<View>();
    match view.data.as_ref().expect("a view").depth {
        ViewDepth::Finite { far, .. } => far,
        ViewDepth::Infinite { .. } => panic!("an orthographic view has an end"),
    }
}

/// A camera whose far plane is a kilometre away sees as one that ends behind the scene, and the depth that is drawn
/// follows what there is.
#[test]
fn the_far_plane_does_not_matter() {
    let context = strict_context();
    let mut pictures = Vec::new();
    for (near, end) in [(-2.0, 30.0), (-100.0, 1000.0), (0.0, 1e5)] {
        let mut stage = ground(&context, 3.6, near, end);
        let scene = rays(&mut stage);
        let sun = Vec3::new(1.0, 2.0, 0.7);
        light(
            &mut stage,
            LightKind::Directional,
            sun,
            f32::INFINITY,
            StencilVolume::default(),
        );
        let rendered = stage.render().expect("the frame renders");
        let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
        println!("{near} to {end}: drawn to {:.1}, {error:?}", far(&stage));
        assert_eq!(error.wrong_inner, 0, "{error:?}");
        assert!(far(&stage) < 400.0, "{}", far(&stage));
        pictures.push(rendered.visibility);
    }
    let differing = |at: usize| {
        let pairs = pictures[0][0].iter().zip(&pictures[at][0]);
        pairs.filter(|(a, b)| a != b).count()
    };
    println!("{} and {} pixels differ", differing(1), differing(2));
    assert!(differing(1) <= 8 && differing(2) <= 8);
}

/// A light within the bounds of what surrounds it, from near the middle to a hand's breadth from a wall: the volume of
/// the room ends beyond all that the light reaches.
#[test]
fn lights_in_a_room_shine_on_its_walls_alone() {
    let context = strict_context();
    for (at, kind) in [
        (Vec3::new(0.5, 2.0, 0.3), LightKind::Point),
        (Vec3::new(0.5, 2.9, 0.3), LightKind::Point),
        (Vec3::new(0.0, 2.99, 0.0), LightKind::Point),
    ] {
        let mut stage = ground(&context, 9.0, -20.0, 60.0);
        // Without the front walls one looks into it: its right and near ones are missing.
        let wall = MeshData::cuboid(Vec3::new(0.05, 1.5, 2.5));
        let lid = MeshData::cuboid(Vec3::new(2.5, 0.05, 2.5));
        spawn(&mut stage, wall.clone(), Transform::from_xyz(-2.5, 1.5, 0.0));
        spawn(
            &mut stage,
            wall,
            Transform::from_xyz(0.0, 1.5, -2.5)
                .with_rotation(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2)),
        );
        spawn(&mut stage, lid, Transform::from_xyz(0.0, 3.1, 0.0));
        // One mesh whose bounds hold the light.
        spawn(
            &mut stage,
            corner(),
            Transform::from_xyz(0.0, 0.0, 0.0).with_scale(Vec3::splat(4.0)),
        );
        let scene = rays(&mut stage);
        light(&mut stage, kind, at, 25.0, StencilVolume::default());
        let rendered = stage.render().expect("the frame renders");
        let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
        let dark = rendered.visibility[0].iter().filter(|v| **v == 0.0).count();
        println!(
            "light at {at}: drawn to {:.1}, {error:?}, {dark} dark",
            far(&stage)
        );
        assert_eq!(error.wrong_inner, 0, "{error:?}");
        assert!(dark > 1000, "{dark}");
    }
}

/// Two walls that meet, open on all other sides.
fn corner() -> MeshData {
    let positions = [
        [-1.0, 0.0, -1.0],
        [1.0, 0.0, -1.0],
        [1.0, 1.0, -1.0],
        [-1.0, 1.0, -1.0],
        [-1.0, 0.0, 1.0],
        [-1.0, 1.0, 1.0],
    ];
    let positions = positions.map(Vec3::from_array).to_vec();
    MeshData::from_triangles("corner", positions, vec![0, 1, 2, 0, 2, 3, 4, 0, 3, 4, 3, 5])
}

/// Far from the world's origin, on either side, volumes and wedges still reach the ground.
#[test]
fn far_from_the_origin_shadows_are_as_near_it() {
    let context = strict_context();
    let sun = LightKind::Directional;
    for (away, wedges) in [(20_000.0, false), (-20_000.0, false), (20_000.0, true)] {
        let mut stage = ground(&context, 3.6, -20.0, 60.0);
        let up = Vec3::new(0.0, away, 0.0);
        let world = &mut stage.world;
        for mut place in world.query::<&mut Transform>().iter_mut(world) {
            place.translation += up;
        }
        let scene = rays(&mut stage);
        let from = Vec3::new(1.0, 2.0, 0.7);
        if wedges {
            light(&mut stage, sun, from, f32::INFINITY, PenumbraWedge::default());
        } else {
            light(&mut stage, sun, from, f32::INFINITY, StencilVolume::default());
        }
        let rendered = stage.render().expect("the frame renders");
        let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
        let dark = rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
        println!("{away}, wedges {wedges}: {dark} dark, {error:?}");
        assert!(
            dark > 200 && error.wrong_inner == 0,
            "{away}: {dark} dark, {error:?}"
        );
    }
}
