//! One face: a camera at the light in post-projective space, with the axis of the smallest cone around what it
//! must see, and the smallest rectangle around its picture.

use glam::{DMat3, DVec2, DVec3, DVec4};

use super::projection::ProjectedLight;
use super::smallest_cone::smallest_cone;

/// Rows of a picture: x, y and w as linear functions of homogeneous points of post-projective space. All are 0
/// at the light.
pub type Rows = [DVec4; 3];

/// Cosine of the largest angle between the axis and what a camera sees. Beyond, most texels are at the
/// picture's border.
const LEAST_COS: f64 = 0.1;

/// Share of the light's distance below which the light counts as at infinity: the directions from it differ too
/// little to be told apart.
const AT_INFINITY: f64 = 1e-6;

/// Number of rectangles that are tried, turned by equal steps over a right angle.
const TURNS: u32 = 16;

/// Returns the picture that shows all points, −1 to 1 in x and y, or `None` if the points are around the light.
/// `directions` and `picture` are scratch memory.
pub fn fit(
    light: &ProjectedLight,
    points: &[DVec3],
    directions: &mut Vec<DVec3>,
    picture: &mut Vec<DVec2>,
) -> Option<Rows> {
    let plain = camera(light, points, directions)?;
    picture.clear();
    for point in points {
        let [x, y, w] = plain.map(|row| row.dot(point.extend(1.0)));
        if !(w > 0.0) {
            return None;
        }
        picture.push(DVec2::new(x, y) / w);
    }
    let window = smallest_rectangle(picture);
    let rows = [0, 1, 2].map(|row| {
        let [x, y, one] = [window.x_axis[row], window.y_axis[row], window.z_axis[row]];
        plain[0] * x + plain[1] * y + plain[2] * one
    });
    rows.iter().all(|row| row.is_finite()).then_some(rows)
}

/// Returns the camera with the axis of the smallest cone around the points.
fn camera(light: &ProjectedLight, points: &[DVec3], directions: &mut Vec<DVec3>) -> Option<Rows> {
    let ProjectedLight { point: at, w } = *light;
    let farthest = points.iter().map(|point| point.length()).fold(0.0, f64::max);
    if w * farthest <= AT_INFINITY * at.length() {
        let z = -at.try_normalize()?;
        let (x, y) = z.any_orthonormal_pair();
        return Some([x.extend(0.0), y.extend(0.0), (z * w).extend(at.length())]);
    }
    directions.clear();
    directions.extend(points.iter().map(|point| (*point * w - at).normalize_or_zero()));
    let cone = smallest_cone(directions).filter(|cone| cone.cos > LEAST_COS)?;
    let z = cone.axis;
    let (x, y) = z.any_orthonormal_pair();
    Some([x, y, z].map(|axis| (axis * w).extend(-axis.dot(at))))
}

/// Returns the map that turns and stretches the smallest rectangle around points to the square −1 … 1.
fn smallest_rectangle(points: &[DVec2]) -> DMat3 {
    let mut best = (f64::INFINITY, DMat3::IDENTITY);
    for turn in 0..TURNS {
        let (sin, cos) = (std::f64::consts::FRAC_PI_2 * f64::from(turn) / f64::from(TURNS)).sin_cos();
        let (x, y) = (DVec2::new(cos, sin), DVec2::new(-sin, cos));
        let (mut min, mut max) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        for point in points {
            let turned = DVec2::new(x.dot(*point), y.dot(*point));
            (min, max) = (min.min(turned), max.max(turned));
        }
        let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
        // A rectangle without width would have no inverse.
        let half = half.max(DVec2::splat(1e-6 * half.max_element().max(1e-9)));
        let area = half.x * half.y;
        if area < best.0 {
            let (x, y) = (x / half.x, y / half.y);
            let window = DMat3::from_cols(
                DVec3::new(x.x, y.x, 0.0),
                DVec3::new(x.y, y.y, 0.0),
                DVec3::new(-middle.x / half.x, -middle.y / half.y, 1.0),
            );
            best = (area, window);
        }
    }
    best.1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube() -> Vec<DVec3> {
        (0..8)
            .map(|i| DVec3::from_array([0, 1, 2].map(|bit| if i >> bit & 1 == 0 { -1.0 } else { 1.0 })))
            .collect()
    }

    #[test]
    fn every_point_is_in_the_picture_and_the_picture_is_full() {
        let (mut directions, mut picture) = (Vec::new(), Vec::new());
        let places = [
            (DVec3::new(3.0, 0.5, -0.2), 1.0),
            (DVec3::new(0.0, 0.0, 1.5), 1.0),
            (DVec3::new(0.3, 0.9, 0.1), 1e-9),
            (DVec3::new(0.3, 0.9, 0.1), 0.0),
            (DVec3::new(2.0, 1.0, 1e4), 1e-3),
        ];
        for (point, w) in places {
            let light = ProjectedLight { point, w };
            let rows = fit(&light, &cube(), &mut directions, &mut picture).expect("the cube is on one side");
            let (mut least, mut most) = (DVec2::ZERO, DVec2::ZERO);
            for corner in cube() {
                let [x, y, w] = rows.map(|row| row.dot(corner.extend(1.0)));
                let ndc = DVec2::new(x, y) / w;
                assert!(w > 0.0 && ndc.abs().max_element() < 1.0 + 1e-9);
                (least, most) = (least.min(ndc), most.max(ndc));
            }
            assert!(
                least.max_element() < -0.999 && most.min_element() > 0.999,
                "{least} {most}"
            );
            // The light itself is the centre of projection.
            let at_light = rows.map(|row| row.dot(point.extend(w)));
            assert!(at_light.iter().all(|value| value.abs() < 1e-9), "{at_light:?}");
        }
    }

    #[test]
    fn points_around_the_light_have_no_picture() {
        let light = ProjectedLight {
            point: DVec3::new(0.1, 0.2, 0.0),
            w: 1.0,
        };
        assert!(fit(&light, &cube(), &mut Vec::new(), &mut Vec::new()).is_none());
    }
}
