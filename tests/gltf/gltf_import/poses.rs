//! Skins and morph targets.

use antumbra::scene::gltf_import::{SkipKind, spawn_scene};
use antumbra::scene::{LocalBounds, MorphWeights, PosedMesh, SceneMesh, WorldBounds, apply_animation};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3, Vec4};
use serde_json::json;

use super::assert_near;
use crate::gltf_builder::*;

#[test]
fn skin_and_morph_pose_to_hand_computed_vertices() {
    let gltf = animated().load();
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let mesh = spawned.meshes[0];
    assert_ne!(
        Some(mesh),
        spawned.nodes.nodes[0],
        "a skinned mesh leaves its node"
    );
    schedule.run(&mut world);
    assert_eq!(
        world.get::<PosedMesh>(mesh).unwrap().positions,
        world.get::<SceneMesh>(mesh).unwrap().0.positions
    );

    // halfway: the second joint has moved by (2, 0, 0), the target is at one half
    apply_animation(&mut world, &spawned, &gltf.clips[0], 1.0);
    schedule.run(&mut world);
    let posed = world.get::<PosedMesh>(mesh).unwrap();
    let lift = 0.5 * Vec3::Z;
    for (vertex, expected) in [
        Vec3::ZERO,
        Vec3::X * 3.0,
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(2.5, 1.0, 0.0),
    ]
    .into_iter()
    .enumerate()
    {
        assert_near(posed.positions[vertex], expected + lift);
        assert_near(posed.normals[vertex], Vec3::Z);
    }
    let bounds = world.get::<WorldBounds>(mesh).unwrap().0;
    assert_near(bounds.max, Vec3::new(3.0, 1.0, 0.5));

    // times are clamped
    apply_animation(&mut world, &spawned, &gltf.clips[0], 99.0);
    assert_eq!(world.get::<MorphWeights>(mesh).unwrap().0, [1.0]);
    assert_eq!(gltf.clips[0].duration(), 2.0);

    // a turned joint turns normals
    let hip = spawned.nodes.nodes[1].unwrap();
    world.get_mut::<Transform>(hip).unwrap().rotation = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    apply_animation(&mut world, &spawned, &gltf.clips[0], 0.0);
    schedule.run(&mut world);
    let posed = world.get::<PosedMesh>(mesh).unwrap();
    assert_near(posed.positions[2], Vec3::Z);
    assert_near(posed.normals[2], -Vec3::Y);
}

#[derive(Resource, Default)]
struct PoseCount(usize);

#[test]
fn meshes_pose_only_when_something_moved_and_survive_singular_transforms() {
    let gltf = animated().load();
    let (mut world, mut schedule) = frame();
    world.init_resource::<PoseCount>();
    schedule.add_systems(
        (|posed: Query<(), Changed<PosedMesh>>, mut count: ResMut<PoseCount>| {
            count.0 += posed.iter().count()
        })
        .after(antumbra::scene::pose_meshes),
    );
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let mesh = spawned.meshes[0];
    let joint = spawned.nodes.nodes[2].unwrap();
    let poses = |world: &mut World, schedule: &mut Schedule| {
        world.resource_mut::<PoseCount>().0 = 0;
        schedule.run(world);
        world.resource::<PoseCount>().0
    };
    assert_eq!(poses(&mut world, &mut schedule), 1);
    assert_eq!(poses(&mut world, &mut schedule), 0);
    world.get_mut::<Transform>(joint).unwrap().translation.x = 1.0;
    assert_eq!(poses(&mut world, &mut schedule), 1);
    world.get_mut::<MorphWeights>(mesh).unwrap().0[0] = 0.5;
    assert_eq!(poses(&mut world, &mut schedule), 1);
    let before = world.get::<PosedMesh>(mesh).unwrap().clone();

    // the root's move carries joints and mesh alike: posed anew, to the same place
    world.get_mut::<Transform>(spawned.root).unwrap().translation = Vec3::new(1e4, 0.0, 0.0);
    assert_eq!(poses(&mut world, &mut schedule), 1);
    for (after, before) in world
        .get::<PosedMesh>(mesh)
        .unwrap()
        .positions
        .iter()
        .zip(&before.positions)
    {
        assert!(after.distance(*before) < 2e-3, "{after} {before}");
    }
    let before = world.get::<PosedMesh>(mesh).unwrap().clone();
    // Joints alone say where it is: without a scale of its own it is posed around its place.
    *world.get_mut::<Transform>(mesh).unwrap() = Transform::from_scale(Vec3::ZERO);
    assert_eq!(poses(&mut world, &mut schedule), 1);
    let posed = world.get::<PosedMesh>(mesh).unwrap();
    for (after, before) in posed.positions.iter().zip(&before.positions) {
        assert!(after.distance(*before) < 2e-3, "{after} {before}");
    }
    let before = world.get::<PosedMesh>(mesh).unwrap().clone();
    world.get_mut::<Transform>(mesh).unwrap().translation = Vec3::splat(f32::NAN);
    assert_eq!(poses(&mut world, &mut schedule), 0);
    assert_eq!(*world.get::<PosedMesh>(mesh).unwrap(), before);
    *world.get_mut::<Transform>(mesh).unwrap() = Transform::IDENTITY;
    assert_eq!(poses(&mut world, &mut schedule), 1);
    world.despawn(joint);
    world.get_mut::<MorphWeights>(mesh).unwrap().0[0] = 0.0;
    assert_eq!(poses(&mut world, &mut schedule), 0);
    world.entity_mut(mesh).remove::<antumbra::scene::Skin>();
    assert_eq!(poses(&mut world, &mut schedule), 1);
    assert_eq!(
        world.get::<PosedMesh>(mesh).unwrap().positions,
        gltf.meshes[0].data.positions
    );
}

