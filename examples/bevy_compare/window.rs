//! The window: Bevy's shadows on the left and ours on the right, from the same lights.

use antumbra::bevy_adapter::prelude::*;
use bevy::camera::Viewport;
use bevy::pbr::DefaultOpaqueRendererMethod;
use bevy::prelude::*;
use bevy::window::WindowResized;

use crate::game::{Shadows, furnish, lens};
use crate::rooms::Rooms;

/// Half of the window: 0 is the left, 1 the right.
#[derive(Component)]
struct Half(u32);

/// Opens the window.
pub fn run(rooms: &Rooms) {
    let mut app = App::new();
    app.add_plugins((DefaultPlugins, AntumbraPlugin));
    app.insert_resource(ClearColor(Color::BLACK));
    app.insert_resource(DefaultOpaqueRendererMethod::deferred());
    app.insert_resource(GlobalAmbientLight {
        brightness: 20.0,
        ..default()
    });
    let world = app.world_mut();
    for light in furnish(world, rooms, Shadows::Bevy, 9) {
        world.entity_mut(light).insert(StencilVolume::default());
    }
    for (index, name) in ["Bevy's shadow maps", "antumbra"].into_iter().enumerate() {
        let order = index as isize;
        let mut camera = world.spawn((lens(rooms), Half(index as u32)));
        camera.insert(Camera { order, ..default() });
        if index == 1 {
            camera.insert(AntumbraCamera);
        }
        let camera = camera.id();
        world.spawn((
            Text::new(name),
            Node {
                position_type: PositionType::Absolute,
                left: Val::Px(8.0),
                ..default()
            },
            UiTargetCamera(camera),
        ));
    }
    app.add_systems(Update, (fit, turn));
    app.run();
}

fn fit(
    windows: Query<&Window>,
    mut resized: MessageReader<WindowResized>,
    mut cameras: Query<(&Half, &mut Camera)>,
) {
    for message in resized.read() {
        let Ok(window) = windows.get(message.window) else {
            continue;
        };
        let size = window.physical_size();
        let half = UVec2::new(size.x / 2, size.y);
        for (Half(index), mut camera) in &mut cameras {
            camera.viewport = (half.min_element() > 0).then(|| Viewport {
                physical_position: UVec2::new(index * half.x, 0),
                physical_size: half,
                ..default()
            });
        }
    }
}

/// Turns and moves both cameras by the arrow keys.
fn turn(keys: Res<ButtonInput<KeyCode>>, time: Res<Time>, mut cameras: Query<&mut Transform, With<Half>>) {
    let pressed = |key| f32::from(u8::from(keys.pressed(key)));
    let turn = pressed(KeyCode::ArrowLeft) - pressed(KeyCode::ArrowRight);
    let walk = pressed(KeyCode::ArrowUp) - pressed(KeyCode::ArrowDown);
    let step = time.delta_secs();
    for mut transform in &mut cameras {
        transform.rotate_y(turn * step);
        let ahead = transform.forward() * walk * 2.0 * step;
        transform.translation += ahead.with_y(0.0);
    }
}
