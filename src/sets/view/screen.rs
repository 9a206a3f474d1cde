//! Bounds on the screen and in view depth, of boxes and of convex hulls of homogeneous points.

use glam::{DVec2, DVec3, DVec4};

use super::frame_view::ViewData;

/// A rectangle in pixels and a range of view depth. Row 0 is at the top, and the rectangle is neither rounded
/// nor clipped to the picture. Empty when a minimum exceeds its maximum.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScreenBounds {
    /// Left and top border, pixels.
    pub min: DVec2,
    /// Right and bottom border, pixels.
    pub max: DVec2,
    /// Smallest view depth, at least that of the near plane.
    pub near: f64,
    /// Largest view depth. It may be infinite.
    pub far: f64,
}

impl ScreenBounds {
    /// Bounds that hold nothing.
    pub const EMPTY: Self = Self {
        min: DVec2::INFINITY,
        max: DVec2::NEG_INFINITY,
        near: f64::INFINITY,
        far: f64::NEG_INFINITY,
    };

    /// Bounds that hold everything.
    pub const ALL: Self = Self {
        min: DVec2::NEG_INFINITY,
        max: DVec2::INFINITY,
        // An orthographic view may reach behind its camera, where view depth is negative.
        near: f64::NEG_INFINITY,
        far: f64::INFINITY,
    };

    /// Whether nothing lies inside the bounds.
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all() && self.near <= self.far)
    }

    /// The smallest bounds around both.
    pub fn union(self, other: Self) -> Self {
        Self {
            min: self.min.min(other.min),
            max: self.max.max(other.max),
            near: self.near.min(other.near),
            far: self.far.max(other.far),
        }
    }

    /// The bounds of what lies in both.
    pub fn intersection(self, other: Self) -> Self {
        Self {
            min: self.min.max(other.min),
            max: self.max.min(other.max),
            near: self.near.max(other.near),
            far: self.far.min(other.far),
        }
    }

    fn include(&mut self, point: Clip, size: DVec2) {
        // `mul_add` is avoided, because without the target feature it is a function call.
        let half = 0.5 / point.w;
        let pixel = DVec2::new(0.5 + point.x * half, 0.5 - point.y * half) * size;
        let depth = if point.weight > 0.0 {
            point.depth / point.weight
        } else {
            f64::INFINITY
        };
        self.min = self.min.min(pixel);
        self.max = self.max.max(pixel);
        self.near = self.near.min(depth);
        self.far = self.far.max(depth);
    }
}

/// A point in clip space. `weight` is 1 for positions and 0 for directions. `depth` is the view depth times
/// `weight`. `w` is the depth in perspective and the weight in an orthographic view.
#[derive(Clone, Copy, Debug)]
struct Clip {
    x: f64,
    y: f64,
    w: f64,
    depth: f64,
    weight: f64,
}

/// Projects from world space to pixels. It computes in `f64`, relative to the eye.
#[derive(Clone, Copy, Debug)]
pub struct Projector {
    /// Rows of three maps applied to vectors: x and y of clip from world, and the view depth.
    rows: [DVec3; 3],
    /// Offsets that rows x and y add for positions.
    shift: DVec2,
    orthographic: bool,
    eye: DVec3,
    near: f64,
    size: DVec2,
}

/// Edges of a box with the corner order of [`Aabb::corners`](crate::geometry::Aabb::corners).
const BOX_EDGES: [(usize, usize); 12] = [
    (0, 1),
    (2, 3),
    (4, 5),
    (6, 7),
    (0, 2),
    (1, 3),
    (4, 6),
    (5, 7),
    (0, 4),
    (1, 5),
    (2, 6),
    (3, 7),
];

impl Projector {
    /// The projection of a view.
    pub fn new(view: &ViewData) -> Self {
        let row = |i: usize| view.clip_from_world.row(i).truncate();
        let orthographic = view.is_orthographic();
        let shift = view.clip_from_view.w_axis.truncate().truncate();
        Self {
            rows: [row(0), row(1), -view.view_from_world.row(2).truncate()],
            shift: if orthographic { shift } else { DVec2::ZERO },
            orthographic,
            eye: view.eye,
            near: view.near,
            size: view.viewport.as_dvec2(),
        }
    }

    /// Gradient of the view depth in world space. It has the view direction; in a scaled view it does not
    /// have unit length.
    pub fn depth_gradient(&self) -> DVec3 {
        self.rows[2]
    }

    /// View depth of a position in world space.
    pub fn depth(&self, point: DVec3) -> f64 {
        self.rows[2].dot(point - self.eye)
    }

    /// Rows x, y and w of clip from world. They apply to vectors from the eye, extended by their fourth
    /// coordinate.
    pub(in crate::sets) fn rows(&self) -> [DVec4; 3] {
        let [x, y, depth] = self.rows;
        let w = if self.orthographic {
            DVec4::W
        } else {
            depth.extend(0.0)
        };
        [x.extend(self.shift.x), y.extend(self.shift.y), w]
    }

    /// Position of the eye, world space.
    pub(in crate::sets) fn eye(&self) -> DVec3 {
        self.eye
    }

    /// Size of the picture, pixels.
    pub(in crate::sets) fn size(&self) -> DVec2 {
        self.size
    }

    /// View depth of the near plane.
    pub fn near(&self) -> f64 {
        self.near
    }

    fn clip(&self, point: DVec4) -> Clip {
        let point_eye = point.truncate() - self.eye * point.w;
        let [x, y, depth] = self.rows.map(|row| row.dot(point_eye));
        self.with_w(
            x + self.shift.x * point.w,
            y + self.shift.y * point.w,
            depth,
            point.w,
        )
    }

