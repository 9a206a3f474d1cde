//! Every technique and each of its settings is in the window, a stranger's as well.

use antumbra::techniques::{AddTechnique, Techniques};
use antumbra_playground::compare::Show;
use antumbra_playground::schema::label;
use antumbra_playground::session::Session;
use glam::UVec2;
use serde_json::{Value, json};

use crate::harness::{PICTURE, different, opened, report, run, session_with, shot};
use crate::veil::Veil;

/// High enough for all settings of any technique, with a narrow picture.
const HIGH: UVec2 = UVec2::new(600, 760);

fn with_a_stranger(name: &str, size: UVec2) -> Session {
    let mut techniques = Techniques::default();
    techniques.add_technique::<Veil>();
    let mut session = session_with(techniques, name, size);
    assert!(session.app.open(&shot(name)), "{:?}", session.app.message);
    session.app.shown.panes = [Show::A, Show::A];
    session.app.shown.selected = Some(1);
    session.frame().unwrap();
    session
}

fn shows(session: &Session, text: &str) -> bool {
    session.texts().any(|shown| shown == text)
}

#[test]
fn a_technique_is_chosen_from_a_menu_of_all() {
    let mut session = with_a_stranger("menu", HIGH);
    run(
        &mut session,
        r#"{"do":"technique","side":"b","name":"none"}
        {"do":"frames","count":2}"#,
    );
    assert!(!shows(&session, "Veil"), "the menu is closed");
    run(&mut session, r#"{"do":"click","text":"Penumbra wedge"}"#);
    for row in session.app.techniques.rows() {
        let name = label(row.name());
        assert!(shows(&session, &name), "{name} is not in the menu");
    }
    assert!(session.run_script(r#"{"do":"click","text":"Moon"}"#).is_err());
    run(&mut session, r#"{"do":"click","text":"Veil"}"#);
    assert_eq!(report(&session)["lights"][1]["technique"][0], "veil");
    assert!(shows(&session, "This technique does not describe its settings."));
}

#[test]
fn every_technique_changes_the_picture_or_says_why_not() {
    let mut session = with_a_stranger("techniques", PICTURE);
    let choose = |session: &mut Session, name: &str| {
        let line = json!({"do": "technique", "side": "a", "name": name});
        run(session, &line.to_string());
        session.picture(Show::A).unwrap().1
    };
    let none = choose(&mut session, "none");
    let names: Vec<&str> = session
        .app
        .techniques
        .rows()
        .iter()
        .map(|row| row.name())
        .collect();
    let mut drawn = Vec::new();
    for name in names {
        let picture = choose(&mut session, name);
        let changed = different(&none, &picture, 8);
        let light = &report(&session)["lights"][1];
        match light["error"].as_str() {
            None => {
                assert!(changed > 20, "{name} changes {changed} pixels");
                drawn.push(name);
            }
            Some(error) => assert!(
                changed == 0 && error.contains("shadow: "),
                "{name}: {changed} {error}"
            ),
        }
    }
    assert!(drawn.len() >= 6 && drawn.contains(&"veil"), "{drawn:?}");
}

#[test]
fn each_setting_of_each_technique_has_a_widget() {
    let mut session = with_a_stranger("widgets", HIGH);
    run(&mut session, r#"{"do":"technique","side":"b","name":"none"}"#);
    let names: Vec<&str> = session.app.schemas.technique_names().collect();
    let mut count = 0;
    for name in names {
        let Some(schema) = session.app.schemas.technique(name) else {
            assert_eq!(name, "veil");
            continue;
        };
        let keys: Vec<String> = schema["properties"]
            .as_object()
            .unwrap()
            .keys()
            .cloned()
            .collect();
        run(
            &mut session,
            &json!({"do": "technique", "side": "a", "name": name}).to_string(),
        );
        run(&mut session, r#"{"do":"frames","count":1}"#);
        for key in keys {
            assert!(shows(&session, &label(&key)), "{name} has no widget for {key}");
            count += 1;
        }
    }
    assert!(count > 40, "{count}");
    let choices = ["counting", "filter", "width"];
    for (technique, key) in ["stencil_volume", "shadow_map", "smoothie"]
        .into_iter()
        .zip(choices)
    {
        let schemas = &session.app.schemas;
        let property = &schemas.technique(technique).unwrap()["properties"][key];
        let form = schemas.form_of_some(property);
        assert!(
            matches!(&form, antumbra_playground::schema::Form::Choice(all) if all.len() > 1),
            "{technique}.{key}: {form:?}"
        );
    }
}

#[test]
fn a_choice_is_opened_and_taken() {
    let mut session = with_a_stranger("choice", HIGH);
    run(
        &mut session,
        r#"{"do":"technique","side":"b","name":"none"}
        {"do":"technique","side":"a","name":"omni_map"}
        {"do":"frames","count":2}
        {"do":"click","text":"Bilinear"}
        {"do":"click","text":"Jittered"}"#,
    );
    let shadow = &report(&session)["lights"][1]["value"]["shadow"];
    assert_eq!(shadow["filter"]["jittered"]["softness"], 0.01, "{shadow}");
    assert_eq!(report(&session)["lights"][1]["error"], Value::Null);
}

#[test]
fn a_scale_is_applied_once() {
    let mut session = opened("scale", PICTURE);
    let shown = |session: &Session| session.picture(Show::A).unwrap().0;
    let size = shown(&session);
    run(
        &mut session,
        r#"{"do":"size","to":[384,216]}
        {"do":"scale","to":3}
        {"do":"frames","count":2}"#,
    );
    // Heights of texts are rounded to pixels.
    let apart = shown(&session).as_ivec2() - 3 * size.as_ivec2();
    assert!(
        apart.abs().max_element() <= 6,
        "{size} becomes {}",
        shown(&session)
    );
    run(
        &mut session,
        r#"{"do":"scale","to":1}
        {"do":"size","to":[128,72]}
        {"do":"frames","count":2}"#,
    );
    assert_eq!(shown(&session), size);
}
