//! A headless game, and what its cameras see.

use std::sync::Mutex;

use bevy::app::SubApps;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::error_handler::RenderErrorHandler;

use antumbra::bevy_adapter::prelude::*;

#[path = "../../examples/support/bevy_frames.rs"]
pub mod frames;
pub use frames::target;

/// Size of test pictures.
pub const SIZE: UVec2 = UVec2::new(128, 72);

/// The plugins of a game without a window, with results in the same frame.
pub fn headless() -> App {
    crate::setup::listen();
    complete(frames::app())
}

/// The same, with ours and more added before Bevy's.
pub fn antumbra_first(more: impl FnOnce(&mut App)) -> App {
    crate::setup::listen();
    let mut app = App::new();
    app.add_plugins(AntumbraPlugin);
    more(&mut app);
    at_once(complete(frames::with_plugins(app)))
}

fn complete(mut app: App) -> App {
    app.insert_resource(ambient());
    // Validation and other errors of the device fail the test.
    app.insert_resource(RenderErrorHandler(|error, _, _| panic!("{error:?}")));
    app
}

fn ambient() -> GlobalAmbientLight {
    GlobalAmbientLight {
        brightness: 50.0,
        ..default()
    }
}

fn at_once(mut app: App) -> App {
    app.insert_resource(settings());
    app
}

fn settings() -> AntumbraSettings {
    AntumbraSettings {
        immediate_triangles: usize::MAX,
        ..default()
    }
}

/// The same, with ours. Meshes are ready in the frame in which they appear.
pub fn antumbra() -> App {
    let mut app = headless();
    app.add_plugins(AntumbraPlugin);
    at_once(app)
}

/// What every camera of the tests has.
pub fn camera(world: &mut World, transform: Transform) -> Entity {
    sized_camera(world, SIZE, transform)
}

fn sized_camera(world: &mut World, size: UVec2, transform: Transform) -> Entity {
    let target = target(world, size);
    world
        .spawn((
            Camera3d::default(),
            bevy::camera::Hdr,
            Msaa::Off,
            Tonemapping::None,
            target,
            transform,
        ))
        .id()
}

/// A camera of ours that looks at the origin.
pub fn marked_camera(world: &mut World, eye: Vec3) -> Entity {
    let camera = camera(world, from(eye));
    world.entity_mut(camera).insert(AntumbraCamera);
    camera
}

/// A camera of ours like [`marked_camera`] with a picture of a few pixels, for tests that look at no picture.
pub fn unseen_camera(world: &mut World, eye: Vec3) -> Entity {
    let camera = sized_camera(world, SIZE / 8, from(eye));
    world.entity_mut(camera).insert(AntumbraCamera);
    camera
}

fn from(eye: Vec3) -> Transform {
    Transform::from_translation(eye).looking_at(Vec3::ZERO, Vec3::Y)
}

/// An object of some material.
pub fn add_mesh(world: &mut World, mesh: impl Into<Mesh>, transform: Transform) -> Entity {
    let mesh = world.resource_mut::<Assets<Mesh>>().add(mesh.into());
    let matte = matte(world);
    world.spawn((Mesh3d(mesh), matte, transform)).id()
}

/// A managed point light above.
pub fn add_light(world: &mut World) -> Entity {
    let light = PointLight {
        intensity: 500_000.0,
        ..default()
    };
    let place = Transform::from_xyz(1.0, 4.0, 1.0);
    world.spawn((light, StencilVolume::default(), place)).id()
}

/// Some material.
pub fn matte(world: &mut World) -> MeshMaterial3d<StandardMaterial> {
    MeshMaterial3d(
        world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial::default()),
    )
}

/// Games for [`game`] that no test uses now.
static RESTING: Mutex<Vec<SubApps>> = Mutex::new(Vec::new());

/// A running game of [`antumbra`] with an empty scene. Starting a game takes seconds, so this one may have shown the scenes
/// of other tests before. A test that adds plugins, or changes resources other than the ambient light and the settings,
/// starts its own with [`Game::start`].
pub fn game() -> Game {
    let resting = RESTING.lock().unwrap().pop();
    let mut game = match resting {
        Some(apps) => Game { apps, rests: false },
        None => Game::start(antumbra()),
    };
    game.rests = true;
    game.world().insert_resource(ambient());
    game.world().insert_resource(settings());
    game
}

/// A running game like [`game`] without ambient light.
pub fn dark_game() -> Game {
    let mut game = game();
    game.world().insert_resource(GlobalAmbientLight::NONE);
    game
}

