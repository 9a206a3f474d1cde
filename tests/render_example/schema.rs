//! The JSON Schema of shot files is that of the types, and the shot files of the repository fit it.

use std::path::Path;

use antumbra::techniques::{AddTechnique, Techniques};
use antumbra_stage::shot::shot_schema;
use serde_json::{Value, json};

use crate::veil::Veil;

/// The file, relative to the repository.
const FILE: &str = "examples/shots/schema.json";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_schema_file_is_that_of_the_types() {
    let path = root().join(FILE);
    let schema = format!("{:#}\n", shot_schema(&Techniques::default()));
    if std::env::var_os("ANTUMBRA_WRITE_SCHEMA").is_some() {
        std::fs::write(&path, &schema).unwrap();
    }
    let file = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(
        file == schema,
        "{FILE} is old; write it with ANTUMBRA_WRITE_SCHEMA=1 cargo test --features bevy,gltf,reference --test \
         render_example schema_file"
    );
}

#[test]
fn a_technique_of_somebody_else_is_in_the_schema_without_a_line_of_it() {
    let names = |schema: &Value| -> Vec<String> {
        let all = schema["$defs"]["ShotShadow"]["oneOf"].as_array().unwrap();
        let name = |one: &Value| {
            one["properties"]["technique"]["const"]
                .as_str()
                .unwrap()
                .to_owned()
        };
        all.iter().map(name).collect()
    };
    let mut techniques = Techniques::default();
    let before = names(&shot_schema(&techniques));
    assert_eq!(
        before.len(),
        techniques.rows().len() + 1,
        "all techniques and `none`"
    );
    techniques.add_technique::<Veil>();
    let after = names(&shot_schema(&techniques));
    assert_eq!(after.last().map(String::as_str), Some("veil"));
    assert_eq!(after.len(), before.len() + 1);
}

/// Returns why a value does not fit a schema, by the keywords that the schema of shots has.
fn fault(root: &Value, schema: &Value, value: &Value) -> Option<String> {
    if let Some(name) = schema.get("$ref").and_then(Value::as_str) {
        let inner = root.pointer(name.trim_start_matches('#')).unwrap();
        return fault(root, inner, value);
    }
    for key in ["oneOf", "anyOf"] {
        if let Some(all) = schema.get(key).and_then(Value::as_array) {
            let fitting = all.iter().filter(|one| fault(root, one, value).is_none()).count();
            if fitting == 0 || (key == "oneOf" && fitting > 1) {
                return Some(format!("{value} fits {fitting} of {key}"));
            }
        }
    }
    if let Some(all) = schema.get("allOf").and_then(Value::as_array)
        && let Some(fault) = all.iter().find_map(|one| fault(root, one, value))
    {
        return Some(fault);
    }
    if schema.get("const").is_some_and(|only| only != value) {
        return Some(format!("{value} is not {}", schema["const"]));
    }
    if let Some(all) = schema.get("enum").and_then(Value::as_array)
        && !all.contains(value)
    {
        return Some(format!("{value} is none of {all:?}"));
    }
    let is = |name: &Value| match name.as_str() {
        Some("object") => value.is_object(),
        Some("array") => value.is_array(),
        Some("string") => value.is_string(),
        Some("number") => value.is_number(),
        Some("integer") => value.is_u64() || value.is_i64(),
        Some("boolean") => value.is_boolean(),
        Some("null") => value.is_null(),
        _ => panic!("unknown type {name}"),
    };
    match schema.get("type") {
        Some(Value::Array(names)) if !names.iter().any(is) => {
            return Some(format!("{value} is not {names:?}"));
        }
        Some(name @ Value::String(_)) if !is(name) => return Some(format!("{value} is not {name}")),
        _ => {}
    }
    let number = |key: &str| schema.get(key).and_then(Value::as_f64);
    if let Some(value) = value.as_f64()
        && (number("minimum").is_some_and(|least| value < least)
            || number("maximum").is_some_and(|most| value > most)
            || number("exclusiveMinimum").is_some_and(|bound| value <= bound)
            || number("exclusiveMaximum").is_some_and(|bound| value >= bound))
    {
        return Some(format!("{value} is out of bounds"));
    }
    if let (Some(all), Some(items)) = (value.as_array(), schema.get("items")) {
        let length = |key: &str| schema.get(key).and_then(Value::as_u64);
        let count = all.len() as u64;
        if length("minItems").is_some_and(|least| count < least)
            || length("maxItems").is_some_and(|most| count > most)
        {
            return Some(format!("{value} has {count} items"));
        }
        return all.iter().find_map(|item| fault(root, items, item));
    }
    let object = value.as_object()?;
    let required = schema.get("required").and_then(Value::as_array);
    for key in required.into_iter().flatten().filter_map(Value::as_str) {
        if !object.contains_key(key) {
            return Some(format!("no {key}"));
        }
    }
    let properties = schema.get("properties");
    for (key, value) in object {
        match properties.and_then(|properties| properties.get(key)) {
            Some(property) => {
                if let Some(fault) = fault(root, property, value) {
                    return Some(format!("{key}: {fault}"));
                }
            }
            None if schema.get("additionalProperties") == Some(&json!(false)) => {
                return Some(format!("unknown key {key}"));
            }
            None => {}
        }
    }
    None
}

