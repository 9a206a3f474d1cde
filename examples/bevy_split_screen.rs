//! Two players share a screen: two marked cameras, each with a half of the window, in one scene with three lights.
//!
//! ```sh
//! cargo run --features bevy-window --example bevy_split_screen
//! cargo run --features bevy --example bevy_split_screen -- --headless --out DIR
//! ```
//!
//! The cameras share meshes, materials and pipelines. Each has its own copy of the scene's shadow data, because sets,
//! silhouettes and maps depend on the view.

use antumbra::bevy_adapter::prelude::*;
use bevy::camera::Viewport;
use bevy::prelude::*;

#[path = "support/bevy_headless.rs"]
mod bevy_headless;

/// The player whose half of the window a camera draws: 0 is left, 1 is right.
#[derive(Component)]
struct Player(u32);

fn main() {
    let mut app = bevy_headless::app_of_arguments("bevy_split_screen");
    app.add_plugins(AntumbraPlugin)
        .add_systems(Startup, setup)
        .add_systems(PreUpdate, split)
        .add_systems(Update, walk);
    bevy_headless::run(app);
}

fn setup(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let matte = materials.add(Color::WHITE);
    let floor = meshes.add(Plane3d::default().mesh().size(16.0, 16.0));
    commands.spawn((Mesh3d(floor), MeshMaterial3d(matte.clone())));
    let pillar = meshes.add(Cylinder::new(0.3, 2.0));
    for index in 0..6 {
        let angle = index as f32 / 6.0 * std::f32::consts::TAU;
        let place = Transform::from_xyz(3.0 * angle.cos(), 1.0, 3.0 * angle.sin());
        commands.spawn((Mesh3d(pillar.clone()), MeshMaterial3d(matte.clone()), place));
    }
    // Hard shadows, soft shadows, and a map.
    let lamp = |color: Color, radius: f32| PointLight {
        color,
        radius,
        intensity: 400_000.0,
        ..default()
    };
    let at = |x: f32, z: f32| Transform::from_xyz(x, 2.5, z);
    let (red, green, blue) = (
        Color::srgb(1.0, 0.6, 0.5),
        Color::srgb(0.6, 1.0, 0.6),
        Color::srgb(0.5, 0.7, 1.0),
    );
    commands.spawn((lamp(red, 0.0), StencilVolume::default(), at(0.0, 0.5)));
    commands.spawn((lamp(green, 0.3), PenumbraWedge::default(), at(5.0, 4.0)));
    commands.spawn((lamp(blue, 0.0), OmniMap::default(), at(-5.0, 4.0)));
    for player in 0..2 {
        let side = if player == 0 { -1.0 } else { 1.0 };
        let eyes = Transform::from_xyz(4.0 * side, 2.0, 6.0).looking_at(Vec3::Y * 0.5, Vec3::Y);
        let camera = Camera {
            order: player,
            ..default()
        };
        commands.spawn((
            Camera3d::default(),
            camera,
            Msaa::Off,
            AntumbraCamera,
            Player(player as u32),
            eyes,
        ));
    }
}

/// Gives each camera its half of the window, whatever size that has.
fn split(mut cameras: Query<(&mut Camera, &Player)>) {
    for (mut camera, player) in &mut cameras {
        let Some(size) = camera.physical_target_size() else {
            continue;
        };
        let half = UVec2::new((size.x / 2).max(1), size.y.max(1));
        let wanted = Some((UVec2::new(half.x * player.0, 0), half));
        let known = camera
            .viewport
            .as_ref()
            .map(|viewport| (viewport.physical_position, viewport.physical_size));
        if known != wanted {
            camera.viewport = wanted.map(|(physical_position, physical_size)| Viewport {
                physical_position,
                physical_size,
                ..default()
            });
        }
    }
}

/// The players walk around the middle.
fn walk(time: Res<Time>, mut players: Query<&mut Transform, With<Player>>) {
    for mut eyes in &mut players {
        eyes.rotate_around(Vec3::ZERO, Quat::from_rotation_y(0.2 * time.delta_secs()));
    }
}
