//! Faces with a matrix: which of them shows a point, how large its texels are there, and the depth of a plane.
//!
//! A matrix whose centre of projection is the light differs from a plain picture of the light by a homography
//! of the picture alone. All points of a ray fall on one texel, whatever the matrix, so any warp gives exact
//! shadows; it moves texels to where they are needed.
//!
//! Twin of `shaders/techniques/maps/matrix.wgsl`, held equal by `tests/gpu/maps/matrix_twins.rs`.

use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

use super::face::{FaceProjection, MapFace};

/// Largest NDC, in x and y, up to which a picture is drawn: [`MapFace::with_border`] at most halves a picture.
const WIDEST: f64 = 2.0;

/// Makes a face of a light at a position.
///
/// `homography` maps a direction from the light, in the face's space, to x, y and w of clip space. Casters
/// nearer to the light than `near` metres, at the places of the picture where w rises least along a ray, are
/// not drawn.
pub fn point_face(origin: DVec3, axes: [DVec3; 3], homography: &DMat3, near: f64) -> MapFace {
    // A unit step along the ray that falls on a place `p` raises w by 1 / |homography⁻¹ (p, 1)|.
    let longest = rays(homography).map(DVec3::length).fold(0.0, f64::max);
    let [x, y, z] =
        [homography.x_axis, homography.y_axis, homography.z_axis].map(|c| DVec4::new(c.x, c.y, 0.0, c.z));
    MapFace {
        origin,
        axes,
        projection: FaceProjection::Matrix {
            clip_from_face: DMat4::from_cols(x, y, z, DVec4::Z * (near / longest)),
            parallel: false,
        },
    }
}

/// Returns the distance that [`point_face`] takes for a near plane whose distances in the picture have the geometric mean
/// `mean`, and of which none is more than `most`.
pub fn near_of_mean(homography: &DMat3, mean: f64, most: f64) -> f64 {
    let inverse = homography.inverse();
    let (mut shortest, mut longest) = (f64::INFINITY, f64::MIN_POSITIVE);
    for x in [-1.0, 0.0, 1.0] {
        for y in [-1.0, 0.0, 1.0] {
            let ray = (inverse * DVec3::new(x, y, 1.0)).length();
            (shortest, longest) = (shortest.min(ray), longest.max(ray));
        }
    }
    let widest = rays(homography).map(DVec3::length).fold(0.0, f64::max);
    let mean_ray = (shortest * longest).sqrt().max(f64::MIN_POSITIVE);
    widest * (mean / mean_ray).min(most / longest)
}

/// Makes a face of a directional light.
///
/// `homography` maps (x, y, 1) of the face's space to x, y and w of clip space. The base is the plane
/// z = `base.x` x + `base.y` y + `base.z` of the face's space. Depth is the distance along the ray from there
/// towards the light, up to `height` metres, divided by w. A base close under the receivers keeps depth small
/// where w is small, so that the rounding of w does not show.
pub fn parallel_face(
    origin: DVec3,
    axes: [DVec3; 3],
    homography: &DMat3,
    base: DVec3,
    height: f64,
) -> MapFace {
    // w at a place `p` is 1 / (homography⁻¹ (p, 1)).z.
    let least_w = rays(homography).map(|ray| ray.z).fold(0.0, f64::max).recip();
    let scale = least_w / height;
    let [x, y, one] = [homography.x_axis, homography.y_axis, homography.z_axis];
    MapFace {
        origin,
        axes,
        projection: FaceProjection::Matrix {
            clip_from_face: DMat4::from_cols(
                DVec4::new(x.x, x.y, scale * base.x, x.z),
                DVec4::new(y.x, y.y, scale * base.y, y.z),
                DVec4::Z * -scale,
                DVec4::new(one.x, one.y, scale * base.z, one.z),
            ),
            parallel: true,
        },
    }
}

/// What a homography maps to the corners of the largest picture, with w = 1.
fn rays(homography: &DMat3) -> impl Iterator<Item = DVec3> {
    let inverse = homography.inverse();
    let corners = [
        (-WIDEST, -WIDEST),
        (WIDEST, -WIDEST),
        (-WIDEST, WIDEST),
        (WIDEST, WIDEST),
    ];
    corners
        .into_iter()
        .map(move |(x, y)| inverse * DVec3::new(x, y, 1.0))
}

