//! The JSON Schema of shot files.

use antumbra::techniques::Techniques;
use schemars::generate::SchemaSettings;
use serde_json::{Value, json};

use super::super::shadow::shadow_schema;
use super::Shot;

/// Returns the JSON Schema of shot files whose lights may name the techniques of a list.
pub fn shot_schema(techniques: &Techniques) -> Value {
    let mut generator = SchemaSettings::draft2020_12().into_generator();
    let mut schema = generator.root_schema_for::<Shot>().to_value();
    let shadow = shadow_schema(techniques, &mut generator);
    let mut defs = generator.take_definitions(true);
    defs.insert("ShotShadow".to_owned(), shadow);
    schema["$defs"] = json!(defs);
    schema["title"] = json!("Shot of antumbra");
    tidy(&mut schema);
    schema
}

/// Takes the marks of links out of descriptions, which editors show as plain text, and writes defaults with the digits
/// that an `f32` has.
pub fn tidy(schema: &mut Value) {
    match schema {
        Value::Object(all) => {
            if let Some(default) = all.get_mut("default")
                && let Some(number) = default.as_f64().filter(|number| number.fract() != 0.0)
            {
                *default = json!((number as f32).to_string().parse::<f64>().unwrap_or(number));
            }
            if let Some(Value::String(text)) = all.get_mut("description") {
                *text = text.replace("[`", "`").replace("`]", "`");
            }
            all.values_mut().for_each(tidy);
        }
        Value::Array(all) => all.iter_mut().for_each(tidy),
        _ => {}
    }
}
