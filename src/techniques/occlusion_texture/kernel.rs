//! The rectangle of each slice through which a receiver sees the light, and how the slices' hidden shares are combined.
//!
//! Twin of the functions of the same names in `shaders/techniques/occlusion_texture/kernel.wgsl`.
//!
//! Source: Eisemann & Décoret 2008, "Occlusion Textures for Plausible Soft Shadows": eq. 4 for the kernel, eq. 5 for the
//! product, §3.4 for the slice that fades.

use glam::{Vec2, Vec3, Vec4};

use super::component::SliceCombination;
use super::records::OcclusionFace;

/// A rectangle of a slice's picture: the light as it is projected through a receiver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kernel {
    /// Middle of the rectangle, 0 to 1 inside the picture, from the upper left.
    pub center: Vec2,
    /// Half of the sides, in the same unit.
    pub half: Vec2,
}

/// Returns the depth at which a slice ends.
pub fn slice_bottom(face: &OcclusionFace, slice: usize) -> f32 {
    face.bottoms[slice / 4][slice % 4]
}

/// Returns the share of a slice's shadow that a receiver at a depth gets. A slice fades in over the thickness of the slice
/// behind it; the slice that holds the receiver gives nothing.
pub fn slice_weight(face: &OcclusionFace, slice: usize, count: usize, depth: f32) -> f32 {
    let bottom = slice_bottom(face, slice);
    let thickness = if slice + 1 < count {
        slice_bottom(face, slice + 1) - bottom
    } else {
        face.depth[3]
    };
    ((depth - bottom) / thickness.max(1e-30)).clamp(0.0, 1.0)
}

/// Returns the depth at which the casters of a slice are taken to be: where the slice ends for a receiver just behind it, and
/// in its middle for receivers that get its whole shadow. The source takes the end for all, which makes casters larger and
/// nearer to their receivers than they are.
pub fn slice_plane(face: &OcclusionFace, slice: usize, weight: f32) -> f32 {
    let bottom = slice_bottom(face, slice);
    let top = slice
        .checked_sub(1)
        .map_or(face.depth[2], |before| slice_bottom(face, before));
    bottom - 0.5 * weight * (bottom - top)
}

/// Texels around a kernel that its lookup touches, with the half texel by which what was drawn may be off.
pub const TOUCHED: f32 = 1.5;

/// Returns the metres by which a receiver is raised along its normal, both in light space, so that a surface nearly along the
/// light's rays does not shadow itself: past the texels that a lookup touches, and past the way that casters of the slice move
/// in the picture when they are taken to be at one depth, at most `reach` from theirs. `side` is that of the picture, texels.
pub fn slice_lift(
    face: &OcclusionFace,
    light: Vec4,
    side: f32,
    receiver: Vec3,
    normal: Vec3,
    reach: f32,
) -> f32 {
    let divisor = face.depth[0] * receiver.z + face.depth[1];
    let texel = 2.0 * divisor / (side * face.projection[0].min(face.projection[1]));
    let across = normal.truncate();
    // Rays from the light and from the centre of projection behind it part with the distance from the axis.
    let apart = across.dot(receiver.truncate()).abs() * face.depth[1] / (receiver.z * divisor);
    let parallax = if light.z > 0.5 { apart * reach } else { 0.0 };
    TOUCHED * texel * across.length() + parallax
}

/// Returns the rectangle at a depth through which a receiver sees the light, in a slice's picture. The receiver, in light
/// space, lies behind `plane` or on it. `light` is [`OcclusionLight::kernel`](super::records::OcclusionLight::kernel).
pub fn slice_kernel(face: &OcclusionFace, light: Vec4, receiver: Vec3, plane: f32) -> Kernel {
    let behind = (receiver.z - plane).max(0.0);
    let (mut middle, mut half) = (receiver.truncate(), light.truncate().truncate() * behind);
    if light.z > 0.5 {
        middle *= plane / receiver.z;
        half /= receiver.z;
    }
    if light.w > 0.5 {
        // A sphere that is seen at an angle casts a longer cone on the slice.
        let slope = receiver.truncate() / receiver.z;
        half *= Vec2::new((1.0 + slope.x * slope.x).sqrt(), (1.0 + slope.y * slope.y).sqrt());
    }
    let scale = Vec2::new(face.projection[0], face.projection[1]) / (face.depth[0] * plane + face.depth[1]);
    let ndc = middle * scale + Vec2::new(face.projection[2], face.projection[3]);
    Kernel {
        center: ndc * Vec2::new(0.5, -0.5) + 0.5,
        half: half * scale * 0.5,
    }
}

/// Adds the hidden share that one more slice leaves to what the slices before it left. Both begin at 0.
pub fn combine(combination: SliceCombination, hidden: f32, more: f32) -> f32 {
    match combination {
        SliceCombination::Product => 1.0 - (1.0 - hidden) * (1.0 - more),
        SliceCombination::Maximum => hidden.max(more),
        SliceCombination::Sum => (hidden + more).min(1.0),
    }
}
