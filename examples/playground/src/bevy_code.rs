//! The lights of a document as Bevy code, written from the schemas of their settings.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use antumbra_stage::shadow::nest_softness;
use antumbra_stage::shot::LightParts;
use glam::{EulerRot, Quat, Vec3};
use serde_json::{Map, Value};

use crate::document::{Document, LightDoc, Side};
use crate::schema::{BranchKind, Form, Schemas, definition, rust_path};

/// Luminous power of a light of one candela in all directions, lumen: Bevy gives points and spots by their power.
const LUMEN: f32 = 4.0 * std::f32::consts::PI;

/// Returns code that spawns the lights with the techniques of a side. It compiles as it is in a game that depends on
/// `antumbra` with its feature `bevy`, and on `bevy`.
pub fn lights(document: &Document, side: Side, techniques: &Techniques, schemas: &Schemas) -> String {
    let mut code = String::new();
    let mut has_path = false;
    for light in document.lights() {
        // A name may hold anything, but not end the comment.
        let name = light.name.replace(['\n', '\r'], " ");
        match light.parts(side, techniques) {
            Ok((parts, note)) => {
                has_path |= parts.path.is_some();
                let note = note.map_or_else(String::new, |note| format!(" ({})", note.replace('\n', " ")));
                let _ = writeln!(code, "    // {name}{note}");
                code += &spawn(light, &parts, side, schemas);
            }
            Err(error) => {
                let error = error.replace('\n', " ");
                let _ = writeln!(code, "    // {name}: left out, because {error}");
            }
        }
    }
    // Names are imported one by one and within the function: some are also names of Bevy's.
    let mut uses = String::new();
    if has_path {
        uses += "    use antumbra::scene::LightPath;\n";
    }
    let names = names_in(&code, schemas);
    if !names.is_empty() {
        let names = names.into_iter().collect::<Vec<_>>().join(", ");
        let _ = writeln!(uses, "    use antumbra::techniques::{{{names}}};");
    }
    format!("use bevy::prelude::*;\n\nfn spawn_lights(mut commands: Commands) {{\n{uses}{code}}}\n")
}

/// Returns the types of this crate's techniques and of their settings that code names.
fn names_in<'a>(code: &'a str, schemas: &Schemas) -> BTreeSet<&'a str> {
    let lines = code.lines().filter(|line| !line.trim_start().starts_with("//"));
    let words = lines.flat_map(|line| line.split(|letter: char| !letter.is_alphanumeric()));
    let builtin = Techniques::default();
    let is_component = |word: &str| builtin.rows().iter().any(|row| row.component_name() == word);
    words
        .filter(|word| is_component(word) || schemas.is_type(word))
        .collect()
}

/// Returns the statement that spawns a light.
fn spawn(light: &LightDoc, parts: &LightParts, side: Side, schemas: &Schemas) -> String {
    let mut code = "    commands.spawn((\n".to_owned();
    let _ = writeln!(code, "        {},", component(&parts.light));
    let transform = &parts.transform;
    let at = vec3(transform.translation);
    if transform.rotation.angle_between(Quat::IDENTITY) < 1e-4 {
        let _ = writeln!(code, "        Transform::from_translation({at}),");
    } else {
        let (y, x, z) = transform.rotation.to_euler(EulerRot::YXZ);
        let angles = [y, x, z].map(angle).join(", ");
        let turn = format!("Quat::from_euler(EulerRot::YXZ, {angles})");
        let _ = writeln!(
            code,
            "        Transform::from_translation({at}).with_rotation({turn}),"
        );
    }
    if let Some(path) = &parts.path {
        let _ = writeln!(code, "        {},", light_path(path));
    }
    let first = &light.shadows[side.index()];
    let second = first.get("moving").and_then(Value::as_object);
    for (shadow, settings) in [(&parts.shadow, Some(first)), (&parts.moving, second)] {
        let (Some(shadow), Some(settings)) = (shadow, settings) else {
            continue;
        };
        let row = shadow.row();
        let mut settings = settings.clone();
        nest_softness(&mut settings);
        let schema = schemas.technique(row.name());
        let value = match schema {
            Some(schema) => structure(schemas, row.component_name(), schema, &settings, 2),
            None => format!("{}::default()", row.component_name()),
        };
        let _ = writeln!(code, "        {value},");
    }
    code += "    ));\n";
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
    code
}

