//! Lamps below the ceiling of closed rooms, which have receivers nearly all around.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::techniques::PerspectiveMaps;
use antumbra::techniques::maps::{MapResolution, Maps};
use antumbra::techniques::perspective_map::Fit;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use crate::faults::placements::Random;
use crate::harness::support::stage::Stage;
use crate::harness::{strict_context, truth};

const SIZE: UVec2 = UVec2::new(160, 90);

/// Heights of lamps below the ceiling, metres.
const BELOW: [f32; 6] = [0.0, 0.01, 0.03, 0.1, 0.2, 0.3];

/// Sizes of rooms, metres: a small room, a long corridor and a hall.
const ROOMS: [Vec3; 3] = [
    Vec3::new(4.0, 2.5, 4.0),
    Vec3::new(2.2, 2.6, 11.0),
    Vec3::new(13.0, 4.5, 9.0),
];

/// A room with tables and crates, seen from a place by its walls.
fn room(size: Vec3, random: &mut Random) -> (Stage, RayScene) {
    let mut between = |low: f32, high: f32| low + (high - low) * random.unit() as f32;
    let camera = Camera {
        vertical_fov: 1.22,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let corner = Vec3::new(between(-0.45, 0.45), 0.0, 0.44);
    let eye = corner * size + Vec3::Y * between(1.3, 1.8);
    let target = Vec3::new(between(-0.3, 0.3), 0.0, between(-0.4, 0.0)) * size + Vec3::Y * between(0.4, 1.2);
    let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    stage.world.insert_resource(FaceCulling::None);
    let mut add = |mesh: MeshData, at: Vec3, turn: f32| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at).with_rotation(Quat::from_rotation_y(turn)),
        ));
    };
    let mut walls = MeshData::cuboid(size * 0.5);
    walls
        .indices
        .chunks_exact_mut(3)
        .for_each(|corners| corners.swap(0, 1));
    walls.normals.iter_mut().for_each(|normal| *normal = -*normal);
    add(walls, Vec3::Y * size.y * 0.5, 0.0);
    for _ in 0..3 {
        let at = Vec3::new(between(-0.35, 0.35), 0.0, between(-0.4, 0.25)) * size;
        add(
            MeshData::cuboid(Vec3::new(0.5, 0.02, 0.3)),
            at + Vec3::Y * 0.72,
            0.3,
        );
        let at = Vec3::new(between(-0.35, 0.35), 0.0, between(-0.4, 0.25)) * size;
        add(
            MeshData::cuboid(Vec3::splat(0.25)),
            at + Vec3::Y * 0.25,
            between(0.0, 1.5),
        );
        let at = Vec3::new(between(-0.35, 0.35), 0.0, between(-0.4, 0.25)) * size;
        add(
            MeshData::icosphere(0.15, 3),
            at + Vec3::Y * between(0.15, 1.2),
            0.0,
        );
    }
    stage.schedule.run(&mut stage.world);
    let rays = RayScene::from_world(&mut stage.world);
    (stage, rays)
}

/// How wrong a picture is.
#[derive(Clone, Copy, Debug, Default)]
struct Wrong {
    /// Pixels that count.
    counted: usize,
    /// Pixels that are dark in truth.
    dark: usize,
    /// Pixels that are wrong by more than ½.
    all: usize,
    /// Wrong pixels around which the truth is the same for two pixels.
    far: usize,
}

fn compare(truth: &[f32], got: &[f32]) -> Wrong {
    let (width, height) = (SIZE.x as i32, SIZE.y as i32);
    let mut wrong = Wrong::default();
    for (index, (&expected, &got)) in truth.iter().zip(got).enumerate() {
        if expected.is_nan() {
            continue;
        }
        wrong.counted += 1;
        wrong.dark += usize::from(expected < 0.5);
        if (got - expected).abs() <= 0.5 {
            continue;
        }
        wrong.all += 1;
        let (x, y) = (index as i32 % width, index as i32 / width);
        let around = (-2..=2).flat_map(|dy| (-2..=2).map(move |dx| (x + dx, y + dy)));
        let mut around = around.filter(|(x, y)| (0..width).contains(x) && (0..height).contains(y));
        wrong.far += usize::from(!around.any(|(x, y)| {
            let other = truth[(y * width + x) as usize];
            !other.is_nan() && (other < 0.5) != (expected < 0.5)
        }));
    }
    wrong
}

/// Draws a lamp's perspective map and returns what is wrong, the fit and the map's resolution.
fn draw(stage: &mut Stage, rays: &RayScene, at: Vec3, map: PerspectiveMap) -> (Wrong, Fit, u32) {
    let light = stage.spawn_light(
        Light::point(Vec3::ONE, 40.0, 30.0),
        Transform::from_translation(at),
        Some(map),
    );
    let rendered = stage.render().expect("the frame renders");
    let truth = truth(stage, rays, 0);
    let wrong = compare(truth.values(), &rendered.visibility[0]);
    let fit = *stage
        .world
        .resource::<PerspectiveMaps>()
        .of_light(0)
        .expect("it is fitted");
    let resolution = stage
        .world
        .resource::<Maps>()
        .of_light(0)
        .expect("it has a map")
        .resolution;
    stage.lights.clear();
    stage.world.despawn(light);
    (wrong, fit, resolution)
}

#[test]
fn lamps_below_a_ceiling_have_the_texels_that_the_room_needs() {
    let mut random = Random::new(11);
    let (mut all, mut coarse, mut bad) = (Wrong::default(), Wrong::default(), Vec::new());
    let mut faces = [0; 7];
    for size in ROOMS {
        for below in BELOW {
            for _ in 0..3 {
                let (mut stage, rays) = room(size, &mut random);
                let place = Vec3::new(
                    (random.unit() as f32 - 0.5) * 0.8 * size.x,
                    size.y - below,
                    (random.unit() as f32 - 0.5) * 0.8 * size.z,
                );
                let (wrong, fit, resolution) = draw(&mut stage, &rays, place, PerspectiveMap::default());
                let few = PerspectiveMap {
                    resolution: MapResolution::Fixed(64),
                    ..Default::default()
                };
                let (few, ..) = draw(&mut stage, &rays, place, few);
                let line = format!(
                    "{size}, {below} m below, {place}: {wrong:?}, {} faces of {resolution}², side {:.2}; at 64²: {few:?}",
                    fit.faces, fit.texel_side
                );
                println!("{line}");
                faces[fit.faces] += 1;
                // Texels are about as large as pixels, at most four times; a lamp of one coarse picture had 25.
                if wrong.all * 250 > wrong.counted || wrong.far * 400 > wrong.counted || fit.texel_side > 4.0
                {
                    bad.push(line);
                }
                for (sum, wrong) in [(&mut all, wrong), (&mut coarse, few)] {
                    sum.counted += wrong.counted;
                    sum.dark += wrong.dark;
                    sum.all += wrong.all;
                    sum.far += wrong.far;
                }
            }
        }
    }
    println!("{all:?}, at 64²: {coarse:?}, {faces:?}");
    assert!(all.dark * 50 > all.counted, "hardly anything is dark: {all:?}");
    assert!(all.all * 800 < all.counted, "{all:?}");
    assert!(coarse.all > 3 * all.all, "coarse maps pass too: {coarse:?}");
    assert!(bad.is_empty(), "{} pictures:\n{}", bad.len(), bad.join("\n"));
}
