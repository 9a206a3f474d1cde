//! A document takes the places of lights and of the camera from its scene, in the scene's pose and with all digits.

use antumbra_playground::compare::Show;
use antumbra_playground::session::Session;
use glam::{EulerRot, Quat, Vec3};
use serde_json::{Value, json};

use crate::harness::{PICTURE, different, models, out, run, session, tetrahedron};

/// Adds a camera and a lamp to a scene, as children of the moving node or of none.
fn add(scene: &mut Value, moves: bool, camera: Value, lamp: Value) {
    scene["cameras"] = json!([{"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}]);
    scene["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    scene["extensions"]["KHR_lights_punctual"]["lights"] = json!([{"type": "point", "intensity": 40}]);
    let nodes = scene["nodes"].as_array_mut().unwrap();
    nodes.extend([camera, lamp]);
    if moves {
        scene["nodes"][0]["children"] = json!([1, 2]);
    } else {
        scene["scenes"][0]["nodes"] = json!([0, 1, 2]);
    }
}

fn lamp(at: [f64; 3]) -> Value {
    json!({"translation": at, "extensions": {"KHR_lights_punctual": {"light": 0}}})
}

/// Saves what a session shows, opens it again, and asserts that camera and lights are the same.
fn open_again(session: &mut Session, name: &str) {
    session.app.shown.panes = [Show::A, Show::A];
    session.frame().unwrap();
    let (document, shown) = (session.app.document.clone(), session.picture(Show::A).unwrap());
    run(session, r#"{"do":"save","side":"a","file":"again.json"}"#);
    let path = out(name).join("again.json");
    assert!(session.app.open(&path), "{:?}", session.app.message);
    let (before, after) = (document.view.unwrap(), session.app.document.view.unwrap());
    assert_eq!((after.eye, after.target), (before.eye, before.target));
    for (light, of_file) in document.lights().iter().zip(session.app.document.lights()) {
        assert_eq!(light.vector("position"), of_file.vector("position"));
    }
    session.frame().unwrap();
    let again = session.picture(Show::A).unwrap();
    assert_eq!(shown.0, again.0);
    let apart = different(&shown.1, &again.1, 3);
    assert!(apart < 20, "{apart} pixels differ");
}

#[test]
fn a_posed_scene_has_its_lights_and_its_camera_in_the_pose() {
    let name = "posed";
    let scene = tetrahedron(name, |scene| {
        add(
            scene,
            true,
            json!({"camera": 0, "translation": [0, 0.5, 6]}),
            lamp([1.0, 3.0, 3.0]),
        );
    });
    let shot = scene.with_file_name("posed.json");
    for (animation, x) in [(json!({"clip": 0, "time": 0.5}), 1.0), (Value::Null, 0.0)] {
        let text = json!({"scene": "moving.gltf", "animation": animation});
        std::fs::write(&shot, text.to_string()).unwrap();
        let mut session = session(name, PICTURE);
        assert!(session.app.open(&shot), "{:?}", session.app.message);
        let document = &session.app.document;
        let position = document.lights()[0].vector("position").unwrap();
        assert!(
            position.distance(Vec3::new(1.0 + x, 3.0, 3.0)) < 1e-5,
            "{position}"
        );
        let eye = document.view.unwrap().eye;
        assert!(eye.distance(Vec3::new(x, 0.5, 6.0)) < 1e-5, "{eye}");
        open_again(&mut session, name);
    }
}

#[test]
fn the_picture_is_turned_as_the_camera_of_the_scene() {
    for (name, rotation, eye) in [
        (
            "rolled",
            Quat::from_euler(EulerRot::YXZ, 0.2, -0.1, 0.5),
            [0.5, 0.3, 4.0],
        ),
        (
            "top",
            Quat::from_euler(EulerRot::YXZ, 0.5, -std::f32::consts::FRAC_PI_2, 0.0),
            [0.0, 5.0, 0.0],
        ),
    ] {
        let scene = tetrahedron(name, |scene| {
            let camera = json!({"camera": 0, "rotation": rotation.to_array(), "translation": eye});
            add(scene, false, camera, lamp([1.0, 3.0, 3.0]));
        });
        let mut session = session(name, PICTURE);
        assert!(session.app.open(&scene), "{:?}", session.app.message);
        session.frame().unwrap();
        let turned = |session: &Session| {
            let stage = &session.app.compare.as_ref().unwrap().sides[0]
                .as_ref()
                .unwrap()
                .stage;
            let place = stage
                .world
                .get::<bevy_transform::prelude::Transform>(stage.camera);
            let apart = |axis: Vec3| (place.unwrap().rotation * axis).distance(rotation * axis);
            apart(Vec3::Y).max(apart(Vec3::Z))
        };
        assert!(turned(&session) < 1e-4, "{name}: {}", turned(&session));
        open_again(&mut session, name);
        assert!(turned(&session) < 1e-4, "{name}, saved: {}", turned(&session));
    }
}

#[test]
fn places_far_from_the_origin_keep_all_their_digits() {
    let name = "far";
    let at = [412_345.0, 0.0, -254_321.0];
    let scene = tetrahedron(name, |scene| {
        // A node above the moving one takes it there.
        add(
            scene,
            true,
            json!({"camera": 0, "translation": [0.25, 0.5, 4]}),
            lamp([1.25, 3.0, 3.5]),
        );
        let nodes = scene["nodes"].as_array_mut().unwrap();
        nodes.push(json!({"children": [0], "translation": at}));
        scene["scenes"][0]["nodes"] = json!([3]);
    });
    let mut session = session(name, PICTURE);
    assert!(session.app.open(&scene), "{:?}", session.app.message);
    let position = |session: &Session| session.app.document.lights()[0].vector("position").unwrap();
    assert_eq!(position(&session), Vec3::new(412_346.25, 3.0, -254_317.5));
    run(
        &mut session,
        r#"{"do":"select","light":0}
        {"do":"move","by":[0.5,0.25,0.0]}"#,
    );
    assert_eq!(position(&session), Vec3::new(412_346.75, 3.25, -254_317.5));
    open_again(&mut session, name);
}

#[test]
fn a_shot_file_may_begin_with_a_byte_order_mark() {
    let path = out("mark").join("mark.json");
    let text = json!({"scene": models().join("suzanne.glb"), "size": [64, 32]});
    std::fs::write(&path, format!("\u{feff}{text}")).unwrap();
    let mut session = session("mark", PICTURE);
    assert!(session.app.open(&path), "{:?}", session.app.message);
}