/// Returns a path.
fn light_path(path: &LightPath) -> String {
    match path {
        LightPath::Arc {
            direction,
            axis,
            degrees,
        } => {
            let (direction, axis, degrees) = (vec3(*direction), vec3(*axis), number(*degrees));
            format!("LightPath::Arc {{ direction: {direction}, axis: {axis}, degrees: {degrees} }}")
        }
        LightPath::Sun {
            latitude_degrees,
            day,
            hours,
        } => {
            let [latitude, day, from, to] = [*latitude_degrees, *day, hours[0], hours[1]].map(number);
            format!("LightPath::Sun {{ latitude_degrees: {latitude}, day: {day}, hours: [{from}, {to}] }}")
        }
        LightPath::Positions(positions) => {
            let positions: Vec<String> = positions.iter().copied().map(vec3).collect();
            format!("LightPath::Positions(vec![{}])", positions.join(", "))
        }
    }
}

/// Keys of the light model, which are components of their own.
const MODEL: [&str; 15] = [
    "shape",
    "barn_map",
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
    "texture",
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
            let (inner, outer) = (angle(inner_angle), angle(outer_angle));
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
    let Form::Optional(inner) = schemas.form(schema) else {
        return expression_of(schemas.form(schema), schemas, schema, value, depth);
    };
    let value = expression_of(schemas.form_of_some(inner), schemas, inner, value, depth);
    // A type that says itself how it is written has no `Option` around it.
    if rust_path(schemas.resolve(inner)).is_some() {
        value
    } else {
        format!("Some({value})")
    }
}

/// Returns a value of a schema that has a form.
fn expression_of(form: Form, schemas: &Schemas, schema: &Value, value: &Value, depth: usize) -> String {
    let name = type_name(schema);
    match form {
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
                return "default()".to_owned();
            };
            if let Some(flag) = value.as_bool()
                && let Some(rust) = branch
                    .schema
                    .get(if flag { "x-rust-true" } else { "x-rust-false" })
            {
                return rust.as_str().unwrap_or("_").to_owned();
            }
            let path = rust_path(branch.schema).map_or_else(
                || format!("{}::{}", name.unwrap_or("_"), camel_case(&branch.name)),
                |path| path.trim_end_matches("(_)").to_owned(),
            );
            match branch.kind {
                BranchKind::Exactly(Value::String(_)) => path,
                BranchKind::Exactly(value) => value.to_string(),
                BranchKind::Plain if path == "_" => expression(schemas, branch.schema, value, depth),
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
        Form::Text => format!("{value}.to_owned()"),
        Form::Flag | Form::Texts | Form::Optional(_) | Form::Other => value.to_string(),
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

/// Returns an angle in radians as Rust code: degrees, rounded to a thousandth.
fn angle(radians: f32) -> String {
    let degrees = (radians.to_degrees() * 1e3).round() / 1e3;
    format!("f32::to_radians({})", number(degrees))
}

/// Returns a number as Rust code: the fewest digits that give it.
fn number(value: f32) -> String {
    if value.is_finite() {
        return format!("{:?}", value + 0.0); // no negative zero
    }
    let infinity = if value < 0.0 {
        "f32::NEG_INFINITY"
    } else {
        "f32::INFINITY"
    };
    infinity.to_owned()
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
        assert!(plain.contains("SpotLight { color: Color::linear_rgb(1.0, 1.0, 1.0), intensity: 753.98224,"));
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
        assert!(!none.contains("antumbra"), "{none}");
    }
}
