//! What is edited: a scene with a camera and lights, as a shot file holds it, with two techniques for each light.

use std::path::{Path, PathBuf};

use antumbra::prelude::*;
use antumbra::techniques::{Row, Techniques};
use antumbra_stage::shot::{Shot, ShotGround};
use glam::Vec3;
use serde::Deserialize;
use serde_json::{Map, Value, json};

pub use crate::light::{LightDoc, NONE, exactly, light_name, light_value, rounded, shadow_of};

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
        let text = Shot::read(path)?;
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
                "eye": view.eye.to_array().map(exactly),
                "target": view.target.to_array().map(exactly),
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
            shot["animation"] = json!({"clip": pose.clip, "time": exactly(pose.time)});
        }
        let lights = self.lights.iter().flatten().map(|light| {
            let mut keys = light.saved_keys(side, techniques);
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
