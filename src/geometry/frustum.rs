//! View frustum. In perspective its far plane is at infinity; in an orthographic view it is a box.

use glam::{DVec2, DVec3, DVec4, Vec4};
use smallvec::SmallVec;

use super::convex_solid::{HalfSpace, SolidEdge};
use super::{Plane, PlaneSet};

/// The region that a view sees, in the parameters of a camera. World space, in `f64` so that a camera far
/// from the origin keeps its shape. The three axes need neither unit length nor right angles. A left-handed
/// triple is a mirrored view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrustumShape {
    /// Apex of a perspective view, or the point from which an orthographic view measures depth, metres.
    pub eye: DVec3,
    /// Axis that points to the right of the picture.
    pub right: DVec3,
    /// Axis that points to the top of the picture.
    pub up: DVec3,
    /// Axis that points into the picture.
    pub forward: DVec3,
    /// Half the picture's width, in lengths of `right`. In perspective it is measured at the distance of
    /// `forward`; in an orthographic view it is the same at any depth.
    pub half_right: f64,
    /// Half the picture's height, in lengths of `up`, measured at the same distance as `half_right`.
    pub half_up: f64,
    /// Offset of the picture's centre from the axis `forward`, to the right and up, in halves of the
    /// picture's size. It is zero unless the view is off-centre.
    pub center: DVec2,
    /// Depth of the near plane, in lengths of `forward`.
    pub near: f64,
}

/// The view frustum of a reversed infinite projection. It has five planes; the plane at infinity counts as a
/// sixth face, which bounds nothing but is needed by the edge count of [`LightHull`](super::LightHull). In an
/// orthographic view all six faces are planes.
///
/// Corner `i` has bit 0 set on the right and bit 1 set at the top. Corners 0–3 are on the near plane
/// (`w = 1`). Corners 4–7 are the directions in which the far corners lie (`w = 0`), or in an orthographic
/// view the corners of the far plane (`w = 1`).
#[derive(Clone, Debug, PartialEq)]
pub struct Frustum {
    /// The planes in world space, in the order [`Frustum::NEAR`], `LEFT`, `RIGHT`, `BOTTOM`, `TOP`, and in an
    /// orthographic view `FAR`.
    pub planes: PlaneSet,
    /// The eight corners in world space, homogeneous.
    pub corners: [Vec4; 8],
    shape: FrustumShape,
    /// Depth of the far plane of an orthographic view, in lengths of `forward`.
    far: Option<f64>,
    /// The planes, relative to the eye.
    half_spaces: SmallVec<[HalfSpace; 6]>,
    /// The corners, relative to the eye. Directions have unit length.
    corners_eye: [DVec4; 8],
}

impl Frustum {
    /// Index of the near plane.
    pub const NEAR: usize = 0;
    /// Index of the left plane.
    pub const LEFT: usize = 1;
    /// Index of the right plane.
    pub const RIGHT: usize = 2;
    /// Index of the bottom plane.
    pub const BOTTOM: usize = 3;
    /// Index of the top plane.
    pub const TOP: usize = 4;
    /// Index of the far plane. In perspective it stands for the plane at infinity, which has no entry in
    /// [`Frustum::planes`].
    pub const FAR: usize = 5;

    /// The edges, each with its two planes. An edge runs counter-clockwise around its first plane seen from
    /// outside, and therefore clockwise around its second. In a mirrored view the two senses are exchanged.
    ///
    /// Source: O'Rorke 2004, "Managing Visibility for Per-Pixel Lighting", GPU Gems ch. 15, §15.4.4.
    pub const EDGES: [SolidEdge; 12] = [
        SolidEdge::new(0, 1, Self::NEAR, Self::BOTTOM),
        SolidEdge::new(1, 3, Self::NEAR, Self::RIGHT),
        SolidEdge::new(3, 2, Self::NEAR, Self::TOP),
        SolidEdge::new(2, 0, Self::NEAR, Self::LEFT),
        SolidEdge::new(0, 4, Self::BOTTOM, Self::LEFT),
        SolidEdge::new(1, 5, Self::RIGHT, Self::BOTTOM),
        SolidEdge::new(3, 7, Self::TOP, Self::RIGHT),
        SolidEdge::new(2, 6, Self::LEFT, Self::TOP),
        SolidEdge::new(4, 5, Self::BOTTOM, Self::FAR),
        SolidEdge::new(5, 7, Self::RIGHT, Self::FAR),
        SolidEdge::new(7, 6, Self::TOP, Self::FAR),
        SolidEdge::new(6, 4, Self::LEFT, Self::FAR),
    ];

    /// The frustum of a perspective view. `None` if the numbers do not span one: not finite, flat, or without
    /// a field of view.
    pub fn new(shape: &FrustumShape) -> Option<Self> {
        (shape.near > 0.0).then(|| Self::build(shape, None)).flatten()
    }

