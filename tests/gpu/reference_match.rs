//! Stencil shadow volumes against the ray caster, on every model, from outside and inside of shadows.

use crate::harness::radiance::{judge_radiance, show_lights_alone};
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
    for (index, path) in models_below(&folder).iter().enumerate() {
        let name = file_name(path);
        let Some(mut model) = ModelStage::new(path, &context, SIZE) else {
            println!("{name:<32} has no triangles");
            continue;
        };
        show_lights_alone(&mut model.stage);
        let (mut inner, mut lit, mut dark, mut worst) = (0, 0, 0, (0.0, String::new()));
        for (label, case) in model.some_cases(index, 2) {
            model.set(&case, StencilVolume::default());
            let rendered = model.stage.render().expect("the frame renders");
            let error = judge(&model.stage, &model.scene, 0, &rendered.visibility[0]);
            inner += error.inner;
            let shown = judge_radiance(&model.stage, &model.scene, &rendered.radiance);
            lit += shown.inner;
            dark += rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
            let share = error.share().unwrap_or(0.0);
            if share > worst.0 {
                worst = (share, format!("{label}: {error:?}"));
            }
            if share > ALLOWED {
                failures.push(format!("{name} {label}: {error:?}"));
            }
            if shown.share().unwrap_or(0.0) > ALLOWED {
                failures.push(format!("{name} {label}, radiance: {shown:?}"));
            }
        }
        println!(
            "{name:<32} {inner:>7} judged {dark:>7} dark, worst {:.5} {}",
            worst.0, worst.1
        );
        assert!(
            inner > 15_000 && lit > 10_000 && dark > 4_000,
            "{name}: too little was judged"
        );
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

/// A light that is cut off where it should shine is noticed, though its mask stays the same.
#[test]
fn a_light_that_is_cut_off_is_noticed() {
    let path = models_below(&models_folder()).swap_remove(0);
    let mut model = ModelStage::new(&path, &strict_context(), SIZE).expect("triangles");
    show_lights_alone(&mut model.stage);
    let (_, case) = model.cases().swap_remove(0);
    model.set(&case, StencilVolume::default());
    let mut radiance = model.stage.render().expect("the frame renders").radiance;
    let judged = |radiance: &[f32]| judge_radiance(&model.stage, &model.scene, radiance).share();
    assert!(judged(&radiance).expect("pixels count") <= ALLOWED);
    let half = radiance.len() / 2;
    radiance[half..].fill(0.0);
    assert!(judged(&radiance).expect("pixels count") > 10.0 * ALLOWED);
}
