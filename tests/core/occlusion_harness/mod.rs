//! Random worlds with meshes, and a judge that asks rays what the sets must hold.
#![allow(dead_code, reason = "each test file uses a part")]

pub mod rooms;
pub mod scenes;

use std::ops::AddAssign;

use antumbra::prelude::*;
use antumbra::reference::{Ray, RayScene, SceneTriangle, camera_rays};
use antumbra::scene::{Cell, LightKind};
use antumbra::schedule::standalone_schedule;
use antumbra::sets::{FrameLight, FrustumSet, Objects, VisibleSet};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::GlobalTransform;
use glam::{DVec3, UVec2};

/// Size of the pictures whose rays are cast.
pub const VIEWPORT: UVec2 = UVec2::new(48, 27);

/// Rays cast from each light.
const LIGHT_RAYS: usize = 400;

/// Random numbers: every scene follows from its seed.
pub struct Random(fastrand::Rng);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(fastrand::Rng::with_seed(seed))
    }

    pub fn unit(&mut self) -> f32 {
        self.0.f32()
    }

    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    pub fn below(&mut self, count: usize) -> usize {
        self.0.usize(..count)
    }

    pub fn chance(&mut self, share: f32) -> bool {
        self.unit() < share
    }

    pub fn vec(&mut self, half: f32) -> glam::Vec3 {
        glam::Vec3::new(
            self.range(-half, half),
            self.range(-half, half),
            self.range(-half, half),
        )
    }

    pub fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vec(1.0).as_dvec3();
            if v.length_squared() <= 1.0 && v.length_squared() > 1e-3 {
                return v.normalize();
            }
        }
    }

    pub fn rotation(&mut self) -> glam::Quat {
        let mut angle = || self.range(-3.2, 3.2);
        glam::Quat::from_euler(glam::EulerRot::YXZ, angle(), angle(), angle())
    }
}

/// How much was looked at, and how much was hidden.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    pub camera_rays: usize,
    pub light_rays: usize,
    pub lit_points: usize,
    pub hidden_from_camera: usize,
    pub hidden_from_lights: usize,
}

impl AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.camera_rays += other.camera_rays;
        self.light_rays += other.light_rays;
        self.lit_points += other.lit_points;
        self.hidden_from_camera += other.hidden_from_camera;
        self.hidden_from_lights += other.hidden_from_lights;
    }
}

/// What was found.
#[derive(Default)]
pub struct Verdict {
    pub wrong: Vec<String>,
    pub counts: Counts,
}

/// Runs a frame and asks rays.
pub fn judge(world: &mut World, seed: u64) -> Verdict {
    standalone_schedule().run(world);
    let scene = RayScene::from_world(world);
    let mut verdict = Verdict::default();
    let objects = world.resource::<Objects>();
    let index = |triangle: &SceneTriangle| objects.index_of(triangle.entity.unwrap()).unwrap();
    let (f, v) = (
        &world.resource::<FrustumSet>().set,
        &world.resource::<VisibleSet>().set,
    );
    verdict.counts.hidden_from_camera += f.count_ones(..) - v.count_ones(..);
    for (ray, near) in view_rays(world) {
        verdict.counts.camera_rays += 1;
        let culled = |triangle: &SceneTriangle| {
            let [a, b, c] = triangle.corners;
            *world.resource::<FaceCulling>() == FaceCulling::SingleSided
                && !triangle.is_double_sided
                && (b - a).cross(c - a).dot(ray.direction) >= 0.0
        };
        let shown = |triangle: &SceneTriangle| drawn(world, triangle) && !culled(triangle);
        walk(&scene, &ray, near, f64::INFINITY, &shown, |triangle, t| {
            if !v.contains(index(triangle)) {
                let text = format!(
                    "{:?} not in V, seen at {}",
                    triangle.entity,
                    ray.origin + ray.direction * t
                );
                verdict.wrong.push(text);
            }
            triangle.is_primary && !is_masked(world, triangle)
        });
    }
    let mut random = Random::new(seed ^ 0x11_6487);
    for light in &world.resource::<FrameLights>().lights {
        verdict.counts.hidden_from_lights += light.sets.reach.count_ones(..) - light.sets.l.count_ones(..);
        look_from_light(world, &scene, light, &mut random, &mut verdict);
        look_at_lit(world, &scene, light, &mut verdict);
    }
    verdict
}

fn drawn(world: &World, triangle: &SceneTriangle) -> bool {
    world.get::<SceneMaterials>(triangle.entity.unwrap()).is_some()
}

fn is_masked(world: &World, triangle: &SceneTriangle) -> bool {
    let materials = &world.get::<SceneMaterials>(triangle.entity.unwrap()).unwrap().0;
    materials
        .iter()
        .any(|material| material.alpha_mode != AlphaMode::Opaque)
}

/// Rays through pixels, with the depth of the near plane as their parameter.
fn view_rays(world: &World) -> Vec<(Ray, f64)> {
    let Some(view) = &world.resource::<antumbra::sets::View>().data else {
        return Vec::new();
    };
    let camera = world.get::<Camera>(view.camera).unwrap();
    let transform = world.get::<GlobalTransform>(view.camera).unwrap();
    let rays = camera_rays(camera, transform, VIEWPORT).unwrap();
    rays.into_iter()
        .map(|ray| (ray, f64::from(camera.near)))
        .collect()
}

