//! What a camera does not draw casts nothing and hides no near cap: levels of detail out of range, materials whose
//! textures are not loaded, surfaces that are wholly transparent. Meshes that a negative scale turns show their backs.

use antumbra::bevy_adapter::Mirrors;
use antumbra::scene::ShadowCaster;
use antumbra::sets::OcclusionSettings;
use antumbra::silhouettes::LightClearance;
use antumbra::techniques::maps::MapSettings;
use bevy::asset::RenderAssetUsages;
use bevy::camera::visibility::VisibilityRange;
use bevy::prelude::*;
use bevy::render::render_resource::{Extent3d, TextureDimension, TextureFormat};

use crate::harness::{self, Game};

/// A dark game with the scene of [`furnish`].
fn room() -> (Game, Entity) {
    let mut game = harness::dark_game();
    let camera = furnish(game.world());
    (game, camera)
}

/// A floor, a light at the side, and a camera that sees both shadow and caster.
fn furnish(world: &mut World) -> Entity {
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let floor = Plane3d::default().mesh().size(12.0, 12.0);
    harness::add_mesh(world, floor, Transform::default());
    harness::add_light(world);
    camera
}

fn add_material(world: &mut World, material: StandardMaterial) -> MeshMaterial3d<StandardMaterial> {
    let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
    MeshMaterial3d(materials.add(material))
}

#[test]
fn a_level_out_of_range_is_as_if_it_were_not_there() {
    let (mut game, camera) = room();
    let world = game.world();
    let at = Transform::from_xyz(0.0, 1.0, 0.0);
    let fine = harness::add_mesh(world, Sphere::new(0.5), at);
    let coarse = harness::add_mesh(world, Cuboid::new(1.6, 1.2, 1.6), at);
    game.run(3);
    // Each alone, by visibility, near and far.
    let far = Transform::from_xyz(0.0, 6.0, 12.0).looking_at(Vec3::ZERO, Vec3::Y);
    let near = Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut alone = |hidden: Entity, shown: Entity, place: Transform| {
        game.world().entity_mut(hidden).insert(Visibility::Hidden);
        game.world().entity_mut(shown).insert(Visibility::Inherited);
        game.world().entity_mut(camera).insert(place);
        game.run(2).settled(camera)
    };
    let (fine_near, coarse_far) = (alone(coarse, fine, near), alone(fine, coarse, far));
    let both_far = {
        game.world().entity_mut(fine).insert(Visibility::Inherited);
        game.run(2).settled(camera)
    };
    // As levels of detail they take turns while the camera comes and goes.
    let levels = [
        (fine, VisibilityRange::abrupt(0.0, 10.0)),
        (coarse, VisibilityRange::abrupt(10.0, 50.0)),
    ];
    for (level, range) in levels.clone() {
        game.world()
            .entity_mut(level)
            .insert((range, Visibility::Inherited));
    }
    for (place, alone) in [
        (near, &fine_near),
        (far, &coarse_far),
        (near, &fine_near),
        (far, &coarse_far),
    ] {
        game.world().entity_mut(camera).insert(place);
        let picture = game.run(2).settled(camera);
        picture.save("levels");
        assert_eq!(picture.difference(alone).channels, 0);
    }
    // Without the ranges both are there again.
    for (level, _) in levels {
        game.world().entity_mut(level).remove::<VisibilityRange>();
    }
    assert_eq!(game.run(2).settled(camera).difference(&both_far).channels, 0);
    assert!(
        both_far.difference(&coarse_far).channels == 0,
        "the cube hides the ball"
    );
    assert!(fine_near.difference(&coarse_far).channels > 1000);
}

#[test]
fn meshes_that_a_scale_turns_hide_no_near_caps() {
    let (mut game, camera) = room();
    // A mask that cuts nothing: it is drawn alike, and its caps are always drawn.
    let mut draw = |masked: bool, scale: Vec3| {
        let world = game.world();
        let masked = if masked {
            AlphaMode::Mask(0.0)
        } else {
            AlphaMode::Opaque
        };
        let material = add_material(
            world,
            StandardMaterial {
                alpha_mode: masked,
                ..default()
            },
        );
        let at = Transform::from_xyz(0.0, 1.0, 0.0);
        let cube = harness::add_mesh(world, Cuboid::new(1.2, 1.0, 1.2), at);
        world.entity_mut(cube).insert(material);
        game.run(3);
        // The scale changes at runtime.
        game.world().get_mut::<Transform>(cube).unwrap().scale = scale;
        let picture = game.run(2).settled(camera);
        game.world().despawn(cube);
        picture
    };
    for scale in [Vec3::new(-1.0, 1.0, 1.0), Vec3::NEG_ONE] {
        let (opaque, masked) = (draw(false, scale), draw(true, scale));
        opaque.save("turned");
        masked.save("turned_masked");
        assert_eq!(opaque.difference(&masked).channels, 0, "{scale}");
    }
    let plain = draw(false, Vec3::ONE);
    assert!(
        plain.difference(&draw(false, Vec3::NEG_ONE)).channels > 500,
        "backs look other than fronts"
    );
}

