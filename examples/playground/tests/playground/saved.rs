//! Saved shots open again and equal the document that was saved.

use antumbra::scene::BlurredGround;
use antumbra_playground::compare::Show;
use antumbra_playground::session::Session;
use serde_json::{Value, json};

use crate::harness::{PICTURE, models, opened, out, run, session};

#[test]
fn what_is_saved_opens_again() {
    let mut session = opened("saved", PICTURE);
    run(
        &mut session,
        r#"{"do":"select","light":0}
        {"do":"technique","side":"a","name":"smoothie"}
        {"do":"set","side":"a","key":"width","value":{"share":0.05}}
        {"do":"light","key":"intensity","value":9}
        {"do":"save","side":"a","file":"again.json"}
        {"do":"picture","show":"a","file":"before.png"}
        {"do":"bevy","side":"a","file":"lights.rs"}"#,
    );
    let before = session.picture(Show::A).unwrap();
    let folder = out("saved");
    let code = std::fs::read_to_string(folder.join("lights.rs")).unwrap();
    assert!(code.contains("width: SmoothieWidth::Share(0.05),"), "{code}");
    assert!(
        session.app.open(&folder.join("again.json")),
        "{:?}",
        session.app.message
    );
    session.frame().unwrap();
    assert_eq!(session.picture(Show::A).unwrap(), before);
    assert!(folder.join("before.png").exists());
}

/// Grounds whose shadows are blurred, in the world of side A.
fn grounds(session: &mut Session) -> Vec<f32> {
    let compare = session.app.compare.as_mut().unwrap();
    let world = &mut compare.sides[0].as_mut().unwrap().stage.world;
    let mut all = world.query::<&BlurredGround>();
    all.iter(world).map(|ground| ground.radius).collect()
}

#[test]
fn nothing_of_a_shot_file_is_lost() {
    let folder = out("whole");
    let pictures = folder.join("pictures");
    std::fs::create_dir_all(&pictures).unwrap();
    let mut cookie = image::RgbImage::new(4, 4);
    cookie.put_pixel(1, 1, image::Rgb([255, 255, 255]));
    cookie.save(pictures.join("window.png")).unwrap();
    let shot = json!({
        "$schema": "schemas/shot.json",
        "scene": models().join("suzanne.glb"),
        "camera": {"eye": [0.3, 0.2, 2.5], "target": [0, 0, 0], "vfov_deg": 40, "near": 0.00002},
        "ambient": [0.00001, 0.02, 0.3],
        "blurred_grounds": [{"node": "mesh", "radius": 0.35}],
        "lights": [
            {"kind": "spot", "position": [0.0002, 2, 0.00000012], "direction": [0, -1, 0.3], "inner_deg": 20,
             "outer_deg": 30, "cookie": {"path": "pictures/window.png"}, "shadow": {"technique": "shadow_map"}},
            {"kind": "directional", "direction": [0, -1, 0.3], "path": {"axis": [0, 0, 1], "degrees": 90},
             "shadow": {"technique": "occlusion_interval", "maps": "baked"}},
        ],
    });
    let path = folder.join("shot.json");
    std::fs::write(&path, shot.to_string()).unwrap();
    let mut session = session("whole", PICTURE);
    assert!(session.app.open(&path), "{:?}", session.app.message);
    session.app.shown.panes = [Show::A, Show::A];
    session.frame().unwrap();
    assert_eq!(grounds(&mut session), [0.35]);
    let document = session.app.document.clone();
    run(
        &mut session,
        r#"{"do":"save","side":"a","file":"deeper/again.json"}"#,
    );
    let again = folder.join("deeper/again.json");
    let value: Value = serde_json::from_str(&std::fs::read_to_string(&again).unwrap()).unwrap();
    assert_eq!(value["blurred_grounds"], shot["blurred_grounds"]);
    assert_eq!(value["$schema"], "../schemas/shot.json");
    assert_eq!(value["camera"]["near"], 0.00002);
    assert_eq!(value["ambient"], shot["ambient"]);
    assert_eq!(value["lights"][0]["cookie"]["path"], "../pictures/window.png");
    assert_eq!(value["lights"][1]["shadow"]["maps"], "../baked");
    assert_eq!(value["lights"][1]["path"], shot["lights"][1]["path"]);
    assert!(session.app.open(&again), "{:?}", session.app.message);
    let reopened = &session.app.document;
    assert_eq!(reopened.view.map(|view| view.camera.near), Some(0.00002));
    assert_eq!(reopened.blurred_grounds, document.blurred_grounds);
    assert_eq!(reopened.lights().len(), 2);
    for key in ["position", "direction", "kind", "inner_deg"] {
        assert_eq!(
            reopened.lights()[0].keys.get(key),
            document.lights()[0].keys.get(key),
            "{key}"
        );
    }
    // A ground that is not there is an error, and the old scene stays.
    let mut wrong = shot.clone();
    wrong["blurred_grounds"][0]["node"] = json!("moon");
    std::fs::write(&path, wrong.to_string()).unwrap();
    assert!(!session.app.open(&path));
    let message = session.app.message.clone().unwrap().text;
    assert!(
        message.contains("shot.json: blurred_grounds[0].node"),
        "{message}"
    );
    session.frame().unwrap();
    assert_eq!(grounds(&mut session), [0.35]);
    // A scene without blurred grounds has none, and a schema on the web keeps its address.
    let mut plain = shot;
    plain["blurred_grounds"] = json!([]);
    plain["$schema"] = json!("https://example.org/shot.json");
    std::fs::write(&path, plain.to_string()).unwrap();
    assert!(session.app.open(&path));
    session.frame().unwrap();
    assert!(grounds(&mut session).is_empty());
    run(&mut session, r#"{"do":"save","side":"a","file":"plain.json"}"#);
    let plain = std::fs::read_to_string(folder.join("plain.json")).unwrap();
    assert!(
        plain.contains(r#""$schema": "https://example.org/shot.json""#),
        "{plain}"
    );
}
