//! A technique of somebody else, and changes of techniques while the game runs.

use antumbra::bevy_adapter::Mirrors;
use antumbra::bevy_adapter::prelude::*;
use antumbra::reports::Reports;
use bevy::prelude::*;

use crate::harness::{self, Game};

#[path = "../veil/mod.rs"]
mod veil;
use veil::Veil;

#[test]
fn a_technique_of_somebody_else_joins_the_frame() {
    // Added before Bevy's plugins, and waiting for them.
    let mut app = harness::antumbra_first(|app| {
        app.add_technique::<Veil>();
    });
    app.insert_resource(GlobalAmbientLight::NONE);
    let world = app.world_mut();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    let light = harness::add_light(world);
    world.entity_mut(light).remove::<StencilVolume>();
    let mut game = Game::start(app);
    let lit = game.run(5).settled(camera);
    for (seen, technique) in [(0.25, 0), (0.75, 0), (1.0, 1)] {
        let mut entity = game.world().entity_mut(light);
        match technique {
            0 => entity.insert(Veil { seen }),
            // Ours in its place.
            _ => entity.remove::<Veil>().insert(StencilVolume::default()),
        };
        let picture = game.run(4).settled(camera);
        let share = picture.mean() / lit.mean();
        println!("{seen} of the light is seen: {share}");
        assert!((share - seen).abs() < 0.01, "{share}");
    }
}

#[test]
fn techniques_come_go_and_meet_while_the_game_runs() {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    harness::add_mesh(world, Sphere::new(0.6), Transform::from_xyz(0.0, 1.0, 0.0));
    let light = harness::add_light(world);
    let volumes = game.run(5).settled(camera);
    let reports = |game: &mut Game| {
        let mirrors = game.render_world().resource::<Mirrors>();
        let world = &mirrors.get(camera).expect("the camera is marked").world;
        world.resource::<Reports>().iter().count()
    };
    // A second technique does nothing but be reported; it takes over once the first is gone.
    game.world().entity_mut(light).insert(OmniMap::default());
    let both = game.run(4).settled(camera);
    assert_eq!(both.difference(&volumes).channels, 0);
    assert_eq!(reports(&mut game), 1);
    game.world().entity_mut(light).remove::<StencilVolume>();
    let maps = game.run(4).settled(camera);
    assert_ne!(
        maps.difference(&volumes).channels,
        0,
        "edges of maps are other edges"
    );
    assert_eq!(reports(&mut game), 0);
    game.world()
        .entity_mut(light)
        .remove::<OmniMap>()
        .insert(PenumbraWedge::default());
    game.run(4).settled(camera);
    game.world()
        .entity_mut(light)
        .remove::<PenumbraWedge>()
        .insert(StencilVolume::default());
    let again = game.run(4).settled(camera);
    assert_eq!(again.difference(&volumes).channels, 0);
}
