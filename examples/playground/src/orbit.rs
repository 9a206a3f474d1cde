//! Moves of the camera: around its target, through the scene, nearer and farther.

use glam::{DMat4, Quat, UVec2, Vec2, Vec3};

use antumbra::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};

use crate::document::Eye;

/// The steepest view up or down, radians from the horizon.
const STEEPEST: f32 = 1.55;

/// Largest height of the direction to the right of a level view. More tilts the picture by a tenth of a pixel at its borders.
const LEVEL: f32 = 1e-4;

impl Eye {
    /// Returns the view of a camera that looks at a point at a distance. Up is the world's if the camera is level, so that
    /// one orbits about the vertical; otherwise, or if the camera looks straight up or down, up is the camera's own.
    pub fn at(camera: Camera, place: &Transform, distance: f32) -> Self {
        let up = place.up().as_vec3();
        let is_level = place.right().y.abs() < LEVEL && up.y > LEVEL;
        Self {
            eye: place.translation,
            target: place.translation + place.forward() * distance,
            up: if is_level { Vec3::Y } else { up },
            camera,
        }
    }

    fn forward(&self) -> Vec3 {
        (self.target - self.eye).try_normalize().unwrap_or(Vec3::NEG_Z)
    }

    fn right(&self) -> Vec3 {
        let right = self.forward().cross(self.up).try_normalize();
        right.unwrap_or_else(|| self.forward().any_orthonormal_vector())
    }

    /// Returns the view's directions to the right, up and forward.
    pub fn axes(&self) -> [Vec3; 3] {
        let (right, forward) = (self.right(), self.forward());
        [right, right.cross(forward), forward]
    }

    /// Turns the offset between eye and target by angles, radians.
    fn turned(&self, offset: Vec3, by: Vec2) -> Vec3 {
        let up = self.up.try_normalize().unwrap_or(Vec3::Y);
        let offset = Quat::from_axis_angle(up, by.x) * offset;
        let elevation = offset
            .try_normalize()
            .map_or(0.0, |direction| direction.dot(up).clamp(-1.0, 1.0).asin());
        let wanted = (elevation + by.y).clamp(-STEEPEST, STEEPEST);
        let axis = offset.cross(up).try_normalize().unwrap_or(Vec3::X);
        Quat::from_axis_angle(axis, wanted - elevation) * offset
    }

    /// Goes around the target by angles: to the left, and up; radians.
    pub fn orbit(&mut self, by: Vec2) {
        self.eye = self.target + self.turned(self.eye - self.target, by);
    }

    /// Looks around from where the eye is: to the left, and up; radians.
    pub fn look(&mut self, by: Vec2) {
        self.target = self.eye + self.turned(self.target - self.eye, by);
    }

    /// Moves eye and target along the view's axes: right, up, forward; metres.
    pub fn fly(&mut self, by: Vec3) {
        let [right, up, forward] = self.axes();
        let step = right * by.x + up * by.y + forward * by.z;
        self.eye += step;
        self.target += step;
    }

    /// Goes nearer to the target by a factor.
    pub fn dolly(&mut self, factor: f32) {
        const FARTHEST: f32 = 1e6;
        // The near plane of a file may be anywhere.
        let least = (self.camera.near * 2.0).min(FARTHEST);
        let offset = self.eye - self.target;
        let length = (offset.length() * factor).max(least).min(FARTHEST);
        self.eye = self.target + offset.normalize_or(Vec3::Z) * length;
    }

    /// Distance to the target, metres.
    pub fn distance(&self) -> f32 {
        self.eye.distance(self.target)
    }

    /// Returns the map from points of the view, with the origin at its top left corner, to rays and back.
    pub fn lens(&self, size: UVec2) -> Lens {
        let transform = Transform::from_translation(self.eye).looking_to(self.forward(), self.up);
        let aspect = size.x as f32 / size.y.max(1) as f32;
        let camera = Camera {
            aspect,
            ..self.camera
        };
        let view = Camera::view_from_world(&GlobalTransform::from(transform)).unwrap_or(DMat4::IDENTITY);
        Lens {
            clip_from_world: camera.clip_from_view() * view,
            axes: self.axes(),
            eye: self.eye,
            camera,
            size: size.as_vec2(),
        }
    }
}

/// Connects points of the picture with rays in the scene.
#[derive(Clone, Copy, Debug)]
pub struct Lens {
    clip_from_world: DMat4,
    axes: [Vec3; 3],
    eye: Vec3,
    camera: Camera,
    size: Vec2,
}

impl Lens {
    /// Returns the pixel of a point; `None` behind the viewer.
    pub fn pixel(&self, point: Vec3) -> Option<Vec2> {
        let clip = self.clip_from_world * point.as_dvec3().extend(1.0);
        if !(clip.w > 1e-6) {
            return None;
        }
        let ndc = (clip.truncate() / clip.w).as_vec3();
        let pixel = (Vec2::new(ndc.x, -ndc.y) * 0.5 + 0.5) * self.size;
        pixel.is_finite().then_some(pixel)
    }

