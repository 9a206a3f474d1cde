//! What is edited: a scene with a camera and lights, as a shot file holds it, with two techniques for each light.

use std::path::{Path, PathBuf};

use antumbra::prelude::*;
use antumbra::techniques::{Row, Techniques};
use antumbra_stage::shadow::nest_softness;
use antumbra_stage::shot::{LightParts, Shot, ShotGround, ShotLight};
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
    /// Grounds on which perspective maps blur their shadows.
    pub blurred_grounds: Vec<ShotGround>,
    /// The file or address of the JSON Schema from which editors complete the shot file.
    pub schema: Option<PathBuf>,
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
            blurred_grounds: Vec::new(),
            schema: None,
        }
    }
}

/// Keys of a light that only some techniques take.
const SPECIAL: [&str; 3] = [PATH, "angle_deg", "texture"];

/// Key of the path along which a light moves.
const PATH: &str = "path";

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
        others
            .find(|shadow| self.fits(shadow, techniques))
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

    /// Returns the keys of the light in a shot file.
    pub fn to_keys(&self, side: Side) -> Map<String, Value> {
        let mut keys = self.keys.clone();
        let shadow = self.shadows[side.index()].clone();
        keys.insert("shadow".to_owned(), Value::Object(shadow));
        keys
    }

    /// Makes the parts of the light, without the keys of [`SPECIAL`] whose bits are set.
    fn parts_without(
        &self,
        bits: usize,
        shadow: Option<&Map<String, Value>>,
        techniques: &Techniques,
    ) -> Result<LightParts, String> {
        let is_left_out = |key: &str| {
            let index = SPECIAL.iter().position(|special| *special == key);
            index.is_some_and(|index| bits >> index & 1 == 1)
        };
        let mut keys = self.keys.clone();
        // A path also places the light, so it is read before it is left out.
        keys.retain(|key, _| key == PATH || !is_left_out(key));
        if let Some(shadow) = shadow {
            keys.insert("shadow".to_owned(), Value::Object(shadow.clone()));
        }
        let mut light = ShotLight::try_from(keys)?;
        if is_left_out(PATH) {
            light.path = None;
        }
        light.parts(techniques)
    }

    /// Makes the parts of the light. Keys of [`SPECIAL`] that the technique does not take are left out, because the
    /// technique of the other side may need them. In that case the second value says what was left out and why.
    fn parts_with(
        &self,
        shadow: Option<&Map<String, Value>>,
        techniques: &Techniques,
    ) -> Result<(LightParts, Option<String>), String> {
        let refused = match self.parts_without(0, shadow, techniques) {
            Ok(parts) => return Ok((parts, None)),
            Err(error) => error,
        };
        let all = SPECIAL.iter().enumerate();
        let there = all.filter(|(_, key)| self.keys.contains_key(**key));
        let there = there.fold(0_usize, |bits, (index, _)| bits | 1 << index);
        // As few as possible are left out.
        let mut choices: Vec<usize> = (1..1 << SPECIAL.len())
            .filter(|bits| bits & !there == 0)
            .collect();
        choices.sort_by_key(|bits| bits.count_ones());
        let found = choices
            .into_iter()
            .find_map(|bits| self.parts_without(bits, shadow, techniques).ok());
        found.map(|parts| (parts, Some(refused.clone()))).ok_or(refused)
    }

    /// Returns what to spawn for the light, and a note if a key is left out that the technique does not take.
    ///
    /// # Errors
    /// A key or a setting that cannot be used.
    pub fn parts(&self, side: Side, techniques: &Techniques) -> Result<(LightParts, Option<String>), String> {
        self.parts_with(Some(&self.shadows[side.index()]), techniques)
    }

    /// Returns what to spawn for the light without a shadow.
    ///
    /// # Errors
    /// A key that cannot be used.
    pub fn bare_parts(&self, techniques: &Techniques) -> Result<LightParts, String> {
        self.parts_with(None, techniques).map(|(parts, _)| parts)
    }

    /// Whether a value of `shadow` can be used for the light.
    pub fn fits(&self, shadow: &Map<String, Value>, techniques: &Techniques) -> bool {
        self.parts_with(Some(shadow), techniques).is_ok()
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

/// Rounds to six digits, so that saved files stay readable at any scale. What is left of a zero becomes one.
pub fn rounded(value: f32) -> f64 {
    if value.abs() < 1e-7 {
        return 0.0;
    }
    format!("{value:.5e}").parse().unwrap_or(f64::from(value))
}

/// Returns the number with the digits that an `f32` has, so that it is read back as it is.
fn exactly(value: f32) -> f64 {
    value.to_string().parse().unwrap_or(f64::from(value))
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
            "width": exactly(width),
            "height": exactly(height),
        }),
        LightKind::Sphere { radius } => json!({"kind": "sphere", "radius": exactly(radius)}),
    };
    if light.kind != LightKind::Directional {
        value["position"] = json!(transform.translation.to_array().map(rounded));
        if light.range.is_finite() {
            value["range"] = json!(exactly(light.range));
        }
    }
    value["color"] = json!(light.color.to_array().map(rounded));
    value["intensity"] = json!(rounded(light.intensity));
    match value {
        Value::Object(keys) => keys,
        _ => Map::new(),
    }
}

