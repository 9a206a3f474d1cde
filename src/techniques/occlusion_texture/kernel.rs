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

/// Where a slice is, and how finely a lookup sees it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lookup {
    /// Depth at which casters of the slice begin.
    pub top: f32,
    /// Depth at which the slice ends.
    pub bottom: f32,
    /// Depth at which its casters are taken to be.
    pub plane: f32,
    /// Texels along a side of the picture.
    pub side: f32,
    /// Squares of a lookup in N-buffers.
    pub taps: f32,
}

/// Returns the part of a kernel that shows no surface in the receiver's own plane, because a flat surface hides nothing from
/// itself. Receiver and unit normal are in light space.
///
/// Taking the casters of a slice to be at one depth moves them along the rays of the picture, into the room before their
/// plane wherever these rays are not in the plane. The kernel's lower side is raised above them and above the texels that a
/// lookup touches.
pub fn over_own_plane(
    face: &OcclusionFace,
    at: &Lookup,
    receiver: Vec3,
    normal: Vec3,
    kernel: Kernel,
) -> Kernel {
    let across = normal.truncate();
    let is_along_x = across.x.abs() > across.y.abs();
    let axis = if is_along_x { Vec2::X } else { Vec2::Y };
    let steepness = across.dot(axis);
    if steepness.abs() < 1e-4 {
        return kernel;
    }
    let divisor = |depth| face.depth[0] * depth + face.depth[1];
    let [scale_x, scale_y, offset_x, offset_y] = face.projection;
    let metres = 2.0 * divisor(at.plane) / Vec2::new(scale_x, scale_y);
    let ndc = (kernel.center - 0.5) * Vec2::new(2.0, -2.0) - Vec2::new(offset_x, offset_y);
    let middle = (0.5 * metres * ndc).extend(at.plane);
    let least = Vec2::splat((kernel.half.max_element() / at.taps).max(0.5 / at.side));
    let half = kernel.half.max(least);
    let lowest = normal.dot(middle - receiver) - across.abs().dot(half * metres);
    // Height that a point in the plane gains for each metre by which it is moved, times the divisor where it was.
    let rate = face.depth[0] * normal.dot(receiver) + face.depth[1] * normal.z;
    let gained = |from| (at.plane - from) * rate / divisor(from);
    let texel = metres.max_element() / at.side;
    let raised = gained(at.top).max(gained(at.bottom)).max(0.0);
    let missing = raised + TOUCHED * texel * across.length() - lowest;
    if missing <= 0.0 {
        return kernel;
    }
    let cut = missing / (steepness.abs() * axis.dot(metres));
    let full = axis.dot(half);
    let left = (full - 0.5 * cut).max(axis.dot(least));
    let upwards = Vec2::new(1.0, -1.0) * axis * steepness.signum();
    let shortened = kernel.half.min(Vec2::splat(left));
    Kernel {
        center: kernel.center + upwards * (cut + left - full),
        half: if is_along_x {
            Vec2::new(shortened.x, kernel.half.y)
        } else {
            Vec2::new(kernel.half.x, shortened.y)
        },
    }
}

/// Adds the hidden share that one more slice leaves to what the slices before it left. Both begin at 0.
/// [`SliceCombination::Overlap`] knows more than these shares, see [`add_overlapping`]; here it is the product.
pub fn combine(combination: SliceCombination, hidden: f32, more: f32) -> f32 {
    match combination {
        SliceCombination::Product | SliceCombination::Overlap => 1.0 - (1.0 - hidden) * (1.0 - more),
        SliceCombination::Maximum => hidden.max(more),
        SliceCombination::Sum => (hidden + more).min(1.0),
    }
}

/// How much wider than a kernel the rectangle is in which the depth of its casters is looked for. By measure: with 1, thin walls
/// beside the rays of the picture are missed; with 3, casters beside the kernel move it.
pub const WIDER: f32 = 2.0;

/// Distance behind a caster at which its shadow begins, in thicknesses of the caster's slice. By measure: with less, bent surfaces
/// shadow themselves.
pub const BEGINS: f32 = 0.15;

/// Distance behind a caster at which its shadow is whole, in thicknesses of the caster's slice. By measure: with more, light passes
/// thin walls; with less, surfaces that the light grazes show the rounding of their receivers.
pub const WHOLE: f32 = 0.75;

/// Returns the depth at which the casters of a slice between `top` and `bottom` are taken to be. `below` is their mean depth
/// below the top, in thicknesses of the slice.
pub fn measured_plane(top: f32, bottom: f32, below: f32) -> f32 {
    top + below.clamp(0.0, 1.0) * (bottom - top)
}

/// Returns the share of a shadow that a receiver at a depth gets from casters at the mean depth `plane`, in a slice of a
/// thickness.
pub fn measured_weight(plane: f32, thickness: f32, depth: f32) -> f32 {
    let fade = ((WHOLE - BEGINS) * thickness).max(1e-30);
    ((depth - plane - BEGINS * thickness) / fade).clamp(0.0, 1.0)
}

/// Shares of one kernel's area, as the pictures show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Share that casters of the slice cover.
    pub own: f32,
    /// Share that casters of any slice before it cover, as seen from the centre of projection.
    pub above: f32,
    /// Share that casters of the slice or of any slice before it cover.
    pub united: f32,
}

/// Adds one more slice to the hidden share that the slices before it left. `weight` is the share of the slice's shadow that
/// the receiver gets.
///
/// Rays of the kernel are of two kinds: those that pass casters before the slice in the pictures, and the others. The
/// pictures tell which part of either kind the slice hides. Rays that the slices before it hide are taken to be of the first
/// kind, as far as there are enough of those, and to be spread evenly within each kind.
///
/// Beyond Eisemann & Décoret 2008, eq. 5: where the slice hides as large a part of both kinds, this is the product.
pub fn add_overlapping(hidden: f32, weight: f32, shares: Shares) -> f32 {
    let Shares { own, above, united } = shares;
    let beside = (united - above).max(0.0);
    let behind = (own - beside).max(0.0);
    let more = if hidden < above {
        beside + behind * (1.0 - hidden / above)
    } else {
        beside * (1.0 - hidden) / (1.0 - above).max(1e-6)
    };
    (hidden + weight * more).clamp(0.0, 1.0)
}