/// Visits the triangles along a ray, nearest first, until `visit` says that one ends it.
fn walk(
    scene: &RayScene,
    ray: &Ray,
    mut from: f64,
    to: f64,
    accept: &dyn Fn(&SceneTriangle) -> bool,
    mut visit: impl FnMut(&SceneTriangle, f64) -> bool,
) {
    for _ in 0..64 {
        let Some(hit) = scene.closest_hit(ray, from, to, accept) else {
            return;
        };
        let triangle = &scene.triangles()[hit.triangle as usize];
        if visit(triangle, hit.t) {
            return;
        }
        from = hit.t * (1.0 + 1e-9) + 1e-12;
    }
}

/// Whether a light's direction is one in which it shines.
fn shines(light: &FrameLight, direction: DVec3) -> bool {
    match light.light.kind {
        LightKind::Spot { outer_angle, .. } => {
            light.direction.as_dvec3().dot(direction) > f64::from(outer_angle).cos() + 1e-4
        }
        LightKind::Rect { .. } => light.direction.as_dvec3().dot(direction) > 1e-3,
        _ => true,
    }
}

/// A triangle that casts for the light.
fn casts(light: &FrameLight, triangle: &SceneTriangle) -> bool {
    triangle.blocks && triangle.layers & light.selection.casts_for != 0
}

fn look_from_light(
    world: &World,
    scene: &RayScene,
    light: &FrameLight,
    random: &mut Random,
    verdict: &mut Verdict,
) {
    let objects = world.resource::<Objects>();
    let shadowed = light.needs().light_occlusion;
    for _ in 0..LIGHT_RAYS {
        let (ray, reach) = if light.point_world.w == 0.0 {
            let direction = -light.point_world.truncate();
            let from = random.vec(12.0).as_dvec3() - direction * 100.0;
            (
                Ray {
                    origin: from,
                    direction,
                },
                f64::INFINITY,
            )
        } else {
            let direction = random.direction();
            let origin = light.point_world.truncate() + area_offset(light, random);
            (Ray { origin, direction }, f64::from(light.light.range) * 0.999)
        };
        if !shines(light, ray.direction) {
            continue;
        }
        verdict.counts.light_rays += 1;
        walk(scene, &ray, 2e-3, reach, &|_| true, |triangle, t| {
            let index = objects.index_of(triangle.entity.unwrap()).unwrap();
            if !light.sets.l.contains(index) {
                let text = format!(
                    "{:?} not in L of {:?}, lit at {}",
                    triangle.entity,
                    light.light.kind,
                    ray.origin + ray.direction * t
                );
                verdict.wrong.push(text);
            }
            shadowed && casts(light, triangle)
        });
    }
}

/// A point of the light, relative to its middle.
fn area_offset(light: &FrameLight, random: &mut Random) -> DVec3 {
    let [a, b] = light.emitter.half_sides;
    let ball = random.direction() * light.emitter.radius * 0.99;
    ball + a * f64::from(random.range(-1.0, 1.0)) + b * f64::from(random.range(-1.0, 1.0))
}

/// Points that the camera sees and the light lights are of objects of I; what blocks others is in S.
fn look_at_lit(world: &World, scene: &RayScene, light: &FrameLight, verdict: &mut Verdict) {
    let objects = world.resource::<Objects>();
    let has_cells = world.iter_entities().any(|entity| entity.contains::<Cell>());
    if light.emitter.bounding_radius() > 0.0 || has_cells && light.light.kind == LightKind::Directional {
        return;
    }
    for (ray, near) in view_rays(world) {
        let culled = |triangle: &SceneTriangle| {
            let [a, b, c] = triangle.corners;
            *world.resource::<FaceCulling>() == FaceCulling::SingleSided
                && !triangle.is_double_sided
                && (b - a).cross(c - a).dot(ray.direction) >= 0.0
        };
        let seen = scene.closest_hit(&ray, near, f64::INFINITY, |triangle| {
            triangle.is_primary && drawn(world, triangle) && !culled(triangle)
        });
        let Some(hit) = seen else { continue };
        let triangle = scene.triangles()[hit.triangle as usize];
        let point = ray.origin + ray.direction * hit.t;
        let to_light = light.point_world.truncate() - point * light.point_world.w;
        let distance = to_light.length();
        let lit = light.point_world.w == 0.0 || distance < f64::from(light.light.range) * 0.999;
        let selected = triangle.layers & light.selection.affects != 0;
        if !lit || !selected || !shines(light, -to_light / distance) {
            continue;
        }
        let from = Ray {
            origin: point,
            direction: to_light,
        };
        let end = if light.point_world.w == 0.0 {
            f64::INFINITY
        } else {
            1.0 - 2e-3 / distance
        };
        let blocker = scene.closest_hit(&from, 1e-4 / distance, end, |other| casts(light, other));
        let shadowed = light.needs().light_occlusion && triangle.receives;
        let index = objects.index_of(triangle.entity.unwrap()).unwrap();
        if blocker.is_none() || !shadowed {
            verdict.counts.lit_points += 1;
            if !light.sets.i.contains(index) {
                let text = format!(
                    "{:?} not in I of {:?}, lit at {point}",
                    triangle.entity, light.light.kind
                );
                verdict.wrong.push(text);
            }
        } else if light.sets.i.contains(index) {
            // Dark: some caster on the way must be in S.
            let mut blocked = false;
            walk(
                scene,
                &from,
                1e-6 / distance,
                end,
                &|other| casts(light, other),
                |other, _| {
                    blocked |= light
                        .sets
                        .s
                        .contains(objects.index_of(other.entity.unwrap()).unwrap());
                    blocked
                },
            );
            if !blocked {
                let text = format!(
                    "{point} of {:?} has no blocker in S of {:?}",
                    triangle.entity, light.light.kind
                );
                verdict.wrong.push(text);
            }
        }
    }
}
