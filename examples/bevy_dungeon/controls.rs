//! The flying camera, and the keys.

use antumbra::bevy_adapter::prelude::*;
use bevy::input::mouse::AccumulatedMouseMotion;
use bevy::prelude::*;
use bevy::render::view::screenshot::{Screenshot, save_to_disk};
use bevy::window::PrimaryWindow;

use crate::Moving;
use crate::flame_size;
use crate::lights::{FlameRadius, Technique};

/// Plugin for the camera, and for the keys that change lights.
pub struct Controls;

/// The light that keys change; `None` means all lights.
#[derive(Resource, Default)]
pub struct Chosen(pub Option<Entity>);

/// Index in [`SUBJECTS`] of the subject that the gizmos show.
#[derive(Resource, Default)]
pub struct Shown(pub usize);

impl Plugin for Controls {
    fn build(&self, app: &mut App) {
        app.init_resource::<Chosen>()
            .init_resource::<Shown>()
            .add_systems(
                Update,
                (fly, (choose, pick, change).chain(), stop, show, take_screenshot),
            );
    }
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

/// Keys of the techniques, in the order of [`Technique::all`].
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
    radius: Res<FlameRadius>,
    mut lights: Query<(Entity, &mut PointLight), With<Technique>>,
) {
    for (key, technique) in KEYS.into_iter().zip(Technique::all()) {
        if !keys.just_pressed(key) {
            continue;
        }
        for (light, mut point) in &mut lights {
            if chosen.0.is_none_or(|chosen| chosen == light) {
                technique.give(&mut commands.entity(light), &mut point, *radius);
            }
        }
    }
}

fn stop(keys: Res<ButtonInput<KeyCode>>, mut moving: ResMut<Moving>) {
    if keys.just_pressed(KeyCode::KeyP) {
        moving.0 = !moving.0;
    }
}

/// Distance from a flame within which a click chooses it, metres.
const GRIP: f32 = 0.3;

/// Chooses the flame that is clicked, nearest first. Walls are not looked at.
fn pick(
    buttons: Res<ButtonInput<MouseButton>>,
    windows: Query<&Window, With<PrimaryWindow>>,
    cameras: Query<(&Camera, &GlobalTransform), With<AntumbraCamera>>,
    lights: Query<(Entity, &GlobalTransform), With<Technique>>,
    mut chosen: ResMut<Chosen>,
) {
    let (Ok(window), Ok((camera, eyes))) = (windows.single(), cameras.single()) else {
        return;
    };
    let Some(cursor) = window
        .cursor_position()
        .filter(|cursor| buttons.just_pressed(MouseButton::Left) && !flame_size::is_on_bar(window, *cursor))
    else {
        return;
    };
    let Ok(ray) = camera.viewport_to_world(eyes, cursor) else {
        return;
    };
    let hit = |(light, place): (Entity, &GlobalTransform)| {
        let to_light = place.translation() - ray.origin;
        let depth = to_light.dot(*ray.direction);
        let off = (to_light - *ray.direction * depth).length();
        (depth > 0.0 && off < GRIP).then_some((depth, light))
    };
    let hits = lights.iter().filter_map(hit);
    if let Some((_, light)) = hits.min_by(|a, b| a.0.total_cmp(&b.0)) {
        chosen.0 = Some(light);
    }
}

/// Names of what gizmos can show, each with the switch that turns it on.
pub const SUBJECTS: [(&str, fn(&mut AntumbraGizmos)); 7] = [
    ("nothing", |_| {}),
    ("sets", |gizmos| gizmos.sets = true),
    ("silhouettes", |gizmos| gizmos.silhouettes = true),
    ("reach", |gizmos| gizmos.reach = true),
    ("hulls", |gizmos| gizmos.hulls = true),
    ("regions", |gizmos| gizmos.regions = true),
    ("techniques", |gizmos| gizmos.techniques = true),
];

fn show(
    keys: Res<ButtonInput<KeyCode>>,
    chosen: Res<Chosen>,
    mut shown: ResMut<Shown>,
    mut gizmos: ResMut<GizmoConfigStore>,
) {
    if keys.just_pressed(KeyCode::KeyG) {
        shown.0 = (shown.0 + 1) % SUBJECTS.len();
    }
    let (_, config) = gizmos.config_mut::<AntumbraGizmos>();
    *config = AntumbraGizmos {
        light: chosen.0,
        ..default()
    };
    SUBJECTS[shown.0].1(config);
}

fn take_screenshot(mut commands: Commands, keys: Res<ButtonInput<KeyCode>>, mut taken: Local<u32>) {
    if keys.just_pressed(KeyCode::F12) {
        let file = format!("bevy_dungeon_{}.png", *taken);
        *taken += 1;
        commands
            .spawn(Screenshot::primary_window())
            .observe(save_to_disk(file));
    }
}
