//! Apps and cameras that cannot show our shadows: no panic, and one warning.

use std::fmt::Write as _;
use std::sync::Mutex;

use antumbra::bevy_adapter::prelude::*;
use bevy::camera::Hdr;
use bevy::prelude::*;
use bevy::tasks::ComputeTaskPool;
use tracing::field::{Field, Visit};
use tracing::span;

use crate::harness::{self, Game};

/// Warnings of ours, of all tests.
static WARNINGS: Mutex<Vec<String>> = Mutex::new(Vec::new());

struct Listener;

struct Message(String);

impl Visit for Message {
    fn record_debug(&mut self, field: &Field, value: &dyn std::fmt::Debug) {
        if field.name() == "message" {
            let _ = write!(self.0, "{value:?}");
        }
    }
}

impl tracing::Subscriber for Listener {
    fn enabled(&self, metadata: &tracing::Metadata<'_>) -> bool {
        *metadata.level() <= tracing::Level::WARN
    }
    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }
    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}
    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}
    fn event(&self, event: &tracing::Event<'_>) {
        let mut message = Message(String::new());
        event.record(&mut message);
        let target = event.metadata().target();
        if target.starts_with("antumbra") {
            WARNINGS.lock().unwrap().push(message.0);
        } else if target != "log" {
            println!("{} {target}: {}", event.metadata().level(), message.0);
        }
    }
    fn enter(&self, _: &span::Id) {}
    fn exit(&self, _: &span::Id) {}
}

/// Warnings so far that hold a text.
pub fn warnings(text: &str) -> Vec<String> {
    let all = WARNINGS.lock().unwrap();
    all.iter()
        .filter(|warning| warning.contains(text))
        .cloned()
        .collect()
}

/// Hears warnings from now on.
pub fn listen() {
    let _ = tracing::subscriber::set_global_default(Listener);
}

fn scene(world: &mut World) -> Entity {
    let camera = harness::marked_camera(world, Vec3::new(0.0, 3.0, 6.0));
    harness::add_mesh(world, Cuboid::new(1.0, 1.0, 1.0), Transform::default());
    harness::add_light(world);
    camera
}

#[test]
fn wrong_setups_warn_once_and_go_on() {
    listen();
    // No renderer, and nobody who would miss it.
    ComputeTaskPool::get_or_init(Default::default);
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, AntumbraPlugin));
    app.update();
    assert_eq!(warnings("no renderer").len(), 0);
    // No renderer, and a camera that misses it.
    app.world_mut().spawn(AntumbraCamera);
    for _ in 0..3 {
        app.update();
    }
    assert_eq!(warnings("no renderer").len(), 1, "{:?}", WARNINGS.lock());

    // A camera of low dynamic range: Bevy lights it.
    let mut app = harness::antumbra();
    let camera = scene(app.world_mut());
    app.world_mut().entity_mut(camera).remove::<Hdr>();
    let mut game = Game::start(app);
    game.run(4);
    assert_eq!(warnings("has no `Hdr`").len(), 1);
    // And us, once it is right.
    game.world().entity_mut(camera).insert(Hdr);
    game.run(3);
    assert!(game.radiance(camera).mean() > 0.0);
    assert_eq!(warnings("has no `Hdr`").len(), 1);
    // Bevy's prepasses would cull the wrong faces.
    let invert = |game: &mut Game, inverts| {
        let mut settings = game.world().get_mut::<Camera>(camera).expect("a camera");
        settings.invert_culling = inverts;
        game.run(2);
        warnings("invert_culling").len()
    };
    assert_eq!(invert(&mut game, true), 1);
    assert_eq!(invert(&mut game, true), 1);
    assert_eq!(invert(&mut game, false), 1);

    // MSAA is turned off by us before Bevy sees it.
    let mut app = harness::antumbra();
    let camera = scene(app.world_mut());
    app.world_mut().entity_mut(camera).insert(Msaa::Sample4);
    let mut game = Game::start(app);
    game.run(3);
    assert_eq!(game.world().get::<Msaa>(camera), Some(&Msaa::Off));
    assert!(game.radiance(camera).mean() > 0.0);
}

#[test]
fn the_marker_brings_what_it_needs() {
    let mut app = harness::antumbra();
    let camera = app.world_mut().spawn(AntumbraCamera).id();
    let world = app.world();
    assert_eq!(world.get::<Msaa>(camera), Some(&Msaa::Off));
    assert!(world.get::<Hdr>(camera).is_some() && world.get::<Camera3d>(camera).is_some());
    assert!(
        world
            .get::<bevy::core_pipeline::prepass::DeferredPrepass>(camera)
            .is_some()
    );
    let registry = world.resource::<AppTypeRegistry>().read();
    for name in [
        "AntumbraCamera",
        "StencilVolume",
        "PenumbraWedge",
        "ShadowMap",
        "OmniMap",
        "PerspectiveMap",
        "OcclusionTexture",
        "LightSelection",
        "LightShape",
        "LightDistance",
        "LightWeights",
        "ShadowTint",
    ] {
        let registered = registry
            .get_with_short_type_path(name)
            .unwrap_or_else(|| panic!("{name}"));
        assert!(
            registered.data::<ReflectComponent>().is_some(),
            "{name} can be made from its name"
        );
        assert!(registered.data::<ReflectDefault>().is_some(), "{name}");
    }
}
