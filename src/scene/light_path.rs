//! The path along which a light moves, such as the sun's through a day.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

/// The path of a light, a curve over the *time* 0 to 1. It moves nothing by itself: a technique that knows the time
/// does, such as [`OcclusionInterval`](crate::techniques::OcclusionInterval).
///
/// Directions and positions are in world space, so a light with a path should have no parent.
#[derive(Component, Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Debug, Clone, PartialEq)
)]
pub enum LightPath {
    /// The direction of a directional light turns about an axis. The path is closed if it turns by a whole circle.
    Arc {
        /// Direction in which the light shines at time 0; of any length but 0.
        direction: Vec3,
        /// Axis about which the direction turns, counter-clockwise as seen from its tip; of any length but 0.
        axis: Vec3,
        /// Angle by which the direction has turned at time 1, degrees; −360 to 360 and not 0.
        degrees: f32,
    },
    /// A directional light is the sun of one day. +X is east, −Z is north, and hours are solar: the sun is highest at
    /// 12. It gives no light below the horizon. The path is closed if it covers all 24 hours.
    Sun {
        /// Latitude, degrees north; −90 to 90.
        latitude_degrees: f32,
        /// Day of the year, 1 to 366. Day 172 is the longest in the north.
        day: f32,
        /// Hours of the day at time 0 and time 1; 0 ≤ first < second ≤ 24. A shorter part of the day is baked more
        /// finely, because every path has the same number of points.
        hours: [f32; 2],
    },
    /// A point or spot light moves along a polyline at constant speed. The path is closed if the last point is the
    /// first.
    Positions(
        /// Corners of the polyline, metres; at least two, and not all the same.
        Vec<Vec3>,
    ),
}

/// The place of a light at one time of its path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathPoint {
    /// A directional light shines in this direction, a unit vector.
    Direction(Vec3),
    /// A light at a position stands here, metres.
    Position(Vec3),
}

/// Inclination of the earth's axis, degrees. Source: Cooper 1969, "The absorption of radiation in solar stills".
const OBLIQUITY: f32 = 23.45;

impl LightPath {
    /// Whether the path is that of a directional light.
    pub fn is_directional(&self) -> bool {
        !matches!(self, Self::Positions(_))
    }

    /// Whether the path ends where it begins. Time then wraps around.
    pub fn is_closed(&self) -> bool {
        match self {
            Self::Arc { degrees, .. } => degrees.abs() == 360.0,
            Self::Sun { hours, .. } => hours[1] - hours[0] == 24.0,
            Self::Positions(positions) => positions.len() > 2 && positions.first() == positions.last(),
        }
    }

    /// Brings a time into the path: it wraps around a closed path and stops at the ends of any other.
    pub fn time(&self, time: f32) -> f32 {
        if !time.is_finite() {
            0.0
        } else if self.is_closed() {
            // `rem_euclid` may round up to 1, which is 0 again.
            let wrapped = time.rem_euclid(1.0);
            if wrapped < 1.0 { wrapped } else { 0.0 }
        } else {
            time.clamp(0.0, 1.0)
        }
    }

    /// Returns the place of the light at a time. Call [`LightPath::check`] before.
    pub fn at(&self, time: f32) -> PathPoint {
        let time = self.time(time);
        match self {
            Self::Arc {
                direction,
                axis,
                degrees,
            } => {
                let turn = Quat::from_axis_angle(axis.normalize_or(Vec3::Y), (degrees * time).to_radians());
                PathPoint::Direction((turn * *direction).normalize_or(Vec3::NEG_Y))
            }
            Self::Sun { .. } => PathPoint::Direction(-self.towards_sun(time)),
            Self::Positions(positions) => PathPoint::Position(along(positions, time)),
        }
    }

    /// Whether the light shines at a time. The sun does not while it is below the horizon.
    pub fn shines(&self, time: f32) -> bool {
        match self {
            Self::Sun { .. } => self.towards_sun(self.time(time)).y > 0.0,
            _ => true,
        }
    }

    /// The unit direction towards the sun; straight up for other paths.
    ///
    /// With the declination δ, the latitude φ and the hour angle H: east −cos δ sin H, north
    /// cos φ sin δ − sin φ cos δ cos H, up sin φ sin δ + cos φ cos δ cos H.
    fn towards_sun(&self, time: f32) -> Vec3 {
        let &Self::Sun {
            latitude_degrees,
            day,
            hours,
        } = self
        else {
            return Vec3::Y;
        };
        let turn = std::f32::consts::TAU;
        let declination = OBLIQUITY.to_radians() * (turn * (284.0 + day) / 365.0).sin();
        let hour_angle = (hours[0] + time * (hours[1] - hours[0]) - 12.0) / 24.0 * turn;
        let (sin_latitude, cos_latitude) = latitude_degrees.to_radians().sin_cos();
        let (sin_declination, cos_declination) = declination.sin_cos();
        let (sin_hour, cos_hour) = hour_angle.sin_cos();
        let east = -cos_declination * sin_hour;
        let north = cos_latitude * sin_declination - sin_latitude * cos_declination * cos_hour;
        let up = sin_latitude * sin_declination + cos_latitude * cos_declination * cos_hour;
        Vec3::new(east, up, -north).normalize_or(Vec3::Y)
    }

