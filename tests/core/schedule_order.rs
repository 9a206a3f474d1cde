//! The order in which things are spawned, or systems happen to run, does not show: same input, same frame.
//!
//! bevy_ecs 0.19 cannot shuffle a schedule (0.20 can). Instead every pair of systems that touch the same data must be
//! ordered: ambiguities are errors here, so that all orders which the executor may choose give the same result.

use std::collections::BTreeMap;
use std::f32::consts::TAU;
use std::sync::Arc;

use antumbra::plugin::AntumbraPlugin;
use antumbra::prelude::*;
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::sets::{DepthBounds, FrustumSet, Objects, ScissorRect, SetWork, VisibleSet};
use antumbra::silhouettes::Silhouettes;
use antumbra::techniques::stencil_volume::StencilVolumes;
use bevy_app::{App, PostUpdate};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::{LogLevel, ScheduleBuildError, ScheduleBuildSettings, Schedules};
use bevy_transform::prelude::Transform;
use fixedbitset::FixedBitSet;
use glam::{UVec2, Vec3};

const SEEDS: u64 = 32;

/// One entity of the scene; what is spawned does not depend on when.
#[derive(Clone)]
enum Part {
    Camera,
    Light(usize),
    Object(usize),
}

fn parts() -> Vec<Part> {
    std::iter::once(Part::Camera)
        .chain((0..6).map(Part::Light))
        .chain((0..150).map(Part::Object))
        .collect()
}

/// Points on a spiral: all different, some behind the camera.
fn place(index: usize) -> Vec3 {
    let angle = index as f32 * 0.618 * TAU;
    let radius = 1.5 + 0.12 * index as f32;
    Vec3::new(
        radius * angle.cos(),
        (index % 7) as f32 * 0.4,
        radius * angle.sin(),
    )
}

fn spawn(world: &mut World, part: &Part, meshes: &[Arc<MeshData>; 2]) {
    match *part {
        Part::Camera => {
            let eye = Transform::from_xyz(0.0, 2.0, 12.0).looking_at(Vec3::Y, Vec3::Y);
            world.spawn((Name::new("camera"), Camera::default(), eye));
        }
        Part::Light(index) => {
            let at = Transform::from_translation(place(3 * index) + 3.0 * Vec3::Y);
            let mut light = Light::point(Vec3::ONE, 20.0, 4.0 + index as f32);
            match index % 3 {
                1 => light.kind = LightKind::Directional,
                2 => {
                    light.kind = LightKind::Spot {
                        inner_angle: 0.3,
                        outer_angle: 0.7,
                    }
                }
                _ => {}
            }
            let down = at.looking_at(Vec3::new(1.0, 0.0, 0.5), Vec3::Y);
            world.spawn((
                Name::new(format!("light {index}")),
                light,
                StencilVolume::default(),
                down,
            ));
        }
        Part::Object(index) => {
            let mut entity = world.spawn((
                Name::new(format!("object {index}")),
                SceneMesh(meshes[index % 2].clone()),
                SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
                Transform::from_translation(place(index)),
            ));
            // Several archetypes, so that query order is not spawn order either.
            if index % 5 != 0 {
                entity.insert(ShadowCaster);
            }
            if index % 4 != 0 {
                entity.insert(ShadowReceiver);
            }
            if index % 3 == 0 {
                entity.insert(SelectionLayers(1 << (index % 2)));
            }
        }
    }
}

/// All that a light's volumes are, by name of the caster.
type Volumes = BTreeMap<String, ([u32; 4], u32, [bool; 3], Vec<[u32; 2]>)>;

/// Names instead of indices, so that frames of different spawn orders compare.
#[derive(Debug, PartialEq)]
struct Snapshot {
    sets: BTreeMap<String, Vec<String>>,
    rects: BTreeMap<String, (Option<ScissorRect>, Option<DepthBounds>)>,
    volumes: BTreeMap<String, Volumes>,
}

fn name(world: &World, entity: Entity) -> String {
    world
        .get::<Name>(entity)
        .map_or_else(String::new, |name| name.to_string())
}

fn names(world: &World, set: &FixedBitSet) -> Vec<String> {
    let objects = world.resource::<Objects>();
    let mut names: Vec<String> = set
        .ones()
        .map(|index| name(world, objects.entities[index]))
        .collect();
    names.sort();
    names
}

