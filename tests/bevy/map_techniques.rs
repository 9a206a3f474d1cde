//! Perspective maps with a blurred ground, and smoothies, in a game.

use antumbra::bevy_adapter::prelude::*;
use antumbra::techniques::maps::MapResolution;
use antumbra::techniques::{Smoothie, SmoothieWidth};
use bevy::prelude::*;

use crate::harness::{Game, Picture, add_mesh, dark_game, marked_camera};

/// A plate over a floor under a spot light.
struct Plate {
    game: Game,
    camera: Entity,
    floor: Entity,
    light: Entity,
}

fn plate() -> Plate {
    let mut game = dark_game();
    let world = game.world();
    let camera = marked_camera(world, Vec3::new(0.4, 5.0, 1.2));
    let floor = Plane3d::default().mesh().size(6.0, 6.0);
    let floor = add_mesh(world, floor, Transform::IDENTITY);
    add_mesh(
        world,
        Cuboid::new(1.2, 0.05, 1.0),
        Transform::from_xyz(0.2, 1.0, 0.0),
    );
    let light = SpotLight {
        intensity: 2_000_000.0,
        outer_angle: 0.9,
        inner_angle: 0.8,
        ..default()
    };
    let place = Transform::from_xyz(1.2, 4.0, 0.6).looking_at(Vec3::ZERO, Vec3::Y);
    let light = world.spawn((light, place)).id();
    Plate {
        game,
        camera,
        floor,
        light,
    }
}

impl Plate {
    /// Returns what the camera sees once everything is ready.
    fn picture(&mut self) -> Picture {
        self.game.run(3).settled(self.camera)
    }

    /// Returns what the camera sees after parts were inserted into the light.
    fn with(&mut self, parts: impl Bundle) -> Picture {
        self.game.world().entity_mut(self.light).insert(parts);
        self.picture()
    }
}

/// Numbers of pixels that see none of the light, and of those that see a part.
fn dark_and_soft(shadowed: &Picture, lit: &Picture) -> [usize; 2] {
    let most = lit
        .texels
        .iter()
        .map(|texel| f32::from(texel[1]))
        .fold(0.0, f32::max);
    let mut counts = [0; 2];
    for (a, b) in shadowed.texels.iter().zip(&lit.texels) {
        let (a, b) = (f32::from(a[1]), f32::from(b[1]));
        if b > 0.02 * most {
            counts[0] += usize::from(a < 0.02 * b);
            counts[1] += usize::from((0.1..0.9).contains(&(a / b)));
        }
    }
    counts
}

#[test]
fn perspective_maps_shadow_a_game_and_blur_its_ground() {
    let map = PerspectiveMap {
        resolution: MapResolution::Fixed(512),
        ..default()
    };
    let mut plate = plate();
    let lit = plate.picture();
    let sharp = dark_and_soft(&plate.with(map), &lit);
    // The component may come and go.
    let floor = plate.floor;
    let blur = BlurredGround { radius: 0.15 };
    plate.game.world().entity_mut(floor).insert(blur);
    let blurred = dark_and_soft(&plate.picture(), &lit);
    plate.game.world().entity_mut(floor).remove::<BlurredGround>();
    let again = dark_and_soft(&plate.picture(), &lit);
    println!("dark and soft: {sharp:?}, blurred {blurred:?}, again {again:?}");
    assert!(sharp[0] > 100 && sharp[1] < sharp[0] / 2, "{sharp:?}");
    assert!(blurred[1] > 3 * sharp[1] && blurred[1] > 150, "{blurred:?}");
    assert_eq!(sharp, again);
}

#[test]
fn smoothies_soften_the_shadows_of_a_game_around_the_same_umbra() {
    let resolution = MapResolution::Fixed(512);
    let mut plate = plate();
    let lit = plate.picture();
    let plain = ShadowMap {
        resolution,
        ..default()
    };
    let smoothie = Smoothie {
        resolution,
        width: SmoothieWidth::Metres(0.5),
        ..default()
    };
    let plain = dark_and_soft(&plate.with(plain), &lit);
    let light = plate.light;
    plate.game.world().entity_mut(light).remove::<ShadowMap>();
    let soft = dark_and_soft(&plate.with(smoothie), &lit);
    println!("dark and soft: plain {plain:?}, smoothies {soft:?}");
    assert!(
        plain[0] > 100 && soft[0].abs_diff(plain[0]) < plain[0] / 8,
        "{plain:?} {soft:?}"
    );
    assert!(soft[1] > 2 * plain[1].max(30), "{plain:?} {soft:?}");
}
