//! Materials and meshes are exchanged: what hides as before leaves all sets, and whatever is exchanged leaves the sets of a fresh
//! world.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::{LeftOutSubmeshes, Occluder, Submesh};
use antumbra::schedule::standalone_schedule;
use antumbra::sets::{
    InvertedHulls, InvisibleObjects, Objects, Occluders, SeeThrough, SeenInto, SetWork, VisibleSet,
};
use bevy_ecs::component::Mutable;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Vec3, Vec4};

use crate::occlusion_harness::scenes::{random_scene, spawn_light};
use crate::occlusion_harness::{Random, VIEWPORT};

fn set<C: Component<Mutability = Mutable>>(world: &mut World, entity: Entity, value: C) {
    *world.get_mut::<C>(entity).expect("it has one") = value;
}

fn looks(material: Material) -> SceneMaterials {
    SceneMaterials([Arc::new(material)].into())
}

/// A wall before a ball, a camera and a shadowed lamp.
fn wall() -> (World, Entity) {
    let mut world = World::new();
    antumbra::schedule::init_resources(&mut world);
    world.insert_resource(ViewportSize(VIEWPORT));
    let mut spawn = |mesh: MeshData, z: f32| {
        let parts = (ShadowCaster, ShadowReceiver, Transform::from_xyz(0.0, 0.0, z));
        let mesh = SceneMesh(Arc::new(mesh));
        world.spawn((mesh, looks(Material::matte(Vec3::ONE)), parts)).id()
    };
    let wall = spawn(MeshData::cuboid(Vec3::new(4.0, 4.0, 0.1)), -4.0);
    spawn(MeshData::icosphere(0.3, 1), -8.0);
    world.spawn((Camera::default(), Transform::IDENTITY));
    let lamp = Light::point(Vec3::ONE, 10.0, 30.0);
    world.spawn((lamp, StencilVolume::default(), Transform::from_xyz(0.0, 1.0, 0.0)));
    (world, wall)
}

fn generations(world: &World) -> (u64, u64) {
    let occluders = world.resource::<Occluders>().generation;
    (occluders, world.resource::<VisibleSet>().generation)
}

#[test]
fn a_material_that_hides_as_before_leaves_all_sets() {
    let (mut world, wall) = wall();
    let mut schedule = standalone_schedule();
    schedule.run(&mut world);
    world.clear_trackers();
    let (before, work) = (generations(&world), *world.resource::<SetWork>());
    assert!(work.depth_buffers > 0 && work.illuminations > 0);
    let same = world.get::<SceneMaterials>(wall).unwrap().clone();
    let metal = Material {
        metallic: 1.0,
        roughness: 0.1,
        emissive: Vec3::ONE,
        ..Material::matte(Vec3::X)
    };
    for looks in [same, looks(Material::matte(Vec3::X)), looks(metal)] {
        world.entity_mut(wall).insert(looks);
        schedule.run(&mut world);
        world.clear_trackers();
        assert_eq!(generations(&world), before);
        assert_eq!(*world.resource::<SetWork>(), work, "no set was computed");
    }
}

#[test]
fn whatever_an_occluder_depends_on_makes_the_sets_anew() {
    let (mut world, wall) = wall();
    let mut schedule = standalone_schedule();
    let mut run = |world: &mut World| {
        schedule.run(world);
        world.clear_trackers();
        generations(world)
    };
    let mut last = run(&mut world);
    let mut expect_new = |world: &mut World, why: &str| {
        let now = run(world);
        assert!(now.0 > last.0 && now.1 > last.1, "{why}: {now:?} after {last:?}");
        assert_eq!(run(world), now, "{why}: at rest");
        last = now;
    };
    let matte = Material::matte(Vec3::ONE);
    let materials = [
        (
            "sides",
            Material {
                double_sided: true,
                ..matte.clone()
            },
        ),
        (
            "hides nothing",
            Material {
                alpha_mode: AlphaMode::Mask(0.5),
                ..matte.clone()
            },
        ),
        (
            "cannot be left out",
            Material {
                alpha_mode: AlphaMode::Blend,
                ..matte.clone()
            },
        ),
        ("hides again", matte),
    ];
    for (why, material) in materials {
        set(&mut world, wall, looks(material));
        expect_new(&mut world, why);
    }
    let larger = MeshData::cuboid(Vec3::new(5.0, 4.0, 0.1));
    set(&mut world, wall, SceneMesh(Arc::new(larger)));
    expect_new(&mut world, "mesh");
    world.entity_mut(wall).insert(Occluder::Never);
    expect_new(&mut world, "an occluder came");
    set(&mut world, wall, Occluder::Own);
    expect_new(&mut world, "another occluder");
    world.entity_mut(wall).remove::<Occluder>();
    expect_new(&mut world, "an occluder went");
    world.get_mut::<SelectionLayers>(wall).unwrap().0 = 2;
    expect_new(&mut world, "layers");
}

