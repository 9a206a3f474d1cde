//! Blurred grounds: their shadows are a Gaussian of exact visibility on the plane, and what stands on them has sharp ones.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, SurfaceHit, primary_hits};
use antumbra::reports::Reports;
use antumbra::scene::BlurredGround;
use antumbra::techniques::maps::MapResolution;
use antumbra::techniques::perspective_map::PerspectiveFaces;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, Quat, UVec2, Vec3};

use super::{SPOT, variants};
use crate::harness::maps::Judge;
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(96, 54);

/// Pixels of which one is judged.
const EVERY: usize = 5;

pub(super) fn add(stage: &mut Stage, mesh: MeshData, at: Transform) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        at,
    );
    stage.world.spawn(parts).id()
}

/// A ground with a box that stands on it, a plate that floats over it, and a block beneath it. Returns the ground.
pub(super) fn stage(radius: f32) -> (Stage, Entity) {
    let camera = Camera {
        vertical_fov: 0.9,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(1.2, 2.2, 3.4).looking_at(Vec3::new(0.0, 0.2, -0.3), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let ground = add(&mut stage, MeshData::plane(5.0), Transform::IDENTITY);
    stage.world.entity_mut(ground).insert(BlurredGround { radius });
    let turned = Quat::from_rotation_y(0.5);
    let standing = Transform::from_xyz(-0.6, 0.35, 0.2).with_rotation(turned);
    add(&mut stage, MeshData::cuboid(Vec3::new(0.3, 0.35, 0.25)), standing);
    let plate = Transform::from_xyz(0.7, 0.9, -0.4).with_rotation(turned);
    add(&mut stage, MeshData::cuboid(Vec3::new(0.4, 0.02, 0.5)), plate);
    let beneath = Transform::from_xyz(0.8, -0.6, 0.9);
    add(&mut stage, MeshData::cuboid(Vec3::new(0.4, 0.3, 0.4)), beneath);
    (stage, ground)
}

pub(super) fn lights() -> [(Light, Transform); 3] {
    let from = Vec3::new(1.1, 3.2, 1.4);
    [LightKind::Directional, LightKind::Point, SPOT].map(|kind| {
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 40.0, 30.0)
        };
        (
            light,
            Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y),
        )
    })
}

fn hits(stage: &Stage, rays: &RayScene) -> HitImage {
    let camera = stage.world.get::<Camera>(stage.camera).expect("a camera");
    let transform = stage
        .world
        .get::<GlobalTransform>(stage.camera)
        .expect("its place");
    primary_hits(rays, camera, transform, SIZE).expect("a usable camera")
}

/// A Gaussian of visibility around a point of a plane, by a grid of rays to those points that are of the ground.
pub(super) fn expected(
    judge: &Judge,
    hit: &SurfaceHit,
    radius: f64,
    is_of_ground: impl Fn(DVec3) -> bool,
) -> f64 {
    let (x, y) = hit.normal.any_orthonormal_pair();
    let (mut sum, mut weights) = (0.0, 0.0);
    for i in -12..=12 {
        for k in -12..=12 {
            let (u, v) = (f64::from(i) / 12.0 * 2.5, f64::from(k) / 12.0 * 2.5);
            let weight = (-0.5 * (u * u + v * v)).exp();
            // Off the plane, so that its other triangle is not in the way.
            let point = hit.position + (x * u + y * v) * radius + hit.normal * 1e-4;
            if !is_of_ground(point) {
                continue;
            }
            sum += weight * f64::from(u8::from(judge.sees(point, hit)));
            weights += weight;
        }
    }
    sum / weights
}

