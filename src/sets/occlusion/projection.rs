//! Projections from world space to the texels of a depth buffer.

use glam::{DMat4, DVec3, DVec4, UVec2, Vec3};

use crate::geometry::Aabb;
use crate::sets::ViewData;

/// How much farther than their true extent boundary edges reach, texels. This is more than our coordinates
/// can differ from those of a GPU, which snaps to 1/256 of a pixel.
pub const SLACK: f32 = 1.0 / 16.0;

/// A homogeneous point of a depth buffer's picture. Points with `x / w` and `y / w` in −1..=1 are inside.
/// `key / w` orders points by depth: the greater, the nearer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClipPoint {
    /// Coordinate to the right.
    pub x: f64,
    /// Coordinate upward.
    pub y: f64,
    /// Depth in a perspective view; 1 in a parallel one.
    pub w: f64,
    /// Numerator of the key: 1 in a perspective view, minus the depth in a parallel one.
    pub key: f64,
}

impl ClipPoint {
    /// Linear interpolation between two points.
    pub fn mix(a: Self, b: Self, t: f64) -> Self {
        let mix = |a: f64, b: f64| a + (b - a) * t;
        Self {
            x: mix(a.x, b.x),
            y: mix(a.y, b.y),
            w: mix(a.w, b.w),
            key: mix(a.key, b.key),
        }
    }
}

/// One picture that a viewpoint has of the world: that of a camera, a cube face of a point light, that of a
/// spot light, or the parallel one of a directional light.
///
/// The key of a point is 1 / depth in perspective and minus the depth in a parallel picture. Both are linear
/// in the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// Rows x, y, w and key, applied to vectors relative to the origin. The last component is added for
    /// points.
    rows: [DVec4; 4],
    origin: DVec3,
    /// Smallest `w` that is in the picture.
    near: f64,
    /// Width and height of the picture, texels.
    pub size: UVec2,
    /// Least difference between the keys of two surfaces whose order is certain. Closer surfaces may be drawn
    /// in either order.
    pub key_quantum: f64,
    /// Whether a triangle that appears counter-clockwise in the world appears clockwise in the picture.
    mirrored: bool,
    /// In perspective, the largest ratio of a visible point's distance to its depth. `None` in a parallel
    /// picture.
    slant: Option<f64>,
}

/// The image of a box: a rectangle of texels, not yet clipped to the picture, and its greatest key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxImage {
    /// Left and right border, texels.
    pub x: (f64, f64),
    /// Top and bottom border, texels.
    pub y: (f64, f64),
    /// Key of the box's nearest point.
    pub key: f64,
}

impl BoxImage {
    /// Share of the picture that the rectangle covers.
    pub fn area(&self, projection: &Projection) -> f64 {
        let (width, height) = (f64::from(projection.size.x), f64::from(projection.size.y));
        let share = |(low, high): (f64, f64), size: f64| (high.min(size) - low.max(0.0)).max(0.0) / size;
        share(self.x, width) * share(self.y, height)
    }
}

impl BoxImage {
    /// Whether the whole rectangle is in the picture.
    pub fn is_within(&self, projection: &Projection) -> bool {
        let (width, height) = (f64::from(projection.size.x), f64::from(projection.size.y));
        self.x.0 >= 0.0 && self.x.1 <= width && self.y.0 >= 0.0 && self.y.1 <= height
    }
}

/// A projection from an object's local space.
#[derive(Clone, Copy, Debug)]
pub struct LocalProjection {
    rows: [DVec4; 4],
}

impl LocalProjection {
    /// Projects a point of local space.
    pub fn point(&self, local: Vec3) -> ClipPoint {
        let p = local.as_dvec3().extend(1.0);
        let [x, y, w, key] = self.rows.map(|row| row.dot(p));
        ClipPoint { x, y, w, key }
    }
}

/// Steps of a 24-bit depth buffer by which two surfaces may differ and still be drawn in either order.
const DEPTH_STEPS: f64 = 4.0;

