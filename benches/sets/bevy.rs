//! Beside Bevy 0.19.1's `check_point_light_mesh_visibility`: one world, one run, two threads for each.
//!
//! Timed on Bevy's side: that one system, which transforms the local bounds of every mesh for every visible light, tests them
//! against the light's ball and the six frusta of its cube map, and sorts what it keeps. It has neither an I nor an S.
//!
//! Timed on ours, all of it: `update_world_bounds` (boxes in world space of what moved, from `LocalBounds` and
//! `GlobalTransform`) and the chain `collect_sets()`, which is `collect_objects`, `collect_view`, `collect_frustum_set`,
//! `collect_visible_set`, `collect_frame_lights`, `collect_light_sets`, `collect_light_occlusion`,
//! `collect_illumination` (with scissors and depth bounds) and `collect_shadow_sets`: F, V, L, I and S of all lights,
//! seen or not. Each side runs in a schedule of its own; ours on the single-threaded executor, for its systems are a
//! chain, with tasks inside.
//!
//! Timed on neither: the motion itself, the propagation of transforms, what finds the frusta and the visible lights
//! (Bevy has that in other systems).
//!
//! Both are run in turns, and the least time counts. Before that S is asserted to hold nothing that Bevy would not draw
//! into the light's shadow map, and Bevy's map to hold nothing in range that L does not.

use std::any::TypeId;
use std::collections::HashSet;
use std::time::Instant;

use antumbra::sets::{FrameLights, LightVolume, Objects, init_set_resources};
use bevy_app::{App, TaskPoolOptions, TaskPoolPlugin};
use bevy_camera::primitives::Aabb;
use bevy_camera::visibility::{CubemapVisibleEntities, NoAutoAabb, VisibleEntities};
use bevy_camera::{
    Camera, Camera3d, CameraPlugin, CameraProjection, PerspectiveProjection, Projection, RenderTargetInfo,
};
use bevy_ecs::prelude::*;
use bevy_light::cluster::{ClusterVisibilityClass, GlobalClusterSettings};
use bevy_light::{LightPlugin, PointLight, check_point_light_mesh_visibility};
use bevy_math::Vec3A;
use bevy_mesh::Mesh3d;
use bevy_transform::TransformPlugin;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use crate::field::{self, Random};

/// Which objects move in a frame: each so many-th; 0 for none.
const MOTIONS: [(&str, usize); 3] = [("static", 0), ("moving10", 10), ("moving", 1)];

/// Times every case.
pub fn run(short: bool) {
    println!("\nbeside Bevy's check_point_light_mesh_visibility, two threads each, least of the frames, µs");
    println!(
        "{:<14} {:>10} {:>12} {:>10} {:>9}",
        "case", "pairs", "Bevy µs", "ours µs", "ratio"
    );
    let cases: &[(usize, usize)] = if short {
        &[(10_000, 8), (100_000, 64)]
    } else {
        &[
            (10_000, 8),
            (10_000, 64),
            (10_000, 256),
            (100_000, 8),
            (100_000, 64),
            (100_000, 256),
        ]
    };
    for &(objects, lights) in cases {
        for range in [20.0, 60.0] {
            compare(objects, lights, range, short);
        }
    }
}

fn compare(objects: usize, lights: usize, range: f32, short: bool) {
    let mut app = app(objects, lights, range);
    let world = app.world_mut();
    let mut bevy = Schedule::default();
    bevy.add_systems(check_point_light_mesh_visibility);
    let mut ours = field::schedule();
    for _ in 0..2 {
        bevy.run(world);
        ours.run(world);
    }
    assert_agrees(world, objects, lights, range);
    let frames = match (objects * lights) as u64 {
        _ if short => 5,
        0..1_000_000 => 60,
        1_000_000..10_000_000 => 20,
        _ => 8,
    };
    let mut step = 0.02;
    for (name, every) in MOTIONS {
        let mut least = [f64::INFINITY; 2];
        for _ in 0..frames {
            step = -step;
            if every > 0 {
                field::shake(world, every, step);
            }
            for (schedule, least) in [&mut bevy, &mut ours].into_iter().zip(&mut least) {
                let start = Instant::now();
                schedule.run(world);
                *least = least.min(start.elapsed().as_secs_f64() * 1e6);
            }
        }
        assert_agrees(world, objects, lights, range);
        let [bevy, ours] = least;
        let ratio = bevy / ours;
        println!(
            "{:<14} {:>10} {bevy:>12.1} {ours:>10.1} {ratio:>9.1}",
            format!("{name}_r{range}"),
            objects * lights,
        );
        println!("speedup {name}_r{range} {objects}x{lights} {ratio:.1}");
    }
}

