//! Area lights that a surface cuts: they light by the part that is outside, under wedges as under rays.

use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, RayScene, SoftError, VisibilityImage, compare_soft, primary_hits, soft_visibility,
};
use antumbra::reports::Reports;
use antumbra::techniques::PenumbraWedges;
use antumbra::techniques::penumbra_wedge::{Overlap, WedgeCulling};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, Vec3};

use super::scenes::{SIZE, draw, ground, lamp, object, stage};
use crate::harness::support::stage::Stage;

/// The error of the light's visibility as drawn, and the mean of the truth of so many samples.
pub fn soft_error(stage: &mut Stage, samples: u32) -> (SoftError, f32) {
    let rendered = draw(stage);
    let scene = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).unwrap();
    let place = stage.world.get::<GlobalTransform>(stage.camera).unwrap();
    let size = stage.world.resource::<ViewportSize>().0;
    let hits = primary_hits(&scene, camera, place, size).unwrap();
    let source = LightSource::of_entity(&stage.world, stage.lights[0]).unwrap();
    let truth = soft_visibility(&scene, &hits, &source, samples, 1);
    let got = VisibilityImage::new(size, rendered.visibility[0].clone()).unwrap();
    let counted = truth.values().iter().filter(|value| !value.is_nan());
    let mean = counted.clone().sum::<f32>() / counted.count() as f32;
    (compare_soft(&truth, &got).unwrap().unwrap(), mean)
}

/// A room seen from within, with a table and a board.
fn room(kind: LightKind) -> (Stage, Entity) {
    let mut stage = stage(
        Vec3::new(-3.4, 2.2, 3.3),
        Vec3::new(0.4, 0.9, 0.0),
        Camera {
            vertical_fov: 1.1,
            near: 0.05,
            ..Camera::default()
        },
    );
    for (half, at) in [
        (Vec3::new(4.0, 1.5, 4.0), Vec3::new(0.0, 1.5, 0.0)),
        (Vec3::new(0.8, 0.04, 0.5), Vec3::new(0.0, 0.8, 0.0)),
    ] {
        let place = Transform::from_translation(at);
        stage.world.spawn(object(MeshData::cuboid(half), place));
    }
    let board = Transform::from_xyz(1.8, 1.0, -0.6).with_rotation(Quat::from_rotation_z(1.2));
    stage.world.spawn(object(MeshData::plane(1.4), board));
    let light = lamp(&mut stage, kind, Vec3::Y, 20.0);
    stage.world.entity_mut(light).insert(PenumbraWedge::default());
    (stage, light)
}