impl Projection {
    /// The camera's picture, with `width` texels in a row.
    pub fn of_view(view: &ViewData, width: u32) -> Self {
        let row = |i: usize| view.clip_from_world.row(i).truncate();
        let (x, y, w) = (row(0), row(1), -view.view_from_world.row(2).truncate());
        let aspect = f64::from(view.viewport.y) / f64::from(view.viewport.x);
        let height = (f64::from(width) * aspect).round().clamp(8.0, 2048.0) as u32;
        if let Some(far) = view.frustum.far() {
            let shift = view.clip_from_view.w_axis.truncate().with_z(0.0);
            let middle = glam::DMat3::from_cols(x, y, w).transpose().inverse() * -shift;
            return Self {
                rows: [x.extend(0.0), y.extend(0.0), DVec4::W, (-w).extend(0.0)],
                origin: view.eye + middle,
                near: 0.5,
                size: UVec2::new(width, height),
                // Depth is linear, in steps of the whole drawn range, which may be somewhat deeper than the
                // far plane.
                key_quantum: 16.0 * DEPTH_STEPS / f64::from(1 << 24) * (far - view.near),
                mirrored: x.cross(y).dot(w) > 0.0,
                slant: None,
            };
        }
        // Depth is near / w, stored in at least 24 bits.
        let quantum = DEPTH_STEPS / f64::from(1 << 24) / view.near;
        let forward = w.normalize();
        let slant = view.frustum.corners[4..]
            .iter()
            .map(|ray| 1.0 / forward.dot(ray.truncate().as_dvec3().normalize()))
            .fold(1.0, f64::max);
        Self {
            rows: [x.extend(0.0), y.extend(0.0), w.extend(0.0), DVec4::W],
            origin: view.eye,
            near: view.near,
            size: UVec2::new(width, height),
            key_quantum: quantum,
            mirrored: x.cross(y).dot(w) > 0.0,
            slant: Some(slant * w.length().recip()),
        }
    }

    /// A square perspective picture. The axes are orthonormal, and the picture extends by `tan` to each side
    /// at distance 1.
    pub fn perspective(
        eye: DVec3,
        [right, up, forward]: [DVec3; 3],
        tan: f64,
        near: f64,
        width: u32,
    ) -> Self {
        Self {
            rows: [
                (right / tan).extend(0.0),
                (up / tan).extend(0.0),
                forward.extend(0.0),
                DVec4::W,
            ],
            origin: eye,
            near,
            size: UVec2::splat(width),
            key_quantum: 0.0,
            mirrored: right.cross(up).dot(forward) > 0.0,
            slant: Some((1.0 + 2.0 * tan * tan).sqrt()),
        }
    }

    /// A parallel picture of a whole box, along `forward`.
    pub fn parallel(bounds: &Aabb, [right, up, forward]: [DVec3; 3], width: u32) -> Self {
        let (center, half) = (bounds.center().as_dvec3(), bounds.half_size().as_dvec3());
        let extent = |axis: DVec3| (axis.abs().dot(half) * (1.0 + 1e-6)).max(1e-6);
        Self {
            rows: [
                (right / extent(right)).extend(0.0),
                (up / extent(up)).extend(0.0),
                DVec4::W,
                (-forward).extend(0.0),
            ],
            origin: center,
            near: 0.5,
            size: UVec2::splat(width),
            key_quantum: 1e-5 * half.length(),
            mirrored: right.cross(up).dot(forward) > 0.0,
            slant: None,
        }
    }

    /// This projection combined with a transform from local space.
    pub fn for_local_space(&self, world_from_local: &DMat4) -> LocalProjection {
        let relative = DMat4::from_translation(-self.origin) * *world_from_local;
        let transposed = relative.transpose();
        LocalProjection {
            rows: self.rows.map(|row| transposed * row),
        }
    }

    pub(super) fn rows(&self) -> [DVec4; 4] {
        self.rows
    }

    /// The point from which directions and depths are measured, world space.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Whether the lines of sight are parallel: a directional light or an orthographic view.
    pub fn is_parallel(&self) -> bool {
        self.slant.is_none()
    }

    /// Smallest `w` that is in the picture.
    pub fn near(&self) -> f64 {
        self.near
    }

    /// The sign that makes the determinant of three clip points (x, y, w) positive for a triangle that
    /// appears counter-clockwise in the world, so that its front is visible.
    pub fn front_sign(&self) -> f64 {
        if self.mirrored { -1.0 } else { 1.0 }
    }

    fn point(&self, world: DVec3) -> ClipPoint {
        let p = (world - self.origin).extend(1.0);
        let [x, y, w, key] = self.rows.map(|row| row.dot(p));
        ClipPoint { x, y, w, key }
    }

    /// Place of a point with `w > 0`, texels. Row 0 is at the top.
    pub fn texel(&self, point: &ClipPoint) -> (f64, f64) {
        let (width, height) = (f64::from(self.size.x), f64::from(self.size.y));
        let half = 0.5 / point.w;
        ((0.5 + point.x * half) * width, (0.5 - point.y * half) * height)
    }