/// A game that runs.
pub struct Game {
    pub apps: SubApps,
    /// Whether another test may have it after this one.
    rests: bool,
}

impl Drop for Game {
    fn drop(&mut self) {
        if self.rests && !std::thread::panicking() {
            self.clear().run(2);
            RESTING.lock().unwrap().push(std::mem::take(&mut self.apps));
        }
    }
}

impl Game {
    /// Starts it.
    pub fn start(mut app: App) -> Self {
        app.finish();
        app.cleanup();
        Self {
            apps: std::mem::take(app.sub_apps_mut()),
            rests: false,
        }
    }

    /// Keeps the game from other tests, because this one breaks it for good.
    pub fn spoil(&mut self) {
        self.rests = false;
    }

    /// Runs frames.
    pub fn run(&mut self, frames: usize) -> &mut Self {
        for _ in 0..frames {
            self.apps.update();
        }
        self
    }

    /// The game's world.
    pub fn world(&mut self) -> &mut World {
        self.apps.main.world_mut()
    }

    /// The renderer's world.
    pub fn render_world(&mut self) -> &mut World {
        frames::render_world(&mut self.apps)
    }

    /// Despawns cameras, lights and meshes, so that another scene can take their place. Shaders and pipelines stay.
    pub fn clear(&mut self) -> &mut Self {
        let world = self.world();
        let mut placed = world.query_filtered::<Entity, (With<Transform>, Without<ChildOf>)>();
        for entity in placed.iter(world).collect::<Vec<_>>() {
            world.despawn(entity);
        }
        self
    }

    /// Returns what a camera sees once its picture stays the same. Bevy's clusters grow over frames.
    pub fn settled(&mut self, camera: Entity) -> Picture {
        let [picture] = self.all_settled([camera]);
        picture
    }

    /// Returns what cameras see once the pictures of all of them stay the same.
    pub fn all_settled<const N: usize>(&mut self, cameras: [Entity; N]) -> [Picture; N] {
        let mut last = cameras.map(|camera| self.radiance(camera));
        for _ in 0..30 {
            self.run(3);
            let next = cameras.map(|camera| self.radiance(camera));
            if next == last {
                return next;
            }
            last = next;
        }
        panic!("the pictures never settle");
    }

    /// Linear radiance that a camera sees.
    pub fn radiance(&mut self, camera: Entity) -> Picture {
        let (size, texels) = frames::radiance(&mut self.apps, camera);
        Picture { size, texels }
    }
}

/// Linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub size: UVec2,
    pub texels: Vec<[half::f16; 3]>,
}

/// How two pictures differ.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// Channels that are not the same number.
    pub channels: usize,
    /// Largest difference over the larger value.
    pub relative: f32,
    /// Largest difference.
    pub absolute: f32,
    /// Largest difference in steps of the 16-bit format.
    pub steps: i32,
}

impl Picture {
    /// Compares with one of the same size.
    pub fn difference(&self, other: &Self) -> Difference {
        assert_eq!(self.size, other.size);
        let mut out = Difference::default();
        let pairs = self.texels.iter().flatten().zip(other.texels.iter().flatten());
        for (&a, &b) in pairs {
            assert!(a.is_finite() && b.is_finite(), "a picture is not finite");
            let (x, y) = (f32::from(a), f32::from(b));
            out.channels += usize::from(x != y);
            out.absolute = out.absolute.max((x - y).abs());
            if x != y {
                out.relative = out.relative.max((x - y).abs() / x.abs().max(y.abs()));
            }
            out.steps = out.steps.max((ordered(a) - ordered(b)).abs());
        }
        out
    }

    /// Mean of all channels.
    pub fn mean(&self) -> f32 {
        let sum: f32 = self.texels.iter().flatten().map(|&x| f32::from(x)).sum();
        sum / (self.texels.len() * 3) as f32
    }

    /// Writes it as a PNG below the directory of `ANTUMBRA_OUT`, if that is set.
    pub fn save(&self, name: &str) {
        let Ok(dir) = std::env::var("ANTUMBRA_OUT") else {
            return;
        };
        let encode = |x: half::f16| (f32::from(x).clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
        let bytes = self.texels.iter().flatten().map(|&x| encode(x)).collect();
        let image = image::RgbImage::from_raw(self.size.x, self.size.y, bytes).unwrap();
        image.save(format!("{dir}/{name}.png")).unwrap();
    }
}

/// Numbers of the format, counted from 0.
fn ordered(x: half::f16) -> i32 {
    let bits = i32::from(x.to_bits());
    if bits & 0x8000 == 0 {
        bits
    } else {
        -(bits & 0x7fff)
    }
}