/// A point in the picture of a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shown {
    /// Index of the face.
    pub face: usize,
    /// Place in the picture, NDC.
    pub ndc: DVec2,
    /// Depth in the picture.
    pub depth: f64,
}

/// Returns the face in which a point of world space is farthest from the border, if any face shows it.
pub fn showing<'a>(faces: impl IntoIterator<Item = &'a MapFace>, point: DVec3) -> Option<Shown> {
    let mut best: Option<Shown> = None;
    let mut nearest = 1.0;
    for (index, face) in faces.into_iter().enumerate() {
        let clip = face.clip_from_relative(point) * DVec4::W;
        let ndc = clip.truncate().truncate() / clip.w;
        let border = ndc.abs().max_element();
        if clip.w > 0.0 && border <= nearest {
            nearest = border;
            best = Some(Shown {
                face: index,
                ndc,
                depth: clip.z / clip.w,
            });
        }
    }
    best
}

/// Returns the two sides of a face's texel at a point of world space, metres, at right angles to the ray of
/// light: to the right and up in the picture.
///
/// Source: Kozlov 2004, GPU Gems ch. 14, §14.2.3. There the step keeps the depth of the map; here it is
/// projected along the ray, because a step along a ray changes no texel.
pub fn texel_at(face: &MapFace, point: DVec3, resolution: u32) -> [DVec3; 2] {
    let clip_from_relative = face.clip_from_relative(point);
    let relative_from_clip = clip_from_relative.inverse();
    let w = (clip_from_relative * DVec4::W).w;
    let ray = away(&relative_from_clip);
    [relative_from_clip.x_axis, relative_from_clip.y_axis].map(|column| {
        let step = column.truncate() * (w * 2.0 / f64::from(resolution));
        step - ray * ray.dot(step)
    })
}

/// Returns the unit direction of the light's ray at the origin of a relative space.
fn away(relative_from_clip: &DMat4) -> DVec3 {
    -relative_from_clip.z_axis.truncate().normalize_or_zero()
}

/// Returns the depth of a plane at a place of the picture: where the ray of light passes the plane
/// `normal · point = offset`. `None` if the plane's front does not face the light. The shader has it as `plane_in_face`.
pub fn plane_depth(face: &MapFace, normal: DVec3, offset: f64, ndc: DVec2) -> Option<f64> {
    let relative_from_clip = face.clip_from_relative(DVec3::ZERO).inverse();
    let plane = relative_from_clip.transpose() * normal.extend(-offset);
    (plane.z > 0.0).then(|| -(plane.x * ndc.x + plane.y * ndc.y + plane.w) / plane.z)
}

