//! Barn doors shrink the sets of an interior's lights. The figures are printed: `cargo test … light_model::sizes --
//! --nocapture`.

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::scene::LightShape;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::model;
use crate::harness::support::stage::Stage;
use crate::harness::support::walk::{EYE_HEIGHT, standing_points};

/// Sums of |I|, of |S| and of the pixels in scissors, over eight views of the interior with eight lamps that hang at
/// the height of the ceiling and shine down.
fn sums(doors: Option<LightShape>) -> [u64; 3] {
    let size = UVec2::new(320, 180);
    let mut stage = Stage::empty(size, Camera::default(), Transform::IDENTITY);
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
    let mut sums = [0; 3];
    for (index, eye) in standing_points(&scene, bounds, 8, EYE_HEIGHT)
        .into_iter()
        .enumerate()
    {
        let turn = index as f32 * 2.399_963_2; // the golden angle: all directions alike
        let look = Vec3::new(turn.cos(), -0.05, turn.sin());
        let view = Transform::from_translation(eye.as_vec3()).looking_to(look, Vec3::Y);
        stage
            .world
            .entity_mut(stage.camera)
            .insert((Camera::default(), view));
        stage.schedule.run(&mut stage.world);
        for light in &stage.world.resource::<FrameLights>().lights {
            sums[0] += light.sets.i.count_ones(..) as u64;
            sums[1] += light.sets.s.count_ones(..) as u64;
            sums[2] += light.region.scissor.map_or(0, |scissor| scissor.area());
        }
    }
    sums
}

#[test]
fn doors_of_40_degrees_shrink_the_sets_of_an_interior() {
    let slope = 20f32.to_radians().tan();
    let doors = LightShape {
        width: 0.8 * slope,
        height: 0.8 * slope,
        width_edge: 0.2 * slope,
        height_edge: 0.2 * slope,
        round: 0.0,
    };
    let (open, shut) = (sums(None), sums(Some(doors)));
    println!(
        "sums over 8 views and 8 lights: |I|, |S|, scissor pixels: {open:?} without doors, {shut:?} with"
    );
    for (open, shut) in open.into_iter().zip(shut) {
        assert!(shut > 0 && 2 * shut < open, "{shut} of {open}");
    }
}
