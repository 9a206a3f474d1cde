//! The lights of a shot, and the components that are spawned for them.

use std::path::PathBuf;

use antumbra::prelude::*;
use antumbra::techniques::{Row, Settings, Techniques};
use bevy_transform::prelude::Transform;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::emission::ShotEmission;
use super::keys::{Keys, key_of};
use super::model::{KEYS, ShotModel};
use super::path::ShotPath;

/// A light of a shot.
#[derive(Clone, Debug, Deserialize)]
#[serde(try_from = "Keys")]
pub struct ShotLight {
    /// Kind, place and brightness, and the technique.
    pub emission: ShotEmission,
    /// The light model.
    pub model: ShotModel,
    /// The path along which the light moves, if any.
    pub path: Option<ShotPath>,
}

impl TryFrom<Keys> for ShotLight {
    type Error = String;

    fn try_from(Keys(light): Keys) -> Result<Self, String> {
        light.try_into()
    }
}

impl TryFrom<Map<String, Value>> for ShotLight {
    type Error = String;

    fn try_from(mut light: Map<String, Value>) -> Result<Self, String> {
        let model = ShotModel::take(&mut light)?;
        let path = ShotPath::take(&mut light)?;
        let emission = ShotEmission::deserialize(Value::Object(light.clone())).map_err(|error| {
            let error = error.to_string();
            if error.starts_with("unknown field") {
                // serde knows the keys of the kind alone.
                return format!("{error}, `path`, `{}`", KEYS.join("`, `"));
            }
            match key_of::<ShotEmission>(&error, &light, "kind") {
                Some(key) => format!("{key}: {error}"),
                None => error,
            }
        })?;
        Ok(Self {
            emission,
            model,
            path,
        })
    }
}

/// The keys of the kind, each with those of the light model.
impl JsonSchema for ShotLight {
    fn schema_name() -> std::borrow::Cow<'static, str> {
        "ShotLight".into()
    }

    fn json_schema(of: &mut SchemaGenerator) -> Schema {
        let model = ShotModel::json_schema(of);
        let path = of.subschema_for::<ShotPath>().to_value();
        let mut light = ShotEmission::json_schema(of);
        let kinds = light.get_mut("oneOf").and_then(Value::as_array_mut);
        for kind in kinds.into_iter().flatten() {
            let own = kind.get_mut("properties").and_then(Value::as_object_mut);
            let shared = model.get("properties").and_then(Value::as_object);
            let (Some(own), Some(shared)) = (own, shared) else {
                continue;
            };
            own.extend(shared.clone());
            // A path gives direction or position instead.
            let given = match own
                .get("kind")
                .and_then(|kind| kind.get("const"))
                .and_then(Value::as_str)
            {
                Some("directional") => ("direction", json!(["latitude_deg"])),
                Some("point" | "spot") => ("position", json!(["positions"])),
                _ => continue,
            };
            own.insert("path".to_owned(), path.clone());
            let (key, path_keys) = given;
            if let Some(required) = kind.get_mut("required").and_then(Value::as_array_mut) {
                required.retain(|name| name != key);
            }
            let by_path = json!({"required": ["path"], "properties": {"path": {"required": path_keys}}});
            kind["allOf"] = json!([{"anyOf": [{"required": [key]}, by_path]}]);
        }
        light
    }
}

/// The parts that are spawned for a light.
#[derive(Clone, Debug)]
pub struct LightParts {
    /// The light component.
    pub light: Light,
    /// Position and direction of the light.
    pub transform: Transform,
    /// Technique with its settings, if any.
    pub shadow: Option<Settings>,
    /// The second technique with its settings, if any: what shadows by things that the technique does not know.
    pub moving: Option<Settings>,
    /// Path of the picture with the light's colours, if any.
    pub texture: Option<PathBuf>,
    /// The light model.
    pub model: ShotModel,
    /// The path along which the light moves, if any.
    pub path: Option<LightPath>,
}

impl ShotLight {
    /// Returns the parts to spawn.
    ///
    /// # Errors
    /// A number of the light or of its model, or a setting of its technique, is wrong.
    pub fn parts(&self, techniques: &Techniques) -> Result<LightParts, String> {
        let emitted = self.emission.parts(techniques)?;
        let path = self
            .path
            .as_ref()
            .map(|path| path.of_light(&emitted))
            .transpose()?;
        let parts = LightParts {
            model: self.model.clone(),
            path,
            ..emitted
        };
        parts.check_path(techniques)?;
        self.model.check(&parts.light)?;
        Ok(parts)
    }
}

impl LightParts {
    /// Checks that a path and a technique that follows it stand together.
    fn check_path(&self, techniques: &Techniques) -> Result<(), String> {
        let follows = |row: Row| row.needs().light_path;
        let row = self.shadow.as_ref().map(Settings::row);
        match (&self.path, row.filter(|row| follows(*row))) {
            (Some(_), None) => {
                let rows = techniques.rows().iter().filter(|row| follows(**row));
                let names: Vec<&str> = rows.map(Row::name).collect();
                Err(format!("path: needs the technique {}", names.join(" or ")))
            }
            (None, Some(row)) => Err(format!("path: {} needs one", row.name())),
            _ => Ok(()),
        }
    }
}
