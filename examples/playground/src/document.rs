//! What is edited: a scene with a camera and lights, as a shot file holds it, with two techniques for each light.

use std::path::{Path, PathBuf};

use antumbra::prelude::*;
use antumbra::techniques::{Settings, Techniques};
use antumbra_stage::shadow::{ShotShadow, nest_softness};
use antumbra_stage::shot::{LightParts, Shot, ShotLight};
use bevy_transform::prelude::Transform;
use glam::Vec3;
use serde::Deserialize;
use serde_json::{Map, Value, json};

/// The two sets of techniques that are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Side {
    /// The techniques that a saved shot has.
    A,
    /// The techniques to compare with.
    B,
}

impl Side {
    /// Both sides.
    pub const ALL: [Self; 2] = [Self::A, Self::B];

    /// Index of the side.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Name of the side in the window.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
        }
    }
}

/// A light as a shot file holds it, without its technique, and a technique for each [`Side`].
#[derive(Clone, Debug, PartialEq)]
pub struct LightDoc {
    /// Name in the list.
    pub name: String,
    /// Keys of the shot's light except `shadow`.
    pub keys: Map<String, Value>,
    /// Technique and settings of each side, as the value of `shadow`.
    pub shadows: [Map<String, Value>; 2],
}

/// Place from which the scene is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Position, metres.
    pub eye: Vec3,
    /// Point that is looked at, around which the camera orbits; metres.
    pub target: Vec3,
    /// Direction that is up in the picture.
    pub up: Vec3,
    /// Projection. Its aspect is that of the view.
    pub camera: Camera,
}

/// A pose of the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Index of the clip.
    pub clip: usize,
    /// Time within the clip, seconds.
    pub time: f32,
}

/// Everything that is saved, and undone.
#[derive(Clone, Debug, PartialEq)]
pub struct Document {
    /// glTF file of the scene; empty without a scene.
    pub scene: PathBuf,
    /// Place from which the scene is seen; `None` frames the scene.
    pub view: Option<Eye>,
    /// Ambient light, linear RGB radiance.
    pub ambient: [f32; 3],
    /// Factor on radiance before the tonemap. Shot files do not hold it.
    pub exposure: f32,
    /// Pose of the scene; `None` is the bind pose.
    pub pose: Option<Pose>,
    /// The lights; `None` takes those of the scene.
    pub lights: Option<Vec<LightDoc>>,
}

impl Default for Document {
    fn default() -> Self {
        Self {
            scene: PathBuf::new(),
            view: None,
            ambient: [0.02; 3],
            exposure: 1.0,
            pose: None,
            lights: None,
        }
    }
}

/// Name of no technique.
pub const NONE: &str = "none";

/// Returns the value of `shadow` for a technique with its default settings.
pub fn shadow_of(technique: &str) -> Map<String, Value> {
    Map::from_iter([("technique".to_owned(), json!(technique))])
}

impl LightDoc {
    /// Makes a light from the value of a shot's light.
    pub fn new(name: String, mut keys: Map<String, Value>, techniques: &Techniques) -> Self {
        let mut shadow = match keys.remove("shadow") {
            Some(Value::Object(shadow)) => shadow,
            _ => shadow_of(NONE),
        };
        nest_softness(&mut shadow);
        let mut light = Self {
            name,
            keys,
            shadows: [shadow.clone(), shadow],
        };
        light.shadows[Side::B.index()] = light.other_technique(techniques);
        light
    }

    /// Returns the last technique of the list that fits the light and is not that of side A, so that the sides
    /// differ from the start.
    fn other_technique(&self, techniques: &Techniques) -> Map<String, Value> {
        let others = techniques.rows().iter().rev().map(|row| shadow_of(row.name()));
        let mut others = others.filter(|other| other.get("technique") != self.shadows[0].get("technique"));
        let fits = |shadow: &Map<String, Value>| self.parts_with(shadow, techniques).is_ok();
        others
            .find(fits)
            .unwrap_or_else(|| self.shadows[Side::A.index()].clone())
    }

