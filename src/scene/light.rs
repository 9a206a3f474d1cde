//! Lights: what they emit and from where. The shadow technique of a light is a separate component beside it.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec4, Vec3, Vec3A};

/// A light, placed by its `GlobalTransform`: it sits at the origin of its local space and shines along local
/// −Z. Scale is ignored. A transform with shear does not tilt the light of a rectangle against its plane.
///
/// A light whose numbers are not usable ([`Light::validate`]) lights nothing and is counted as skipped.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
#[require(LightSelection)]
pub struct Light {
    /// Shape and direction of the emission.
    pub kind: LightKind,
    /// Colour of the light, linear RGB, each component ≥ 0.
    pub color: Vec3,
    /// Luminous intensity, candela; for a directional light illuminance, lux. At least 0.
    pub intensity: f32,
    /// Distance beyond which nothing is lit, metres; greater than 0. Higher values light more objects and
    /// cost more; `f32::INFINITY` means no limit. Directional lights ignore it.
    pub range: f32,
}

/// Shape and direction of a light's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// The light shines from a point in all directions.
    Point,
    /// The light shines from a point into a cone around −Z, with full intensity inside the inner half-angle
    /// and none outside the outer one. Equal angles make a cone with a sharp edge.
    Spot {
        /// Half-angle of the region of full intensity, radians; 0 ≤ inner ≤ outer.
        inner_angle: f32,
        /// Half-angle of the whole cone, radians; greater than 0 and at most π/2.
        outer_angle: f32,
    },
    /// The light comes from infinity, parallel along −Z.
    Directional,
    /// The light shines from a rectangle in the local XY plane, at right angles to that plane and to its −Z side.
    Rect {
        /// Size of the rectangle along local X, metres; at least 0.
        width: f32,
        /// Size of the rectangle along local Y, metres; at least 0.
        height: f32,
    },
    /// The light shines from a sphere in all directions.
    Sphere {
        /// Radius of the sphere, metres; at least 0.
        radius: f32,
    },
}

/// The objects that a light acts on. An object is selected if its [`SelectionLayers`](super::SelectionLayers)
/// share a bit with the mask.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
pub struct LightSelection {
    /// Mask of the layers that the light lights; default all.
    pub affects: u32,
    /// Mask of the layers that block the light; default all.
    pub casts_for: u32,
    /// Mask of the layers that show the light's shadows; default all. Other objects are lit as if nothing stood
    /// before the light. Objects without [`ShadowReceiver`](super::ShadowReceiver) show no shadows of any light.
    pub shows_on: u32,
}

impl Default for LightSelection {
    fn default() -> Self {
        Self {
            affects: u32::MAX,
            casts_for: u32::MAX,
            shows_on: u32::MAX,
        }
    }
}

/// Why a light cannot shine.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// The range is NaN, zero or negative.
    #[error("range is {0} m, it must be greater than 0 m")]
    Range(f32),
    /// The intensity is NaN, negative or infinite.
    #[error("intensity is {0}, it must be finite and at least 0")]
    Intensity(f32),
    /// A component of the colour is NaN, negative or infinite.
    #[error("colour is {0}, its components must be finite and at least 0")]
    Color(Vec3),
    /// The angles of a spot light are out of order or too large.
    #[error(
        "cone half-angles are {:.2}° inside and {:.2}° outside ({inner} and {outer} radians), 0 ≤ inner ≤ outer and \
         0 < outer ≤ 90° are needed",
        inner.to_degrees(),
        outer.to_degrees()
    )]
    Angles {
        /// Inner half-angle, radians.
        inner: f32,
        /// Outer half-angle, radians.
        outer: f32,
    },
    /// The size of a rectangle or sphere is NaN, negative or infinite.
    #[error("size is {0} m, it must be finite and at least 0 m")]
    Size(f32),
    /// The transform is not finite, or gives the light no direction.
    #[error("its transform is not finite or has no direction")]
    Transform,
}

impl Light {
    /// A point light with the given colour, intensity in candela and range in metres.
    pub fn point(color: Vec3, intensity: f32, range: f32) -> Self {
        Self {
            kind: LightKind::Point,
            color,
            intensity,
            range,
        }
    }

    /// A directional light with the given colour and illuminance in lux.
    pub fn directional(color: Vec3, lux: f32) -> Self {
        Self {
            kind: LightKind::Directional,
            color,
            intensity: lux,
            range: f32::INFINITY,
        }
    }

