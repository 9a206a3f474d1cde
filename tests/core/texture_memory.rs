//! Lights of all techniques share one limit on the memory of their textures, and a third party's technique joins it.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reports::{Report, Reports};
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::techniques::maps::{MapResolution, Maps};
use antumbra::techniques::{
    Needs, Shortage, Storage, Technique, TextureGrant, TextureMemory, TextureMemorySystems, TextureWant,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

/// A third party's technique: films of 4-byte texels that cannot be shared.
#[derive(Component, Clone, Copy, Debug, PartialEq)]
struct Film {
    resolution: u32,
    layers: u64,
}

impl Default for Film {
    fn default() -> Self {
        Self {
            resolution: 256,
            layers: 6,
        }
    }
}

/// What the systems of [`Film`] found in the set in which they build.
#[derive(Resource, Default)]
struct Granted(Vec<(Entity, Option<TextureGrant>)>);

fn ask_for_films(mut memory: ResMut<TextureMemory>, lights: Res<FrameLights>, films: Query<&Film>) {
    for (index, light) in lights.lights.iter().enumerate() {
        if let (true, Ok(film)) = (light.is_shadowed_by::<Film>(), films.get(light.entity)) {
            let want = TextureWant {
                bytes_per_square: 4 * film.layers,
                resolution: film.resolution,
                least: 64,
                storage: Storage::OwnElseNothing,
            };
            memory.ask(index, Film::NAME, want);
        }
    }
}

fn build_films(memory: Res<TextureMemory>, lights: Res<FrameLights>, mut granted: ResMut<Granted>) {
    granted.0.clear();
    for (index, light) in lights.lights.iter().enumerate() {
        if light.is_shadowed_by::<Film>() {
            granted.0.push((light.entity, memory.grant(index, Film::NAME)));
        }
    }
}

impl Technique for Film {
    const NAME: &'static str = "film";
    const NEEDS: Needs = Needs::NOTHING;

    fn init(world: &mut World) {
        world.init_resource::<Granted>();
    }

    fn add_systems(schedule: &mut Schedule) {
        schedule.add_systems((
            ask_for_films.in_set(TextureMemorySystems::Ask),
            build_films.in_set(TextureMemorySystems::Build),
        ));
    }

    #[cfg(feature = "render")]
    type Recorder = antumbra::render::NoRecorder;

    #[cfg(feature = "render")]
    fn recorder(
        _: &antumbra::render::Gpu,
    ) -> Result<antumbra::render::NoRecorder, antumbra::render::RenderError> {
        Ok(antumbra::render::NoRecorder)
    }
}

struct Scene {
    world: World,
    schedule: Schedule,
}

/// Bytes of six layers of 256² texels: what each light wants.
const EACH: u64 = 6 * 4 * 256 * 256;

/// Range of a light that reaches all of the view, and of one that reaches a small part.
const RANGES: [f32; 2] = [30.0, 1.5];

impl Scene {
    /// A cube on a floor before a camera.
    fn new() -> Self {
        let mut world = World::new();
        init_resources(&mut world);
        let mut schedule = standalone_schedule();
        (&mut world, &mut schedule).add_technique::<Film>();
        world.insert_resource(ViewportSize(UVec2::new(160, 90)));
        let view = Transform::from_xyz(0.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
        world.spawn((Camera::default(), view));
        for (mesh, height) in [
            (MeshData::cuboid(Vec3::splat(0.3)), 0.0),
            (MeshData::plane(5.0), -0.3),
        ] {
            world.spawn((
                SceneMesh(Arc::new(mesh)),
                SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
                (ShadowCaster, ShadowReceiver),
                Transform::from_xyz(0.0, height, 0.0),
            ));
        }
        Self { world, schedule }
    }

    fn light(&mut self, range: f32, technique: impl Bundle) -> Entity {
        let light = Light::point(Vec3::ONE, 10.0, range);
        self.world
            .spawn((light, technique, Transform::from_xyz(0.2, 1.0, 0.3)))
            .id()
    }

    fn run(&mut self, limit: u64) {
        self.world.resource_mut::<TextureMemory>().limit = limit;
        self.schedule.run(&mut self.world);
        let memory = self.world.resource::<TextureMemory>();
        assert!(memory.bytes() <= limit, "{} of {limit}", memory.bytes());
    }

    fn film(&self, light: Entity) -> Option<u32> {
        let granted = &self.world.resource::<Granted>().0;
        let (_, grant) = granted
            .iter()
            .find(|(entity, _)| *entity == light)
            .expect("it is built");
        grant.map(|grant| grant.resolution)
    }

    fn map(&self, light: Entity) -> (u32, bool) {
        let maps = self.world.resource::<Maps>();
        let map = maps
            .lights
            .iter()
            .find(|map| map.entity == light)
            .expect("it has a map");
        (map.resolution, map.cached)
    }

    fn new_reports(&mut self) -> Vec<Report> {
        let mut reports = self.world.resource_mut::<Reports>();
        reports.drain_new().cloned().collect()
    }
}

fn omni_map() -> OmniMap {
    OmniMap {
        resolution: MapResolution::Fixed(256),
        ..Default::default()
    }
}

#[test]
fn the_least_visible_light_loses_first_whatever_its_technique() {
    for film_is_small in [true, false] {
        let mut scene = Scene::new();
        let [large, small] = RANGES;
        let film = scene.light(if film_is_small { small } else { large }, Film::default());
        let map = scene.light(if film_is_small { large } else { small }, omni_map());
        scene.run(2 * EACH);
        assert_eq!((scene.film(film), scene.map(map)), (Some(256), (256, true)));
        assert_eq!(scene.world.resource::<TextureMemory>().bytes(), 2 * EACH);
        assert_eq!(scene.new_reports(), []);

        scene.run(2 * EACH - 1);
        let coarse = if film_is_small { (128, 256) } else { (256, 128) };
        assert_eq!(
            (scene.film(film), scene.map(map)),
            (Some(coarse.0), (coarse.1, true))
        );
        let (loser, name) = if film_is_small {
            (film, "film")
        } else {
            (map, "omni_map")
        };
        let [report] = &scene.new_reports()[..] else {
            panic!("one light is short");
        };
        assert_eq!((report.topic, report.entity), ("texture_memory", Some(loser)));
        for text in [name, "256 became 128", "TextureMemory::limit"] {
            assert!(report.message.contains(text), "{text}: {}", report.message);
        }

        scene.run(0);
        assert_eq!((scene.film(film), scene.map(map)), (None, (64, false)));
        let said: Vec<_> = scene
            .new_reports()
            .into_iter()
            .map(|report| (report.entity, report.message))
            .collect();
        assert_eq!(said.len(), 2, "{said:?}");
        let of = |light| {
            said.iter()
                .find(|said| said.0 == Some(light))
                .expect("it is said")
        };
        assert!(of(film).1.contains("the light gets none"), "{said:?}");
        assert!(of(map).1.contains("drawn every frame"), "{said:?}");

        scene.run(2 * EACH);
        assert_eq!((scene.film(film), scene.map(map)), (Some(256), (256, true)));
        assert_eq!(scene.world.resource::<Reports>().iter().count(), 0);
        // Without anybody who asks, nothing is left of the frame before.
        scene.world.despawn(film);
        scene.world.despawn(map);
        scene.run(0);
        let memory = scene.world.resource::<TextureMemory>();
        assert_eq!((memory.bytes(), memory.shortages()), (0, &[][..]));
        assert_eq!(memory.grant(0, Film::NAME), None);
    }
}

#[test]
fn the_order_in_which_techniques_ask_does_not_matter() {
    let plan = |swapped: bool| {
        let mut scene = Scene::new();
        let ask_again = |mut memory: ResMut<TextureMemory>, lights: Res<FrameLights>| {
            for index in (0..lights.lights.len()).rev() {
                let want = TextureWant {
                    bytes_per_square: 4,
                    resolution: 512,
                    least: 512,
                    storage: Storage::OwnElseNothing,
                };
                memory.ask(index, "a second asker", want);
            }
        };
        let system = ask_again.in_set(TextureMemorySystems::Ask);
        scene.schedule.add_systems(if swapped {
            system.before(ask_for_films)
        } else {
            system.after(ask_for_films)
        });
        let lights: Vec<Entity> = (0..6)
            .map(|i| match i % 2 {
                0 => scene.light(2.0, Film::default()),
                _ => scene.light(2.0, omni_map()),
            })
            .collect();
        scene.run(6 << 20);
        let memory = scene.world.resource::<TextureMemory>();
        let shortages = memory.shortages().to_vec();
        assert!(shortages.len() > 3, "{shortages:?}");
        let second: Vec<bool> = (0..6)
            .map(|light| memory.grant(light, "a second asker").is_some())
            .collect();
        assert!(second.contains(&true) && second.contains(&false), "{second:?}");
        let films: Vec<_> = [0, 2, 4].map(|i| scene.film(lights[i])).into();
        let maps: Vec<_> = [1, 3, 5].map(|i| scene.map(lights[i])).into();
        (shortages, second, films, maps)
    };
    assert_eq!(plan(false), plan(true));
}

#[test]
fn equally_visible_lights_lose_from_the_last_on() {
    let mut scene = Scene::new();
    let mut films = [0; 3].map(|_| scene.light(2.0, Film::default()));
    films.sort(); // the order of the frame's lights
    scene.run(2 * EACH);
    assert_eq!(
        films.map(|film| scene.film(film)),
        [Some(256), Some(128), Some(128)],
        "two quarters"
    );
    let short: Vec<_> = scene.world.resource::<TextureMemory>().shortages().to_vec();
    assert_eq!(short.len(), 2);
    assert!(short.iter().all(
        |short| short.asker == "film" && matches!(short.shortage, Shortage::Coarser { wanted: 256, .. })
    ));
}