/// The field in a world that both run in.
fn app(objects: usize, lights: usize, range: f32) -> App {
    let mut app = App::new();
    app.add_plugins(TaskPoolPlugin {
        task_pool_options: TaskPoolOptions::with_num_threads(2),
    });
    app.add_plugins((
        TransformPlugin,
        bevy_asset::AssetPlugin::default(),
        bevy_mesh::MeshPlugin,
        CameraPlugin,
        LightPlugin,
    ));
    bevy_asset::AssetApp::init_asset::<bevy_image::Image>(&mut app);
    // What Bevy's renderer would insert.
    app.insert_resource(GlobalClusterSettings {
        supports_storage_buffers: true,
        clustered_decals_are_usable: false,
        gpu_clustering: None,
        max_uniform_buffer_clusterable_objects: 204,
        view_cluster_bindings_max_indices: 16384,
    });
    app.finish();
    app.cleanup();
    let world = app.world_mut();
    init_set_resources(world);
    field::spawn_camera(world);
    let mut random = Random::new();
    for (index, place) in field::objects(&mut random, objects).into_iter().enumerate() {
        let aabb = Aabb {
            center: Vec3A::ZERO,
            half_extents: Vec3A::from(field::HALF),
        };
        world.spawn((Mesh3d::default(), aabb, NoAutoAabb, place, field::object(index)));
    }
    for place in field::lights(&mut random, lights) {
        let light = PointLight {
            range,
            shadow_maps_enabled: true,
            ..Default::default()
        };
        world.spawn((light, place, field::light(range)));
    }
    let mut projection = PerspectiveProjection {
        aspect_ratio: 16.0 / 9.0,
        ..Default::default()
    };
    projection.update(1920.0, 1080.0);
    let mut camera = Camera::default();
    camera.computed.clip_from_view = projection.get_clip_from_view();
    camera.computed.target_info = Some(RenderTargetInfo {
        physical_size: UVec2::new(1920, 1080),
        scale_factor: 1.0,
    });
    let place = Transform::from_translation(field::EYE).looking_at(Vec3::ZERO, Vec3::Y);
    world.spawn((Camera3d::default(), camera, Projection::Perspective(projection), place));
    for _ in 0..3 {
        app.update();
    }
    app
}

/// Holds our sets against what Bevy would draw into the shadow maps of the lights that it sees.
fn assert_agrees(world: &mut World, object_count: usize, light_count: usize, range: f32) {
    let mut views = world.query::<&VisibleEntities>();
    let visible: HashSet<Entity> = views
        .iter(world)
        .flat_map(|view| view.get(TypeId::of::<ClusterVisibilityClass>()).to_vec())
        .collect();
    let mut maps = world.query::<&CubemapVisibleEntities>();
    let mut transforms = world.query::<&GlobalTransform>();
    let objects = world.resource::<Objects>();
    let frame = world.resource::<FrameLights>();
    assert_eq!((objects.len(), frame.lights.len()), (object_count, light_count));
    let (mut drawn, mut cast, mut looked, mut more) = (0, 0, 0, 0);
    for light in &frame.lights {
        let LightVolume::Ball(ball) = light.volume else {
            panic!("a point light with a range has a ball");
        };
        if !visible.contains(&light.entity) {
            continue;
        }
        looked += 1;
        let Ok(map) = maps.get(world, light.entity) else {
            panic!("Bevy has no cube map for the light");
        };
        let faces = map.iter().flat_map(|face| &face.entities);
        let in_map: HashSet<Entity> = faces.copied().collect();
        for object in light.s.ones() {
            let entity = objects.entities[object];
            if !in_map.contains(&entity) {
                let Ok(place) = transforms.get(world, entity) else {
                    continue;
                };
                let d = place.translation().distance(ball.center);
                if more < 5 { println!("more: {d} range {range}"); }
                more += 1;
            }
        }
        drawn += in_map.len();
        cast += light.s.count_ones(..);
    }
    assert!(looked > 0 && drawn > 0 && cast > 0, "nothing was compared");
    println!("  {looked} lights seen: {drawn} objects in Bevy's maps, {cast} in S, {more} not in map");
}
