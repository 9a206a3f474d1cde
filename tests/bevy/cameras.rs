//! Cameras with and without the marker, beside each other and one after the other: nobody quits, cameras without it are
//! Bevy's to the bit, and the log has the lines that are wanted and no other.

use bevy::app::TaskPoolPlugin;
use bevy::camera::{Hdr, RenderTarget, Viewport};
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::material::OpaqueRendererMethod;
use bevy::pbr::ExtendedMaterial;
use bevy::prelude::*;
use bevy::render::render_resource::{BufferDescriptor, BufferUsages};
use bevy::render::renderer::RenderDevice;
use bevy::transform::TransformPlugin;

use antumbra::bevy_adapter::prelude::*;

use crate::harness::{self, Game, Picture};
use crate::setup::warnings;
use crate::stripes::{self, ForwardStripes, Stripes};

const SIZE: UVec2 = UVec2::new(96, 64);

/// On the floor, in the shadow of a cube.
const SHADOWED: Vec3 = Vec3::new(-2.0, 0.0, 1.0);
/// On an alpha-masked patch, in the shadow of another cube.
const SHADOWED_MASK: Vec3 = Vec3::new(2.6, 0.02, 0.9);
/// Centres of the tops of two striped boxes.
const STRIPED_FORWARD: Vec3 = Vec3::new(-0.8, 0.8, 2.5);
const STRIPED_BOTH: Vec3 = Vec3::new(0.8, 0.8, 2.5);

/// Materials of every way to be drawn, and a light without a technique, which is given back.
fn scene(app: &mut App) -> Entity {
    stripes::add(app);
    let world = app.world_mut();
    let mut material = |change: fn(&mut StandardMaterial)| {
        let mut material = StandardMaterial::default();
        change(&mut material);
        world.resource_mut::<Assets<StandardMaterial>>().add(material)
    };
    let auto = material(|_| ());
    let forward = material(|material| material.opaque_render_method = OpaqueRendererMethod::Forward);
    let deferred = material(|material| material.opaque_render_method = OpaqueRendererMethod::Deferred);
    let masked = material(|material| material.alpha_mode = AlphaMode::Mask(0.5));
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let floor = meshes.add(Plane3d::default().mesh().size(10.0, 10.0));
    let patch = meshes.add(Plane3d::default().mesh().size(0.6, 0.6));
    let cube = meshes.add(Cuboid::new(1.0, 1.0, 1.0));
    let low = meshes.add(Cuboid::new(0.8, 0.8, 0.8));
    let mut add = |mesh: &Handle<Mesh>, material: &Handle<StandardMaterial>, place: Vec3| {
        let place = Transform::from_translation(place);
        world.spawn((Mesh3d(mesh.clone()), MeshMaterial3d(material.clone()), place));
    };
    add(&floor, &auto, Vec3::ZERO);
    add(&cube, &auto, Vec3::new(-2.0, 0.5, 0.0));
    add(&cube, &auto, Vec3::new(2.0, 0.5, 0.0));
    add(&patch, &masked, SHADOWED_MASK);
    add(&low, &forward, Vec3::new(0.0, 0.4, -1.0));
    add(&low, &deferred, Vec3::new(1.0, 0.4, -2.0));
    let half = Vec3::Y * 0.4;
    let striped = world
        .resource_mut::<Assets<ExtendedMaterial<StandardMaterial, ForwardStripes>>>()
        .add(stripes::forward());
    world.spawn((
        Name::new("striped forward"),
        Mesh3d(low.clone()),
        MeshMaterial3d(striped),
        Transform::from_translation(STRIPED_FORWARD - half),
    ));
    let striped = world
        .resource_mut::<Assets<ExtendedMaterial<StandardMaterial, Stripes>>>()
        .add(stripes::both());
    world.spawn((
        Name::new("striped both"),
        Mesh3d(low),
        MeshMaterial3d(striped),
        Transform::from_translation(STRIPED_BOTH - half),
    ));
    let light = PointLight {
        intensity: 1_000_000.0,
        ..default()
    };
    world.spawn((light, Transform::from_xyz(-2.0, 5.0, -3.0))).id()
}

fn camera(world: &mut World, name: &'static str, msaa: Msaa) -> Entity {
    let target = harness::target(world, SIZE);
    world
        .spawn((
            (Name::new(name), Camera3d::default(), Hdr, msaa, Tonemapping::None),
            target,
            Transform::from_xyz(0.0, 6.0, 8.0).looking_at(Vec3::ZERO, Vec3::Y),
        ))
        .id()
}

/// A camera that shares the target of another, at its left or right.
fn half(world: &mut World, name: &'static str, target: &RenderTarget, right: bool) -> Entity {
    let camera = camera(world, name, Msaa::Sample4);
    let size = UVec2::new(SIZE.x / 2, SIZE.y);
    world.entity_mut(camera).insert((
        target.clone(),
        Camera {
            order: isize::from(right),
            viewport: Some(Viewport {
                physical_position: UVec2::new(if right { size.x } else { 0 }, 0),
                physical_size: size,
                ..default()
            }),
            ..default()
        },
    ));
    camera
}

