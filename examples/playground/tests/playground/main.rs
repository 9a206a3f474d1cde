//! What a user does in the playground, done by scripts without a display.

mod animation;
mod cameras;
mod copied;
mod harness;
mod keys;
mod lights;
mod measures;
mod menus;
mod saved;

use std::path::Path;

use antumbra_playground::compare::Show;
use antumbra_playground::session::Session;
use glam::UVec2;
use serde_json::Value;

use harness::{PICTURE, WINDOW, apart, different, models, opened, out, report, run, session, shot};

#[path = "../../../../tests/veil/mod.rs"]
mod veil;

#[test]
fn a_divided_view_shows_both_techniques_and_only_their_halves_change() {
    let mut session = opened("divider", PICTURE);
    let whole = |session: &mut Session, show: Show, at: f32| {
        session.app.shown.panes = [show, show];
        session.app.shown.divider = at;
        session.frame().unwrap();
        session.pixels().unwrap()
    };
    run(&mut session, r#"{"do":"technique","side":"b","name":"none"}"#);
    let (a, b) = (
        whole(&mut session, Show::A, 0.5),
        whole(&mut session, Show::B, 0.5),
    );
    let changed = different(&a, &b, 8);
    assert!(changed > 100, "only {changed} pixels show the other technique");
    run(&mut session, r#"{"do":"show","left":"a","right":"b"}"#);
    let both = session.pixels().unwrap();
    let (width, height) = (PICTURE.x as usize, PICTURE.y as usize);
    for y in 24..height - 40 {
        for x in 0..width {
            // The divider itself is white in all of them.
            let expected = if x < width / 2 - 3 {
                &a
            } else if x > width / 2 + 3 {
                &b
            } else {
                continue;
            };
            let at = 4 * (y * width + x);
            assert_eq!(both[at..at + 4], expected[at..at + 4], "pixel {x}, {y}");
        }
    }
    run(&mut session, r#"{"do":"divider","at":0.25}"#);
    assert_eq!(report(&session)["divider"], 0.25);
    assert!(different(&both, &session.pixels().unwrap(), 8) > 20);
}

#[test]
fn settings_change_the_picture_and_undo_brings_it_back() {
    let mut session = opened("settings", PICTURE);
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"a"}
        {"do":"select","light":0}
        {"do":"technique","side":"a","name":"omni_map"}"#,
    );
    let picture = |session: &Session| session.picture(Show::A).unwrap().1;
    let before = picture(&session);
    run(
        &mut session,
        r#"{"do":"set","side":"a","key":"resolution","value":64}"#,
    );
    let coarse = picture(&session);
    assert!(different(&before, &coarse, 4) > 10);
    run(&mut session, r#"{"do":"move","by":[0.5,0.0,0.0]}"#);
    let moved = picture(&session);
    assert!(different(&coarse, &moved, 4) > 10);
    run(&mut session, r#"{"do":"undo"}"#);
    assert_eq!(picture(&session), coarse);
    run(&mut session, r#"{"do":"undo"}"#);
    assert_eq!(picture(&session), before);
    run(
        &mut session,
        r#"{"do":"redo"}
        {"do":"redo"}"#,
    );
    assert_eq!(picture(&session), moved);
    // A setting that cannot be used is told beside the light, and the light keeps what it had.
    run(&mut session, r#"{"do":"set","side":"a","key":"near","value":-3}"#);
    let known = report(&session);
    assert!(
        known["lights"][0]["error"].as_str().unwrap().contains("near"),
        "{known}"
    );
    run(
        &mut session,
        r#"{"do":"set","side":"a","key":"softness_of_bread","value":1}"#,
    );
    let error = report(&session)["lights"][0]["error"].clone();
    assert!(error.as_str().unwrap().contains("softness_of_bread"), "{error}");
}

#[test]
fn lights_are_added_copied_and_deleted() {
    let mut session = opened("lights", PICTURE);
    let kinds: Vec<String> = session
        .app
        .schemas
        .light_kinds()
        .into_iter()
        .map(str::to_owned)
        .collect();
    assert_eq!(kinds.len(), 5);
    for kind in &kinds {
        run(
            &mut session,
            &serde_json::json!({"do": "add", "kind": kind}).to_string(),
        );
        let known = report(&session);
        let index = known["selected"].as_u64().unwrap() as usize;
        assert_eq!(known["lights"][index]["value"]["kind"], kind.as_str());
        assert_eq!(known["lights"][index]["error"], Value::Null, "{known:#}");
    }
    run(
        &mut session,
        r#"{"do":"duplicate"}
        {"do":"delete"}
        {"do":"delete"}
        {"do":"undo"}"#,
    );
    assert_eq!(report(&session)["lights"].as_array().unwrap().len(), 7);
    for _ in 0..9 {
        run(&mut session, r#"{"do":"delete"}"#);
    }
    assert_eq!(
        report(&session)["lights"].as_array().unwrap().len(),
        0,
        "and a scene without lights is drawn"
    );
}

#[test]
fn the_truth_judges_both_sides() {
    let mut session = opened("truth", PICTURE);
    run(
        &mut session,
        r#"{"do":"select","light":1}
        {"do":"technique","side":"b","name":"none"}
        {"do":"show","left":"error_a","right":"truth"}
        {"do":"truth","samples":20}
        {"do":"show","left":"a","right":"b"}
        {"do":"frames","count":2}"#,
    );
    let known = report(&session);
    assert_eq!(known["samples"], 20);
    let rmse = |side: &str| known["errors"][side]["rmse"].as_f64().unwrap();
    assert!(known["errors"]["a"]["rmse_penumbra"].is_f64(), "{known:#}");
    assert!(rmse("a") < 0.1, "{known:#}");
    assert!(
        rmse("b") > 2.0 * rmse("a"),
        "a light without shadows is worse: {known:#}"
    );
    // The truth is the same picture but for what the techniques do wrong.
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"truth"}
        {"do":"frames","count":2}"#,
    );
    let (a, truth) = (
        session.picture(Show::A).unwrap().1,
        session.picture(Show::Truth).unwrap().1,
    );
    let far = apart(&a, &truth);
    run(
        &mut session,
        r#"{"do":"show","left":"b","right":"truth"}
        {"do":"frames","count":1}"#,
    );
    let none = apart(&session.picture(Show::B).unwrap().1, &truth);
    assert!(far < 0.6 * none, "{far} with shadows, {none} without");
    // What is seen changes: the truth begins again.
    run(&mut session, r#"{"do":"orbit","by":[20,0]}"#);
    assert_ne!(report(&session)["samples"], 20);
}

#[test]
fn a_light_is_picked_and_dragged_in_the_picture() {
    let mut session = opened("drag", PICTURE);
    // The camera is far enough that both lights are in view.
    run(
        &mut session,
        r#"{"do":"dolly","factor":2.0}
        {"do":"select","light":null}
        {"do":"point_light","light":1}
        {"do":"press"}
        {"do":"release"}"#,
    );
    assert_eq!(report(&session)["selected"], 1);
    let position = |session: &Session| session.app.document.lights()[1].vector("position").unwrap();
    let before = position(&session);
    run(
        &mut session,
        r#"{"do":"point_light","light":1}
        {"do":"press"}
        {"do":"point_light","light":1,"offset":[12,-6]}
        {"do":"point_light","light":1,"offset":[6,-3]}
        {"do":"release"}"#,
    );
    let after = position(&session);
    assert!(after.distance(before) > 0.1, "{before} is {after}");
    run(&mut session, r#"{"do":"undo"}"#);
    assert_eq!(position(&session), before, "a drag is undone in one step");
    // Beside a light, the camera moves.
    let eye = session.app.document.view.unwrap().eye;
    run(
        &mut session,
        r#"{"do":"pointer","to":[8,60]}
        {"do":"press"}
        {"do":"pointer","to":[30,50]}
        {"do":"pointer","to":[36,50]}
        {"do":"release"}"#,
    );
    assert!(session.app.document.view.unwrap().eye.distance(eye) > 0.05);
    assert_eq!(position(&session), before);
}

#[test]
fn bad_input_is_told_and_nothing_is_lost() {
    let mut session = opened("bad", WINDOW);
    let folder = out("bad");
    let before = session.picture(Show::A).unwrap().1;
    for (name, text) in [
        ("broken.glb", "no model"),
        ("broken.json", "{"),
        ("notes.txt", "to do"),
        ("missing.json", r#"{"scene": "nowhere.glb"}"#),
        ("unknown.json", r#"{"scene": "a.glb", "moon": 1}"#),
    ] {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        session.app.message = None;
        assert!(!session.app.open(&path));
        session.frame().unwrap();
        let known = report(&session);
        assert_eq!(known["is_error"], true, "{name}");
        assert!(!known["message"].as_str().unwrap().contains('\n'));
        assert_eq!(
            session.picture(Show::A).unwrap().1,
            before,
            "{name}: the old scene stays"
        );
    }
    let good = shot("bad");
    let both = serde_json::json!({"do": "drop", "paths": [good, folder.join("broken.glb")]});
    run(&mut session, &both.to_string());
    assert!(
        report(&session)["message"]
            .as_str()
            .unwrap()
            .contains("Of 2 files")
    );
    for size in ["[1,1]", "[8192,12]", "[760,300]"] {
        run(&mut session, &format!(r#"{{"do":"size","to":{size}}}"#));
        assert_ne!(report(&session)["is_error"], true, "{size}");
    }
    assert_eq!(
        session.picture(Show::A).unwrap().1,
        before,
        "the size is what it was"
    );
    run(
        &mut session,
        r#"{"do":"lose_device"}
        {"do":"frames","count":1}"#,
    );
    assert_eq!(session.picture(Show::A).unwrap().1, before, "on the new device");
    assert!(
        session
            .run_script(r#"{"do":"dance"}"#)
            .unwrap_err()
            .starts_with("line 1: ")
    );
    assert!(session.run_script(r#"{"do":"key","key":"no key"}"#).is_err());
}

#[test]
fn five_hundred_lights_are_listed_and_drawn() {
    let scene = models().join("suzanne.glb");
    let light = |index: usize| {
        let (sin, cos) = (index as f32).sin_cos();
        serde_json::json!({"kind": "point", "position": [2.0 * cos, 1.0, 2.0 * sin], "range": 3, "intensity": 0.02,
            "shadow": {"technique": "none"}})
    };
    let text = serde_json::json!({"scene": scene, "lights": (0..500).map(light).collect::<Vec<_>>()});
    let path = out("many").join("many.json");
    std::fs::write(&path, text.to_string()).unwrap();
    let mut session = session("many", WINDOW);
    assert!(session.app.open(&path), "{:?}", session.app.message);
    run(
        &mut session,
        r#"{"do":"show","left":"a","right":"a"}
        {"do":"select","light":499}"#,
    );
    let known = report(&session);
    assert_eq!(known["is_error"], false, "{known}");
    assert!(
        session
            .picture(Show::A)
            .unwrap()
            .1
            .chunks(4)
            .any(|pixel| pixel[0] > 40)
    );
}

#[test]
fn the_window_shows_its_panels_help_and_times() {
    let mut session = opened("panels", UVec2::new(900, 330));
    let plain = session.pixels().unwrap();
    let corner = |pixels: &[u8], from: UVec2, to: UVec2| -> Vec<u8> {
        let rows = (from.y..to.y).flat_map(|y| (from.x..to.x).map(move |x| (y * 900 + x) as usize * 4));
        rows.flat_map(|at| pixels[at..at + 4].to_vec()).collect()
    };
    // Selecting another light changes the panels at both sides.
    run(&mut session, r#"{"do":"select","light":1}"#);
    let other = session.pixels().unwrap();
    for (from, to) in [([0, 40], [260, 300]), ([610, 40], [900, 300])] {
        let (from, to) = (UVec2::from(from), UVec2::from(to));
        assert!(different(&corner(&plain, from, to), &corner(&other, from, to), 20) > 50);
    }
    run(
        &mut session,
        r#"{"do":"key","key":"F1"}
        {"do":"frames","count":2}"#,
    );
    assert!(
        different(&other, &session.pixels().unwrap(), 20) > 2000,
        "the help is open"
    );
    run(
        &mut session,
        r#"{"do":"key","key":"Escape"}
        {"do":"frames","count":8}
        {"do":"show","left":"a","right":"a"}
        {"do":"times","on":true}
        {"do":"frames","count":3}"#,
    );
    let known = report(&session);
    let passes = known["gpu_ms"]["a"].as_object().unwrap();
    assert!(
        passes.len() > 2 && passes.values().all(|time| time.as_f64().unwrap() >= 0.0),
        "{known:#}"
    );
    assert!(
        different(&other, &session.pixels().unwrap(), 20) > 1000,
        "the graph is open"
    );
    for (name, least) in [
        ("sets", 20),
        ("silhouettes", 20),
        ("region", 20),
        ("hulls", 20),
        ("technique", 20),
    ] {
        let shown = session.pixels().unwrap();
        run(
            &mut session,
            &format!(r#"{{"do":"overlay","name":"{name}","on":true}}"#),
        );
        assert!(
            different(&shown, &session.pixels().unwrap(), 20) > least,
            "{name}"
        );
        run(
            &mut session,
            &format!(r#"{{"do":"overlay","name":"{name}","on":false}}"#),
        );
    }
}

#[test]
fn a_script_without_a_display_draws_its_pictures() {
    let folder = out("program");
    let script = folder.join("script.jsonl");
    std::fs::write(
        &script,
        "# a comment\n\n{\"do\":\"screenshot\",\"file\":\"window.png\"}\n",
    )
    .unwrap();
    let (scene, folder) = (shot("program"), folder.display().to_string());
    let (scene, script) = (scene.display().to_string(), script.display().to_string());
    let done = playground(&[&scene, "--script", &script, "--out", &folder, "--size", "600x300"]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let picture = image::open(Path::new(&folder).join("window.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (600, 300));
    for wrong in [
        vec!["nowhere.glb", "--script", &script, "--out", &folder],
        vec![&scene],
    ] {
        let failed = playground(&wrong);
        let text = String::from_utf8_lossy(&failed.stderr).into_owned();
        assert_eq!(
            (failed.status.code(), text.lines().count()),
            (Some(1), 1),
            "{text}"
        );
    }
}

/// The program, without a display.
fn playground(arguments: &[&str]) -> std::process::Output {
    let mut command = std::process::Command::new(env!("CARGO_BIN_EXE_antumbra_playground"));
    command
        .args(arguments)
        .env_remove("DISPLAY")
        .env_remove("WAYLAND_DISPLAY");
    command.output().unwrap()
}

/// Returns by how many MiB the memory of the program grows while it drags the first light of a scene for sixty frames.
fn grown(scene: &Path, name: &str, size: UVec2) -> u64 {
    let moves = |frames: usize| -> String {
        let by = |frame: usize| if frame % 20 < 10 { 0.02 } else { -0.02 };
        let lines = (0..frames).map(|frame| format!("{{\"do\":\"move\",\"by\":[{},0,0]}}\n", by(frame)));
        lines.collect()
    };
    let report = |name: &str| format!("{{\"do\":\"report\",\"file\":\"{name}.json\"}}\n");
    let folder = out(name);
    let script = folder.join("script.jsonl");
    let text = [moves(20), report("before"), moves(60), report("after")].concat();
    std::fs::write(&script, text).unwrap();
    let (scene, script) = (scene.display().to_string(), script.display().to_string());
    let (target, size) = (folder.display().to_string(), format!("{}x{}", size.x, size.y));
    let done = playground(&[&scene, "--script", &script, "--out", &target, "--size", &size]);
    assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
    let known = |name: &str| -> Value {
        let text = std::fs::read_to_string(folder.join(format!("{name}.json"))).unwrap();
        serde_json::from_str(&text).unwrap()
    };
    let (before, after) = (known("before"), known("after"));
    assert_eq!(after["is_error"], false, "{after:#}");
    let bytes = |known: &Value| known["memory_bytes"].as_u64().unwrap();
    bytes(&after).saturating_sub(bytes(&before)) >> 20
}

/// In a process of its own, whose memory no other test uses.
#[test]
fn dragging_a_light_for_sixty_frames_keeps_the_memory() {
    let grown = grown(&shot("memory"), "memory", PICTURE);
    assert!(grown < 16, "memory grew by {grown} MiB");
}

#[test]
#[ignore = "minutes on a software rasterizer"] // the picture has 640 × 360 pixels beside the panels
fn dragging_a_light_of_the_interior_keeps_the_memory_by_hand() {
    let grown = grown(&models().join("interior.glb"), "interior", UVec2::new(1214, 420));
    println!("memory grew by {grown} MiB");
    assert!(grown < 32, "memory grew by {grown} MiB");
}
