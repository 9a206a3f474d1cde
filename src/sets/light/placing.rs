//! The place of a light: from where it shines, from where its shadows are cast, and the regions that both reach.

use bevy_transform::prelude::GlobalTransform;
use glam::{DVec2, DVec3, Vec3};

use super::light_volume::LightVolume;
use super::lit_region::LitRegion;
use crate::geometry::{Emitter, PlaneSet, Pyramid, Sphere};
use crate::scene::{Light, LightError, LightKind, LightModel, ShadowOrigin, light};

/// The place from which a light shines. Shadows are cast from the same place unless a
/// [`ShadowOrigin`] or a [`ShadowSoftness`](crate::scene::ShadowSoftness) says otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shining {
    /// Place and extent of the source in world space.
    pub emitter: Emitter,
    /// Axes of light space in world space: local X and Y, and the direction in which the light shines.
    /// They are at right angles, whatever the scale of the light's transform.
    pub axes: [DVec3; 3],
    /// Distance beyond which nothing is lit, metres: that of the [`Light`].
    pub range: f32,
}

/// The parts of a light that follow from its components and its transform.
#[derive(Clone, Debug)]
pub(super) struct Placed {
    pub shining: Shining,
    /// Place and extent from which shadows are cast.
    pub emitter: Emitter,
    pub direction: Vec3,
    /// Distance from the shadows' place beyond which nothing matters, metres.
    pub range: f32,
    /// Region that holds what is lit, and the casters that may shadow it.
    pub volume: LightVolume,
    /// Planes that bound the same region, beside the volume.
    pub doors: PlaneSet,
    /// Region that is lit.
    pub lit: LitRegion,
}

impl Placed {
    /// Whether shadows are cast from behind a light that shines to one side.
    pub fn casts_from_behind(&self, kind: LightKind) -> bool {
        let [.., along] = self.shining.axes;
        let moved = (self.emitter.point - self.shining.emitter.point).truncate();
        matches!(kind, LightKind::Spot { .. } | LightKind::Rect { .. }) && moved.dot(along) < -1e-4
    }
}

/// Places a light.
pub(super) fn place(
    light: &Light,
    world_from_light: &GlobalTransform,
    model: &LightModel,
) -> Result<Placed, LightError> {
    light.validate()?;
    let point = light.point_world(world_from_light)?;
    let direction = light::light_direction(light.kind, world_from_light);
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
    let shining = Shining {
        emitter,
        axes: light_axes(world_from_light, direction),
        range: light.range,
    };
    Ok(with_model(light, &shining, direction, model))
}

/// The axes of light space in world space: local X and Y, made perpendicular to the direction in which the light
/// shines, and that direction.
fn light_axes(world_from_light: &GlobalTransform, direction: Vec3) -> [DVec3; 3] {
    let matrix = world_from_light.affine().matrix3;
    let along = direction.as_dvec3().normalize();
    let across = |axis: glam::Vec3A| {
        let axis = Vec3::from(axis).as_dvec3();
        (axis - along * axis.dot(along)).try_normalize()
    };
    let right = across(matrix.x_axis)
        .or_else(|| across(matrix.y_axis).map(|up| along.cross(up)))
        .unwrap_or_else(|| along.any_orthonormal_vector());
    let up = right.cross(along);
    // A mirrored transform mirrors what the light projects.
    let mirrors = matrix.determinant() < 0.0;
    [right, if mirrors { -up } else { up }, along]
}

