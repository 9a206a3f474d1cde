//! Devices that are lost, render worlds on another thread, cameras that come late and go.

use antumbra::bevy_adapter::Mirrors;
use antumbra::bevy_adapter::prelude::*;
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::error_handler::{RenderErrorHandler, RenderErrorPolicy};
use bevy::render::renderer::RenderDevice;
use bevy::render::settings::RenderCreation;

use crate::harness::{self, Game};

fn scene(world: &mut World) -> Entity {
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    let cube = Cuboid::new(1.0, 1.0, 1.0);
    harness::add_mesh(world, cube, Transform::from_xyz(0.0, 0.5, 0.0));
    harness::add_light(world);
    camera
}

/// A picture shows shadows if it is brighter without them. Takes them off.
fn assert_shows_shadows(game: &mut Game, camera: Entity, picture: &harness::Picture) {
    let world = game.world();
    let mut lights = world.query_filtered::<Entity, With<StencilVolume>>();
    let lights: Vec<Entity> = lights.iter(world).collect();
    for light in lights {
        world.entity_mut(light).remove::<StencilVolume>();
    }
    let unshadowed = game.run(3).settled(camera);
    assert!(
        unshadowed.mean() > 1.001 * picture.mean(),
        "{} without shadows, {} with them",
        unshadowed.mean(),
        picture.mean()
    );
}

#[test]
fn a_lost_device_is_survived() {
    let mut app = harness::antumbra();
    let camera = scene(app.world_mut());
    app.insert_resource(RenderErrorHandler(|_, _, _| {
        RenderErrorPolicy::Recover(RenderCreation::default())
    }));
    let mut game = Game::start(app);
    let before = game.run(5).settled(camera);
    let device = game.render_world().resource::<RenderDevice>().clone();
    device.wgpu_device().destroy();
    // Before Bevy makes a buffer on it, which panics.
    let _ = device.wgpu_device().poll(wgpu::PollType::Poll);
    game.run(8);
    let after = game.settled(camera);
    assert!(before.mean() > 0.01);
    assert_eq!(after.difference(&before).channels, 0);
    assert_shows_shadows(&mut game, camera, &after);
}

#[test]
fn cameras_come_late_and_go() {
    let mut game = harness::game();
    let camera = scene(game.world());
    let first = game.run(5).settled(camera);
    let place = *game.world().get::<Transform>(camera).unwrap();
    let late = harness::camera(game.world(), place);
    game.world().entity_mut(late).insert(AntumbraCamera);
    let second = game.run(5).settled(late);
    assert_eq!(
        second.difference(&first).channels,
        0,
        "a late camera sees the same"
    );
    game.world().entity_mut(late).remove::<AntumbraCamera>();
    game.run(3);
    assert!(game.render_world().resource::<Mirrors>().get(late).is_none());
    let unshadowed = game.settled(late);
    assert!(
        unshadowed.mean() > first.mean(),
        "Bevy lights it, without our shadows"
    );
    game.world().despawn(late);
    game.run(2);
    assert_eq!(game.radiance(camera).difference(&first).channels, 0);
}

#[test]
fn meshes_are_made_ready_on_other_threads() {
    let mut app = harness::antumbra();
    app.insert_resource(AntumbraSettings {
        immediate_triangles: 0,
        ..default()
    });
    let camera = scene(app.world_mut());
    let mut game = Game::start(app);
    let (mut frames, mut most) = (0, 0);
    loop {
        let library = game.world().resource::<antumbra::bevy_adapter::MeshLibrary>();
        let building = library.building();
        most = most.max(building);
        if building == 0 && frames >= 3 {
            break;
        }
        game.run(1);
        std::thread::sleep(std::time::Duration::from_millis(1));
        frames += 1;
        assert!(frames < 2000, "they are never ready");
    }
    assert!(most > 0, "no mesh was made ready in the background");
    let background = game.run(3).settled(camera);
    let mut game = harness::game();
    let camera = scene(game.world());
    let immediate = game.run(5).settled(camera);
    assert_eq!(background.difference(&immediate).channels, 0);
    assert_shows_shadows(&mut game, camera, &immediate);
}

