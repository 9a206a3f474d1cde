//! The text on the screen.

use bevy::prelude::*;

use crate::controls::{Chosen, SUBJECTS, Shown};
use crate::lights::{FlameRadius, Technique};

/// Plugin for the text on the screen.
pub struct Figures;

/// Time of a frame, smoothed, milliseconds.
#[derive(Resource, Default)]
struct FrameTime(f32);

#[derive(Component)]
struct Lines;

impl Plugin for Figures {
    fn build(&self, app: &mut App) {
        app.init_resource::<FrameTime>()
            .add_systems(Startup, write)
            .add_systems(PostUpdate, (hide, tell));
    }
}

fn write(mut commands: Commands) {
    let corner = Node {
        position_type: PositionType::Absolute,
        top: Val::Px(8.0),
        left: Val::Px(8.0),
        ..default()
    };
    let small = TextFont {
        font_size: FontSize::Px(14.0),
        ..default()
    };
    commands.spawn((Text::default(), small, corner, Lines));
}

fn hide(keys: Res<ButtonInput<KeyCode>>, mut lines: Query<&mut Visibility, With<Lines>>) {
    if keys.just_pressed(KeyCode::KeyH) {
        for mut visibility in &mut lines {
            visibility.toggle_visible_hidden();
        }
    }
}

/// Help for the keys and the mouse.
const HELP: &str = "W A S D Q E, Shift, right mouse button: fly\n\
                    click, Tab, Backspace: choose lights    [ ]: size of flames\n\
                    G: gizmos    P: stop and go    F12: screenshot    H: hide this text";

fn tell(
    time: Res<Time<Real>>,
    (chosen, shown, radius): (Res<Chosen>, Res<Shown>, Res<FlameRadius>),
    mut frame: ResMut<FrameTime>,
    lights: Query<(Entity, &Technique)>,
    mut lines: Query<&mut Text, With<Lines>>,
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
        Some((light, technique)) => format!("light {light}, {}", technique.name()),
        None => "all lights".to_owned(),
    };
    for mut text in &mut lines {
        text.0 = format!(
            "{:.1} ms, {:.0} frames a second\n{}\nchosen: {chosen}; flames of {:.2} m; gizmos show {}\n{HELP}",
            frame.0,
            1e3 / frame.0.max(1e-3),
            by_technique.join("    "),
            radius.0,
            SUBJECTS[shown.0].0,
        );
    }
}
