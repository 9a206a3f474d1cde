//! Managed lights make no views of Bevy's: `Core3d` runs once for each camera, however many there are.

use std::sync::atomic::{AtomicUsize, Ordering};

use antumbra::bevy_adapter::prelude::*;
use bevy::core_pipeline::schedule::Core3d;
use bevy::prelude::*;
use bevy::render::RenderApp;

use crate::harness::{self, Game};

#[derive(Resource, Default)]
struct Runs(AtomicUsize);

/// Runs of `Core3d` in one frame with so many point lights.
fn runs(lights: usize, shadow_maps: bool) -> usize {
    let mut app = harness::antumbra();
    let render_app = app.sub_app_mut(RenderApp);
    render_app.init_resource::<Runs>();
    render_app.add_systems(Core3d, |runs: Res<Runs>| {
        runs.0.fetch_add(1, Ordering::Relaxed);
    });
    app.insert_resource(bevy::light::PointLightShadowMap { size: 16 });
    let world = app.world_mut();
    harness::unseen_camera(world, Vec3::new(0.0, 3.0, 6.0));
    harness::add_mesh(world, Cuboid::new(1.0, 1.0, 1.0), Transform::default());
    for i in 0..lights {
        let angle = i as f32;
        world.spawn((
            PointLight {
                shadow_maps_enabled: shadow_maps,
                ..default()
            },
            StencilVolume::default(),
            Transform::from_xyz(3.0 * angle.cos(), 2.0, 3.0 * angle.sin()),
        ));
    }
    let mut game = Game::start(app);
    game.run(3);
    let before = game.render_world().resource::<Runs>().0.load(Ordering::Relaxed);
    game.run(1);
    game.render_world().resource::<Runs>().0.load(Ordering::Relaxed) - before
}

#[test]
fn core_3d_runs_once_a_camera_with_many_managed_lights() {
    let ours = runs(40, false);
    let bevys = runs(1, true);
    println!(
        "runs of Core3d a frame: 40 managed lights {ours}; one shadow-mapped point light of Bevy's {bevys}"
    );
    assert_eq!(ours, 1);
    assert_eq!(bevys, 7, "the count counts");
}