    /// Returns a line segment in pixels, cut at the viewer.
    pub fn segment(&self, a: Vec3, b: Vec3) -> Option<[Vec2; 2]> {
        const NEAR: f64 = 1e-3;
        let clip = |point: Vec3| self.clip_from_world * point.as_dvec3().extend(1.0);
        let (wa, wb) = (clip(a).w, clip(b).w);
        if wa < NEAR && wb < NEAR {
            return None;
        }
        let cut = |behind: Vec3, front: Vec3, wb: f64, wf: f64| {
            let share = (NEAR - wb) / (wf - wb);
            behind.lerp(front, share as f32)
        };
        let start = if wa < NEAR { cut(a, b, wa, wb) } else { a };
        let end = if wb < NEAR { cut(b, a, wb, wa) } else { b };
        Some([self.pixel(start)?, self.pixel(end)?])
    }

    /// Returns the ray through a pixel: its origin and its direction.
    pub fn ray(&self, pixel: Vec2) -> (Vec3, Vec3) {
        let ndc = (pixel / self.size.max(Vec2::ONE) - 0.5) * Vec2::new(2.0, -2.0);
        let [right, up, forward] = self.axes;
        if let Some(flat) = self.camera.orthographic {
            let half = Vec2::new(flat.height * self.camera.aspect, flat.height) * 0.5 * ndc;
            return (self.eye + right * half.x + up * half.y, forward);
        }
        let (half_x, half_y) = self.camera.half_extent_at_unit_distance();
        let direction = forward + right * (ndc.x * half_x as f32) + up * (ndc.y * half_y as f32);
        (self.eye, direction.normalize_or(forward))
    }

    /// Direction in which the viewer looks.
    pub fn forward(&self) -> Vec3 {
        self.axes[2]
    }

    /// Metres that a pixel covers at a point.
    pub fn metres_per_pixel(&self, point: Vec3) -> f32 {
        if let Some(flat) = self.camera.orthographic {
            return flat.height / self.size.y.max(1.0);
        }
        let depth = (point - self.eye).dot(self.axes[2]).abs().max(1e-3);
        let (_, half) = self.camera.half_extent_at_unit_distance();
        2.0 * half as f32 * depth / self.size.y.max(1.0)
    }
}

#[cfg(test)]
mod tests {
    use glam::EulerRot;

    use super::*;

    fn eye() -> Eye {
        Eye {
            eye: Vec3::new(1.0, 2.0, 5.0),
            target: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::Y,
            camera: Camera::default(),
        }
    }

    #[test]
    fn a_ray_goes_through_the_point_of_its_pixel() {
        let lens = eye().lens(UVec2::new(320, 180));
        let point = Vec3::new(0.4, 0.7, 1.0);
        let (origin, direction) = lens.ray(lens.pixel(point).unwrap());
        let along = (point - origin).dot(direction);
        assert!((origin + direction * along).distance(point) < 1e-4);
        assert!(
            lens.pixel(Vec3::new(2.0, 3.0, 10.0)).is_none(),
            "behind the viewer"
        );
    }

    #[test]
    fn a_view_is_turned_as_its_camera() {
        let turned = |yaw: f32, pitch: f32, roll: f32| Quat::from_euler(EulerRot::YXZ, yaw, pitch, roll);
        let quarter = std::f32::consts::FRAC_PI_2;
        for (rotation, is_level) in [
            (turned(2.0, -0.6, 0.0), true),
            (turned(2.0, -0.6, 0.3), false),
            (turned(2.0, 0.2, std::f32::consts::PI), false),
            (turned(0.5, -quarter, 0.0), false),
            (turned(0.5, quarter, 0.0), false),
        ] {
            let place = Transform::from_xyz(1.0, 2.0, 3.0).with_rotation(rotation);
            let eye = Eye::at(Camera::default(), &place, 4.0);
            let of_camera = [Vec3::X, Vec3::Y, Vec3::NEG_Z].map(|axis| rotation * axis);
            for (axis, expected) in eye.axes().into_iter().zip(of_camera) {
                assert!(
                    axis.distance(expected) < 1e-5,
                    "{rotation}: {axis} is not {expected}"
                );
            }
            assert_eq!(eye.up == Vec3::Y, is_level, "{rotation}");
            assert!((eye.distance() - 4.0).abs() < 1e-5);
        }
    }

    #[test]
    fn orbiting_keeps_the_distance_and_never_goes_over_the_top() {
        let mut eye = eye();
        let distance = eye.distance();
        for _ in 0..20 {
            eye.orbit(Vec2::new(0.3, 0.4));
        }
        assert!((eye.distance() - distance).abs() < 1e-3);
        assert!(eye.axes().iter().all(|axis| axis.is_finite()));
        eye.dolly(1e-9);
        assert!(eye.distance() > 0.0);
        for (near, factor) in [
            (1e30, 1.0),
            (0.1, f32::INFINITY),
            (0.1, f32::NAN),
            (f32::NAN, 2.0),
        ] {
            eye.camera.near = near;
            eye.dolly(factor);
            assert!(
                eye.eye.is_finite() && eye.distance() > 0.0,
                "{near} {factor}: {eye:?}"
            );
        }
    }
}
