//! Comparison with Bevy 0.19.1's `check_point_light_mesh_visibility`, in one world and one run, with two threads for
//! each side.
//!
//! On Bevy's side, only that system is timed. For every visible light, it transforms the local bounds of every mesh,
//! tests them against the light's ball and the six frusta of its cube map, and sorts what it keeps. It computes
//! neither an I nor an S.
//!
//! On our side, everything is timed: `update_world_bounds` (boxes in world space of what moved, from `LocalBounds`
//! and `GlobalTransform`) and the chain `collect_sets()`. The chain is `collect_objects`, `collect_view`,
//! `collect_frustum_set`, `collect_visible_set`, `collect_frame_lights`, `collect_light_sets`,
//! `collect_light_occlusion`, `collect_illumination` (with scissors and depth bounds) and `collect_shadow_sets`. It
//! computes F, V, L, I and S of all lights, seen or not. Each side runs in a schedule of its own. Ours uses the
//! single-threaded executor, because its systems are a chain with tasks inside.
//!
//! Neither side's time includes the motion itself, the propagation of transforms, or the search for frusta and
//! visible lights (other systems of Bevy do that).
//!
//! Both sides take turns, and the least time counts. Two assertions hold before and after: S holds nothing that Bevy
//! would not draw into the light's shadow map, and L holds everything in range that Bevy draws.

use std::any::TypeId;
use std::collections::HashSet;
use std::time::Instant;

use antumbra::sets::{FrameLight, FrameLights, LightVolume, Objects, init_set_resources};
use bevy::camera::primitives::Aabb;
use bevy::camera::visibility::{CubemapVisibleEntities, NoAutoAabb, VisibleEntities};
use bevy::camera::{
    Camera, Camera3d, CameraPlugin, CameraProjection, PerspectiveProjection, Projection, RenderTargetInfo,
};
use bevy::light::cluster::{ClusterVisibilityClass, GlobalClusterSettings};
use bevy::light::{LightPlugin, PointLight, check_point_light_mesh_visibility};
use bevy::math::Vec3A;
use bevy::mesh::Mesh3d;
use bevy_app::{App, TaskPoolOptions, TaskPoolPlugin};
use bevy_ecs::prelude::*;
use bevy_transform::TransformPlugin;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, UVec2, Vec3};

use crate::field::{self, Random};

/// Which objects move in a frame: every n-th one, or none if it is 0.
const MOTIONS: [(&str, usize); 3] = [("static", 0), ("moving10", 10), ("moving", 1)];

