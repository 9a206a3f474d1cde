//! From JSON to the schema of glTF, with the repairs that files in the world need.

use gltf::json::{Error as JsonError, Root, Value, deserialize};

use super::{Element, Report, SkipKind};

/// Why JSON is not a glTF document.
pub(super) enum SchemaError {
    /// The document is of another major version of glTF; the text is its version.
    Version(String),
    /// Parsing stopped at the element with this path, such as `accessors[3].count`.
    Json { path: String, source: JsonError },
}

/// Largest whole number below which every whole number is an `f64`.
const WHOLE_NUMBERS_END: f64 = 9_007_199_254_740_992.0;

/// Reads the schema. What the specification forbids but other viewers accept is mended on a second try: fields that
/// `gltf::json` requires and the specification does not, whole numbers written as `24.0`, and channels whose target is
/// no node. A good file pays nothing for it.
pub(super) fn parse_json(json: &[u8], report: &mut Report) -> Result<Root, SchemaError> {
    let first_error = match deserialize::from_slice::<Root>(json) {
        Ok(root) => return Ok(root),
        Err(error) => error,
    };
    let mut reader = serde_json::Deserializer::from_slice(json);
    let mut document: Value = serde_path_to_error::deserialize(&mut reader).map_err(of_path)?;
    reader.end().map_err(|_| SchemaError::Json {
        path: String::new(),
        source: first_error,
    })?;
    if let Some(version) = version_of(&document).filter(|version| !is_version_2(version)) {
        return Err(SchemaError::Version(version));
    }
    make_numbers_whole(&mut document);
    if let Some(version) = document.pointer_mut("/asset/version")
        && version.is_number()
    {
        *version = Value::String(version.to_string());
    }
    for scene in array_mut(&mut document, "scenes") {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    let unknown_targets = remove_unknown_targets(&mut document);
    let root = serde_path_to_error::deserialize(document).map_err(of_path)?;
    for (animation, count) in unknown_targets.into_iter().filter(|&(_, count)| count > 0) {
        let reason = "the target is not a node";
        report.add(
            SkipKind::AnimationChannel,
            Element::Animation(animation),
            count,
            reason,
        );
    }
    Ok(root)
}

/// Whether the major version of glTF is 2.
pub(super) fn is_version_2(version: &str) -> bool {
    version.split('.').next() == Some("2")
}

fn of_path(error: serde_path_to_error::Error<JsonError>) -> SchemaError {
    let path = error.path().to_string();
    SchemaError::Json {
        path: if path == "." { String::new() } else { path },
        source: error.into_inner(),
    }
}

/// The version that a document states, or by which its form is known: lists of glTF 1.0 are objects.
fn version_of(document: &Value) -> Option<String> {
    let stated = document
        .pointer("/asset/version")
        .and_then(|version| match version {
            Value::String(text) => Some(text.clone()),
            Value::Number(number) => Some(number.to_string()),
            _ => None,
        });
    let has_named_lists = ["accessors", "bufferViews", "meshes", "nodes", "scenes"]
        .iter()
        .any(|list| document.get(list).is_some_and(Value::is_object));
    stated.or_else(|| has_named_lists.then(|| "1.0".to_owned()))
}

/// Turns numbers like `24.0` into whole ones, everywhere. Where a fraction is allowed, the value stays equal: −0 becomes 0.
fn make_numbers_whole(value: &mut Value) {
    match value {
        Value::Number(number) => {
            let Some(float) = number.as_f64().filter(|_| number.is_f64()) else {
                return;
            };
            if float.fract() == 0.0 && float.abs() < WHOLE_NUMBERS_END {
                *value = Value::from(float as i64);
            }
        }
        Value::Array(items) => items.iter_mut().for_each(make_numbers_whole),
        Value::Object(fields) => fields.values_mut().for_each(make_numbers_whole),
        _ => {}
    }
}

/// Removes the channels whose target is no node. Returns each animation and how many it lost.
fn remove_unknown_targets(document: &mut Value) -> Vec<(usize, usize)> {
    let mut removed = Vec::new();
    for (index, animation) in array_mut(document, "animations").iter_mut().enumerate() {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let before = channels.len();
            channels.retain(|channel| {
                let target = channel.get("target");
                target.is_some_and(|target| {
                    target.get("node").is_some() && target.get("path").is_some_and(|path| path != "pointer")
                })
            });
            removed.push((index, before - channels.len()));
        }
    }
    removed
}

fn array_mut<'a>(document: &'a mut Value, key: &str) -> &'a mut [Value] {
    match document.get_mut(key).and_then(Value::as_array_mut) {
        Some(items) => items,
        None => &mut [],
    }
}
