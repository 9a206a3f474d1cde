//! Worlds of kilometres seen from close above their ground: the near shadows are right, whatever is far away.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::reports::Reports;
use antumbra::techniques::PerspectiveMaps;
use antumbra::techniques::maps::MapResolution;
use antumbra::techniques::perspective_map::Fit;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::SPOT;
use crate::harness::maps::{Judge, MapError};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(112, 63);

fn add(stage: &mut Stage, mesh: MeshData, at: Vec3) {
    stage.world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_translation(at),
    ));
}

/// Three boxes on a ground, with the eye at a height.
fn boxes(ground: MeshData, height: f32) -> Stage {
    let camera = Camera {
        vertical_fov: 60_f32.to_radians(),
        near: 0.1,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let eye = Vec3::new(0.5, height, 4.0);
    let view = Transform::from_translation(eye).looking_at(Vec3::new(0.0, height + 0.2, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    add(&mut stage, ground, Vec3::ZERO);
    for (at, half) in [
        ([-1.6, 0.6, 0.0], [0.4, 0.6, 0.4]),
        ([1.4, 0.6, 0.5], [0.4, 0.6, 0.4]),
        ([0.0, 0.9, -1.2], [0.03, 0.9, 0.03]),
    ] {
        add(&mut stage, MeshData::cuboid(half.into()), at.into());
    }
    stage
}

/// Hills of 60 m, up to 4 km away, around a flat place.
fn hills() -> MeshData {
    const CELLS: u32 = 80;
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for row in 0..=CELLS {
        for column in 0..=CELLS {
            let place = |index: u32| (index as f32 / CELLS as f32 * 2.0 - 1.0) * 4000.0;
            let (x, z) = (place(column), place(row));
            let height = if x.hypot(z) < 60.0 {
                0.0
            } else {
                60.0 * (x / 400.0).sin() * (z / 300.0).cos()
            };
            positions.push(Vec3::new(x, height, z));
        }
    }
    for row in 0..CELLS {
        for column in 0..CELLS {
            let first = row * (CELLS + 1) + column;
            let below = first + CELLS + 1;
            indices.extend([first, below, below + 1, first, below + 1, first + 1]);
        }
    }
    MeshData::from_triangles("hills", positions, indices)
}

fn sun(stage: &mut Stage, direction: Vec3, map: PerspectiveMap) {
    let place = Transform::default().looking_to(direction, Vec3::Y);
    stage.spawn_light(Light::directional(Vec3::ONE, 3.0), place, Some(map));
}

fn judged(stage: &mut Stage) -> MapError {
    let rendered = stage.render().expect("the frame renders");
    let rays = RayScene::from_world(&mut stage.world);
    let judge = Judge::new(stage, &rays, 0).expect("something casts");
    judge.compare(&rendered.visibility[0])
}

fn fit(stage: &Stage) -> Fit {
    let maps = stage.world.resource::<PerspectiveMaps>();
    *maps.of_light(0).expect("it is fitted")
}

fn reports(stage: &Stage) -> Vec<String> {
    let reports = stage.world.resource::<Reports>().of_entity(stage.lights[0]);
    reports.map(|report| report.message.clone()).collect()
}

/// The sun is ahead, close above the horizon: boxes and hills share the middle of one picture.
#[test]
fn near_shadows_of_a_low_sun_over_hills_are_not_smeared() {
    let mut stage = boxes(hills(), 0.3);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    sun(
        &mut stage,
        Vec3::new(0.55, -0.12, 0.83),
        PerspectiveMap::default(),
    );
    let error = judged(&mut stage);
    let fit = fit(&stage);
    println!("{fit:?} {error:?}");
    assert!(fit.replaces_one && fit.faces > 1, "{fit:?}");
    assert!(error.dark > 200 && error.share() < 0.01, "{error:?}");
    // Shadows as wide as a texel count too.
    assert!(
        (error.wrong_all as f64) < 0.03 * error.counted as f64,
        "{error:?}"
    );
    assert_eq!(reports(&stage), Vec::<String>::new());
}

/// Corners of the ground have a w that is 50,000 times that of what is near the eye, and its rounding with it.
#[test]
fn a_ground_of_two_triangles_and_sixty_kilometres_does_not_shadow_itself() {
    let mut dark = 0;
    for (height, turn) in [(0.3, 0.0_f32), (0.08, 50.0)] {
        let mut stage = boxes(MeshData::plane(30_000.0), height);
        let camera = stage.camera;
        let (sin, cos) = turn.to_radians().sin_cos();
        let eye = Vec3::new(0.5 * cos + 4.0 * sin, height, 4.0 * cos - 0.5 * sin);
        let view = Transform::from_translation(eye).looking_at(Vec3::Y * (height + 0.2), Vec3::Y);
        stage.world.entity_mut(camera).insert(view);
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        for resolution in [256, 1024] {
            let map = PerspectiveMap {
                resolution: MapResolution::Fixed(resolution),
                ..Default::default()
            };
            for direction in [Vec3::new(0.55, -0.12, 0.83), Vec3::new(-0.6, -0.3, -0.5)] {
                sun(&mut stage, direction, map);
                let error = judged(&mut stage);
                assert!(
                    error.share() < 0.004,
                    "{height} m, {direction}, {resolution}²: {error:?}"
                );
                assert!(fit(&stage).slide > 1.0, "{:?}", fit(&stage));
                dark += error.dark;
                remove_lights(&mut stage);
            }
            let lamp = Light {
                kind: SPOT,
                ..Light::point(Vec3::ONE, 50.0, f32::INFINITY)
            };
            let place = Transform::from_xyz(2.0, 4.5, 1.5).looking_at(Vec3::ZERO, Vec3::Y);
            stage.spawn_light(lamp, place, Some(map));
            let error = judged(&mut stage);
            assert!(
                error.share() < 0.004,
                "{height} m, spot, {resolution}²: {error:?}"
            );
            remove_lights(&mut stage);
        }
    }
    assert!(dark > 2000, "{dark}");
}

fn remove_lights(stage: &mut Stage) {
    for light in stage.lights.drain(..) {
        stage.world.despawn(light);
    }
}

/// The near plane is close to the eye, inside of the bounds of a hall, and no surface is there: texels would be spent on air.
#[test]
fn without_a_slide_in_a_hall_texels_are_where_the_nearest_surfaces_are() {
    let mut stage = boxes(MeshData::plane(6.0), 1.2);
    let camera = stage.camera;
    stage.world.get_mut::<Camera>(camera).expect("a camera").near = 1e-4;
    // One mesh of a few triangles is not divided, and its bounds hold the eye.
    let walls = [-5.8, 5.8]
        .map(|x| [(0.0, -6.0), (0.0, 6.0), (4.0, 6.0), (4.0, -6.0)].map(|(y, z)| Vec3::new(x, y, z)));
    let indices = vec![0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7];
    let walls = MeshData::from_triangles("walls", walls.concat(), indices);
    add(&mut stage, walls, Vec3::ZERO);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let map = PerspectiveMap {
        slide: Some(0.0),
        ..PerspectiveMap::default()
    };
    sun(&mut stage, Vec3::new(-0.3, -0.8, 0.1), map);
    let error = judged(&mut stage);
    let fit = fit(&stage);
    println!("{fit:?} {error:?}");
    assert!(fit.near < 0.001 && fit.slide > 0.5, "{fit:?}");
    assert!(
        error.dark > 100 && (error.wrong_all as f64) < 0.03 * error.counted as f64,
        "{error:?}"
    );
}

/// No picture has fine texels for boxes close by and for a ball at 370 km: that is reported, and only that.
#[test]
fn what_is_very_near_and_very_far_is_reported() {
    let with_moon = |has_moon: bool| {
        let mut stage = boxes(MeshData::plane(6.0), 0.3);
        if has_moon {
            let moon = MeshData::icosphere(20_000.0, 2);
            add(&mut stage, moon, Vec3::new(200_000.0, 100_000.0, -300_000.0));
        }
        sun(
            &mut stage,
            Vec3::new(0.55, -0.12, 0.83),
            PerspectiveMap::default(),
        );
        stage.schedule.run(&mut stage.world);
        println!("{:?}", fit(&stage));
        reports(&stage)
    };
    assert_eq!(with_moon(false), Vec::<String>::new());
    let told = with_moon(true);
    assert!(
        told.len() == 1 && told[0].contains("pixels") && told[0].contains("very far"),
        "{told:?}"
    );
}
