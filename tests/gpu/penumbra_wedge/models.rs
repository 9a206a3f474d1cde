//! The bundled models under a light of 0.5 m at 4 m, scaled to a radius of 1 m; `examples/gallery --soft-table` prints
//! the same for a folder of models.

use std::path::Path;

use antumbra::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::flicker::{ALLOWED, Changes};
use super::scenes::{SAMPLES, SIZE, judge, rect, rendered, truth};
use crate::harness::{ModelStage, strict_context};

/// A bundled model under its light, which is `moved` along x by a share of the model's radius.
fn stage_of(context: &RenderContext, name: &str) -> (ModelStage, impl Fn(f32) -> Transform + use<>) {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models");
    let mut model =
        ModelStage::new(&folder.join(format!("{name}.glb")), context, SIZE).expect("it has triangles");
    let center = model.bounds.center();
    let unit = model.bounds.half_size().length();
    let at = move |direction: Vec3, distance: f32| center + direction.normalize() * (distance * unit);
    let stage = &mut model.stage;
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.01 * unit,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_translation(at(Vec3::new(0.5, 0.45, 0.9), 2.8)).looking_at(center, Vec3::Y);
    let entity = stage.camera;
    stage.world.entity_mut(entity).insert((camera, view));
    let light = Light {
        kind: rect(0.5 * unit, 0.5 * unit),
        color: Vec3::ONE,
        intensity: 10.0,
        range: 20.0 * unit,
    };
    let place = move |moved: f32| {
        let from = at(Vec3::new(0.5, 1.0, 0.35), 4.0) + Vec3::X * (moved * unit);
        Transform::from_translation(from).looking_at(center, Vec3::Z)
    };
    stage.spawn_light(light, place(0.0), Some(PenumbraWedge::default()));
    (model, place)
}

#[test]
fn models_err_little_and_split_lights_less() {
    let context = strict_context();
    for name in ["deer", "suzanne", "generic_hand_left"] {
        let (mut model, _) = stage_of(&context, name);
        let stage = &mut model.stage;
        let light = stage.lights[0];
        let truth = truth(stage, 0, SAMPLES);
        for (split, all, penumbra) in [(1, 0.03, 0.12), (3, 0.015, 0.06)] {
            let wedge = PenumbraWedge {
                split: [split; 2],
                ..Default::default()
            };
            stage.world.entity_mut(light).insert(wedge);
            let error = judge(stage, &truth, &format!("{name}_{split}"));
            assert!(
                error.rmse <= all && error.rmse_penumbra <= penumbra,
                "{name} {split}: {error:?}"
            );
        }
    }
}

/// Where surfaces touch at less than the rasterizer's steps, a pixel may jump: seldom.
#[test]
fn under_a_slowly_moving_light_pixels_of_models_seldom_jump() {
    let context = strict_context();
    for name in ["deer", "suzanne", "generic_hand_left"] {
        let (mut model, place) = stage_of(&context, name);
        let stage = &mut model.stage;
        let light = stage.lights[0];
        let mut changes = Changes::default();
        for frame in 0..12 {
            stage.world.entity_mut(light).insert(place(0.01 * frame as f32));
            let truth = truth(stage, 0, 256);
            changes.add(rendered(stage, 0), truth);
        }
        let flicker = changes.flicker();
        println!("{name}: {flicker:.3?}");
        assert!(
            flicker.rare <= ALLOWED && flicker.jumps <= 20,
            "{name}: {flicker:?}"
        );
    }
}