    fn with_w(&self, x: f64, y: f64, depth: f64, weight: f64) -> Clip {
        let w = if self.orthographic { weight } else { depth };
        Clip {
            x,
            y,
            w,
            depth,
            weight,
        }
    }

    /// Bounds of the part of a box that lies behind the near plane.
    pub fn bounds_of_box(&self, center: DVec3, half: DVec3) -> ScreenBounds {
        let mut middle = self.rows.map(|row| row.dot(center - self.eye));
        middle[0] += self.shift.x;
        middle[1] += self.shift.y;
        let axes = self.rows.map(|row| row * half);
        let corners: [Clip; 8] = std::array::from_fn(|i| {
            let signs = DVec3::select(
                glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0),
                DVec3::ONE,
                DVec3::NEG_ONE,
            );
            self.with_w(
                middle[0] + axes[0].dot(signs),
                middle[1] + axes[1].dot(signs),
                middle[2] + axes[2].dot(signs),
                1.0,
            )
        });
        self.bounds(&corners, BOX_EDGES)
    }

    /// Bounds of the part of the convex hull of homogeneous points that lies behind the near plane. All pairs
    /// of points serve as edges. Their intersections with the near plane lie in the hull, so the bounds stay
    /// exact.
    pub fn bounds_of_hull<const N: usize>(&self, points: [DVec4; N]) -> ScreenBounds {
        let clip = points.map(|point| self.clip(point));
        self.bounds(&clip, (0..N).flat_map(|b| (0..b).map(move |a| (a, b))))
    }

    /// Bounds of a ball. They are exact if the ball lies wholly in front of the camera (from the tangent
    /// planes through the eye) or the view is orthographic; otherwise they are those of the ball's box. The
    /// depth range is exact in all cases.
    ///
    /// Source: Lengyel 2002, "The Mechanics of Robust Stencil Shadows": scissor rectangle of a sphere from
    /// the two tangents in each of the planes x–z and y–z.
    pub fn bounds_of_ball(&self, center: DVec3, radius: f64) -> ScreenBounds {
        let mut bounds = self.bounds_of_box(center, DVec3::splat(radius));
        let [x, y, w] = self.rows;
        let scale = w.length();
        let reach = radius * scale;
        let depth = self.depth(center);
        bounds.near = bounds.near.max(depth - reach);
        bounds.far = bounds.far.min(depth + reach);
        if self.orthographic {
            let at = DVec2::new(x.dot(center - self.eye), y.dot(center - self.eye)) + self.shift;
            let half = DVec2::new(x.length(), y.length()) * radius;
            let (low, high) = ((at - half) * 0.5, (at + half) * 0.5);
            let exact = ScreenBounds {
                min: DVec2::new(0.5 + low.x, 0.5 - high.y) * self.size,
                max: DVec2::new(0.5 + high.x, 0.5 - low.y) * self.size,
                ..ScreenBounds::ALL
            };
            return bounds.intersection(exact);
        }
        if depth <= reach * (1.0 + 1e-6) {
            return bounds;
        }
        let tangents = |row: DVec3| {
            // Removes the row's component along the depth, which shifts the whole picture equally.
            let shift = row.dot(w) / (scale * scale);
            let row = row - w * shift;
            // Computes in the plane of the row and the depth, both scaled to the depth.
            let stretch = row.length() / scale;
            let across = row.dot(center - self.eye) / stretch;
            let root = reach * (across * across + depth * depth - reach * reach).max(0.0).sqrt();
            let below = depth * depth - reach * reach;
            let (a, b) = ((across * depth - root) / below, (across * depth + root) / below);
            (a * stretch + shift, b * stretch + shift)
        };
        let ((left, right), (bottom, top)) = (tangents(x), tangents(y));
        let exact = ScreenBounds {
            min: DVec2::new(left * 0.5 + 0.5, 0.5 - top * 0.5) * self.size,
            max: DVec2::new(right * 0.5 + 0.5, 0.5 - bottom * 0.5) * self.size,
            ..ScreenBounds::ALL
        };
        bounds.intersection(exact)
    }

    fn everything(&self) -> ScreenBounds {
        ScreenBounds {
            near: self.near,
            ..ScreenBounds::ALL
        }
    }

    fn bounds(&self, points: &[Clip], edges: impl IntoIterator<Item = (usize, usize)>) -> ScreenBounds {
        let inside = |point: &Clip| point.depth - self.near * point.weight;
        let mut bounds = ScreenBounds::EMPTY;
        let mut outside = 0;
        for point in points {
            if inside(point) < 0.0 {
                outside += 1;
            } else if point.w > 0.0 {
                bounds.include(*point, self.size);
            } else {
                // A direction on the horizon is infinitely far to the side.
                return self.everything();
            }
        }
        if outside == 0 || outside == points.len() {
            return bounds;
        }
        for (a, b) in edges {
            let (a, b) = (points[a], points[b]);
            let (inside_a, inside_b) = (inside(&a), inside(&b));
            if (inside_a >= 0.0) == (inside_b >= 0.0) {
                continue;
            }
            let t = inside_a / (inside_a - inside_b);
            let mix = |from: f64, to: f64| from + (to - from) * t;
            let crossing = Clip {
                x: mix(a.x, b.x),
                y: mix(a.y, b.y),
                w: mix(a.w, b.w),
                depth: mix(a.depth, b.depth),
                weight: mix(a.weight, b.weight),
            };
            if !(crossing.w > 0.0 && crossing.weight > 0.0) {
                // The two directions lie on either side of the horizon, so their hull passes through the
                // picture's infinity.
                return self.everything();
            }
            bounds.include(crossing, self.size);
        }
        bounds
    }
}
