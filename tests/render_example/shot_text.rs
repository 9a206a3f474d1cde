//! The text of a shot file, and what is said about a wrong one.

use antumbra::techniques::Techniques;
use antumbra_stage::shot::Shot;
use serde_json::{Value, json};

fn parse(text: &str) -> Result<Shot, String> {
    Shot::parse(text, Techniques::default())
}

fn error_of_light(light: Value) -> String {
    let shot = json!({"scene": "no.glb", "lights": [light]});
    parse(&shot.to_string()).expect_err("the light is wrong")
}

#[test]
fn a_byte_order_mark_is_skipped() {
    assert!(parse("\u{feff}{\"scene\": \"no.glb\"}").is_ok());
    assert!(parse("\u{feff}\u{feff}{\"scene\": \"no.glb\"}").is_err());
}

#[test]
fn a_missing_key_of_a_light_is_not_blamed_on_another() {
    let spot = error_of_light(json!({"kind": "spot", "position": [0, 1, 0], "direction": [0, -1, 0]}));
    assert!(spot.starts_with("lights[0]: missing field `inner_deg`"), "{spot}");
    let point = error_of_light(json!({"kind": "point"}));
    assert!(
        point.starts_with("lights[0]: missing field `position`"),
        "{point}"
    );
    // An error below a key still has it.
    let wrong = error_of_light(json!({"kind": "point", "position": [0, 1]}));
    assert!(wrong.starts_with("lights[0]: position: "), "{wrong}");
}

#[test]
fn the_shot_as_a_whole_has_no_name() {
    for (text, part) in [("", "EOF"), ("{}", "missing field `scene`")] {
        let error = parse(text).expect_err("it is no shot");
        assert!(error.starts_with(part), "{error}");
    }
    let nested = parse(r#"{"scene": "no.glb", "size": [1]}"#).expect_err("a number is missing");
    assert!(nested.starts_with("size"), "{nested}");
}

#[test]
fn a_time_that_overflows_is_refused() {
    let shot = |time: f64| json!({"scene": "no.glb", "animation": {"clip": 0, "time": time}}).to_string();
    let error = parse(&shot(1e39)).expect_err("it is infinite");
    assert!(error.starts_with("animation.time: inf"), "{error}");
    assert!(parse(&shot(1e38)).is_ok());
}

#[test]
fn fields_of_view_are_those_of_the_schema() {
    let shot = |degrees: f64| {
        json!({"scene": "no.glb", "camera": {"eye": [0, 0, 1], "target": [0, 0, 0], "vfov_deg": degrees}})
            .to_string()
    };
    for (degrees, is_good) in [(0.0, false), (0.5, true), (179.0, true), (180.0, false)] {
        assert_eq!(parse(&shot(degrees)).is_ok(), is_good, "{degrees}");
    }
    let schema = antumbra_stage::shot::shot_schema(&Techniques::default());
    let of_camera = &schema["$defs"]["ShotCamera"]["properties"]["vfov_deg"];
    assert_eq!(
        (&of_camera["exclusiveMinimum"], &of_camera["exclusiveMaximum"]),
        (&json!(0), &json!(180))
    );
}
