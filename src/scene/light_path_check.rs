//! Checks of paths of lights.

use glam::Vec3;

use super::light_path::{LightPath, length};

/// Why a path cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PathError {
    /// A number is not finite or out of its range.
    #[error("{field} is {value}, it must be {allowed}")]
    Number {
        /// Name of the field.
        field: &'static str,
        /// Value of the field.
        value: f32,
        /// Values that are allowed.
        allowed: &'static str,
    },
    /// A vector has no direction.
    #[error("{field} is {value}, it must be finite and not 0")]
    Vector {
        /// Name of the field.
        field: &'static str,
        /// Value of the field.
        value: Vec3,
    },
    /// The axis of an arc is parallel to the light.
    #[error("axis {axis} is parallel to the light's direction, so the light would not move")]
    Parallel {
        /// Axis of the arc.
        axis: Vec3,
    },
    /// A corner of a polyline is not finite.
    #[error("positions[{index}] is {value}, it must be finite")]
    Position {
        /// Index of the corner.
        index: usize,
        /// Position of the corner.
        value: Vec3,
    },
    /// A polyline has no length.
    #[error("positions: {count} of them make a path of no length, at least two different ones are needed")]
    NoLength {
        /// Number of corners.
        count: usize,
    },
}

/// The sine of the least angle between the axis of an arc and the light.
const LEAST_ANGLE: f32 = 1e-3;

impl LightPath {
    /// Checks that all numbers are usable.
    ///
    /// # Errors
    /// [`PathError`] names the first field that is not.
    pub fn check(&self) -> Result<(), PathError> {
        match self {
            Self::Arc {
                direction,
                axis,
                degrees,
            } => check_arc(*direction, *axis, *degrees),
            Self::Sun {
                latitude_degrees,
                day,
                hours,
            } => {
                in_range("latitude_deg", *latitude_degrees, -90.0..=90.0, "from -90 to 90")?;
                in_range("day", *day, 1.0..=366.0, "from 1 to 366")?;
                in_range("hours[0]", hours[0], 0.0..=24.0, "from 0 to 24")?;
                in_range("hours[1]", hours[1], 0.0..=24.0, "from 0 to 24")?;
                if hours[0] < hours[1] {
                    return Ok(());
                }
                Err(PathError::Number {
                    field: "hours[1]",
                    value: hours[1],
                    allowed: "later than hours[0]",
                })
            }
            Self::Positions(positions) => {
                for (index, &value) in positions.iter().enumerate() {
                    if !value.is_finite() {
                        return Err(PathError::Position { index, value });
                    }
                }
                let length = length(positions);
                if length > 0.0 && length.is_finite() {
                    return Ok(());
                }
                Err(PathError::NoLength {
                    count: positions.len(),
                })
            }
        }
    }
}

fn check_arc(direction: Vec3, axis: Vec3, degrees: f32) -> Result<(), PathError> {
    let unit = |field, value: Vec3| value.try_normalize().ok_or(PathError::Vector { field, value });
    let direction = unit("direction", direction)?;
    let unit_axis = unit("axis", axis)?;
    let allowed = "from -360 to 360 and not 0";
    in_range("degrees", degrees, -360.0..=360.0, allowed)?;
    if degrees == 0.0 {
        return Err(PathError::Number {
            field: "degrees",
            value: degrees,
            allowed,
        });
    }
    if unit_axis.cross(direction).length() < LEAST_ANGLE {
        return Err(PathError::Parallel { axis });
    }
    Ok(())
}

fn in_range(
    field: &'static str,
    value: f32,
    range: std::ops::RangeInclusive<f32>,
    allowed: &'static str,
) -> Result<(), PathError> {
    if range.contains(&value) {
        return Ok(());
    }
    Err(PathError::Number {
        field,
        value,
        allowed,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sun(latitude_degrees: f32, day: f32) -> LightPath {
        LightPath::Sun {
            latitude_degrees,
            day,
            hours: [0.0, 24.0],
        }
    }

    #[test]
    fn what_cannot_be_used_is_named() {
        let named = |path: LightPath| path.check().expect_err("it cannot be used").to_string();
        let arc = |axis: Vec3, degrees: f32| LightPath::Arc {
            direction: Vec3::NEG_Y,
            axis,
            degrees,
        };
        assert!(named(arc(Vec3::ZERO, 90.0)).starts_with("axis"));
        assert!(named(arc(Vec3::Y, 90.0)).contains("parallel"));
        assert!(named(arc(Vec3::X, 0.0)).starts_with("degrees"));
        assert!(named(arc(Vec3::X, f32::NAN)).starts_with("degrees"));
        assert!(named(sun(91.0, 1.0)).starts_with("latitude_deg"));
        assert!(named(sun(0.0, 0.0)).starts_with("day"));
        let hours = LightPath::Sun {
            latitude_degrees: 0.0,
            day: 1.0,
            hours: [12.0, 6.0],
        };
        assert!(named(hours).starts_with("hours[1]"));
        let positions = |positions: &[Vec3]| named(LightPath::Positions(positions.to_vec()));
        assert!(positions(&[Vec3::X, Vec3::NAN]).starts_with("positions[1]"));
        assert!(positions(&[]).contains("0 of them"));
        assert!(positions(&[Vec3::X; 3]).contains("3 of them"));
        assert_eq!(arc(Vec3::X, 360.0).check(), Ok(()));
    }
}