    /// Checks that all numbers are usable.
    ///
    /// # Errors
    /// [`LightError`] for the first number that is out of its range.
    pub fn validate(&self) -> Result<(), LightError> {
        let usable = |x: f32| x.is_finite() && x >= 0.0;
        if !usable(self.intensity) {
            return Err(LightError::Intensity(self.intensity));
        }
        if !self.color.to_array().into_iter().all(usable) {
            return Err(LightError::Color(self.color));
        }
        if self.kind != LightKind::Directional && !(self.range > 0.0) {
            return Err(LightError::Range(self.range));
        }
        match self.kind {
            LightKind::Spot {
                inner_angle: inner,
                outer_angle: outer,
            } if !(0.0 <= inner && inner <= outer && 0.0 < outer && outer <= std::f32::consts::FRAC_PI_2) => {
                Err(LightError::Angles { inner, outer })
            }
            LightKind::Rect { width, height } if !usable(width) || !usable(height) => {
                Err(LightError::Size(if usable(width) { height } else { width }))
            }
            LightKind::Sphere { radius } if !usable(radius) => Err(LightError::Size(radius)),
            _ => Ok(()),
        }
    }

    /// The light as a homogeneous point in world space: its position with `w = 1`, or for a directional light
    /// the unit direction towards it with `w = 0`. Rectangles and spheres give their centre.
    ///
    /// # Errors
    /// [`LightError::Transform`] if the point is not finite, or a directional light has no direction.
    pub fn point_world(&self, world_from_light: &GlobalTransform) -> Result<DVec4, LightError> {
        let point = if self.kind == LightKind::Directional {
            let towards = -light_direction(self.kind, world_from_light).ok_or(LightError::Transform)?;
            towards.as_dvec3().normalize().extend(0.0)
        } else {
            world_from_light.translation().as_dvec3().extend(1.0)
        };
        if point.is_finite() {
            Ok(point)
        } else {
            Err(LightError::Transform)
        }
    }
}

/// Unit direction in which a light of this kind shines, in world space: local −Z. A rectangle shines at right angles to its
/// plane, to the side of local −Z; a transform with shear makes these differ. Without a plane it shines along local −Z as well.
/// A transform that is flat along Z alone faces where its other axes say. `None` if it flattens more, or is not finite.
pub fn light_direction(kind: LightKind, world_from_light: &GlobalTransform) -> Option<Vec3> {
    let matrix = world_from_light.affine().matrix3;
    if !matrix.is_finite() {
        return None;
    }
    let unit = |axis: Vec3A| Vec3::from(axis).try_normalize();
    let sides = unit(matrix.x_axis).zip(unit(matrix.y_axis));
    let normal = sides.and_then(|(right, up)| right.cross(up).try_normalize());
    let is_flat = matrix.z_axis == Vec3A::ZERO;
    let back = match normal {
        Some(normal) if is_flat || matches!(kind, LightKind::Rect { .. }) => {
            if matrix.determinant() < 0.0 {
                -normal
            } else {
                normal
            }
        }
        _ => matrix.z_axis.into(),
    };
    (-back).try_normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Quat;

    #[test]
    fn a_light_of_a_flat_node_faces_where_it_did() {
        let turned = Transform::from_rotation(Quat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.0));
        let direction = |scale| {
            light_direction(
                LightKind::Directional,
                &GlobalTransform::from(turned.with_scale(scale)),
            )
        };
        let usual = direction(Vec3::ONE).expect("it has one");
        let flat = direction(Vec3::new(2.0, 0.5, 0.0)).expect("x and y are left");
        assert!(usual.distance(flat) < 1e-6, "{usual} {flat}");
        assert_eq!(direction(Vec3::new(0.0, 1.0, 0.0)), None);
        assert_eq!(direction(Vec3::NAN), None);
    }

    #[test]
    fn a_rectangle_shines_at_right_angles_to_its_plane() {
        const RECT: LightKind = LightKind::Rect {
            width: 1.0,
            height: 1.0,
        };
        let turned = GlobalTransform::from(Transform::from_rotation(Quat::from_rotation_y(0.8)));
        for scale in [
            Vec3::ONE,
            Vec3::new(2.0, 1.0, 1.0),
            Vec3::new(1.0, 3.0, 0.5),
            Vec3::new(-1.0, 1.0, 1.0),
            Vec3::new(2.0, -1.0, 1.0),
            Vec3::new(1.0, 1.0, -4.0),
        ] {
            let parent = GlobalTransform::from(Transform::from_scale(scale));
            let place = parent * turned;
            let matrix = place.affine().matrix3;
            let direction = light_direction(RECT, &place).expect("it has one");
            for side in [matrix.x_axis, matrix.y_axis] {
                let along = direction.dot(side.into());
                assert!(along.abs() < 1e-6, "{scale}: {direction} along {side}");
            }
            let front = -Vec3::from(matrix.z_axis);
            assert!(direction.dot(front) > 0.1, "{scale}: {direction} before {front}");
        }
        let flat = |scale| light_direction(RECT, &GlobalTransform::from(Transform::from_scale(scale)));
        assert_eq!(flat(Vec3::new(0.0, 1.0, 1.0)), Some(Vec3::NEG_Z));
        assert_eq!(flat(Vec3::new(0.0, 1.0, 0.0)), None);
        assert_eq!(flat(Vec3::new(f32::NAN, 1.0, 1.0)), None);
    }
}
