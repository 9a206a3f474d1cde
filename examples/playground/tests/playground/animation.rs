//! Keys that are held or pressed, and an animation that plays.

use std::path::PathBuf;

use antumbra_playground::compare::Show;
use antumbra_playground::session::Session;
use glam::Vec3;
use serde_json::json;

use crate::harness::{PICTURE, different, opened, out, report, run, session, tetrahedron};

fn moving() -> PathBuf {
    let scene = tetrahedron("animation", |_| ());
    let folder = scene.parent().unwrap();
    let shot = json!({"scene": "moving.gltf", "camera": {"eye": [0, 0.5, 6], "target": [0, 0, 0]},
        "lights": [{"kind": "point", "position": [1, 3, 3], "intensity": 40,
            "shadow": {"technique": "stencil_volume"}}]});
    let path = folder.join("moving.json");
    std::fs::write(&path, shot.to_string()).unwrap();
    path
}

fn time(session: &Session) -> f64 {
    report(session)["time"].as_f64().unwrap_or(0.0)
}

#[test]
fn the_space_key_plays_the_animation_and_the_truth_waits_for_it() {
    let mut session = session("animation", PICTURE);
    assert!(session.app.open(&moving()), "{:?}", session.app.message);
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"a"}
        {"do":"frames","count":2}"#,
    );
    let still = session.picture(Show::A).unwrap().1;
    assert_eq!(time(&session), 0.0);
    run(
        &mut session,
        r#"{"do":"key","key":"Space"}
        {"do":"frames","count":12}"#,
    );
    assert!(session.app.shown.playing);
    assert!((time(&session) - 0.2).abs() < 0.03, "{}", time(&session));
    let moved = session.picture(Show::A).unwrap().1;
    assert!(different(&still, &moved, 20) > 100);
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"truth"}
        {"do":"frames","count":2}"#,
    );
    let waits = "The truth waits until the animation stops.";
    assert!(session.texts().any(|text| text == waits));
    run(
        &mut session,
        r#"{"do":"key","key":"Space"}
        {"do":"time","seconds":1.75}
        {"do":"truth","samples":4}
        {"do":"frames","count":1}"#,
    );
    assert!(!session.app.shown.playing);
    assert!((time(&session) - 0.75).abs() < 1e-4, "a clip repeats");
    assert!(!session.texts().any(|text| text == waits));
    // The truth is that of the pose.
    let (a, truth) = (
        session.picture(Show::A).unwrap().1,
        session.picture(Show::Truth).unwrap().1,
    );
    assert!(different(&a, &truth, 60) < 60, "{}", different(&a, &truth, 60));
    // The pose is saved.
    run(&mut session, r#"{"do":"save","side":"a","file":"posed.json"}"#);
    let text = std::fs::read_to_string(out("animation").join("posed.json")).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(value["animation"], json!({"clip": 0, "time": 0.75}));
    assert_eq!(value["scene"], "moving.gltf");
}

#[test]
fn keys_fly_edit_and_undo() {
    let mut session = opened("keys", PICTURE);
    let view = |session: &Session| session.app.document.view.unwrap();
    run(&mut session, r#"{"do":"pointer","to":[40,40]}"#);
    let start = view(&session);
    run(&mut session, r#"{"do":"hold","key":"W","frames":6}"#);
    let ahead = view(&session);
    let along = (ahead.eye - start.eye).dot(start.axes()[2]);
    assert!(along > 0.02, "{along}");
    assert!(
        (ahead.eye - start.eye - start.axes()[2] * along).length() < 1e-3,
        "straight ahead"
    );
    run(&mut session, r#"{"do":"hold","key":"D","frames":6}"#);
    assert!((view(&session).eye - ahead.eye).dot(start.axes()[0]) > 0.02);
    run(&mut session, r#"{"do":"key","key":"F"}"#);
    assert!(view(&session).target.distance(session.app.bounds.0) < 1e-4);
    let count = |session: &Session| session.app.document.lights().len();
    run(
        &mut session,
        r#"{"do":"select","light":0}
        {"do":"key","key":"D","ctrl":true}"#,
    );
    assert_eq!((count(&session), session.app.shown.selected), (3, Some(2)));
    run(&mut session, r#"{"do":"key","key":"Delete"}"#);
    assert_eq!(count(&session), 2);
    run(&mut session, r#"{"do":"key","key":"Z","ctrl":true}"#);
    assert_eq!(count(&session), 3);
    run(&mut session, r#"{"do":"key","key":"Y","ctrl":true}"#);
    assert_eq!(count(&session), 2);
    run(&mut session, r#"{"do":"key","key":"S","ctrl":true}"#);
    let message = report(&session)["message"].as_str().unwrap().to_owned();
    let path = message.strip_prefix("Written: ").expect("it says where");
    assert!(session.app.open(std::path::Path::new(path)));
    // The space key does nothing in a scene that stands still.
    run(&mut session, r#"{"do":"key","key":"Space"}"#);
    assert!(!session.app.shown.playing);
    let eye = view(&session).eye;
    assert!(eye.is_finite() && eye != Vec3::ZERO);
}
