//! The view of a shot.

use antumbra::prelude::*;
use antumbra::scene::Orthographic;
use bevy_transform::prelude::Transform;
use glam::{Mat3, Quat, UVec2, Vec3};
use serde::Deserialize;

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

fn default_up() -> [f32; 3] {
    [0.0, 1.0, 0.0]
}
fn default_vfov() -> f32 {
    45.0
}
fn default_near() -> f32 {
    0.1
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
pub fn frame(forward: Vec3, up: Vec3, what: &str) -> Result<Quat, String> {
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
