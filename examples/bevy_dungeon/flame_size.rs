//! The size of flames, with a bar to drag.

use bevy::prelude::*;
use bevy::window::PrimaryWindow;

use crate::lights::{FlameRadius, Technique};

/// Plugin for the size of flames.
pub struct FlameSizes;

/// Largest radius of a flame, metres.
const LARGEST: f32 = 0.5;

/// Size of the bar, and its distance from the lower left corner of the window, logical pixels.
const BAR: Vec2 = Vec2::new(240.0, 14.0);
const MARGIN: f32 = 12.0;

#[derive(Component)]
struct Filled;

impl Plugin for FlameSizes {
    fn build(&self, app: &mut App) {
        app.add_systems(Startup, draw_bar)
            .add_systems(Update, (drag, press, fill, apply).chain());
    }
}

fn draw_bar(mut commands: Commands) {
    let bar = Node {
        position_type: PositionType::Absolute,
        left: Val::Px(MARGIN),
        bottom: Val::Px(MARGIN),
        width: Val::Px(BAR.x),
        height: Val::Px(BAR.y),
        ..default()
    };
    let filled = Node {
        height: Val::Percent(100.0),
        ..default()
    };
    let (dark, light) = (Color::srgba(0.1, 0.1, 0.1, 0.7), Color::srgb(1.0, 0.7, 0.35));
    commands
        .spawn((bar, BackgroundColor(dark)))
        .with_child((filled, BackgroundColor(light), Filled));
}

/// Whether a place in a window is on the bar.
pub fn is_on_bar(window: &Window, cursor: Vec2) -> bool {
    let corner = Vec2::new(MARGIN, window.height() - MARGIN - BAR.y);
    (cursor - corner).cmpge(Vec2::ZERO).all() && (cursor - corner).cmple(BAR).all()
}

fn drag(
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window, With<PrimaryWindow>>,
    mut radius: ResMut<FlameRadius>,
    mut holds: Local<bool>,
) {
    let Some((window, cursor)) = windows
        .single()
        .ok()
        .and_then(|window| Some((window, window.cursor_position()?)))
    else {
        return;
    };
    if buttons.just_pressed(MouseButton::Left) {
        *holds = is_on_bar(window, cursor);
    }
    if *holds && buttons.pressed(MouseButton::Left) {
        radius.set_if_neq(FlameRadius(
            ((cursor.x - MARGIN) / BAR.x).clamp(0.0, 1.0) * LARGEST,
        ));
    }
}

fn press(time: Res<Time>, keys: Res<ButtonInput<KeyCode>>, mut radius: ResMut<FlameRadius>) {
    let pressed = |key| f32::from(u8::from(keys.pressed(key)));
    let change = pressed(KeyCode::BracketRight) - pressed(KeyCode::BracketLeft);
    let wanted = (radius.0 + 0.2 * change * time.delta_secs()).clamp(0.0, LARGEST);
    radius.set_if_neq(FlameRadius(wanted));
}

fn fill(radius: Res<FlameRadius>, mut filled: Query<&mut Node, With<Filled>>) {
    for mut node in &mut filled {
        node.width = Val::Percent(100.0 * radius.0 / LARGEST);
    }
}

fn apply(radius: Res<FlameRadius>, mut lights: Query<(&Technique, &mut PointLight)>) {
    if !radius.is_changed() {
        return;
    }
    for (technique, mut light) in &mut lights {
        if technique.has_flame() {
            light.radius = radius.0;
        }
    }
}
