//! The views and lights that every model is judged under.

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

/// Where camera and light stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Placement {
    /// The camera sees the model from outside of its shadow.
    Outside,
    /// The camera stands in the model's shadow.
    InsideShadow,
    /// The light stands behind the camera.
    LightBehind,
    /// The camera sees the light.
    LightInFrustum,
    /// The camera's near plane touches the model.
    Touching,
}

/// All placements.
pub const PLACEMENTS: [Placement; 5] = [
    Placement::Outside,
    Placement::InsideShadow,
    Placement::LightBehind,
    Placement::LightInFrustum,
    Placement::Touching,
];

/// All kinds of light.
pub const KINDS: [&str; 3] = ["point", "spot", "directional"];

/// A view and a light of one kind.
#[derive(Clone, Debug)]
pub struct Case {
    /// Camera.
    pub camera: Camera,
    /// Its place.
    pub view: Transform,
    /// Light.
    pub light: Light,
    /// Its place.
    pub place: Transform,
}

/// Builds a case for a model with these bounds; `vertex` is a point of its surface.
pub fn case(bounds: Aabb, vertex: Vec3, placement: Placement, kind: &str, aspect: f32) -> Case {
    let center = bounds.center();
    let radius = bounds.half_size().length().max(1e-3);
    let at = |direction: Vec3, distance: f32| center + direction.normalize() * (distance * radius);
    let up_right = Vec3::new(0.7, 1.3, 0.45);
    let (eye, light) = match placement {
        Placement::Outside => (at(Vec3::new(0.5, 0.45, 0.9), 2.8), at(up_right, 2.2)),
        Placement::InsideShadow => (at(-up_right.with_y(0.35), 1.35), at(up_right.with_y(0.35), 2.0)),
        Placement::LightBehind => (
            at(Vec3::new(-0.6, 0.5, 0.8), 2.3),
            at(Vec3::new(-0.75, 0.75, 0.8), 4.5),
        ),
        Placement::LightInFrustum => (
            at(Vec3::new(0.2, 0.35, 1.0), 3.2),
            at(Vec3::new(-0.3, 0.9, -0.2), 0.9),
        ),
        Placement::Touching => {
            let outward = (vertex - center).normalize_or(Vec3::Z);
            (vertex + outward * (radius * 0.002), at(up_right, 1.8))
        }
    };
    let target = if eye.distance(center) > 1e-4 * radius {
        center
    } else {
        center + Vec3::X * radius
    };
    let look = (target - eye).normalize();
    let up = if look.y.abs() > 0.95 { Vec3::X } else { Vec3::Y };
    let place = Transform::from_translation(light).looking_at(center, up_for(center - light));
    let kind = match kind {
        "point" => LightKind::Point,
        "spot" => LightKind::Spot {
            inner_angle: 0.35,
            outer_angle: 0.6,
        },
        _ => LightKind::Directional,
    };
    Case {
        camera: Camera {
            vertical_fov: 0.9,
            near: 0.004 * radius,
            aspect,
            ..Camera::default()
        },
        view: Transform::from_translation(eye).looking_at(target, up),
        light: Light {
            kind,
            color: Vec3::ONE,
            intensity: 10.0,
            range: if kind == LightKind::Point {
                6.0 * radius
            } else {
                f32::INFINITY
            },
        },
        place,
    }
}

fn up_for(direction: Vec3) -> Vec3 {
    if direction.normalize_or_zero().y.abs() > 0.95 {
        Vec3::X
    } else {
        Vec3::Y
    }
}
