//! The shot file: a scene, a camera, lights, and the size of the picture, as JSON.

use std::path::{Path, PathBuf};

use antumbra::prelude::*;
use antumbra::scene::Orthographic;
use bevy_transform::prelude::Transform;
use glam::{Mat3, Quat, UVec2, Vec3};
use serde::Deserialize;

use super::picture::light_texture;
use super::shadow::ShotShadow;

/// A shot. Unknown keys are errors.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Shot {
    /// Path of a glTF file, relative to the shot file.
    pub scene: PathBuf,
    /// Absent: the scene's first camera, else one that frames the scene.
    pub camera: Option<ShotCamera>,
    /// Width and height, pixels.
    #[serde(default = "default_size")]
    pub size: [u32; 2],
    /// Linear RGB radiance from everywhere.
    #[serde(default = "default_ambient")]
    pub ambient: [f32; 3],
    /// Poses the scene.
    pub animation: Option<ShotAnimation>,
    /// Absent: those of the scene, with stencil volumes.
    pub lights: Option<Vec<ShotLight>>,
}

/// The view.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotCamera {
    /// Position, metres.
    pub eye: [f32; 3],
    /// What it looks at.
    pub target: [f32; 3],
    /// Up.
    #[serde(default = "default_up")]
    pub up: [f32; 3],
    /// Vertical field of view, degrees.
    #[serde(default = "default_vfov")]
    pub vfov_deg: f32,
    /// Near plane, metres.
    #[serde(default = "default_near")]
    pub near: f32,
    /// In place of the field of view.
    pub orthographic: Option<ShotOrthographic>,
}

/// An orthographic view.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotOrthographic {
    /// Of what the picture shows, metres.
    pub height: f32,
    /// Far plane, metres.
    pub far: f32,
}

/// A pose in time.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ShotAnimation {
    /// Index of the clip.
    pub clip: usize,
    /// Seconds.
    pub time: f32,
}

/// A light.
#[derive(Clone, Debug, Deserialize)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShotLight {
    /// From a point.
    Point {
        /// Metres.
        position: [f32; 3],
        /// What all lights have.
        range: Option<f32>,
        color: Option<[f32; 3]>,
        intensity: Option<f32>,
        shadow: Option<ShotShadow>,
    },
    /// From a point into a cone.
    Spot {
        position: [f32; 3],
        direction: [f32; 3],
        inner_deg: f32,
        outer_deg: f32,
        range: Option<f32>,
        color: Option<[f32; 3]>,
        intensity: Option<f32>,
        shadow: Option<ShotShadow>,
    },
    /// From infinity.
    Directional {
        direction: [f32; 3],
        color: Option<[f32; 3]>,
        intensity: Option<f32>,
        shadow: Option<ShotShadow>,
    },
    /// From a rectangle.
    Rect {
        position: [f32; 3],
        direction: [f32; 3],
        up: Option<[f32; 3]>,
        width: f32,
        height: f32,
        /// Path of a picture that the light has the colours of, relative to the shot file; for `penumbra_wedge`.
        texture: Option<PathBuf>,
        range: Option<f32>,
        color: Option<[f32; 3]>,
        intensity: Option<f32>,
        shadow: Option<ShotShadow>,
    },
    /// From a sphere.
    Sphere {
        position: [f32; 3],
        radius: f32,
        range: Option<f32>,
        color: Option<[f32; 3]>,
        intensity: Option<f32>,
        shadow: Option<ShotShadow>,
    },
}

fn default_size() -> [u32; 2] {
    [640, 360]
}
fn default_ambient() -> [f32; 3] {
    [0.02; 3]
}
fn default_up() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}
fn default_vfov() -> f32 {
    45.0
}
fn default_near() -> f32 {
    0.1
}

/// What is spawned for a light.
#[derive(Clone, Debug)]
pub struct LightParts {
    /// The component.
    pub light: Light,
    /// Where it stands and shines to.
    pub transform: Transform,
    /// Its technique, if any.
    pub shadow: Option<ShotShadow>,
    /// Path of its picture, if any.
    pub texture: Option<PathBuf>,
}

impl Shot {
    /// Reads and checks a shot file.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn load(path: &Path) -> Result<Self, String> {
        let text = std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))?;
        let mut shot = Self::parse(&text).map_err(|error| format!("{}: {error}", path.display()))?;
        let folder = path.parent().unwrap_or(Path::new(""));
        shot.scene = folder.join(&shot.scene);
        for (index, light) in shot.lights.iter_mut().flatten().enumerate() {
            if let ShotLight::Rect {
                texture: Some(texture),
                ..
            } = light
            {
                *texture = folder.join(&*texture);
                // Here, where the shot file is known; it is read again when the light is made.
                light_texture(texture)
                    .map_err(|error| format!("{}: lights[{index}].texture: {error}", path.display()))?;
            }
        }
        Ok(shot)
    }

    /// Parses and checks the text of a shot file.
    ///
    /// # Errors
    /// One line that names the element.
    pub fn parse(text: &str) -> Result<Self, String> {
        let mut json = serde_json::Deserializer::from_str(text);
        let shot: Self = serde_path_to_error::deserialize(&mut json).map_err(|error| {
            let element = error.path().to_string();
            format!("{element}: {}", error.inner())
        })?;
        json.end().map_err(|error| format!("after the shot: {error}"))?;
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
        for (index, light) in self.lights.iter().flatten().enumerate() {
            light
                .parts()
                .map_err(|error| format!("lights[{index}]: {error}"))?;
        }
        Ok(())
    }

    /// Size of the picture.
    pub fn size(&self) -> UVec2 {
        UVec2::from(self.size)
    }
}

