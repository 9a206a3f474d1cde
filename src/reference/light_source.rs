//! The points at which a light is sampled, and the surface points that count for it.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Vec3};

use super::error::ReferenceError;
use super::primary::SurfaceHit;
use crate::scene::light::light_direction;
use crate::scene::{Light, LightError, LightKind, LightSelection};

/// Least distance of a light's centre in front of the surface's plane, metres, and least distance of a
/// surface point in front of a rectangle. For directional lights it is the least cosine. Equal to the value
/// in `tools/truth.py`.
const LEAST_FACING: f64 = 1e-3;

/// Share of the range up to which surface points count. Techniques and the truth may cut the rim differently.
/// Equal to the value in `tools/truth.py`.
const RANGE_SHARE: f64 = 0.999;

/// Share of the cone's half-angle up to which surface points count. Equal to the value in `tools/truth.py`.
const CONE_SHARE: f64 = 0.99;

/// A light in the form that the judge uses: world space, in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSource {
    /// Shape and place of the emitter.
    pub shape: LightShape,
    /// Distance up to which the light reaches, metres; infinite for directional lights.
    pub range: f64,
    /// The layers that the light lights, and the layers that block it.
    pub selection: LightSelection,
}

/// Shape and place of an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// The light comes from a point.
    Point {
        /// Position of the light, metres.
        position: DVec3,
    },
    /// The light comes from a point and lights a cone.
    Spot {
        /// Position of the light, metres.
        position: DVec3,
        /// Direction of the cone's axis, a unit vector.
        direction: DVec3,
        /// Half-angle of the cone, radians.
        outer_angle: f64,
    },
    /// The light comes from infinitely far away.
    Directional {
        /// Unit vector towards the light.
        towards: DVec3,
    },
    /// The light comes from a rectangle that lights one side.
    Rect {
        /// Centre of the rectangle, metres.
        center: DVec3,
        /// Half of the rectangle's width, as a vector along it, metres.
        half_right: DVec3,
        /// Half of the rectangle's height, as a vector along it, metres.
        half_up: DVec3,
        /// Unit vector towards the side that the rectangle lights.
        direction: DVec3,
    },
    /// The light comes from a sphere. It is sampled on the disc through its centre that faces the receiver.
    Sphere {
        /// Centre of the sphere, metres.
        center: DVec3,
        /// Radius of the sphere, metres.
        radius: f64,
    },
}

impl LightShape {
    /// The smallest and the largest corner of a box around the points that are sampled; `None` if there is one point, or none.
    pub(super) fn bounds(&self) -> Option<[DVec3; 2]> {
        let (center, half) = match *self {
            Self::Rect {
                center,
                half_right,
                half_up,
                ..
            } => (center, half_right.abs() + half_up.abs()),
            Self::Sphere { center, radius } => (center, DVec3::splat(radius)),
            Self::Point { .. } | Self::Spot { .. } | Self::Directional { .. } => return None,
        };
        Some([center - half, center + half])
    }
}

impl LightSource {
    /// The light at its transform. Scale is ignored.
    ///
    /// # Errors
    /// The error of [`Light::validate`], or [`LightError::Transform`].
    pub fn new(
        light: &Light,
        world_from_light: &GlobalTransform,
        selection: LightSelection,
    ) -> Result<Self, LightError> {
        light.validate()?;
        let affine = world_from_light.affine();
        if !affine.is_finite() {
            return Err(LightError::Transform);
        }
        let axis = |column: glam::Vec3A| {
            Vec3::from(column)
                .as_dvec3()
                .try_normalize()
                .ok_or(LightError::Transform)
        };
        let position = Vec3::from(affine.translation).as_dvec3();
        let direction = || -> Result<DVec3, LightError> {
            let direction = light_direction(light.kind, world_from_light).ok_or(LightError::Transform)?;
            Ok(direction.as_dvec3().normalize())
        };
        let shape = match light.kind {
            LightKind::Point => LightShape::Point { position },
            LightKind::Spot { outer_angle, .. } => LightShape::Spot {
                position,
                direction: direction()?,
                outer_angle: f64::from(outer_angle),
            },
            LightKind::Directional => LightShape::Directional {
                towards: -direction()?,
            },
            LightKind::Rect { width, height } => LightShape::Rect {
                center: position,
                half_right: axis(affine.matrix3.x_axis)? * (f64::from(width) * 0.5),
                half_up: axis(affine.matrix3.y_axis)? * (f64::from(height) * 0.5),
                direction: direction()?,
            },
            LightKind::Sphere { radius } => LightShape::Sphere {
                center: position,
                radius: f64::from(radius),
            },
        };
        let range = match light.kind {
            LightKind::Directional => f64::INFINITY,
            _ => f64::from(light.range),
        };
        Ok(Self {
            shape,
            range,
            selection,
        })
    }

    /// The light of an entity.
    ///
    /// # Errors
    /// [`ReferenceError::NotALight`] or [`ReferenceError::Light`].
    pub fn of_entity(world: &World, entity: Entity) -> Result<Self, ReferenceError> {
        let parts = world
            .get_entity(entity)
            .ok()
            .and_then(|entity| Some((entity.get::<Light>()?, entity.get::<GlobalTransform>()?, entity)));
        let (light, transform, entity_ref) = parts.ok_or(ReferenceError::NotALight(entity))?;
        let selection = entity_ref.get::<LightSelection>().copied().unwrap_or_default();
        Ok(Self::new(light, transform, selection)?)
    }

    /// Whether visibility is defined at the surface point. The point must face the light's centre and lie
    /// within the range, within the cone, and on the lit side of a rectangle. The margins equal those of
    /// `tools/truth.py`.
    pub fn reaches(&self, surface: &SurfaceHit) -> bool {
        let center = match self.shape {
            LightShape::Directional { towards } => return surface.normal.dot(towards) > LEAST_FACING,
            LightShape::Point { position } | LightShape::Spot { position, .. } => position,
            LightShape::Rect { center, .. } | LightShape::Sphere { center, .. } => center,
        };
        let from_light = surface.position - center;
        let distance = from_light.length();
        let in_shape = match self.shape {
            LightShape::Spot {
                direction,
                outer_angle,
                ..
            } => from_light.dot(direction) > distance * (outer_angle * CONE_SHARE).cos(),
            LightShape::Rect { direction, .. } => from_light.dot(direction) > LEAST_FACING,
            _ => true,
        };
        -surface.normal.dot(from_light) > LEAST_FACING && distance < self.range * RANGE_SHARE && in_shape
    }
}