#[test]
fn an_occluder_that_moves_while_colours_change_is_known_to_move() {
    let (mut world, wall) = wall();
    let mut schedule = standalone_schedule();
    schedule.run(&mut world);
    world.clear_trackers();
    let before = generations(&world);
    set(&mut world, wall, looks(Material::matte(Vec3::X)));
    world.get_mut::<Transform>(wall).unwrap().translation.x = 20.0;
    let seen = |world: &World| world.resource::<VisibleSet>().set.count_ones(..);
    assert_eq!(seen(&world), 1, "the wall");
    schedule.run(&mut world);
    assert_eq!(world.resource::<Occluders>().generation, before.0);
    let index = world.resource::<Objects>().index_of(wall).unwrap();
    assert!(world.resource::<Occluders>().moved.contains(index));
    assert_eq!(seen(&world), 1, "the ball behind it");
}

/// A box of two submeshes, and one that is turned inside out.
fn special_meshes() -> [Arc<MeshData>; 2] {
    let mut two = MeshData::cuboid(Vec3::new(1.5, 1.0, 0.6));
    two.submeshes = [0, 18]
        .map(|first_index| Submesh {
            first_index,
            index_count: 18,
        })
        .to_vec();
    let mut inverted = MeshData::cuboid(Vec3::new(1.0, 1.2, 0.8));
    for corners in inverted.indices.chunks_mut(3) {
        corners.swap(1, 2);
    }
    [Arc::new(two), Arc::new(inverted)]
}

fn random_material(random: &mut Random) -> Arc<Material> {
    let alpha_mode = match random.below(6) {
        0 => AlphaMode::Blend,
        1 => AlphaMode::Mask(0.5),
        _ => AlphaMode::Opaque,
    };
    Arc::new(Material {
        base_color: Vec4::new(random.unit(), 1.0, 1.0, [0.0, 1.0][random.below(2)]),
        alpha_mode,
        double_sided: random.chance(0.3),
        ..Material::default()
    })
}

fn give<C: Component + Clone>(made: &mut EntityWorldMut, component: Option<&C>) {
    if let Some(component) = component {
        made.insert(component.clone());
    }
}

/// A world with clones of all components that a user gives objects, cameras and lights, and the entities in both worlds.
fn fresh(world: &mut World) -> (World, Vec<(Entity, Entity)>) {
    let mut copy = World::new();
    antumbra::schedule::init_resources(&mut copy);
    copy.insert_resource(ViewportSize(VIEWPORT));
    copy.insert_resource(*world.resource::<FaceCulling>());
    let mut placed = world.query::<(Entity, &Transform)>();
    let mut all: Vec<(Entity, Transform)> = placed
        .iter(world)
        .map(|(entity, place)| (entity, *place))
        .collect();
    // Bevy's order puts younger entities first, and the copies are to be in the same order.
    all.sort_unstable_by_key(|(entity, _)| std::cmp::Reverse(*entity));
    let pairs = all.into_iter().map(|(entity, place)| {
        let mut made = copy.spawn(place);
        give(&mut made, world.get::<SceneMesh>(entity));
        give(&mut made, world.get::<SceneMaterials>(entity));
        give(&mut made, world.get::<SelectionLayers>(entity));
        give(&mut made, world.get::<ShadowCaster>(entity));
        give(&mut made, world.get::<ShadowReceiver>(entity));
        give(&mut made, world.get::<Occluder>(entity));
        give(&mut made, world.get::<Light>(entity));
        give(&mut made, world.get::<LightSelection>(entity));
        give(&mut made, world.get::<StencilVolume>(entity));
        give(&mut made, world.get::<Camera>(entity));
        (entity, made.id())
    });
    let pairs = pairs.collect();
    (copy, pairs)
}

