//! Why a technique does not shadow a light.

use bevy_ecs::prelude::Entity;

use crate::scene::{Light, LightKind};

/// Why a technique does not shadow a light that has its component. The light shines without a shadow then.
///
/// It is made anew in each frame in which the light is refused, and so it holds no text of its own.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// The technique does not fit the kind of light.
    #[error("it does not fit a {light} light: {instead}")]
    Kind {
        /// Kind of the light, as [`Refusal::kind`] names it.
        light: &'static str,
        /// What the technique needs, and what to use instead.
        instead: &'static str,
    },
    /// A number that nothing can be drawn with.
    #[error("{setting} is {value}{unit}: {allowed}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Its value.
        value: f32,
        /// Unit of the value with a space before it; empty for a bare number.
        unit: &'static str,
        /// What the setting may be.
        allowed: &'static str,
    },
}

impl Refusal {
    /// A technique that does not fit the kind of a light.
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

    /// A number without a unit that nothing can be drawn with.
    pub fn setting(setting: &'static str, value: f32, allowed: &'static str) -> Self {
        Self::Setting {
            setting,
            value,
            unit: "",
            allowed,
        }
    }

    /// Number of the fault among the reports of its technique. Those that a technique raises itself are below.
    pub(super) fn code(&self) -> u32 {
        match self {
            Self::Kind { .. } => u32::MAX,
            Self::Setting { .. } => u32::MAX - 1,
        }
    }
}

/// A light that its technique does not shadow, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RefusedLight {
    /// The light.
    pub entity: Entity,
    /// Index of the technique.
    pub row: usize,
    /// What is wrong.
    pub refusal: Refusal,
}
