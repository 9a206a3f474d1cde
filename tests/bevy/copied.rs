//! The lights that the playground gives as Bevy code: what is copied compiles in a game, and spawns what it says.

use antumbra::techniques::Techniques;
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;

/// A file as the playground writes it, with each setting of each technique. A test of the playground holds it against what
/// it writes now.
#[allow(
    clippy::wildcard_imports,
    clippy::needless_update,
    reason = "what is copied is not written by hand"
)]
mod pasted {
    include!("copied_lights.in");

    /// Spawns the lights.
    pub fn spawn(commands: Commands) {
        spawn_lights(commands);
    }
}

#[test]
fn copied_lights_compile_and_have_every_technique() {
    let mut world = World::new();
    world.run_system_once(pasted::spawn).unwrap();
    let lights: Vec<EntityRef> = world.iter_entities().collect();
    assert!(lights.len() > 30, "{}", lights.len());
    let is_light = |light: &EntityRef| {
        light.contains::<PointLight>()
            || light.contains::<SpotLight>()
            || light.contains::<DirectionalLight>()
            || light.contains::<RectLight>()
    };
    assert!(lights.iter().filter(|light| is_light(light)).count() > 30);
    for row in Techniques::default().rows() {
        let count = lights
            .iter()
            .filter(|light| row.settings_of(light).is_some())
            .count();
        assert!(count >= 3, "{}: {count} lights", row.name());
    }
    let paths = lights
        .iter()
        .filter(|light| light.contains::<antumbra::scene::LightPath>());
    assert!(paths.count() >= 3);
}
