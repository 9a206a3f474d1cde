//! Where a light is sampled, and which surface points count for it.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Vec3};

use super::error::ReferenceError;
use super::primary::SurfaceHit;
use crate::scene::{Light, LightError, LightKind, LightSelection};

/// A surface point must be more than this in front of a light's centre's plane, and a rectangle's reach begins
/// this far before it, metres; for directional lights it is the least cosine. As `tools/truth.py`.
const LEAST_FACING: f64 = 1e-3;

/// Share of the range up to which points count: techniques and truth may cut the rim differently. As
/// `tools/truth.py`.
const RANGE_SHARE: f64 = 0.999;

/// Share of the cone's half-angle up to which points count. As `tools/truth.py`.
const CONE_SHARE: f64 = 0.99;

/// A light as the judge sees it, world space in `f64`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSource {
    /// Where its light comes from.
    pub shape: LightShape,
    /// Metres; infinite for directional lights.
    pub range: f64,
    /// What it lights and what blocks it.
    pub selection: LightSelection,
}

/// Where a light's light comes from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightShape {
    /// A point.
    Point {
        /// Metres.
        position: DVec3,
    },
    /// A point that lights a cone.
    Spot {
        /// Metres.
        position: DVec3,
        /// Unit vector.
        direction: DVec3,
        /// Half-angle of the cone, radians.
        outer_angle: f64,
    },
    /// Infinitely far.
    Directional {
        /// Unit vector towards the light.
        towards: DVec3,
    },
    /// A rectangle that lights one side.
    Rect {
        /// Centre, metres.
        center: DVec3,
        /// Half of the width, along it, metres.
        half_right: DVec3,
        /// Half of the height, along it, metres.
        half_up: DVec3,
        /// Unit vector: the side that it shines to.
        direction: DVec3,
    },
    /// A sphere, sampled as the disc through its centre that faces the receiver.
    Sphere {
        /// Metres.
        center: DVec3,
        /// Metres.
        radius: f64,
    },
}

impl LightSource {
    /// The light at its transform; scale is ignored.
    ///
    /// # Errors
    /// What [`Light::validate`] finds, or [`LightError::Transform`].
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
        let direction = || axis(-affine.matrix3.z_axis);
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
    /// [`ReferenceError::NotALight`], [`ReferenceError::Light`].
    pub fn of_entity(world: &World, entity: Entity) -> Result<Self, ReferenceError> {
        let parts = world
            .get_entity(entity)
            .ok()
            .and_then(|entity| Some((entity.get::<Light>()?, entity.get::<GlobalTransform>()?, entity)));
        let (light, transform, entity_ref) = parts.ok_or(ReferenceError::NotALight(entity))?;
        let selection = entity_ref.get::<LightSelection>().copied().unwrap_or_default();
        Ok(Self::new(light, transform, selection)?)
    }

    /// Whether visibility is defined at the surface point: it faces the light's centre and lies within range,
    /// cone, and the lit side of a rectangle. The margins are those of `tools/truth.py`.
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
