//! Kind, place and brightness of a shot's light, with its technique.

use std::path::PathBuf;

use antumbra::prelude::*;
use antumbra::techniques::{Row, Settings, Techniques};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};
use schemars::JsonSchema;
use serde::Deserialize;

use super::super::shadow::ShotShadow;
use super::camera::{check_place, frame, unit};
use super::light::LightParts;
use super::model::ShotModel;

/// Luminous intensity of a light at a position that says nothing of it, candela.
const CANDELA: f32 = 60.0;

/// Illuminance by a directional light that says nothing of it, lux.
const LUX: f32 = 3.0;

/// Kind, place and brightness of a light, and its technique.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum ShotEmission {
    /// A light that shines from a point.
    Point {
        /// Position, metres.
        position: [f32; 3],
        /// Distance beyond which nothing is lit, metres; greater than 0. Higher values light more and cost
        /// more. Default: no limit.
        #[schemars(range(min = 0))]
        range: Option<f32>,
        /// Colour, linear RGB, at least 0. Default: white.
        #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
        color: Option<[f32; 3]>,
        /// Luminous intensity, candela, at least 0. Default: 60.
        #[schemars(range(min = 0), extend("default" = CANDELA))]
        intensity: Option<f32>,
        /// Shadow technique and its settings. Default: no shadow.
        shadow: Option<ShotShadow>,
    },
    /// A light that shines from a point into a cone.
    Spot {
        /// Position, metres.
        position: [f32; 3],
        /// Direction in which the light shines; of any length.
        direction: [f32; 3],
        /// Half-angle of the cone of full intensity, degrees; at most `outer_deg`.
        #[schemars(range(min = 0, max = 90))]
        inner_deg: f32,
        /// Half-angle of the whole cone, degrees.
        #[schemars(range(min = 0, max = 90))]
        outer_deg: f32,
        /// Distance beyond which nothing is lit, metres; greater than 0. Higher values light more and cost
        /// more. Default: no limit.
        #[schemars(range(min = 0))]
        range: Option<f32>,
        /// Colour, linear RGB, at least 0. Default: white.
        #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
        color: Option<[f32; 3]>,
        /// Luminous intensity, candela, at least 0. Default: 60.
        #[schemars(range(min = 0), extend("default" = CANDELA))]
        intensity: Option<f32>,
        /// Shadow technique and its settings. Default: no shadow.
        shadow: Option<ShotShadow>,
    },
    /// A light that shines from infinity.
    Directional {
        /// Direction in which the light shines; of any length.
        direction: [f32; 3],
        /// Angle that the light covers in the sky, degrees, for techniques that have this setting. A light without
        /// `shadow` must not have it.
        #[schemars(range(min = 0, max = 180))]
        angle_deg: Option<f32>,
        /// Colour, linear RGB, at least 0. Default: white.
        #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
        color: Option<[f32; 3]>,
        /// Illuminance, lux, at least 0. Default: 3.
        #[schemars(range(min = 0), extend("default" = LUX))]
        intensity: Option<f32>,
        /// Shadow technique and its settings. Default: no shadow.
        shadow: Option<ShotShadow>,
    },
    /// A light that shines from a rectangle.
    Rect {
        /// Position, metres.
        position: [f32; 3],
        /// Direction in which the light shines; of any length.
        direction: [f32; 3],
        /// Direction of the height. Default: +Y as far as the direction allows, and +X where it points up or down.
        up: Option<[f32; 3]>,
        /// Width, metres.
        #[schemars(range(min = 0))]
        width: f32,
        /// Height, metres.
        #[schemars(range(min = 0))]
        height: f32,
        /// Path of a picture with the light's colours, relative to the shot file; for `penumbra_wedge`.
        texture: Option<PathBuf>,
        /// Distance beyond which nothing is lit, metres; greater than 0. Higher values light more and cost
        /// more. Default: no limit.
        #[schemars(range(min = 0))]
        range: Option<f32>,
        /// Colour, linear RGB, at least 0. Default: white.
        #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
        color: Option<[f32; 3]>,
        /// Luminous intensity, candela, at least 0. Default: 60.
        #[schemars(range(min = 0), extend("default" = CANDELA))]
        intensity: Option<f32>,
        /// Shadow technique and its settings. Default: no shadow.
        shadow: Option<ShotShadow>,
    },
    /// A light that shines from a sphere.
    Sphere {
        /// Position, metres.
        position: [f32; 3],
        /// Radius, metres.
        #[schemars(range(min = 0))]
        radius: f32,
        /// Distance beyond which nothing is lit, metres; greater than 0. Higher values light more and cost
        /// more. Default: no limit.
        #[schemars(range(min = 0))]
        range: Option<f32>,
        /// Colour, linear RGB, at least 0. Default: white.
        #[schemars(extend("default" = [1.0, 1.0, 1.0]))]
        color: Option<[f32; 3]>,
        /// Luminous intensity, candela, at least 0. Default: 60.
        #[schemars(range(min = 0), extend("default" = CANDELA))]
        intensity: Option<f32>,
        /// Shadow technique and its settings. Default: no shadow.
        shadow: Option<ShotShadow>,
    },
}

