//! Cells, portals and occluders of a game hide objects from lights.

use antumbra::bevy_adapter::Mirrors;
use antumbra::bevy_adapter::prelude::*;
use antumbra::sets::{Cells, FrameLights};
use bevy::prelude::*;

use crate::harness::{self, Game};

/// A light in one room, a cube in another, and a camera that is in no room.
struct Rooms {
    game: Game,
    camera: Entity,
    cells: [Entity; 2],
    portal: Entity,
}

impl Rooms {
    fn new() -> Self {
        let mut game = harness::game();
        let world = game.world();
        let camera = harness::unseen_camera(world, Vec3::new(2.0, 1.0, 9.0));
        let [left, right] = [0.0, 4.0].map(|x| {
            let cell = Cell {
                half_size: Vec3::splat(2.0),
            };
            world.spawn((cell, Transform::from_xyz(x, 0.0, 0.0))).id()
        });
        let door = Transform::from_xyz(2.0, 0.0, 0.0)
            .with_rotation(Quat::from_rotation_y(std::f32::consts::FRAC_PI_2));
        let portal = Portal {
            open: false,
            ..Portal::rectangle([left, right], 0.5, 1.0)
        };
        let portal = world.spawn((portal, door)).id();
        harness::add_mesh(world, Cuboid::default(), Transform::from_xyz(4.0, 0.0, 0.0));
        world.spawn((
            PointLight::default(),
            StencilVolume::default(),
            Transform::default(),
        ));
        game.run(4);
        Self {
            game,
            camera,
            cells: [left, right],
            portal,
        }
    }

    /// The number of objects that the light lights.
    fn lit(&mut self) -> usize {
        self.game.run(2);
        let mirrors = self.game.render_world().resource::<Mirrors>();
        let world = &mirrors.get(self.camera).expect("a mirror").world;
        assert!(world.resource::<Cells>().issues.is_empty());
        world.resource::<FrameLights>().lights[0].sets.i.count_ones(..)
    }

    fn set_open(&mut self, open: bool) {
        let portal = self.portal;
        let mut portals = self.game.world().query::<&mut Portal>();
        let world = self.game.world();
        portals.get_mut(world, portal).expect("a portal").open = open;
    }
}

#[test]
fn a_closed_door_stops_the_light_and_an_open_one_does_not() {
    let mut rooms = Rooms::new();
    assert_eq!(rooms.lit(), 0, "the door is closed");
    rooms.set_open(true);
    assert_eq!(rooms.lit(), 1, "the door is open");
    rooms.set_open(false);
    assert_eq!(rooms.lit(), 0, "the door is closed again");
    // Mirrors that are made anew know the cells.
    rooms.game.render_world().resource_mut::<Mirrors>().clear();
    assert_eq!(rooms.lit(), 0, "the mirror is new");
}

#[test]
fn cells_move_and_go_away() {
    let mut rooms = Rooms::new();
    let [left, right] = rooms.cells;
    assert_eq!(rooms.lit(), 0);
    // The light's room is moved away from the light.
    let mut place = rooms
        .game
        .world()
        .get_mut::<Transform>(left)
        .expect("a transform");
    place.translation.y = 20.0;
    assert_eq!(rooms.lit(), 1, "the light is in no room");
    let mut place = rooms
        .game
        .world()
        .get_mut::<Transform>(left)
        .expect("a transform");
    place.translation.y = 0.0;
    assert_eq!(rooms.lit(), 0);
    rooms.game.world().entity_mut(rooms.portal).despawn();
    rooms.game.world().entity_mut(right).remove::<Cell>();
    assert_eq!(rooms.lit(), 1, "the cube is in no room");
}
