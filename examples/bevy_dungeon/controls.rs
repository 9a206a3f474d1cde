//! A camera that flies, keys, and what the screen says.

use antumbra::bevy_adapter::prelude::*;
use bevy::input::mouse::AccumulatedMouseMotion;
use bevy::prelude::*;

use crate::Moving;
use crate::lights::Technique;

/// What a visitor does.
pub struct Controls;

/// The light that keys change; `None`: all.
#[derive(Resource, Default)]
struct Chosen(Option<Entity>);

/// Milliseconds of a frame, smoothed.
#[derive(Resource, Default)]
struct FrameTime(f32);

#[derive(Component)]
struct Figures;

impl Plugin for Controls {
    fn build(&self, app: &mut App) {
        app.init_resource::<Chosen>()
            .init_resource::<FrameTime>()
            .add_systems(Startup, write)
            .add_systems(Update, (fly, choose, change, stop, tell).chain());
    }
}

fn write(mut commands: Commands) {
    let corner = Node {
        position_type: PositionType::Absolute,
        top: Val::Px(8.0),
        left: Val::Px(8.0),
        ..default()
    };
    commands.spawn((Text::default(), corner, Figures));
}

fn fly(
    time: Res<Time>,
    keys: Res<ButtonInput<KeyCode>>,
    buttons: Res<ButtonInput<MouseButton>>,
    mouse: Res<AccumulatedMouseMotion>,
    mut cameras: Query<&mut Transform, With<AntumbraCamera>>,
) {
    let axis =
        |plus, minus| f32::from(u8::from(keys.pressed(plus))) - f32::from(u8::from(keys.pressed(minus)));
    let step = time.delta_secs();
    let mut look = Vec2::new(
        axis(KeyCode::ArrowLeft, KeyCode::ArrowRight),
        axis(KeyCode::ArrowUp, KeyCode::ArrowDown),
    ) * 1.5
        * step;
    if buttons.pressed(MouseButton::Right) {
        look -= mouse.delta * 0.004;
    }
    let hurry = if keys.pressed(KeyCode::ShiftLeft) {
        3.0
    } else {
        1.0
    };
    for mut eyes in &mut cameras {
        let (yaw, pitch, _) = eyes.rotation.to_euler(EulerRot::YXZ);
        let pitch = (pitch + look.y).clamp(-1.5, 1.5);
        eyes.rotation = Quat::from_euler(EulerRot::YXZ, yaw + look.x, pitch, 0.0);
        let way = eyes.right() * axis(KeyCode::KeyD, KeyCode::KeyA)
            + eyes.forward() * axis(KeyCode::KeyW, KeyCode::KeyS)
            + Vec3::Y * axis(KeyCode::KeyE, KeyCode::KeyQ);
        eyes.translation += way * 2.5 * hurry * step;
    }
}

fn choose(
    keys: Res<ButtonInput<KeyCode>>,
    mut chosen: ResMut<Chosen>,
    lights: Query<Entity, With<Technique>>,
) {
    if keys.just_pressed(KeyCode::Backspace) {
        chosen.0 = None;
    }
    if keys.just_pressed(KeyCode::Tab) {
        let mut all: Vec<Entity> = lights.iter().collect();
        all.sort_unstable();
        let at = all.iter().position(|light| Some(*light) == chosen.0);
        chosen.0 = all.get(at.map_or(0, |at| (at + 1) % all.len())).copied();
    }
}

/// Keys of the techniques, in their order.
const KEYS: [KeyCode; 9] = [
    KeyCode::Digit1,
    KeyCode::Digit2,
    KeyCode::Digit3,
    KeyCode::Digit4,
    KeyCode::Digit5,
    KeyCode::Digit6,
    KeyCode::Digit7,
    KeyCode::Digit8,
    KeyCode::Digit9,
];

fn change(
    mut commands: Commands,
    keys: Res<ButtonInput<KeyCode>>,
    chosen: Res<Chosen>,
    mut lights: Query<(Entity, &mut PointLight), With<Technique>>,
) {
    for (key, technique) in KEYS.into_iter().zip(Technique::all()) {
        if !keys.just_pressed(key) {
            continue;
        }
        for (light, mut point) in &mut lights {
            if chosen.0.is_none_or(|chosen| chosen == light) {
                technique.give(&mut commands.entity(light), &mut point);
            }
        }
    }
}

fn stop(keys: Res<ButtonInput<KeyCode>>, mut moving: ResMut<Moving>) {
    if keys.just_pressed(KeyCode::KeyP) {
        moving.0 = !moving.0;
    }
}

fn tell(
    time: Res<Time<Real>>,
    chosen: Res<Chosen>,
    mut frame: ResMut<FrameTime>,
    lights: Query<(Entity, &Technique)>,
    mut figures: Query<&mut Text, With<Figures>>,
) {
    let now = time.delta_secs() * 1e3;
    frame.0 += (now - frame.0) * 0.1;
    let count = |technique| lights.iter().filter(|(_, own)| **own == technique).count();
    let techniques = Technique::all();
    let by_technique = techniques
        .iter()
        .enumerate()
        .map(|(at, &technique)| format!("{} {}: {}", at + 1, technique.name(), count(technique)));
    let by_technique: Vec<String> = by_technique.collect();
    let chosen = match chosen.0.and_then(|light| lights.get(light).ok()) {
        Some((light, technique)) => format!("light {light}: {}", technique.name()),
        None => "all lights".to_owned(),
    };
    for mut text in &mut figures {
        text.0 = format!(
            "{:.1} ms, {:.0} frames a second\n{}\nTab, Backspace: {chosen}",
            frame.0,
            1e3 / frame.0.max(1e-3),
            by_technique.join(", "),
        );
    }
}
