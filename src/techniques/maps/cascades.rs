//! The boxes that a directional light's maps show: one for each part of the view depth, fitted to it, and standing still
//! while the view turns or moves a little.
//!
//! A part is bounded by a ball, whose size does not change as the view turns; its centre moves in steps of whole texels,
//! so that edges do not swim. The steps are larger than a texel, and the boxes larger than the balls by as much: in
//! between nothing changes, and a kept map stays as it is.
//! Source: Valient 2008, "Stable Rendering of Cascaded Shadow Maps" (ShaderX6); Zhang et al. 2006, "Parallel-Split Shadow
//! Maps for Large-scale Virtual Environments".

use glam::DVec3;

use super::face::{FaceProjection, MapFace};
use super::settings::Cascades;
use crate::sets::ViewData;

/// Share of a ball's radius by which its box is larger.
const MARGIN: f64 = 1.0 / 16.0;

/// Steps of depth, a box's half side each: so far a box may reach to the light further than its casters.
const DEPTH_STEP: f64 = 0.5;

/// Most cascades of a light.
pub const MOST_CASCADES: u32 = 4;

/// View depths between which each cascade fits, nearest first; `count + 1` of them.
///
/// `far` is rounded up to a quarter of a power of two, so that it does not follow every move.
pub fn split_depths(cascades: &Cascades, near: f64, far: f64) -> [f64; MOST_CASCADES as usize + 1] {
    let far = far.max(near * 1.001);
    let far = ((far.log2() * 4.0).ceil() / 4.0).exp2();
    let count = f64::from(cascades.count);
    // A near plane at a millimetre would take all cascades for the first metre.
    let first = near.max(far / 256.0);
    std::array::from_fn(|i| {
        if i == 0 {
            return near;
        }
        let share = (i as f64 / count).min(1.0);
        let log = first * (far / first).powf(share);
        let uniform = first + (far - first) * share;
        uniform + (log - uniform) * f64::from(cascades.log_share)
    })
}

/// The same in an orthographic view, whose pixels are as large everywhere: alike, and the length rounded up.
pub fn even_splits(cascades: &Cascades, near: f64, far: f64) -> [f64; MOST_CASCADES as usize + 1] {
    let length = (((far - near).max(1e-3).log2() * 4.0).ceil() / 4.0).exp2();
    std::array::from_fn(|i| near + length * (i as f64 / f64::from(cascades.count)).min(1.0))
}

/// Centre and radius of the smallest ball around the part of the view between two depths.
pub fn slice_ball(view: &ViewData, near: f64, far: f64) -> (DVec3, f64) {
    let shape = view.frustum.shape();
    let forward = shape.forward.normalize();
    // A rotation in f32 is of unit length but for rounding, and a ball must not change with that.
    let length = |axis: DVec3| (axis.length() * 1e5).round() * 1e-5;
    let scale = length(shape.forward);
    // Off-centre by what jitters, the ball stays the same.
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

/// The box of one part; `nearest_caster` gives the smallest distance along the light's direction from the given point, of
/// what may cast into a box, if there is anything.
pub fn fit(
    view: &ViewData,
    towards: DVec3,
    depths: (f64, f64),
    resolution: u32,
    nearest_caster: impl Fn(&MapFace) -> Option<f64>,
) -> MapFace {
    let (center, radius) = slice_ball(view, depths.0, depths.1);
    let z = -towards.normalize();
    let (x, y) = z.any_orthonormal_pair();
    let half = radius * (1.0 + MARGIN);
    let texel = 2.0 * half / f64::from(resolution);
    let step = texel * (2.0 * MARGIN * radius / texel).floor().max(1.0);
    let snap = |axis: DVec3, step: f64| axis * ((axis.dot(center) / step).round() * step);
    let depth_step = half * DEPTH_STEP;
    let snapped = snap(x, step) + snap(y, step) + snap(z, depth_step);
    // All of the ball, and half a step of depth.
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
