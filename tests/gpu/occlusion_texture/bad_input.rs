//! Lights without a size, scenes behind the light, no memory, settings that cannot be drawn: reports, and every value is a
//! visibility.

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::techniques::{OcclusionTexture, OcclusionTextures, Techniques, TextureMemory};
use bevy_transform::prelude::Transform;
use glam::{DVec3, Vec3};

use super::scenes::{empty, hits, lamp, plate, rendered, spawn, square, staged};
use crate::harness::strict_context;

fn messages(stage: &crate::harness::support::stage::Stage) -> Vec<String> {
    let reports = stage.world.resource::<Reports>();
    reports.iter().map(|report| report.message.clone()).collect()
}

fn assert_shares(values: &[f32], name: &str) {
    let wrong = values
        .iter()
        .filter(|value| !(0.0..=1.0).contains(*value))
        .count();
    assert_eq!(wrong, 0, "{name}");
}

/// A light without a size casts the hard shadow of its middle.
#[test]
fn lights_without_a_size_cast_hard_shadows() {
    let context = strict_context();
    for kind in [
        square(0.0),
        LightKind::Sphere { radius: 0.0 },
        LightKind::Directional,
    ] {
        let mut stage = staged(&context, &plate());
        let (light, place) = lamp(kind, Vec3::new(0.2, 3.0, 0.0));
        let settings = OcclusionTexture {
            angle_deg: 0.0,
            resolution: 512,
            ..Default::default()
        };
        stage.spawn_light(light, place, Some(settings));
        let got = rendered(&mut stage);
        assert_shares(&got, "hard");
        let (scene, hits) = hits(&mut stage);
        let source = antumbra::reference::LightSource::of_entity(&stage.world, stage.lights[0]);
        let truth = antumbra::reference::hard_visibility(&scene, &hits, &source.expect("a light"));
        let (mut dark, mut wrong) = (0, 0);
        for (truth, got) in truth
            .values()
            .iter()
            .zip(&got)
            .filter(|(truth, _)| !truth.is_nan())
        {
            dark += usize::from(*truth == 0.0);
            wrong += usize::from((truth - got).abs() > 0.5);
        }
        assert!(dark > 100 && wrong < 25, "{kind:?}: {wrong} wrong, {dark} dark");
    }
}

#[test]
fn scenes_behind_the_light_or_without_casters_are_lit() {
    let context = strict_context();
    let mut stage = staged(&context, &plate());
    // It shines up, away from everything but what it does not reach.
    let (light, mut place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
    place.rotate_x(std::f32::consts::PI);
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    assert!(rendered(&mut stage).iter().all(|value| *value == 1.0));
    for kind in [
        square(1.0),
        LightKind::Sphere { radius: 0.3 },
        LightKind::Directional,
    ] {
        let mut stage = empty(&context, Vec3::new(0.0, 2.0, 3.0));
        let (light, place) = lamp(kind, Vec3::new(0.0, 2.0, 0.0));
        stage.spawn_light(light, place, Some(OcclusionTexture::default()));
        assert!(
            rendered(&mut stage).iter().all(|value| *value == 1.0),
            "{kind:?}: nothing"
        );
        spawn(&mut stage, MeshData::plane(2.0), Transform::IDENTITY);
        let lonely = rendered(&mut stage);
        assert!(
            lonely.iter().all(|value| *value > 0.99),
            "{kind:?}: a ground alone"
        );
        assert_eq!(messages(&stage), [""; 0], "{kind:?}: a ground alone");
        let slices = &stage.world.resource::<OcclusionTextures>().lights[0];
        assert_eq!(slices.extent(), Vec3::ZERO, "{kind:?}: no casters");
        let over = spawn(
            &mut stage,
            MeshData::plane(0.4),
            Transform::from_xyz(0.0, 1.0, 0.0),
        );
        let shadowed = rendered(&mut stage);
        assert!(
            shadowed.iter().any(|value| *value < 0.5),
            "{kind:?}: a plate over it"
        );
        stage.world.despawn(over);
        // The light is inside of a caster, whose walls are all around it.
        let box_around = spawn(
            &mut stage,
            MeshData::cuboid(Vec3::splat(0.6)),
            Transform::from_xyz(0.0, 2.0, 0.0),
        );
        assert_shares(&rendered(&mut stage), "inside");
        stage.world.despawn(box_around);
    }
}

/// Casters that lie behind a light or in its plane shadow nothing, and a report says so. A ground is no reason for it.
#[test]
fn casters_in_the_plane_of_the_light_are_reported() {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::new(0.0, 2.0, 3.0));
    spawn(&mut stage, MeshData::plane(2.0), Transform::IDENTITY);
    let (light, place) = lamp(square(0.5), Vec3::new(0.0, 1.0, 0.0));
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    assert!(rendered(&mut stage).iter().all(|value| *value > 0.99));
    assert_eq!(messages(&stage), [""; 0]);
    spawn(
        &mut stage,
        MeshData::plane(0.2),
        Transform::from_xyz(0.6, 1.0, 0.0),
    );
    assert_shares(&rendered(&mut stage), "in the plane");
    let messages = messages(&stage);
    let told = messages
        .iter()
        .any(|text| text.contains("all casters lie behind it"));
    assert!(told, "{messages:?}");
}

