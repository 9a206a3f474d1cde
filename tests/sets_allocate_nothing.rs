//! After warm-up a frame allocates nothing in the systems of the sets: not at rest, and not when everything moves.

#![allow(
    unsafe_code,
    reason = "a global allocator that counts cannot be written without"
)]

#[path = "core/sets_harness/mod.rs"]
mod sets_harness;

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;
use std::sync::Arc;

use antumbra::prelude::{
    Camera, LightPath, Material, MeshData, OcclusionInterval, OmniMap, PenumbraWedge, PerspectiveMap,
    SceneMaterials, SceneMesh, ShadowCaster, ShadowMap, ShadowReceiver, Smoothie, StencilVolume,
};
use antumbra::reports::Reports;
use antumbra::scene::{
    BarnMap, Cookie, CookieImage, Light, LightDistance, LightKind, LightProfile, LightShape, LightWeights,
    ShadowOrigin, ShadowSoftness, ShadowTint, WorldBounds,
};
use antumbra::schedule::{add_systems, collect_reports, init_resources};
use antumbra::sets::{SetWork, ViewportSize, collect_sets};
use antumbra::techniques::occlusion_interval::{BakeStatistics, BakedSurface, Corner, Page, surface_hash};
use antumbra::techniques::{IntervalLibrary, IntervalMaps, PenumbraWedges, PerspectiveMaps};
use bevy_ecs::prelude::*;
use bevy_ecs::schedule::SingleThreadedExecutor;
use bevy_transform::prelude::GlobalTransform;
use glam::Vec3;
use sets_harness::{VIEWPORT, random_scene, rooms, spawn};

struct Counting;

thread_local! {
    /// Allocations of this thread; the test harness has threads of its own.
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

// SAFETY: everything is handed to `System`; counting touches a thread-local without a destructor.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: the caller's promise is passed on.
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: likewise.
        unsafe { System.dealloc(pointer, layout) }
    }

    unsafe fn realloc(&self, pointer: *mut u8, layout: Layout, size: usize) -> *mut u8 {
        COUNT.set(COUNT.get() + 1);
        // SAFETY: likewise.
        unsafe { System.realloc(pointer, layout, size) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn allocations(mut work: impl FnMut()) -> usize {
    let before = COUNT.get();
    work();
    COUNT.get() - before
}

fn schedule() -> Schedule {
    let mut schedule = Schedule::default();
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.add_systems(collect_sets());
    schedule
}

#[test]
fn a_frame_allocates_nothing_after_warm_up() {
    for scene in [random_scene(3), random_scene(4), rooms(1, 6)] {
        let order: Vec<usize> = (0..scene.things.len()).collect();
        let (mut world, _) = spawn(&scene, &order);
        let mut schedule = schedule();
        let mut bounds = world.query::<&mut WorldBounds>();
        let mut lights = world.query_filtered::<&mut GlobalTransform, With<Light>>();
        let mut move_all = |world: &mut World, by: f32| {
            for mut bounds in bounds.iter_mut(world) {
                bounds.0.min.x += by;
                bounds.0.max.x += by;
            }
            for mut transform in lights.iter_mut(world) {
                let moved = transform.affine();
                let mut moved = moved;
                moved.translation.y += by;
                *transform = moved.into();
            }
        };
        for _ in 0..3 {
            move_all(&mut world, 0.01);
            schedule.run(&mut world);
        }
        assert_eq!(allocations(|| schedule.run(&mut world)), 0, "at rest");
        let before = *world.resource::<SetWork>();
        for by in [0.02, -0.5, 0.7] {
            move_all(&mut world, by);
            assert_eq!(
                allocations(|| schedule.run(&mut world)),
                0,
                "everything moves by {by}"
            );
        }
        assert!(world.resource::<SetWork>().light_words > before.light_words);
        world.resource_mut::<ViewportSize>().0 = VIEWPORT * 2;
        assert_eq!(allocations(|| schedule.run(&mut world)), 0, "another view");
    }
}

/// Gives every light all parts of a light model. Directional lights report those that do not fit them.
fn give_models(world: &mut World, images: &[Arc<CookieImage>; 2]) {
    let text = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n5 4 3\n";
    let profile = LightProfile::from_ies(text).expect("the file is read");
    let mut lights = world.query_filtered::<Entity, With<Light>>();
    for light in lights.iter(world).collect::<Vec<_>>() {
        world.entity_mut(light).insert((
            LightShape {
                width: 2.0,
                height: 1.0,
                width_edge: 0.5,
                height_edge: 0.5,
                round: 0.5,
            },
            LightDistance {
                far: 500.0,
                ..LightDistance::default()
            },
            LightWeights {
                ambient: 0.5,
                ..LightWeights::default()
            },
            ShadowTint {
                darkness: 0.5,
                ..ShadowTint::default()
            },
            ShadowOrigin::Position(Vec3::ONE),
            ShadowSoftness(0.1),
            Cookie::new(images[0].clone()),
            profile.clone(),
            BarnMap::default(),
        ));
    }
}

#[test]
fn lights_with_models_allocate_nothing_after_warm_up() {
    let white = |name| CookieImage::from_linear(name, 1, 1, vec![Vec3::ONE]).expect("a picture");
    let images = [white("a"), white("b")];
    let scene = random_scene(3);
    let order: Vec<usize> = (0..scene.things.len()).collect();
    let (mut world, _) = spawn(&scene, &order);
    give_models(&mut world, &images);
    let mut schedule = schedule();
    let mut cookies = world.query::<(&mut Cookie, &mut LightShape, &mut GlobalTransform)>();
    let mut change = |world: &mut World, frame: usize| {
        for (mut cookie, mut shape, mut transform) in cookies.iter_mut(world) {
            cookie.image = images[frame % 2].clone();
            cookie.turn += 0.1;
            shape.width += 0.01;
            let mut moved = transform.affine();
            moved.translation.y += 0.01;
            *transform = moved.into();
        }
    };
    for frame in 0..3 {
        change(&mut world, frame);
        schedule.run(&mut world);
    }
    assert_eq!(allocations(|| schedule.run(&mut world)), 0, "at rest");
    for frame in 3..6 {
        change(&mut world, frame);
        assert_eq!(allocations(|| schedule.run(&mut world)), 0, "all of it changes");
    }
    let lights = &world.resource::<antumbra::sets::FrameLights>().lights;
    assert!(lights.iter().any(|light| light.model.shape.is_some()));
    assert!(lights.iter().all(|light| light.textures.cookie.is_some()));
}

fn place(x: f32, y: f32, z: f32) -> GlobalTransform {
    GlobalTransform::from_translation(Vec3::new(x, y, z))
}

/// A world with a camera, and the systems of a frame without threads.
fn viewed() -> (World, Schedule, Entity) {
    let mut world = World::new();
    init_resources(&mut world);
    let mut frame = Schedule::default();
    frame.set_executor(SingleThreadedExecutor::new());
    add_systems(&mut frame);
    world.resource_mut::<ViewportSize>().0 = VIEWPORT;
    let camera = world.spawn((Camera::default(), place(0.0, 2.0, 8.0))).id();
    (world, frame, camera)
}

fn add_mesh(world: &mut World, mesh: MeshData, at: GlobalTransform) {
    world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        at,
    ));
}

