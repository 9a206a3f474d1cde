//! Lights: what they emit and from where. The shadow technique is a component of its own beside it.

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;
#[cfg(feature = "bevy")]
use bevy_reflect::prelude::ReflectDefault;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec4, Vec3};

/// A light. Placed by its `GlobalTransform`: it sits at the origin and shines along local −Z.
/// Scale is ignored.
///
/// A light whose numbers are not usable ([`Light::validate`]) lights nothing and is counted as skipped.
#[derive(Component, Clone, Debug, PartialEq)]
#[require(Transform)]
#[require(LightSelection)]
pub struct Light {
    /// Shape and direction of the emission.
    pub kind: LightKind,
    /// Linear RGB; each ≥ 0.
    pub color: Vec3,
    /// Candela; lux for a directional light; ≥ 0.
    pub intensity: f32,
    /// Distance beyond which nothing is lit, metres; > 0, `f32::INFINITY` for none. Unused by directional lights.
    pub range: f32,
}

/// Shape and direction of a light's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// From a point into all directions.
    Point,
    /// From a point into a cone around −Z: full inside the inner half-angle, nothing outside the outer one. Equal angles make
    /// a cone with a sharp edge.
    Spot {
        /// Half-angle of full intensity, radians; 0 ≤ inner ≤ outer.
        inner_angle: f32,
        /// Half-angle of the cone, radians; 0 < outer ≤ π/2.
        outer_angle: f32,
    },
    /// Parallel light along −Z from infinity.
    Directional,
    /// A rectangle in the local XY plane that shines to its −Z side.
    Rect {
        /// Size along local X, metres; ≥ 0.
        width: f32,
        /// Size along local Y, metres; ≥ 0.
        height: f32,
    },
    /// A sphere.
    Sphere {
        /// Metres; ≥ 0.
        radius: f32,
    },
}

/// What a light acts on. A bit shared with an object's [`SelectionLayers`](super::SelectionLayers) selects it.
#[derive(Component, Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(Component, Default, Debug, Clone, PartialEq)
)]
pub struct LightSelection {
    /// Layers that the light lights.
    pub affects: u32,
    /// Layers that block this light.
    pub casts_for: u32,
}

impl Default for LightSelection {
    fn default() -> Self {
        Self {
            affects: u32::MAX,
            casts_for: u32::MAX,
        }
    }
}

/// Every receiver that the light does not see is dark in it, so that it need not be drawn for the light: what a shadow
/// technique says of its light by requiring this component, and takes back when it is removed. Without it nothing is
/// occluded from the light.
#[derive(Component, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ShadowedLight;

/// Why a light cannot shine.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LightError {
    /// NaN or negative.
    #[error("range is {0}, it must be greater than 0")]
    Range(f32),
    /// NaN, negative or infinite.
    #[error("intensity is {0}, it must be finite and at least 0")]
    Intensity(f32),
    /// NaN, negative or infinite.
    #[error("colour is {0}, its components must be finite and at least 0")]
    Color(Vec3),
    /// Angles of a spot light out of order.
    #[error(
        "cone half-angles are {inner} and {outer} radians, 0 ≤ inner ≤ outer and 0 < outer ≤ π/2 are needed"
    )]
    Angles {
        /// Inner half-angle.
        inner: f32,
        /// Outer half-angle.
        outer: f32,
    },
    /// Size of a rectangle or sphere is NaN, negative or infinite.
    #[error("size is {0}, it must be finite and at least 0")]
    Size(f32),
    /// NaN or infinite transform, or one without a direction.
    #[error("its transform is not finite or has no direction")]
    Transform,
}

impl Light {
    /// A point light.
    pub fn point(color: Vec3, intensity: f32, range: f32) -> Self {
        Self {
            kind: LightKind::Point,
            color,
            intensity,
            range,
        }
    }

    /// A directional light of `lux`.
    pub fn directional(color: Vec3, lux: f32) -> Self {
        Self {
            kind: LightKind::Directional,
            color,
            intensity: lux,
            range: f32::INFINITY,
        }
    }

    /// Checks the numbers.
    ///
    /// # Errors
    /// The first number that is out of its range.
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

    /// The light as a homogeneous point in world space: position with `w = 1`, or the unit direction towards a
    /// directional light with `w = 0`. Rectangles and spheres give their centre.
    ///
    /// # Errors
    /// [`LightError::Transform`] if it is not finite.
    pub fn point_world(&self, world_from_light: &GlobalTransform) -> Result<DVec4, LightError> {
        let point = if self.kind == LightKind::Directional {
            let towards = -light_direction(world_from_light).ok_or(LightError::Transform)?;
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

/// Unit world direction of local −Z; `None` if the transform flattens it or is not finite.
pub fn light_direction(world_from_light: &GlobalTransform) -> Option<Vec3> {
    (-Vec3::from(world_from_light.affine().matrix3.z_axis)).try_normalize()
}
