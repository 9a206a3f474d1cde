//! Maps spend their texels on what is seen: automatic resolution follows the visible receivers, cascades follow the shadows
//! that are seen, and the near plane follows the casters, however far the world reaches.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::reports::Reports;
use antumbra::techniques::maps::{FaceProjection, MapError, MapResolution, Maps};
use antumbra::techniques::shadow_map::Cascades;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use super::contacts::SPOT;
use crate::harness::maps::judge_map;
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

fn stage(size: UVec2, vertical_fov: f32, eye: Vec3, target: Vec3) -> Stage {
    let camera = Camera {
        vertical_fov,
        aspect: size.x as f32 / size.y as f32,
        near: 0.05,
        ..Camera::default()
    };
    let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
    let mut stage = Stage::empty(size, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    stage
}

fn add(stage: &mut Stage, mesh: MeshData, at: Transform) {
    stage.world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        at,
    ));
}

/// Texels that an omnidirectional map over a floor and before a wall gets by itself.
fn automatic(size: UVec2, distance: f32, range: f32) -> u32 {
    let eye = Vec3::new(3.1, 2.4, 4.3) * distance;
    let mut stage = stage(size, 34_f32.to_radians(), eye, Vec3::new(0.0, 0.7, 0.0));
    add(
        &mut stage,
        MeshData::plane(7.0),
        Transform::from_xyz(0.0, 0.0, 4.0),
    );
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    let wall = Transform::from_xyz(0.0, 2.5, -3.0).with_rotation(upright);
    add(&mut stage, MeshData::plane(7.0), wall);
    let light = Light::point(Vec3::ONE, 60.0, range);
    let height = if range < 4.0 { 0.5 } else { 3.9 };
    let place = Transform::from_xyz(1.7, height, 1.3);
    stage.spawn_light(light, place, Some(OmniMap::default()));
    stage.schedule.run(&mut stage.world);
    let maps = stage.world.resource::<Maps>();
    maps.of_light(0).expect("it has a map").resolution
}

#[test]
fn automatic_resolution_follows_what_is_seen() {
    let size = UVec2::new(240, 135);
    assert_eq!(automatic(size, 1.0, 60.0), 512);
    assert_eq!(automatic(2 * size, 1.0, 60.0), 1024, "pixels of half the size");
    assert_eq!(automatic(size / 2, 1.0, 60.0), 256);
    assert_eq!(automatic(size, 4.0, 60.0), 256, "receivers further away");
    assert_eq!(automatic(2 * size, 2.0, 1.5), 128, "a small light");
}

#[test]
fn a_sky_does_not_push_the_near_plane_away() {
    for kind in [LightKind::Point, SPOT] {
        for near in [None, Some(5.0)] {
            let eye = Vec3::new(2.5, 2.5, 4.0);
            let mut stage = stage(UVec2::new(112, 63), 0.8, eye, Vec3::new(0.0, 0.3, 0.0));
            stage
                .add_renderer(strict_context(), RenderSettings::default())
                .expect("shaders compose");
            add(&mut stage, MeshData::plane(6.0), Transform::default());
            let cube = MeshData::cuboid(Vec3::splat(0.4));
            add(&mut stage, cube, Transform::from_xyz(0.0, 0.4, 0.0));
            let sky = Transform::from_scale(Vec3::splat(300_000.0));
            add(&mut stage, MeshData::icosphere(1.0, 3), sky);
            let light = Light {
                kind,
                ..Light::point(Vec3::ONE, 40.0, f32::INFINITY)
            };
            let place = Transform::from_xyz(-1.4, 2.4, 0.6).looking_at(Vec3::ZERO, Vec3::Y);
            let entity = stage.spawn_light(light, place, None::<OmniMap>);
            let resolution = MapResolution::Fixed(512);
            let mut entity = stage.world.entity_mut(entity);
            if kind == LightKind::Point {
                entity.insert(OmniMap {
                    resolution,
                    near,
                    ..Default::default()
                });
            } else {
                entity.insert(ShadowMap {
                    resolution,
                    near,
                    ..Default::default()
                });
            }
            stage.schedule.run(&mut stage.world); // places the objects
            let rays = RayScene::from_world(&mut stage.world);
            let rendered = stage.render().expect("the frame renders");
            let error = judge_map(&stage, &rays, 0, &rendered.visibility[0]);
            assert!(error.dark > 50, "{error:?}");
            if near.is_none() {
                assert!(error.share() < 0.005, "{kind:?}: {error:?}");
            } else {
                assert!(error.leaks > 50, "{kind:?}: a far near plane is seen: {error:?}");
            }
        }
    }
}

