//! A skinned character from a glTF file walks around in the light of a lamp, and its shadow follows the skin. Keys change the
//! shadow technique.
//!
//! ```sh
//! cargo run --release --features bevy-window --example bevy_character
//! cargo run --features bevy-window --example bevy_character -- --headless --out DIR
//! ```
//!
//! | key | action |
//! | --- | --- |
//! | 1 to 9 | the technique of the lamp; the text on the screen lists them |
//! | Space | stop and go |
//!
//! Nothing is done for the shadow beside the technique on the light: the scene is spawned by `WorldAssetRoot` (once called
//! `SceneRoot`) and animated by Bevy, and antumbra takes over meshes, joints and morph weights in every frame.

use std::f32::consts::FRAC_PI_2;

use antumbra::bevy_adapter::prelude::*;
use antumbra::techniques::{Row, Techniques};
use bevy::prelude::*;
use bevy::world_serialization::WorldInstanceReady;

#[path = "support/bevy_headless.rs"]
mod bevy_headless;

/// The character: a figure with 17 joints, and its walk.
const FILE: &str = "models/walker.glb";

/// Speed at which the feet of the walk stand still on the ground, metres per second.
const SPEED: f32 = 1.3;

/// Radius of the circle that the character walks on, metres.
const CIRCLE: f32 = 1.3;

/// Radius of the lamp's bulb, metres. It makes shadows soft.
const BULB: f32 = 0.05;

/// Marks the character.
#[derive(Component)]
struct Walker;

/// Marks the light.
#[derive(Component)]
struct Lamp;

/// Marks the text on the screen.
#[derive(Component)]
struct Lines;

/// The animation of the character.
#[derive(Resource)]
struct Walk {
    graph: Handle<AnimationGraph>,
    clip: AnimationNodeIndex,
}

/// The technique of the lamp; `None` is Bevy's shadow map.
#[derive(Resource)]
struct Shadow(Option<Row>);

fn main() {
    let mut app = bevy_headless::app_of_arguments("bevy_character");
    app.add_plugins(AntumbraPlugin)
        .insert_resource(ClearColor(Color::BLACK))
        .insert_resource(GlobalAmbientLight {
            brightness: 60.0,
            ..default()
        })
        .insert_resource(Shadow(choices()[0]))
        .init_resource::<bevy_headless::Loading>()
        .add_systems(Startup, (build, enter))
        .add_systems(Update, (choose, shade, tell).chain())
        .add_systems(Update, (stop, walk, give_up));
    bevy_headless::run(app);
}

/// Returns what the lamp can have: our techniques that fit a point light, then Bevy's shadow map.
fn choices() -> Vec<Option<Row>> {
    let point = antumbra::scene::Light::point(Vec3::ONE, 1.0, 10.0);
    let techniques = Techniques::default();
    let rows = techniques.rows().iter().copied();
    let fitting = rows.filter(|row| row.defaults().check(&point).is_ok());
    fitting.map(Some).chain([None]).collect()
}

