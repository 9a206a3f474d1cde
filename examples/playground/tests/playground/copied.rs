//! Copied Bevy code: one file with every setting of every technique, which the tests of the library compile and run.

use antumbra::techniques::Techniques;
use antumbra_playground::bevy_code::lights;
use antumbra_playground::document::{Document, LightDoc, Side};
use antumbra_playground::schema::{Form, Schemas};
use serde_json::{Map, Value, json};

/// Values of a schema that differ from the default: one for each branch of each choice.
fn others(schemas: &Schemas, schema: &Value) -> Vec<Value> {
    let default = schema.get("default").cloned().unwrap_or_default();
    match schemas.form(schema) {
        Form::Flag => vec![json!(default != json!(true))],
        Form::Number(bounds) => {
            let before = default.as_f64().or(schemas.first(schema).as_f64()).unwrap();
            let less = if bounds.whole { before - 1.0 } else { before * 0.5 };
            let other = [less, before + 0.25, before + 1.0].into_iter().find(|other| {
                bounds.least.is_none_or(|least| *other > least)
                    && bounds.most.is_none_or(|most| *other <= most)
                    && (!bounds.whole || other.fract() == 0.0)
                    && Some(*other) != default.as_f64()
            });
            vec![if bounds.whole {
                json!(other.unwrap() as i64)
            } else {
                json!(other.unwrap())
            }]
        }
        Form::Text => vec![json!("some/\"folder\"")],
        Form::Row(count, item) => vec![Value::Array(vec![schemas.first(item); count])],
        Form::Choice(branches) => {
            let first = branches.iter().map(|branch| schemas.first_of(branch));
            first
                .flat_map(|value| match value {
                    Value::Bool(_) => vec![json!(true), json!(false)],
                    other => vec![other],
                })
                .collect()
        }
        Form::Optional(inner) => match schemas.form_of_some(inner) {
            Form::Object(_) => others(schemas, schemas.resolve(inner)),
            _ => vec![schemas.first(inner)],
        },
        Form::Object(properties) => {
            let pair = |(key, inner): (&String, &Value)| (key.clone(), others(schemas, inner).remove(0));
            vec![Value::Object(properties.iter().map(pair).collect())]
        }
        Form::Texts | Form::Other => panic!("no technique has such a setting: {schema}"),
    }
}

/// Lights of all kinds, and lights that have between them each setting of each technique.
fn all_lights(techniques: &Techniques, schemas: &Schemas) -> Vec<LightDoc> {
    let place = json!({"position": [0.5, 2, -1], "direction": [0.3, -1, 0.2], "inner_deg": 20, "outer_deg": 30,
        "width": 0.6, "height": 0.4, "radius": 0.2});
    let paths = [
        json!({"axis": [0, 0, 1], "degrees": 150}),
        json!({"latitude_deg": 50, "day": 172, "hours": [6, 18]}),
        json!({"positions": [[0, 2, 0], [4, 2, 0.5]]}),
    ];
    let keys = |kind: &str, path: Option<&Value>| {
        let schema = schemas.light(kind).unwrap()["properties"].as_object().unwrap();
        let own = place
            .as_object()
            .unwrap()
            .iter()
            .filter(|(key, _)| schema.contains_key(*key));
        let mut keys: Map<String, Value> = own.map(|(key, value)| (key.clone(), value.clone())).collect();
        keys.insert("kind".to_owned(), json!(kind));
        keys.extend(path.map(|path| ("path".to_owned(), path.clone())));
        keys
    };
    let light = |keys: &Map<String, Value>, name: &str, settings: Map<String, Value>| {
        let mut light = LightDoc::new(name.to_owned(), keys.clone(), techniques);
        light.shadows[0] = settings;
        light.shadows[0].insert("technique".to_owned(), json!(name));
        light
    };
    let bare = schemas
        .light_kinds()
        .into_iter()
        .map(|kind| light(&keys(kind, None), "none", Map::new()));
    let mut all: Vec<LightDoc> = bare.collect();
    for name in schemas.technique_names() {
        let Form::Object(properties) = schemas.form_of_some(schemas.technique(name).unwrap()) else {
            panic!("{name} has no settings");
        };
        let values: Vec<_> = properties
            .iter()
            .map(|(key, schema)| (key, others(schemas, schema)))
            .collect();
        let count = values
            .iter()
            .map(|(_, all)| all.len())
            .max()
            .unwrap_or(0)
            .max(paths.len());
        for index in 0..count {
            let settings = values
                .iter()
                .map(|(key, all)| ((*key).clone(), all[index % all.len()].clone()));
            let settings: Map<String, Value> = settings.collect();
            let kinds = schemas.light_kinds().into_iter();
            let choices = kinds.flat_map(|kind| {
                let with = keys(kind, Some(&paths[index % paths.len()]));
                [
                    light(&keys(kind, None), name, settings.clone()),
                    light(&with, name, settings.clone()),
                ]
            });
            let fitting = choices.into_iter().find(|light| {
                let parts = light.parts(Side::A, techniques);
                parts.is_ok_and(|(_, note)| note.is_none())
            });
            all.push(fitting.unwrap_or_else(|| panic!("no light takes {name} with {settings:?}")));
        }
    }
    all
}

/// The file is compiled and run by the tests of the library with Bevy. Write it with `ANTUMBRA_WRITE_COPIED=1`.
#[test]
fn the_code_that_is_compiled_with_bevy_is_what_is_copied() {
    let techniques = Techniques::default();
    let schemas = Schemas::of(&techniques);
    let document = Document {
        lights: Some(all_lights(&techniques, &schemas)),
        ..Document::default()
    };
    let code = lights(&document, Side::A, &techniques, &schemas);
    assert!(!code.contains("left out"), "{code}");
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/bevy/copied_lights.in");
    if std::env::var_os("ANTUMBRA_WRITE_COPIED").is_some() {
        std::fs::write(&path, &code).unwrap();
    }
    let file = std::fs::read_to_string(&path).unwrap_or_default();
    assert!(file == code, "{} is old:\n{code}", path.display());
}
