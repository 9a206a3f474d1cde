//! A dungeon to walk through: nine rooms, torches that flicker, a wisp that wanders, things that turn; each light with the
//! shadow technique that one gives it.
//!
//! ```sh
//! cargo run --release --features bevy-window --example bevy_dungeon
//! cargo run --features bevy --example bevy_dungeon -- --headless --out DIR
//! ```
//!
//! | key | |
//! | --- | --- |
//! | W A S D, Q E | walk, sink and rise; with Shift three times as fast |
//! | arrows, or the mouse with its right button down | look around |
//! | Tab, Backspace | choose the next light, or all of them |
//! | 1 2 3 4 0 | stencil volumes, penumbra wedges, omnidirectional maps, Bevy's own maps, no shadows |
//! | P | stop and go |

#[cfg(feature = "bevy-window")]
mod controls;
mod lights;
mod rooms;

#[path = "../support/bevy_headless.rs"]
mod bevy_headless;

use antumbra::bevy_adapter::prelude::*;
use bevy::prelude::*;

/// Whether things move.
#[derive(Resource, Clone, Copy)]
pub struct Moving(pub bool);

fn main() {
    let mut app = bevy_headless::app_of_arguments("bevy_dungeon");
    app.add_plugins(AntumbraPlugin)
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight {
            brightness: 40.0,
            ..default()
        })
        .insert_resource(Moving(true))
        .add_systems(Startup, (rooms::build, lights::hang, enter))
        .add_systems(
            Update,
            (rooms::turn, lights::flicker, lights::wander).run_if(|moving: Res<Moving>| moving.0),
        );
    #[cfg(feature = "bevy-window")]
    app.add_plugins(controls::Controls);
    bevy_headless::run(app);
}

/// The visitor's eyes.
fn enter(mut commands: Commands) {
    let eyes = Transform::from_xyz(-3.3, 1.7, 1.2).looking_at(Vec3::new(0.6, 1.0, -0.6), Vec3::Y);
    commands.spawn((Camera3d::default(), Msaa::Off, AntumbraCamera, eyes));
}
