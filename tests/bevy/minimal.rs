//! The README's snippet is the example's, and the example runs.

use antumbra::bevy_adapter::prelude::*;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::render_resource::TextureFormat;

use crate::harness::{self, Game};
use crate::setup::warnings;

#[path = "../../examples/bevy_minimal.rs"]
#[allow(dead_code, reason = "its main is for the command line")]
mod example;

const EXAMPLE: &str = include_str!("../../examples/bevy_minimal.rs");
const README: &str = include_str!("../../README.md");

#[test]
fn the_readme_has_the_example_word_for_word() {
    let (_, rest) = EXAMPLE.split_once("// [snippet]\n").expect("a marked snippet");
    let (snippet, _) = rest.split_once("// [/snippet]").expect("its end");
    assert!(snippet.lines().count() < 30);
    assert!(README.contains(snippet), "the README shows something else");
}

#[test]
fn the_example_shows_a_shadow() {
    let picture = |casts: bool| {
        let mut app = harness::headless();
        example::game(&mut app);
        let target = harness::target(app.world_mut(), harness::SIZE);
        let mut game = Game::start(app);
        game.run(1);
        let world = game.world();
        let camera = world
            .query_filtered::<Entity, With<Camera3d>>()
            .single(world)
            .unwrap();
        world.entity_mut(camera).insert((target, Tonemapping::None));
        if !casts {
            let meshes: Vec<Entity> = world
                .query_filtered::<Entity, With<Mesh3d>>()
                .iter(world)
                .collect();
            for mesh in meshes {
                world.entity_mut(mesh).insert(bevy::light::NotShadowCaster);
            }
        }
        game.run(6).settled(camera)
    };
    let (shadowed, lit) = (picture(true), picture(false));
    shadowed.save("minimal");
    let darker = shadowed
        .texels
        .iter()
        .zip(&lit.texels)
        .filter(|(a, b)| f32::from(a[1]) < 0.5 * f32::from(b[1]));
    let darker = darker.count();
    println!("{darker} pixels in shadow");
    assert!(darker > 50 && darker < 1000, "{darker}");
}

#[test]
fn without_the_marker_the_example_looks_as_bevy_does_and_says_what_is_missing() {
    let picture = |ours: bool| {
        let mut app = harness::headless();
        if ours {
            example::game(&mut app);
        } else {
            app.add_systems(Startup, example::setup);
        }
        let target = harness::target(app.world_mut(), UVec2::new(64, 36));
        let unmark = move |mut commands: Commands, cameras: Query<Entity, With<Camera3d>>| {
            for camera in &cameras {
                let mut camera = commands.entity(camera);
                camera.remove::<AntumbraCamera>();
                // With the multisampling of Bevy's default.
                camera.insert((
                    Name::new(if ours { "forgotten" } else { "bevy" }),
                    Msaa::default(),
                ));
                camera.insert((target.clone(), Tonemapping::AcesFitted));
            }
        };
        app.add_systems(PostStartup, unmark);
        let mut game = Game::start(app);
        game.run(12);
        let world = game.world();
        let camera = world
            .query_filtered::<Entity, With<Camera3d>>()
            .single(world)
            .unwrap();
        harness::frames::texels(&mut game.apps, camera)
    };
    let (ours, bevys) = (picture(true), picture(false));
    assert_eq!(ours.1, TextureFormat::Rgba8UnormSrgb);
    assert!(ours.2.iter().any(|&byte| byte != ours.2[0]), "nothing is seen");
    assert!(ours == bevys, "it does not look as Bevy does");
    let lines = warnings("`forgotten`");
    assert_eq!(lines.len(), 1, "{lines:?}");
    assert!(lines[0].contains("insert `AntumbraCamera`"));
    assert!(warnings("`bevy`").is_empty());
}

#[test]
fn the_example_draws_with_its_render_world_on_another_thread() {
    crate::setup::listen(); // before Bevy's logger does
    let folder = std::env::temp_dir().join(format!("antumbra_bevy_minimal_{}", std::process::id()));
    let file = folder.join("bevy_minimal.png");
    let mut app = example::bevy_headless::headless(file.clone());
    assert!(app.is_plugin_added::<bevy::render::pipelined_rendering::PipelinedRenderingPlugin>());
    example::game(&mut app);
    app.add_plugins(bevy::app::ScheduleRunnerPlugin::default());
    assert_eq!(app.run(), AppExit::Success);
    let picture = image::open(&file).expect("a picture").into_rgb8();
    let bright = picture.pixels().filter(|pixel| pixel.0[1] > 60).count();
    println!(
        "{} of {} pixels are bright",
        bright,
        picture.width() * picture.height()
    );
    assert!(bright > 5000);
    std::fs::remove_dir_all(&folder).expect("it can be removed");
}