impl ShotCamera {
    /// The component.
    pub fn camera(&self, size: UVec2) -> Camera {
        Camera {
            vertical_fov: self.vfov_deg.to_radians(),
            near: self.near,
            aspect: size.x as f32 / size.y.max(1) as f32,
            orthographic: self.orthographic.map(|view| Orthographic {
                height: view.height,
                far: view.far,
            }),
            ..Camera::default()
        }
    }

    /// Where it stands.
    ///
    /// # Errors
    /// If eye, target and up give no frame.
    pub fn transform(&self) -> Result<Transform, String> {
        let eye = Vec3::from(self.eye);
        let forward = Vec3::from(self.target) - eye;
        let rotation = frame(forward, Vec3::from(self.up), "target - eye")?;
        if !eye.is_finite() {
            return Err(format!("eye {:?} is not finite", self.eye));
        }
        Ok(Transform::from_translation(eye).with_rotation(rotation))
    }
}

/// The rotation that takes −Z to `forward` and Y towards `up`; right = forward × up.
fn frame(forward: Vec3, up: Vec3, what: &str) -> Result<Quat, String> {
    let forward = forward
        .try_normalize()
        .ok_or_else(|| format!("{what} has no direction"))?;
    let right = forward
        .cross(up)
        .try_normalize()
        .ok_or_else(|| format!("up is parallel to {what} or has no direction"))?;
    let matrix = Mat3::from_cols(right, right.cross(forward), -forward);
    Ok(Quat::from_mat3(&matrix))
}

/// As [`frame`] for lights whose turn about their axis does not matter.
fn axis_frame(direction: [f32; 3]) -> Result<Quat, String> {
    let direction = Vec3::from(direction);
    let up = if direction.y.abs() > 0.9 * direction.length() {
        Vec3::X
    } else {
        Vec3::Y
    };
    frame(direction, up, "direction")
}

impl ShotLight {
    /// What to spawn.
    ///
    /// # Errors
    /// What is wrong with its numbers.
    pub fn parts(&self) -> Result<LightParts, String> {
        const CANDELA: f32 = 60.0;
        const LUX: f32 = 3.0;
        let at = |p: [f32; 3]| Transform::from_translation(p.into());
        let mut picture = None;
        let (kind, transform, range, color, intensity, shadow) = match self.clone() {
            Self::Point {
                position,
                range,
                color,
                intensity,
                shadow,
            } => (LightKind::Point, at(position), range, color, intensity, shadow),
            Self::Spot {
                position,
                direction,
                inner_deg,
                outer_deg,
                range,
                color,
                intensity,
                shadow,
            } => (
                LightKind::Spot {
                    inner_angle: inner_deg.to_radians(),
                    outer_angle: outer_deg.to_radians(),
                },
                at(position).with_rotation(axis_frame(direction)?),
                range,
                color,
                intensity,
                shadow,
            ),
            Self::Directional {
                direction,
                color,
                intensity,
                shadow,
            } => (
                LightKind::Directional,
                Transform::from_rotation(axis_frame(direction)?),
                None,
                color,
                intensity.or(Some(LUX)),
                shadow,
            ),
            Self::Rect {
                position,
                direction,
                up,
                width,
                height,
                texture,
                range,
                color,
                intensity,
                shadow,
            } => {
                picture = texture;
                (
                    LightKind::Rect { width, height },
                    at(position).with_rotation(match up {
                        Some(up) => frame(direction.into(), up.into(), "direction")?,
                        None => frame(direction.into(), Vec3::Y, "direction")?,
                    }),
                    range,
                    color,
                    intensity,
                    shadow,
                )
            }
            Self::Sphere {
                position,
                radius,
                range,
                color,
                intensity,
                shadow,
            } => (
                LightKind::Sphere { radius },
                at(position),
                range,
                color,
                intensity,
                shadow,
            ),
        };
        if !transform.is_finite() {
            return Err("its position is not finite".to_owned());
        }
        let light = Light {
            kind,
            color: color.unwrap_or([1.0; 3]).into(),
            intensity: intensity.unwrap_or(CANDELA),
            range: range.unwrap_or(f32::INFINITY),
        };
        light.validate().map_err(|error| error.to_string())?;
        if let Some(shadow) = shadow {
            shadow.check(&light)?;
        }
        if picture.is_some() && !matches!(shadow, Some(ShotShadow::PenumbraWedge { .. })) {
            return Err("texture: needs the technique penumbra_wedge".to_owned());
        }
        Ok(LightParts {
            light,
            transform,
            shadow,
            texture: picture,
        })
    }
}