/// Shapes the regions of a light as its model says, and moves the place of its shadows.
fn with_model(light: &Light, shining: &Shining, direction: Vec3, model: &LightModel) -> Placed {
    let actual = shining.emitter;
    let center = actual.point.truncate().as_vec3();
    let extent = |emitter: &Emitter| emitter.bounding_radius() as f32;
    let slopes = model.shape.map(|shape| shape.outer().as_dvec2());
    let slope = slopes.map(|slopes| steepest(slopes, model.shape.is_some_and(|shape| shape.round >= 1.0)));
    let mut reach = model
        .distance
        .map_or(f64::INFINITY, |distance| f64::from(distance.reach()));
    let depth = reach; // along the axis, if there are barn doors
    if let Some(slope) = slope {
        reach *= 1f64.hypot(slope); // the corner is farther away than the middle
    }
    let range = light.range.min((reach * (1.0 + 1e-6)) as f32);
    // Wider than a shader that rounds could shine.
    let half_angle =
        slope.map(|slope| ((slope * (1.0 + 1e-5) + 1e-5).atan() as f32).min(std::f32::consts::FRAC_PI_2));
    let volume_of = |extent| LightVolume::shaped(light.kind, range, center, direction, extent, half_angle);
    let pyramid = slopes.map(|slopes| Pyramid {
        apex: actual.point.truncate(),
        axes: shining.axes,
        slopes,
        depth: depth.min(f64::from(light.range)),
    });
    let [.., along] = shining.axes;
    let stands_at = actual.point.truncate();
    let lit = LitRegion::new(
        volume_of(extent(&actual)),
        pyramid.as_ref(),
        model,
        stands_at,
        along,
    );

    let mut emitter = softened(&actual, light.kind, model.softness);
    let mut volume = volume_of(extent(&actual).max(extent(&emitter)));
    let mut doors = PlaneSet::default();
    if let Some(pyramid) = &pyramid {
        doors = pyramid.planes(&if extent(&emitter) > extent(&actual) {
            emitter
        } else {
            actual
        });
    }
    let mut shadow_range = range;
    if let Some(origin) = model.origin {
        emitter.point = match origin {
            ShadowOrigin::Position(point) => point.as_dvec3().extend(1.0),
            ShadowOrigin::Direction(towards) => (-towards.as_dvec3().normalize()).extend(0.0),
        };
        let moved = (emitter.point - actual.point).truncate().length() as f32;
        if actual.point.w != 0.0 {
            shadow_range += moved + extent(&actual);
        }
        volume = around(&lit, &emitter);
        doors = PlaneSet::default();
    }
    Placed {
        shining: *shining,
        emitter,
        direction,
        range: shadow_range,
        volume,
        doors,
        lit,
    }
}

/// The slope of the cone around a superellipse: an ellipse reaches as far as its longer axis, and every other
/// superellipse at most to the corner of its box.
fn steepest(slopes: DVec2, is_ellipse: bool) -> f64 {
    if is_ellipse {
        slopes.max_element()
    } else {
        slopes.length()
    }
}

/// The source with the extent that an artist gave its shadows.
fn softened(emitter: &Emitter, kind: LightKind, softness: Option<f32>) -> Emitter {
    let Some(softness) = softness.map(f64::from) else {
        return *emitter;
    };
    let mut soft = *emitter;
    match kind {
        LightKind::Point | LightKind::Spot { .. } | LightKind::Sphere { .. } => soft.radius = softness,
        LightKind::Rect { .. } => {
            let radius = emitter.bounding_radius();
            let scale = if radius > 0.0 { softness / radius } else { 0.0 };
            soft.half_sides = emitter.half_sides.map(|side| side * scale);
        }
        LightKind::Directional => {}
    }
    soft
}

/// A region around what is lit and the place from which its shadows are cast.
fn around(lit: &LitRegion, emitter: &Emitter) -> LightVolume {
    let aabb = lit.aabb();
    if emitter.point.w == 0.0 || !(aabb.min.is_finite() && aabb.max.is_finite()) {
        return LightVolume::Infinite;
    }
    let (center, radius) = (aabb.center().as_dvec3(), f64::from(aabb.half_size().length()));
    let to_origin = emitter.point.truncate() - center;
    let distance = to_origin.length() + emitter.bounding_radius();
    let (center, radius) = if distance <= radius || to_origin.length() == 0.0 {
        (center, radius.max(distance))
    } else {
        let grown = 0.5 * (radius + distance);
        (center + to_origin.normalize() * (grown - radius), grown)
    };
    LightVolume::Ball(Sphere {
        center: center.as_vec3(),
        radius: radius as f32 * (1.0 + 1e-5) + 1e-6,
    })
}
