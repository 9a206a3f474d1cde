//! Mirrors that follow the game by what changed hold what a mirror made anew holds.

use antumbra::bevy_adapter::prelude::*;
use antumbra::bevy_adapter::{HostEntity, HostLight};
use antumbra::bevy_adapter::{Mirror, Mirrors};
use antumbra::scene::{
    Light, MeshData, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster, ShadowReceiver, WorldBounds,
};
use antumbra::sets::FrameLights;
use bevy::camera::visibility::{CubemapVisibleEntities, RenderLayers};
use bevy::ecs::entity::EntityHashSet;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::prelude::*;

use crate::harness::{self, Game};

/// What a mirror holds of an entity of the game, as text; bare places (of joints, or of what was an object) left out.
fn dump(mirror: &mut Mirror) -> Vec<String> {
    let mut query = mirror.world.query::<EntityRef>();
    let mut lines = Vec::new();
    for entity in query.iter(&mirror.world) {
        let Some(host) = entity.get::<HostEntity>() else {
            continue;
        };
        let (layers, light) = (entity.get::<SelectionLayers>(), entity.get::<HostLight>());
        if layers.is_none() && light.is_none() {
            continue;
        }
        let mesh = entity
            .get::<SceneMesh>()
            .map(|mesh| std::sync::Arc::as_ptr(&mesh.0));
        let mesh: Option<*const MeshData> = mesh;
        lines.push(format!(
            "{:?} {:?} {mesh:?} {} {} {} {layers:?} {:?} {light:?} {:?} {:?} {:?} {:?}",
            host.0,
            entity.get::<GlobalTransform>().unwrap().affine(),
            entity.contains::<ShadowCaster>(),
            entity.contains::<ShadowReceiver>(),
            entity.contains::<SceneMaterials>(),
            entity.get::<WorldBounds>(),
            entity.get::<Light>(),
            entity.get::<LightSelection>(),
            entity.get::<StencilVolume>(),
            entity.get::<OmniMap>().is_some(),
        ));
    }
    lines.sort();
    lines
}

fn mirror_dump(game: &mut Game, camera: Entity) -> Vec<String> {
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    dump(mirrors.get_mut(camera).expect("a mirror"))
}

struct Edited {
    meshes: Vec<Handle<Mesh>>,
    objects: Vec<Entity>,
    lights: Vec<Entity>,
}

fn place(random: &mut fastrand::Rng) -> Transform {
    let mut axis = || random.f32() * 8.0 - 4.0;
    Transform::from_xyz(axis(), axis() * 0.5 + 2.0, axis())
}

fn spawn_object(world: &mut World, edited: &mut Edited, random: &mut fastrand::Rng) {
    let mesh = edited.meshes[random.usize(..edited.meshes.len())].clone();
    let matte = harness::matte(world);
    let object = world.spawn((Mesh3d(mesh), matte, place(random)));
    edited.objects.push(object.id());
}

fn spawn_light(world: &mut World, edited: &mut Edited, random: &mut fastrand::Rng) {
    let mut light = world.spawn((place(random), StencilVolume::default()));
    match random.usize(..4) {
        0 => light.insert(PointLight::default()),
        1 => light.insert(SpotLight::default()),
        2 => light.insert(DirectionalLight::default()),
        _ => light.insert(RectLight::default()),
    };
    edited.lights.push(light.id());
}

