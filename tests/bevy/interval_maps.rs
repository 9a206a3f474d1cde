//! Maps baked from a game's scene shadow the game's light, which follows its path.

use antumbra::baking::{BakeSettings, bake_into};
use antumbra::bevy_adapter::prelude::*;
use antumbra::bevy_adapter::still_scene;
use antumbra::reports::Reports;
use antumbra::scene::PathPoint;
use antumbra::techniques::IntervalFolder;
use bevy::prelude::*;

use crate::harness::{self, Game, Picture, add_mesh, marked_camera};

/// Pixels that are darker than in another picture.
fn darker(picture: &Picture, other: &Picture) -> usize {
    let green = |picture: &Picture, at: usize| f32::from(picture.texels[at][1]);
    (0..picture.texels.len())
        .filter(|&at| green(picture, at) < 0.7 * green(other, at))
        .count()
}

/// Spawns a sun that follows an arc. Returns it and its path.
fn sun_on_a_path(world: &mut World) -> (Entity, LightPath) {
    let path = LightPath::Arc {
        direction: Vec3::new(-1.0, -0.7, -0.4),
        axis: Vec3::Z,
        degrees: 100.0,
    };
    let light = DirectionalLight {
        illuminance: 3000.0,
        ..default()
    };
    let light = world.spawn((light, path.clone(), Transform::default())).id();
    (light, path)
}

#[test]
fn a_game_bakes_its_scene_and_its_sun_follows_the_path() {
    let mut app = harness::antumbra();
    let world = app.world_mut();
    let camera = marked_camera(world, Vec3::new(0.0, 4.0, 4.0));
    add_mesh(
        world,
        Plane3d::default().mesh().size(5.0, 5.0),
        Transform::IDENTITY,
    );
    let place = Transform::from_xyz(0.0, 0.5, 0.0).with_rotation(Quat::from_rotation_y(0.4));
    add_mesh(world, Cuboid::new(0.8, 1.0, 0.8), place);
    let (light, path) = sun_on_a_path(world);
    let mut game = Game::start(app);
    game.run(2);
    let mut still = still_scene(game.world(), |_| false);
    let folder = std::env::temp_dir().join(format!("antumbra-{}-bevy", std::process::id()));
    let settings = BakeSettings {
        texels_per_metre: 4.0,
        ..default()
    };
    let bake = bake_into(&folder, &mut still, &path, &settings, |_| ()).expect("it is baked");
    assert_eq!((bake.notes.len(), bake.maps.surfaces.len()), (0, 2));
    let shadow = |time: f32| OcclusionInterval {
        maps: folder.to_string_lossy().into_owned(),
        time,
        ..default()
    };
    let mut pictures = Vec::new();
    for time in [0.1, 0.9] {
        game.world().entity_mut(light).insert(shadow(time));
        let shadowed = game.run(3).settled(camera);
        let forward = game.world().get::<Transform>(light).expect("it stands").forward();
        let PathPoint::Direction(expected) = path.at(time) else {
            panic!("an arc has directions");
        };
        assert!(forward.distance(expected) < 1e-5, "{forward:?} {expected}");
        // The same light without its shadow.
        game.world().entity_mut(light).insert(LightSelection {
            shows_on: 0,
            ..default()
        });
        let bare = game.run(3).settled(camera);
        let dark = darker(&shadowed, &bare);
        println!("{time}: {dark} pixels are in shadow");
        assert!(dark > 80, "{time}: {dark}");
        game.world().entity_mut(light).remove::<LightSelection>();
        pictures.push(shadowed);
    }
    assert_ne!(pictures[0], pictures[1]);
    // Names are relative to the game's assets, or to another folder.
    let assets = game.world().resource::<IntervalFolder>().0.clone();
    assert!(assets.is_absolute() && assets.ends_with("assets"), "{assets:?}");
    let (parent, name) = (
        folder.parent().expect("its parent"),
        folder.file_name().expect("its name"),
    );
    game.world().insert_resource(IntervalFolder(parent.to_owned()));
    game.world().entity_mut(light).insert(OcclusionInterval {
        maps: name.to_string_lossy().into_owned(),
        time: 0.9,
        ..default()
    });
    assert_eq!(game.run(3).settled(camera), pictures[1]);
    // A light on another path than that of its maps is reported.
    let messages = |game: &mut Game| -> Vec<String> {
        let reports = game.world().resource::<Reports>();
        let own = reports
            .iter()
            .filter(|report| report.topic == "occlusion_interval");
        own.map(|report| report.message.clone()).collect()
    };
    assert_eq!(messages(&mut game), [] as [String; 0]);
    let LightPath::Arc { direction, axis, .. } = path else {
        panic!("the path is an arc");
    };
    let other = LightPath::Arc {
        direction,
        axis,
        degrees: 90.0,
    };
    game.world().entity_mut(light).insert(other);
    game.run(3);
    let told = messages(&mut game);
    assert!(told.len() == 1 && told[0].contains("another path"), "{told:?}");
    game.world().entity_mut(light).insert(path);
    game.run(3);
    assert_eq!(messages(&mut game), [] as [String; 0]);
    std::fs::remove_dir_all(&folder).expect("it is removed");
}

