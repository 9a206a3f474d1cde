//! What the GPU tests share: a device whose errors fail the test, the models, and their judgement.

#![allow(dead_code, reason = "each test uses a part")]

#[path = "../../examples/support/mod.rs"]
pub mod support;

pub mod cases;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    HardError, LightSource, RayScene, VisibilityImage, compare_hard, hard_visibility, primary_hits,
};
use bevy_transform::prelude::GlobalTransform;
pub use support::solid::make_alpha_solid;
use support::stage::Stage;

/// A device that panics on any wgpu error: silent validation is part of every test.
pub fn strict_context(requested: RequestedFeatures) -> RenderContext {
    let context = pollster::block_on(RenderContext::headless(requested)).expect("a GPU adapter is needed");
    context
        .device
        .on_uncaptured_error(Arc::new(|error| panic!("wgpu error: {error}")));
    context
}

/// Folder of the models named by `ANTUMBRA_MODELS`; says that the caller's test is skipped when it is not set.
pub fn models_folder(test: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("ANTUMBRA_MODELS").map(PathBuf::from);
    if folder.is_none() {
        eprintln!("{test}: skipped, ANTUMBRA_MODELS does not name the folder of the models");
    }
    folder
}

/// All glTF files below a folder, sorted. Fails if there are none.
pub fn models_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let entries = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for entry in entries {
            let path = entry.expect("a folder entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "glb" || extension == "gltf") {
                found.push(path);
            }
        }
    }
    assert!(!found.is_empty(), "no models below {}", folder.display());
    found.sort();
    found
}

/// Truth for one light of the stage, for the frame that ran last.
pub fn truth(stage: &Stage, scene: &RayScene, light: usize) -> VisibilityImage {
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("the stage has a camera");
    let transform = world.get::<GlobalTransform>(stage.camera).expect("and it stands somewhere");
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(scene, camera, transform, size).expect("the camera is usable");
    let source = LightSource::of_entity(world, stage.lights[light]).expect("the light is usable");
    hard_visibility(scene, &hits, &source)
}

/// Judges one light's rendered visibility.
pub fn judge(stage: &Stage, scene: &RayScene, light: usize, rendered: &[f32]) -> HardError {
    let truth = truth(stage, scene, light);
    let got = VisibilityImage::new(truth.size(), rendered.to_vec()).expect("a whole picture");
    compare_hard(&truth, &got).expect("pictures of one size")
}
