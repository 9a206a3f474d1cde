//! The triangles of a world, and the ray queries on them.

use bevy_ecs::entity::Entity;
use glam::DVec3;

use super::bvh::Bvh;
use super::contact::touches;
use super::ray::{Ray, RayHit, ShearedRay};
use crate::conventions::LIGHT_CLEARANCE;
use crate::scene::SelectionLayers;

/// Largest coordinate of a triangle, metres. Triangles beyond it are dropped; below it the areas in the tree,
/// which are `f32`, stay finite.
pub const MAX_COORDINATE: f64 = 1e15;

/// Share of the way to a positional light at which a shadow ray ends. So surfaces nearer to the light than
/// [`LIGHT_CLEARANCE`] times the receiver's distance do not block it, as under every technique.
pub const LIGHT_END: f64 = 1.0 - LIGHT_CLEARANCE as f64;

/// A triangle in world space, and its roles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneTriangle {
    /// Corners, metres. They are counter-clockwise as seen from the front, also if the object's transform
    /// mirrors.
    pub corners: [DVec3; 3],
    /// Entity that the triangle belongs to; `None` for bare triangles.
    pub entity: Option<Entity>,
    /// Index among the triangles of its mesh, or in the sequence of bare triangles.
    pub source_index: u32,
    /// Value of the entity's [`SelectionLayers`].
    pub layers: u32,
    /// Whether the camera sees the triangle.
    pub is_primary: bool,
    /// Whether the triangle blocks light.
    pub blocks: bool,
    /// Whether the triangle shows shadows. If not, it sees every light whole.
    pub receives: bool,
    /// Whether the camera also sees the triangle's back.
    pub is_double_sided: bool,
}

/// Triangles prepared for ray queries.
#[derive(Clone, Debug, Default)]
pub struct RayScene {
    triangles: Vec<SceneTriangle>,
    bvh: Bvh,
    dropped_count: usize,
}

