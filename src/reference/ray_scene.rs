//! The triangles of a world, and the ray queries on them.

use bevy_ecs::entity::Entity;
use glam::DVec3;
use smallvec::SmallVec;

use super::bvh::Bvh;
use super::contact::touches;
use super::ray::{Ray, RayHit, ShearedRay};
use super::suspects::{FEW, Suspects};
use crate::geometry::{Aabb, distance_to_triangle};
use crate::scene::SelectionLayers;
use crate::sets::{LightClearance, Surroundings};

/// Largest coordinate of a triangle, metres. Triangles beyond it are dropped; below it the areas in the tree,
/// which are `f32`, stay finite.
pub const MAX_COORDINATE: f64 = 1e15;

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
    objects: Vec<Bounds>,
    dropped_count: usize,
}

/// The bounds of one object's triangles.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    entity: Option<Entity>,
    bounds: Aabb,
    /// Layers on which it blocks light; 0 if it does not.
    blocks_on: u32,
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
        let objects = bounds_of(&triangles);
        let (bvh, order) = Bvh::build(&corners);
        triangles = order.iter().map(|&index| triangles[index as usize]).collect();
        Self {
            triangles,
            bvh,
            objects,
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

    /// The distance from a light within which triangles do not block it, metres: the default
    /// [`LightClearance`], which holds under every technique. Triangles without an entity are one object. `range` is the
    /// distance up to which the light reaches, metres.
    pub fn clearance(&self, light_world: DVec3, range: f64, casts_for: u32) -> f64 {
        let mut around = Surroundings::new(light_world, range);
        for object in &self.objects {
            if around.add(&object.bounds, object.blocks_on & casts_for != 0) {
                break;
            }
        }
        LightClearance::default().metres(&around)
    }

    /// Whether a triangle blocks the segment from the surface point to `light_world`. Triangles within the
    /// [clearance](RayScene::clearance) of a light without a range do not. The clearance is computed for each call, in
    /// O(objects); [`RayScene::segment_blocker`] takes one that is known.
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
        let clearance = self.clearance(light_world, f64::INFINITY, casts_for);
        let end = End::At(light_world, clearance);
        self.blocker(&ray, end, receiver, casts_for, None).is_some()
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
        self.blocker(&ray, End::Never, receiver, casts_for, None)
            .is_some()
    }

    /// A triangle that blocks the segment from the surface point to `light_world`, as in
    /// [`RayScene::blocks_segment`]. Triangles nearer to the light than `clearance`, metres, do not block. `guess` is
    /// looked at first: it saves the search if it blocks again, as the blocker of a neighbouring segment often does.
    pub fn segment_blocker(
        &self,
        surface: DVec3,
        light_world: DVec3,
        clearance: f64,
        receiver: Option<u32>,
        casts_for: u32,
        guess: Option<u32>,
    ) -> Option<u32> {
        let ray = Ray {
            origin: surface,
            direction: light_world - surface,
        };
        let end = End::At(light_world, clearance);
        self.blocker(&ray, end, receiver, casts_for, guess)
    }

    /// The triangles that may block segments from the surface point to points of a box, its smallest and largest corner. One
    /// search for all segments of a pixel mostly finds few, or none.
    pub(super) fn suspects(
        &self,
        surface: DVec3,
        ends: [DVec3; 2],
        receiver: Option<u32>,
        casts_for: u32,
    ) -> Suspects {
        let mut few = SmallVec::new();
        let mut is_many = false;
        self.bvh.gather(surface, ends, |slots| {
            for slot in slots.filter(|&slot| self.may_block(slot, surface, receiver, casts_for)) {
                if few.len() == FEW {
                    is_many = true;
                    return false;
                }
                few.push(slot as u32);
            }
            true
        });
        if is_many {
            Suspects::Many
        } else {
            Suspects::Few(few)
        }
    }

    /// As [`RayScene::segment_blocker`], for a segment to a point of the box whose `suspects` these are.
    pub(super) fn blocker_among(
        &self,
        suspects: &Suspects,
        surface: DVec3,
        light_world: DVec3,
        clearance: f64,
        receiver: Option<u32>,
        casts_for: u32,
        guess: Option<u32>,
    ) -> Option<u32> {
        let Suspects::Few(few) = suspects else {
            return self.segment_blocker(surface, light_world, clearance, receiver, casts_for, guess);
        };
        if suspects.is_empty() {
            return None;
        }
        let ray = Ray {
            origin: surface,
            direction: light_world - surface,
        };
        let sheared = ShearedRay::new(&ray);
        let end = End::At(light_world, clearance);
        let blocks = |slot: &u32| self.crosses(*slot as usize, &sheared, end);
        if let Some(guess) = guess.filter(blocks) {
            return Some(guess);
        }
        // A loop, not `find`, which tests would wait for as calls.
        for slot in few {
            if blocks(slot) {
                return Some(*slot);
            }
        }
        None
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
        self.blocker(&ray, End::Never, receiver, casts_for, guess)
    }

    /// A blocking triangle that crosses the ray before its end, without touching its origin and without being
    /// nearer to the light than its clearance.
    fn blocker(
        &self,
        ray: &Ray,
        end: End,
        receiver: Option<u32>,
        casts_for: u32,
        guess: Option<u32>,
    ) -> Option<u32> {
        let sheared = ShearedRay::new(ray);
        let blocks = |slot: usize| {
            self.crosses(slot, &sheared, end) && self.may_block(slot, ray.origin, receiver, casts_for)
        };
        if let Some(guess) = guess
            && (guess as usize) < self.triangles.len()
            && blocks(guess as usize)
        {
            return Some(guess);
        }
        let mut blocker = None;
        let t_max = end.t_max();
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

    /// Whether a triangle blocks light that comes to a surface point, wherever it comes from.
    fn may_block(&self, slot: usize, surface: DVec3, receiver: Option<u32>, casts_for: u32) -> bool {
        let triangle = &self.triangles[slot];
        triangle.blocks
            && triangle.layers & casts_for != 0
            && receiver != Some(slot as u32)
            && !touches(&triangle.corners, surface)
    }

    /// Whether a triangle crosses a ray before its end, and is not nearer to the light than its clearance.
    fn crosses(&self, slot: usize, ray: &ShearedRay, end: End) -> bool {
        let corners = &self.triangles[slot].corners;
        let hit = ray.intersect(corners);
        hit.is_some_and(|(t, _)| t > 0.0 && t < end.t_max())
            && match end {
                End::At(light, clearance) => distance_to_triangle(light, *corners) > clearance,
                End::Never => true,
            }
    }
}

/// Where a shadow ray ends.
#[derive(Clone, Copy, Debug)]
enum End {
    /// At a light, at t = 1. Triangles nearer to it than the distance, metres, do not block.
    At(DVec3, f64),
    /// Nowhere.
    Never,
}

impl End {
    /// Parameter of the ray before which triangles block.
    fn t_max(self) -> f64 {
        match self {
            End::At(..) => 1.0,
            End::Never => f64::INFINITY,
        }
    }
}

/// The bounds of every object. Triangles of an object follow each other.
fn bounds_of(triangles: &[SceneTriangle]) -> Vec<Bounds> {
    let mut objects: Vec<Bounds> = Vec::new();
    for triangle in triangles {
        let of_triangle = Bounds {
            entity: triangle.entity,
            bounds: Aabb::from_points(triangle.corners.map(|corner| corner.as_vec3())),
            blocks_on: if triangle.blocks { triangle.layers } else { 0 },
        };
        match objects.last_mut() {
            Some(last) if last.entity == triangle.entity => {
                last.bounds = last.bounds.union(of_triangle.bounds);
                last.blocks_on |= of_triangle.blocks_on;
            }
            _ => objects.push(of_triangle),
        }
    }
    objects
}
