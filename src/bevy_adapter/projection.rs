//! Conversion of Bevy's views to [`Camera`]. Only this file knows how Bevy and this crate write projections.

use bevy::math::{Mat4, UVec2};
use bevy::render::camera::TemporalJitter;
use bevy::transform::components::GlobalTransform;
use glam::{Affine3A, DMat4, Vec2};

use crate::scene::Camera;

/// The projection of a view that Bevy renders.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewProjection {
    /// Camera of this crate that shows the same picture.
    pub camera: Camera,
    /// Slope of the lines of sight to the right and up, metres per metre of depth. Bevy's jitter causes it in
    /// orthographic views; elsewhere it is 0.
    pub lean: Vec2,
    /// Projection with which Bevy draws its depth, including the jitter of temporal antialiasing.
    pub clip_from_view: DMat4,
}

impl ViewProjection {
    /// Returns the transform of [`ViewProjection::camera`] for a view with the transform `world_from_view`.
    pub fn place(&self, world_from_view: &GlobalTransform) -> GlobalTransform {
        if self.lean == Vec2::ZERO {
            return *world_from_view;
        }
        // A point straight ahead of our camera at depth 1 is beside the axis of Bevy's view.
        let mut lean = Affine3A::IDENTITY;
        lean.matrix3.z_axis -= self.lean.extend(0.0).to_vec3a();
        GlobalTransform::from(world_from_view.affine() * lean)
    }
}

/// Converts the projection of a view. `viewport` is the size of the view in pixels. Returns `None` if the
/// projection is neither perspective nor orthographic; Bevy then lights the view alone.
///
/// Perspective views may be off-centre and may have a far plane. Their near plane need not be parallel to the
/// picture; the near plane of [`ViewProjection::camera`] is then at the depth of its nearest visible point.
/// Orthographic views may be off-centre.
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
    if [m.x_axis.y, m.y_axis.x] != [0.0; 2] {
        return None;
    }
    let (camera, lean) = match m.row(3).to_array() {
        [0.0, 0.0, -1.0, 0.0] => (perspective(&m)?, Vec2::ZERO),
        [0.0, 0.0, 0.0, 1.0] => orthographic(&m)?,
        _ => return None,
    };
    camera.is_valid().then_some(ViewProjection {
        camera,
        lean,
        clip_from_view: m.as_dmat4(),
    })
}

fn perspective(m: &Mat4) -> Option<Camera> {
    if [m.w_axis.x, m.w_axis.y] != [0.0; 2] {
        return None;
    }
    let half = Vec2::new(m.x_axis.x, m.y_axis.y).recip();
    let shift = -m.z_axis.truncate().truncate();
    // The view depth at which the ray through each corner, (x, y, -1) times depth, meets the near plane, on which
    // z is w.
    let corners = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let depths = corners.map(|(x, y)| {
        let ray = (Vec2::new(x, y) - shift) * half;
        m.w_axis.z / (1.0 + m.z_axis.z - m.x_axis.z * ray.x - m.y_axis.z * ray.y)
    });
    let near = depths
        .into_iter()
        .filter(|depth| *depth > 0.0)
        .fold(f32::INFINITY, f32::min);
    Some(Camera {
        vertical_fov: 2.0 * half.y.atan(),
        near,
        aspect: half.x / half.y,
        shift,
        orthographic: None,
    })
}

/// Returns the camera and the slope of its lines of sight ([`ViewProjection::lean`]). Stored depth is
/// `a · z + b`: 1 on the near plane, 0 on the far plane.
fn orthographic(m: &Mat4) -> Option<(Camera, Vec2)> {
    if [m.x_axis.z, m.y_axis.z] != [0.0; 2] {
        return None;
    }
    let half = Vec2::new(m.x_axis.x, m.y_axis.y).recip();
    let (a, b) = (f64::from(m.z_axis.z), f64::from(m.w_axis.z));
    let (near, far) = (((b - 1.0) / a) as f32, (b / a) as f32);
    let camera = Camera {
        shift: m.w_axis.truncate().truncate(),
        ..Camera::orthographic(2.0 * half.y, near, far, half.x / half.y)
    };
    // x_clip = (x + (z_axis.x · half.x) z) / half.x
    Some((camera, m.z_axis.truncate().truncate() * half))
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
        // The near plane goes through (0, 0, -2) and is tilted.
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
    fn an_orthographic_view_is_ours_to_rounding() {
        let mut projection = OrthographicProjection::default_3d();
        projection.area = bevy::math::Rect::new(-3.0, -1.0, 5.0, 2.0); // off-centre
        (projection.near, projection.far) = (-2.0, 40.0);
        let view = projection_of(&projection.get_clip_from_view(), None, SIZE).unwrap();
        assert_eq!(view.lean, Vec2::ZERO);
        let ours = view.camera.clip_from_view();
        assert!(
            ours.abs_diff_eq(view.clip_from_view, 1e-6),
            "{ours} {}",
            view.clip_from_view
        );
        let jitter = TemporalJitter {
            offset: Vec2::new(0.25, -0.375),
        };
        let jittered = projection_of(&projection.get_clip_from_view(), Some(&jitter), SIZE).unwrap();
        // The leaning camera and Bevy's jittered projection must show any point at the same place.
        let place = GlobalTransform::from(bevy::transform::components::Transform::from_xyz(1.0, 2.0, 3.0));
        let from = |place: &GlobalTransform| place.affine().inverse();
        for point in [glam::vec3(0.3, 0.7, -4.0), glam::vec3(-2.0, 1.0, -30.0)] {
            let bevys = jittered
                .clip_from_view
                .as_mat4()
                .project_point3(from(&place).transform_point3(point));
            let in_ours = from(&jittered.place(&place)).transform_point3(point);
            let ours = jittered.camera.clip_from_view().as_mat4().project_point3(in_ours);
            assert!(ours.abs_diff_eq(bevys, 1e-5), "{ours} {bevys}");
        }
    }

    #[test]
    fn other_projections_are_refused() {
        let mut skewed = bevy(None);
        skewed.x_axis.y = 0.1;
        assert_eq!(projection_of(&skewed, None, SIZE), None);
        assert_eq!(projection_of(&Mat4::IDENTITY.mul_scalar(-1.0), None, SIZE), None);
    }
}
