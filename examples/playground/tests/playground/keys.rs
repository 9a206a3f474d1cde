//! Keys that only some techniques take: they are saved only where the technique takes them, and settings show them.

use antumbra_playground::document::{Document, Side};
use antumbra_playground::session::Session;
use serde_json::{Value, json};

use crate::harness::{PICTURE, models, opened, out, report, run, session};

/// Opens a shot with one light.
fn lit_by(name: &str, light: &Value) -> Session {
    let path = out(name).join("shot.json");
    let shot = json!({"scene": models().join("suzanne.glb"), "lights": [light]});
    std::fs::write(&path, shot.to_string()).unwrap();
    let mut session = session(name, PICTURE);
    assert!(session.app.open(&path), "{:?}", session.app.message);
    run(&mut session, r#"{"do":"select","light":0}"#);
    session
}

/// Saves a side, checks that what was saved opens, and returns its light.
fn saved(session: &mut Session, name: &str, side: &str) -> Value {
    let file = json!({"do": "save", "side": side, "file": "saved.json"});
    run(session, &file.to_string());
    let path = out(name).join("saved.json");
    Document::load(&path, &session.app.techniques).unwrap();
    let value: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    value["lights"][0].clone()
}

#[test]
fn keys_that_the_technique_of_a_side_does_not_take_are_not_saved() {
    let picture = out("left_out").join("panel.png");
    let mut panel = image::RgbImage::new(2, 2);
    panel.put_pixel(0, 0, image::Rgb([255, 200, 100]));
    panel.save(&picture).unwrap();
    let mut session = lit_by(
        "left_out",
        &json!({"kind": "rect", "position": [2, 4, 1], "direction": [-2, -4, -1], "width": 1, "height": 1,
            "texture": picture, "shadow": {"technique": "penumbra_wedge"}}),
    );
    run(&mut session, r#"{"do":"technique","side":"b","name":"smoothie"}"#);
    assert!(saved(&mut session, "left_out", "a")["texture"].is_string());
    let light = saved(&mut session, "left_out", "b");
    assert_eq!(
        (&light["texture"], &light["shadow"]["technique"]),
        (&Value::Null, &json!("smoothie"))
    );
}

#[test]
fn a_light_that_leaves_its_path_is_saved_where_it_is_shown() {
    let shadow = json!({"technique": "occlusion_interval", "maps": "nowhere", "time": 0.3});
    let sun = json!({"kind": "directional", "path": {"latitude_deg": 50, "day": 172, "hours": [6, 18]}, "shadow": shadow});
    let mut session = lit_by("off_path", &sun);
    run(
        &mut session,
        r#"{"do":"technique","side":"b","name":"shadow_map"}
        {"do":"frames","count":2}"#,
    );
    assert_eq!(saved(&mut session, "off_path", "a")["path"], sun["path"]);
    let light = saved(&mut session, "off_path", "b");
    assert_eq!(light["path"], Value::Null);
    let direction: [f32; 3] = serde_json::from_value(light["direction"].clone()).unwrap();
    let stage = &session.app.compare.as_ref().unwrap().sides[1]
        .as_ref()
        .unwrap()
        .stage;
    let place = stage
        .world
        .get::<bevy_transform::prelude::Transform>(stage.lights[0]);
    let shown = place.unwrap().forward().as_vec3();
    assert!(
        shown.distance(direction.into()) < 1e-4,
        "{direction:?} is not {shown}"
    );
    // Without the path on side A, the light stands where its own keys put it.
    run(
        &mut session,
        r#"{"do":"technique","side":"a","name":"shadow_map"}"#,
    );
    assert!(saved(&mut session, "off_path", "a")["direction"].is_array());
}

#[test]
fn the_angle_of_a_light_is_a_setting_of_the_techniques_that_have_it() {
    let mut session = lit_by(
        "angle",
        &json!({"kind": "directional", "direction": [-1, -2, -1], "angle_deg": 5,
            "shadow": {"technique": "occlusion_texture"}}),
    );
    let of_side = |session: &Session, side: Side| {
        session.app.document.lights()[0].shadows[side.index()]
            .get("angle_deg")
            .cloned()
    };
    assert_eq!(of_side(&session, Side::A), Some(json!(5)));
    run(
        &mut session,
        r#"{"do":"set","side":"a","key":"angle_deg","value":3}"#,
    );
    assert_eq!(report(&session)["lights"][0]["error"], Value::Null);
    let light = saved(&mut session, "angle", "a");
    assert_eq!(
        (&light["angle_deg"], &light["shadow"]["angle_deg"]),
        (&Value::Null, &json!(3))
    );
    // A key that is given later is the newer one.
    run(&mut session, r#"{"do":"light","key":"angle_deg","value":4}"#);
    assert_eq!(of_side(&session, Side::A), Some(json!(4)));
    run(
        &mut session,
        r#"{"do":"technique","side":"a","name":"stencil_volume"}"#,
    );
    assert_eq!(report(&session)["lights"][0]["error"], Value::Null);
    let light = saved(&mut session, "angle", "a");
    assert_eq!(
        (&light["angle_deg"], &light["shadow"]["angle_deg"]),
        (&Value::Null, &Value::Null)
    );
    // An angle waits for a technique that takes it.
    run(
        &mut session,
        r#"{"do":"technique","side":"b","name":"none"}
        {"do":"light","key":"angle_deg","value":6}"#,
    );
    assert_eq!(saved(&mut session, "angle", "a")["angle_deg"], Value::Null);
    run(
        &mut session,
        r#"{"do":"technique","side":"b","name":"occlusion_texture"}"#,
    );
    assert_eq!(of_side(&session, Side::B), Some(json!(6)));
}

#[test]
fn a_shot_that_does_not_open_is_not_saved_in_silence() {
    let mut session = opened("faulty", PICTURE);
    run(
        &mut session,
        r#"{"do":"select","light":0}
        {"do":"light","key":"intensity","value":-3}"#,
    );
    let error = session
        .run_script(r#"{"do":"save","side":"a","file":"faulty.json"}"#)
        .unwrap_err();
    assert!(error.contains("it does not open: lights[0]"), "{error}");
    assert!(out("faulty").join("faulty.json").exists());
}
