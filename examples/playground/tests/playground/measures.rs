//! Numbers at each pixel in false colours: they are those of the frame, and of every technique.

use antumbra::prelude::*;
use antumbra::reference::{HitImage, LightSource, RayScene, SurfaceHit, primary_hits};
use antumbra::sets::Objects;
use antumbra::techniques::{AddTechnique, Techniques};
use antumbra_playground::compare::Show;
use antumbra_playground::session::Session;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, UVec2};
use serde_json::{Value, json};

use super::harness::{PICTURE, different, models, opened, out, report, run, session_with};
use super::veil::Veil;

/// Opens a scene with lights, and shows a number of side A in both halves.
fn measured(name: &str, scene: &str, camera: &Value, lights: &Value, show: &str) -> Session {
    let shot = json!({"scene": models().join(scene), "camera": camera, "lights": lights});
    let path = out(name).join("shot.json");
    std::fs::write(&path, shot.to_string()).unwrap();
    let mut session = super::harness::session(name, PICTURE);
    assert!(session.app.open(&path), "{:?}", session.app.message);
    let show = json!({"do": "show", "left": show, "right": show});
    run(&mut session, &show.to_string());
    session
}

fn values(session: &Session, show: Show) -> (UVec2, Vec<f32>) {
    let compare = session.app.compare.as_ref().unwrap();
    let measured = compare.measured[show as usize].as_ref().unwrap();
    (measured.size, measured.values.clone())
}

/// Pixels that are looked at: every fifth in both directions.
fn some_pixels(size: UVec2) -> impl Iterator<Item = usize> {
    let rows = (2..size.y).step_by(5);
    rows.flat_map(move |y| (2..size.x).step_by(5).map(move |x| (y * size.x + x) as usize))
}

fn hits(session: &mut Session, size: UVec2) -> (RayScene, HitImage) {
    let stage = &mut session.app.compare.as_mut().unwrap().sides[0]
        .as_mut()
        .unwrap()
        .stage;
    let rays = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).unwrap();
    let place = stage.world.get::<GlobalTransform>(stage.camera).unwrap();
    let hits = primary_hits(&rays, camera, place, size).unwrap();
    (rays, hits)
}

/// Whether all neighbours of a pixel show its triangle, so that rounding at an edge does not matter.
fn is_inner(hits: &HitImage, pixel: usize) -> bool {
    let width = hits.size.x as usize;
    let triangle = |at: usize| {
        hits.hits
            .get(at)
            .copied()
            .flatten()
            .map(|hit: SurfaceHit| hit.triangle)
    };
    let around = [pixel - 1, pixel + 1, pixel - width, pixel + width];
    around.into_iter().all(|at| triangle(at) == triangle(pixel))
}

#[test]
fn lights_are_counted_as_the_sets_have_them_and_none_that_reaches_a_pixel_is_missing() {
    let light = |x: f32, z: f32, range: f32, technique: &str| {
        json!({"kind": "point", "position": [x, 1.6, z], "range": range, "intensity": 2,
               "shadow": {"technique": technique}})
    };
    let lights = json!([
        light(0.2, -0.4, 0.6, "stencil_volume"),
        light(0.0, 0.5, 2.0, "omni_map"),
        light(1.5, 0.0, 1.5, "penumbra_wedge"),
        light(0.5, -1.0, 8.0, "smoothie"),
    ]);
    let camera = json!({"eye": [0.0, 2.0, 2.2], "target": [0, 0.6, -0.5], "vfov_deg": 75});
    let mut session = measured(
        "lights-per-pixel",
        "room_office_small.glb",
        &camera,
        &lights,
        "lights_a",
    );
    let (size, counts) = values(&session, Show::LightsA);
    let (rays, hits) = hits(&mut session, size);
    let stage = &session.app.compare.as_ref().unwrap().sides[0]
        .as_ref()
        .unwrap()
        .stage;
    let objects = stage.world.resource::<Objects>();
    let lights = &stage.world.resource::<FrameLights>().lights;
    let (mut judged, mut seen) = (0, [0; 5]);
    for pixel in some_pixels(size).filter(|pixel| is_inner(&hits, *pixel)) {
        let Some(hit) = hits.hits[pixel] else { continue };
        let entity = rays.triangles()[hit.triangle as usize].entity.unwrap();
        let object = objects
            .entities
            .iter()
            .position(|known| *known == entity)
            .unwrap();
        let at = UVec2::new(pixel as u32 % size.x, pixel as u32 / size.x);
        let drawn = lights.iter().filter(|light| {
            light.sets.i.contains(object)
                && light.region.scissor.is_some_and(|scissor| {
                    (scissor.x..scissor.x + scissor.width).contains(&at.x)
                        && (scissor.y..scissor.y + scissor.height).contains(&at.y)
                })
        });
        let drawn = drawn.count();
        let reaching = stage.lights.iter().filter(|light| {
            LightSource::of_entity(&stage.world, **light).is_ok_and(|source| source.reaches(&hit))
        });
        assert_eq!(counts[pixel], drawn as f32, "pixel {at}");
        assert!(counts[pixel] >= reaching.count() as f32, "pixel {at}");
        judged += 1;
        seen[drawn.min(4)] += 1;
    }
    assert!(judged > 100, "{judged} pixels");
    assert!(seen.iter().filter(|pixels| **pixels > 3).count() >= 2, "{seen:?}");
    // A light that reaches nothing is not counted any more.
    run(
        &mut session,
        r#"{"do":"select","light":3}
        {"do":"light","key":"range","value":0.01}"#,
    );
    let fewer = values(&session, Show::LightsA).1;
    let change = counts
        .iter()
        .zip(&fewer)
        .filter(|(before, after)| before > after)
        .count();
    assert!(change > 1000, "{change} pixels have one light fewer");
    let known = report(&session)["measured"][0].clone();
    assert_eq!(known["title"], "Lights per pixel");
    assert!(known["mean"].as_f64().unwrap() > 0.1, "{known}");
}

