//! Tables for people: errors on models through the day, and what baking and drawing cost.
//!
//! ```sh
//! cargo test --release --all-features --test gpu occlusion_interval -- --ignored --nocapture by_hand
//! ```

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Instant;

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::scene::PathPoint;
use antumbra::techniques::{IntervalLibrary, IntervalMaps, Techniques};
use bevy_ecs::prelude::Entity;
use bevy_transform::prelude::Transform;
use glam::{DVec3, UVec2, Vec3};

use super::scenes::{seen, truth_of};
use crate::harness::support::shot::Shot;
use crate::harness::support::stage::Stage;
use crate::harness::{model, strict_context};

/// A model in the sun of a summer's day, seen as a whole.
fn of_model(name: &str, size: UVec2) -> Stage {
    let text = serde_json::json!({
        "scene": model(name),
        "size": size.to_array(),
        "lights": [{
            "kind": "directional", "path": {"latitude_deg": 40, "day": 172, "hours": [5, 19]},
            "shadow": {"technique": "occlusion_interval", "maps": "by hand"},
        }],
    });
    let shot = Shot::parse(&text.to_string(), Techniques::default()).expect("the shot is right");
    let mut stage = Stage::of_shot(&shot).expect("the model loads");
    stage.world.insert_resource(FaceCulling::None);
    stage.schedule.run(&mut stage.world);
    stage
}

fn bake(stage: &mut Stage, texels_per_metre: f32) -> Arc<IntervalMaps> {
    let settings = BakeSettings {
        texels_per_metre,
        ..Default::default()
    };
    let path = stage
        .world
        .get::<LightPath>(stage.lights[0])
        .expect("it has a path")
        .clone();
    let start = Instant::now();
    let bake = bake_intervals(&mut stage.world, &path, &settings, |_| ()).expect("it is baked");
    let statistics = bake.maps.statistics;
    println!(
        "{texels_per_metre} texels a metre: {} texels, {} pages of {}, {} layers, {:.1} bytes a texel; {} rays, {:.2} M/s, {:.1} s in all; {} notes",
        statistics.texels,
        bake.maps.pages.len(),
        bake.maps.size,
        bake.maps.layer_count(),
        bake.maps.bytes() as f64 / statistics.texels as f64,
        statistics.rays,
        statistics.rays as f64 / statistics.seconds / 1e6,
        start.elapsed().as_secs_f64(),
        bake.notes.len(),
    );
    let notes: Vec<String> = bake.notes.iter().map(ToString::to_string).collect();
    let not_flat = notes.iter().filter(|note| note.contains("cannot be laid flat"));
    for note in not_flat.take(5) {
        println!("{note}");
    }
    Arc::new(bake.maps)
}

fn insert(stage: &mut Stage, maps: Arc<IntervalMaps>) {
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    stage
        .world
        .resource_mut::<IntervalLibrary>()
        .insert("by hand", maps);
}

fn set(stage: &mut Stage, time: f32, width: f32) {
    let light = stage.lights[0];
    let mut settings = stage
        .world
        .get_mut::<OcclusionInterval>(light)
        .expect("the technique");
    (settings.time, settings.width) = (time, width);
}

/// Prints the error at 20 times of the day.
fn errors(name: &str, texels_per_metre: f32) {
    let mut stage = of_model(name, UVec2::new(96, 54));
    println!("{name}");
    let maps = bake(&mut stage, texels_per_metre);
    let path = maps.path.clone();
    insert(&mut stage, maps);
    let (scene, hits) = seen(&mut stage);
    let (mut worst, mut sum) = (0.0f32, 0.0);
    for step in 0..20 {
        let (time, width) = ((step as f32 + 0.5) / 20.0, 0.03);
        set(&mut stage, time, width);
        let rendered = stage.render().expect("the frame renders");
        let truth = truth_of(&scene, &hits, &path, (time, width), texels_per_metre);
        let error = |is_off: fn(bool) -> bool| {
            let counted = truth
                .iter()
                .zip(&rendered.visibility[0])
                .filter_map(|(truth, drawn)| {
                    let (truth, varies) = (*truth)?;
                    is_off(varies).then_some((truth - drawn).powi(2))
                });
            let (sum, count) = counted.fold((0.0, 0), |(sum, count), error| (sum + error, count + 1));
            ((sum / count.max(1) as f32).sqrt(), count)
        };
        let ((off, off_count), (all, count)) = (error(|varies| !varies), error(|_| true));
        let wrong = truth.iter().zip(&rendered.visibility[0]);
        let wrong = wrong.filter(|(truth, drawn)| {
            truth.is_some_and(|(truth, varies)| !varies && (truth - **drawn).abs() > 0.5)
        });
        println!(
            "{time:.3}: {off:.4} over {off_count} pixels off the band of a texel, {} of them by more than half; {all:.4} over all {count}",
            wrong.count()
        );
        worst = worst.max(off);
        sum += off;
    }
    println!("{name}: mean {:.4}, worst {worst:.4}", sum / 20.0);
}

#[test]
#[ignore = "a table, and town_A.glb is not bundled"]
fn errors_on_a_town_by_hand() {
    errors("town_A.glb", 2.0);
}

