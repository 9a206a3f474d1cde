//! Texels per pixel of the screen, at sample points: the measure by which a map's slide is chosen.

use glam::{DMat2, DVec2, DVec3, DVec4};

use super::light_camera::Rows;
use super::view_space::ViewSpace;
use crate::geometry::Aabb;

/// Number of samples across and down the screen.
const GRID: [u32; 2] = [16, 9];

/// A point that the screen shows, with a small piece of surface around it.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The point, view coordinates.
    pub point: DVec3,
    /// Two vectors along the surface, view coordinates.
    pub tangents: [DVec3; 2],
    /// The two tangents on the screen, NDC.
    pub screen: DMat2,
}

/// Returns the places of the samples on the screen, NDC.
pub fn places() -> impl Iterator<Item = DVec2> {
    let [across, down] = GRID;
    (0..across * down).map(move |i| {
        let (x, y) = (f64::from(i % across), f64::from(i / across));
        DVec2::new(
            (x + 0.5) / f64::from(across) * 2.0 - 1.0,
            1.0 - (y + 0.5) / f64::from(down) * 2.0,
        )
    })
}

/// Side of a texel where no picture shows the sample, screens.
const FARTHEST: f64 = 1e9;

/// Number of samples below which the points that a map must show are samples too.
const FEW: usize = 8;

/// Collects the points where lines of sight meet the boxes first. A line that starts in a box meets its far side, where there
/// may be no surface: the next box that it meets, or else the farthest that it starts in, gives a sample, too. If the boxes
/// are too small for the grid, `points` in view coordinates stand in for them.
///
/// Points outside of the half-spaces, in view coordinates, are no samples: a map need not show them. `light` is a
/// homogeneous point of world space.
pub fn collect_samples(
    space: &ViewSpace,
    boxes: &[Aabb],
    half_spaces: &[DVec4],
    points: &[DVec3],
    light: DVec4,
    samples: &mut Vec<Sample>,
) {
    samples.clear();
    let must_show = |sample: &Sample| {
        let mut sides = half_spaces.iter().map(|half| half.dot(sample.point.extend(1.0)));
        sides.all(|side| side >= 0.0)
    };
    for place in places() {
        let (from, along) = space.line_of_sight(place.x, place.y);
        let hits = || boxes.iter().filter_map(|aabb| hit(space, aabb, from, along));
        let nearest = |a: Hit, b: Hit| if b.at < a.at { b } else { a };
        let farthest = |a: Hit, b: Hit| if b.at > a.at { b } else { a };
        let first = hits().reduce(nearest);
        // The surface in a box around the eye may be elsewhere in the box, or the line may miss it.
        let next = hits().filter(|hit| !hit.starts_within).reduce(nearest);
        let next = next.or_else(|| hits().reduce(farthest));
        for hit in first.into_iter().chain(next.filter(|next| first != Some(*next))) {
            let point = space.eye_world + from + along * hit.at;
            samples.extend(Sample::new(space, point, along, light).filter(must_show));
        }
    }
    if samples.len() < FEW {
        let every = points.len().div_ceil(64).max(1);
        for point in points.iter().step_by(every) {
            let world = space.eye_world + space.to_axes * (*point - space.eye);
            let along = if space.is_perspective {
                world - space.eye_world
            } else {
                space.to_axes * DVec3::Z
            };
            samples.extend(Sample::new(space, world, along, light));
        }
    }
}

/// Where a line of sight meets a box.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Hit {
    /// Place on the line, as a factor on its direction.
    at: f64,
    /// Whether the line starts within the box. The place is then on the far side.
    starts_within: bool,
}

/// Where a line of sight meets a box in front of the near plane.
fn hit(space: &ViewSpace, aabb: &Aabb, from: DVec3, along: DVec3) -> Option<Hit> {
    let nearest = if space.is_perspective { space.near } else { 0.0 };
    let (enter, leave) = aabb.crossed_by(space.eye_world + from, along)?;
    let starts_within = enter < nearest;
    let at = if starts_within { leave } else { enter };
    (leave >= nearest).then_some(Hit { at, starts_within })
}