/// What a camera with a viewport at the right drew there.
fn right_half(picture: &Picture) -> Vec<[half::f16; 3]> {
    let rows = picture.texels.chunks(SIZE.x as usize);
    rows.flat_map(|row| &row[SIZE.x as usize / 2..])
        .copied()
        .collect()
}

/// What a camera sees of a point.
fn texel(game: &mut Game, camera: Entity, picture: &Picture, point: Vec3) -> [f32; 3] {
    let world = game.world();
    let place = *world.get::<GlobalTransform>(camera).unwrap();
    let at = world
        .get::<Camera>(camera)
        .unwrap()
        .world_to_viewport(&place, point);
    let at = at.expect("it is in view").as_uvec2();
    picture.texels[(at.y * SIZE.x + at.x) as usize].map(f32::from)
}

/// Lines of the log that name an entity.
fn lines(name: &str) -> Vec<String> {
    warnings(&format!("`{name}`"))
}

/// The log names an entity so often, each time with one of these words.
fn assert_lines(name: &str, words: &[&str]) {
    let lines = lines(name);
    assert_eq!(lines.len(), words.len(), "{name}: {lines:#?}");
    for (line, word) in lines.iter().zip(words) {
        assert!(line.contains(word), "{name}: {line}");
    }
}

const UNMARKED: &str = "insert `AntumbraCamera`";
const MSAA: &str = "AntumbraCamera switched 4x MSAA off";
const PREPASS: &str = "keeps its `DepthPrepass`";

/// The pictures that cameras of Bevy's own see: with MSAA, without, and the right half of a shared target.
fn of_bevy() -> [Picture; 3] {
    let mut app = harness::headless();
    let light = scene(&mut app);
    let world = app.world_mut();
    world.entity_mut(light).insert(StencilVolume::default());
    let with = camera(world, "bevy 4x", Msaa::Sample4);
    let without = camera(world, "bevy off", Msaa::Off);
    let target = harness::target(world, SIZE);
    half(world, "bevy left", &target, false);
    let right = half(world, "bevy right", &target, true);
    let mut game = Game::start(app);
    game.run(3);
    game.all_settled([with, without, right])
}

