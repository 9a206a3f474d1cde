//! Finds the surface that each pixel shows.

use bevy_transform::prelude::GlobalTransform;
use glam::{DMat3, DVec3, UVec2, Vec3};
use rayon::prelude::*;

use super::error::ReferenceError;
use super::ray::Ray;
use super::ray_scene::RayScene;
use crate::scene::Camera;

/// The surface point that is visible at a pixel's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Position in world space, metres. It lies on the triangle up to rounding.
    pub position: DVec3,
    /// Unit normal of the triangle, turned towards the camera.
    pub normal: DVec3,
    /// Index of the triangle in [`RayScene::triangles`].
    pub triangle: u32,
    /// Distance along the line of sight, metres: from the eye, or in an orthographic view from depth 0.
    pub distance: f64,
    /// Depth along the camera's −Z, in the camera's units (metres unless it is scaled).
    pub view_depth: f64,
}

/// The visible surface of every pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct HitImage {
    /// Width and height, pixels.
    pub size: UVec2,
    /// The surface of each pixel, rows from the top, `size.x · size.y` entries. `None` where no surface is
    /// visible.
    pub hits: Vec<Option<SurfaceHit>>,
}

/// Which faces are invisible to the camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PrimaryCulling {
    /// The camera sees all faces.
    #[default]
    None,
    /// The camera does not see the backs of triangles that are not double-sided. The front is the side from
    /// which a triangle winds counter-clockwise before a mirroring transform, so mirrored objects keep their
    /// outside.
    SingleSided,
}

/// Rays through the pixel centres (+0.5), rows from the top. Their parameter is the view depth. The shape of
/// the picture is [`Camera::aspect`], not that of `size`.
///
/// # Errors
/// [`ReferenceError::Camera`] or [`ReferenceError::CameraTransform`].
pub fn camera_rays(
    camera: &Camera,
    world_from_camera: &GlobalTransform,
    size: UVec2,
) -> Result<Vec<Ray>, ReferenceError> {
    if !camera.is_valid() {
        return Err(ReferenceError::Camera {
            vertical_fov: camera.vertical_fov,
            near: camera.near,
            aspect: camera.aspect,
        });
    }
    if Camera::view_from_world(world_from_camera).is_none() {
        return Err(ReferenceError::CameraTransform);
    }
    let affine = world_from_camera.affine();
    let world_from_view = DMat3::from_cols_array(&affine.matrix3.to_cols_array().map(f64::from));
    let origin = Vec3::from(affine.translation).as_dvec3();
    let (right, up) = camera.half_extent_at_unit_distance();
    let shift = camera.shift.as_dvec2();
    let rows = 0..size.y;
    Ok(rows
        .flat_map(|y| (0..size.x).map(move |x| (x, y)))
        .map(|(x, y)| {
            let ndc_x = (f64::from(x) + 0.5) / f64::from(size.x) * 2.0 - 1.0;
            let ndc_y = 1.0 - (f64::from(y) + 0.5) / f64::from(size.y) * 2.0;
            let across = DVec3::new((ndc_x - shift.x) * right, (ndc_y - shift.y) * up, 0.0);
            if camera.orthographic.is_some() {
                return Ray {
                    origin: origin + world_from_view * across,
                    direction: world_from_view * DVec3::NEG_Z,
                };
            }
            Ray {
                origin,
                direction: world_from_view * (across + DVec3::NEG_Z),
            }
        })
        .collect())
}

/// Finds the surface of every pixel, with all triangles visible from both sides. Nothing in front of the near
/// plane is visible, nor anything beyond the far plane of an orthographic view.
///
/// # Errors
/// The errors of [`camera_rays`].
pub fn primary_hits(
    scene: &RayScene,
    camera: &Camera,
    world_from_camera: &GlobalTransform,
    size: UVec2,
) -> Result<HitImage, ReferenceError> {
    primary_hits_culled(scene, camera, world_from_camera, size, PrimaryCulling::None)
}

/// Finds the surface of every pixel like [`primary_hits`], with a choice of culling.
///
/// # Errors
/// The errors of [`camera_rays`].
pub fn primary_hits_culled(
    scene: &RayScene,
    camera: &Camera,
    world_from_camera: &GlobalTransform,
    size: UVec2,
    culling: PrimaryCulling,
) -> Result<HitImage, ReferenceError> {
    let rays = camera_rays(camera, world_from_camera, size)?;
    let planes = (
        f64::from(camera.near),
        camera
            .orthographic
            .map_or(f64::INFINITY, |view| f64::from(view.far)),
    );
    let hits = rays
        .par_iter()
        .map(|ray| surface_hit(scene, ray, planes, culling))
        .collect();
    Ok(HitImage { size, hits })
}

/// The surface that a ray shows. The ray's parameter must be the view depth.
fn surface_hit(
    scene: &RayScene,
    ray: &Ray,
    (near, far): (f64, f64),
    culling: PrimaryCulling,
) -> Option<SurfaceHit> {
    let hit = scene.closest_hit(ray, near, far, |triangle| {
        let [a, b, c] = triangle.corners;
        triangle.is_primary
            && (culling == PrimaryCulling::None
                || triangle.is_double_sided
                || (b - a).cross(c - a).dot(ray.direction) < 0.0)
    })?;
    let [a, b, c] = scene.triangles()[hit.triangle as usize].corners;
    // The position is computed from the corners, not along the ray, so that it lies on the plane to a few
    // roundings of its coordinates, however grazing the view.
    let position = a * hit.barycentric.x + b * hit.barycentric.y + c * hit.barycentric.z;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    Some(SurfaceHit {
        position,
        normal: if normal.dot(ray.direction) < 0.0 {
            normal
        } else {
            -normal
        },
        triangle: hit.triangle,
        distance: position.distance(ray.origin),
        view_depth: hit.t,
    })
}
