//! The path of a light in a shot.

use antumbra::scene::{LightKind, LightPath};
use glam::Vec3;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value, json};

use super::light::LightParts;

/// The path of a light. A key tells the kinds apart.
#[derive(Clone, Debug, PartialEq, JsonSchema)]
#[schemars(untagged)]
pub enum ShotPath {
    /// The direction turns about an axis.
    Arc(ShotArc),
    /// The light is the sun of a day.
    Sun(ShotSun),
    /// The light moves along a polyline.
    Positions(ShotPositions),
}

/// An arc.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "arc")]
pub struct ShotArc {
    /// Axis about which the direction of the light turns; of any length.
    #[schemars(example = [0, 0, 1])]
    axis: [f32; 3],
    /// Angle of the whole path, degrees.
    #[schemars(example = 150)]
    degrees: f32,
}

/// A day of the sun.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "sun")]
pub struct ShotSun {
    /// Latitude, degrees; north is positive.
    #[schemars(range(min = -90, max = 90), example = 50)]
    latitude_deg: f32,
    /// Day of the year, 1 to 366.
    #[schemars(range(min = 1, max = 366), example = 172)]
    day: f32,
    /// First and last hour of the path, 0 to 24. Default: the whole day, from midnight.
    #[serde(default = "whole_day")]
    hours: [f32; 2],
}

/// A polyline.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShotPositions {
    /// Points of the polyline, metres.
    #[schemars(example = [[0, 2, 0], [4, 2, 0]])]
    positions: Vec<[f32; 3]>,
}

fn whole_day() -> [f32; 2] {
    [0.0, 24.0]
}

fn parse<'de, T: Deserialize<'de>>(value: Value) -> Result<T, String> {
    serde_path_to_error::deserialize(value).map_err(|error| match error.path().to_string().as_str() {
        "." => format!("path: {}", error.inner()),
        path => format!("path.{path}: {}", error.inner()),
    })
}

impl ShotPath {
    /// Takes the path out of a light's keys, and reads it.
    ///
    /// # Errors
    /// Names the key and says what is wrong with it.
    pub fn take(light: &mut Map<String, Value>) -> Result<Option<Self>, String> {
        let Some(value) = light.remove("path") else {
            return Ok(None);
        };
        let has = |key: &str| value.get(key).is_some();
        let path = if has("axis") || has("degrees") {
            Self::Arc(parse(value)?)
        } else if has("latitude_deg") || has("day") {
            Self::Sun(parse(value)?)
        } else if has("positions") {
            Self::Positions(parse(value)?)
        } else {
            return Err("path: needs axis and degrees, or latitude_deg and day, or positions".to_owned());
        };
        path.complete(light);
        Ok(Some(path))
    }

    /// Adds the keys of the light that the path makes superfluous.
    fn complete(&self, light: &mut Map<String, Value>) {
        let is_directional = light.get("kind").is_some_and(|kind| kind == "directional");
        let (key, value) = match self {
            Self::Sun(_) if is_directional => ("direction", json!([0, -1, 0])),
            Self::Positions(line) if !is_directional => {
                ("position", json!(line.positions.first().unwrap_or(&[0.0; 3])))
            }
            _ => return,
        };
        light.entry(key).or_insert(value);
    }

    /// The path of a light that is otherwise complete.
    ///
    /// # Errors
    /// The path does not fit the light, or a number of it is wrong.
    pub fn of_light(&self, light: &LightParts) -> Result<LightPath, String> {
        let path = match self {
            Self::Arc(arc) => LightPath::Arc {
                direction: Vec3::from(light.transform.forward()),
                axis: arc.axis.into(),
                degrees: arc.degrees,
            },
            Self::Sun(sun) => LightPath::Sun {
                latitude_degrees: sun.latitude_deg,
                day: sun.day,
                hours: sun.hours,
            },
            Self::Positions(line) => {
                LightPath::Positions(line.positions.iter().copied().map(Vec3::from).collect())
            }
        };
        if path.is_directional() != (light.light.kind == LightKind::Directional) {
            return Err("path: positions move point and spot lights, all others directional ones".to_owned());
        }
        path.check().map_err(|error| format!("path.{error}"))?;
        Ok(path)
    }
}