    /// The image of a box. `None` if the whole box lies in front of the near plane or beside the picture.
    pub fn image_of_box(&self, center: DVec3, half: DVec3) -> Option<BoxImage> {
        let corners: [ClipPoint; 8] = std::array::from_fn(|i| {
            let signs = DVec3::select(
                glam::BVec3::new(i & 1 != 0, i & 2 != 0, i & 4 != 0),
                DVec3::ONE,
                DVec3::NEG_ONE,
            );
            self.point(center + half * signs)
        });
        let mut image = BoxImage {
            x: (f64::INFINITY, f64::NEG_INFINITY),
            y: (f64::INFINITY, f64::NEG_INFINITY),
            key: f64::NEG_INFINITY,
        };
        let mut include = |point: &ClipPoint| {
            let (x, y) = self.texel(point);
            image.x = (image.x.0.min(x), image.x.1.max(x));
            image.y = (image.y.0.min(y), image.y.1.max(y));
            image.key = image.key.max(point.key / point.w);
        };
        let mut before = 0;
        for corner in &corners {
            if corner.w >= self.near {
                include(corner);
            } else {
                before += 1;
            }
        }
        if before == 8 {
            return None;
        }
        if before > 0 {
            for a in 0..8usize {
                for axis in 0..3 {
                    let b = a | 1 << axis;
                    if a == b {
                        continue;
                    }
                    let (from, to) = (corners[a], corners[b]);
                    if (from.w >= self.near) != (to.w >= self.near) {
                        let t = (self.near - from.w) / (to.w - from.w);
                        let mut point = ClipPoint::mix(from, to, t.clamp(0.0, 1.0));
                        point.w = self.near;
                        include(&point);
                    }
                }
            }
        }
        let slack = f64::from(SLACK);
        let inside = image.x.1 >= -slack
            && image.x.0 <= f64::from(self.size.x) + slack
            && image.y.1 >= -slack
            && image.y.0 <= f64::from(self.size.y) + slack;
        if !inside {
            return None;
        }
        if let Some(slant) = self.slant {
            // No visible point is nearer in depth than the nearest point of the box would be if it were seen
            // along the most slanted ray.
            let nearest = ((self.origin - center).abs() - half).max(DVec3::ZERO).length();
            if nearest > 0.0 {
                image.key = image.key.min(slant * (1.0 + 1e-9) / nearest);
            }
        }
        Some(image)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::NEG_Z];

    #[test]
    fn a_box_falls_where_its_corners_do() {
        let projection = Projection::perspective(DVec3::ZERO, AXES, 1.0, 0.1, 100);
        let image = projection
            .image_of_box(DVec3::new(0.0, 0.0, -2.0), DVec3::splat(0.5))
            .unwrap();
        assert!((image.x.0 - 50.0 * (1.0 - 0.5 / 1.5)).abs() < 1e-9);
        assert!((image.key - 1.0 / 1.5).abs() < 1e-9);
        assert_eq!(projection.image_of_box(DVec3::Z * 2.0, DVec3::ONE), None);
        assert_eq!(
            projection.image_of_box(DVec3::new(9.0, 0.0, -2.0), DVec3::ONE),
            None
        );
    }

    #[test]
    fn a_box_beside_the_near_plane_is_as_near_as_its_distance_allows() {
        let projection = Projection::perspective(DVec3::ZERO, AXES, 1.0, 1e-3, 100);
        let image = projection
            .image_of_box(DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 1.0, 4.0))
            .unwrap();
        assert!(image.key <= 3f64.sqrt() * 1.001, "{image:?}");
    }

    #[test]
    fn fronts_have_the_sign_that_is_told() {
        for axes in [AXES, [DVec3::NEG_X, DVec3::Y, DVec3::NEG_Z]] {
            let projection = Projection::perspective(DVec3::ZERO, axes, 1.0, 0.1, 100);
            let corners = [
                Vec3::new(0.0, 0.0, -1.0),
                Vec3::new(1.0, 0.0, -1.0),
                Vec3::new(0.0, 1.0, -1.0),
            ];
            let local = projection.for_local_space(&DMat4::IDENTITY);
            let [a, b, c] = corners.map(|corner| {
                let point = local.point(corner);
                DVec3::new(point.x, point.y, point.w)
            });
            assert!(a.cross(b).dot(c) * projection.front_sign() > 0.0);
        }
    }
}