    /// Returns the name of the technique of a side.
    pub fn technique(&self, side: Side) -> &str {
        let name = self.shadows[side.index()].get("technique");
        name.and_then(Value::as_str).unwrap_or(NONE)
    }

    /// Returns the name of the light's kind.
    pub fn kind(&self) -> &str {
        self.keys.get("kind").and_then(Value::as_str).unwrap_or("point")
    }

    /// Returns the value of the light in a shot file.
    pub fn to_value(&self, side: Side) -> Value {
        let mut keys = self.keys.clone();
        keys.insert(
            "shadow".to_owned(),
            Value::Object(self.shadows[side.index()].clone()),
        );
        Value::Object(keys)
    }

    fn parts_with(&self, shadow: &Map<String, Value>, techniques: &Techniques) -> Result<LightParts, String> {
        let mut keys = self.keys.clone();
        keys.insert("shadow".to_owned(), Value::Object(shadow.clone()));
        ShotLight::try_from(keys)?.parts(techniques)
    }

    /// Returns what to spawn for the light.
    ///
    /// # Errors
    /// A key or a setting that cannot be used.
    pub fn parts(&self, side: Side, techniques: &Techniques) -> Result<LightParts, String> {
        self.parts_with(&self.shadows[side.index()], techniques)
    }

    /// Returns what to spawn for the light without a shadow.
    ///
    /// # Errors
    /// A key that cannot be used.
    pub fn bare_parts(&self, techniques: &Techniques) -> Result<LightParts, String> {
        let mut keys = self.keys.clone();
        keys.remove("texture"); // only some techniques show one
        ShotLight::try_from(keys)?.parts(techniques)
    }

    /// Returns the technique's settings of a side; `None` for no technique.
    ///
    /// # Errors
    /// A setting that cannot be used.
    pub fn settings(&self, side: Side, techniques: &Techniques) -> Result<Option<Settings>, String> {
        ShotShadow::from(self.shadows[side.index()].clone()).settings(techniques)
    }

    /// Returns a vector that the light's keys hold.
    pub fn vector(&self, key: &str) -> Option<Vec3> {
        let parts = self.keys.get(key)?.as_array()?;
        let at = |index: usize| parts.get(index).and_then(Value::as_f64).map(|x| x as f32);
        Some(Vec3::new(at(0)?, at(1)?, at(2)?))
    }

    /// Sets a vector of the light's keys.
    pub fn set_vector(&mut self, key: &str, value: Vec3) {
        self.keys
            .insert(key.to_owned(), json!(value.to_array().map(rounded)));
    }
}

/// Rounds to a tenth of a millimetre, so that saved files stay readable.
pub fn rounded(value: f32) -> f64 {
    (f64::from(value) * 1e4).round() / 1e4
}

/// Returns the value of a light in a shot file.
pub fn light_value(light: &Light, transform: &Transform) -> Map<String, Value> {
    let forward = (transform.rotation * Vec3::NEG_Z).to_array().map(rounded);
    let mut value = match light.kind {
        LightKind::Point => json!({"kind": "point"}),
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => json!({
            "kind": "spot",
            "direction": forward,
            "inner_deg": rounded(inner_angle.to_degrees()),
            "outer_deg": rounded(outer_angle.to_degrees()),
        }),
        LightKind::Directional => json!({"kind": "directional", "direction": forward}),
        LightKind::Rect { width, height } => json!({
            "kind": "rect",
            "direction": forward,
            "up": (transform.rotation * Vec3::Y).to_array().map(rounded),
            "width": width,
            "height": height,
        }),
        LightKind::Sphere { radius } => json!({"kind": "sphere", "radius": radius}),
    };
    if light.kind != LightKind::Directional {
        value["position"] = json!(transform.translation.to_array().map(rounded));
        if light.range.is_finite() {
            value["range"] = json!(light.range);
        }
    }
    value["color"] = json!(light.color.to_array().map(rounded));
    value["intensity"] = json!(rounded(light.intensity));
    match value {
        Value::Object(keys) => keys,
        _ => Map::new(),
    }
}