/// One change of the game, of any kind that is to be followed.
fn edit(world: &mut World, edited: &mut Edited, random: &mut fastrand::Rng) {
    let object = edited.objects[random.usize(..edited.objects.len())];
    let light = edited.lights[random.usize(..edited.lights.len())];
    let either = if random.usize(..2) == 0 { object } else { light };
    match random.usize(..16) {
        0 => {
            let mut place = place(random);
            place.scale.x = if random.bool() { 1.0 } else { -1.0 };
            world.entity_mut(either).insert(place);
        }
        1 => {
            world.entity_mut(either).insert(Visibility::Hidden);
        }
        2 => {
            world.entity_mut(either).insert(Visibility::Inherited);
        }
        3 => {
            world
                .entity_mut(either)
                .insert(RenderLayers::from_layers(&[0, random.usize(..40)]));
        }
        4 => {
            world
                .entity_mut(either)
                .insert(RenderLayers::layer(random.usize(..3)));
        }
        5 => {
            world.entity_mut(either).remove::<RenderLayers>();
        }
        6 => {
            world.entity_mut(object).insert(NotShadowCaster);
        }
        7 => {
            world.entity_mut(object).remove::<NotShadowCaster>();
        }
        8 => {
            world.entity_mut(object).insert(NotShadowReceiver);
        }
        9 => {
            world.entity_mut(object).remove::<NotShadowReceiver>();
        }
        10 if edited.objects.len() > 4 => {
            world.despawn(object);
            edited.objects.retain(|&known| known != object);
            spawn_object(world, edited, random);
        }
        11 if edited.lights.len() > 3 => {
            world.despawn(light);
            edited.lights.retain(|&known| known != light);
            spawn_light(world, edited, random);
        }
        12 => {
            world.entity_mut(light).remove::<StencilVolume>();
        }
        13 => {
            world.entity_mut(light).insert((
                StencilVolume::default(),
                LightSelection {
                    affects: 1,
                    casts_for: random.usize(..4) as u32,
                    shows_on: u32::MAX,
                },
            ));
        }
        14 => {
            // Hot reload.
            let id = edited.meshes[random.usize(..edited.meshes.len())].id();
            let size = 0.5 + random.f32();
            let mut meshes = world.resource_mut::<Assets<Mesh>>();
            meshes.insert(id, Cuboid::new(size, size, size).into()).unwrap();
        }
        _ => {
            // A new parent, or none.
            let parent = edited.objects[random.usize(..edited.objects.len())];
            if parent != either
                && world.get::<Children>(either).is_none()
                && world.get::<ChildOf>(parent).is_none()
            {
                world.entity_mut(either).insert(ChildOf(parent));
            } else {
                world.entity_mut(either).remove::<ChildOf>();
            }
        }
    }
}

#[test]
fn what_changed_makes_the_same_mirror_as_everything() {
    let mut game = harness::game();
    let world = game.world();
    let camera = harness::unseen_camera(world, Vec3::new(0.0, 6.0, 9.0));
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let meshes = vec![
        meshes.add(Cuboid::new(1.0, 1.0, 1.0)),
        meshes.add(Sphere::new(0.5)),
        meshes.add(Torus::new(0.2, 0.5)),
    ];
    let mut edited = Edited {
        meshes,
        objects: Vec::new(),
        lights: Vec::new(),
    };
    let mut random = fastrand::Rng::with_seed(0x9e37_79b9_7f4a_7c15);
    for _ in 0..12 {
        spawn_object(world, &mut edited, &mut random);
    }
    for _ in 0..6 {
        spawn_light(world, &mut edited, &mut random);
    }
    game.run(2);
    let (mut steps, mut different) = (0, EntityHashSet::default());
    let mut last = Vec::new();
    for step in 0..60 {
        for _ in 0..1 + random.usize(..4) {
            edit(game.world(), &mut edited, &mut random);
            // Children go with their parents.
            let world = game.world();
            edited.objects.retain(|&object| world.get_entity(object).is_ok());
            edited.lights.retain(|&light| world.get_entity(light).is_ok());
            while edited.objects.len() < 4 {
                spawn_object(world, &mut edited, &mut random);
            }
            while edited.lights.len() < 3 {
                spawn_light(world, &mut edited, &mut random);
            }
        }
        game.run(1);
        let followed = mirror_dump(&mut game, camera);
        if followed != last {
            steps += 1;
        }
        last.clone_from(&followed);
        if step % 4 == 3 {
            game.render_world().resource_mut::<Mirrors>().clear();
            game.run(1);
            let anew = mirror_dump(&mut game, camera);
            assert_eq!(followed, anew, "step {step}");
            different.insert(Entity::from_raw_u32(anew.len() as u32).unwrap());
        }
    }
    assert!(steps > 30, "only {steps} steps changed anything");
    assert!(different.len() > 2, "the scenes were all alike");
}

