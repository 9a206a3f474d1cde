//! From Bevy's view to our camera. The one file that knows how either writes a projection.

use bevy::math::{Mat4, UVec2};
use bevy::render::camera::TemporalJitter;
use glam::{DMat4, Vec2};

use crate::scene::Camera;

/// A view as Bevy renders it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewProjection {
    /// What it shows.
    pub camera: Camera,
    /// The matrix that Bevy's depth is of, jitter of temporal antialiasing included.
    pub clip_from_view: DMat4,
}

/// The projection of a view of a size in pixels. `None` for one that is no perspective: the lights of such a view are
/// Bevy's.
///
/// Perspectives may be off-centre, have a far plane, or a near plane that is not parallel to the picture: the depth of
/// ours is then that of its nearest visible point.
pub fn projection_of(
    clip_from_view: &Mat4,
    jitter: Option<&TemporalJitter>,
    viewport: UVec2,
) -> Option<ViewProjection> {
    if viewport.x == 0 || viewport.y == 0 {
        return None;
    }
    let mut m = *clip_from_view;
    if let Some(jitter) = jitter {
        jitter.jitter_projection(&mut m, viewport.as_vec2());
    }
    let weights = m.row(3);
    let skews = [m.x_axis.y, m.y_axis.x, m.w_axis.x, m.w_axis.y];
    if weights != glam::vec4(0.0, 0.0, -1.0, 0.0) || skews != [0.0; 4] {
        return None;
    }
    let half = Vec2::new(m.x_axis.x, m.y_axis.y).recip();
    let shift = -m.z_axis.truncate().truncate();
    // Where the ray through a corner, (x, y, -1) times its depth, meets the plane on which z is w.
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let depths = corners.map(|(x, y)| {
        let ray = (Vec2::new(x, y) - shift) * half;
        m.w_axis.z / (1.0 + m.z_axis.z - m.x_axis.z * ray.x - m.y_axis.z * ray.y)
    });
    let near = depths
        .into_iter()
        .filter(|depth| *depth > 0.0)
        .fold(f32::INFINITY, f32::min);
    let camera = Camera {
        vertical_fov: 2.0 * half.y.atan(),
        near,
        aspect: half.x / half.y,
        shift,
    };
    camera.is_valid().then_some(ViewProjection {
        camera,
        clip_from_view: m.as_dmat4(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::camera::{CameraProjection, OrthographicProjection, PerspectiveProjection};
    use glam::Vec4;

    const SIZE: UVec2 = UVec2::new(160, 90);

    fn bevy(near_clip_plane: Option<Vec4>) -> Mat4 {
        let mut projection = PerspectiveProjection {
            fov: 0.9,
            near: 0.25,
            aspect_ratio: 16.0 / 9.0,
            ..Default::default()
        };
        if let Some(plane) = near_clip_plane {
            projection.near_clip_plane = plane;
        }
        projection.get_clip_from_view()
    }

    #[test]
    fn a_perspective_is_ours_to_rounding() {
        let view = projection_of(&bevy(None), None, SIZE).unwrap();
        let ours = view.camera.clip_from_view();
        assert!(
            ours.abs_diff_eq(view.clip_from_view, 1e-6),
            "{ours} {}",
            view.clip_from_view
        );
    }

    #[test]
    fn jitter_shifts_the_picture_as_bevys_does() {
        let jitter = TemporalJitter {
            offset: Vec2::new(0.25, -0.375),
        };
        let view = projection_of(&bevy(None), Some(&jitter), SIZE).unwrap();
        assert!(view.camera.shift != Vec2::ZERO);
        assert!(
            view.camera
                .clip_from_view()
                .abs_diff_eq(view.clip_from_view, 1e-6)
        );
    }

    #[test]
    fn an_oblique_near_plane_has_the_depth_of_its_nearest_visible_point() {
        // A plane through (0, 0, -2), tilted.
        let normal = glam::vec3(0.3, 0.0, -1.0).normalize();
        let plane = normal.extend(-normal.dot(glam::vec3(0.0, 0.0, -2.0)));
        let view = projection_of(&bevy(Some(plane)), None, SIZE).unwrap();
        let right = (0.9f32 * 0.5).tan() * 16.0 / 9.0;
        let at_edge = |x: f32| -plane.w / normal.dot(glam::vec3(x, 0.0, -1.0));
        let expected = at_edge(right).min(at_edge(-right));
        assert!(
            (view.camera.near - expected).abs() < 1e-3,
            "{} {expected}",
            view.camera.near
        );
    }

    #[test]
    fn parallel_projections_are_refused() {
        let parallel = OrthographicProjection::default_3d().get_clip_from_view();
        assert_eq!(projection_of(&parallel, None, SIZE), None);
    }
}
