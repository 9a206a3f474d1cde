//! Perspective maps of 1024² on every model: at most 0.5 % of the pixels are wrong further than a texel from an edge, in every
//! view.

use glam::UVec2;

use super::variants;
use crate::harness::maps::{MapError, judge_map};
use crate::harness::{ModelStage, file_name, models_below, models_folder, strict_context};

const SIZE: UVec2 = UVec2::new(80, 45);

/// Share of the pixels of a picture that may be wrong.
const ALLOWED: f64 = 0.005;

/// Pixels that make a share meaningful.
const ENOUGH: usize = 500;

#[test]
fn perspective_maps_equal_ray_cast_on_every_model_up_to_a_texel() {
    let context = strict_context();
    let mut failures = Vec::new();
    for (index, path) in models_below(&models_folder()).iter().enumerate() {
        let name = file_name(path);
        let Some(mut model) = ModelStage::new(path, &context, SIZE) else {
            continue;
        };
        let (mut all, mut worst) = (MapError::default(), (0.0, String::new()));
        for (case_index, (label, case)) in model.cases().into_iter().enumerate() {
            // Most cases have the default settings.
            let variant = if case_index % 3 == index % 3 {
                case_index % 5
            } else {
                0
            };
            model.set(&case, variants(1024)[variant]);
            let rendered = model.stage.render().expect("the frame renders");
            let error = judge_map(&model.stage, &model.scene, 0, &rendered.visibility[0]);
            all.add(error);
            if error.share() > worst.0 {
                worst = (error.share(), format!("{label} {variant}: {error:?}"));
            }
            if error.counted > ENOUGH && error.share() > ALLOWED {
                failures.push(format!(
                    "{name} {label} {variant}: {:.5} {error:?}",
                    error.share()
                ));
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
        assert!(
            all.counted > 8_000 && all.dark > 200,
            "{name}: too little was judged"
        );
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
