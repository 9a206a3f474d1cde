//! From Bevy's view to our camera. The one file that knows how either writes a projection.

use bevy::math::{Mat4, UVec2, Vec2};
use bevy::render::camera::TemporalJitter;

use crate::scene::Camera;

/// The camera of a view: its projection as Bevy renders with it, jitter of temporal antialiasing included. `None` for a
/// projection that ours cannot be; the lights of such a view are Bevy's.
pub fn camera_of(clip_from_view: &Mat4, jitter: Option<&TemporalJitter>, viewport: UVec2) -> Option<Camera> {
    let m = clip_from_view;
    let _ = jitter;
    let is_perspective = m.w_axis.w == 0.0 && m.z_axis.w == -1.0;
    if !is_perspective || viewport.x == 0 || viewport.y == 0 {
        return None;
    }
    let camera = Camera {
        vertical_fov: 2.0 * (1.0 / m.y_axis.y).atan(),
        near: m.w_axis.z,
        aspect: m.y_axis.y / m.x_axis.x,
    };
    camera.is_valid().then_some(camera)
}

/// What Bevy adds to a clip position for each unit of `w`, in NDC.
pub fn jitter_ndc(jitter: &TemporalJitter, viewport: UVec2) -> Vec2 {
    jitter.offset * Vec2::new(2.0, -2.0) / viewport.as_vec2()
}
