//! Counts and times of a frame are in Bevy's diagnostics, if the game asks for them.

use antumbra::bevy_adapter::prelude::*;
use bevy::diagnostic::{DiagnosticPath, DiagnosticsStore};
use bevy::prelude::*;

use crate::harness::{self, Game};

const EYE: Vec3 = Vec3::new(0.0, 3.0, 6.0);

/// A floor, a cube and a light, seen by so many cameras, after a few frames.
fn game(cameras: usize, more: impl FnOnce(&mut App)) -> Game {
    let mut app = harness::antumbra();
    more(&mut app);
    let world = app.world_mut();
    for camera in 0..cameras {
        harness::unseen_camera(world, EYE + Vec3::X * camera as f32);
    }
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    harness::add_mesh(world, Cuboid::default(), Transform::from_xyz(0.0, 1.0, 0.0));
    harness::add_light(world);
    let mut game = Game::start(app);
    game.run(4);
    game
}

fn value(game: &mut Game, path: &DiagnosticPath) -> Option<f64> {
    let store = game.apps.main.world().resource::<DiagnosticsStore>();
    store.get(path).and_then(|diagnostic| diagnostic.value())
}

#[test]
fn counts_are_those_of_the_scene_and_sums_over_cameras() {
    type Paths = AntumbraDiagnosticsPlugin;
    for cameras in [1, 2] {
        let mut game = game(cameras, |app| {
            app.add_plugins(AntumbraDiagnosticsPlugin);
        });
        let each = cameras as f64;
        for (path, of_camera) in [
            (Paths::CAMERAS, 1.0),
            (Paths::OBJECTS, 2.0),
            (Paths::VISIBLE, 2.0),
            (Paths::LIGHTS, 1.0),
            (Paths::RECEIVERS, 2.0),
        ] {
            assert_eq!(value(&mut game, &path), Some(of_camera * each), "{path}");
        }
        let casters = value(&mut game, &Paths::CASTERS).expect("there are casters");
        assert!((1.0..=2.0).contains(&(casters / each)), "{casters}");
        // Seen from above and from the side, a cube has a contour of four to six edges, and the floor has four.
        let edges = value(&mut game, &Paths::SILHOUETTE_EDGES).expect("there are edges");
        assert!((4.0..=10.0).contains(&(edges / each)), "{edges}");
        assert!(value(&mut game, &Paths::CPU_TIME) > Some(0.0));
        assert_eq!(
            value(&mut game, &Paths::TEXTURE_BYTES),
            Some(0.0),
            "volumes have no texture"
        );
        let world = game.world();
        let mut lights = world.query_filtered::<Entity, With<PointLight>>();
        let light = lights.single(world).expect("one light");
        let mut light = world.entity_mut(light);
        light.remove::<StencilVolume>().insert(OmniMap::default());
        game.run(3);
        assert!(value(&mut game, &Paths::TEXTURE_BYTES) > Some(0.0));
    }
}

#[test]
fn cameras_that_draw_nothing_are_not_counted() {
    let mut game = game(2, |app| {
        app.add_plugins(AntumbraDiagnosticsPlugin);
    });
    let world = game.world();
    let mut cameras = world.query::<&mut Camera>();
    cameras.iter_mut(world).next().expect("a camera").is_active = false;
    game.run(3);
    assert_eq!(value(&mut game, &AntumbraDiagnosticsPlugin::CAMERAS), Some(1.0));
}

#[test]
fn a_game_that_does_not_ask_has_none() {
    let mut game = game(1, |_| {});
    assert_eq!(value(&mut game, &AntumbraDiagnosticsPlugin::CASTERS), None);
}
