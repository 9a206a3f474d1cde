//! Nine rooms of stone with doors between them, pillars, and turning objects.

use bevy::prelude::*;

/// Side of a room, metres.
pub const ROOM: f32 = 8.0;
/// Height of the rooms, metres.
pub const HEIGHT: f32 = 3.2;
const DOOR: f32 = 1.8;
const LINTEL: f32 = 2.3;
const WALL: f32 = 0.4;

/// Makes an object turn about an axis.
#[derive(Component)]
pub struct Turns {
    axis: Vec3,
    /// Speed, radians per second.
    speed: f32,
}

/// Returns the centres of the rooms' floors.
pub fn rooms() -> impl Iterator<Item = Vec3> {
    (0..9).map(|i| Vec3::new((i % 3) as f32 - 1.0, 0.0, (i / 3) as f32 - 1.0) * ROOM)
}

/// Builds everything that casts shadows.
pub fn build(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let mut stone = |color: Color| {
        materials.add(StandardMaterial {
            base_color: color,
            perceptual_roughness: 0.9,
            ..default()
        })
    };
    let (wall, floor) = (
        stone(Color::srgb(0.55, 0.52, 0.48)),
        stone(Color::srgb(0.4, 0.36, 0.33)),
    );
    let (bronze, clay) = (
        stone(Color::srgb(0.7, 0.5, 0.25)),
        stone(Color::srgb(0.65, 0.4, 0.3)),
    );
    let block = meshes.add(Cuboid::default());
    let mut add_block = |center: Vec3, size: Vec3, material: &Handle<StandardMaterial>| {
        let place = Transform::from_translation(center).with_scale(size);
        commands.spawn((Mesh3d(block.clone()), MeshMaterial3d(material.clone()), place));
    };
    let extent = 3.0 * ROOM + WALL;
    for height in [-0.5 * WALL, HEIGHT + 0.5 * WALL] {
        add_block(Vec3::Y * height, Vec3::new(extent, WALL, extent), &floor);
    }
    // Walls run along x and along z. Inner walls have a door into each room.
    for line in 0..4 {
        for room in 0..3 {
            let across = (line as f32 - 1.5) * ROOM;
            let along = (room as f32 - 1.0) * ROOM;
            for turned in [false, true] {
                let place = |along: f32, height: f32| match turned {
                    false => Vec3::new(along, height, across),
                    true => Vec3::new(across, height, along),
                };
                let size = |length: f32, height: f32| match turned {
                    false => Vec3::new(length, height, WALL),
                    true => Vec3::new(WALL, height, length),
                };
                if line == 0 || line == 3 {
                    add_block(place(along, 0.5 * HEIGHT), size(ROOM, HEIGHT), &wall);
                    continue;
                }
                let side = 0.5 * (ROOM - DOOR);
                for sign in [-1.0, 1.0] {
                    let middle = along + sign * 0.5 * (DOOR + side);
                    add_block(place(middle, 0.5 * HEIGHT), size(side, HEIGHT), &wall);
                }
                let above = HEIGHT - LINTEL;
                add_block(place(along, LINTEL + 0.5 * above), size(DOOR, above), &wall);
            }
        }
    }
    let pillar = meshes.add(Cylinder::new(0.25, HEIGHT));
    let shapes = [
        meshes.add(Torus::new(0.35, 0.55)),
        meshes.add(Cuboid::new(0.7, 0.7, 0.7)),
        meshes.add(
            Sphere::new(0.4)
                .mesh()
                .ico(3)
                .expect("80 · 4³ triangles can be indexed"),
        ),
    ];
    for (index, middle) in rooms().enumerate() {
        for (x, z) in [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)] {
            let foot = middle + Vec3::new(x, 0.0, z) * 2.2;
            let place = Transform::from_translation(foot + Vec3::Y * 0.5 * HEIGHT);
            commands.spawn((Mesh3d(pillar.clone()), MeshMaterial3d(wall.clone()), place));
        }
        let axis = Vec3::new(0.3, 1.0, 0.2 * index as f32).normalize();
        let material = if index % 2 == 0 { &bronze } else { &clay };
        commands.spawn((
            Mesh3d(shapes[index % 3].clone()),
            MeshMaterial3d(material.clone()),
            Transform::from_translation(middle + Vec3::Y * 1.2),
            Turns {
                axis,
                speed: 0.4 + 0.1 * index as f32,
            },
        ));
    }
}

/// Turns the turning objects.
pub fn turn(time: Res<Time>, mut things: Query<(&Turns, &mut Transform)>) {
    for (turns, mut place) in &mut things {
        place.rotate(Quat::from_axis_angle(turns.axis, turns.speed * time.delta_secs()));
    }
}