#[test]
fn the_marker_comes_and_goes_and_other_cameras_are_bevys() {
    // Ours before Bevy's.
    let mut app = harness::antumbra_first(|_| ());
    let light = scene(&mut app);
    let world = app.world_mut();
    let with = camera(world, "unmarked 4x", Msaa::Sample4);
    let without = camera(world, "unmarked off", Msaa::Off);
    let spawned = camera(world, "marked at spawn", Msaa::Sample4);
    world.entity_mut(spawned).insert(AntumbraCamera);
    let late = camera(world, "marked late", Msaa::Sample4);
    let target = harness::target(world, SIZE);
    let left = half(world, "left", &target, false);
    world.entity_mut(left).insert(AntumbraCamera);
    let right = half(world, "right", &target, true);
    let mut game = Game::start(app);

    // No light is managed: nothing is missed.
    game.run(2);
    for name in ["unmarked 4x", "unmarked off", "marked late", "right"] {
        assert_lines(name, &[]);
    }
    game.world().entity_mut(light).insert(StencilVolume::default());
    game.run(2);
    let first = game.radiance(spawned);
    let bevy = of_bevy();

    // Cameras of Bevy's see what they see without us.
    let [of_with, of_without, of_late, of_right, marked] =
        game.all_settled([with, without, late, right, spawned]);
    for (picture, bevy) in [(of_with, &bevy[0]), (of_without, &bevy[1]), (of_late, &bevy[0])] {
        assert_eq!(picture.difference(bevy).channels, 0);
    }
    assert!(
        right_half(&of_right) == right_half(&bevy[2]),
        "the right half is not Bevy's"
    );
    // Ours have shadows from the second frame on, on what is masked too.
    for picture in [&first, &marked] {
        for point in [SHADOWED, SHADOWED_MASK] {
            let lit = texel(&mut game, spawned, &bevy[1], point)[1];
            let seen = texel(&mut game, spawned, picture, point)[1];
            assert!(seen < 0.3 * lit, "{point}: {seen} of {lit}");
        }
    }
    // What has no deferred shader keeps its look to the bit, what has one keeps its stripes.
    let mut stripes = Vec::new();
    for x in [-0.3, -0.15, 0.0, 0.15, 0.3] {
        let forward = STRIPED_FORWARD + Vec3::X * x;
        let ours = texel(&mut game, spawned, &marked, forward);
        assert_eq!(ours, texel(&mut game, spawned, &bevy[1], forward));
        let both = STRIPED_BOTH + Vec3::X * x;
        let ours = texel(&mut game, spawned, &marked, both);
        let bevys = texel(&mut game, spawned, &bevy[1], both);
        for (ours, bevys) in ours.iter().zip(bevys) {
            assert!((ours - bevys).abs() <= 0.1 * bevys + 0.01, "{ours} for {bevys}");
        }
        stripes.push(ours[0] > ours[1]);
    }
    assert!(stripes.contains(&true) && stripes.contains(&false), "no stripes");
    // It shows our shadows too, so nothing is missed.
    assert_lines("striped forward", &[]);
    assert_lines("striped both", &[]);

    // Marked late: the second frame is as one that was marked from the start.
    game.world().entity_mut(late).insert(AntumbraCamera);
    game.run(2);
    assert_eq!(game.radiance(late).difference(&marked).channels, 0);
    // Unmarked: Bevy's again; a prepass and the like are gone.
    game.world().entity_mut(spawned).remove::<AntumbraCamera>();
    game.run(1);
    assert_eq!(game.settled(spawned).difference(&bevy[0]).channels, 0);
    let camera = game.world().entity(spawned);
    assert!(!camera.contains::<DepthPrepass>() && !camera.contains::<DeferredPrepass>());
    assert!(camera.contains::<Hdr>(), "it had that before");
    // And marked again, and one that never had MSAA.
    for camera in [spawned, without] {
        game.world().entity_mut(camera).insert(AntumbraCamera);
    }
    game.run(2);
    for picture in game.all_settled([spawned, without]) {
        assert_eq!(picture.difference(&marked).channels, 0);
    }
    // In and out within a frame.
    let mut camera = game.world().entity_mut(spawned);
    camera.remove::<AntumbraCamera>().insert(AntumbraCamera);
    game.run(2);
    assert_eq!(game.settled(spawned).difference(&marked).channels, 0);

    // What shadows are computed from cannot be taken, and MSAA cannot be set.
    game.world().entity_mut(late).remove::<DeferredPrepass>();
    game.run(1);
    game.world().entity_mut(late).remove::<DepthPrepass>();
    game.run(1);
    game.world()
        .entity_mut(without)
        .remove::<(DepthPrepass, DeferredPrepass)>();
    game.world().entity_mut(without).insert(Msaa::Sample4);
    game.run(2);
    for picture in game.all_settled([late, without]) {
        assert_eq!(picture.difference(&marked).channels, 0);
    }
    for camera in [late, without] {
        assert_eq!(game.world().get::<Msaa>(camera), Some(&Msaa::Off));
    }
    // With the marker they go.
    game.world()
        .entity_mut(late)
        .remove::<(AntumbraCamera, DepthPrepass, DeferredPrepass)>();
    game.run(2);
    assert_eq!(game.settled(late).difference(&bevy[0]).channels, 0);
    game.world().entity_mut(left).despawn();
    game.run(2);

    assert_lines("unmarked 4x", &[UNMARKED]);
    assert_lines("unmarked off", &[UNMARKED, PREPASS, MSAA]);
    assert_lines("marked at spawn", &[MSAA, UNMARKED]);
    assert_lines("marked late", &[UNMARKED, MSAA, PREPASS]);
    assert_lines("left", &[MSAA]);
    assert_lines("right", &[UNMARKED]);
}

#[test]
#[should_panic(expected = "Validation")]
fn an_error_of_validation_fails_a_test() {
    let mut game = Game::start(harness::headless());
    game.run(1);
    let device = game.render_world().resource::<RenderDevice>().clone();
    device.create_buffer(&BufferDescriptor {
        label: Some("for nothing"),
        size: 16,
        usage: BufferUsages::empty(),
        mapped_at_creation: false,
    });
    game.run(1);
}

#[test]
fn without_a_renderer_transforms_are_propagated_whatever_the_order() {
    let propagates = |mut app: App| {
        app.finish();
        app.cleanup();
        let parent = app.world_mut().spawn(Transform::from_xyz(1.0, 0.0, 0.0)).id();
        let child = app
            .world_mut()
            .spawn((Transform::from_xyz(0.0, 2.0, 0.0), ChildOf(parent)))
            .id();
        app.update();
        app.world_mut()
            .get_mut::<Transform>(parent)
            .unwrap()
            .translation
            .z = 3.0;
        app.update();
        let place = app.world().get::<GlobalTransform>(child).unwrap().translation();
        assert_eq!(place, Vec3::new(1.0, 2.0, 3.0));
    };
    let mut app = App::new();
    app.add_plugins((AntumbraPlugin, TaskPoolPlugin::default(), TransformPlugin));
    propagates(app);
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), TransformPlugin, AntumbraPlugin));
    propagates(app);
    let mut app = App::new();
    app.add_plugins((TaskPoolPlugin::default(), AntumbraPlugin));
    propagates(app);
}