/// Texels by which a picture of a cube goes beyond its face.
const GUARD: f64 = 2.0;

#[test]
fn texels_are_those_of_a_central_projection_at_every_pixel() {
    let resolution = 256.0_f64;
    let light = DVec3::new(0.3, 1.7, 0.3);
    let lights = json!([{"kind": "point", "position": light.to_array(), "intensity": 20,
        "shadow": {"technique": "omni_map", "resolution": resolution as u32}}]);
    let (eye, target) = (DVec3::new(0.9, 1.6, 1.2), DVec3::new(-0.4, 0.9, -0.9));
    let camera = json!({"eye": eye.to_array(), "target": target.to_array(), "vfov_deg": 70});
    let mut session = measured(
        "texels-per-pixel",
        "room_office_small.glb",
        &camera,
        &lights,
        "texels_a",
    );
    let (size, texels) = values(&session, Show::TexelsA);
    let (_, hits) = hits(&mut session, size);
    let pixel_side = 2.0 * 35.0_f64.to_radians().tan() / f64::from(size.y);
    let forward = (target - eye).normalize();
    let mut judged = 0;
    for pixel in some_pixels(size).filter(|pixel| is_inner(&hits, *pixel)) {
        let Some(hit) = hits.hits[pixel] else {
            assert!(texels[pixel].is_nan());
            continue;
        };
        // A surface of area A at p is A |n · p| / z³ on the plane at distance 1 of a projection along z.
        let (from_eye, from_light) = (hit.position - eye, hit.position - light);
        let steepest = [from_eye, from_light].map(|ray| hit.normal.dot(ray.normalize()).abs());
        if texels[pixel].is_nan() || steepest[0].min(steepest[1]) < 0.05 {
            continue; // the light is not drawn there, or the normal, packed into 16 bits, is too coarse
        }
        let z = from_eye.dot(forward);
        let area = pixel_side.powi(2) * z.powi(3) / hit.normal.dot(from_eye).abs();
        let depth = from_light.abs().max_element();
        let on_face = area * hit.normal.dot(from_light).abs() / depth.powi(3);
        let expected = on_face * (0.5 * (resolution - 2.0 * GUARD)).powi(2);
        let got = f64::from(texels[pixel]);
        assert!((got / expected - 1.0).abs() < 0.01, "{got} {expected}");
        judged += 1;
    }
    assert!(judged > 100, "{judged} pixels");
    let median = |session: &Session| report(session)["measured"][0]["median"].as_f64().unwrap();
    let before = median(&session);
    run(
        &mut session,
        r#"{"do":"set","side":"a","key":"resolution","value":512}"#,
    );
    let after = median(&session);
    assert!((after / before - 4.0).abs() < 0.1, "{before} {after}");
}

