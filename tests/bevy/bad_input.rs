//! Meshes, lights and cameras as games make them when something goes wrong.

use antumbra::bevy_adapter::prelude::*;
use antumbra::bevy_adapter::{Mirrors, RefusedMeshes};
use antumbra::sets::FrameLights;
use bevy::asset::RenderAssetUsages;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;

use crate::harness::{self, Game};
use crate::setup::{listen, warnings};

fn game() -> (Game, Entity) {
    let mut game = harness::game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    harness::add_mesh(
        world,
        Plane3d::default().mesh().size(8.0, 8.0),
        Transform::default(),
    );
    harness::add_light(world);
    (game, camera)
}

fn add(world: &mut World, mesh: Mesh) -> Entity {
    harness::add_mesh(world, mesh, Transform::from_xyz(0.0, 1.0, 0.0))
}

fn casters(game: &mut Game, camera: Entity) -> usize {
    let mirrors = game.render_world().resource::<Mirrors>();
    let lights = mirrors.get(camera).unwrap().world.resource::<FrameLights>();
    lights.lights[0].sets.s.count_ones(..)
}

#[test]
fn meshes_that_cannot_cast_are_told_of_and_lit() {
    listen();
    let (mut game, camera) = game();
    let world = game.world();
    let usage = RenderAssetUsages::default();
    let positions = || {
        vec![
            [0.0f32, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [1.0, 1.0, 0.0],
        ]
    };
    let lines = Mesh::new(PrimitiveTopology::LineList, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0f32, 0.0, 1.0]; 4]);
    let lines = add(world, lines);
    // Cast: a strip, and a soup without indices.
    let strip = Mesh::new(PrimitiveTopology::TriangleStrip, usage)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions())
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, vec![[0.0f32, 0.0, 1.0]; 4])
        .with_inserted_indices(Indices::U16(vec![0, 1, 2, 3]));
    add(world, strip);
    // Of the render world alone, yet seen before it went there.
    let mut gone = Mesh::from(Cuboid::new(0.5, 0.5, 0.5));
    gone.asset_usage = RenderAssetUsages::RENDER_WORLD;
    add(world, gone);
    game.run(4);
    assert!(game.radiance(camera).mean() > 0.0);
    let refused = game.render_world().resource::<RefusedMeshes>().count();
    assert_eq!(refused, 1, "the lines alone");
    let told = warnings("LineList");
    assert_eq!(told.len(), 1, "{told:?}");
    assert!(told[0].contains(&lines.to_string()), "{told:?} names the entity");
    assert_eq!(
        casters(&mut game, camera),
        3,
        "floor, strip and what went to the render world"
    );
}

#[test]
fn meshes_replaced_every_frame_are_followed() {
    let (mut game, camera) = game();
    let world = game.world();
    let object = add(world, Cuboid::new(1.0, 1.0, 1.0).into());
    game.run(2);
    for frame in 0..8 {
        let world = game.world();
        let size = 0.5 + 0.1 * frame as f32;
        let handle = world.get::<Mesh3d>(object).unwrap().0.clone();
        let mut meshes = world.resource_mut::<Assets<Mesh>>();
        if frame % 2 == 0 {
            meshes
                .insert(handle.id(), Cuboid::new(size, size, size).into())
                .unwrap();
        } else {
            let mesh = meshes.add(Cuboid::new(size, size, size));
            world.entity_mut(object).insert(Mesh3d(mesh));
        }
        game.run(1);
        assert_eq!(casters(&mut game, camera), 2, "frame {frame}");
    }
}

#[test]
fn lights_come_and_go_every_frame_and_two_thousand_are_managed() {
    let (mut game, camera) = game();
    let world = game.world();
    add(world, Cuboid::new(1.0, 1.0, 1.0).into());
    game.run(2);
    for frame in 0..6 {
        let light = game.world().spawn((
            PointLight::default(),
            StencilVolume::default(),
            Transform::from_xyz(frame as f32 - 3.0, 2.0, 1.0),
        ));
        let light = light.id();
        game.run(1);
        game.world().despawn(light);
        game.run(1);
        let mirrors = game.render_world().resource::<Mirrors>();
        let lights = mirrors.get(camera).unwrap().world.resource::<FrameLights>();
        assert_eq!(lights.lights.len(), 1, "frame {frame}");
    }
    const MANY: usize = 2000;
    for i in 0..MANY {
        let (x, z) = ((i % 50) as f32, (i / 50) as f32);
        game.world().spawn((
            PointLight {
                range: 0.3,
                intensity: 100.0,
                ..default()
            },
            StencilVolume::default(),
            Transform::from_xyz(x * 0.06 - 1.5, 0.2, z * -0.06 + 1.2),
        ));
    }
    game.run(2);
    assert!(game.radiance(camera).mean() > 0.0);
    let mirrors = game.render_world().resource::<Mirrors>();
    let mirror = mirrors.get(camera).unwrap();
    let lights = mirror.world.resource::<FrameLights>();
    assert_eq!(lights.lights.len(), MANY + 1);
    let managed = mirror.view.draws.iter().flatten().count();
    println!(
        "{managed} of {} lights are drawn by us or skipped",
        lights.lights.len()
    );
    assert_eq!(managed, MANY + 1);
}

#[test]
fn cameras_without_the_marker_are_bevys() {
    let (mut game, _) = game();
    let world = game.world();
    let plain = harness::camera(
        world,
        Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y),
    );
    game.run(4);
    assert!(game.render_world().resource::<Mirrors>().get(plain).is_none());
    assert!(game.radiance(plain).mean() > 0.0, "and its lights shine");
}
