//! The bundled models under a light of 0.5 m at 4 m, scaled to a radius of 1 m; `examples/gallery --soft-table` prints
//! the same for a folder of models.

use std::path::Path;

use antumbra::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use crate::harness::{ModelStage, strict_context};
use crate::scenes::{SAMPLES, SIZE, judge, rect, truth};

#[test]
fn models_err_little_and_split_lights_less() {
    let context = strict_context(RequestedFeatures::default());
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models");
    for name in ["deer", "suzanne", "generic_hand_left"] {
        let mut model =
            ModelStage::new(&folder.join(format!("{name}.glb")), &context, SIZE).expect("it has triangles");
        let center = model.bounds.center();
        let unit = model.bounds.half_size().length();
        let at = |direction: Vec3, distance: f32| center + direction.normalize() * (distance * unit);
        let stage = &mut model.stage;
        let camera = Camera {
            vertical_fov: 0.9,
            near: 0.01 * unit,
            aspect: SIZE.x as f32 / SIZE.y as f32,
            ..Camera::default()
        };
        let view =
            Transform::from_translation(at(Vec3::new(0.5, 0.45, 0.9), 2.8)).looking_at(center, Vec3::Y);
        let entity = stage.camera;
        stage.world.entity_mut(entity).insert((camera, view));
        let light = Light {
            kind: rect(0.5 * unit, 0.5 * unit),
            color: Vec3::ONE,
            intensity: 10.0,
            range: 20.0 * unit,
        };
        let place =
            Transform::from_translation(at(Vec3::new(0.5, 1.0, 0.35), 4.0)).looking_at(center, Vec3::Z);
        let light = stage.spawn_light(light, place, Some(PenumbraWedge::default()));
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