#[test]
#[ignore = "a table"]
fn errors_in_an_interior_by_hand() {
    errors("interior.glb", 8.0);
}

#[test]
#[ignore = "a table, and town_A.glb is not bundled"]
fn rays_per_second_by_hand() {
    let mut stage = of_model("town_A.glb", UVec2::new(96, 54));
    let maps = bake(&mut stage, 0.5);
    let scene = RayScene::from_world(&mut stage.world);
    // The same number of points and directions, without what a bake saves.
    let directions: Vec<DVec3> = (0..256)
        .filter_map(|step| match maps.path.at((step as f32 + 0.5) / 256.0) {
            PathPoint::Direction(direction) => Some(-direction.as_dvec3()),
            PathPoint::Position(_) => None,
        })
        .collect();
    let start = Instant::now();
    let (mut rays, mut blocked) = (0u64, 0u64);
    for (slot, triangle) in (0u32..).zip(scene.triangles()).step_by(7) {
        let [a, b, c] = triangle.corners;
        let (point, normal) = ((a + b + c) / 3.0, (b - a).cross(c - a));
        for &towards in directions.iter().filter(|towards| normal.dot(**towards) > 0.0) {
            rays += 1;
            blocked += u64::from(scene.blocks_direction(point, towards, Some(slot), u32::MAX));
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    println!(
        "a plain loop on one thread: {rays} rays, {blocked} blocked, {:.2} M/s",
        rays as f64 / seconds / 1e6
    );
}

/// Time that all threads of this process took, milliseconds, where the system tells it; else the time that went by. The former
/// is the same on a busy machine.
fn spent(start: Instant) -> f64 {
    let of_process = || {
        let mut nanoseconds = 0.0;
        for thread in std::fs::read_dir("/proc/self/task").ok()? {
            let text = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
            nanoseconds += text.split_whitespace().next()?.parse::<f64>().ok()?;
        }
        Some(nanoseconds * 1e-6)
    };
    of_process().unwrap_or_else(|| start.elapsed().as_secs_f64() * 1e3)
}

/// The middle of some numbers.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// Spawns a small object on top of the scene that is in no maps. While it is a receiver, nothing dark may be left out.
fn spawn_stranger(stage: &mut Stage) -> Entity {
    let bounds = stage.scene_bounds();
    let place = Transform::from_translation(bounds.center().with_y(bounds.max.y));
    let mesh = Arc::new(MeshData::cuboid(Vec3::splat(0.05)));
    let materials = SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into());
    stage.world.spawn((SceneMesh(mesh), materials, place)).id()
}

/// Frames without and with the shadow take turns, so that drift affects all of them equally. The last way is one in which most
/// triangles are dark and all of them are drawn.
#[test]
#[ignore = "a table"]
fn cost_of_a_frame_by_hand() {
    const FRAMES: usize = 21;
    let mut stage = of_model("interior.glb", UVec2::new(640, 360));
    let maps = bake(&mut stage, 4.0);
    insert(&mut stage, maps);
    let light = stage.lights[0];
    let shadowed = stage
        .world
        .get::<OcclusionInterval>(light)
        .expect("the technique")
        .clone();
    let stranger = spawn_stranger(&mut stage);
    let begin = Instant::now();
    let ways = [
        None,
        Some((0.3, 0.0, false)),
        Some((0.3, 0.03, false)),
        Some((0.3, 0.3, false)),
        Some((0.3, 0.03, true)),
    ];
    let mut frames: [Vec<f64>; 5] = Default::default();
    let mut passes: [BTreeMap<String, Vec<f64>>; 5] = Default::default();
    for frame in 0..=FRAMES {
        for (at, way) in ways.into_iter().enumerate() {
            match way {
                None => {
                    stage.world.entity_mut(light).remove::<OcclusionInterval>();
                }
                Some((time, width, is_stranger)) => {
                    let mut stranger = stage.world.entity_mut(stranger);
                    if is_stranger {
                        stranger.insert(ShadowReceiver);
                    } else {
                        stranger.remove::<ShadowReceiver>();
                    }
                    stage.world.entity_mut(light).insert(shadowed.clone());
                    set(&mut stage, time, width);
                }
            }
            stage.draw().expect("the frame is drawn"); // makes what this way needs
            let start = spent(begin);
            let times = stage.time_passes().expect("the frame is drawn");
            // The first frame compiles.
            if frame > 0 {
                frames[at].push(spent(begin) - start);
                for pass in times {
                    passes[at].entry(pass.label).or_default().push(pass.milliseconds);
                }
            }
        }
    }
    let frames = frames.map(median);
    for ((way, frame), passes) in ways.into_iter().zip(frames).zip(passes) {
        let name = way.map_or("unshadowed".to_owned(), |(time, width, is_stranger)| {
            let beside = if is_stranger { ", all drawn" } else { "" };
            format!("time {time}, width {width}{beside}")
        });
        let times = passes
            .into_iter()
            .map(|(label, times)| format!("{label} {:.1}", median(times)));
        println!(
            "{name}: {frame:.1} ms, {:.3} times the unshadowed light; passes in ms: {}",
            frame / frames[0],
            times.collect::<Vec<_>>().join(", ")
        );
    }
}