/// RMSE where the Gaussian of a radius is neither lit nor dark, numbers of such pixels and of soft ones, and pixels that are
/// wrong on what is no ground or is wholly lit.
fn judge(stage: &mut Stage, radius: f64) -> (f64, usize, usize, usize) {
    let rendered = stage.render().expect("the frame renders").visibility.remove(0);
    let rays = RayScene::from_world(&mut stage.world);
    let hits = hits(stage, &rays);
    let judge = Judge::new(stage, &rays, 0).expect("something casts");
    let on_ground = |hit: &SurfaceHit| hit.position.y.abs() < 1e-4;
    let (mut sum, mut count, mut soft, mut halo) = (0.0, 0, 0, 0);
    let mut others = rendered.clone();
    for (index, hit) in hits.hits.iter().enumerate() {
        let Some(hit) = hit.as_ref().filter(|hit| on_ground(hit)) else {
            continue;
        };
        others[index] = judge.truth.values()[index];
        soft += usize::from((0.1..0.9).contains(&rendered[index]));
        if index % EVERY == 0 && !judge.truth.values()[index].is_nan() {
            let expected = expected(&judge, hit, radius, |_| true);
            let square = (f64::from(rendered[index]) - expected).powi(2);
            halo += usize::from(expected >= 0.99 && square > 1e-3);
            if (0.01..0.99).contains(&expected) {
                sum += square;
                count += 1;
            }
        }
    }
    let wrong = judge.compare(&others).wrong + halo;
    ((sum / f64::from(count as u32)).sqrt(), count, soft, wrong)
}

#[test]
fn blurred_shadows_are_a_gaussian_of_exact_visibility_on_the_plane() {
    for (index, (light, place)) in lights().into_iter().enumerate() {
        for radius in [0.06f32, 0.2] {
            let (mut stage, _) = stage(radius);
            let map = PerspectiveMap {
                resolution: MapResolution::Fixed(512),
                faces: [PerspectiveFaces::One, PerspectiveFaces::Cube][index % 2],
                ..Default::default()
            };
            stage.spawn_light(light.clone(), place, Some(map));
            let (rmse, count, soft, wrong) = judge(&mut stage, f64::from(radius));
            println!(
                "{:?}, {radius} m: RMSE {rmse:.4} of {count}, {soft} soft, {wrong} wrong beside",
                light.kind
            );
            assert!(rmse <= 0.03, "{:?}, {radius} m: {rmse}", light.kind);
            assert!(count >= 8 && soft > 40, "{count} {soft}");
            assert_eq!(
                wrong, 0,
                "{:?}, {radius} m: what stands on the ground has a halo",
                light.kind
            );
            // A Gaussian of another radius is not what is drawn.
            if radius > 0.1 && index == 0 {
                let (other, ..) = judge(&mut stage, 2.0 * f64::from(radius));
                assert!(other > 0.04, "{other}");
            }
        }
    }
}

#[test]
fn grounds_that_cast_nothing_look_the_same_and_nothing_shines_through_from_below() {
    for (light, place) in lights() {
        let pictures = [true, false].map(|casts| {
            let (mut stage, ground) = stage(0.15);
            if !casts {
                stage.world.entity_mut(ground).remove::<ShadowCaster>();
            }
            stage.spawn_light(light.clone(), place, Some(variants(512)[0]));
            stage.render().expect("the frame renders").visibility.remove(0)
        });
        let [casts, not] = &pictures;
        let differ = casts
            .iter()
            .zip(not)
            .filter(|(a, b)| (*a - *b).abs() > 0.05)
            .count();
        let soft = casts.iter().filter(|v| (0.1..0.9).contains(*v)).count();
        assert!(
            differ < 8 && soft > 60, // the light's camera sees other casters, so texels are elsewhere
            "{:?}: {differ} pixels differ, {soft} soft",
            light.kind
        );
    }
}

