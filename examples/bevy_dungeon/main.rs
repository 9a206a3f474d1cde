//! A dungeon to walk through: nine rooms, flickering torches, a wandering wisp and turning objects. Keys change the
//! shadow technique of each light.
//!
//! ```sh
//! cargo run --release --features bevy-window --example bevy_dungeon
//! cargo run --features bevy --example bevy_dungeon -- --headless --out DIR
//! ```
//!
//! | key | action |
//! | --- | --- |
//! | W A S D, Q E | walk, sink and rise; three times as fast with Shift |
//! | arrows, or the mouse with its right button down | look around |
//! | click on a flame, Tab, Backspace | choose this light, the next one, or all of them |
//! | 1 to 9 | the technique of the chosen lights; the text on the screen lists them |
//! | the bar, or [ and ] | the size of flames, from 0 to 0.5 m |
//! | G | show the next of the sets, silhouettes, hulls … as gizmos, or none |
//! | P | stop and go |
//! | F12 | save a screenshot to `bevy_dungeon_N.png` |
//! | H | hide and show the text |

#[cfg(feature = "bevy-window")]
mod controls;
#[cfg(feature = "bevy-window")]
mod figures;
#[cfg(feature = "bevy-window")]
mod flame_size;
mod lights;
mod rooms;

#[path = "../support/bevy_headless.rs"]
mod bevy_headless;

use antumbra::bevy_adapter::prelude::*;
use bevy::prelude::*;

/// Whether lights and objects move.
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
        .init_resource::<lights::FlameRadius>()
        .add_systems(Startup, (rooms::build, lights::hang, enter))
        .add_systems(
            Update,
            (rooms::turn, lights::flicker, lights::wander).run_if(|moving: Res<Moving>| moving.0),
        );
    #[cfg(feature = "bevy-window")]
    app.add_plugins((
        AntumbraGizmosPlugin,
        controls::Controls,
        figures::Figures,
        flame_size::FlameSizes,
    ));
    bevy_headless::run(app);
}

/// Spawns the visitor's camera.
fn enter(mut commands: Commands) {
    let eyes = Transform::from_xyz(-3.3, 1.7, 1.2).looking_at(Vec3::new(0.6, 1.0, -0.6), Vec3::Y);
    commands.spawn((Camera3d::default(), Msaa::Off, AntumbraCamera, eyes));
}