#[test]
fn equal_vertices_pose_to_equal_bits_whatever_the_order_of_their_joints() {
    let mut builder = animated();
    // the same three influences in three orders
    let joints = builder.accessor(&[0, 1, 1, 0, 1, 0, 1, 0, 1, 1, 0, 0, 0, 1, 1, 0], U8, "VEC4", 4);
    let weights = [
        [0.1, 0.3, 0.6, 0.0],
        [0.6, 0.1, 0.3, 0.0],
        [0.3, 0.6, 0.1, 0.0],
        [0.1, 0.3, 0.6, 0.0],
    ];
    let weights = builder.floats(&weights);
    let positions = builder.floats(&[[0.3, 0.7, 0.9]; 4]);
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["POSITION"] = json!(positions);
    let gltf = builder.load();
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let hip = spawned.nodes.nodes[1].unwrap();
    world.get_mut::<Transform>(hip).unwrap().rotation = Quat::from_rotation_z(0.7);
    apply_animation(&mut world, &spawned, &gltf.clips[0], 0.37);
    schedule.run(&mut world);
    let posed = &world.get::<PosedMesh>(spawned.meshes[0]).unwrap().positions;
    assert!(
        posed
            .iter()
            .all(|p| p.to_array().map(f32::to_bits) == posed[0].to_array().map(f32::to_bits))
    );
    assert_ne!(posed[0], Vec3::new(0.3, 0.7, 0.9));
}

#[test]
fn more_than_four_joints_keep_the_strongest() {
    let mut builder = animated();
    let weights = builder.floats(&[[0.5, 0.5, 0.0, 0.0]; 4]);
    let joints = builder.json["meshes"][0]["primitives"][0]["attributes"]["JOINTS_0"].clone();
    let strong = builder.floats(&[[0.75, 0.75, 0.75, 0.75]; 4]);
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["WEIGHTS_0"] = json!(weights);
    attributes["JOINTS_1"] = joints;
    attributes["WEIGHTS_1"] = json!(strong);
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::VertexData), 4);
    assert_eq!(gltf.meshes[0].data.joint_weights[0], Vec4::splat(0.25));
    assert_eq!(gltf.meshes[0].data.joints[0], [0, 0, 0, 1]);
}

#[test]
fn a_mesh_not_posed_yet_has_the_bounds_of_its_rest_pose() {
    let gltf = animated().load();
    let mut world = World::new();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    let mut schedule = Schedule::default();
    schedule.add_systems(antumbra::scene::update_local_bounds);
    schedule.run(&mut world);
    assert_eq!(
        world.get::<LocalBounds>(spawned.meshes[0]).unwrap().0.max,
        Vec3::new(1.0, 1.0, 0.0)
    );
}