impl RayScene {
    /// A scene of bare triangles. They are visible from both sides, receive, block, and are on the default
    /// layer.
    ///
    /// Triangles that are not finite, or beyond [`MAX_COORDINATE`], are dropped and counted.
    pub fn from_triangles(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Self {
        Self::from_scene_triangles((0..).zip(triangles).map(|(source_index, corners)| SceneTriangle {
            corners,
            entity: None,
            source_index,
            layers: SelectionLayers::default().0,
            is_primary: true,
            blocks: true,
            receives: true,
            is_double_sided: true,
        }))
    }

    /// A scene of triangles with given roles. Triangles that are not finite, or beyond [`MAX_COORDINATE`],
    /// are dropped and counted.
    pub fn from_scene_triangles(triangles: impl IntoIterator<Item = SceneTriangle>) -> Self {
        let mut dropped_count = 0;
        let mut triangles: Vec<SceneTriangle> = triangles
            .into_iter()
            .filter(|triangle| {
                let usable = triangle
                    .corners
                    .iter()
                    .all(|p| p.abs().cmple(DVec3::splat(MAX_COORDINATE)).all());
                dropped_count += usize::from(!usable);
                usable
            })
            .collect();
        let corners: Vec<_> = triangles.iter().map(|triangle| triangle.corners).collect();
        let (bvh, order) = Bvh::build(&corners);
        triangles = order.iter().map(|&index| triangles[index as usize]).collect();
        Self {
            triangles,
            bvh,
            dropped_count,
        }
    }

    /// The triangles, in the scene's own order. [`RayHit::triangle`] is an index into them.
    pub fn triangles(&self) -> &[SceneTriangle] {
        &self.triangles
    }

    /// Number of triangles that were dropped because they were not usable.
    pub fn dropped_count(&self) -> usize {
        self.dropped_count
    }

    /// Counts triangles of the world that could not be built at all.
    pub(super) fn add_dropped(&mut self, count: usize) {
        self.dropped_count += count;
    }

    /// The nearest intersection with `t_min ≤ t < t_max` among the triangles for which `accept` returns true.
    pub fn closest_hit(
        &self,
        ray: &Ray,
        t_min: f64,
        mut t_max: f64,
        accept: impl Fn(&SceneTriangle) -> bool,
    ) -> Option<RayHit> {
        let sheared = ShearedRay::new(ray);
        let mut nearest = None;
        self.bvh.walk(ray, t_max, |slots| {
            for slot in slots {
                let triangle = &self.triangles[slot];
                if let Some((t, barycentric)) = sheared.intersect(&triangle.corners)
                    && t >= t_min
                    && t < t_max
                    && accept(triangle)
                {
                    t_max = t;
                    nearest = Some(RayHit {
                        t,
                        triangle: slot as u32,
                        barycentric,
                    });
                }
            }
            t_max
        });
        nearest
    }

    /// Whether a triangle blocks the segment from the surface point to `light_world`.
    ///
    /// `receiver` is the triangle that the point lies on, if any. `casts_for` is the mask of
    /// [`LightSelection`](crate::scene::LightSelection).
    pub fn blocks_segment(
        &self,
        surface: DVec3,
        light_world: DVec3,
        receiver: Option<u32>,
        casts_for: u32,
    ) -> bool {
        let ray = Ray {
            origin: surface,
            direction: light_world - surface,
        };
        self.is_blocked(&ray, LIGHT_END, receiver, casts_for)
    }

    /// Whether a triangle blocks the half-line from the surface point along `towards_light`.
    ///
    /// `receiver` is the triangle that the point lies on, if any. `casts_for` is the mask of
    /// [`LightSelection`](crate::scene::LightSelection).
    pub fn blocks_direction(
        &self,
        surface: DVec3,
        towards_light: DVec3,
        receiver: Option<u32>,
        casts_for: u32,
    ) -> bool {
        let ray = Ray {
            origin: surface,
            direction: towards_light,
        };
        self.is_blocked(&ray, f64::INFINITY, receiver, casts_for)
    }

    /// A triangle that blocks the segment from the surface point to `light_world`, as in
    /// [`RayScene::blocks_segment`]. `guess` is looked at first: it saves the search if it blocks again, as the blocker
    /// of a neighbouring segment often does.
    pub fn segment_blocker(
        &self,
        surface: DVec3,
        light_world: DVec3,
        receiver: Option<u32>,
        casts_for: u32,
        guess: Option<u32>,
    ) -> Option<u32> {
        let ray = Ray {
            origin: surface,
            direction: light_world - surface,
        };
        self.blocker(&ray, LIGHT_END, receiver, casts_for, guess)
    }

    /// A triangle that blocks the half-line from the surface point along `towards_light`, as in
    /// [`RayScene::blocks_direction`]. `guess` is looked at first.
    pub fn direction_blocker(
        &self,
        surface: DVec3,
        towards_light: DVec3,
        receiver: Option<u32>,
        casts_for: u32,
        guess: Option<u32>,
    ) -> Option<u32> {
        let ray = Ray {
            origin: surface,
            direction: towards_light,
        };
        self.blocker(&ray, f64::INFINITY, receiver, casts_for, guess)
    }

    /// Whether a blocking triangle crosses the ray at `0 < t < t_max` without touching its origin.
    fn is_blocked(&self, ray: &Ray, t_max: f64, receiver: Option<u32>, casts_for: u32) -> bool {
        self.blocker(ray, t_max, receiver, casts_for, None).is_some()
    }

    fn blocker(
        &self,
        ray: &Ray,
        t_max: f64,
        receiver: Option<u32>,
        casts_for: u32,
        guess: Option<u32>,
    ) -> Option<u32> {
        let sheared = ShearedRay::new(ray);
        let blocks = |slot: usize| {
            let triangle = &self.triangles[slot];
            triangle.blocks
                && triangle.layers & casts_for != 0
                && receiver != Some(slot as u32)
                && sheared
                    .intersect(&triangle.corners)
                    .is_some_and(|(t, _)| t > 0.0 && t < t_max)
                && !touches(&triangle.corners, ray.origin)
        };
        if let Some(guess) = guess
            && (guess as usize) < self.triangles.len()
            && blocks(guess as usize)
        {
            return Some(guess);
        }
        let mut blocker = None;
        self.bvh.walk(ray, t_max, |slots| {
            blocker = slots.into_iter().find(|&slot| blocks(slot));
            if blocker.is_some() {
                f64::NEG_INFINITY
            } else {
                t_max
            }
        });
        blocker.map(|slot| slot as u32)
    }
}
