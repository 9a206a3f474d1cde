//! A cube, a floor, and a light with hard shadows, in a game of Bevy's.
//!
//! ```sh
//! cargo run --features bevy-window --example bevy_minimal
//! cargo run --features bevy --example bevy_minimal -- --headless --out DIR
//! ```
//!
//! The second writes `DIR/bevy_minimal.png`.

use antumbra::bevy_adapter::prelude::*;
use bevy::prelude::*;

#[path = "support/bevy_headless.rs"]
pub mod bevy_headless;

// [snippet]
/// Call it before or after `DefaultPlugins` are added.
pub fn game(app: &mut App) {
    app.add_plugins(AntumbraPlugin).add_systems(Startup, setup);
}

/// Spawns the scene: the marker on the camera, a technique on the light.
pub fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let matte = materials.add(Color::WHITE);
    let floor = meshes.add(Plane3d::default().mesh().size(10.0, 10.0));
    let cube = meshes.add(Cuboid::default());
    commands.spawn((Mesh3d(floor), MeshMaterial3d(matte.clone())));
    commands.spawn((
        Mesh3d(cube),
        MeshMaterial3d(matte),
        Transform::from_xyz(0.0, 0.5, 0.0),
    ));
    let light = Transform::from_xyz(2.0, 4.0, 1.0);
    commands.spawn((PointLight::default(), StencilVolume::default(), light));
    let camera = Transform::from_xyz(-2.5, 4.5, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((Camera3d::default(), Msaa::Off, AntumbraCamera, camera));
}
// [/snippet]

fn main() {
    let mut app = bevy_headless::app_of_arguments("bevy_minimal");
    game(&mut app);
    bevy_headless::run(app);
}
