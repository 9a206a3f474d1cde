//! The length of shadow volumes in orthographic views, where depth ends.
//!
//! A perspective view draws to infinity, and its depth has a value for a vertex with `w = 0`. The depth of an
//! orthographic view is linear and ends. Faces that it clips are not counted at the surfaces in front of
//! them. So volumes end too, beyond all receivers of the light in view, and the view's depth range is
//! extended to contain them ([`DepthReach`]).

use bevy_ecs::prelude::*;
use glam::{DMat4, DVec3, DVec4, Vec4};

use crate::geometry::edge_mesh::EdgeMesh;
use crate::geometry::{Aabb, distance_to_triangle};
use crate::sets::{DepthReach, FrameLight, Projector, ViewData};
use crate::silhouettes::{CasterShapeItem, KEPT_FRAMES};

/// The receivers that the volumes of a light must reach beyond.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FiniteReach {
    light: DVec4,
    receivers: Aabb,
}

/// The factor by which volumes reach beyond all receivers, so that rounding does not matter.
const SLACK: f64 = 1.002;

/// The ratio of the farthest receiver's distance to the distance of the caster's bounds from which the
/// distance of the caster's nearest surface is computed instead. Chosen by eye.
const COSTLY: f64 = 16.0;

/// The largest factor on the distance from the light. A surface so near to a light that it needs a larger one
/// casts a shorter shadow.
const LARGEST: f64 = 1e4;

impl FiniteReach {
    /// Makes the reach of a light, or of the part of a light around `point_world`. Returns `None` in a
    /// perspective view, where volumes may reach infinity.
    pub fn new(view: &ViewData, light: &FrameLight, point_world: DVec4) -> Option<Self> {
        view.frustum.far()?;
        let seen = Aabb::from_points(view.frustum.corners.map(|corner| corner.truncate())).padded();
        Some(Self {
            light: point_world,
            receivers: light.region.receiver_bounds.intersection(seen),
        })
    }

    /// Returns the distance within which all receivers are, metres. It is measured from the light or, for a
    /// directional light, along its light from the world's origin.
    pub fn distance(&self) -> f64 {
        let corners = self.receivers.corners().map(|corner| corner.as_dvec3());
        let light = self.light.truncate();
        let distance = |corner: DVec3| match self.light.w {
            0.0 => -light.dot(corner),
            _ => light.distance(corner),
        };
        corners
            .into_iter()
            .map(distance)
            .fold(f64::NEG_INFINITY, f64::max)
    }

    /// Returns the [extrusion](super::extrude::far_position) of a caster, or `None` if it is beyond all
    /// receivers. The result moves in steps of ∜2, so that it mostly stays the same.
    ///
    /// `nearest_surface` returns the metres from the light to the nearest of the caster's triangles. It is
    /// called only where the light is within the caster's bounds or near them.
    pub fn extrusion(&self, caster: &Aabb, nearest_surface: impl FnOnce() -> Option<f64>) -> Option<f32> {
        if self.receivers.is_empty() || caster.is_empty() {
            return None;
        }
        let light = self.light.truncate();
        let needed = if self.light.w == 0.0 {
            // Distances from the world's origin have a sign, so the slack is a share of the size instead.
            let corners = caster.corners().map(|corner| -light.dot(corner.as_dvec3()));
            let size = f64::from((caster.half_size() + self.receivers.half_size()).length());
            let farthest = self.distance() + size * (SLACK - 1.0);
            let length = farthest - corners.into_iter().fold(f64::INFINITY, f64::min);
            (length > 0.0).then_some(length + size * (SLACK - 1.0))?
        } else {
            let farthest = self.distance() * SLACK;
            let (min, max) = (caster.min.as_dvec3(), caster.max.as_dvec3());
            let mut nearest = light.distance(light.clamp(min, max));
            if nearest > farthest {
                return None;
            }
            if farthest > nearest * COSTLY {
                nearest = nearest_surface().unwrap_or(nearest);
            }
            (farthest / nearest).clamp(1.0, LARGEST)
        };
        let step = (needed.log2() * 4.0).ceil() / 4.0;
        Some(step.exp2() as f32)
    }
}

/// Returns the greatest view depth of these points; −∞ without points.
pub fn farthest_depth(view: &ViewData, points: impl IntoIterator<Item = Vec4>) -> f64 {
    let projector = Projector::new(view);
    let depths = points
        .into_iter()
        .map(|point| projector.depth(point.truncate().as_dvec3()));
    depths.fold(f64::NEG_INFINITY, f64::max)
}

/// Extends the view's depth reach to the hull of these points.
pub fn include_points(reach: &DepthReach, view: &ViewData, points: impl IntoIterator<Item = Vec4>) {
    reach.include(farthest_depth(view, points));
}

/// Extends the view's depth reach to rays of this length from anywhere in a box.
pub fn include_rays(reach: &DepthReach, view: &ViewData, from: &Aabb, length: f32) {
    let projector = Projector::new(view);
    let gradient = projector.depth_gradient();
    let deepest = projector.depth(from.center().as_dvec3()) + gradient.abs().dot(from.half_size().as_dvec3());
    reach.include(deepest + gradient.length() * f64::from(length));
}

