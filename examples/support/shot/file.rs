//! Reads and checks a shot.

use std::path::{Path, PathBuf};

use antumbra::scene::BlurredGround;
use antumbra::techniques::Techniques;
use glam::UVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::super::picture::light_texture;
use super::{ShotCamera, ShotEmission, ShotLight};

/// A shot. Unknown keys are errors.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// Path of the JSON Schema of shot files, by which editors complete and check this file.
    #[serde(rename = "$schema")]
    pub schema: Option<String>,
    /// Path of a glTF file, relative to the shot file.
    pub scene: PathBuf,
    /// The view. Default: the scene's first camera, or else one that frames the scene.
    pub camera: Option<ShotCamera>,
    /// Width and height of the picture, pixels.
    #[serde(default = "default_size")]
    pub size: [u32; 2],
    /// Ambient light, linear RGB radiance from everywhere.
    #[serde(default = "default_ambient")]
    pub ambient: [f32; 3],
    /// Pose of the scene. Default: the bind pose.
    pub animation: Option<ShotAnimation>,
    /// The lights. Default: those of the scene, with the first technique.
    pub lights: Option<Vec<ShotLight>>,
    /// Grounds, floors and walls on which perspective maps blur their shadows.
    #[serde(default)]
    pub blurred_grounds: Vec<ShotGround>,
    /// The techniques that the lights may name.
    #[serde(skip)]
    pub techniques: Techniques,
    /// The file that the shot was loaded from; empty for a text.
    #[serde(skip)]
    pub path: PathBuf,
}

/// The receivers below a node on which shadows are blurred.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShotGround {
    /// Name of nodes of the scene, which stand for themselves and all nodes below them.
    pub node: String,
    /// Standard deviation of the Gaussian, metres; greater than 0.
    #[serde(default = "default_radius")]
    #[schemars(range(min = 0))]
    pub radius: f32,
}

fn default_radius() -> f32 {
    BlurredGround::default().radius
}

/// A pose at a time of a clip.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShotAnimation {
    /// Index of the clip.
    pub clip: usize,
    /// Time within the clip, seconds.
    pub time: f32,
}

fn default_size() -> [u32; 2] {
    [640, 360]
}
fn default_ambient() -> [f32; 3] {
    [0.02; 3]
}

/// Least distance of a near plane, metres. Nearer ones show nothing more, and products with them leave the range of `f32`.
const LEAST_NEAR: f32 = 1e-6;

/// Returns a text without its byte order mark.
fn unmarked(text: &str) -> &str {
    text.strip_prefix('\u{feff}').unwrap_or(text)
}

impl Shot {
    /// Reads and checks a shot file.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn load(path: &Path, techniques: Techniques) -> Result<Self, String> {
        let text = Self::read(path)?;
        let mut shot =
            Self::parse(&text, techniques).map_err(|error| format!("{}: {error}", path.display()))?;
        shot.path = path.to_owned();
        let folder = path.parent().unwrap_or(Path::new(""));
        shot.scene = folder.join(&shot.scene);
        for (index, light) in shot.lights.iter_mut().flatten().enumerate() {
            light
                .model
                .find_files(folder)
                .map_err(|error| format!("{}: lights[{index}].{error}", path.display()))?;
            if let Some(shadow) = light.emission.shadow_mut() {
                shadow.find_files(folder, &shot.techniques);
            }
            if let ShotEmission::Rect {
                texture: Some(texture),
                ..
            } = &mut light.emission
            {
                *texture = folder.join(&*texture);
                // The picture is read here only to report errors with the shot file's name. It is read again when the
                // light is spawned.
                light_texture(texture)
                    .map_err(|error| format!("{}: lights[{index}].texture: {error}", path.display()))?;
            }
        }
        Ok(shot)
    }

    /// Returns the text of a shot file, without its byte order mark.
    ///
    /// # Errors
    /// One line that names the file.
    pub fn read(path: &Path) -> Result<String, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok(unmarked(&text).to_owned())
    }

    /// Parses and checks the text of a shot file.
    ///
    /// # Errors
    /// One line that names the element.
    pub fn parse(text: &str, techniques: Techniques) -> Result<Self, String> {
        let mut json = serde_json::Deserializer::from_str(unmarked(text));
        let mut shot: Self = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            match error.path().to_string().as_str() {
                "." => error.inner().to_string(), // the shot as a whole has no name
                element => format!("{element}: {}", error.inner()),
            }
        })?;
        json.end().map_err(|error| format!("after the shot: {error}"))?;
        shot.techniques = techniques;
        shot.check()?;
        Ok(shot)
    }

    fn check(&self) -> Result<(), String> {
        if self.ambient.iter().any(|a| !(a.is_finite() && *a >= 0.0)) {
            return Err(format!(
                "ambient: {:?} must be finite and at least 0",
                self.ambient
            ));
        }
        if let Some(camera) = &self.camera {
            camera.transform().map_err(|error| format!("camera: {error}"))?;
            if camera.orthographic.is_none() && camera.near > 0.0 && camera.near < LEAST_NEAR {
                return Err(format!(
                    "camera.near: {:e} must be at least {LEAST_NEAR:e} m",
                    camera.near
                ));
            }
            if !camera.camera(UVec2::ONE).is_valid() {
                return Err(match camera.orthographic {
                    None => format!(
                        "camera: vfov_deg {} must be in 0..180 and near {} greater than 0",
                        camera.vfov_deg, camera.near
                    ),
                    Some(view) => format!(
                        "camera: orthographic height {} must be greater than 0, and far {} greater than near {}",
                        view.height, view.far, camera.near
                    ),
                });
            }
        }
        if let Some(animation) = self.animation.filter(|animation| !animation.time.is_finite()) {
            return Err(format!("animation.time: {} must be finite", animation.time));
        }
        for (index, ground) in self.blurred_grounds.iter().enumerate() {
            if !(ground.radius > 0.0 && ground.radius.is_finite()) {
                return Err(format!(
                    "blurred_grounds[{index}].radius: {} must be finite and greater than 0",
                    ground.radius
                ));
            }
        }
        for (index, light) in self.lights.iter().flatten().enumerate() {
            light
                .parts(&self.techniques)
                .map_err(|error| format!("lights[{index}]: {error}"))?;
        }
        Ok(())
    }

    /// Returns the size of the picture, pixels.
    pub fn size(&self) -> UVec2 {
        UVec2::from(self.size)
    }
}