/// A pillar beside the camera in the sun, on a ground of some half size.
fn field(half: f32, cascades: Cascades) -> Stage {
    let (eye, target) = (Vec3::new(2.0, 1.7, 3.0), Vec3::new(-0.3, 0.5, 0.0));
    let mut stage = stage(UVec2::new(128, 72), 0.8, eye, target);
    add(&mut stage, MeshData::plane(half), Transform::default());
    let pillar = MeshData::cuboid(Vec3::new(0.2, 0.8, 0.2));
    add(&mut stage, pillar, Transform::from_xyz(0.3, 0.8, 0.0));
    let sun = Transform::default().looking_to(Vec3::new(-0.5, -1.0, -0.3), Vec3::Y);
    let map = ShadowMap {
        cascades,
        ..Default::default()
    };
    stage.spawn_light(Light::directional(Vec3::ONE, 3.0), sun, Some(map));
    stage
}

fn finest_texel(stage: &Stage) -> f64 {
    let map = stage
        .world
        .resource::<Maps>()
        .of_light(0)
        .expect("the sun has a map");
    let texels = map.faces.iter().map(|face| match face.face.projection {
        FaceProjection::Parallel { half, .. } => 2.0 * half / f64::from(map.resolution),
        _ => f64::INFINITY,
    });
    texels.fold(f64::INFINITY, f64::min)
}

/// A hill at the horizon, which is lit and casts.
fn hill(stage: &mut Stage) {
    let at = Transform::from_xyz(-2500.0, -200.0, -4000.0).with_scale(Vec3::splat(900.0));
    add(stage, MeshData::icosphere(1.0, 3), at);
}

#[test]
fn the_size_of_the_ground_does_not_coarsen_the_sun() {
    for (half, has_hill, largest) in [
        (30.0, false, 0.02),
        (3000.0, false, 0.02),
        (10_000.0, false, 0.02),
        (6000.0, true, 0.1),
    ] {
        let mut stage = field(half, Cascades::default());
        if has_hill {
            hill(&mut stage);
        }
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        stage.schedule.run(&mut stage.world); // places the objects
        let rays = RayScene::from_world(&mut stage.world);
        let rendered = stage.render().expect("the frame renders");
        let error = judge_map(&stage, &rays, 0, &rendered.visibility[0]);
        let texel = finest_texel(&stage);
        println!("ground ±{half}, hill {has_hill}: texel {texel:.4} m, {error:?}");
        assert!(texel < largest, "±{half}: {texel}");
        assert!(error.dark > 30 && error.share() < 0.01, "±{half}: {error:?}");
        let near_edge = error.wrong_all as f64 / error.dark as f64;
        assert!(near_edge < 0.25, "±{half}: {error:?}");
        assert_eq!(stage.world.resource::<Maps>().reports, []);
    }
}

#[test]
fn what_stays_coarse_is_reported() {
    let one = Cascades {
        count: 1,
        ..Default::default()
    };
    let mut stage = field(6000.0, one);
    hill(&mut stage);
    stage.schedule.run(&mut stage.world);
    let reports = &stage.world.resource::<Maps>().reports;
    assert!(
        matches!(reports[..], [report] if matches!(report.error, MapError::Coarse { pixels } if pixels > 64)),
        "{reports:?}"
    );
    let light = stage.lights[0];
    let said: Vec<String> = stage
        .world
        .resource::<Reports>()
        .of_entity(light)
        .map(|report| format!("{}: {}", report.topic, report.message))
        .collect();
    assert!(said.len() == 1 && said[0].starts_with("shadow_map: "), "{said:?}");
    assert!(
        said[0].contains("pixels") && said[0].contains("distance"),
        "{said:?}"
    );
}

/// A pixel is larger than the shadow, and its middle is in the shadow.
#[test]
fn pictures_of_few_pixels_show_shadows() {
    for (size, vertical_fov) in [(1, 60_f32), (9, 150.0)] {
        let eye = Vec3::new(0.0, 3.0, 5.0);
        let mut stage = stage(UVec2::splat(size), vertical_fov.to_radians(), eye, Vec3::ZERO);
        add(&mut stage, MeshData::plane(6.0), Transform::default());
        let slab = MeshData::cuboid(Vec3::new(0.5, 0.05, 0.5));
        add(&mut stage, slab, Transform::from_xyz(0.0, 1.0, 0.0));
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        let sun = Transform::default().looking_to(Vec3::new(0.05, -1.0, 0.02), Vec3::X);
        let light = Light::directional(Vec3::ONE, 1.0);
        stage.spawn_light(light.clone(), sun, Some(ShadowMap::default()));
        stage.spawn_light(light.clone(), sun, Some(PerspectiveMap::default()));
        stage.spawn_light(light, sun, Some(Smoothie::default()));
        let rendered = stage.render().expect("the frame renders");
        let middle = (size * size / 2) as usize;
        let seen: Vec<f32> = rendered.visibility.iter().map(|light| light[middle]).collect();
        assert_eq!(seen, [0.0; 3], "{size} × {size} pixels");
    }
}