    /// The box of an orthographic view. `far` is the depth of its far plane in lengths of `forward` and lies
    /// beyond the near plane. `None` if the numbers do not span a box.
    pub fn orthographic(shape: &FrustumShape, far: f64) -> Option<Self> {
        let spans = shape.near.is_finite() && far.is_finite() && far > shape.near;
        spans.then(|| Self::build(shape, Some(far))).flatten()
    }

    fn build(shape: &FrustumShape, far: Option<f64>) -> Option<Self> {
        let FrustumShape {
            eye,
            right,
            up,
            forward,
            half_right,
            half_up,
            center,
            near,
        } = *shape;
        if !(eye.is_finite() && center.is_finite() && half_right > 0.0 && half_up > 0.0) {
            return None;
        }
        let across = |x: f64, y: f64| right * (half_right * (x + center.x)) + up * (half_up * (y + center.y));
        // A line of sight: the point where it passes at depth 0, and its direction from there.
        let line_at = |x: f64, y: f64| match far {
            None => (DVec3::ZERO, forward + across(x, y)),
            Some(_) => (across(x, y), forward),
        };
        let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
        let lines: [(DVec3, DVec3); 4] = std::array::from_fn(|i| line_at(sign(i & 1), sign(i & 2)));
        // The central line is the mean of the four, so it lies strictly inside every plane except near and
        // far.
        let middle = line_at(0.0, 0.0);
        let side = |a: usize, b: usize| {
            let (from, along) = lines[a];
            let across = lines[b].0 + lines[b].1 - from;
            let normal = along.cross(across).try_normalize()?;
            let towards = normal.dot(middle.0 + middle.1 - from);
            let normal = normal * towards.signum();
            (towards != 0.0).then(|| HalfSpace {
                normal,
                offset: -normal.dot(from),
            })
        };
        let front = right.cross(up).try_normalize()?;
        let depth = front.dot(forward);
        if !(depth.is_finite() && depth != 0.0) {
            return None;
        }
        let mut half_spaces: SmallVec<[HalfSpace; 6]> = SmallVec::from_slice(&[
            HalfSpace {
                normal: front * depth.signum(),
                offset: -depth.abs() * near,
            },
            side(0, 2)?,
            side(1, 3)?,
            side(0, 1)?,
            side(2, 3)?,
        ]);
        half_spaces.extend(far.map(|far| HalfSpace {
            normal: -front * depth.signum(),
            offset: depth.abs() * far,
        }));
        let mut corners_eye = [DVec4::ZERO; 8];
        for (i, &(from, along)) in lines.iter().enumerate() {
            corners_eye[i] = (from + along * near).extend(1.0);
            corners_eye[i + 4] = match far {
                None => along.try_normalize()?.extend(0.0),
                Some(far) => (from + along * far).extend(1.0),
            };
        }
        let usable = half_spaces
            .iter()
            .all(|h| h.normal.is_finite() && h.offset.is_finite())
            && corners_eye.iter().all(|corner| corner.is_finite());
        usable.then(|| Self {
            planes: PlaneSet {
                planes: half_spaces.iter().map(|h| h.to_world(eye)).collect(),
            },
            corners: corners_eye.map(|corner| (corner + eye.extend(0.0) * corner.w).as_vec4()),
            shape: *shape,
            far,
            half_spaces,
            corners_eye,
        })
    }

    /// The parameters that the frustum was made from.
    pub fn shape(&self) -> &FrustumShape {
        &self.shape
    }

    /// Depth of the far plane of an orthographic view, in lengths of `forward`; `None` in perspective.
    pub fn far(&self) -> Option<f64> {
        self.far
    }

    /// All planes except the far one. Anything outside one of these is neither visible in a pixel nor farther
    /// along the line of sight of any pixel.
    pub fn open_planes(&self) -> &[Plane] {
        &self.planes.planes[..Self::FAR]
    }

    /// Apex of a perspective view, or the point from which an orthographic view measures depth, metres, world
    /// space.
    pub fn eye(&self) -> DVec3 {
        self.shape.eye
    }

    /// Whether the view shows the world mirrored.
    pub fn is_mirrored(&self) -> bool {
        // A camera looks along −Z, so right × up points backwards in an ordinary view.
        self.shape.right.cross(self.shape.up).dot(self.shape.forward) > 0.0
    }

    /// Corners of the near rectangle in world space, numbered like the corners of the frustum.
    pub fn near_corners(&self) -> [DVec3; 4] {
        std::array::from_fn(|i| self.corners_eye[i].truncate() + self.shape.eye)
    }

    /// Whether a point (`w = 1`) or direction (`w = 0`) of world space lies inside the frustum or on its
    /// border.
    pub fn contains(&self, point: DVec4) -> bool {
        let point_eye = point - self.shape.eye.extend(0.0) * point.w;
        self.half_spaces.iter().all(|half| half.side(point_eye) >= 0.0)
    }

    /// The planes relative to the eye, without the rounding of [`Frustum::planes`].
    pub(super) fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces
    }

    /// The corners, relative to the eye.
    pub(super) fn corners_eye(&self) -> &[DVec4; 8] {
        &self.corners_eye
    }
}
