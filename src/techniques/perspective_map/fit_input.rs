//! The casters and the visible points to which the faces of a light are fitted.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use super::component::{MapFocus, PerspectiveMap, PerspectiveProjection};
use super::receivers::{corners, push_cut};
use super::shadowed::push_half_spaces;
use super::view_space::ViewSpace;
use crate::geometry::Aabb;
use crate::sets::{FrameLight, Objects, ViewData};

/// Largest share of a caster's size that it is thick, for it to count as a ground. Grounds have large triangles close to the eye.
const GROUND_THICKNESS: f64 = 1e-3;

/// Largest ratio of w between the corners of a ground and what is near the eye. A rasterizer rounds w by a share of the
/// greatest of a triangle, and with it the depth near the eye. Beyond 25,000, a ground of two triangles shadowed itself.
const MOST_CORNER_RATIO: f64 = 8192.0;

/// The input from which a light's faces are fitted.
#[derive(Clone, Copy, Debug)]
pub struct FitInput<'a> {
    /// The view.
    pub view: &'a ViewData,
    /// The light.
    pub light: &'a FrameLight,
    /// All objects.
    pub objects: &'a Objects,
    /// The light's settings.
    pub settings: &'a PerspectiveMap,
    /// Boxes that hold every visible point of the light's receivers, world space.
    pub boxes: &'a [Aabb],
    /// Distance to which the blur of grounds reaches beyond what is seen, metres.
    pub blur_metres: f64,
    /// Whether a cube's faces replaced one picture when the light was fitted last.
    pub replaced_one: bool,
}

impl FitInput<'_> {
    /// The casters that the map shows: set S, or all that the light reaches if the map is kept.
    pub(super) fn casters(&self) -> impl Iterator<Item = usize> + '_ {
        let kept = self
            .settings
            .cached
            .then(|| self.light.reached_casters(self.objects));
        let of_frame = (!self.settings.cached).then(|| self.light.sets.s.ones());
        kept.into_iter().flatten().chain(of_frame.into_iter().flatten())
    }

    /// Calls `each` with the middle and the half sides of the bounds of every caster.
    pub(super) fn for_each_caster(&self, mut each: impl FnMut(DVec3, DVec3)) {
        for index in self.casters() {
            let (center, half) = self.objects.boxes.center_half(index);
            each(center, half);
        }
    }

    /// Half-spaces, in view coordinates, of what the view shows and the light lights.
    pub(super) fn half_spaces(&self, space: &ViewSpace) -> SmallVec<[DVec4; 20]> {
        let mut half_spaces: SmallVec<[DVec4; 20]> = space.half_spaces.iter().copied().collect();
        let apex = self.light.point_world.truncate();
        if let Some((axis, half_angle)) = self.light.shadow_cone() {
            let angle = half_angle + 1e-5;
            if half_angle <= std::f64::consts::FRAC_PI_2 {
                half_spaces.push(space.half_space(axis, apex));
            }
            if angle < std::f64::consts::FRAC_PI_2 {
                let (x, y) = axis.any_orthonormal_pair();
                let (sin, cos) = angle.sin_cos();
                half_spaces
                    .extend([x, -x, y, -y].map(|side| space.half_space(axis * sin - side * cos, apex)));
            }
        }
        let reach = self.blur_metres.max(self.softness());
        push_half_spaces(
            self.light,
            self.objects,
            self.view,
            space,
            self.casters(),
            reach,
            &mut half_spaces,
        );
        half_spaces
    }

    /// Radius of the filter: metres, or a share of the distance from a light at a position.
    fn softness(&self) -> f64 {
        f64::from(self.settings.filter.softness().unwrap_or(0.0))
    }

    /// Collects the points that the map must show, in view coordinates. Returns their least and greatest
    /// depth.
    pub(super) fn collect_points(
        &self,
        space: &ViewSpace,
        half_spaces: &[DVec4],
        points: &mut Vec<DVec3>,
    ) -> Option<(f64, f64)> {
        points.clear();
        for aabb in self.boxes {
            let corners = corners(aabb).map(|corner| space.point(corner));
            push_cut(&corners, half_spaces, points);
        }
        let range = |points: &[DVec3]| {
            points
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(near, far), point| {
                    (near.min(point.z), far.max(point.z))
                })
        };
        let (_, far) = range(points);
        if self.settings.focus == MapFocus::All && far > space.near {
            points.clear();
            let side = |depth: f64| if space.is_perspective { depth } else { 1.0 };
            let frustum: [DVec3; 8] = std::array::from_fn(|i| {
                let sign = |bit: usize| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
                let depth = if i >> 2 & 1 == 0 { space.near } else { far };
                DVec3::new(sign(0) * side(depth), sign(1) * side(depth), depth)
            });
            push_cut(&frustum, &half_spaces[space.half_spaces.len()..], points);
        }
        let (near, far) = range(points);
        if points.is_empty() {
            return None;
        }
        let softness = self.softness();
        if softness > 0.0 || self.blur_metres > 0.0 {
            self.widen(space, softness, points);
        }
        let near = if space.is_perspective {
            near.max(space.near)
        } else {
            near
        };
        Some((near, far.max(near + 1e-3 * near.abs().max(1e-3))))
    }

    /// Adds the places that the taps of a soft filter and of a blur reach.
    fn widen(&self, space: &ViewSpace, softness: f64, points: &mut Vec<DVec3>) {
        let light = self.light.point_world;
        for index in 0..points.len() {
            let world = space.eye_world + space.to_axes * (points[index] - space.eye);
            let ray = world * light.w - light.truncate();
            let radius = softness * if light.w == 0.0 { 1.0 } else { ray.length() };
            let radius = radius.max(self.blur_metres);
            let (x, y) = ray.normalize_or(DVec3::Z).any_orthonormal_pair();
            // A square with these corners holds the disc.
            for side in [x, -x, y, -y] {
                let mut beside = points[index] + space.from_axes * side * (radius * std::f64::consts::SQRT_2);
                beside.z = beside.z.max(space.near);
                points.push(beside);
            }
        }
    }

    /// The greatest growth of w with which the corners of grounds round little.
    pub(super) fn growth_of_grounds(&self, space: &ViewSpace) -> f64 {
        let depth_row = space.from_axes.transpose().z_axis;
        let mut farthest: f64 = 0.0;
        self.for_each_caster(|center, half| {
            if half.min_element() <= GROUND_THICKNESS * half.max_element() {
                farthest = farthest.max(space.point(center).z.abs() + depth_row.abs().dot(half));
            }
        });
        MOST_CORNER_RATIO / farthest
    }

    /// The greatest growth of w that the projection allows.
    pub(super) fn most_growth(&self, space: &ViewSpace, near: f64) -> f64 {
        if !space.is_perspective {
            return 0.0;
        }
        let most = near.recip();
        if self.settings.projection == PerspectiveProjection::Inverse {
            return most;
        }
        // The virtual eye stands behind all casters.
        let depth_row = space.from_axes.transpose().z_axis;
        let mut nearest = near;
        self.for_each_caster(|center, half| {
            nearest = nearest.min(space.point(center).z - depth_row.abs().dot(half));
        });
        if nearest >= 0.0 {
            return most;
        }
        (near - nearest * 1.01).recip()
    }
}