/// Returns a rotation like [`frame`], for lights whose turn about their axis does not matter.
fn axis_frame(direction: [f32; 3]) -> Result<Quat, String> {
    let direction = unit(direction.into()).unwrap_or_default();
    let up = if direction.y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
    frame(direction, up, "direction")
}

/// Returns a rotation like [`frame`], with Y as far up as the direction allows, or towards X where it points up or down.
fn level_frame(direction: [f32; 3]) -> Result<Quat, String> {
    frame(direction.into(), Vec3::Y, "direction").or_else(|_| frame(direction.into(), Vec3::X, "direction"))
}

impl ShotEmission {
    /// Returns the parts to spawn, without a light model.
    ///
    /// # Errors
    /// A number of the light, or a setting of its technique, is wrong.
    pub(super) fn parts(&self, techniques: &Techniques) -> Result<LightParts, String> {
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
                angle_deg,
                color,
                intensity,
                shadow,
            } => (
                LightKind::Directional,
                Transform::from_rotation(axis_frame(direction)?),
                None,
                color,
                intensity.or(Some(LUX)),
                match (angle_deg, shadow) {
                    (Some(angle), Some(shadow)) => Some(shadow.with("angle_deg", angle)?),
                    (Some(_), None) => {
                        let advice = "add a shadow of a technique that has this setting, or leave it out";
                        return Err(format!("angle_deg: the light has no shadow to soften; {advice}"));
                    }
                    (None, shadow) => shadow,
                },
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
                        None => level_frame(direction)?,
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
        check_place(transform.translation.to_array()).map_err(|error| format!("position {error}"))?;
        let light = Light {
            kind,
            color: color.unwrap_or([1.0; 3]).into(),
            intensity: intensity.unwrap_or(CANDELA),
            range: range.unwrap_or(f32::INFINITY),
        };
        light.validate().map_err(|error| error.to_string())?;
        let given = shadow;
        let settings = |of: fn(&ShotShadow, &Techniques) -> Result<Option<Settings>, String>, key: &str| {
            let settings = given
                .as_ref()
                .map(|shadow| of(shadow, techniques))
                .transpose()?
                .flatten();
            let checked = settings
                .as_ref()
                .map_or(Ok(()), |settings| settings.check(&light));
            checked.map_err(|error| format!("{key}: {error}"))?;
            Ok::<_, String>(settings)
        };
        let shadow = settings(ShotShadow::settings, "shadow")?;
        let moving = settings(ShotShadow::moving, "shadow.moving")?;
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
            moving,
            texture: picture,
            model: ShotModel::default(),
            path: None,
        })
    }

    /// The technique of the light as the file has it, if any.
    pub fn shadow_mut(&mut self) -> Option<&mut ShotShadow> {
        let (Self::Point { shadow, .. }
        | Self::Spot { shadow, .. }
        | Self::Directional { shadow, .. }
        | Self::Rect { shadow, .. }
        | Self::Sphere { shadow, .. }) = self;
        shadow.as_mut()
    }
}