#[test]
fn a_mesh_that_changes_in_every_frame_casts() {
    use antumbra::bevy_adapter::MeshLibrary;
    use antumbra::scene::{SceneMesh, ShadowCaster, WorldBounds};

    let mut game = harness::game();
    let world = game.world();
    world.insert_resource(AntumbraSettings {
        immediate_triangles: 0,
        ..default()
    });
    let camera = harness::unseen_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let cube = harness::add_mesh(world, Cuboid::from_length(1.0), Transform::default());
    harness::add_light(world);
    let mesh = world.get::<Mesh3d>(cube).expect("a mesh").0.clone();
    // Changes the mesh, and returns whether it casts in that frame, with the top of its bounds and of what casts.
    let step = |game: &mut Game, size: f32| {
        let mut meshes = game.world().resource_mut::<Assets<Mesh>>();
        let changed = Cuboid::from_length(size).into();
        meshes.insert(mesh.id(), changed).expect("the mesh is there");
        game.run(1);
        let mirrors = game.render_world().resource::<Mirrors>();
        let mirror = mirrors.get(camera).expect("a mirror");
        let object = mirror.world.entity(mirror.get(cube).expect("it is mirrored"));
        let top = |mesh: &SceneMesh| mesh.0.positions.iter().fold(0.0_f32, |top, at| top.max(at.y));
        (
            object.contains::<ShadowCaster>(),
            object.get::<WorldBounds>().expect("it has bounds").0.max.y,
            object.get::<SceneMesh>().map(top),
        )
    };
    let casts = |frame: usize| {
        std::thread::sleep(std::time::Duration::from_millis(1));
        step(&mut game, 1.0 + frame as f32 * 1e-3).0
    };
    assert!((0..500).any(casts), "it never casts");
    for frame in 0..50 {
        assert!(step(&mut game, 1.0 + frame as f32 * 1e-3).0, "frame {frame}");
    }
    // The object is drawn with its new shape at once, and must be lit there, even if that shape does not cast yet.
    step(&mut game, 3.0);
    let (_, top, _) = step(&mut game, 3.0);
    assert!(top >= 1.5, "{top}");
    // The last shape is built, too.
    let is_idle = |game: &mut Game| game.world().resource::<MeshLibrary>().building() == 0;
    step(&mut game, 2.0);
    for _ in 0..500 {
        if is_idle(&mut game) {
            break;
        }
        std::thread::sleep(std::time::Duration::from_millis(1));
        game.run(1);
    }
    assert!(is_idle(&mut game), "it is never ready");
    let mirrors = game.run(1).render_world().resource::<Mirrors>();
    let mirror = mirrors.get(camera).expect("a mirror");
    let object = mirror.world.entity(mirror.get(cube).expect("it is mirrored"));
    let bounds = object.get::<WorldBounds>().expect("it has bounds");
    assert_eq!(bounds.0.max.y, 1.0);
}

#[test]
fn a_target_may_shrink_to_nothing_and_grow_again() {
    let mut game = harness::game();
    let camera = scene(game.world());
    let before = game.run(5).settled(camera);
    // As of a window that is minimized.
    for size in [
        UVec2::ZERO,
        UVec2::new(harness::SIZE.x, 0),
        UVec2::new(0, harness::SIZE.y),
    ] {
        game.world()
            .entity_mut(camera)
            .insert(RenderTarget::None { size });
        game.run(3);
    }
    for size in [UVec2::ONE, UVec2::new(300, 20), harness::SIZE] {
        let target = harness::target(game.world(), size);
        game.world().entity_mut(camera).insert(target);
        let picture = game.run(4).settled(camera);
        assert_eq!(picture.size, size);
        if size == harness::SIZE {
            assert_eq!(picture.difference(&before).channels, 0);
        }
    }
    assert_shows_shadows(&mut game, camera, &before);
}

#[test]
fn a_camera_that_rests_keeps_nothing_of_what_comes_and_goes() {
    let mut game = harness::game();
    let camera = scene(game.world());
    let before = game.run(5).settled(camera);
    game.world()
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .is_active = false;
    game.run(130);
    let mirrors = game.render_world().resource::<Mirrors>();
    assert!(mirrors.get(camera).is_none(), "its mirror is given up");
    let cube = Cuboid::new(0.5, 0.5, 0.5);
    harness::add_mesh(game.world(), cube, Transform::from_xyz(1.5, 0.5, 0.0));
    game.world()
        .get_mut::<Camera>(camera)
        .expect("a camera")
        .is_active = true;
    let after = game.run(3).settled(camera);
    assert!(after.difference(&before).channels > 100, "the new cube is there");
    assert_shows_shadows(&mut game, camera, &after);
}

/// A material that moves vertices needs bounds that the mesh does not have.
#[test]
fn bounds_that_a_game_gives_count_beside_those_of_the_mesh() {
    use antumbra::scene::WorldBounds;
    use bevy::camera::primitives::Aabb;
    use bevy::camera::visibility::NoAutoAabb;

    let mut game = harness::game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let water = Plane3d::default().mesh().size(4.0, 4.0);
    let water = harness::add_mesh(world, water, Transform::from_xyz(0.0, 1.0, 0.0));
    harness::add_light(world);
    let height = |game: &mut Game| {
        game.run(3);
        let mirrors = game.render_world().resource::<Mirrors>();
        let mirror = mirrors.get(camera).expect("a mirror");
        let object = mirror.get(water).expect("the water is mirrored");
        let bounds = mirror.world.get::<WorldBounds>(object).expect("it has bounds");
        (bounds.0.min.y, bounds.0.max.y)
    };
    assert_eq!(height(&mut game), (1.0, 1.0));
    let waves = Aabb::from_min_max(Vec3::new(-2.0, -0.5, -2.0), Vec3::new(2.0, 0.5, 2.0));
    game.world().entity_mut(water).insert((waves, NoAutoAabb));
    assert_eq!(height(&mut game), (0.5, 1.5));
}
