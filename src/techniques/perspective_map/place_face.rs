//! A picture of post-projective space as a face of a map: a frame at the light, a homography and the depths of casters.

use glam::{DMat3, DVec3, DVec4};

use super::fit_input::FitInput;
use super::light_camera::Rows;
use super::view_space::ViewSpace;
use crate::techniques::maps::MapFace;
use crate::techniques::maps::matrix_faces::{near_of_mean, parallel_face, point_face};
use crate::techniques::maps::members::{farthest, near_plane};

/// Steepest slope of the plane under the receivers from which depth counts.
const STEEPEST_BASE: f64 = 100.0;

/// Makes a face of a picture: the frame at the light in world space, and the homography that the rows are in
/// that frame.
pub(super) fn place_face(
    input: &FitInput,
    space: &ViewSpace,
    rows: &Rows,
    points: &[DVec3],
) -> Option<MapFace> {
    let light = input.light.point_world;
    let column = |at: DVec4| DVec3::from_array(rows.map(|row| row.dot(at)));
    let direction = |axis: DVec3| column((space.from_axes * axis).extend(0.0));
    // A homography may be scaled; w is about 1 at the points.
    let w = |point: &DVec3| rows[2].dot(point.extend(1.0));
    let largest = points.iter().map(|point| w(point).abs()).fold(0.0, f64::max);
    let scale = largest.max(f64::MIN_POSITIVE).recip();
    let to_world = |point: &DVec3| space.eye_world + space.to_axes * (*point - space.eye);
    let face = if light.w == 0.0 {
        let z = -light.truncate().normalize();
        let (x, y) = z.any_orthonormal_pair();
        let axes = [x, y, z];
        let origin = to_world(points.first()?);
        let local = |point: &DVec3| {
            let offset = to_world(point) - origin;
            DVec3::from_array(axes.map(|axis| axis.dot(offset)))
        };
        // Near points have the most pixels, and the least w.
        let weighted = |point: &DVec3| (local(point), 1.0 / (point.z * point.z).max(1e-12));
        let base = base_plane(points.iter().map(weighted));
        let up = x * base.x + y * base.y - z;
        let mut height: f64 = 1e-3;
        input.for_each_caster(|center, half| {
            height = height.max(base.z + up.dot(center - origin) + up.abs().dot(half));
        });
        let at_origin = column(space.point(origin).extend(1.0));
        let homography = DMat3::from_cols(direction(x), direction(y), at_origin) * scale;
        parallel_face(origin, axes, &homography, base, height * (1.0 + 1e-3))
    } else {
        let origin = light.truncate();
        let middle = points.iter().map(to_world).sum::<DVec3>() / points.len() as f64;
        let z = (middle - origin).normalize_or(DVec3::NEG_Y);
        let (x, y) = z.any_orthonormal_pair();
        let homography = DMat3::from_cols(direction(x), direction(y), direction(z)) * scale;
        let near = near_distance(input, &homography);
        point_face(origin, [x, y, z], &homography, near)
    };
    let clip = face.clip_from_world();
    (clip.is_finite() && clip.inverse().is_finite()).then_some(face)
}

/// Returns the plane z = a x + b y + c close to points with weights, as (a, b, c), with no point beyond it: the
/// plane of least squares, moved along z.
fn base_plane(points: impl Iterator<Item = (DVec3, f64)> + Clone) -> DVec3 {
    let sum = |value: &dyn Fn(DVec3) -> f64| points.clone().map(|(p, weight)| value(p) * weight).sum::<f64>();
    let total = sum(&|_| 1.0).max(f64::MIN_POSITIVE);
    let mean = DVec3::new(sum(&|p| p.x), sum(&|p| p.y), sum(&|p| p.z)) / total;
    let (xx, yy) = (sum(&|p| (p.x - mean.x).powi(2)), sum(&|p| (p.y - mean.y).powi(2)));
    let xy = sum(&|p| (p.x - mean.x) * (p.y - mean.y));
    let (xz, yz) = (
        sum(&|p| (p.x - mean.x) * (p.z - mean.z)),
        sum(&|p| (p.y - mean.y) * (p.z - mean.z)),
    );
    let ridge = 1e-9 * (xx + yy) + f64::MIN_POSITIVE;
    let (xx, yy) = (xx + ridge, yy + ridge);
    let determinant = xx * yy - xy * xy;
    let (a, b) = (
        (xz * yy - yz * xy) / determinant,
        (yz * xx - xz * xy) / determinant,
    );
    // Receivers along the light have no such plane.
    let is_steep = !(a.abs().max(b.abs()) < STEEPEST_BASE);
    let (a, b) = if is_steep { (0.0, 0.0) } else { (a, b) };
    let beyond = points
        .map(|(p, _)| p.z - a * p.x - b * p.y)
        .fold(f64::MIN, f64::max);
    DVec3::new(a, b, beyond + 1e-6 * (1.0 + beyond.abs()))
}

/// Distance from a light at a position within which nothing casts, metres, where w rises least along a ray.
///
/// It follows the casters, as in plain maps. The near plane of a warped picture is nearer to the light where w rises faster.
/// So where the light is on a surface, whose parts within its clearance block nothing, the clearance is the geometric mean
/// of the distances in the picture.
fn near_distance(input: &FitInput, homography: &DMat3) -> f64 {
    if let Some(near) = input.settings.near {
        return f64::from(near);
    }
    let (light, objects) = (input.light, input.objects);
    let reach = farthest(light, input.casters(), objects);
    let near = near_plane(light, input.casters(), objects, reach);
    if near.most > near.metres {
        near_of_mean(homography, near.metres, near.most)
    } else {
        near.metres
    }
}
