//! Casters at the edge of a ground, receivers outside the picture, and what each of six pictures draws.

use antumbra::insides::occlusion_textures::SliceFace;
use antumbra::prelude::*;
use antumbra::sets::Objects;
use antumbra::techniques::{OcclusionTexture, OcclusionTextures, SliceFilter};
use bevy_transform::prelude::Transform;
use glam::{DVec3, Vec3};

use super::scenes::{BETWEEN, Scene, boxes, empty, lamp, rendered, rmse, spawn, square, staged, truth};
use crate::harness::strict_context;

/// Errors with and without the shadow.
fn errors(scene: &Scene, eye: [Vec3; 2], kind: LightKind, settings: OcclusionTexture) -> (f64, f64, f32) {
    let context = strict_context();
    let mut stage = staged(&context, scene);
    let camera = stage.camera;
    let view = Transform::from_translation(eye[0]).looking_at(eye[1], Vec3::Y);
    stage.world.entity_mut(camera).insert(view);
    let (light, place) = lamp(kind, Vec3::new(0.3, 3.0, 0.2));
    stage.spawn_light(light, place, Some(settings));
    let got = rendered(&mut stage);
    let truth = truth(&mut stage, 100);
    // The darkest that a pixel is which the light sees whole.
    let lit = truth
        .values()
        .iter()
        .zip(&got)
        .filter(|(truth, _)| **truth == 1.0);
    let darkest = lit.map(|(_, got)| *got).fold(1.0, f32::min);
    let all_lit = vec![1.0; got.len()];
    (rmse(&truth, &got), rmse(&truth, &all_lit), darkest)
}

/// A small box at the edge of its ground has a shadow.
#[test]
fn casters_at_the_edge_of_a_ground_cast() {
    let scene = Scene {
        name: "a box at an edge",
        parts: vec![
            (MeshData::plane(2.5), Transform::IDENTITY),
            (
                MeshData::cuboid(Vec3::splat(0.1)),
                Transform::from_xyz(-2.35, 0.1, 0.0),
            ),
        ],
        eye: Vec3::ZERO,
    };
    let view = [Vec3::new(-2.9, 0.6, 0.1), Vec3::new(-2.45, 0.0, 0.0)];
    let settings = OcclusionTexture {
        slices: 16,
        ..Default::default()
    };
    let (error, lit, _) = errors(&scene, view, square(0.2), settings);
    println!("error {error:.4}, without a shadow {lit:.4}");
    assert!(lit > 0.1 && error < 0.6 * lit, "{error}, {lit}");
}

/// The picture shows a small plate alone; the wide ground around it stays lit, and the shadow is fine.
#[test]
fn receivers_outside_the_picture_are_lit() {
    let scene = Scene {
        name: "a plate over a wide ground",
        parts: vec![
            (MeshData::plane(12.0), Transform::IDENTITY),
            (MeshData::plane(0.3), Transform::from_xyz(0.4, 1.2, 0.0)),
        ],
        eye: Vec3::ZERO,
    };
    let view = [Vec3::new(1.5, 4.0, 3.0), Vec3::new(0.3, 0.0, 0.0)];
    for filter in [
        SliceFilter::NBuffers,
        SliceFilter::Mipmaps,
        SliceFilter::SummedAreas,
    ] {
        let settings = OcclusionTexture {
            resolution: 64,
            filter,
            ..Default::default()
        };
        let (error, lit, darkest) = errors(&scene, view, square(1.0), settings);
        println!(
            "{filter:?}: error {error:.4}, without a shadow {lit:.4}, lit pixels {darkest:.3} or lighter"
        );
        assert!(lit > 0.05 && error < 0.02, "{filter:?}: {error}, {lit}");
        assert!(darkest > 0.9, "{filter:?}: {darkest}");
    }
}

/// Each of the six pictures around a sphere draws only the casters in its own pyramid.
#[test]
fn each_of_six_pictures_draws_the_casters_that_it_shows() {
    let context = strict_context();
    let mut stage = staged(&context, &boxes());
    let (light, place) = lamp(LightKind::Sphere { radius: 0.1 }, BETWEEN);
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    rendered(&mut stage);
    let renderer = stage.world.resource::<Renderer>();
    let draws = renderer.shadow_batch_count(&renderer.frame().lights[0]);
    let world = &stage.world;
    let objects = world.resource::<Objects>();
    let slices = &world.resource::<OcclusionTextures>().lights[0];
    assert_eq!(slices.faces.len(), 6);
    let (mut shown, mut drawn) = (0, 0);
    for face in &slices.faces {
        for object in slices.casters.ones() {
            let is_shown = slices.shows(face, objects, object);
            drawn += usize::from(is_shown);
            let (center, half) = objects.boxes.center_half(object);
            let is_inside = (0..512).any(|index| {
                let share = DVec3::new(
                    f64::from(index % 8),
                    f64::from(index / 8 % 8),
                    f64::from(index / 64),
                );
                is_in_pyramid(face, center + half * (share / 3.5 - 1.0))
            });
            shown += usize::from(is_inside);
            assert!(
                is_shown || !is_inside,
                "a picture shows a caster that it does not draw"
            );
        }
    }
    let casters = slices.casters.count_ones(..);
    println!("{casters} casters, {shown} shown and {drawn} drawn in all pictures, by {draws} draws");
    assert!(
        // Closed casters are drawn twice where they fill slices.
        drawn < 4 * casters && drawn >= casters && draws <= 2 * drawn,
        "{drawn}, {draws}"
    );
}

/// Whether a point is in the 90° that one of six pictures shows.
fn is_in_pyramid(face: &SliceFace, point: DVec3) -> bool {
    let point = face.light_from_world(point);
    point.truncate().abs().max_element() < point.z
}

/// Six pictures show the same shadows as one.
#[test]
fn spheres_between_casters_have_shadows_on_all_sides() {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::new(0.5, 1.2, 3.0));
    spawn(&mut stage, MeshData::plane(2.0), Transform::IDENTITY);
    for x in [-0.7, 0.7] {
        let at = Transform::from_xyz(x, 0.8, 0.0);
        spawn(&mut stage, MeshData::cuboid(Vec3::new(0.04, 0.3, 0.3)), at);
        let wall = Transform::from_xyz(2.4 * x, 1.0, 0.0);
        spawn(&mut stage, MeshData::cuboid(Vec3::new(0.05, 1.0, 1.0)), wall);
    }
    let (light, place) = lamp(LightKind::Sphere { radius: 0.1 }, Vec3::new(0.0, 0.9, 0.0));
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let got = rendered(&mut stage);
    let truth = truth(&mut stage, 64);
    let lit = rmse(&truth, &vec![1.0; got.len()]);
    let error = rmse(&truth, &got);
    println!("error {error:.4}, without a shadow {lit:.4}");
    assert!(lit > 0.2 && error < 0.5 * lit, "{error}, {lit}");
}
