//! The field of all cases: unit boxes in 400×20×400 m, lights over its middle, a camera that sees 61 % of it.

use antumbra::scene::{
    Camera, LocalBounds, SceneMaterials, ShadowCaster, ShadowReceiver, WorldBounds, update_world_bounds,
};
use antumbra::sets::{ViewportSize, collect_sets, init_set_resources};
use antumbra::{geometry::Aabb, scene::Light};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, UVec2, Vec3};

/// Xorshift; what Bevy's side of the comparison was measured with.
pub struct Random(u64);

impl Random {
    /// The field's seed.
    pub fn new() -> Self {
        Self(0x2545_F491_4F6C_DD1D)
    }

    /// From 0 to 1.
    pub fn unit(&mut self) -> f32 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 40) as f32 / (1u64 << 24) as f32
    }
}

/// The camera: where Bevy's measured one is, with its angle of view.
pub const EYE: Vec3 = Vec3::new(0.0, 60.0, 180.0);

/// Half sizes of all objects, in local space.
pub const HALF: Vec3 = Vec3::splat(0.5);

/// Marks an object of the field, and has its place among them.
#[derive(Component, Clone, Copy)]
pub struct Index(pub usize);

/// Where the objects are.
pub fn objects(random: &mut Random, count: usize) -> Vec<Transform> {
    let mut place = |_| {
        let at = Vec3::new(
            random.unit() * 400.0 - 200.0,
            random.unit() * 20.0,
            random.unit() * 400.0 - 200.0,
        );
        Transform::from_translation(at)
            .with_rotation(Quat::from_rotation_y(random.unit() * std::f32::consts::TAU))
    };
    (0..count).map(&mut place).collect()
}

/// Where the lights are.
pub fn lights(random: &mut Random, count: usize) -> Vec<Transform> {
    let mut place =
        |_| Transform::from_xyz(random.unit() * 200.0 - 100.0, 5.0, random.unit() * 200.0 - 100.0);
    (0..count).map(&mut place).collect()
}

/// What an object is to us.
pub fn object(index: usize) -> impl Bundle {
    let local = Aabb {
        min: -HALF,
        max: HALF,
    };
    (
        Index(index),
        LocalBounds(local),
        WorldBounds::default(),
        ShadowCaster,
        ShadowReceiver,
        SceneMaterials(Default::default()),
    )
}

/// What a light is to us.
pub fn light(range: f32) -> Light {
    Light::point(Vec3::ONE, 1000.0, range)
}

/// Our camera: Bevy's default of 45°, at 1920×1080.
pub fn spawn_camera(world: &mut World) {
    world.insert_resource(ViewportSize(UVec2::new(1920, 1080)));
    let camera = Camera {
        vertical_fov: std::f32::consts::FRAC_PI_4,
        near: 0.1,
        aspect: 16.0 / 9.0,
        ..Camera::default()
    };
    let place = Transform::from_translation(EYE).looking_at(Vec3::ZERO, Vec3::Y);
    world.spawn((camera, GlobalTransform::from(place)));
}

/// The world of ours alone.
pub fn world(count: usize, light_count: usize, range: f32) -> World {
    let mut world = World::new();
    init_set_resources(&mut world);
    spawn_camera(&mut world);
    let mut random = Random::new();
    for (index, place) in objects(&mut random, count).into_iter().enumerate() {
        world.spawn((object(index), GlobalTransform::from(place)));
    }
    for place in lights(&mut random, light_count) {
        world.spawn((light(range), GlobalTransform::from(place)));
    }
    world
}

/// All of ours that is timed: world bounds of what moved, and the sets.
pub fn schedule() -> Schedule {
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems((update_world_bounds, collect_sets()).chain());
    schedule
}

/// Moves each `every`-th object a little to and fro; outside of all timings, for that is the game's.
pub fn shake(world: &mut World, every: usize, step: f32) {
    let mut objects = world.query::<(&Index, &mut GlobalTransform)>();
    for (index, mut transform) in objects.iter_mut(world) {
        if index.0.is_multiple_of(every) {
            let mut moved = transform.affine();
            moved.translation.x += step;
            *transform = moved.into();
        }
    }
}
