//! The lights of a document as Bevy code, written from the schemas of their settings.

use std::fmt::Write as _;

use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use glam::{EulerRot, Quat, Vec3};
use serde_json::{Map, Value};

use crate::document::{Document, Side};
use crate::schema::{BranchKind, Form, Schemas, definition, rust_path};

/// Luminous power of a light of one candela in all directions, lumen: Bevy gives points and spots by their power.
const LUMEN: f32 = 4.0 * std::f32::consts::PI;

/// Returns code that spawns the lights with the techniques of a side.
pub fn lights(document: &Document, side: Side, techniques: &Techniques, schemas: &Schemas) -> String {
    let mut code =
        "use antumbra::prelude::*;\nuse antumbra::techniques::*;\nuse bevy::prelude::*;\n\n".to_owned();
    code += "fn spawn_lights(mut commands: Commands) {\n";
    for light in document.lights() {
        let parts = match light.parts(side, techniques) {
            Ok(parts) => parts,
            Err(error) => {
                let _ = writeln!(code, "    // {}: left out, because {error}", light.name);
                continue;
            }
        };
        let _ = writeln!(code, "    // {}", light.name);
        let _ = writeln!(code, "    commands.spawn((");
        let _ = writeln!(code, "        {},", component(&parts.light));
        let transform = &parts.transform;
        let at = vec3(transform.translation);
        if transform.rotation.angle_between(Quat::IDENTITY) < 1e-4 {
            let _ = writeln!(code, "        Transform::from_translation({at}),");
        } else {
            let (y, x, z) = transform.rotation.to_euler(EulerRot::YXZ);
            let angles = [y, x, z].map(number).join(", ");
            let turn = format!("Quat::from_euler(EulerRot::YXZ, {angles})");
            let _ = writeln!(
                code,
                "        Transform::from_translation({at}).with_rotation({turn}),"
            );
        }
        if let Some(shadow) = &parts.shadow {
            let row = shadow.row();
            let settings = &light.shadows[side.index()];
            let value = match schemas.technique(row.name()) {
                Some(schema) => structure(schemas, row.component_name(), schema, settings, 2),
                None => format!("{}::default()", row.component_name()),
            };
            let _ = writeln!(code, "        {value},");
        }
        let _ = writeln!(code, "    ));");
        let model: Vec<&str> = MODEL
            .into_iter()
            .filter(|key| light.keys.contains_key(*key))
            .collect();
        if !model.is_empty() {
            let _ = writeln!(
                code,
                "    // Insert also the components of the light model for {}.",
                model.join(", ")
            );
        }
    }
    code + "}\n"
}

/// Keys of the light model, which are components of their own.
const MODEL: [&str; 13] = [
    "shape",
    "distance",
    "weights",
    "shadow_color",
    "shadow_darkness",
    "shadow_origin",
    "shadow_direction",
    "shadow_softness",
    "cookie",
    "profile",
    "affects",
    "casts_for",
    "shows_on",
];

/// Returns Bevy's component of a light.
fn component(light: &Light) -> String {
    let color = light.color.to_array().map(number).join(", ");
    let color = format!("color: Color::linear_rgb({color})");
    let range = if light.range.is_finite() {
        format!(", range: {}", number(light.range))
    } else {
        ", range: 1000.0".to_owned()
    };
    let power = format!("intensity: {}", number(light.intensity * LUMEN));
    match light.kind {
        LightKind::Point => format!("PointLight {{ {color}, {power}{range}, ..default() }}"),
        LightKind::Sphere { radius } => {
            let radius = number(radius);
            format!("PointLight {{ {color}, {power}{range}, radius: {radius}, ..default() }}")
        }
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => {
            let (inner, outer) = (number(inner_angle), number(outer_angle));
            format!(
                "SpotLight {{ {color}, {power}{range}, inner_angle: {inner}, outer_angle: {outer}, ..default() }}"
            )
        }
        LightKind::Directional => {
            let lux = number(light.intensity);
            format!("DirectionalLight {{ {color}, illuminance: {lux}, ..default() }}")
        }
        LightKind::Rect { width, height } => {
            // A rectangle that shines to one side with I · cos θ has the power π I.
            let power = number(light.intensity * std::f32::consts::PI);
            let (width, height) = (number(width), number(height));
            format!("RectLight {{ {color}, intensity: {power}{range}, width: {width}, height: {height} }}")
        }
    }
}

/// Returns a component or a struct with the settings that are not the default.
fn structure(
    schemas: &Schemas,
    name: &str,
    schema: &Value,
    settings: &Map<String, Value>,
    depth: usize,
) -> String {
    let Form::Object(properties) = schemas.form_of_some(schema) else {
        return format!("{name}::default()");
    };
    let fields: Vec<String> = properties
        .iter()
        .filter_map(|(key, property)| {
            let value = settings.get(key).filter(|value| !value.is_null())?;
            Some(format!(
                "{key}: {}",
                expression(schemas, property, value, depth + 1)
            ))
        })
        .collect();
    if fields.is_empty() {
        return format!("{name}::default()");
    }
    let indent = "    ".repeat(depth + 1);
    let end = "    ".repeat(depth);
    let lines: String = fields.iter().map(|field| format!("{indent}{field},\n")).collect();
    format!("{name} {{\n{lines}{indent}..default()\n{end}}}")
}