#[test]
fn perspective_maps_and_smoothies_allocate_nothing_after_warm_up() {
    let (mut world, mut frame, camera) = viewed();
    add_mesh(&mut world, MeshData::plane(30.0), place(0.0, 0.0, 0.0));
    for i in 0..12 {
        let at = place(i as f32 - 6.0, 0.6, -(i as f32) * 2.0);
        add_mesh(&mut world, MeshData::cuboid(Vec3::splat(0.4)), at);
    }
    let sun = GlobalTransform::from_rotation(glam::Quat::from_rotation_x(-0.8));
    for (light, at) in [
        (Light::directional(Vec3::ONE, 1.0), sun),
        (Light::point(Vec3::ONE, 50.0, 40.0), place(1.0, 4.0, -3.0)),
    ] {
        world.spawn((light.clone(), at, PerspectiveMap::default()));
        world.spawn((light, at, Smoothie::default()));
    }
    let mut run = |world: &mut World, by: f32| {
        let mut view = world
            .get_mut::<GlobalTransform>(camera)
            .expect("it stands somewhere");
        *view = place(0.01 * by, 2.0, 8.0);
        frame.run(world);
        world.clear_trackers();
    };
    for step in [0, 1, 2, 3, 4, 0] {
        run(&mut world, step as f32);
    }
    assert_eq!(world.resource::<PerspectiveMaps>().fits.len(), 2);
    assert_eq!(world.resource::<PerspectiveMaps>().fitted_anew, 2);
    for step in 1..5 {
        assert_eq!(allocations(|| run(&mut world, step as f32)), 0, "the view moves");
    }
    assert_eq!(world.resource::<PerspectiveMaps>().fitted_anew, 2);
}