#[test]
fn balls_in_surfaces_light_by_what_is_outside() {
    let radius = 0.15;
    let (mut stage, light) = room(LightKind::Sphere { radius });
    let mut failed = Vec::new();
    for (name, at, halved) in [
        ("ceiling", Vec3::new(0.3, 3.0, 0.4), true),
        ("ceiling, a third out", Vec3::new(0.3, 2.95, 0.4), false),
        ("edge of the room", Vec3::new(4.0, 3.0, 0.5), true),
        ("on the table", Vec3::new(0.2, 0.84, 0.1), false),
        ("board", Vec3::new(1.8, 1.0, -0.6), true),
        ("free", Vec3::new(0.3, 2.5, 0.4), false),
    ] {
        stage
            .world
            .entity_mut(light)
            .insert(Transform::from_translation(at));
        let (error, mean) = soft_error(&mut stage, 64);
        println!("{name}: {error:?}, mean {mean:.3}");
        // Most of this is the error of 64 samples.
        if error.rmse_penumbra > 0.03 {
            failed.push((name, error));
        }
        assert!(!halved || mean < 0.6, "{name}: {mean}");
        let wedges = &stage.world.resource::<PenumbraWedges>().lights[0];
        assert_eq!(wedges.cuts_left_out, 0, "{name}");
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn cut_lights_are_the_same_with_every_culling_and_sum() {
    let (mut stage, light) = room(LightKind::Sphere { radius: 0.15 });
    stage
        .world
        .entity_mut(light)
        .insert(Transform::from_xyz(0.3, 2.95, 0.4));
    let mut pictures = Vec::new();
    for culling in [WedgeCulling::Depth, WedgeCulling::Stencil, WedgeCulling::None] {
        let wedge = PenumbraWedge {
            culling,
            overlap: Overlap::Additive,
            ..PenumbraWedge::default()
        };
        stage.world.entity_mut(light).insert(wedge);
        pictures.push(draw(&mut stage).visibility.remove(0));
    }
    assert_eq!(pictures[0], pictures[1]);
    assert_eq!(pictures[0], pictures[2]);
    let lit = pictures[0].iter().filter(|value| **value > 0.3 && **value < 0.9);
    assert!(lit.count() > 3000);
}

#[test]
fn rectangles_through_walls_light_by_what_is_outside() {
    let mut stage = ground();
    let wall = Transform::from_xyz(0.1, 1.0, 0.0).with_rotation(Quat::from_rotation_z(1.2));
    stage.world.spawn(object(MeshData::plane(3.0), wall));
    let (width, height) = (1.0, 0.6);
    let light = lamp(&mut stage, LightKind::Rect { width, height }, Vec3::Y, 20.0);
    stage.world.entity_mut(light).insert(PenumbraWedge::default());
    for x in [-0.5, 0.1, 0.6] {
        let place = Transform::from_xyz(x, 1.6, 0.2).looking_at(Vec3::new(x, 0.0, 0.1), Vec3::X);
        stage.world.entity_mut(light).insert(place);
        let (error, _) = soft_error(&mut stage, 64);
        println!("rectangle at {x}: {error:?}");
        assert!(error.rmse_penumbra < 0.04, "{x}: {error:?}");
    }
}

/// An open lamp shade: a cone of thin triangles that widens downwards.
fn shade() -> MeshData {
    const SIDES: u32 = 24;
    let ring = |radius: f32, height: f32| {
        (0..SIDES).map(move |side| {
            let (sin, cos) = (side as f32 / SIDES as f32 * std::f32::consts::TAU).sin_cos();
            Vec3::new(radius * cos, height, radius * sin)
        })
    };
    let positions = ring(0.5, 2.0).chain(ring(0.25, 2.5)).collect();
    let quad = |i: u32| {
        let j = (i + 1) % SIDES;
        [i, i + SIDES, j, j, i + SIDES, j + SIDES]
    };
    MeshData::from_triangles("shade", positions, (0..SIDES).flat_map(quad).collect())
}

#[test]
fn shades_of_thin_triangles_hide_as_rays_do() {
    let mut failed = Vec::new();
    // The first ball is within the shade, and the others reach through it.
    for (radius, height) in [(0.3, 2.2), (0.45, 2.1), (0.6, 2.1)] {
        let mut stage = stage(
            Vec3::new(0.2, 4.2, 6.5),
            Vec3::new(0.0, 0.4, 0.0),
            Camera::default(),
        );
        stage.world.insert_resource(ViewportSize(SIZE / 2));
        for mesh in [MeshData::plane(6.0), shade()] {
            stage.world.spawn(object(mesh, Transform::IDENTITY));
        }
        let at = Vec3::Y * height;
        let light = lamp(&mut stage, LightKind::Sphere { radius }, at, 20.0);
        stage.world.entity_mut(light).insert(PenumbraWedge::default());
        let (error, _) = soft_error(&mut stage, 1024);
        println!("ball of {radius}: {error:?}");
        assert!(error.penumbra > 300, "{radius}: {error:?}");
        if error.rmse_penumbra > 0.03 {
            failed.push((radius, error));
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

/// A lamp whose surface is too rough for few polygons: the nearest count, and the others are reported.
#[test]
fn more_cuts_than_there_is_time_for_are_reported() {
    let mut stage = ground();
    let mut mesh = MeshData::icosphere(0.2, 3);
    for (index, position) in mesh.positions.iter_mut().enumerate() {
        *position *= if index.is_multiple_of(2) { 0.6 } else { 1.0 };
    }
    stage
        .world
        .spawn(object(mesh, Transform::from_xyz(0.0, 2.0, 0.0)));
    let light = lamp(
        &mut stage,
        LightKind::Sphere { radius: 0.25 },
        Vec3::new(0.0, 2.0, 0.0),
        20.0,
    );
    stage.world.entity_mut(light).insert(PenumbraWedge::default());
    draw(&mut stage);
    assert!(stage.world.resource::<PenumbraWedges>().lights[0].cuts_left_out > 100);
    let of_light = |stage: &Stage| {
        let reports = stage.world.resource::<Reports>().of_entity(light);
        reports.map(|report| report.message.clone()).collect::<Vec<_>>()
    };
    let reported = of_light(&stage);
    assert!(
        reported.iter().any(|message| message.contains("reach into")),
        "{reported:?}"
    );
    stage
        .world
        .entity_mut(light)
        .insert(Transform::from_xyz(1.0, 2.0, 0.0));
    draw(&mut stage);
    assert!(of_light(&stage).is_empty());
}