/// Returns a value of a schema.
fn expression(schemas: &Schemas, schema: &Value, value: &Value, depth: usize) -> String {
    let name = type_name(schema);
    match schemas.form(schema) {
        Form::Optional(inner) => {
            let value = expression(schemas, inner, value, depth);
            // A type that says itself how it is written has no `Option` around it.
            if rust_path(schemas.resolve(inner)).is_some() {
                value
            } else {
                format!("Some({value})")
            }
        }
        Form::Number(bounds) if bounds.whole => value.to_string(),
        Form::Number(_) => number(value.as_f64().unwrap_or_default() as f32),
        Form::Row(_, item) => {
            let parts = value.as_array().into_iter().flatten();
            let parts: Vec<String> = parts.map(|part| expression(schemas, item, part, depth)).collect();
            format!("[{}]", parts.join(", "))
        }
        Form::Choice(branches) => {
            let Some(branch) = schemas
                .branch_of(&branches, value)
                .and_then(|at| branches.get(at))
            else {
                return format!("{}::default()", name.unwrap_or("_"));
            };
            let path = rust_path(branch.schema).map_or_else(
                || format!("{}::{}", name.unwrap_or("_"), camel_case(&branch.name)),
                |path| path.trim_end_matches("(_)").to_owned(),
            );
            match branch.kind {
                BranchKind::Name(_) => path,
                BranchKind::Keyed(key, inner) => variant(
                    schemas,
                    &path,
                    inner,
                    value.get(key).unwrap_or(&Value::Null),
                    depth,
                ),
                BranchKind::Plain => variant(schemas, &path, branch.schema, value, depth),
            }
        }
        Form::Object(_) => match rust_path(schemas.resolve(schema)) {
            Some(path) => variant(schemas, path, schema, value, depth),
            None => {
                let settings = value.as_object().cloned().unwrap_or_default();
                structure(schemas, name.unwrap_or("_"), schema, &settings, depth)
            }
        },
        Form::Flag | Form::Text | Form::Texts | Form::Other => value.to_string(),
    }
}

/// Returns a variant with all of its fields.
fn variant(schemas: &Schemas, path: &str, schema: &Value, value: &Value, depth: usize) -> String {
    let Form::Object(properties) = schemas.form_of_some(schema) else {
        return format!("{path}({})", expression(schemas, schema, value, depth));
    };
    let fields = properties.iter().map(|(key, property)| {
        let default = property.get("default").unwrap_or(&Value::Null);
        let value = value.get(key).unwrap_or(default);
        format!("{key}: {}", expression(schemas, property, value, depth))
    });
    format!("{path} {{ {} }}", fields.collect::<Vec<_>>().join(", "))
}

/// Returns the name of the type that a schema refers to.
fn type_name(schema: &Value) -> Option<&str> {
    let inner = || {
        let all = schema.get("anyOf")?.as_array()?;
        all.iter().find_map(definition)
    };
    definition(schema).or_else(inner)
}

fn camel_case(name: &str) -> String {
    let words = name.split('_').map(|word| {
        let mut letters = word.chars();
        let first = letters.next().map(|first| first.to_uppercase().to_string());
        first.unwrap_or_default() + letters.as_str()
    });
    words.collect()
}

fn vec3(v: Vec3) -> String {
    format!("Vec3::new({})", v.to_array().map(number).join(", "))
}

/// Returns a number as Rust has it, with at most four decimals unless it is small.
fn number(value: f32) -> String {
    if value == 0.0 || !value.is_finite() {
        return if value.is_finite() {
            "0.0".to_owned()
        } else {
            "f32::INFINITY".to_owned()
        };
    }
    if value.abs() < 0.01 {
        return format!("{value:?}");
    }
    let text = format!("{value:.4}");
    let text = text.trim_end_matches('0');
    if text.ends_with('.') {
        format!("{text}0")
    } else {
        text.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;
    use crate::document::LightDoc;

    #[test]
    fn settings_that_differ_become_fields() {
        let techniques = Techniques::default();
        let schemas = Schemas::of(&techniques);
        let code = |light: Value| {
            let Value::Object(keys) = light else { panic!() };
            let document = Document {
                lights: Some(vec![LightDoc::new("lamp".to_owned(), keys, &techniques)]),
                ..Document::default()
            };
            lights(&document, Side::A, &techniques, &schemas)
        };
        let spot = json!({"kind": "spot", "position": [0, 2, 0], "direction": [0, -1, 0], "inner_deg": 20,
            "outer_deg": 30});
        let with = |shadow: Value| {
            let mut light = spot.clone();
            light["shadow"] = shadow;
            code(light)
        };
        let plain = with(json!({"technique": "shadow_map"}));
        assert!(plain.contains("        ShadowMap::default(),\n"), "{plain}");
        assert!(plain.contains("SpotLight { color: Color::linear_rgb(1.0, 1.0, 1.0), intensity: 753.9822,"));
        let set = with(json!({"technique": "shadow_map", "resolution": 512, "near": 0.05,
            "filter": {"jittered": {"softness": 0.02, "adaptive": false}},
            "bias": {"normal_texels": 2.0}}));
        for line in [
            "resolution: MapResolution::Fixed(512),",
            "near: Some(0.05),",
            "filter: MapFilter::Jittered { adaptive: false, softness: 0.02 },",
            "bias: MapBias::Manual { depth_metres: 0.0, distance_share: 0.0, normal_texels: 2.0 },",
            "..default()",
        ] {
            assert!(set.contains(line), "no {line} in\n{set}");
        }
        let smooth = with(
            json!({"technique": "smoothie", "width": {"share": 0.03}, "resolution": {"least": 64, "most": 256}}),
        );
        assert!(smooth.contains("width: SmoothieWidth::Share(0.03),"), "{smooth}");
        assert!(
            smooth.contains("resolution: MapResolution::Auto { least: 64, most: 256 },"),
            "{smooth}"
        );
        let none = with(json!({"technique": "none"}));
        assert!(!none.contains("::default()"), "{none}");
    }
}
