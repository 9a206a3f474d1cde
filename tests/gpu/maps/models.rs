//! Default maps of 1024² on every model: at most 0.5 % of the pixels are wrong further than a texel from an edge.

use antumbra::prelude::*;
use antumbra::techniques::maps::MapResolution;
use glam::UVec2;

use crate::harness::maps::{MapError, judge_map};
use crate::harness::{ModelStage, file_name, models_below, models_folder, strict_context};

const SIZE: UVec2 = UVec2::new(128, 72);

/// Share of the pixels of a picture that may be wrong.
const ALLOWED: f64 = 0.005;

#[test]
fn maps_equal_ray_cast_on_every_model_up_to_a_texel() {
    let folder = models_folder();
    let context = strict_context();
    let resolution = MapResolution::Fixed(1024);
    let (mut failures, mut total) = (Vec::new(), MapError::default());
    for (index, path) in models_below(&folder).iter().enumerate() {
        let name = file_name(path);
        let Some(mut model) = ModelStage::new(path, &context, SIZE) else {
            println!("{name:<32} has no triangles");
            continue;
        };
        let (mut all, mut worst) = (MapError::default(), (0.0, String::new()));
        // The judge traces rays around every pixel in doubt.
        let one_of = if model.scene.triangles().len() > 100_000 {
            7
        } else {
            4
        };
        for (label, case) in model.some_cases(index, one_of) {
            if case.light.kind == LightKind::Point {
                let map = OmniMap {
                    resolution,
                    ..Default::default()
                };
                model.set(&case, map);
            } else {
                let map = ShadowMap {
                    resolution,
                    ..Default::default()
                };
                model.set(&case, map);
            }
            let rendered = model.stage.render().expect("the frame renders");
            let error = judge_map(&model.stage, &model.scene, 0, &rendered.visibility[0]);
            all.add(error);
            if error.share() > worst.0 {
                worst = (error.share(), format!("{label}: {error:?}"));
            }
            if error.share() > ALLOWED {
                failures.push(format!("{name} {label}: {:.5} {error:?}", error.share()));
            }
        }
        println!(
            "{name:<32} {:>7} judged {:>7} dark {:>5} wrong ({:.5}), {} acne, worst {:.5} {}",
            all.counted,
            all.dark,
            all.wrong,
            all.share(),
            all.acne,
            worst.0,
            worst.1
        );
        assert!(all.counted > 1_000, "{name}: too little was judged: {all:?}");
        total.add(all);
    }
    assert!(total.counted > 400_000 && total.dark > 60_000, "{total:?}");
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
