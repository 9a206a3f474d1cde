//! The boxes that a directional light's maps show. Each is fitted to a part of the view depth and stands
//! still while the view turns or moves a little.
//!
//! A ball bounds each part; its size does not change as the view turns. Its centre moves in steps of whole
//! texels, so edges do not swim. The steps are larger than a texel, and the boxes are larger than the balls
//! by as much. Between two steps nothing changes and a kept map stays valid.
//! Source: Valient 2008, "Stable Rendering of Cascaded Shadow Maps" (ShaderX6); Zhang et al. 2006,
//! "Parallel-Split Shadow Maps for Large-scale Virtual Environments".

use glam::DVec3;

use super::face::{FaceProjection, MapFace};
use super::settings::Cascades;
use crate::sets::ViewData;

/// Margin between a ball and its box, as a share of the ball's radius.
const MARGIN: f64 = 1.0 / 16.0;

/// Border of a cascade that is not looked up, texels, beside the reach of its filter. Twin of `choose_cascades` in
/// `shaders/common/map_site.wgsl`.
pub const BORDER: f64 = 3.0;

/// Radius of a filter, metres, beyond which boxes grow no further, so that their sizes stay finite in `f32`.
const WIDEST_FILTER: f64 = 1e9;

/// Step in depth, as a share of the box's half side. A box may reach this much further to the light than its
/// casters.
const DEPTH_STEP: f64 = 0.5;

/// Largest number of cascades of a light.
pub const MOST_CASCADES: u32 = 4;

/// The view depths among which cascades are shared out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DepthRange {
    /// Depth of the view's near plane, where the first cascade begins.
    pub near: f64,
    /// Estimate of the depth of the nearest receiver. The ratio of `far` to it determines how depth is divided.
    pub nearest: f64,
    /// Depth of the nearest receiver whose bounds do not hold the camera; infinite without one.
    pub apart: f64,
    /// Depth beyond which no shadow is seen.
    pub far: f64,
    /// Depth at which shadows are to end, if that was asked for.
    pub end: Option<f64>,
}

/// Ratio of the range's ends up to which the division follows [`Cascades::log_share`] alone.
const MODERATE_RATIO: f64 = 256.0;

/// Largest ratio of the range's ends. Four cascades then each span a ratio of 16.
const LARGEST_RATIO: f64 = 65536.0;

/// Rounds a depth to a quarter of a power of two, so that it does not follow every move.
fn in_steps(depth: f64, round: impl Fn(f64) -> f64) -> f64 {
    (round(depth.log2() * 4.0) / 4.0).exp2()
}

/// Returns the view depths between which the cascades lie, nearest first; `count + 1` of them.
///
/// Both ends of the range are rounded, but not beyond the depth at which shadows are to end. Beyond a ratio of 256 between
/// them, equal parts would be so long that the first one shows little near the camera. The equal share of the division
/// therefore shrinks as the ratio grows, and counts up to that ratio only.
pub fn split_depths(cascades: &Cascades, range: &DepthRange) -> [f64; MOST_CASCADES as usize + 1] {
    let near = range.near;
    let least = near * 1.001;
    let far = in_steps(range.far.min(1e7 * near).max(least), f64::ceil);
    let far = range.end.map_or(far, |end| far.min(end.max(least)));
    // Without a bound, a receiver beside the camera would spend all cascades on the first metre.
    let nearest = in_steps(range.nearest.clamp(far / LARGEST_RATIO, far), f64::floor);
    let first = near.max(nearest.min(far / MODERATE_RATIO));
    let ratio = far / first;
    let equal_share = (1.0 - f64::from(cascades.log_share)) * (MODERATE_RATIO / ratio).min(1.0);
    let equal_end = far.min(MODERATE_RATIO * first);
    let count = f64::from(cascades.count);
    std::array::from_fn(|i| {
        let share = i as f64 / count;
        if i == 0 {
            return near;
        }
        if share >= 1.0 {
            return far;
        }
        let log = first * ratio.powf(share);
        let equal = first + (equal_end - first) * share;
        equal + (log - equal) * (1.0 - equal_share)
    })
}