#[test]
fn the_shots_fit_the_schema_and_wrong_ones_do_not() {
    let schema = shot_schema(&Techniques::default());
    let shots = root().join("examples/shots");
    let mut count = 0;
    for folder in [shots.clone(), shots.join("uberlight")] {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() || path.ends_with("schema.json") {
                continue;
            }
            let shot: Value = serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
            assert_eq!(fault(&schema, &schema, &shot), None, "{}", path.display());
            let named = path.parent().unwrap().join(shot["$schema"].as_str().unwrap());
            assert!(named.exists(), "{} names no schema", path.display());
            count += 1;
        }
    }
    assert!(count > 5);
    let with = |shadow: Value| {
        let light = json!({"kind": "point", "position": [0, 1, 0], "shadow": shadow});
        let shot = json!({"scene": "a.glb", "lights": [light]});
        fault(&schema, &schema, &shot)
    };
    for right in [
        json!({"technique": "none"}),
        json!({"technique": "omni_map", "filter": "jittered", "softness": 0.02}),
        json!({"technique": "omni_map", "filter": {"soft_4": {"softness": 0.02}}, "resolution": 512, "bias": null}),
        json!({"technique": "occlusion_texture", "filter": "mipmaps", "resolution": 64, "close_leaks": true}),
        json!({"technique": "occlusion_interval", "maps": "maps"}),
        json!({"technique": "smoothie", "width": {"share": 0.02}, "resolution": {"least": 64, "most": 128}}),
    ] {
        assert_eq!(with(right.clone()), None, "{right}");
    }
    for wrong in [
        json!({"technique": "penumbra_wedge", "split": [9, 1]}),
        json!({"technique": "penumbra_wedge", "split": [1]}),
        json!({"technique": "nothing_like_it"}),
        json!({"technique": "omni_map", "filter": "sharp"}),
        json!({"technique": "omni_map", "near": -1}),
        json!({"technique": "stencil_volume", "split": [1, 1]}),
        json!({"technique": "shadow_map", "cascades": {"count": 1.5}}),
        json!({"technique": "occlusion_texture", "filter": "jittered"}),
        json!({"technique": "occlusion_texture", "softness": 0.02}),
        json!({"technique": "occlusion_texture", "resolution": 300}),
        json!({"technique": "occlusion_interval"}),
    ] {
        assert!(with(wrong.clone()).is_some(), "{wrong}");
    }
}

#[test]
fn a_path_stands_for_the_direction_or_the_position_of_a_light() {
    let schema = shot_schema(&Techniques::default());
    let with = |light: Value| fault(&schema, &schema, &json!({"scene": "a.glb", "lights": [light]}));
    for right in [
        json!({"kind": "directional", "path": {"latitude_deg": 50, "day": 366}}),
        json!({"kind": "directional", "direction": [0, -1, 0], "path": {"axis": [0, 0, 1], "degrees": 90}}),
        json!({"kind": "point", "path": {"positions": [[0, 1, 0], [2, 1, 0]]}}),
        json!({"kind": "directional", "direction": [0, -1, 0]}),
    ] {
        assert_eq!(with(right.clone()), None, "{right}");
    }
    for wrong in [
        json!({"kind": "directional"}),
        json!({"kind": "directional", "path": {"axis": [0, 0, 1], "degrees": 90}}),
        json!({"kind": "directional", "path": {"latitude_deg": 50, "day": 367}}),
        json!({"kind": "point", "path": {"latitude_deg": 50, "day": 3}}),
        json!({"kind": "sphere", "position": [0, 0, 0], "radius": 1, "path": {"positions": [[0, 1, 0], [2, 1, 0]]}}),
    ] {
        assert!(with(wrong.clone()).is_some(), "{wrong}");
    }
}

/// Collects the names of all properties of a schema.
fn properties<'a>(schema: &'a Value, to: &mut std::collections::BTreeSet<&'a str>) {
    match schema {
        Value::Object(all) => {
            if let Some(Value::Object(own)) = all.get("properties") {
                to.extend(own.keys().map(String::as_str));
            }
            all.values().for_each(|inner| properties(inner, to));
        }
        Value::Array(all) => all.iter().for_each(|inner| properties(inner, to)),
        _ => {}
    }
}

#[test]
fn the_guide_names_every_property_of_the_schema() {
    let guide = std::fs::read_to_string(root().join("src/guide/shot_file.md")).unwrap();
    let schema = shot_schema(&Techniques::default());
    let mut all = std::collections::BTreeSet::new();
    properties(&schema, &mut all);
    assert!(all.len() > 80, "{} properties", all.len());
    let is_named =
        |name: &&&str| guide.contains(&format!("`{name}`")) || guide.contains(&format!("\"{name}\""));
    let missing: Vec<_> = all.iter().filter(|name| !is_named(name)).collect();
    assert!(
        missing.is_empty(),
        "src/guide/shot_file.md does not name {missing:?}"
    );
}
