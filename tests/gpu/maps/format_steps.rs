//! Formats that pack distances into bytes, in scenes that reach much farther than what is seen of them.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::reports::Reports;
use antumbra::techniques::maps::{MapError, MapFormat, MapResolution, Maps};
use bevy_ecs::prelude::Entity;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::maps::judge_map;
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

fn spawn(stage: &mut Stage, mesh: MeshData, at: Transform) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        at,
    );
    stage.world.spawn(parts).id()
}

/// Three cubes under a lamp without a range, on a ground of some half size.
fn field(half: f32, map: OmniMap) -> Stage {
    let size = UVec2::new(112, 63);
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let view = Transform::from_xyz(2.5, 3.5, 5.0).looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
    let mut stage = Stage::empty(size, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    spawn(&mut stage, MeshData::plane(half), Transform::default());
    for x in [-1.2, 0.0, 1.2] {
        let at = Transform::from_xyz(x, 0.6, 0.0);
        spawn(&mut stage, MeshData::cuboid(Vec3::splat(0.3)), at);
    }
    let light = Light::point(Vec3::ONE, 40.0, f32::INFINITY);
    stage.spawn_light(light, Transform::from_xyz(-0.6, 4.0, 0.8), Some(map));
    stage
}

#[test]
fn grounds_of_kilometres_are_shadowed_or_what_is_lost_is_reported() {
    for (half, format, is_reported) in [
        (10.0, MapFormat::Rgba8TwoBytes, false),
        (2000.0, MapFormat::Rgba8TwoBytes, true),
        (2000.0, MapFormat::Rgba8FourBytes, false),
        (10_000.0, MapFormat::Rgba8FourBytes, false),
    ] {
        let map = OmniMap {
            format,
            resolution: MapResolution::Fixed(512),
            ..Default::default()
        };
        let mut stage = field(half, map);
        stage.schedule.run(&mut stage.world); // places the objects
        let rays = RayScene::from_world(&mut stage.world);
        let rendered = stage.render().expect("the frame renders");
        let error = judge_map(&stage, &rays, 0, &rendered.visibility[0]);
        assert!(error.dark > 50, "{error:?}");
        let is_right = error.share() < 0.005;
        assert_eq!(is_right, !is_reported, "±{half} m, {format:?}: {error:?}");
        let reports = &stage.world.resource::<Maps>().reports;
        let steps = |error: MapError| matches!(error, MapError::Steps { centimetres } if centimetres > 500);
        assert_eq!(
            reports.iter().any(|report| steps(report.error)),
            is_reported,
            "{reports:?}"
        );
        let mut said = stage.world.resource::<Reports>().of_entity(stage.lights[0]);
        let is_said =
            said.any(|report| report.topic == "omni_map" && report.message.contains("cm of the light"));
        assert_eq!(is_said, is_reported, "±{half} m, {format:?}");
    }
}

/// Texels of these formats are shares of the distance of the farthest caster.
#[test]
fn all_faces_follow_a_caster_that_flies_away() {
    for format in [MapFormat::R32Float, MapFormat::Rgba8FourBytes] {
        let map = |cached| OmniMap {
            format,
            cached,
            resolution: MapResolution::Fixed(256),
            near: Some(0.01),
            ..Default::default()
        };
        let mut stage = field(5.0, map(true));
        let (light, place) = (
            Light::point(Vec3::ONE, 40.0, f32::INFINITY),
            Transform::from_xyz(-0.6, 4.0, 0.8),
        );
        stage.spawn_light(light, place, Some(map(false)));
        let flying = Transform::from_xyz(8.0, 4.0, 0.8);
        let flying = spawn(&mut stage, MeshData::cuboid(Vec3::splat(0.3)), flying);
        for x in [8.0, 8.0, 100.0, 400.0, 8.0] {
            let mut at = stage
                .world
                .get_mut::<Transform>(flying)
                .expect("it stands somewhere");
            at.translation.x = x;
            let rendered = stage.render().expect("the frame renders");
            let dark = rendered.visibility[1].iter().filter(|seen| **seen < 0.5).count();
            assert!(dark > 50, "{format:?}, {x} m: {dark}");
            let both = rendered.visibility[0].iter().zip(&rendered.visibility[1]);
            let differ = both.filter(|(kept, drawn)| kept != drawn).count();
            assert_eq!(differ, 0, "{format:?}, {x} m");
        }
    }
}
