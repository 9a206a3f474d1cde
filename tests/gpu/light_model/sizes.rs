//! Barn doors shrink the sets of an interior's lights. The figures are printed: `cargo test … light_model::sizes --
//! --nocapture`.

use std::time::Instant;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::scene::LightShape;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::support::stage::Stage;
use crate::harness::support::walk::{EYE_HEIGHT, standing_points};
use crate::harness::{model, strict_context};

const SIZE: UVec2 = UVec2::new(320, 180);

/// The interior under eight lamps that hang at the height of the ceiling and shine down, and eight views of it.
fn interior(doors: Option<LightShape>) -> (Stage, Vec<Transform>) {
    let mut stage = Stage::empty(SIZE, Camera::default(), Transform::IDENTITY);
    let loaded = load_gltf(model("interior.glb")).expect("the model loads");
    let spawned = spawn_scene(&mut stage.world, &loaded, None).expect("the model spawns");
    for &camera in &spawned.cameras {
        stage.world.entity_mut(camera).remove::<Camera>();
    }
    for &light in &spawned.lights {
        stage.world.entity_mut(light).remove::<Light>();
    }
    stage.schedule.run(&mut stage.world);
    let bounds = stage.scene_bounds();
    let scene = RayScene::from_world(&mut stage.world);
    let down = Transform::default().looking_to(Vec3::NEG_Y, Vec3::Z);
    for point in standing_points(&scene, bounds, 16, 2.3).into_iter().skip(8) {
        let at = Transform::from_translation(point.as_vec3()).with_rotation(down.rotation);
        let light = Light::point(Vec3::ONE, 60.0, 6.0);
        let entity = stage.spawn_light(light, at, Some(StencilVolume::default()));
        if let Some(doors) = doors {
            stage.world.entity_mut(entity).insert(doors);
        }
    }
    let eyes = standing_points(&scene, bounds, 8, EYE_HEIGHT);
    let views = eyes.into_iter().enumerate().map(|(index, eye)| {
        let turn = index as f32 * 2.399_963_2; // the golden angle: all directions alike
        let look = Vec3::new(turn.cos(), -0.05, turn.sin());
        Transform::from_translation(eye.as_vec3()).looking_to(look, Vec3::Y)
    });
    (stage, views.collect())
}

fn see(stage: &mut Stage, view: Transform) {
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    stage.world.entity_mut(stage.camera).insert((camera, view));
}

/// Sums of |I|, of |S| and of the pixels in scissors, over all views.
fn sums(doors: Option<LightShape>) -> [u64; 3] {
    let (mut stage, views) = interior(doors);
    let mut sums = [0; 3];
    for view in views {
        see(&mut stage, view);
        stage.schedule.run(&mut stage.world);
        for light in &stage.world.resource::<FrameLights>().lights {
            sums[0] += light.sets.i.count_ones(..) as u64;
            sums[1] += light.sets.s.count_ones(..) as u64;
            sums[2] += light.region.scissor.map_or(0, |scissor| scissor.area());
        }
    }
    sums
}

/// Doors that open by 40°.
fn doors_of_40_degrees() -> LightShape {
    let slope = 20f32.to_radians().tan();
    LightShape {
        width: 0.8 * slope,
        height: 0.8 * slope,
        width_edge: 0.2 * slope,
        height_edge: 0.2 * slope,
        round: 0.0,
    }
}

#[test]
fn doors_of_40_degrees_shrink_the_sets_of_an_interior() {
    let (open, shut) = (sums(None), sums(Some(doors_of_40_degrees())));
    println!(
        "sums over 8 views and 8 lights: |I|, |S|, scissor pixels: {open:?} without doors, {shut:?} with"
    );
    for (open, shut) in open.into_iter().zip(shut) {
        assert!(shut > 0 && 2 * shut < open, "{shut} of {open}");
    }
}

/// Draws a frame and waits for its end.
fn draw(stage: &mut Stage) {
    stage.time_passes().expect("the frame renders");
    let context = stage.world.resource::<Renderer>().context();
    let all = wgpu::PollType::wait_indefinitely();
    context.device.poll(all).expect("the device answers");
}

/// Prints the time of frames with doors beside that of frames without, the median over all views and turns.
#[test]
#[ignore = "a table for people"]
fn frames_of_an_interior_with_doors_by_hand() {
    let mut stages = [None, Some(doors_of_40_degrees())].map(|doors| {
        let (mut stage, views) = interior(doors);
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        (stage, views)
    });
    let mut times = [const { Vec::new() }; 2];
    for turn in 0..4 {
        for view in 0..8 {
            for ((stage, views), times) in stages.iter_mut().zip(&mut times) {
                see(stage, views[view]);
                draw(stage); // silhouettes and uploads
                let start = Instant::now();
                draw(stage);
                if turn > 0 {
                    times.push(start.elapsed().as_secs_f64() * 1e3);
                }
            }
        }
    }
    let [open, shut] = times.map(|mut times| {
        times.sort_by(f64::total_cmp);
        times[times.len() / 2]
    });
    println!(
        "a frame of {SIZE}: {open:.1} ms without doors, {shut:.1} ms with doors of 40°, {:.2} times",
        shut / open
    );
}