#[test]
fn a_steady_frame_changes_nothing() {
    let mut game = harness::game();
    let world = game.world();
    let camera = harness::unseen_camera(world, Vec3::new(0.0, 6.0, 9.0));
    harness::add_mesh(world, Cuboid::new(1.0, 1.0, 1.0), Transform::default());
    harness::add_light(world);
    game.run(4);
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    let mirror = mirrors.get_mut(camera).unwrap();
    let lights = mirror.world.resource::<FrameLights>();
    assert!(!lights.lights[0].moved, "the light did not move");
    let (i, s) = (
        lights.lights[0].sets.i.count_ones(..),
        lights.lights[0].sets.s.count_ones(..),
    );
    assert_eq!((i, s), (1, 1));
    let work = *mirror.world.resource::<antumbra::sets::SetWork>();
    let groups = mirror.view.groups.lock().unwrap().made();
    game.run(3);
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    let mirror = mirrors.get_mut(camera).unwrap();
    let after = mirror.world.resource::<antumbra::sets::SetWork>();
    assert_eq!(
        format!("{work:?}"),
        format!("{after:?}"),
        "sets were computed again"
    );
    let after = mirror.view.groups.lock().unwrap().made();
    assert!(groups > 0 && after == groups, "bind groups were made again");
}

#[test]
fn casters_are_among_bevys() {
    let mut app = harness::antumbra();
    let world = app.world_mut();
    let camera = harness::unseen_camera(world, Vec3::new(0.0, 3.0, 6.0));
    let mut meshes = world.resource_mut::<Assets<Mesh>>();
    let meshes = vec![
        meshes.add(Cuboid::new(1.0, 1.0, 1.0)),
        meshes.add(Sphere::new(0.5)),
    ];
    let mut edited = Edited {
        meshes,
        objects: Vec::new(),
        lights: Vec::new(),
    };
    let mut random = fastrand::Rng::with_seed(0xda94_2042_e4dd_58b5);
    for _ in 0..80 {
        spawn_object(world, &mut edited, &mut random);
    }
    for _ in 0..4 {
        let light = PointLight {
            range: 3.0,
            shadow_maps_enabled: true,
            ..default()
        };
        world.spawn((light, StencilVolume::default(), place(&mut random)));
    }
    app.insert_resource(bevy::light::PointLightShadowMap { size: 16 });
    let mut game = Game::start(app);
    game.run(3);
    let mut mirrors = game.render_world().resource_mut::<Mirrors>();
    let mirror = mirrors.get_mut(camera).expect("a mirror");
    let host = |entity: Entity| mirror.world.get::<HostEntity>(entity).expect("of the game").0;
    let objects = mirror.world.resource::<antumbra::sets::Objects>();
    let lights = mirror.world.resource::<FrameLights>();
    let ours: Vec<(Entity, Vec<Entity>)> = lights
        .lights
        .iter()
        .map(|light| {
            (
                host(light.entity),
                light.sets.s.ones().map(|i| host(objects.entities[i])).collect(),
            )
        })
        .collect();
    let (mut of_ours, mut of_bevy) = (0, 0);
    for (light, casters) in ours {
        let bevys: EntityHashSet = game
            .world()
            .get::<CubemapVisibleEntities>(light)
            .expect("Bevy's casters")
            .iter()
            .flat_map(|face| face.entities.iter().copied())
            .collect();
        assert!(
            casters.iter().all(|caster| bevys.contains(caster)),
            "light {light}"
        );
        of_ours += casters.len();
        of_bevy += bevys.len();
    }
    println!("casters of four lights: ours {of_ours}, Bevy's {of_bevy}");
    assert!(of_ours > 4 && of_ours <= of_bevy);
}