    /// Puts a light at a time of the path: turns a directional light, and moves any other.
    pub fn place(&self, time: f32, transform: &mut Transform) {
        match self.at(time) {
            PathPoint::Direction(direction) => {
                let up = if direction.y.abs() > 0.9 { Vec3::X } else { Vec3::Y };
                *transform = transform.looking_to(direction, up);
            }
            PathPoint::Position(position) => transform.translation = position,
        }
    }
}

pub(super) fn length(positions: &[Vec3]) -> f32 {
    positions.windows(2).map(|pair| pair[0].distance(pair[1])).sum()
}

/// The point of a polyline at a share of its length.
fn along(positions: &[Vec3], share: f32) -> Vec3 {
    let mut left = length(positions) * share;
    for pair in positions.windows(2) {
        let step = pair[0].distance(pair[1]);
        if left <= step && step > 0.0 {
            return pair[0].lerp(pair[1], left / step);
        }
        left -= step;
    }
    positions.last().copied().unwrap_or(Vec3::ZERO)
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

    fn towards(path: &LightPath, time: f32) -> Vec3 {
        match path.at(time) {
            PathPoint::Direction(direction) => -direction,
            PathPoint::Position(position) => panic!("a direction is expected, not {position}"),
        }
    }

    #[test]
    fn the_sun_is_where_almanacs_have_it() {
        // At noon of the longest day the sun stands 90° − 50° + 23.45° high, in the south.
        let noon = towards(&sun(50.0, 172.0), 0.5);
        assert!((noon.y.asin().to_degrees() - 63.45).abs() < 0.05, "{noon}");
        assert!(noon.z > 0.0 && noon.x.abs() < 1e-5, "the south is +Z: {noon}");
        // At the equinox it rises in the east at 6 and sets in the west at 18, everywhere.
        let equinox = sun(50.0, 81.0);
        let (rise, set) = (towards(&equinox, 0.25), towards(&equinox, 0.75));
        assert!(rise.x > 0.999 && rise.y.abs() < 0.01, "{rise}");
        assert!(set.x < -0.999 && set.y.abs() < 0.01, "{set}");
        // South of the equator it stands in the north at noon.
        assert!(towards(&sun(-50.0, 172.0), 0.5).z < 0.0);
    }

    #[test]
    fn the_sun_shines_by_day_and_neither_in_polar_night_nor_ever_not_in_polar_day() {
        let hours_of_light =
            |path: LightPath| (0..240).filter(|&i| path.shines(i as f32 / 240.0)).count() / 10;
        assert_eq!(hours_of_light(sun(80.0, 355.0)), 0);
        assert_eq!(hours_of_light(sun(80.0, 172.0)), 24);
        assert!((15..=17).contains(&hours_of_light(sun(50.0, 172.0))));
    }

    #[test]
    fn an_arc_turns_about_its_axis() {
        let path = LightPath::Arc {
            direction: Vec3::new(-1.0, 0.0, 0.0),
            axis: Vec3::Z * 3.0,
            degrees: 180.0,
        };
        assert!(towards(&path, 0.0).distance(Vec3::X) < 1e-6);
        assert!(towards(&path, 0.5).distance(Vec3::Y) < 1e-6);
        assert!(
            towards(&path, 7.0).distance(Vec3::NEG_X) < 1e-6,
            "an open path ends"
        );
        assert!(!path.is_closed());
    }

    #[test]
    fn polylines_are_walked_at_constant_speed_and_closed_ones_for_ever() {
        let square = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Z, Vec3::Z, Vec3::ZERO];
        let path = LightPath::Positions(square.to_vec());
        assert!(path.is_closed());
        for time in [0.375, 1.375, -0.625] {
            assert_eq!(path.at(time), PathPoint::Position(Vec3::new(1.0, 0.0, 0.5)));
        }
    }

    #[test]
    fn a_light_shines_along_its_path() {
        let path = sun(35.0, 100.0);
        for step in 0..48 {
            let time = step as f32 / 48.0;
            let mut transform = Transform::default();
            path.place(time, &mut transform);
            assert!(Vec3::from(transform.forward()).distance(-towards(&path, time)) < 1e-5);
        }
    }
}
