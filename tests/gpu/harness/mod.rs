//! What the GPU tests share: a device whose errors fail the test, the models, and their judgement.

#![allow(dead_code, unused_imports, reason = "each test uses a part")]

pub use antumbra_stage as support;

pub mod cases;
pub mod half;
pub mod map_twin;
pub mod maps;
pub mod radiance;

use std::path::{Path, PathBuf};
use std::sync::{Arc, LazyLock};

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::reference::{
    HardError, LightSource, RayScene, VisibilityImage, compare_hard, hard_visibility, primary_hits,
};
use antumbra::render::Gpu;
use bevy_ecs::prelude::Bundle;
use bevy_transform::prelude::GlobalTransform;
use glam::{UVec2, Vec3};
use support::model::Model;
use support::shared_gpu::shared_gpu;
pub use support::solid::make_alpha_solid;
use support::stage::Stage;

/// The device that tests of a program share, and with it the shaders and pipelines. It panics on any wgpu error: silent
/// validation is part of every test.
pub fn strict_context() -> RenderContext {
    static SHARED: LazyLock<Arc<Gpu>> = LazyLock::new(|| {
        let context = own_context(RequestedFeatures::default());
        shared_gpu(context).expect("shaders compose")
    });
    SHARED.context.clone()
}

/// A device for one test alone: it is to be lost, or has other features. It panics on any wgpu error, too.
pub fn own_context(requested: RequestedFeatures) -> RenderContext {
    let context = pollster::block_on(RenderContext::headless(requested)).expect("a GPU adapter is needed");
    context
        .device
        .on_uncaptured_error(Arc::new(|error| panic!("wgpu error: {error}")));
    context
}

/// Folder of the models: what `ANTUMBRA_MODELS` names, else the few that are bundled.
pub fn models_folder() -> PathBuf {
    std::env::var_os("ANTUMBRA_MODELS").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models"),
        PathBuf::from,
    )
}

/// A model by its file name, somewhere below [`models_folder`]. A test that asks for one which is not bundled is marked
/// `#[ignore]`, so that the summary counts it where the model is missing.
pub fn model(name: &str) -> PathBuf {
    let folder = models_folder();
    let mut all = models_below(&folder).into_iter();
    all.find(|path| path.ends_with(name)).unwrap_or_else(|| {
        panic!(
            "{}: {name} is not there; ANTUMBRA_MODELS names the folder",
            folder.display()
        )
    })
}

/// All glTF files below a folder, sorted. Fails if there are none.
pub fn models_below(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let entries =
            std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for entry in entries {
            let path = entry.expect("a folder entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path
                .extension()
                .is_some_and(|extension| extension == "glb" || extension == "gltf")
            {
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
    let transform = world
        .get::<GlobalTransform>(stage.camera)
        .expect("and it stands somewhere");
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

/// A model on a ground plane, ready to be lit and judged; `None` if it has no triangles.
pub struct ModelStage {
    /// World, schedule and renderer.
    pub stage: Stage,
    /// The same triangles for the judge.
    pub scene: RayScene,
    /// Bounds of the model without the ground.
    pub bounds: Aabb,
    /// A point of the model's surface.
    pub vertex: Vec3,
}

impl ModelStage {
    /// Loads a model, takes its own lights and cameras away, and lays a ground under it.
    pub fn new(path: &Path, context: &RenderContext, size: UVec2) -> Option<Self> {
        let Model {
            mut stage,
            bounds,
            vertex,
        } = Model::load(path, context, size).expect("the model loads")?;
        let scene = RayScene::from_world(&mut stage.world);
        Some(Self {
            stage,
            scene,
            bounds,
            vertex,
        })
    }

    /// Puts the camera and one light where a case says.
    pub fn set(&mut self, case: &cases::Case, shadow: impl Bundle) {
        let camera = self.stage.camera;
        self.stage
            .world
            .entity_mut(camera)
            .insert((case.camera, case.view));
        for light in self.stage.lights.drain(..) {
            self.stage.world.despawn(light);
        }
        self.stage
            .spawn_light(case.light.clone(), case.place, Some(shadow));
    }

    /// All cases of this model, with their names.
    pub fn cases(&self) -> Vec<(String, cases::Case)> {
        let size = self.stage.world.resource::<ViewportSize>().0;
        let aspect = size.x as f32 / size.y as f32;
        let mut all = Vec::new();
        for placement in cases::PLACEMENTS {
            for kind in cases::KINDS {
                let case = cases::case(self.bounds, self.vertex, placement, kind, aspect);
                all.push((format!("{placement:?} {kind}"), case));
            }
        }
        all
    }

    /// One of so many cases. Where it begins depends on the number of the model, so that the models together have every
    /// kind of light in every placement.
    pub fn some_cases(
        &self,
        model: usize,
        one_of: usize,
    ) -> impl Iterator<Item = (String, cases::Case)> + use<> {
        self.cases().into_iter().skip(model % one_of).step_by(one_of)
    }
}

/// The last part of a path.
pub fn file_name(path: &Path) -> String {
    path.file_name()
        .unwrap_or_default()
        .to_string_lossy()
        .into_owned()
}

/// A composer that knows the files of the renderer and of the crate's techniques.
pub fn shaders() -> antumbra::render::Shaders {
    let shaders = antumbra::render::Shaders::new().expect("the common files compose");
    for row in antumbra::techniques::Techniques::default().rows() {
        shaders.add(row.shaders()).expect("the technique's files compose");
    }
    shaders
}
