//! Shadows in Bevy are those of our own renderer, and the truth.

use antumbra::prelude::RequestedFeatures;
use antumbra::reference::{VisibilityImage, compare_hard};
use antumbra::techniques::StencilVolume;
use glam::UVec2;

use crate::core_harness::{ModelStage, models_folder, strict_context, truth};
use crate::harness::Picture;
use crate::models::ModelGame;

const SIZE: UVec2 = UVec2::new(128, 72);

/// Visibility that Bevy's picture shows: what is left of the light where there is any; NaN elsewhere.
fn visibility(shadowed: &Picture, lit: &Picture) -> Vec<f32> {
    let pairs = shadowed.texels.iter().zip(&lit.texels);
    pairs
        .map(|(a, b)| {
            let (a, b) = (f32::from(a[1]), f32::from(b[1]));
            if b > 0.0 { a / b } else { f32::NAN }
        })
        .collect()
}

/// What a scene says.
#[derive(Debug, Default)]
struct Outcome {
    counted: usize,
    shadowed: usize,
    unlike_standalone: usize,
    wrong_inner: usize,
    wrong_all: usize,
}

fn compare(path: &std::path::Path, case: usize) -> Outcome {
    let context = strict_context(RequestedFeatures::default());
    let mut model = ModelStage::new(path, &context, SIZE).expect("triangles");
    let (label, case) = model.cases().swap_remove(case);
    model.set(&case, StencilVolume::default());
    let standalone = model.stage.render().expect("the frame renders").visibility.swap_remove(0);
    let mut lit = ModelGame::new(&mut model.stage, false, StencilVolume::default());
    let mut shadowed = ModelGame::new(&mut model.stage, true, StencilVolume::default());
    let (lit, shadowed) = (lit.picture(), shadowed.picture());
    let name = path.file_stem().unwrap().to_string_lossy();
    lit.save(&format!("shadows_{name}_{label}_lit"));
    shadowed.save(&format!("shadows_{name}_{label}"));
    println!(
        "{name} {label}: mean radiance {} lit, {} shadowed; camera {:?} at {:?}, light {:?} at {:?}",
        lit.mean(),
        shadowed.mean(),
        case.camera,
        case.view.translation,
        case.light,
        case.place.translation,
    );
    let got = visibility(&shadowed, &lit);
    let truth = truth(&model.stage, &model.scene, 0);
    let mut outcome = Outcome::default();
    // What Bevy's light does not reach cannot be told.
    let told: Vec<f32> = truth
        .values()
        .iter()
        .zip(&got)
        .map(|(truth, got)| if got.is_nan() { f32::NAN } else { *truth })
        .collect();
    for ((truth, got), ours) in told.iter().zip(&got).zip(&standalone) {
        if !truth.is_nan() {
            outcome.counted += 1;
            outcome.shadowed += usize::from(*truth == 0.0);
            outcome.unlike_standalone += usize::from((*got > 0.5) != (*ours > 0.5));
        }
    }
    let got = got.iter().map(|got| if *got > 0.5 { 1.0 } else { 0.0 }).collect();
    let (told, got) = (VisibilityImage::new(SIZE, told).unwrap(), VisibilityImage::new(SIZE, got).unwrap());
    let error = compare_hard(&told, &got).unwrap();
    (outcome.wrong_inner, outcome.wrong_all) = (error.wrong_inner, error.wrong_all);
    println!("{name} {label}: {outcome:?}");
    outcome
}

#[test]
fn stencil_shadows_equal_the_standalone_mask_and_the_truth() {
    let Some(folder) = models_folder("stencil_shadows_equal_the_standalone_mask_and_the_truth") else {
        return;
    };
    for (model, case) in SCENES {
        let outcome = compare(&folder.join(model), case);
        assert!(outcome.counted > 500 && outcome.shadowed > 50, "too little is seen");
        assert_eq!(outcome.unlike_standalone, 0);
        assert_eq!(outcome.wrong_inner, 0);
    }
}

const SCENES: [(&str, usize); 3] = [
    ("look/d-scenes/many_cubes.glb", 0),
    ("copy/d-scenes/interior.glb", 9),
    ("look/c-animated/fox.glb", 3),
];
