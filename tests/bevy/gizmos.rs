//! Gizmos show sets, silhouettes and other results of a frame.

use antumbra::bevy_adapter::AntumbraGizmoLines;
use antumbra::bevy_adapter::prelude::*;
use antumbra::debug_lines::DebugLine;
use bevy::gizmos::config::GizmoConfigStore;
use bevy::prelude::*;

use crate::harness::{self, Game};

const EYE: Vec3 = Vec3::new(0.0, 3.0, 6.0);

/// A floor, a cube between it and a light, and a camera, after a few frames.
fn game() -> (Game, Entity) {
    let mut app = harness::antumbra();
    app.add_plugins(AntumbraGizmosPlugin);
    let world = app.world_mut();
    let camera = harness::marked_camera(world, EYE);
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    harness::add_mesh(world, Cuboid::default(), Transform::from_xyz(0.0, 1.0, 0.0));
    harness::add_light(world);
    let mut game = Game::start(app);
    game.run(4);
    (game, camera)
}

/// Shows some of the lines, and returns them after two frames.
fn shown(game: &mut Game, set: impl FnOnce(&mut AntumbraGizmos)) -> Vec<DebugLine> {
    let mut store = game.world().resource_mut::<GizmoConfigStore>();
    let (_, gizmos) = store.config_mut::<AntumbraGizmos>();
    *gizmos = AntumbraGizmos::default();
    set(gizmos);
    game.run(2);
    game.world().resource::<AntumbraGizmoLines>().0.lines().to_vec()
}

#[test]
fn each_subject_has_its_lines() {
    let (mut game, camera) = game();
    let plain = game.settled(camera);
    assert!(shown(&mut game, |_| {}).is_empty());

    let boxes = shown(&mut game, |gizmos| gizmos.sets = true);
    assert_eq!(boxes.len(), 2 * 12, "the floor and the cube");
    let of_the_view = shown(&mut game, |gizmos| {
        gizmos.sets = true;
        gizmos.light = Some(camera); // which is no light
    });
    assert_eq!(of_the_view.len(), 2 * 12, "they are seen without a light");
    assert_ne!(of_the_view[0].color, boxes[0].color);
    let silhouettes = shown(&mut game, |gizmos| gizmos.silhouettes = true);
    // Seen from above and from the side, a cube has a contour of four to six edges, and the floor has four.
    assert!((4..=10).contains(&silhouettes.len()), "{}", silhouettes.len());
    let volumes = shown(&mut game, |gizmos| gizmos.techniques = true);
    assert_eq!(volumes.len(), 4 * silhouettes.len());
    assert!(!shown(&mut game, |gizmos| gizmos.reach = true).is_empty());
    assert_eq!(shown(&mut game, |gizmos| gizmos.regions = true).len(), 12);
    assert!(shown(&mut game, |gizmos| gizmos.hulls = true).len() >= 12);
    assert!(
        shown(&mut game, |gizmos| gizmos.cells = true).is_empty(),
        "there are no cells"
    );

    // The lines are drawn, and only while they are shown.
    shown(&mut game, |gizmos| gizmos.sets = true);
    let with_boxes = game.settled(camera);
    let drawn = with_boxes.difference(&plain);
    assert!(drawn.channels > 300, "{drawn:?}");
    shown(&mut game, |_| {});
    let after = game.settled(camera);
    assert_eq!(after.difference(&plain).channels, 0);
}

#[test]
fn one_light_or_one_camera_can_be_chosen() {
    let (mut game, camera) = game();
    let world = game.world();
    let first = world
        .query_filtered::<Entity, With<PointLight>>()
        .single(world)
        .expect("one light");
    let place = Transform::from_xyz(-2.0, 3.0, 1.0);
    let second = world
        .spawn((PointLight::default(), OmniMap::default(), place))
        .id();
    game.run(3);
    let all = shown(&mut game, |gizmos| gizmos.regions = true).len();
    let of = |game: &mut Game, light| {
        shown(game, |gizmos| {
            gizmos.regions = true;
            gizmos.light = Some(light);
        })
        .len()
    };
    assert_eq!((all, of(&mut game, first), of(&mut game, second)), (24, 12, 12));
    assert_eq!(of(&mut game, camera), 0, "a camera is no light");
    let elsewhere = shown(&mut game, |gizmos| {
        gizmos.regions = true;
        gizmos.camera = Some(first);
    });
    assert!(elsewhere.is_empty(), "a light is no camera");
    // The six faces of the map.
    let faces = shown(&mut game, |gizmos| {
        gizmos.techniques = true;
        gizmos.light = Some(second);
    });
    assert_eq!(faces.len() % 12, 0);
    assert!(!faces.is_empty());
}
