//! Cameras share what lives long on the GPU: meshes and pipelines are there once, however many cameras look.

use std::sync::Arc;

use antumbra::bevy_adapter::Mirrors;
use antumbra::prelude::Renderer;
use antumbra::render::Gpu;
use bevy::prelude::*;

use crate::harness::{self, Game};

/// The long-lived parts that the cameras' views draw on.
fn resident(game: &mut Game) -> Vec<Arc<Gpu>> {
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    let views = mirrors.iter_mut();
    views
        .map(|mirror| mirror.world.resource::<Renderer>().gpu().clone())
        .collect()
}

#[test]
fn two_cameras_share_meshes_and_pipelines() {
    let mut app = harness::antumbra();
    let world = app.world_mut();
    harness::add_mesh(
        world,
        Plane3d::default().mesh().size(6.0, 6.0),
        Transform::default(),
    );
    harness::add_mesh(
        world,
        Sphere::new(0.6).mesh().ico(4).expect("a ball"),
        Transform::from_xyz(0.0, 0.8, 0.0),
    );
    harness::add_light(world);
    let first = harness::marked_camera(world, Vec3::new(2.0, 3.0, 4.0));
    let mut game = Game::start(app);
    let alone = game.run(5).settled(first);
    let gpu = resident(&mut game);
    assert_eq!(gpu.len(), 1);
    let (bytes, pipelines) = (gpu[0].mesh_bytes(), gpu[0].pipeline_count());
    assert!(
        bytes > 10_000 && pipelines > 3,
        "{bytes} bytes, {pipelines} pipelines"
    );

    let second = harness::marked_camera(game.world(), Vec3::new(-2.0, 3.0, 4.0));
    let other = game.run(5).settled(second);
    assert_ne!(alone, other, "the second camera looks from elsewhere");
    assert_eq!(
        alone,
        game.settled(first),
        "and changes nothing of what the first sees"
    );
    let shared = resident(&mut game);
    assert_eq!(shared.len(), 2);
    assert!(Arc::ptr_eq(&shared[0], &shared[1]));
    assert_eq!(shared[0].mesh_bytes(), bytes);
    assert_eq!(shared[0].pipeline_count(), pipelines);

    // A mesh that comes counts once, and one that goes is freed.
    let ball = Sphere::new(0.3).mesh().ico(5).expect("a ball");
    let ball = harness::add_mesh(game.world(), ball, Transform::from_xyz(1.0, 0.4, 0.0));
    game.run(5).settled(first);
    let more = shared[0].mesh_bytes();
    assert!(more > bytes, "the ball is there");
    game.world().despawn(ball);
    game.run(3);
    assert_eq!(shared[0].mesh_bytes(), bytes);
}
