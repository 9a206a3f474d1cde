//! The state of a light's entity, before it becomes a light of the frame.

use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, Vec3};

use super::light_volume::LightVolume;
use crate::geometry::Emitter;
use crate::scene::{Light, LightError, LightKind, LightSelection, light};

/// The state of a light's entity in this frame.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    pub entity: Entity,
    pub light: Light,
    pub world_from_light: GlobalTransform,
    pub selection: LightSelection,
    pub placed: Placed,
}

/// The parts of a light that follow from its components and its transform.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed {
    pub emitter: Emitter,
    pub direction: Vec3,
    pub volume: LightVolume,
}

/// Whether a light gives no light at all.
pub(in crate::sets) fn is_dark(light: &Light) -> bool {
    light.intensity == 0.0 || light.color == Vec3::ZERO
}

pub(super) fn place(light: &Light, world_from_light: &GlobalTransform) -> Result<Placed, LightError> {
    light.validate()?;
    let point = light.point_world(world_from_light)?;
    let direction = light::light_direction(world_from_light);
    let needs_direction = !matches!(light.kind, LightKind::Point | LightKind::Sphere { .. });
    let direction = match direction {
        Some(direction) => direction,
        None if needs_direction => return Err(LightError::Transform),
        None => Vec3::NEG_Z,
    };
    let mut emitter = Emitter::point(point);
    match light.kind {
        LightKind::Sphere { radius } => emitter.radius = f64::from(radius),
        LightKind::Rect { width, height } => {
            let affine = world_from_light.affine();
            let axis = |axis: glam::Vec3A| Vec3::from(axis).as_dvec3().try_normalize();
            let right: DVec3 = axis(affine.matrix3.x_axis).ok_or(LightError::Transform)?;
            let up: DVec3 = axis(affine.matrix3.y_axis).ok_or(LightError::Transform)?;
            emitter.half_sides = [right * f64::from(width) * 0.5, up * f64::from(height) * 0.5];
        }
        LightKind::Point | LightKind::Spot { .. } | LightKind::Directional => {}
    }
    let extent = emitter.bounding_radius() as f32;
    let center = point.truncate().as_vec3();
    Ok(Placed {
        emitter,
        direction,
        volume: LightVolume::new(light.kind, light.range, center, direction, extent),
    })
}
