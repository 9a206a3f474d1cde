//! Table 15-1: the draws and time that each kind of visibility saves over a walk through a scene.

use std::path::Path;
use std::time::{Duration, Instant};

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::render::RenderError;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::sets::OcclusionSettings;
use bevy_transform::prelude::Transform;
use glam::UVec2;

use super::stage::{Stage, one_line};
use super::stats::Batches;
use super::walk::walk;

/// A row of the table. It has everything that the rows before it have, and one thing more.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Name of the row in the chapter.
    pub name: &'static str,
    /// Occlusion that is switched on.
    pub occlusion: OcclusionSettings,
    /// Whether scissor rectangles and depth bounds are switched on.
    pub scissor: bool,
    /// The chapter's own normalized frame rate and batch count, for its scenes 1 and 2.
    pub chapter: [(f64, usize); 2],
}

/// Returns the rows of table 15-1.
pub fn rows() -> [Row; 5] {
    let all = OcclusionSettings::default();
    let none = OcclusionSettings {
        from_camera: false,
        from_lights: false,
        of_shadows: false,
        ..all
    };
    let camera = OcclusionSettings {
        from_camera: true,
        ..none
    };
    let lights = OcclusionSettings {
        from_lights: true,
        ..camera
    };
    let row = |name, occlusion, scissor, chapter| Row {
        name,
        occlusion,
        scissor,
        chapter,
    };
    [
        row(
            "Frustum-based visibility",
            none,
            false,
            [(0.87, 1171), (0.56, 1414)],
        ),
        row("Visibility occlusion", camera, false, [(0.92, 492), (0.80, 521)]),
        row("Lighting occlusion", lights, false, [(0.99, 468), (0.98, 438)]),
        row("Shadow occlusion", all, false, [(0.99, 460), (0.98, 437)]),
        row("Scissor rectangle", all, true, [(1.00, 460), (1.00, 437)]),
    ]
}

/// A scene with its own lights, all with shadows, and a walk through it.
pub struct Walked {
    /// World, schedule and renderer.
    pub stage: Stage,
    /// Camera transform of each frame.
    pub views: Vec<Transform>,
}

/// Returns the camera of a walk.
pub fn walking_camera(size: UVec2) -> Camera {
    Camera {
        vertical_fov: 60f32.to_radians(),
        aspect: size.x as f32 / size.y as f32,
        ..Camera::default()
    }
}

impl Walked {
    /// Loads a scene and finds a walk through it. Only the lights whose numbers `shines` chooses are switched on.
    ///
    /// # Errors
    /// One line that names the file.
    pub fn new(
        scene: &Path,
        context: &RenderContext,
        size: UVec2,
        frames: usize,
        shines: impl Fn(usize) -> bool,
    ) -> Result<Self, String> {
        let named = |error: &dyn std::error::Error| format!("{}: {}", scene.display(), one_line(error));
        let mut stage = Stage::empty(size, walking_camera(size), Transform::IDENTITY);
        let loaded = load_gltf(scene).map_err(|error| one_line(&error))?;
        let spawned = spawn_scene(&mut stage.world, &loaded, None).map_err(|error| one_line(&error))?;
        for &camera in &spawned.cameras {
            stage.world.entity_mut(camera).remove::<Camera>();
        }
        for (number, &light) in spawned.lights.iter().enumerate() {
            if !shines(number) {
                stage.world.entity_mut(light).remove::<Light>();
                continue;
            }
            stage.shadow_by_default(light);
            stage.lights.push(light);
        }
        stage.run();
        let bounds = stage.scene_bounds();
        let views = walk(&RayScene::from_world(&mut stage.world), bounds, frames);
        stage
            .add_renderer(context.clone(), RenderSettings::default())
            .map_err(|error| named(&error))?;
        Ok(Self { stage, views })
    }

    /// Applies the settings of a row of the table.
    pub fn set_row(&mut self, row: &Row) {
        self.stage.world.insert_resource(row.occlusion);
        let settings = &mut self.stage.world.resource_mut::<Renderer>().settings;
        settings.scissor = row.scissor;
        settings.depth_bounds = row.scissor;
    }

    /// Moves the camera to a frame of the walk.
    pub fn set_view(&mut self, frame: usize) {
        let camera = self.stage.camera;
        self.stage.world.entity_mut(camera).insert(self.views[frame]);
    }

    /// Prepares one frame of the walk without drawing it. Returns its batches.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn count(&mut self, frame: usize) -> Result<Batches, RenderError> {
        self.set_view(frame);
        self.stage.run();
        let mut renderer = self.stage.world.resource_mut::<Renderer>();
        if let Some(failure) = renderer.take_failure() {
            return Err(failure);
        }
        renderer.context().queue.submit([]); // otherwise the writes wait for the next submission
        Ok(Batches::of_frame(&renderer))
    }

    /// Draws one frame of the walk. Returns its batches, and the time until the device was done.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn draw(&mut self, frame: usize) -> Result<(Batches, Duration), RenderError> {
        self.set_view(frame);
        let begin = Instant::now();
        self.stage.draw()?;
        let time = begin.elapsed();
        Ok((Batches::of_frame(self.stage.world.resource::<Renderer>()), time))
    }
}