/// Returns the ray of light that falls on a place of the picture: a point of it and its unit direction.
pub fn ray(face: &MapFace, ndc: DVec2) -> (DVec3, DVec3) {
    let relative_from_clip = face.clip_from_relative(face.origin).inverse();
    let far = relative_from_clip * ndc.extend(0.0).extend(1.0);
    let light = relative_from_clip.z_axis;
    let direction = (far.truncate() * light.w - light.truncate() * far.w).normalize_or_zero();
    let start = match face.projection {
        FaceProjection::Matrix { parallel: true, .. } => relative_from_clip * ndc.extend(1.0).extend(1.0),
        _ => light,
    };
    (face.origin + start.truncate() / start.w, direction)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Faces whose pictures are warped in many ways.
    fn faces() -> Vec<MapFace> {
        let mut faces = Vec::new();
        for i in 0..40 {
            let at = |k: i32| f64::from((i * k + 3) % 41) / 41.0 - 0.5;
            let z = DVec3::new(at(7), at(11) - 0.8, at(17)).normalize();
            let (x, y) = z.any_orthonormal_pair();
            let homography = DMat3::from_cols(
                DVec3::new(1.0 + at(5), 0.5 * at(19), 0.4 * at(23)),
                DVec3::new(0.5 * at(29), 1.0 + at(31), 0.4 * at(37)),
                DVec3::new(at(13), at(9), 1.5),
            );
            let origin = DVec3::new(3.0 * at(3), 4.0, 5.0 * at(8));
            faces.push(point_face(origin, [x, y, z], &homography, 0.01));
            faces.push(parallel_face(
                origin,
                [x, y, z],
                &homography,
                DVec3::new(0.3, -0.2, 20.0),
                30.0,
            ));
        }
        faces
    }

    #[test]
    fn depths_of_planes_are_depths_of_the_points_that_rays_meet() {
        let mut seen = 0;
        for face in faces() {
            for i in 0..20 {
                let at = |k: i32| f64::from((i * k + 1) % 23) / 11.5 - 1.0;
                let (normal, offset) = (DVec3::new(0.4 * at(3), 1.0, 0.4 * at(5)).normalize(), 0.3 * at(7));
                let ndc = DVec2::new(at(11), at(13)) * 0.99;
                let (start, direction) = ray(&face, ndc);
                let Some(depth) = plane_depth(&face, normal, offset, ndc) else {
                    assert!(normal.dot(direction) >= -1e-9 || normal.dot(face.origin) <= offset);
                    continue;
                };
                let along = (offset - normal.dot(start)) / normal.dot(direction);
                if !(along > 0.0) {
                    continue;
                }
                let point = start + direction * along;
                let Some(shown) = showing([&face], point) else {
                    continue;
                };
                assert!((shown.ndc - ndc).length() < 1e-6, "{face:?} {ndc}");
                assert!(
                    (shown.depth - depth).abs() < 1e-9 * depth.abs().max(1.0),
                    "{} {depth}",
                    shown.depth
                );
                let nearer = showing([&face], point - direction * 0.01).expect("the ray stays in one place");
                assert!(nearer.depth > depth, "depth falls along the ray");
                let [right, up] = texel_at(&face, point, 64);
                for (step, axis) in [(right, DVec2::X), (up, DVec2::Y)] {
                    let clip = face.clip_from_world() * (point + step * 1e-3).extend(1.0);
                    let moved = (clip.truncate().truncate() / clip.w - ndc) * 32.0 * 1e3;
                    assert!((moved - axis).length() < 0.02, "{moved}");
                    assert!(step.dot(direction).abs() < 1e-9);
                }
                seen += 1;
            }
        }
        assert!(seen > 300, "{seen}");
    }

    #[test]
    fn near_planes_of_a_mean_are_around_it_and_not_beyond_the_most() {
        for face in faces() {
            let FaceProjection::Matrix {
                clip_from_face,
                parallel: false,
            } = face.projection
            else {
                continue;
            };
            let [x, y, z] = [
                clip_from_face.x_axis,
                clip_from_face.y_axis,
                clip_from_face.z_axis,
            ];
            let homography = DMat3::from_cols(
                DVec3::new(x.x, x.y, x.w),
                DVec3::new(y.x, y.y, y.w),
                DVec3::new(z.x, z.y, z.w),
            );
            for (most, limits) in [(f64::INFINITY, (0.01, f64::INFINITY)), (0.004, (0.0, 0.004))] {
                let near = near_of_mean(&homography, 0.01, most);
                let face = point_face(face.origin, face.axes, &homography, near);
                let mut farthest: f64 = 0.0;
                let mut nearest = f64::INFINITY;
                for (x, y) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (0.0, 0.0)] {
                    let (start, direction) = ray(&face, DVec2::new(x, y));
                    let clip = face.clip_from_world() * (start + direction).extend(1.0);
                    let distance = clip.z / clip.w; // of the point whose depth is 1
                    (nearest, farthest) = (nearest.min(distance), farthest.max(distance));
                }
                assert!(
                    farthest >= limits.0 * 0.999 && farthest <= limits.1 * 1.001,
                    "{farthest}"
                );
                assert!(most.is_finite() || nearest <= 0.01 * 1.001, "{nearest}");
            }
        }
    }

    #[test]
    fn a_border_shows_more() {
        for face in faces() {
            let wider = face.with_border(0.5);
            let (point, direction) = ray(&face, DVec2::new(1.5, -1.2));
            let point = point + direction * 3.0;
            assert!(showing([&face], point).is_none());
            let shown = showing([&wider], point).expect("it lies in the border");
            assert!((shown.ndc - DVec2::new(0.75, -0.6)).length() < 1e-6);
            assert_eq!(showing([&face, &wider], point).map(|shown| shown.face), Some(1));
        }
    }
}
