//! Whether the viewport may lie in a caster's shadow.
//!
//! The occlusion pyramid spans the near rectangle of the view and the light. A caster outside of it shadows
//! no point of the viewport, so its volume may be counted towards the viewer.
//! Source: McGuire 2004, GPU Gems ch. 9, section 9.5.4 and figure 9-9.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use crate::geometry::Aabb;

/// The convex hull of the view's near rectangle and a light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OcclusionPyramid {
    /// Inward planes, as (unit normal, offset). If empty, everything counts as inside.
    planes: SmallVec<[DVec4; 6]>,
}

impl OcclusionPyramid {
    /// Makes the pyramid from the corners of the near rectangle, in order around it, and the light as a
    /// homogeneous point.
    ///
    /// A light in or near the plane of the rectangle makes a flat pyramid, which excludes nothing.
    pub fn new(near_corners_world: &[DVec3; 4], light_world: DVec4) -> Self {
        /// A light nearer to the rectangle's plane than this share of the rectangle's size counts as in it:
        /// rounding would determine the planes through it.
        const FLAT: f64 = 1e-6;
        let corners = near_corners_world;
        let center = corners.iter().sum::<DVec3>() * 0.25;
        let size = (corners[2] - corners[0]).length();
        let normal = (corners[2] - corners[0])
            .cross(corners[3] - corners[1])
            .normalize_or_zero();
        let to_light = light_world.truncate() - center * light_world.w;
        let height = normal.dot(to_light);
        let scale = if light_world.w == 0.0 {
            to_light.length()
        } else {
            size
        };
        if !(height.abs() > FLAT * scale) {
            return Self::default();
        }
        // A point surely inside decides which side of each plane is in.
        let inside = if light_world.w == 0.0 {
            center + to_light.normalize() * size
        } else {
            center + to_light * 0.5
        };
        let mut planes = SmallVec::new();
        let mut add = |point: DVec3, normal: DVec3| {
            let normal = normal.normalize_or_zero();
            let normal = normal * normal.dot(inside - point).signum();
            planes.push(normal.extend(-normal.dot(point)));
        };
        for i in 0..4 {
            let (a, b) = (corners[i], corners[(i + 1) % 4]);
            add(a, (b - a).cross(light_world.truncate() - a * light_world.w));
        }
        add(center, normal);
        if light_world.w != 0.0 {
            // Beyond the light no caster can shadow the viewport.
            add(light_world.truncate(), to_light);
        }
        Self { planes }
    }

    /// Whether nothing in the box can shadow the viewport. Conservative: `false` in case of doubt.
    pub fn excludes(&self, bounds_world: &Aabb) -> bool {
        let center = bounds_world.center().as_dvec3();
        let half = bounds_world.half_size().as_dvec3();
        // Bounds are `f32`. Neither their rounding nor that of the vertices that the GPU transforms may
        // decide.
        let slack = 1e-5 * (center.abs().max_element() + half.max_element());
        self.planes.iter().any(|plane| {
            let normal = plane.truncate();
            normal.dot(center) + plane.w + normal.abs().dot(half) < -slack
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    const NEAR: [DVec3; 4] = [
        DVec3::new(-0.1, -0.1, -0.1),
        DVec3::new(0.1, -0.1, -0.1),
        DVec3::new(0.1, 0.1, -0.1),
        DVec3::new(-0.1, 0.1, -0.1),
    ];

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb::around(center, Vec3::splat(half))
    }

    #[test]
    fn a_caster_between_light_and_viewport_is_inside() {
        let light = DVec4::new(0.0, 10.0, 10.0, 1.0);
        let pyramid = OcclusionPyramid::new(&NEAR, light);
        assert!(!pyramid.excludes(&cube(Vec3::new(0.0, 5.0, 5.0), 0.5)));
        assert!(!pyramid.excludes(&cube(Vec3::new(0.0, 0.0, -0.1), 0.01)));
        assert!(
            pyramid.excludes(&cube(Vec3::new(0.0, 0.0, -5.0), 0.5)),
            "behind the viewport"
        );
        assert!(
            pyramid.excludes(&cube(Vec3::new(0.0, 12.0, 12.0), 0.5)),
            "beyond the light"
        );
        assert!(pyramid.excludes(&cube(Vec3::new(5.0, 5.0, 5.0), 0.5)), "beside");
    }

    #[test]
    fn a_light_in_front_of_the_viewport_spans_the_other_pyramid() {
        let pyramid = OcclusionPyramid::new(&NEAR, DVec4::new(0.0, 0.0, -10.0, 1.0));
        assert!(!pyramid.excludes(&cube(Vec3::new(0.0, 0.0, -5.0), 0.5)));
        assert!(pyramid.excludes(&cube(Vec3::new(0.0, 0.0, 5.0), 0.5)));
    }

    #[test]
    fn directional_lights_span_a_prism() {
        let pyramid = OcclusionPyramid::new(&NEAR, DVec4::new(0.0, 1.0, 1.0, 0.0).normalize());
        assert!(!pyramid.excludes(&cube(Vec3::new(0.0, 500.0, 500.0), 0.5)));
        assert!(pyramid.excludes(&cube(Vec3::new(0.0, -500.0, -500.0), 0.5)));
        assert!(pyramid.excludes(&cube(Vec3::new(9.0, 500.0, 500.0), 0.5)));
    }

    #[test]
    fn a_light_in_the_plane_of_the_viewport_excludes_nothing() {
        for light in [
            DVec4::new(5.0, 0.0, -0.1, 1.0),
            DVec4::new(1.0, 0.0, 0.0, 0.0),
            DVec4::new(0.0, 0.0, -0.1, 1.0),
        ] {
            let pyramid = OcclusionPyramid::new(&NEAR, light);
            assert!(!pyramid.excludes(&cube(Vec3::new(-50.0, 9.0, 3.0), 0.5)));
        }
    }
}