/// Changes all paths of a light and of its technique, but no empty ones.
fn change_paths(light: &mut Map<String, Value>, techniques: &Techniques, change: &dyn Fn(&Path) -> PathBuf) {
    let apply = |value: &mut Value| {
        if let Some(path) = value.as_str().filter(|path| !path.is_empty()) {
            *value = json!(change(Path::new(path)));
        }
    };
    for key in ["profile", "texture"] {
        light.get_mut(key).into_iter().for_each(apply);
    }
    let of_techniques = techniques.rows().iter().flat_map(Row::paths);
    let of_techniques = of_techniques.map(|path| ("shadow", *path));
    for pointer in [("cookie", "path")].into_iter().chain(of_techniques) {
        let inner = light
            .get_mut(pointer.0)
            .and_then(|inner| inner.get_mut(pointer.1));
        inner.into_iter().for_each(apply);
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
                change_paths(&mut keys, techniques, &|path| folder.join(path));
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
            blurred_grounds: shot.blurred_grounds,
            schema: value.get("$schema").and_then(Value::as_str).map(|schema| {
                if schema.contains("://") {
                    PathBuf::from(schema)
                } else {
                    folder.join(schema)
                }
            }),
        })
    }

    /// Returns the text of a shot file with the techniques of a side. Paths are relative to `folder` where they can
    /// be.
    pub fn to_shot(&self, side: Side, size: [u32; 2], folder: &Path, techniques: &Techniques) -> String {
        let mut shot = json!({
            "scene": relative(&self.scene, folder),
            "size": size,
            "ambient": self.ambient.map(exactly),
        });
        if let Some(view) = &self.view {
            shot["camera"] = json!({
                "eye": view.eye.to_array().map(rounded),
                "target": view.target.to_array().map(rounded),
                "up": view.up.to_array().map(rounded),
                "vfov_deg": rounded(view.camera.vertical_fov.to_degrees()),
                "near": exactly(view.camera.near),
            });
            if let Some(flat) = view.camera.orthographic {
                shot["camera"]["orthographic"] =
                    json!({"height": exactly(flat.height), "far": exactly(flat.far)});
            }
        }
        if let Some(pose) = self.pose {
            shot["animation"] = json!({"clip": pose.clip, "time": rounded(pose.time)});
        }
        let lights = self.lights.iter().flatten().map(|light| {
            let mut keys = light.to_keys(side);
            change_paths(&mut keys, techniques, &|path| relative(path, folder));
            Value::Object(keys)
        });
        shot["lights"] = lights.collect();
        if !self.blurred_grounds.is_empty() {
            let grounds = self.blurred_grounds.iter();
            let grounds =
                grounds.map(|ground| json!({"node": ground.node, "radius": exactly(ground.radius)}));
            shot["blurred_grounds"] = grounds.collect();
        }
        if let Some(schema) = &self.schema {
            let is_address = schema.to_string_lossy().contains("://");
            shot["$schema"] = if is_address {
                json!(schema)
            } else {
                json!(relative(schema, folder))
            };
        }
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