/// Memory for few texels leaves a border around the casters that is empty at that resolution.
#[test]
fn coarse_pictures_keep_an_empty_border() {
    let context = strict_context();
    let mut stage = staged(&context, &plate());
    let (light, place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
    let settings = OcclusionTexture {
        resolution: 1024,
        ..Default::default()
    };
    stage.spawn_light(light, place, Some(settings));
    stage.world.resource_mut::<TextureMemory>().limit = 800_000;
    let got = rendered(&mut stage);
    let slices = &stage.world.resource::<OcclusionTextures>().lights[0];
    let (resolution, face) = (f64::from(slices.resolution), &slices.faces[0]);
    assert!((32.0..=64.0).contains(&resolution), "{resolution}");
    for corner in [(-0.4, -0.5), (0.6, 0.5)] {
        let corner = face.light_from_world(DVec3::new(corner.0, 1.0, corner.1));
        let border = (1.0 - face.project(corner).abs().max_element()) * 0.5 * resolution;
        assert!(border > 1.9, "{border} texels");
    }
    assert!(got.iter().any(|value| *value < 0.5));
}

#[test]
fn without_memory_the_light_has_no_shadow_and_a_report() {
    let context = strict_context();
    let mut stage = staged(&context, &plate());
    let (light, place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let shadowed = rendered(&mut stage);
    assert!(shadowed.iter().any(|value| *value < 0.5));
    stage.world.resource_mut::<TextureMemory>().limit = 2_000_000;
    let coarse = rendered(&mut stage);
    assert!(
        coarse.iter().any(|value| *value < 0.5),
        "a coarser shadow is left"
    );
    stage.world.resource_mut::<TextureMemory>().limit = 1000;
    assert!(rendered(&mut stage).iter().all(|value| *value == 1.0));
    let messages = messages(&stage);
    assert!(
        messages
            .iter()
            .any(|text| text.contains("memory for textures is short")),
        "{messages:?}"
    );
}

#[test]
fn settings_that_cannot_be_drawn_are_refused() {
    let techniques = Techniques::default();
    let row = techniques.named("occlusion_texture").expect("it is listed");
    let (light, _) = lamp(square(1.0), Vec3::Y);
    let refused = |json: &str, light: &Light| {
        let mut from = serde_json::Deserializer::from_str(json);
        match row.parse(&mut from) {
            Ok(settings) => settings.check(light).err().map(|error| error.to_string()),
            Err(error) => Some(error.to_string()),
        }
    };
    let good = r#"{"slices": 16, "resolution": 512, "filter": "summed_areas", "combine": "sum", "close_leaks": true}"#;
    assert_eq!(refused(good, &light), None);
    let bad = [
        (r#"{"slices": 17}"#, "slices is 17"),
        (r#"{"slices": 0}"#, "slices is 0"),
        (r#"{"resolution": 100}"#, "power of two"),
        (r#"{"weight": 2}"#, "weight is 2"),
        (r#"{"filter": "gauss"}"#, "n_buffers"),
        (r#"{"combine": "mean"}"#, "product"),
        (r#"{"close_leaks": "yes"}"#, "mask of layers"),
        (r#"{"slice": 4}"#, "unknown field"),
    ];
    for (json, part) in bad {
        let error = refused(json, &light).unwrap_or_default();
        assert!(error.contains(part), "{json}: {error}");
    }
    let sun = Light::directional(Vec3::ONE, 1.0);
    assert!(refused(r#"{"angle_deg": 180}"#, &sun).is_some_and(|error| error.contains("angle_deg is 180°")));
    for angle in ["-1", "200"] {
        let json = format!(r#"{{"angle_deg": {angle}}}"#);
        assert!(refused(&json, &light).is_some_and(|error| error.contains("angle_deg is")));
    }
    let point = Light::point(Vec3::ONE, 1.0, 5.0);
    assert!(refused("{}", &point).is_some_and(|error| error.contains("point light")));
}