/// The distances of lights from the surfaces of casters whose bounds they are in or near. Each distance is
/// kept until light or caster changes.
#[derive(Clone, Debug, Default)]
pub struct NearestSurfaces {
    /// The kept distances, ascending by light, part and caster.
    known: Vec<Known>,
    frame: u64,
}

#[derive(Clone, Debug)]
struct Known {
    /// The light, the number of its part, and the caster.
    key: (Entity, u32, Entity),
    /// The revision of the light's silhouette of the caster.
    revision: u64,
    point: DVec4,
    world_from_local: DMat4,
    distance: f64,
    last_used: u64,
}

impl NearestSurfaces {
    /// Begins another frame.
    pub fn begin_frame(&mut self) {
        self.frame += 1;
        let frame = self.frame;
        self.known.retain(|known| known.last_used + KEPT_FRAMES >= frame);
    }

    /// Returns the metres from a position of a light to the nearest triangle of a caster.
    ///
    /// Cost: linear in the triangles, unless the distance is known. It is kept until light or caster moves or
    /// the `revision` of the light's silhouette of the caster changes.
    pub fn get(
        &mut self,
        key: (Entity, u32, Entity),
        revision: u64,
        point: DVec4,
        caster: &CasterShapeItem,
    ) -> Option<f64> {
        let (edges, world_from_local) = (caster.edges, caster.world_from_local()?);
        let at = self.known.binary_search_by_key(&key, |known| known.key);
        if let Ok(at) = at {
            let known = &mut self.known[at];
            known.last_used = self.frame;
            let now = (revision, point, world_from_local);
            if (known.revision, known.point, known.world_from_local) == now {
                return Some(known.distance);
            }
        }
        let distance = distance_to_mesh(
            point.truncate(),
            &edges.0.edges,
            caster.positions(),
            &world_from_local,
        )?;
        let entry = Known {
            key,
            revision,
            point,
            world_from_local,
            distance,
            last_used: self.frame,
        };
        match at {
            Ok(at) => self.known[at] = entry,
            Err(at) => self.known.insert(at, entry),
        }
        Some(distance)
    }
}

fn distance_to_mesh(
    point: DVec3,
    edges: &EdgeMesh,
    positions: &[glam::Vec3],
    world_from_local: &DMat4,
) -> Option<f64> {
    let place = |vertex: u32| {
        let local = positions.get(vertex as usize)?.as_dvec3();
        Some(world_from_local.transform_point3(local))
    };
    let mut nearest = f64::INFINITY;
    for [a, b, c] in edges.corners() {
        let corners = [place(*a)?, place(*b)?, place(*c)?];
        nearest = nearest.min(distance_to_triangle(point, corners));
    }
    nearest.is_finite().then_some(nearest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb::around(center, Vec3::splat(half))
    }

    #[test]
    fn volumes_end_beyond_all_receivers() {
        let receivers = cube(Vec3::ZERO, 10.0);
        let sun = FiniteReach {
            light: DVec4::new(0.0, 1.0, 0.0, 0.0),
            receivers,
        };
        let length = sun.extrusion(&cube(Vec3::Y * 8.0, 1.0), || None).unwrap();
        assert!(7.0 - length < -10.0 && length < 30.0, "{length}");
        assert_eq!(sun.extrusion(&cube(Vec3::Y * -15.0, 1.0), || None), None);

        let lamp = FiniteReach {
            light: DVec4::new(0.0, 8.0, 0.0, 1.0),
            receivers,
        };
        let factor = lamp.extrusion(&cube(Vec3::Y * 4.0, 1.0), || None).unwrap();
        assert!(
            f64::from(factor) * 3.0 > lamp.distance() && factor < 12.0,
            "{factor}"
        );
        // The light is within the bounds of a caster whose surface is a metre away.
        let around = lamp.extrusion(&cube(Vec3::ZERO, 10.0), || Some(1.0)).unwrap();
        assert!(f64::from(around) > lamp.distance(), "{around}");
    }

    /// Distances along a directional light are negative on the sunward side of the world's origin.
    #[test]
    fn volumes_are_as_long_far_from_the_origin() {
        for away in [0.0, 5_000.0, -5_000.0, 1e5, -1e5] {
            let center = Vec3::new(0.0, away, 0.0);
            let sun = FiniteReach {
                light: DVec4::new(0.0, 1.0, 0.0, 0.0),
                receivers: cube(center, 10.0),
            };
            let length = sun.extrusion(&cube(center + Vec3::Y * 8.0, 1.0), || None);
            let length = length.expect("it is above receivers");
            assert!(length > 17.0 && length < 30.0, "{away}: {length}");
            assert!(
                sun.extrusion(&cube(center - Vec3::Y * 15.0, 1.0), || None)
                    .is_none()
            );
        }
    }
}
