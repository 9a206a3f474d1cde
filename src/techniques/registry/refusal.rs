//! The reasons why a technique does not shadow a light.

use bevy_ecs::prelude::Entity;

use crate::reports::code_of;
use crate::scene::{Light, LightKind};

/// The reason why a technique does not shadow a light that has its component. The light then shines without a
/// shadow.
///
/// The value is made again in each frame in which the light is refused, so it holds no allocated text.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The technique does not fit the kind of light.
    #[error("it does not fit a {light} light: {instead}")]
    Kind {
        /// Kind of the light, as [`Refusal::kind`] names it.
        light: &'static str,
        /// Text that says what the technique needs and what to use instead.
        instead: &'static str,
    },
    /// A setting has a value with which nothing can be drawn.
    #[error("{setting} is {value}{unit}: {allowed}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Value of the setting.
        value: f32,
        /// Unit of the value with a space before it; empty for a bare number.
        unit: &'static str,
        /// Text that says which values are allowed.
        allowed: &'static str,
    },
    /// A setting without a default is not given.
    #[error("{setting} is not given: {needed}")]
    Missing {
        /// Name of the setting.
        setting: &'static str,
        /// Text that says what the setting holds.
        needed: &'static str,
    },
}

impl Refusal {
    /// Makes the refusal of a light whose kind the technique does not fit.
    pub fn kind(light: &Light, instead: &'static str) -> Self {
        let light = match light.kind {
            LightKind::Point => "point",
            LightKind::Spot { .. } => "spot",
            LightKind::Directional => "directional",
            LightKind::Rect { .. } => "rectangle",
            LightKind::Sphere { .. } => "sphere",
        };
        Self::Kind { light, instead }
    }

    /// Makes the refusal of a setting, without a unit, with whose value nothing can be drawn.
    pub fn setting(setting: &'static str, value: f32, allowed: &'static str) -> Self {
        Self::Setting {
            setting,
            value,
            unit: "",
            allowed,
        }
    }

    /// Code of the refusal in the reports of its technique. It is another for each setting and each kind of light, but
    /// not for each value. The codes that a technique raises itself are lower.
    pub(super) fn code(&self) -> u32 {
        match self {
            Self::Kind { light, .. } => code_of(0, light),
            Self::Setting { setting, .. } => code_of(1, setting),
            Self::Missing { setting, .. } => code_of(2, setting),
        }
    }
}

/// A file that a light's settings name and that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{setting}: {problem}")]
pub struct FileError {
    /// Name of the setting.
    pub setting: &'static str,
    /// Text that names the file and says what is wrong with it.
    pub problem: String,
}

/// A light that its technique does not shadow, with the reason.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedLight {
    /// Entity of the light.
    pub entity: Entity,
    /// Index of the technique in [`Techniques::rows`](super::Techniques::rows).
    pub row: usize,
    /// Reason why the light is refused.
    pub refusal: Refusal,
}