fn snapshot(world: &World) -> Snapshot {
    let objects = world.resource::<Objects>();
    let mut sets = BTreeMap::new();
    sets.insert("F".to_owned(), names(world, &world.resource::<FrustumSet>().set));
    sets.insert("V".to_owned(), names(world, &world.resource::<VisibleSet>().set));
    let mut rects = BTreeMap::new();
    let mut volumes = BTreeMap::new();
    for (index, light) in world.resource::<FrameLights>().lights.iter().enumerate() {
        let own = name(world, light.entity);
        for (set, bits) in [("L", &light.sets.l), ("I", &light.sets.i), ("S", &light.sets.s)] {
            sets.insert(format!("{own} {set}"), names(world, bits));
        }
        rects.insert(own.clone(), (light.region.scissor, light.region.depth_bounds));
        let known = world.resource::<Silhouettes>().of_light(light.entity);
        let mut casters = Volumes::new();
        for caster in world
            .resource::<StencilVolumes>()
            .of_light(index)
            .into_iter()
            .flat_map(|volumes| &volumes.casters)
        {
            let contour = known.and_then(|known| known.of_object(caster.object as usize));
            let edges = contour.map_or_else(Vec::new, |(_, silhouette)| {
                silhouette.contour.all_edges().collect::<Vec<_>>()
            });
            casters.insert(
                name(world, objects.entities[caster.object as usize]),
                (
                    caster.light_local.to_array().map(f32::to_bits),
                    caster.extrusion.to_bits(),
                    [caster.depth_pass, caster.near_cap, caster.far_cap],
                    edges,
                ),
            );
        }
        volumes.insert(own, casters);
    }
    Snapshot { sets, rects, volumes }
}

/// Two frames, with a move between them, of the scene spawned in an order. `nudge` moves one object farther.
fn frames(seed: u64, nudge: f32) -> [Snapshot; 2] {
    let meshes = [
        Arc::new(MeshData::cuboid(Vec3::splat(0.4))),
        Arc::new(MeshData::icosphere(0.5, 1)),
    ];
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(UVec2::new(320, 180)));
    let mut random = fastrand::Rng::with_seed(seed);
    let mut parts = parts();
    random.shuffle(&mut parts);
    for part in parts {
        // Gaps in the entity indices, and reused ones.
        if random.usize(..3) == 0 {
            let gap = world.spawn_empty().id();
            if random.bool() {
                world.despawn(gap);
            }
        }
        spawn(&mut world, &part, &meshes);
    }
    let mut schedule = standalone_schedule();
    schedule.run(&mut world);
    let first = snapshot(&world);
    let mut query = world.query::<(&Name, &mut Transform)>();
    for (name, mut transform) in query.iter_mut(&mut world) {
        match name.as_str() {
            "object 30" | "light 0" => transform.translation.x += 0.7 + nudge,
            _ => {}
        }
    }
    schedule.run(&mut world);
    [first, snapshot(&world)]
}

#[test]
fn shuffled_spawn_order_gives_the_same_sets_and_volumes() {
    let expected = frames(0, 0.0);
    for (frame, snapshot) in expected.iter().enumerate() {
        let casters: usize = snapshot.volumes.values().map(BTreeMap::len).sum();
        assert!(
            casters > 50,
            "frame {frame} has only {casters} volumes to compare"
        );
        assert!(snapshot.sets["F"].len() > 40, "frame {frame} sees too little");
    }
    assert_ne!(expected[0], expected[1], "the move shows");
    for seed in 1..=SEEDS {
        assert!(frames(seed, 0.0) == expected, "seed {seed} differs");
    }
}

#[test]
fn comparison_finds_an_object_moved_by_a_hair() {
    assert_ne!(frames(0, 0.0)[1], frames(0, 1e-3)[1]);
}

/// Builds a schedule with ambiguities as errors.
fn build(schedule: &mut Schedule, world: &mut World) -> Result<(), ScheduleBuildError> {
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        hierarchy_detection: LogLevel::Error,
        ..schedule.get_build_settings()
    });
    schedule.initialize(world).map(|_| ())
}

#[test]
fn standalone_schedule_has_no_ambiguity() {
    let mut world = World::new();
    init_resources(&mut world);
    let mut schedule = standalone_schedule();
    if let Err(error) = build(&mut schedule, &mut world) {
        panic!("{}", error.to_string(schedule.graph(), &world));
    }
    schedule.run(&mut world);
}

#[test]
fn plugin_schedule_has_no_ambiguity() {
    let mut app = App::new();
    app.add_plugins(AntumbraPlugin);
    app.finish();
    let mut schedule = app
        .world_mut()
        .resource_mut::<Schedules>()
        .remove(PostUpdate)
        .expect("the plugin adds to PostUpdate");
    if let Err(error) = build(&mut schedule, app.world_mut()) {
        panic!("{}", error.to_string(schedule.graph(), app.world()));
    }
}

#[test]
fn detection_finds_an_unordered_writer() {
    let mut world = World::new();
    init_resources(&mut world);
    let mut schedule = standalone_schedule();
    schedule.add_systems(|mut work: ResMut<SetWork>| work.views += 1);
    assert!(build(&mut schedule, &mut world).is_err());
}
