//! A cookie and a profile on a Bevy light scale what Bevy's own functions give, with a stencil, with a map and with none.

use antumbra::bevy_adapter::prelude::*;
use antumbra::scene::TextureWrap;
use bevy::prelude::*;

use crate::harness::{self, Game, Picture};

/// A floor below a spot light that shines straight down: light's +X is the world's +X.
struct Floor {
    game: Game,
    camera: Entity,
}

fn floor() -> Floor {
    let mut game = harness::dark_game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 5.0, 0.01));
    let floor = Plane3d::default().mesh().size(8.0, 8.0);
    harness::add_mesh(world, floor, Transform::default());
    Floor { game, camera }
}

impl Floor {
    /// Returns what the camera sees of a new light: with no shadow, of volumes, or of a map.
    fn lit_by(&mut self, shadow: usize, textures: impl Bundle) -> Picture {
        let spot = SpotLight {
            intensity: 500_000.0,
            outer_angle: 0.9,
            inner_angle: 0.8,
            ..default()
        };
        let place = Transform::from_xyz(0.0, 3.0, 0.0).looking_to(Vec3::NEG_Y, Vec3::NEG_Z);
        let mut light = self.game.world().spawn((spot, place, textures));
        match shadow {
            0 => {}
            1 => drop(light.insert(StencilVolume::default())),
            _ => drop(light.insert(ShadowMap::default())),
        }
        let light = light.id();
        let picture = self.game.run(4).settled(self.camera);
        self.game.world().despawn(light);
        picture
    }
}

fn image(width: u32, texels: &[Vec3]) -> std::sync::Arc<CookieImage> {
    CookieImage::from_linear("test", width, 1, texels.to_vec()).expect("a picture")
}

/// Radiance of a texel.
fn color(picture: &Picture, x: u32, y: u32) -> Vec3 {
    Vec3::from_array(picture.texels[(y * picture.size.x + x) as usize].map(f32::from))
}

#[test]
fn a_picture_colours_the_light_of_bevy() {
    let share = Vec3::new(0.25, 0.5, 1.0);
    let mut floor = floor();
    let plain = floor.lit_by(1, ());
    let (mut lit, size) = (0, plain.size);
    for shadow in 0..3 {
        let colored = floor.lit_by(shadow, Cookie::new(image(1, &[share])));
        for (x, y) in (0..size.y).flat_map(|y| (0..size.x).map(move |x| (x, y))) {
            let (plain, colored) = (color(&plain, x, y), color(&colored, x, y));
            let expected = plain * share;
            let error = (colored - expected).abs() / expected.max(Vec3::splat(1e-3));
            assert!(
                error.max_element() < 1.0 / 400.0,
                "shadow {shadow} at {x}, {y}: {error}"
            );
            lit += usize::from(plain.max_element() > 0.01);
        }
    }
    assert!(lit > 3 * 1000, "{lit} texels are lit");
}

#[test]
fn a_picture_lies_as_seen_from_the_light() {
    let mut floor = floor();
    let plain = floor.lit_by(1, ());
    let cookie = Cookie {
        size: 0.4,
        wrap: [TextureWrap::Clamp; 2],
        ..Cookie::new(image(2, &[Vec3::X, Vec3::Y]))
    };
    let halves = floor.lit_by(1, cookie);
    let (size, mut lit) = (halves.size, 0);
    for y in 0..size.y {
        // The picture's texels meet below the light, a few pixels wide.
        for x in (0..size.x).filter(|x| x.abs_diff(size.x / 2) > 8) {
            // The camera and the light look down alike, so what is left of one is left of the other.
            let share = if x < size.x / 2 { Vec3::X } else { Vec3::Y };
            let expected = color(&plain, x, y) * share;
            let error = (color(&halves, x, y) - expected).abs().max_element();
            assert!(
                error <= 0.003 * expected.max_element() + 1e-4,
                "at {x}, {y}: {error}"
            );
            lit += usize::from(expected.max_element() > 0.01);
        }
    }
    assert!(lit > 1000, "{lit} texels are lit");
}

#[test]
fn a_profile_dims_the_light_of_bevy_by_direction() {
    let text = "IESNA:LM-63-2002\nTILT=NONE\n1 -1 1 3 1 1 2 0 0 0\n1 1 1\n0 30 90\n0\n100 50 10\n";
    let profile = LightProfile::from_ies(text).expect("the file is read");
    let mut floor = floor();
    let plain = floor.lit_by(2, ());
    let shaped = floor.lit_by(2, profile.clone());
    let below = UVec2::new(plain.size.x / 2, plain.size.y / 2);
    let ratio = |x: u32| color(&shaped, x, below.y).x / color(&plain, x, below.y).x;
    assert!((ratio(below.x) - 1.0).abs() < 0.02, "{}", ratio(below.x));
    // A texel to the side: the camera is 5 m above, its height of view the default 45 degrees.
    let x = below.x + 24;
    let across =
        (x as f32 + 0.5 - below.x as f32) / below.y as f32 * (std::f32::consts::FRAC_PI_8).tan() * 5.0;
    let expected = profile.table().relative(Vec3::new(across, 0.0, -3.0));
    assert!((0.4..0.8).contains(&expected), "{expected}");
    assert!(
        (ratio(x) - expected).abs() < 0.01 * expected,
        "{} is not {expected}",
        ratio(x)
    );
}

#[test]
fn textures_may_come_change_and_go() {
    let mut game = harness::game();
    let world = game.world();
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    harness::add_mesh(
        world,
        Plane3d::default().mesh().size(8.0, 8.0),
        Transform::default(),
    );
    let light = harness::add_light(world);
    let plain = game.run(5).settled(camera);
    let images = [image(1, &[Vec3::X]), image(1, &[Vec3::Y])];
    for channel in [0, 1, 0] {
        game.world()
            .entity_mut(light)
            .insert(Cookie::around(images[channel].clone()));
        let colored = game.run(3).settled(camera);
        let at = color(&colored, colored.size.x / 2, colored.size.y / 2);
        assert!(at[channel] > 2.0 * at[1 - channel], "{at}");
    }
    game.world().entity_mut(light).remove::<Cookie>();
    assert_eq!(game.run(3).settled(camera), plain);
}