#[test]
fn materials_that_draw_nothing_cast_nothing() {
    let (mut game, camera) = room();
    let world = game.world();
    let texture = world.resource::<Assets<Image>>().reserve_handle();
    let unloaded = add_material(
        world,
        StandardMaterial {
            base_color_texture: Some(texture.clone()),
            ..default()
        },
    );
    let clear = add_material(
        world,
        StandardMaterial {
            base_color: Color::WHITE.with_alpha(0.4),
            alpha_mode: AlphaMode::Mask(0.5),
            ..default()
        },
    );
    let empty = game.run(3).settled(camera);
    let world = game.world();
    let at = |x: f32| Transform::from_xyz(x, 1.0, 0.0);
    let cube = harness::add_mesh(world, Cuboid::from_length(1.0), at(-1.0));
    world.entity_mut(cube).insert(unloaded);
    let ghost = harness::add_mesh(world, Cuboid::from_length(1.0), at(1.0));
    world.entity_mut(ghost).insert(clear.clone());
    assert_eq!(game.run(2).settled(camera).difference(&empty).channels, 0);
    // The texture comes, and the ghost gets a body.
    let size = Extent3d::default();
    let usages = RenderAssetUsages::default();
    let format = TextureFormat::Rgba8UnormSrgb;
    let white = Image::new_fill(size, TextureDimension::D2, &[255; 4], format, usages);
    let world = game.world();
    world
        .resource_mut::<Assets<Image>>()
        .insert(texture.id(), white)
        .expect("reserved");
    let loaded = game.run(2).settled(camera);
    let mut materials = game.world().resource_mut::<Assets<StandardMaterial>>();
    materials.get_mut(clear.0.id()).unwrap().base_color.set_alpha(1.0);
    let solid = game.run(2).settled(camera);
    for (now, before) in [(&loaded, &empty), (&solid, &loaded)] {
        let darker = now
            .texels
            .iter()
            .zip(&before.texels)
            .filter(|(now, before)| now[1] < before[1]);
        assert!(darker.count() > 100, "the shadow is missing");
    }
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    let mirror = mirrors.get_mut(camera).unwrap();
    let casters = mirror
        .world
        .query_filtered::<(), With<ShadowCaster>>()
        .iter(&mirror.world)
        .count();
    assert_eq!(casters, 3);
}

#[test]
fn settings_of_the_game_reach_each_camera() {
    let mut app = harness::antumbra();
    let camera = furnish(app.world_mut());
    app.insert_resource(LightClearance(0.001));
    let mut game = Game::start(app);
    game.run(2);
    let clearance = |game: &mut Game, camera: Entity| {
        let mirrors = game.render_world().resource::<Mirrors>();
        mirrors
            .get(camera)
            .expect("a mirror")
            .world
            .resource::<LightClearance>()
            .0
    };
    assert_eq!(clearance(&mut game, camera), 0.001);
    game.world().resource_mut::<LightClearance>().0 = 0.002;
    let late = harness::marked_camera(game.world(), Vec3::new(3.0, 3.0, 3.0));
    game.run(1);
    assert_eq!(
        [camera, late].map(|camera| clearance(&mut game, camera)),
        [0.002; 2]
    );
    game.world().remove_resource::<LightClearance>();
    game.world().insert_resource(MapSettings {
        face_updates: 5,
        ..default()
    });
    game.world().insert_resource(OcclusionSettings {
        from_lights: false,
        ..default()
    });
    game.run(1);
    assert_eq!(clearance(&mut game, camera), LightClearance::default().0);
    let mirrors = game.render_world().resource::<Mirrors>();
    let world = &mirrors.get(camera).unwrap().world;
    assert_eq!(world.resource::<MapSettings>().face_updates, 5);
    assert!(!world.resource::<OcclusionSettings>().from_lights);
}