/// A second technique on the light shadows by what is not in the maps, and on it.
#[test]
fn a_mesh_that_was_not_baked_casts_and_receives_by_the_lights_second_technique() {
    let mut app = harness::antumbra();
    let world = app.world_mut();
    let camera = marked_camera(world, Vec3::new(0.0, 4.0, 4.0));
    add_mesh(
        world,
        Plane3d::default().mesh().size(5.0, 5.0),
        Transform::IDENTITY,
    );
    add_mesh(
        world,
        Cuboid::new(0.8, 1.0, 0.8),
        Transform::from_xyz(-0.6, 0.5, 0.0),
    );
    let (light, path) = sun_on_a_path(world);
    let mut game = Game::start(app);
    game.run(2);
    let mut still = still_scene(game.world(), |_| false);
    let folder = std::env::temp_dir().join(format!("antumbra-{}-bevy-moving", std::process::id()));
    let settings = BakeSettings {
        texels_per_metre: 4.0,
        ..default()
    };
    bake_into(&folder, &mut still, &path, &settings, |_| ()).expect("it is baked");
    game.world().entity_mut(light).insert(OcclusionInterval {
        maps: folder.to_string_lossy().into_owned(),
        time: 0.3,
        ..default()
    });
    // It hangs beside the box and over the ground.
    add_mesh(
        game.world(),
        Cuboid::new(0.6, 0.1, 0.6),
        Transform::from_xyz(0.9, 1.2, 0.2),
    );
    let count = |game: &mut Game| {
        let reports = game.world().resource::<Reports>();
        reports.iter().count()
    };
    let alone = game.run(3).settled(camera);
    assert_eq!(
        count(&mut game),
        1,
        "it is said that one receiver is not in the maps"
    );
    game.world().entity_mut(light).insert(StencilVolume::default());
    let both = game.run(3).settled(camera);
    assert_eq!(count(&mut game), 0);
    let (more, less) = (darker(&both, &alone), darker(&alone, &both));
    println!("{more} pixels are darker with a second technique, {less} brighter");
    assert!(more > 60 && less == 0, "{more} darker, {less} brighter");
    game.world().entity_mut(light).remove::<StencilVolume>();
    assert_eq!(game.run(3).settled(camera), alone, "and it goes again");
    game.world().entity_mut(light).insert(ShadowMap::default());
    let mapped = game.run(3).settled(camera);
    let mapped = darker(&mapped, &alone);
    assert!(
        mapped.abs_diff(more) * 4 < more,
        "{mapped} by a map, {more} by volumes"
    );
    std::fs::remove_dir_all(&folder).expect("it is removed");
}
