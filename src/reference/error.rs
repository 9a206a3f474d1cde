//! The errors of the ray-cast judge.

use bevy_ecs::entity::Entity;
use glam::UVec2;

use crate::scene::LightError;

/// Why the judge gives no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// The camera's numbers make no projection.
    #[error(
        "camera with vertical field of view {vertical_fov}, near plane {near}, aspect {aspect} has no projection"
    )]
    Camera {
        /// Vertical field of view of the camera, radians.
        vertical_fov: f32,
        /// Distance of the near plane, metres.
        near: f32,
        /// Width of the picture divided by its height.
        aspect: f32,
    },
    /// The camera's transform is singular or not finite.
    #[error("the camera's transform is singular or not finite")]
    CameraTransform,
    /// The light's numbers or transform are not usable.
    #[error("light: {0}")]
    Light(#[from] LightError),
    /// The entity has no light with a `GlobalTransform`.
    #[error("entity {0} has no light with a global transform")]
    NotALight(Entity),
    /// The two images to compare differ in size.
    #[error("the truth is {truth} pixels, the image compared with it {got}")]
    Size {
        /// Size of the truth, pixels.
        truth: UVec2,
        /// Size of the image that is compared with the truth, pixels.
        got: UVec2,
    },
    /// The number of values in an image is not its width times its height.
    #[error("{values} values for an image of {size} pixels")]
    ValueCount {
        /// Size of the image, pixels.
        size: UVec2,
        /// Number of values given.
        values: usize,
    },
}
