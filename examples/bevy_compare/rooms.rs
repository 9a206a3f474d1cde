//! The rooms and their lights, as a world of our own components. The ray caster judges it, and the games are made
//! from it.

use std::path::Path;
use std::sync::Arc;

use antumbra::reference::{Ray, RayScene};
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::scene::{
    AlphaMode, Camera, Light, Material, MeshData, SceneMaterials, SceneMesh, ShadowCaster, WorldBounds,
};
use antumbra::schedule::{init_resources, standalone_schedule};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, UVec2, Vec3};

use crate::spread::spread;

/// Range of the lights, metres; the same as that of the scene's own lights.
pub const RANGE: f32 = 9.0;

/// Luminous power of a single lamp, lumens. Several lamps have this divided by the square root of their number.
pub const LUMENS: f32 = 5e5;

/// A caster that moves on a circle.
#[derive(Component, Clone, Copy, Debug)]
pub struct Mover {
    /// Centre of the circle, metres.
    pub center: Vec3,
    /// Angle at time 0, radians.
    pub phase: f32,
}

impl Mover {
    /// Returns its place at a time in seconds.
    pub fn at(&self, time: f32) -> Transform {
        let turn = self.phase + time;
        Transform::from_translation(self.center + 0.4 * Vec3::new(turn.cos(), 0.3 * turn.sin(), turn.sin()))
    }
}

/// The scene and its lights.
pub struct Rooms {
    /// World with the meshes and the moving casters.
    pub world: World,
    /// Camera that sees the scene.
    pub camera: Camera,
    /// Place of the camera.
    pub view: Transform,
    /// Positions of the lights, metres. The scene's own come first, then more, up to 64.
    pub lamps: Vec<Vec3>,
}

impl Rooms {
    /// Loads a scene. Only opaque surfaces and the positions of point lights are taken from it.
    ///
    /// # Errors
    /// One line that names the file.
    pub fn load(path: &Path, size: UVec2) -> Result<Self, String> {
        let mut world = World::new();
        init_resources(&mut world);
        let loaded = load_gltf(path).map_err(|error| error.to_string())?;
        for skip in &loaded.report.skips {
            eprintln!("{}: {skip}", path.display());
        }
        let spawned = spawn_scene(&mut world, &loaded, None).map_err(|error| error.to_string())?;
        let mut schedule = standalone_schedule();
        schedule.run(&mut world);
        let point_lights = spawned.lights.iter().filter_map(|&entity| {
            let light = world.get::<Light>(entity)?;
            let place = world.get::<GlobalTransform>(entity)?;
            (light.kind == antumbra::scene::LightKind::Point).then(|| place.translation())
        });
        let mut lamps: Vec<Vec3> = point_lights.collect();
        for &entity in &spawned.meshes {
            let opaque = |material: &Arc<Material>| material.alpha_mode == AlphaMode::Opaque;
            let materials = world.get::<SceneMaterials>(entity);
            if !materials.is_some_and(|materials| materials.0.iter().all(opaque)) {
                world.entity_mut(entity).remove::<SceneMesh>();
            }
        }
        let bounds: Vec<WorldBounds> = world
            .query_filtered::<&WorldBounds, With<SceneMesh>>()
            .iter(&world)
            .copied()
            .collect();
        let all = bounds
            .iter()
            .fold(antumbra::geometry::Aabb::EMPTY, |all, one| all.union(one.0));
        if all.is_empty() {
            return Err(format!("{}: there is nothing to see", path.display()));
        }
        let scene = RayScene::from_world(&mut world);
        let (min, extent) = (all.min.as_dvec3(), 2.0 * all.half_size().as_dvec3());
        let mut places = (1..20_000).filter_map(|index| hanging_place(&scene, min + extent * spread(index)));
        lamps.extend(
            places
                .by_ref()
                .take(64usize.saturating_sub(lamps.len()))
                .map(|place| place.as_vec3()),
        );
        if lamps.is_empty() {
            return Err(format!("{}: there is no room for a lamp", path.display()));
        }
        // The balls hang below lamps that every run has, so that they always throw shadows.
        let ball = Arc::new(MeshData::icosphere(0.18, 3));
        let matte = SceneMaterials([Arc::new(Material::matte(Vec3::new(0.9, 0.5, 0.3)))].into());
        for (index, lamp) in lamps.iter().take(4).enumerate() {
            let mover = Mover {
                center: *lamp - Vec3::Y * 1.1,
                phase: index as f32,
            };
            let parts = (SceneMesh(ball.clone()), matte.clone(), ShadowCaster);
            world.spawn((parts, mover, mover.at(0.0)));
        }
        schedule.run(&mut world);
        let target = lamps[1 % lamps.len()] - Vec3::Y * 1.2;
        let eye = furthest_view(&RayScene::from_world(&mut world), target);
        Ok(Self {
            world,
            camera: Camera {
                vertical_fov: 1.1,
                near: 0.1,
                aspect: size.x as f32 / size.y as f32,
                ..Camera::default()
            },
            view: Transform::from_translation(eye).looking_at(target, Vec3::Y),
            lamps,
        })
    }
}

/// Returns a place for a lamp above the point, a quarter of a metre below the ceiling. `None` if there is too little
/// room around the point or between its floor and ceiling.
fn hanging_place(scene: &RayScene, from: DVec3) -> Option<DVec3> {
    let distance = |direction| {
        let ray = Ray {
            origin: from,
            direction,
        };
        scene
            .closest_hit(&ray, 1e-4, f64::INFINITY, |_| true)
            .map(|hit| hit.t)
    };
    let (ceiling, floor) = (distance(DVec3::Y)?, distance(DVec3::NEG_Y)?);
    let sides = [DVec3::X, DVec3::NEG_X, DVec3::Z, DVec3::NEG_Z];
    let free = sides
        .into_iter()
        .all(|side| distance(side).is_some_and(|t| t > 0.3));
    (ceiling + floor > 1.8 && free).then(|| from + DVec3::Y * (ceiling - 0.25))
}

/// Returns an eye at a person's height and under a ceiling that sees the target from as far away as the room allows.
fn furthest_view(scene: &RayScene, target: Vec3) -> Vec3 {
    let origin = target.as_dvec3() + DVec3::Y * 0.6;
    let distance = |origin: DVec3, direction: DVec3, most: f64| {
        let hit = scene.closest_hit(&Ray { origin, direction }, 1e-4, most, |_| true);
        hit.map(|hit| hit.t)
    };
    let ways = (0..256).map(|step| {
        let angle = std::f64::consts::TAU * f64::from(step % 32) / 32.0;
        let direction = DVec3::new(angle.cos(), 0.0, angle.sin());
        let most = 1.0 + f64::from(step / 32);
        let reach = distance(origin, direction, most).unwrap_or(most);
        (origin + direction * (reach - 0.3).max(0.2), reach)
    });
    let roofed = ways.filter(|(eye, _)| distance(*eye, DVec3::Y, 4.0).is_some());
    let best = roofed.max_by(|a, b| a.1.total_cmp(&b.1));
    best.map_or(origin + DVec3::X, |(eye, _)| eye).as_vec3()
}
