//! Changes of a light reach its entity; nothing is lost, and no component is left behind.

use antumbra::prelude::*;
use antumbra::scene::{BarnMap, LightShape};
use antumbra_playground::compare::Show;
use antumbra_playground::session::Session;
use bevy_ecs::prelude::*;
use serde_json::{Value, json};

use crate::harness::{PICTURE, opened, out, report, run};

/// Whether the entity of a light of a side has a component.
fn has<T: Component>(session: &Session, side: usize, light: usize) -> bool {
    let compare = session.app.compare.as_ref().unwrap();
    let stage = &compare.sides[side].as_ref().unwrap().stage;
    stage.world.get::<T>(stage.lights[light]).is_some()
}

fn set(session: &mut Session, key: &str, value: Value) {
    run(
        session,
        &json!({"do": "light", "key": key, "value": value}).to_string(),
    );
}

fn error(session: &Session, light: usize) -> Value {
    report(session)["lights"][light]["error"].clone()
}

#[test]
fn a_technique_comes_back_when_the_light_fits_it_again() {
    let mut session = opened("fits", PICTURE);
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"a"}
        {"do":"select","light":0}
        {"do":"technique","side":"a","name":"occlusion_texture"}"#,
    );
    assert!(
        error(&session, 0)
            .as_str()
            .unwrap()
            .contains("occlusion textures need")
    );
    assert!(!has::<OcclusionTexture>(&session, 0, 0) && !has::<StencilVolume>(&session, 0, 0));
    // The keys of the light change, and its technique does not.
    session.app.change_light("kind", 0, |light| {
        light.keys.insert("kind".to_owned(), json!("sphere"));
        light.keys.insert("radius".to_owned(), json!(0.2));
    });
    session.frame().unwrap();
    assert_eq!(error(&session, 0), Value::Null);
    assert!(has::<OcclusionTexture>(&session, 0, 0));
    set(&mut session, "intensity", json!(7));
    assert!(
        has::<OcclusionTexture>(&session, 0, 0),
        "other keys do not matter"
    );
    // A value that cannot be used, then the one before: the light is as it was.
    set(&mut session, "radius", json!(-1));
    assert!(error(&session, 0).is_string());
    set(&mut session, "radius", json!(0.2));
    assert_eq!(error(&session, 0), Value::Null);
    assert!(has::<OcclusionTexture>(&session, 0, 0));
}

#[test]
fn parts_of_the_light_model_go_with_their_keys() {
    let mut session = opened("model", PICTURE);
    let mut picture = image::RgbImage::new(2, 2);
    picture.put_pixel(0, 0, image::Rgb([255, 200, 100]));
    let path = out("model").join("panel.png");
    picture.save(&path).unwrap();
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"a"}
        {"do":"select","light":0}"#,
    );
    set(
        &mut session,
        "shape",
        json!({"width": 1, "height": 1, "width_edge": 0.5, "height_edge": 0.5}),
    );
    set(&mut session, "barn_map", json!({}));
    assert_eq!(error(&session, 0), Value::Null);
    assert!(has::<LightShape>(&session, 0, 0) && has::<BarnMap>(&session, 0, 0));
    set(&mut session, "barn_map", Value::Null);
    assert!(has::<LightShape>(&session, 0, 0) && !has::<BarnMap>(&session, 0, 0));
    set(&mut session, "shape", Value::Null);
    assert!(!has::<LightShape>(&session, 0, 0));
    run(&mut session, r#"{"do":"add","kind":"rect"}"#);
    run(
        &mut session,
        r#"{"do":"technique","side":"a","name":"penumbra_wedge"}"#,
    );
    type Texture = antumbra::techniques::penumbra_wedge::EmitterTexture;
    set(&mut session, "texture", json!(path));
    assert_eq!(error(&session, 2), Value::Null);
    assert!(has::<Texture>(&session, 0, 2));
    // A technique that shows no texture is drawn without, and says so.
    run(&mut session, r#"{"do":"technique","side":"a","name":"smoothie"}"#);
    assert!(error(&session, 2).as_str().unwrap().contains("texture: needs"));
    assert!(!has::<Texture>(&session, 0, 2) && has::<Smoothie>(&session, 0, 2));
    run(
        &mut session,
        r#"{"do":"technique","side":"a","name":"penumbra_wedge"}"#,
    );
    assert!(has::<Texture>(&session, 0, 2) && has::<PenumbraWedge>(&session, 0, 2));
    set(&mut session, "texture", Value::Null);
    assert!(!has::<Texture>(&session, 0, 2));
}

#[test]
fn a_light_on_a_path_is_compared_with_other_techniques() {
    let mut session = opened("path", PICTURE);
    run(
        &mut session,
        r#"{"do":"add","kind":"directional"}
        {"do":"technique","side":"b","name":"shadow_map"}
        {"do":"technique","side":"a","name":"occlusion_interval"}"#,
    );
    assert!(
        error(&session, 2).as_str().unwrap().contains("maps"),
        "they must be given"
    );
    run(
        &mut session,
        r#"{"do":"set","side":"a","key":"maps","value":"nowhere"}
        {"do":"set","side":"a","key":"time","value":0.5}"#,
    );
    set(&mut session, "path", json!({"axis": [0, 0, 1], "degrees": 90}));
    assert_eq!(error(&session, 2), Value::Null);
    assert!(has::<OcclusionInterval>(&session, 0, 2) && has::<LightPath>(&session, 0, 2));
    assert!(has::<ShadowMap>(&session, 1, 2) && !has::<LightPath>(&session, 1, 2));
    run(&mut session, r#"{"do":"frames","count":2}"#);
    let place = |side: usize| {
        let compare = session.app.compare.as_ref().unwrap();
        let stage = &compare.sides[side].as_ref().unwrap().stage;
        let place = stage
            .world
            .get::<bevy_transform::prelude::Transform>(stage.lights[2]);
        place.unwrap().rotation
    };
    assert_eq!(place(0), place(1), "both sides show the same moment");
    let start = session.app.document.lights()[2]
        .vector("direction")
        .unwrap()
        .normalize();
    assert!(
        (place(0) * glam::Vec3::NEG_Z).angle_between(start) > 0.5,
        "the light has moved"
    );
    // Maps that are not there are told beside the light.
    let reports = report(&session)["lights"][2]["reports"].to_string();
    assert!(reports.contains("nowhere"), "{reports}");
}

#[test]
fn times_are_those_of_the_sides_that_are_shown() {
    let mut session = opened("times", PICTURE);
    let count = |session: &Session| [0, 1].map(|side| session.app.times.frames[side].len());
    run(
        &mut session,
        r#"{"do":"times","on":true}
        {"do":"frames","count":3}"#,
    );
    let both = count(&session);
    assert!(both[0] >= 3 && both[1] >= 3, "{both:?}");
    session.app.shown.panes = [Show::A, Show::A];
    session.frame().unwrap();
    assert_eq!(count(&session), [both[0] + 1, 0]);
}