/// Times every case.
pub fn run(short: bool) {
    println!("\nbeside Bevy's check_point_light_mesh_visibility, two threads each, least of the frames, µs");
    println!(
        "{:<14} {:>10} {:>12} {:>10} {:>9}",
        "case", "pairs", "Bevy µs", "ours µs", "ratio"
    );
    let cases: &[(usize, usize)] = if short {
        &[(10_000, 8), (10_000, 64)]
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
    let agreement = assert_agrees(world);
    assert_comparison_can_fail(world);
    println!(
        "{objects} objects, {lights} lights of {range} m, {} of them seen: {} objects in Bevy's maps, {} in S, none of them elsewhere",
        agreement.lights, agreement.drawn, agreement.cast
    );
    let frames = match (objects * lights) as u64 {
        _ if short => 3,
        0..1_000_000 => 60,
        1_000_000..10_000_000 => 40,
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
        assert_agrees(world);
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

/// Builds the field in a world that both sides use.
fn app(objects: usize, lights: usize, range: f32) -> App {
    let mut app = App::new();
    app.add_plugins(TaskPoolPlugin {
        task_pool_options: TaskPoolOptions::with_num_threads(2),
    });
    app.add_plugins((
        TransformPlugin,
        bevy::asset::AssetPlugin::default(),
        bevy::mesh::MeshPlugin,
        CameraPlugin,
        LightPlugin,
    ));
    // With this feature, Bevy's lights have gizmos.
    #[cfg(feature = "bevy-gizmos")]
    app.add_plugins(bevy::gizmos::GizmoPlugin);
    bevy::asset::AssetApp::init_asset::<bevy::image::Image>(&mut app);
    // Bevy's renderer would insert these.
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
    world.spawn((
        Camera3d::default(),
        camera,
        Projection::Perspective(projection),
        place,
    ));
    for _ in 0..3 {
        app.update();
    }
    app
}

/// Counts of what was compared.
struct Agreement {
    lights: usize,
    drawn: usize,
    cast: usize,
}

/// Compares our sets with what Bevy would draw into the shadow maps of the lights that it sees.
fn compare_sets(world: &mut World) -> Result<Agreement, String> {
    let mut views = world.query::<&VisibleEntities>();
    let visible: HashSet<Entity> = views
        .iter(world)
        .flat_map(|view| view.get(TypeId::of::<ClusterVisibilityClass>()).to_vec())
        .collect();
    let mut maps = world.query::<&CubemapVisibleEntities>();
    let places = world.query::<&GlobalTransform>();
    let objects = world.resource::<Objects>();
    let frame = world.resource::<FrameLights>();
    let mut agreement = Agreement {
        lights: 0,
        drawn: 0,
        cast: 0,
    };
    for light in frame
        .lights
        .iter()
        .filter(|light| visible.contains(&light.entity))
    {
        let LightVolume::Ball(ball) = light.volume else {
            return Err(format!("{} has a range, and no ball", light.entity));
        };
        let map = maps.get(world, light.entity).map_err(|error| error.to_string())?;
        let in_map: HashSet<Entity> = map.iter().flat_map(|face| &face.entities).copied().collect();
        let place = |entity| {
            places
                .get_manual(world, entity)
                .copied()
                .map_err(|error| error.to_string())
        };
        for &entity in &in_map {
            let reached = objects
                .index_of(entity)
                .is_some_and(|object| light.sets.l.contains(object));
            if !reached && gap_of_box(&place(entity)?, ball.center) < f64::from(ball.radius) {
                return Err(format!("{entity} is in range of {} and not in L", light.entity));
            }
        }
        for entity in light.sets.s.ones().map(|object| objects.entities[object]) {
            // At the border, either side may round either way. Ours favours the object, by about 0.3 mm at 200 m.
            let beyond = gap_of_oriented_box(&place(entity)?, ball.center) - f64::from(ball.radius);
            if !in_map.contains(&entity) && beyond.abs() > 1e-3 {
                return Err(format!(
                    "{entity} is in S of {}, and not in its map",
                    light.entity
                ));
            }
        }
        agreement.lights += 1;
        agreement.drawn += in_map.len();
        agreement.cast += light.sets.s.count_ones(..);
    }
    Ok(agreement)
}

fn assert_agrees(world: &mut World) -> Agreement {
    match compare_sets(world) {
        Ok(agreement) => {
            assert!(
                agreement.lights > 0 && agreement.drawn > 0 && agreement.cast > 0,
                "nothing was compared"
            );
            agreement
        }
        Err(what) => panic!("{what}"),
    }
}

/// Negative control: the comparison finds one extra object in S and one missing from L.
fn assert_comparison_can_fail(world: &mut World) {
    type Spoil = fn(&mut FrameLight);
    let spoil: [Spoil; 2] = [
        |light| light.sets.s.insert_range(..),
        |light| light.sets.l.clear(),
    ];
    for spoil in spoil {
        let lights = world.resource::<FrameLights>().lights.clone();
        world
            .resource_mut::<FrameLights>()
            .lights
            .iter_mut()
            .for_each(spoil);
        assert!(compare_sets(world).is_err(), "the comparison finds nothing");
        world.resource_mut::<FrameLights>().lights = lights;
    }
}

/// Returns the distance from a point to the world-space box around an object of the field.
fn gap_of_box(place: &GlobalTransform, point: Vec3) -> f64 {
    let affine = place.affine();
    let half = DVec3::from_array(
        [0, 1, 2].map(|row| f64::from(affine.matrix3.row(row).abs().dot(field::HALF.into()))),
    );
    let offset = (place.translation().as_dvec3() - point.as_dvec3()).abs();
    (offset - half).max(DVec3::ZERO).length()
}

/// Returns the distance from a point to the plane that touches an object of the field and is perpendicular to the
/// line between them.
fn gap_of_oriented_box(place: &GlobalTransform, point: Vec3) -> f64 {
    let offset = place.translation().as_dvec3() - point.as_dvec3();
    let normal = offset.normalize();
    let m = place.affine().matrix3;
    let reach = [m.x_axis, m.y_axis, m.z_axis].map(|axis| Vec3::from(axis).as_dvec3().dot(normal).abs());
    offset.length() - DVec3::from_array(reach).dot(field::HALF.as_dvec3())
}
