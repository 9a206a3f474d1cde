//! The lights of a shot, and what is spawned for them.

use std::path::PathBuf;

use antumbra::prelude::*;
use antumbra::techniques::{Row, Settings, Techniques};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};
use serde::Deserialize;

use super::super::shadow::ShotShadow;
use super::camera::frame;

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

/// What is spawned for a light.
#[derive(Clone, Debug)]
pub struct LightParts {
    /// The component.
    pub light: Light,
    /// Where it stands and shines to.
    pub transform: Transform,
    /// Its technique and the settings, if any.
    pub shadow: Option<Settings>,
    /// Path of its picture, if any.
    pub texture: Option<PathBuf>,
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
    /// What is wrong with its numbers, and with the settings of its technique.
    pub fn parts(&self, techniques: &Techniques) -> Result<LightParts, String> {
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
        let shadow = shadow
            .map(|shadow| shadow.settings(techniques))
            .transpose()?
            .flatten();
        if let Some(shadow) = &shadow {
            shadow.check(&light).map_err(|error| format!("shadow: {error}"))?;
        }
        let shows = |row: Row| row.needs().emitter_texture;
        if picture.is_some() && !shadow.as_ref().is_some_and(|shadow| shows(shadow.row())) {
            let rows = techniques.rows().iter().filter(|row| shows(**row));
            let names: Vec<&str> = rows.map(Row::name).collect();
            return Err(format!("texture: needs the technique {}", names.join(" or ")));
        }
        Ok(LightParts {
            light,
            transform,
            shadow,
            texture: picture,
        })
    }
}
