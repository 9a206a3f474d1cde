//! More lights of a kind than Bevy shows: those that it shows have shadows.

use antumbra::bevy_adapter::prelude::*;
use bevy::pbr::{MAX_DIRECTIONAL_LIGHTS, MAX_RECT_LIGHTS};
use bevy::prelude::*;

use crate::harness;

#[test]
fn of_more_lights_than_bevy_shows_none_shines_through_a_lid() {
    let mut game = harness::dark_game();
    for of_suns in [false, true] {
        let world = game.clear().world();
        let camera = harness::marked_camera(world, Vec3::new(0.0, 1.0, 3.0));
        let floor = Plane3d::default().mesh().size(6.0, 6.0);
        harness::add_mesh(world, floor, Transform::default());
        // It is over the floor and the camera.
        let lid = Plane3d::default().mesh().size(60.0, 60.0);
        let lid = harness::add_mesh(world, lid, Transform::from_xyz(0.0, 2.0, 0.0));
        let spawn = |world: &mut World, at: usize| {
            let x = at as f32 * 0.4 - 2.0;
            let place = Transform::from_xyz(x, 4.0, 0.5).looking_at(Vec3::X * (0.5 * x), Vec3::Z);
            let mut light = world.spawn((StencilVolume::default(), place));
            if of_suns {
                light.insert(DirectionalLight {
                    illuminance: 1000.0 + at as f32,
                    ..default()
                });
            } else {
                light.insert(RectLight {
                    intensity: 400_000.0,
                    ..default()
                });
            }
            light.id()
        };
        let shown = if of_suns {
            MAX_DIRECTIONAL_LIGHTS
        } else {
            MAX_RECT_LIGHTS
        };
        let lights: Vec<Entity> = (0..shown + 5).map(|at| spawn(world, at)).collect();
        game.run(3);
        // Some come and go, so that Bevy has them in another order than the game.
        for at in [0, 3, 6] {
            game.world().despawn(lights[at]);
            game.run(1);
            spawn(game.world(), at);
        }
        let brightest = |picture: &harness::Picture| {
            let channels = picture.texels.iter().flatten();
            channels.fold(0.0_f32, |most, &channel| most.max(channel.into()))
        };
        let shadowed = game.run(4).settled(camera);
        shadowed.save(&format!("many_lights_{of_suns}"));
        assert_eq!(brightest(&shadowed), 0.0, "suns: {of_suns}");
        game.world().despawn(lid);
        assert!(brightest(&game.run(4).settled(camera)) > 0.1, "suns: {of_suns}");
    }
}
