//! What the judge refuses.

use bevy_ecs::entity::Entity;
use glam::UVec2;

use crate::scene::LightError;

/// Why the judge gives no answer.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// Numbers of the camera that make no projection.
    #[error(
        "camera with vertical field of view {vertical_fov}, near plane {near}, aspect {aspect} has no projection"
    )]
    Camera {
        /// Radians.
        vertical_fov: f32,
        /// Metres.
        near: f32,
        /// Width over height.
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
    /// Two images that are compared differ in size.
    #[error("the truth is {truth} pixels, the image compared with it {got}")]
    Size {
        /// Size of the truth.
        truth: UVec2,
        /// Size of the other.
        got: UVec2,
    },
    /// An image's number of values is not its width times its height.
    #[error("{values} values for an image of {size} pixels")]
    ValueCount {
        /// Pixels.
        size: UVec2,
        /// Values given.
        values: usize,
    },
}
