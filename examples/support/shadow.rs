//! Techniques in a shot file: `{"technique": NAME}` with settings beside the name, and under `moving` a second technique.

use antumbra::techniques::{Settings, Techniques};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde_json::{Map, Value, json};

/// The key of the second technique, among the settings of one that leaves objects to it.
const MOVING: &str = "moving";

/// A technique and its settings as the file has them.
#[derive(Clone, Debug, Deserialize)]
#[serde(transparent)]
pub struct ShotShadow(Map<String, Value>);

impl From<Map<String, Value>> for ShotShadow {
    fn from(shadow: Map<String, Value>) -> Self {
        Self(shadow)
    }
}

/// Anything: [`shadow_schema`] says what the techniques of a list read.
impl JsonSchema for ShotShadow {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ShotShadow".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        Schema::default()
    }
}

/// Describes what a shot may say of a light's shadow: `none`, or a technique of the list with its settings.
pub fn shadow_schema(techniques: &Techniques, of: &mut SchemaGenerator) -> Value {
    let none = json!({
        "type": "object",
        "description": "The light casts no shadows.",
        "properties": {"technique": {"const": "none"}},
        "required": ["technique"],
        "additionalProperties": false,
    });
    let all = techniques.rows().iter().map(|row| {
        let described = row.schema(of).map(Schema::to_value);
        let mut schema = described.unwrap_or_else(|| json!({"type": "object"}));
        let mut properties = Map::new();
        let own = schema.get("required").and_then(Value::as_array).cloned();
        let required: Vec<Value> = [json!("technique")]
            .into_iter()
            .chain(own.unwrap_or_default())
            .collect();
        properties.insert("technique".to_owned(), json!({"const": row.name()}));
        if let Some(settings) = schema.get_mut("properties").and_then(Value::as_object_mut) {
            flatten_softness(settings);
            properties.extend(std::mem::take(settings));
        }
        if row.leaves_others() {
            let moving = json!({
                "$ref": "#/$defs/ShotShadow",
                "description": "Another technique, which shadows by what this one does not know, and on it: what moves.",
            });
            properties.insert(MOVING.to_owned(), moving);
        }
        schema["properties"] = Value::Object(properties);
        schema["required"] = Value::Array(required);
        schema
    });
    let all: Vec<Value> = [none].into_iter().chain(all).collect();
    json!({ "oneOf": all })
}

/// Lets a filter of maps be named with its softness beside it, as [`nest_softness`] reads it.
fn flatten_softness(settings: &mut Map<String, Value>) {
    let Some(filter) = settings.get_mut("filter").and_then(Value::as_object_mut) else {
        return;
    };
    let of_maps = |reference: &Value| {
        reference
            .as_str()
            .is_some_and(|name| name.ends_with("/MapFilter"))
    };
    if !filter.get("$ref").is_some_and(of_maps) {
        return; // the filter of another technique has no softness
    }
    let nested = filter.remove("$ref").map(|reference| json!({"$ref": reference}));
    let flat = json!({"enum": ["jittered", "jittered_full", "soft_4"]});
    filter.insert("anyOf".to_owned(), nested.into_iter().chain([flat]).collect());
    let softness = json!({
        "type": "number",
        "minimum": 0,
        "default": SOFTNESS,
        "description": "Radius of a filter that is given by its name `jittered`, `jittered_full` (all taps \
                        everywhere) or `soft_4`.",
    });
    settings.insert("softness".to_owned(), softness);
}

impl ShotShadow {
    /// Adds a setting that the file has beside the technique. The technique `none` takes no settings.
    ///
    /// # Errors
    /// The technique has the setting as well.
    pub fn with(mut self, setting: &str, value: f32) -> Result<Self, String> {
        if self.0.contains_key(setting) {
            return Err(format!(
                "{setting}: the light and its shadow both have it; only one of them may"
            ));
        }
        if self.0.get("technique").is_some_and(|name| name != "none") {
            self.0.insert(setting.to_owned(), value.into());
        }
        Ok(self)
    }

