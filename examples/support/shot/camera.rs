//! The view of a shot.

use antumbra::prelude::*;
use antumbra::scene::Orthographic;
use bevy_transform::prelude::Transform;
use glam::{Mat3, Quat, UVec2, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

/// The view of a shot.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShotCamera {
    /// Position, metres.
    pub eye: [f32; 3],
    /// Point that the camera looks at, metres.
    pub target: [f32; 3],
    /// Direction that is up in the picture.
    #[serde(default = "default_up")]
    pub up: [f32; 3],
    /// Vertical field of view, degrees, between 0 and 180. Default: 45.
    #[serde(default = "default_vfov")]
    #[schemars(extend("exclusiveMinimum" = 0, "exclusiveMaximum" = 180))]
    pub vfov_deg: f32,
    /// Distance of the near plane, metres. Default: 0.1.
    #[serde(default = "default_near")]
    pub near: f32,
    /// Makes the view orthographic; the field of view is then ignored.
    pub orthographic: Option<ShotOrthographic>,
}

/// An orthographic view.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShotOrthographic {
    /// Height of the area that the picture shows, metres.
    pub height: f32,
    /// Distance of the far plane, metres.
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
    /// Returns the camera component.
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

    /// Returns the camera's transform.
    ///
    /// # Errors
    /// Eye, target and up do not define an orientation.
    pub fn transform(&self) -> Result<Transform, String> {
        let eye = Vec3::from(self.eye);
        check_place(self.eye).map_err(|error| format!("eye {error}"))?;
        check_place(self.target).map_err(|error| format!("target {error}"))?;
        let forward = Vec3::from(self.target) - eye;
        let rotation = frame(forward, Vec3::from(self.up), "target - eye")?;
        Ok(Transform::from_translation(eye).with_rotation(rotation))
    }
}

/// Largest coordinate of a place, metres: that of triangles in the ray caster.
const FARTHEST: f32 = 1e15;

/// Sine of the angle between two directions below which they are parallel.
const PARALLEL: f32 = 1e-6;

/// Checks that a place is not too far away to compute with.
///
/// # Errors
/// Says which place is too far away.
pub fn check_place(place: [f32; 3]) -> Result<(), String> {
    if place.iter().all(|coordinate| coordinate.abs() <= FARTHEST) {
        return Ok(());
    }
    Err(format!(
        "{place:?} must be finite and within {FARTHEST:e} m of the origin"
    ))
}

/// Returns the unit vector along a vector of any length. `None` if the vector is not finite or has no length.
pub fn unit(vector: Vec3) -> Option<Vec3> {
    // The square of a length of 10³⁰ overflows.
    let longest = vector.abs().max_element();
    (longest > 0.0 && vector.is_finite()).then(|| (vector / longest).normalize())
}

/// Returns the rotation that takes −Z to `forward` and Y towards `up`; right = forward × up.
pub fn frame(forward: Vec3, up: Vec3, what: &str) -> Result<Quat, String> {
    let forward = unit(forward).ok_or_else(|| format!("{what} has no direction"))?;
    let right = unit(up)
        .map(|up| forward.cross(up))
        .filter(|right| right.length() > PARALLEL)
        .and_then(unit)
        .ok_or_else(|| format!("up is parallel to {what} or has no direction"))?;
    let matrix = Mat3::from_cols(right, right.cross(forward), -forward);
    Ok(Quat::from_mat3(&matrix))
}
