//! Stencil shadow volumes against the ray caster, on every model, from outside and inside of shadows.

use crate::harness::{ModelStage, file_name, judge, models_below, models_folder, strict_context};
use antumbra::prelude::*;
use glam::UVec2;

const SIZE: UVec2 = UVec2::new(160, 90);

/// Share of wrong pixels outside of the edge band that any shot may have. What is measured is less by a factor of
/// four: single pixels beyond the band where a shadow's edge grazes a surface, so that rounding moves it sideways.
const ALLOWED: f64 = 0.001;

#[test]
fn stencil_equals_ray_cast_on_every_model() {
    let folder = models_folder();
    let context = strict_context();
    let mut failures = Vec::new();
    for path in models_below(&folder) {
        let name = file_name(&path);
        let Some(mut model) = ModelStage::new(&path, &context, SIZE) else {
            println!("{name:<32} has no triangles");
            continue;
        };
        let (mut inner, mut dark, mut worst) = (0, 0, (0.0, String::new()));
        for (label, case) in model.cases() {
            model.set(&case, StencilVolume::default());
            let rendered = model.stage.render().expect("the frame renders");
            let error = judge(&model.stage, &model.scene, 0, &rendered.visibility[0]);
            inner += error.inner;
            dark += rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
            let share = error.share().unwrap_or(0.0);
            if share > worst.0 {
                worst = (share, format!("{label}: {error:?}"));
            }
            if share > ALLOWED {
                failures.push(format!("{name} {label}: {error:?}"));
            }
        }
        println!(
            "{name:<32} {inner:>7} judged {dark:>7} dark, worst {:.5} {}",
            worst.0, worst.1
        );
        assert!(inner > 30_000 && dark > 10_000, "{name}: too little was judged");
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