#[test]
fn four_grounds_are_blurred_at_once_and_a_fifth_is_reported() {
    let (mut stage, _) = stage(0.3);
    let wall = |at: Vec3, turn: Quat| Transform::from_translation(at).with_rotation(turn);
    let quarter = std::f32::consts::FRAC_PI_2;
    let mut walls = Vec::new();
    for (at, turn, radius) in [
        (Vec3::new(0.0, 0.0, -1.6), Quat::from_rotation_x(quarter), 0.15f32),
        (Vec3::new(-1.8, 0.0, 0.0), Quat::from_rotation_z(-quarter), 0.1),
        (Vec3::new(1.9, 0.5, 0.0), Quat::from_rotation_z(0.9), 0.05),
        (Vec3::new(0.0, -4.0, 0.0), Quat::IDENTITY, 0.2),
    ] {
        let wall = add(&mut stage, MeshData::plane(1.5), wall(at, turn));
        stage.world.entity_mut(wall).insert(BlurredGround { radius });
        walls.push(wall);
    }
    // Two halves of one ground are one.
    let half = add(
        &mut stage,
        MeshData::plane(0.5),
        Transform::from_xyz(0.0, 0.0, 3.0),
    );
    stage.world.entity_mut(half).insert(BlurredGround { radius: 0.3 });
    let (light, place) = lights()[0].clone();
    stage.spawn_light(light, place, Some(variants(512)[0]));
    let rendered = stage.render().expect("the frame renders").visibility.remove(0);
    let reports = stage.world.resource::<Reports>();
    let told: Vec<Entity> = reports
        .iter()
        .filter(|report| report.message.contains("four other grounds"))
        .filter_map(|report| report.entity)
        .collect();
    assert!(told.len() == 1 && walls.contains(&told[0]), "{told:?}");
    let rays = RayScene::from_world(&mut stage.world);
    let hits = hits(&stage, &rays);
    let soft_at = |normal: DVec3| {
        let pixels = hits.hits.iter().zip(&rendered);
        let on = pixels.filter(|(hit, _)| hit.as_ref().is_some_and(|hit| hit.normal.dot(normal) > 0.99));
        on.filter(|(_, v)| (0.1..0.9).contains(*v)).count()
    };
    let soft = [soft_at(DVec3::Y), soft_at(DVec3::Z), soft_at(DVec3::X)];
    println!("soft pixels on ground and walls: {soft:?}");
    // Seams are blurred on each ground by itself. The wall that is left out has none, as the map has none.
    assert!(soft[0] > 100, "{soft:?}");
    for (wall, soft) in walls.iter().zip(&soft[1..]) {
        assert_eq!(*soft > 20, told[0] != *wall, "{soft}");
        assert!(*soft > 20 || *soft == 0, "{soft}");
    }
}

#[test]
fn a_radius_that_is_no_length_leaves_the_filter_and_is_reported() {
    let (mut stage, _) = stage(f32::NAN);
    let (light, place) = lights()[0].clone();
    stage.spawn_light(light, place, Some(variants(512)[0]));
    let rendered = stage.render().expect("the frame renders").visibility.remove(0);
    assert!(rendered.iter().filter(|v| **v == 0.0).count() > 40);
    let mut reports = stage.world.resource::<Reports>().iter();
    assert!(reports.any(|report| report.message.contains("radius")));
}

/// Floor and wall are blurred, and neither darkens the other where they meet in the light.
#[test]
fn grounds_that_meet_in_the_light_are_not_dark() {
    for (light, place) in lights() {
        let (mut stage, _) = stage(0.2);
        let turn = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
        let wall = Transform::from_xyz(0.0, 1.5, -1.2).with_rotation(turn);
        let wall = add(&mut stage, MeshData::plane(1.5), wall);
        stage.world.entity_mut(wall).insert(BlurredGround { radius: 0.1 });
        let floor = add(
            &mut stage,
            MeshData::plane(0.9),
            Transform::from_xyz(0.0, 0.01, -0.3),
        );
        stage
            .world
            .entity_mut(floor)
            .insert(BlurredGround { radius: 0.2 });
        stage.spawn_light(light.clone(), place, Some(variants(512)[0]));
        let rendered = stage.render().expect("the frame renders").visibility.remove(0);
        let rays = RayScene::from_world(&mut stage.world);
        let hits = hits(&stage, &rays);
        // To the right of the plate's shadow, a hand's breadth to each side of the seam.
        let near = |hit: &SurfaceHit| {
            let p = hit.position;
            let (above, before) = (p.y - 0.01, p.z + 1.2);
            p.x < -0.5 && p.x > -0.85 && above < 0.15 && before < 0.15 && above >= 0.0
        };
        let seam = hits
            .hits
            .iter()
            .zip(&rendered)
            .filter(|(hit, _)| hit.as_ref().is_some_and(near));
        let values: Vec<f32> = seam.map(|(_, value)| *value).collect();
        let least = values.iter().copied().fold(1.0, f32::min);
        println!(
            "{:?}: {} pixels along the seam, the darkest {least}",
            light.kind,
            values.len()
        );
        assert!(values.len() > 5 && least > 0.85, "{:?}: {least}", light.kind);
    }
}