/// Does what [`split_depths`] does for an orthographic view, whose pixels are equally large everywhere. All
/// cascades have the same depth, and their total depth is rounded up, but not beyond the depth at which shadows are to end.
pub fn even_splits(cascades: &Cascades, range: &DepthRange) -> [f64; MOST_CASCADES as usize + 1] {
    const LEAST: f64 = 1e-3;
    let (near, far) = (range.near, range.far);
    let length = in_steps((far - near).max(LEAST), f64::ceil);
    let length = range
        .end
        .map_or(length, |end| length.min((end - near).max(LEAST)));
    std::array::from_fn(|i| near + length * (i as f64 / f64::from(cascades.count)).min(1.0))
}

/// Returns centre and radius of the smallest ball around the part of the view between two depths.
pub fn slice_ball(view: &ViewData, near: f64, far: f64) -> (DVec3, f64) {
    let shape = view.frustum.shape();
    let forward = shape.forward.normalize();
    // The length of a rotated axis differs from 1 by rounding in `f32`; the ball must not change with that.
    let length = |axis: DVec3| (axis.length() * 1e5).round() * 1e-5;
    let scale = length(shape.forward);
    // A projection that is off-centre by jitter leaves the ball unchanged.
    let off_center = |center: f64| 1.0 + (center.abs() * 64.0).ceil() / 64.0;
    let (right, up) = (
        shape.half_right * off_center(shape.center.x) * length(shape.right) / scale,
        shape.half_up * off_center(shape.center.y) * length(shape.up) / scale,
    );
    if view.is_orthographic() {
        let (right, up, half) = (right * scale, up * scale, 0.5 * (far - near) * scale);
        let center = shape.eye + shape.forward * (0.5 * (near + far));
        return (center, (right * right + up * up + half * half).sqrt());
    }
    let (near, far) = (near * scale, far * scale);
    let spread = right * right + up * up;
    let middle = (0.5 * (near + far) * (1.0 + spread)).min(far);
    let radius_sq = (middle - near).powi(2) + near * near * spread;
    let radius_sq = radius_sq.max((far - middle).powi(2) + far * far * spread);
    (shape.eye + forward * middle, radius_sq.sqrt())
}

/// Fits the box of one part of the view depth, with room for a filter of the radius `softness`, metres, around whatever is
/// in that part.
///
/// `nearest_caster` returns the smallest distance, along the light's direction, of the casters in a box, or
/// `None` if there are none.
pub fn fit(
    view: &ViewData,
    towards: DVec3,
    depths: (f64, f64),
    resolution: u32,
    softness: f64,
    nearest_caster: impl Fn(&MapFace) -> Option<f64>,
) -> MapFace {
    let (center, radius) = slice_ball(view, depths.0, depths.1);
    let z = -towards.normalize();
    let (x, y) = z.any_orthonormal_pair();
    let texels = f64::from(resolution);
    // The border is a share of the box that it enlarges.
    let enlarged = |half: f64, border: f64| {
        (half + softness.min(WIDEST_FILTER)) / (1.0 - (2.0 * border / texels).min(0.5))
    };
    // A box of few texels moves by one texel, half of which may be more than the margin.
    let half = enlarged(radius * (1.0 + MARGIN), BORDER).max(enlarged(radius, BORDER + 0.5));
    let texel = 2.0 * half / texels;
    let step = texel * (2.0 * MARGIN * radius / texel).floor().max(1.0);
    let snap = |axis: DVec3, step: f64| axis * ((axis.dot(center) / step).round() * step);
    let depth_step = half * DEPTH_STEP;
    let snapped = snap(x, step) + snap(y, step) + snap(z, depth_step);
    // The box contains the ball and half a step of depth.
    let behind = half + 0.5 * depth_step;
    let everything = 1e12;
    let mut face = MapFace {
        origin: snapped - z * everything,
        axes: [x, y, z],
        projection: FaceProjection::Parallel {
            half,
            length: everything + behind,
        },
    };
    let before = nearest_caster(&face).map_or(behind, |nearest| {
        let before = (z.dot(snapped) - nearest).max(behind);
        (before / depth_step).ceil() * depth_step
    });
    face.origin = snapped - z * before;
    face.projection = FaceProjection::Parallel {
        half,
        length: before + behind,
    };
    face
}