#[test]
fn halves_show_numbers_with_their_legend_and_a_word_where_there_are_none() {
    let mut techniques = Techniques::default();
    techniques.add_technique::<Veil>();
    let mut session = session_with(techniques, "legends", UVec2::new(900, 420));
    assert!(
        session.app.open(&super::harness::shot("legends")),
        "{:?}",
        session.app.message
    );
    run(
        &mut session,
        r#"{"do":"select","light":0}
        {"do":"technique","side":"a","name":"omni_map"}
        {"do":"technique","side":"b","name":"veil"}
        {"do":"show","left":"a","right":"a"}"#,
    );
    let plain = session.picture(Show::A).unwrap().1;
    let has = |session: &Session, text: &str| session.texts().any(|shown| shown.contains(text));
    assert!(!has(&session, "Texels per pixel"));
    run(
        &mut session,
        r#"{"do":"show","left":"texels_a","right":"lights_b"}"#,
    );
    for text in [
        "Texels per pixel",
        "median",
        "Lights per pixel",
        "most 2",
        "Texels of A",
        "Lights of B",
    ] {
        assert!(
            has(&session, text),
            "{text}: {:?}",
            session.texts().collect::<Vec<_>>()
        );
    }
    let texels = session.picture(Show::TexelsA).unwrap().1;
    assert!(different(&plain, &texels, 8) > 500);
    assert!(different(&texels, &session.picture(Show::LightsB).unwrap().1, 8) > 500);
    // The picture beside the numbers stays as it is.
    assert_eq!(session.picture(Show::A).unwrap().1, plain);
    // A technique of another crate has lights, and no map.
    run(
        &mut session,
        r#"{"do":"show","left":"texels_b","right":"lights_b"}"#,
    );
    assert!(has(&session, "looks up no map"));
    assert!(!has(&session, "Texels per pixel"));
    run(&mut session, r#"{"do":"select","light":null}"#);
    assert!(has(&session, "Select a light."));
}

#[test]
fn every_technique_with_a_picture_counts_its_texels() {
    let mut session = opened("texels-of-all", PICTURE);
    let names: Vec<&str> = session
        .app
        .techniques
        .rows()
        .iter()
        .map(|row| row.name())
        .collect();
    let mut counted = Vec::new();
    run(
        &mut session,
        r#"{"do":"show","left":"texels_a","right":"texels_a"}"#,
    );
    for name in names {
        for kind in ["point", "directional", "rect"] {
            let value = json!({"kind": kind, "position": [1.6, 1.8, 1.6], "direction": [-1, -1, -1], "intensity": 5,
                "width": 0.5, "height": 0.5, "shadow": {"technique": name}});
            let keys: Vec<&str> = match kind {
                "point" => vec!["kind", "position", "intensity", "shadow"],
                "directional" => vec!["kind", "direction", "intensity", "shadow"],
                _ => vec![
                    "kind",
                    "position",
                    "direction",
                    "intensity",
                    "width",
                    "height",
                    "shadow",
                ],
            };
            let value: serde_json::Map<String, Value> = keys
                .iter()
                .map(|key| ((*key).to_owned(), value[key].clone()))
                .collect();
            let techniques = session.app.techniques.clone();
            let light = antumbra_playground::document::LightDoc::new("light".to_owned(), value, &techniques);
            session.app.document.lights = Some(vec![light]);
            session.app.shown.selected = Some(0);
            session.frame().unwrap();
            let known = report(&session)["measured"][0].clone();
            if known["pixels"].as_u64().is_some_and(|pixels| pixels > 100) && !counted.contains(&name) {
                assert!(known["median"].as_f64().unwrap() > 0.0, "{name}: {known}");
                counted.push(name);
            }
        }
    }
    counted.sort_unstable();
    assert_eq!(
        counted,
        [
            "occlusion_texture",
            "omni_map",
            "perspective_map",
            "shadow_map",
            "smoothie"
        ],
        "occlusion interval maps must be baked, and volumes and wedges have no picture"
    );
}

#[test]
fn a_light_without_a_penumbra_has_no_error_in_it() {
    let mut session = opened("no_penumbra", PICTURE);
    run(
        &mut session,
        r#"{"do":"select","light":0}
        {"do":"truth","samples":2}"#,
    );
    let errors = report(&session)["errors"]["a"].clone();
    assert!(errors["rmse"].is_f64(), "{errors}");
    assert_eq!(errors["rmse_penumbra"], Value::Null);
}