/// Returns what two small vectors at a point are in the picture with these rows, NDC.
fn steps(rows: &Rows, point: DVec3, tangents: &[DVec3; 2]) -> DMat2 {
    let [x, y, w] = rows.map(|row| row.dot(point.extend(1.0)));
    let step = |tangent: DVec3| {
        let [dx, dy, dw] = rows.map(|row| row.truncate().dot(tangent));
        DVec2::new((dx - x / w * dw) / w, (dy - y / w * dw) / w)
    };
    DMat2::from_cols(step(tangents[0]), step(tangents[1]))
}

/// Returns the longer axis of the ellipse to which a matrix maps the unit circle: its greater singular value.
fn longer_axis(matrix: DMat2) -> f64 {
    let squares = matrix.x_axis.length_squared() + matrix.y_axis.length_squared();
    let difference = (squares * squares - 4.0 * matrix.determinant().powi(2))
        .max(0.0)
        .sqrt();
    (0.5 * (squares + difference)).sqrt()
}

impl Sample {
    /// Makes the sample of a point of world space, seen along a line. The surface there is unknown; it is
    /// assumed to face the middle between the viewer and the light. Ratios of two maps' texel areas do not depend
    /// on it; those of the longer sides do, a little.
    fn new(space: &ViewSpace, world: DVec3, along: DVec3, light: DVec4) -> Option<Self> {
        let to_light = (light.truncate() - world * light.w).normalize_or_zero();
        let normal = (to_light - along.normalize_or_zero()).try_normalize()?;
        let (right, up) = normal.any_orthonormal_pair();
        let tangents = [right, up].map(|axis| space.from_axes * axis);
        let point = space.point(world);
        let w = if space.is_perspective { DVec4::Z } else { DVec4::W };
        let screen = steps(&[DVec4::X, DVec4::Y, w], point, &tangents);
        let area = screen.determinant().abs();
        (area > 0.0 && area.is_finite()).then_some(Self {
            point,
            tangents,
            screen,
        })
    }

    /// Longer side of a texel on the screen, NDC of the screen per NDC of the map. `pictures` have rows for view
    /// coordinates; the first that shows the sample counts.
    fn texel_side(&self, pictures: &[Rows]) -> f64 {
        for rows in pictures {
            let [x, y, w] = rows.map(|row| row.dot(self.point.extend(1.0)));
            if w > 0.0 && x.abs().max(y.abs()) <= w * (1.0 + 1e-6) {
                let map = steps(rows, self.point, &self.tangents);
                let screen_from_map = self.screen * map.inverse();
                let side = longer_axis(screen_from_map);
                return if side.is_finite() {
                    side.min(FARTHEST)
                } else {
                    FARTHEST
                };
            }
        }
        FARTHEST
    }
}

/// Mean of the longer sides of texels on the screen, in units of the ratio of screen and map: the aliasing that is seen.
/// Long thin texels count by their length, because it is that which makes edges coarse and bias large.
pub fn mean_texel_side(pictures: &[Rows], samples: &[Sample]) -> f64 {
    let sides = samples.iter().map(|sample| sample.texel_side(pictures));
    sides.sum::<f64>() / samples.len().max(1) as f64
}

/// Median of the longer sides of texels on the screen, in the same units: what half of the visible surfaces has at least.
/// `sides` is working memory.
pub fn median_texel_side(pictures: &[Rows], samples: &[Sample], sides: &mut Vec<f64>) -> f64 {
    sides.clear();
    sides.extend(samples.iter().map(|sample| sample.texel_side(pictures)));
    sides.sort_unstable_by(f64::total_cmp);
    sides.get(sides.len() / 2).copied().unwrap_or(0.0)
}