/// What is known of an object: its part in the sets of the view and, if asked for, of each light, and the submeshes that cast
/// nothing.
fn known(world: &World, entity: Entity, with_lights: bool) -> (Vec<bool>, Vec<u32>) {
    let Some(object) = world.resource::<Objects>().index_of(entity) else {
        return Default::default();
    };
    let occluders = world.resource::<Occluders>();
    let see_through = world.resource::<SeeThrough>();
    let mut known = vec![
        world.resource::<VisibleSet>().set.contains(object),
        occluders.camera.contains(object),
        occluders.light.contains(object),
        occluders.shadeable.contains(object),
        see_through.objects.contains(object),
        see_through.two_sided.contains(object),
        world.resource::<SeenInto>().0.contains(object),
        world.resource::<InvisibleObjects>().contains(entity),
        world.resource::<InvertedHulls>().leaves_out(entity),
    ];
    for light in world
        .resource::<FrameLights>()
        .lights
        .iter()
        .filter(|_| with_lights)
    {
        let sets = [&light.sets.l, &light.sets.i, &light.sets.s];
        known.extend(sets.map(|set| set.contains(object)));
    }
    let left_out = world.get::<LeftOutSubmeshes>(entity);
    let left_out = left_out.map(|left_out| left_out.indices().to_vec());
    (known, left_out.unwrap_or_default())
}

/// Exchanges the materials of an object and, if there are meshes to choose from, its mesh.
fn exchange(world: &mut World, entity: Entity, meshes: &[Arc<MeshData>], random: &mut Random) {
    if !meshes.is_empty() && random.chance(0.3) {
        let mesh = meshes[random.below(meshes.len())].clone();
        set(world, entity, SceneMesh(mesh));
    }
    let count = world.get::<SceneMesh>(entity).expect("a mesh").0.submeshes.len();
    let materials = (0..count).map(|_| random_material(random)).collect();
    if world.get::<SceneMaterials>(entity).is_some() {
        set(world, entity, SceneMaterials(materials));
    }
    if random.chance(0.1) {
        let occluder = [Occluder::Own, Occluder::Never][random.below(2)].clone();
        world.entity_mut(entity).insert(occluder);
    }
}

/// In every other scene meshes are exchanged and objects move as well. There the buffers of lights may be older than the bounds
/// of what hides nothing, and L is larger or smaller than in a fresh world.
#[test]
fn exchanges_leave_the_sets_of_a_fresh_world() {
    let mut changes = [0; 9];
    for seed in 0..40 {
        let is_still = seed % 2 == 0;
        let mut world = random_scene(seed);
        let mut random = Random::new(seed ^ 77);
        let at = random.vec(3.0);
        spawn_light(&mut world, &mut random, at);
        let mut query = world.query_filtered::<Entity, With<SceneMesh>>();
        let objects: Vec<Entity> = query.iter(&world).collect();
        let special = special_meshes();
        for &entity in &objects {
            if random.chance(0.3) {
                exchange(&mut world, entity, &special, &mut random);
            }
        }
        let mut schedule = standalone_schedule();
        schedule.run(&mut world);
        for frame in 0..8 {
            let before: Vec<_> = objects
                .iter()
                .map(|&entity| known(&world, entity, false))
                .collect();
            // In the last frame all of them, which is more than is looked up one by one.
            let picks: Vec<Entity> = match frame {
                7 => objects.clone(),
                _ => (0..1 + random.below(4))
                    .map(|_| objects[random.below(objects.len())])
                    .collect(),
            };
            for entity in picks {
                let meshes = if is_still { &[][..] } else { &special };
                exchange(&mut world, entity, meshes, &mut random);
                if !is_still && random.chance(0.3) {
                    let by = random.vec(0.5);
                    world.get_mut::<Transform>(entity).expect("a place").translation += by;
                }
            }
            world.clear_trackers();
            schedule.run(&mut world);
            let (mut copy, pairs) = fresh(&mut world);
            standalone_schedule().run(&mut copy);
            for (old, new) in pairs {
                let (now, expected) = (known(&world, old, is_still), known(&copy, new, is_still));
                assert_eq!(now, expected, "seed {seed}, frame {frame}, {old}");
            }
            for (&entity, (before, _)) in objects.iter().zip(before) {
                let (now, _) = known(&world, entity, false);
                let differ = now.iter().zip(&before).map(|(now, before)| now != before);
                for (count, differs) in changes.iter_mut().zip(differ) {
                    *count += usize::from(differs);
                }
            }
        }
    }
    println!("{changes:?}");
    assert!(
        changes.iter().all(|count| *count > 3),
        "each changes: {changes:?}"
    );
}