/// Spawns the room, the lamp and the camera.
fn build(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let plaster = materials.add(StandardMaterial {
        base_color: Color::srgb(0.8, 0.76, 0.7),
        perceptual_roughness: 0.95,
        ..default()
    });
    let stone = materials.add(StandardMaterial {
        base_color: Color::srgb(0.5, 0.52, 0.56),
        perceptual_roughness: 0.9,
        ..default()
    });
    let floor = meshes.add(Plane3d::default().mesh().size(16.0, 16.0));
    commands.spawn((Mesh3d(floor), MeshMaterial3d(stone.clone())));
    let wall = meshes.add(Cuboid::new(14.0, 4.2, 0.2));
    let back = Transform::from_xyz(0.0, 2.1, -2.6);
    commands.spawn((Mesh3d(wall), MeshMaterial3d(plaster), back));
    let pillar = meshes.add(Cylinder::new(0.16, 2.6));
    for x in [-2.6, 2.6] {
        let place = Transform::from_xyz(x, 1.3, -1.2);
        commands.spawn((Mesh3d(pillar.clone()), MeshMaterial3d(stone.clone()), place));
    }
    // The lamp is inside its own bulb, so the bulb must not cast a shadow.
    let bulb = meshes.add(Sphere::new(BULB));
    let glow = materials.add(StandardMaterial {
        emissive: LinearRgba::rgb(20.0, 14.0, 8.0),
        ..default()
    });
    commands.spawn((
        PointLight {
            color: Color::srgb(1.0, 0.86, 0.68),
            intensity: 260_000.0,
            range: 12.0,
            ..default()
        },
        Lamp,
        Mesh3d(bulb),
        MeshMaterial3d(glow),
        bevy::light::NotShadowCaster,
        Transform::from_xyz(0.9, 0.7, 2.3),
    ));
    let eyes = Transform::from_xyz(-2.4, 1.9, 4.6).looking_at(Vec3::new(-0.1, 0.95, -0.6), Vec3::Y);
    commands.spawn((Camera3d::default(), Msaa::Off, AntumbraCamera, eyes));
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

/// Spawns the character; its animation begins when the file is loaded.
fn enter(mut commands: Commands, files: Res<AssetServer>, mut graphs: ResMut<Assets<AnimationGraph>>) {
    let clip = files.load(GltfAssetLabel::Animation(0).from_asset(FILE));
    let (graph, clip) = AnimationGraph::from_clip(clip);
    commands.insert_resource(Walk {
        graph: graphs.add(graph),
        clip,
    });
    let scene = files.load(GltfAssetLabel::Scene(0).from_asset(FILE));
    commands.spawn((WorldAssetRoot(scene), Walker)).observe(animate);
}

/// Starts the walk of a character whose entities are there.
fn animate(
    ready: On<WorldInstanceReady>,
    mut commands: Commands,
    walk: Res<Walk>,
    children: Query<&Children>,
    mut players: Query<&mut AnimationPlayer>,
) {
    for entity in children.iter_descendants(ready.entity) {
        if let Ok(mut player) = players.get_mut(entity) {
            player.play(walk.clip).repeat();
            commands
                .entity(entity)
                .insert(AnimationGraphHandle(walk.graph.clone()));
        }
    }
    commands.remove_resource::<bevy_headless::Loading>();
}

/// Ends the example if the file cannot be loaded. Bevy has logged why.
fn give_up(
    files: Res<AssetServer>,
    walkers: Query<&WorldAssetRoot, With<Walker>>,
    mut exit: MessageWriter<AppExit>,
) {
    if walkers.iter().any(|scene| files.load_state(&scene.0).is_failed()) {
        exit.write(AppExit::error());
    }
}

/// Moves the character along its circle.
fn walk(time: Res<Time<Virtual>>, mut walkers: Query<&mut Transform, With<Walker>>) {
    let (sin, cos) = (time.elapsed_secs_wrapped() * SPEED / CIRCLE).sin_cos();
    for mut place in &mut walkers {
        let angle = sin.atan2(cos);
        place.translation = Vec3::new(CIRCLE * sin, 0.0, CIRCLE * cos);
        // The figure faces +Z.
        place.rotation = Quat::from_rotation_y(angle + FRAC_PI_2);
    }
}

fn stop(keys: Res<ButtonInput<KeyCode>>, mut time: ResMut<Time<Virtual>>) {
    if keys.just_pressed(KeyCode::Space) {
        if time.is_paused() {
            time.unpause();
        } else {
            time.pause();
        }
    }
}

/// Keys of the techniques, in the order of [`choices`].
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

fn choose(keys: Res<ButtonInput<KeyCode>>, mut shadow: ResMut<Shadow>) {
    for (key, choice) in KEYS.into_iter().zip(choices()) {
        if keys.just_pressed(key) {
            shadow.0 = choice;
        }
    }
}

/// Gives the chosen technique to the lamp, and takes the others from it.
fn shade(
    mut commands: Commands,
    shadow: Res<Shadow>,
    mut lamps: Query<(Entity, &mut PointLight), With<Lamp>>,
) {
    if !shadow.is_changed() {
        return;
    }
    let row = shadow.0;
    for (lamp, mut light) in &mut lamps {
        light.shadow_maps_enabled = row.is_none();
        // Objects can be hidden from a light only if it is a point, so techniques that use this get one.
        light.radius = if row.is_some_and(|row| !row.needs().light_occlusion) {
            BULB
        } else {
            0.0
        };
        commands.entity(lamp).queue(move |mut lamp: EntityWorldMut| {
            Techniques::default().take(&mut lamp);
            if let Some(row) = row {
                row.defaults().insert(&mut lamp);
            }
        });
    }
}

fn tell(shadow: Res<Shadow>, mut lines: Query<&mut Text, With<Lines>>) {
    let names = choices().into_iter().enumerate().map(|(index, choice)| {
        let mark = if choice == shadow.0 { ">" } else { " " };
        let name = choice.map_or("Bevy's shadow map", |row| row.name());
        format!("{mark} {} {name}", index + 1)
    });
    let names: Vec<String> = names.collect();
    for mut text in &mut lines {
        text.set_if_neq(Text(format!("{}\n  Space stop and go", names.join("\n"))));
    }
}
