//! One thread or many: the same sets, bit for bit. Alone in its file, since the pool of threads is the process's.

#[path = "core/sets_harness/mod.rs"]
mod sets_harness;

use std::sync::Arc;

use antumbra::geometry::Aabb;
use antumbra::prelude::{MeshData, SceneMaterials, SceneMesh};
use antumbra::scene::{Light, LocalBounds, Material, update_world_bounds};
use antumbra::sets::{
    FrameLights, FrustumSet, LightTechnique, Needs, Objects, SetWork, collect_frame_lights,
    collect_light_sets, collect_sets,
};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use bevy_tasks::{ComputeTaskPool, TaskPoolBuilder};
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, Vec3};
use sets_harness::{Random, Scene, simple, spawn, thing, transform};

fn scene() -> Scene {
    let mut random = Random::new(9);
    let mut things = Vec::new();
    for _ in 0..20_000 {
        let half = random.range(0.1, 2.0) as f32;
        things.push(thing(random.vec(60.0).as_vec3(), half));
    }
    let mut scene = simple(things, Vec::new());
    for _ in 0..48 {
        let light = Light::point(Vec3::ONE, 1.0, random.range(3.0, 30.0) as f32);
        let at = transform(random.vec(50.0), Quat::IDENTITY, Vec3::ONE);
        scene.lights.push((light, at, Default::default()));
    }
    scene
}

/// All that some frames with motion leave behind, as text.
fn frames() -> Vec<String> {
    let scene = scene();
    let order: Vec<usize> = (0..scene.things.len()).collect();
    let (mut world, _) = spawn(&scene, &order);
    // World bounds from local ones, so that those are computed on all threads too.
    let mut things = world.query_filtered::<Entity, With<antumbra::scene::ShadowCaster>>();
    let entities: Vec<Entity> = things.iter(&world).collect();
    for (entity, thing) in entities.iter().zip(&scene.things) {
        let (center, half) = (thing.aabb.center(), thing.aabb.half_size());
        let local = Aabb {
            min: -half,
            max: half,
        };
        let place = Transform::from_translation(center).with_rotation(Quat::from_rotation_y(center.x));
        let place = GlobalTransform::from(place);
        world.entity_mut(*entity).insert((LocalBounds(local), place));
    }
    // Some hide others from the lights.
    for (entity, thing) in entities.iter().zip(&scene.things).step_by(40) {
        let wall = Arc::new(MeshData::cuboid(thing.aabb.half_size()));
        let material = SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into());
        world.entity_mut(*entity).insert((SceneMesh(wall), material));
    }
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems((update_world_bounds, collect_sets()).chain());
    let shadow = shadow_all.after(collect_frame_lights).before(collect_light_sets);
    schedule.add_systems(shadow);
    let mut places = world.query_filtered::<&mut GlobalTransform, With<LocalBounds>>();
    let mut frames = Vec::new();
    for frame in 0..4 {
        let step = if frame == 3 { 1 } else { 50 };
        for mut place in places.iter_mut(&mut world).step_by(step) {
            let mut moved = place.affine();
            moved.translation.y += 0.3;
            *place = moved.into();
        }
        schedule.run(&mut world);
        let objects = world.resource::<Objects>();
        let mut text = format!("{:?} {:?}", objects.entities, world.resource::<SetWork>());
        text += &format!("{:?}", world.resource::<FrustumSet>().set.as_slice());
        for light in &world.resource::<FrameLights>().lights {
            for set in [&light.sets.reach, &light.sets.l, &light.sets.i, &light.sets.s] {
                text += &format!("{:x?}", set.as_slice());
            }
            text += &format!(
                "{:?} {:?} {:?}",
                light.region.scissor, light.region.depth_bounds, light.hulls.receivers
            );
        }
        let work = world.resource::<SetWork>();
        assert!(work.depth_buffers > 40 && work.occlusion_tests > 1000, "{work:?}");
        frames.push(text);
    }
    frames
}

#[test]
fn many_threads_give_the_bits_of_one() {
    assert!(ComputeTaskPool::try_get().is_none());
    let alone = frames();
    ComputeTaskPool::get_or_init(|| TaskPoolBuilder::new().num_threads(4).build());
    for _ in 0..3 {
        let together = frames();
        for (frame, (alone, together)) in alone.iter().zip(&together).enumerate() {
            assert!(alone == together, "frame {frame} differs");
        }
    }
    assert!(alone[0] != alone[1] && alone[2] != alone[3], "nothing happened");
}

/// Gives every light a technique whose lights do not light what they do not see.
fn shadow_all(mut lights: ResMut<FrameLights>) {
    for light in &mut lights.lights {
        light.technique = Some(LightTechnique {
            row: 0,
            name: "dark",
            component: std::any::TypeId::of::<()>(),
            needs: Needs {
                light_occlusion: true,
                ..Needs::NOTHING
            },
        });
    }
}