/// Keys that hold a path relative to the shot file.
fn absolute_paths(light: &mut Map<String, Value>, folder: &Path) {
    let join = |value: &mut Value| {
        if let Some(path) = value.as_str() {
            *value = json!(folder.join(path));
        }
    };
    ["profile", "texture"]
        .iter()
        .for_each(|key| light.get_mut(*key).into_iter().for_each(join));
    if let Some(path) = light.get_mut("cookie").and_then(|cookie| cookie.get_mut("path")) {
        join(path);
    }
}

impl Document {
    /// Reads a shot file or, for another ending than `.json`, takes a glTF file as the scene.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn load(path: &Path, techniques: &Techniques) -> Result<Self, String> {
        if path.extension().is_none_or(|ending| ending != "json") {
            return Ok(Self {
                scene: path.to_owned(),
                ..Self::default()
            });
        }
        let shot = Shot::load(path, techniques.clone())?;
        let named = |error: String| format!("{}: {error}", path.display());
        let text = std::fs::read_to_string(path).map_err(|error| named(error.to_string()))?;
        let mut value: Value = serde_json::from_str(&text).map_err(|error| named(error.to_string()))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        let view = shot.camera.map(|camera| Eye {
            eye: camera.eye.into(),
            target: camera.target.into(),
            up: camera.up.into(),
            camera: camera.camera(shot.size()),
        });
        let lights = value.get_mut("lights").and_then(Value::as_array_mut);
        let lights = lights.map(|lights| {
            let all = lights.iter_mut().enumerate().filter_map(|(index, light)| {
                let mut keys = std::mem::take(light.as_object_mut()?);
                absolute_paths(&mut keys, folder);
                Some(LightDoc::new(light_name(index, &keys), keys, techniques))
            });
            all.collect()
        });
        Ok(Self {
            scene: shot.scene.clone(),
            view,
            ambient: shot.ambient,
            exposure: 1.0,
            pose: shot.animation.map(|pose| Pose {
                clip: pose.clip,
                time: pose.time,
            }),
            lights,
        })
    }

    /// Returns the text of a shot file with the techniques of a side. Paths are relative to `folder` where they can
    /// be.
    pub fn to_shot(&self, side: Side, size: [u32; 2], folder: &Path) -> String {
        let mut shot = json!({
            "scene": relative(&self.scene, folder),
            "size": size,
            "ambient": self.ambient.map(rounded),
        });
        if let Some(view) = &self.view {
            shot["camera"] = json!({
                "eye": view.eye.to_array().map(rounded),
                "target": view.target.to_array().map(rounded),
                "up": view.up.to_array().map(rounded),
                "vfov_deg": rounded(view.camera.vertical_fov.to_degrees()),
                "near": rounded(view.camera.near),
            });
            if let Some(flat) = view.camera.orthographic {
                shot["camera"]["orthographic"] = json!({"height": flat.height, "far": flat.far});
            }
        }
        if let Some(pose) = self.pose {
            shot["animation"] = json!({"clip": pose.clip, "time": rounded(pose.time)});
        }
        let lights = self.lights.iter().flatten();
        shot["lights"] = lights.map(|light| light.to_value(side)).collect();
        // A value of JSON values alone always has a text.
        serde_json::to_string_pretty(&shot).unwrap_or_default() + "\n"
    }

    /// Returns the lights, which are none before the scene is loaded.
    pub fn lights(&self) -> &[LightDoc] {
        self.lights.as_deref().unwrap_or_default()
    }
}

/// Returns the name of a light in the list.
pub fn light_name(index: usize, keys: &Map<String, Value>) -> String {
    let kind = keys.get("kind").and_then(Value::as_str).unwrap_or("light");
    format!("{kind} {index}")
}

/// Returns a path relative to a folder if it lies within or beside it, otherwise as it is.
fn relative(path: &Path, folder: &Path) -> PathBuf {
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    let (path, folder) = (absolute(path), absolute(folder));
    let shared = path.components().zip(folder.components());
    let shared = shared.take_while(|(a, b)| a == b).count();
    if shared <= 1 {
        return path;
    }
    let up = folder
        .components()
        .skip(shared)
        .map(|_| Path::new("..").to_owned());
    let rest: PathBuf = path.components().skip(shared).collect();
    up.chain([rest]).collect()
}