/// A plane in the maps of a sun, a box that is not in them, and a second technique that shadows by it.
#[test]
fn lights_with_two_techniques_allocate_nothing_after_warm_up() {
    let (mut world, mut frame, camera) = viewed();
    let plane = MeshData::plane(30.0);
    let path = LightPath::Arc {
        direction: Vec3::new(-1.0, -1.0, -0.5),
        axis: Vec3::Z,
        degrees: 60.0,
    };
    let maps = IntervalMaps {
        key: 0,
        path: path.clone(),
        texels_per_metre: 1.0,
        size: 4,
        pages: vec![Page::dark(4, 1)],
        surfaces: vec![BakedSurface {
            mesh: "plane".to_owned(),
            hash: surface_hash(&plane, &plane.submeshes[0]),
            world_from_local: glam::Affine3A::IDENTITY.to_cols_array(),
            is_two_sided: true,
            casts: true,
            corners: 0..plane.indices.len() as u32,
        }],
        corners: vec![Corner::NOWHERE; plane.indices.len()],
        statistics: BakeStatistics::default(),
    };
    world
        .resource_mut::<IntervalLibrary>()
        .insert("plane", Arc::new(maps));
    add_mesh(&mut world, plane, place(0.0, 0.0, 0.0));
    let cuboid = MeshData::cuboid(Vec3::splat(0.4));
    add_mesh(&mut world, cuboid, place(0.0, 1.0, 0.0));
    let sun = GlobalTransform::from_rotation(glam::Quat::from_rotation_x(-0.8));
    let settings = OcclusionInterval {
        maps: "plane".to_owned(),
        ..OcclusionInterval::default()
    };
    let light = Light::directional(Vec3::ONE, 1.0);
    world.spawn((light, sun, path, settings, StencilVolume::default()));
    let mut run = |world: &mut World, step: u32| {
        let mut view = world
            .get_mut::<GlobalTransform>(camera)
            .expect("it stands somewhere");
        view.set_if_neq(place(0.01 * step as f32, 2.0, 8.0));
        frame.run(world);
        world.clear_trackers();
    };
    for step in 0..4 {
        run(&mut world, step);
    }
    let lights = world.resource::<antumbra::sets::FrameLights>();
    let counts: Vec<_> = lights
        .lights
        .iter()
        .map(|light| [&light.sets.i, &light.sets.s].map(|set| set.count_ones(..)))
        .collect();
    // The plane casts nothing on what is above it.
    assert_eq!(counts, [[2, 2], [1, 1], [1, 1]], "the light, the plane, the box");
    for step in [3, 3, 4, 5, 4] {
        assert_eq!(allocations(|| run(&mut world, step)), 0, "step {step}");
    }
}

/// A ball that reaches into a shade of many triangles and into the plane above it.
#[test]
fn lights_that_surfaces_cut_allocate_nothing_after_warm_up() {
    let (mut world, mut frame, camera) = viewed();
    for (mesh, at) in [
        (MeshData::plane(30.0), place(0.0, 0.0, 0.0)),
        (MeshData::plane(3.0), place(0.0, 2.1, 0.0)),
        (MeshData::icosphere(0.4, 3), place(0.0, 2.0, 0.0)),
    ] {
        world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            (ShadowCaster, ShadowReceiver),
            at,
        ));
    }
    let kind = LightKind::Sphere { radius: 0.5 };
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 50.0, 40.0)
    };
    let lamp = world
        .spawn((light, place(0.0, 2.0, 0.0), PenumbraWedge::default()))
        .id();
    let mut run = |world: &mut World, moved: Entity, at: GlobalTransform| {
        *world
            .get_mut::<GlobalTransform>(moved)
            .expect("it stands somewhere") = at;
        frame.run(world);
        world.clear_trackers();
    };
    let lamp_at = |step: i32| place(0.0, 2.0 + 0.04 * (step % 3) as f32, 0.0);
    for step in 0..6 {
        run(&mut world, lamp, lamp_at(step));
    }
    assert!(world.resource::<PenumbraWedges>().wedges.len() > 50, "it is cut");
    for step in 1..5 {
        let view = place(0.01 * step as f32, 2.0, 8.0);
        assert_eq!(allocations(|| run(&mut world, camera, view)), 0, "the view moves");
    }
    for step in 0..6 {
        let count = allocations(|| run(&mut world, lamp, lamp_at(step)));
        assert_eq!(count, 0, "the lamp moves");
    }
}

#[test]
fn reports_that_stand_allocate_nothing() {
    let mut world = World::new();
    init_resources(&mut world);
    // Without the propagation of transforms, which needs a task pool. The pool would be there for the other test as well,
    // and spreading work over its threads allocates.
    let mut frame = Schedule::default();
    frame.set_executor(SingleThreadedExecutor::new());
    add_systems(&mut frame);
    let mut collect = Schedule::default();
    collect.set_executor(SingleThreadedExecutor::new());
    collect.add_systems(collect_reports);
    for _ in 0..3 {
        let dark = Light::point(Vec3::ONE, 1.0, 0.0);
        world.spawn((dark, bevy_transform::prelude::Transform::default()));
        let sun = Light::directional(Vec3::ONE, 1.0);
        world.spawn((sun.clone(), OmniMap::default(), StencilVolume::default()));
        world.spawn((sun, OmniMap::default()));
        world.spawn((ShadowMap::default(), GlobalTransform::IDENTITY));
    }
    frame.run(&mut world);
    collect.run(&mut world);
    collect.run(&mut world);
    assert_eq!(world.resource::<Reports>().iter().count(), 12);
    assert_eq!(allocations(|| collect.run(&mut world)), 0);
    world.spawn((ShadowMap::default(), GlobalTransform::IDENTITY));
    assert!(allocations(|| collect.run(&mut world)) > 0, "a new report does");
}

#[test]
fn the_counter_counts() {
    let boxed = allocations(|| drop(std::hint::black_box(Box::new(Vec3::ONE))));
    assert_eq!(boxed, 1);
}