    /// Makes paths among the settings relative to the current folder instead of to `folder`.
    pub fn find_files(&mut self, folder: &std::path::Path, techniques: &Techniques) {
        if let Some(Value::Object(moving)) = self.0.get_mut(MOVING) {
            let mut second = Self(std::mem::take(moving));
            second.find_files(folder, techniques);
            *moving = second.0;
        }
        let name = self.0.get("technique").and_then(Value::as_str);
        let row = name.and_then(|name| techniques.named(name));
        for &key in row.map_or(&[][..], |row| row.paths()) {
            if let Some(Value::String(path)) = self.0.get_mut(key)
                && !path.is_empty()
            {
                *path = folder.join(&*path).to_string_lossy().into_owned();
            }
        }
    }

    /// Returns the settings; `None` for the name `none`.
    ///
    /// # Errors
    /// Names the setting and says what is wrong with it.
    pub fn settings(&self, techniques: &Techniques) -> Result<Option<Settings>, String> {
        let mut settings = self.0.clone();
        let names = || {
            let rows = techniques.rows().iter().map(|row| row.name());
            ["none"].into_iter().chain(rows).collect::<Vec<_>>().join(", ")
        };
        let name = match settings.remove("technique") {
            Some(Value::String(name)) => name,
            Some(other) => return Err(format!("shadow.technique: {other} must be one of {}", names())),
            None => return Err(format!("shadow: no technique; choose one of {}", names())),
        };
        if name == "none" {
            return match settings.keys().next() {
                Some(key) => Err(format!("shadow: unknown field `{key}`, none has no settings")),
                None => Ok(None),
            };
        }
        let row = techniques.named(&name).ok_or_else(|| {
            format!(
                "shadow.technique: no technique is called `{name}`; choose one of {}",
                names()
            )
        })?;
        if row.leaves_others() {
            settings.remove(MOVING);
        }
        nest_softness(&mut settings);
        check_softness(&settings)?;
        let mut track = serde_path_to_error::Track::new();
        let from = serde_path_to_error::Deserializer::new(Value::Object(settings), &mut track);
        let parsed = row.parse(from);
        parsed
            .map(Some)
            .map_err(|error| match track.path().to_string().as_str() {
                "." => format!("shadow: {error}"),
                path => format!("shadow.{path}: {error}"),
            })
    }
}

impl ShotShadow {
    /// Returns the settings of the second technique; `None` without one.
    ///
    /// # Errors
    /// Names the setting and says what is wrong with it.
    pub fn moving(&self, techniques: &Techniques) -> Result<Option<Settings>, String> {
        let moving = match self.0.get(MOVING) {
            None => return Ok(None),
            Some(Value::Object(moving)) => Self(moving.clone()),
            Some(other) => return Err(format!("shadow.moving: {other} must be an object")),
        };
        let settings = moving
            .settings(techniques)
            .map_err(|error| error.replacen("shadow", "shadow.moving", 1))?;
        match settings {
            Some(settings) if settings.row().leaves_others() => Err(format!(
                "shadow.moving.technique: {} cannot be the second technique",
                settings.row().name()
            )),
            settings => Ok(settings),
        }
    }
}

/// Says which filters have a softness, if the settings have one beside a filter of maps without it.
fn check_softness(settings: &Map<String, Value>) -> Result<(), String> {
    let filter = settings.get("filter").and_then(Value::as_str).unwrap_or_default();
    if settings.contains_key("softness") && ["bilinear", "brute_4x4", "dithered_4"].contains(&filter) {
        return Err(format!(
            "shadow.softness: the filter `{filter}` has none; choose `jittered`, `jittered_full` or `soft_4`"
        ));
    }
    Ok(())
}

/// Softness of a filter if the shot does not set one.
const SOFTNESS: f64 = 0.01;

/// Moves the softness into the filter: a shot has it beside the filter's name, and the settings have it inside the
/// filter.
pub fn nest_softness(settings: &mut Map<String, Value>) {
    let Some(Value::String(filter)) = settings.get("filter") else {
        return;
    };
    let softness = |value: Option<Value>| value.unwrap_or(json!(SOFTNESS));
    let nested = match filter.as_str() {
        "jittered" | "jittered_full" => {
            let adaptive = filter == "jittered";
            json!({"jittered": {"softness": softness(settings.remove("softness")), "adaptive": adaptive}})
        }
        "soft_4" => json!({"soft_4": {"softness": softness(settings.remove("softness"))}}),
        _ => return,
    };
    settings.insert("filter".to_owned(), nested);
}
