//! One of the pictures that are compared: a world with the scene and the lights of a document, and its renderer.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::{Gpu, PassTime, RenderError, VISIBILITY_FORMAT, create_target};
use antumbra::reports::Reports;
use antumbra::scene::gltf_import::{LoadedGltf, SpawnedScene, spawn_scene};
use antumbra::scene::{
    LightDistance, LightShape, LightWeights, ShadowOrigin, ShadowSoftness, ShadowTint, apply_animation,
};
use antumbra::schedule::SetTimes;
use antumbra::techniques::{Techniques, add_row};
use antumbra_stage::picture::light_texture;
use antumbra_stage::stage::{Stage, one_line};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::document::{Document, LightDoc, Pose, Side};
use crate::given::{GivenPicture, GivenVisibility};
use crate::target::Target;

/// Where the visibility of a picture comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shading {
    /// From the techniques of a side.
    Techniques(Side),
    /// From pictures of the truth.
    Given,
}

/// A world that is drawn.
pub struct SideStage {
    /// World, schedule, camera and lights.
    pub stage: Stage,
    shading: Shading,
    loaded: Arc<LoadedGltf>,
    spawned: SpawnedScene,
    applied: Vec<LightDoc>,
    /// Why each light is not as the document says.
    pub errors: Vec<Option<String>>,
    posed: Option<Pose>,
}

impl std::fmt::Debug for SideStage {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SideStage")
            .field("shading", &self.shading)
            .field("errors", &self.errors)
            .finish_non_exhaustive()
    }
}

/// The components of the light model that a shot's light may have.
type ModelParts = (
    LightShape,
    LightDistance,
    LightWeights,
    ShadowTint,
    ShadowOrigin,
    ShadowSoftness,
    Cookie,
    LightProfile,
);

impl SideStage {
    /// Spawns a scene without lights.
    ///
    /// # Errors
    /// One line that says what the device or the scene refuses.
    pub fn new(
        gpu: &Arc<Gpu>,
        loaded: &Arc<LoadedGltf>,
        shading: Shading,
        techniques: &Techniques,
    ) -> Result<Self, String> {
        let mut stage = Stage::empty(UVec2::ONE, Camera::default(), Transform::IDENTITY);
        stage.world.insert_resource(FaceCulling::None);
        for row in techniques.rows() {
            add_row(*row, &mut stage.world, &mut stage.schedule);
        }
        if shading == Shading::Given {
            let row = antumbra::techniques::Row::of::<GivenVisibility>();
            add_row(row, &mut stage.world, &mut stage.schedule);
        }
        let renderer = Renderer::on(gpu.clone()).map_err(|error| one_line(&error))?;
        stage.world.insert_resource(renderer);
        let spawned = spawn_scene(&mut stage.world, loaded, None).map_err(|error| one_line(&error))?;
        for &camera in &spawned.cameras {
            stage.world.entity_mut(camera).remove::<Camera>();
        }
        for &light in &spawned.lights {
            stage.world.entity_mut(light).remove::<Light>();
        }
        Ok(Self {
            stage,
            shading,
            loaded: loaded.clone(),
            spawned,
            applied: Vec::new(),
            errors: Vec::new(),
            posed: None,
        })
    }

    /// Makes the world that of a document.
    pub fn apply(&mut self, document: &Document, size: UVec2) {
        let world = &mut self.stage.world;
        world.insert_resource(ViewportSize(size));
        if let Some(view) = &document.view {
            let aspect = size.x as f32 / size.y.max(1) as f32;
            let forward = (view.target - view.eye).try_normalize().unwrap_or(Vec3::NEG_Z);
            let transform = Transform::from_translation(view.eye).looking_to(forward, view.up);
            let camera = Camera {
                aspect,
                ..view.camera
            };
            world.entity_mut(self.stage.camera).insert((camera, transform));
        }
        if self.posed != document.pose {
            let pose = document.pose.unwrap_or(Pose { clip: 0, time: 0.0 });
            if let Some(clip) = self.loaded.clips.get(pose.clip) {
                apply_animation(world, &self.spawned, clip, pose.time);
            }
            self.posed = document.pose;
        }
        let mut renderer = world.resource_mut::<Renderer>();
        renderer.settings.ambient = document.ambient.into();
        renderer.settings.exposure = document.exposure;
        self.apply_lights(document.lights());
    }

    fn apply_lights(&mut self, lights: &[LightDoc]) {
        if self.applied == lights {
            return;
        }
        for light in self
            .stage
            .lights
            .drain(lights.len().min(self.stage.lights.len())..)
        {
            self.stage.world.despawn(light);
        }
        self.applied.truncate(lights.len());
        self.errors.resize(lights.len(), None);
        for (index, light) in lights.iter().enumerate() {
            let before = self.applied.get(index).cloned();
            if before.as_ref() == Some(light) {
                continue;
            }
            if index == self.stage.lights.len() {
                self.stage.lights.push(self.stage.world.spawn_empty().id());
            }
            self.errors[index] = self.apply_light(index, before.as_ref(), light).err();
        }
        self.applied = lights.to_vec();
    }

    /// Changes what differs of one light. A light that cannot be used stays as it was, but its technique is taken
    /// from it if only that is wrong.
    fn apply_light(
        &mut self,
        index: usize,
        before: Option<&LightDoc>,
        light: &LightDoc,
    ) -> Result<(), String> {
        let entity = self.stage.lights[index];
        let side = match self.shading {
            Shading::Techniques(side) => side,
            Shading::Given => Side::A,
        };
        let techniques = self.stage.world.resource::<Techniques>().clone();
        let whole = light.parts(side, &techniques);
        let (parts, refused) = match whole {
            Ok(parts) => (parts, None),
            Err(error) => (light.bare_parts(&techniques)?, Some(error)),
        };
        let world = &mut self.stage.world;
        world.entity_mut(entity).insert((parts.light, parts.transform));
        if before.is_none_or(|before| before.keys != light.keys) {
            world.entity_mut(entity).remove::<ModelParts>();
            world.entity_mut(entity).insert(LightSelection::default());
            let scene = (&*self.loaded, &self.spawned);
            parts.model.insert(world, entity, scene)?;
            if let Some(path) = &parts.texture {
                let texture = light_texture(path).map_err(|error| format!("texture: {error}"))?;
                world.entity_mut(entity).insert(texture);
            }
        }
        let mut entity = world.entity_mut(entity);
        match self.shading {
            Shading::Given if !entity.contains::<GivenVisibility>() => {
                entity.insert(GivenVisibility::default());
            }
            Shading::Given => {}
            Shading::Techniques(side) => {
                if before.is_none_or(|before| before.shadows[side.index()] != light.shadows[side.index()]) {
                    let row = parts.shadow.as_ref().map(|shadow| shadow.row());
                    for other in techniques.rows().iter().filter(|other| Some(**other) != row) {
                        other.remove(&mut entity);
                    }
                    if let Some(shadow) = parts.shadow {
                        shadow.insert(&mut entity);
                    }
                }
            }
        }
        refused.map_or(Ok(()), Err)
    }

    /// Gives the lights the visibility of the truth.
    pub fn give(&mut self, pictures: &[Option<Arc<GivenPicture>>]) {
        for (&light, picture) in self.stage.lights.iter().zip(pictures) {
            let given = GivenVisibility(picture.clone());
            if self.stage.world.get::<GivenVisibility>(light) != Some(&given)
                && let Ok(mut light) = self.stage.world.get_entity_mut(light)
            {
                light.insert(given);
            }
        }
    }

    /// Draws a frame into the target. With `visibility`, that of the lights is read back, in the order of the
    /// document.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn draw(&mut self, target: &Target, visibility: bool) -> Result<Vec<Option<Vec<f32>>>, RenderError> {
        self.stage.schedule.run(&mut self.stage.world);
        let indices = self.stage.light_indices();
        let mut renderer = self.stage.world.resource_mut::<Renderer>();
        if let Some(failure) = renderer.take_failure() {
            return Err(failure);
        }
        renderer.prepare_output(Target::FORMAT);
        let context = renderer.context().clone();
        let count = self.stage.world.resource::<FrameLights>().lights.len();
        let masks: Vec<wgpu::Texture> = (0..if visibility { count } else { 0 })
            .map(|_| create_target(&context, "visibility", target.size, VISIBILITY_FORMAT))
            .collect::<Result<_, _>>()?;
        let views: Vec<_> = masks
            .iter()
            .map(|mask| mask.create_view(&Default::default()))
            .collect();
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let renderer = self.stage.world.resource::<Renderer>();
        renderer.record(
            &mut encoder,
            &antumbra::render::FrameOutputs {
                picture: Some(&target.view),
                visibility: &views,
            },
        );
        context.queue.submit([encoder.finish()]);
        if !visibility {
            return Ok(Vec::new());
        }
        indices
            .iter()
            .map(|index| match index.and_then(|index| masks.get(index)) {
                Some(mask) => read_halves(&context, mask).map(Some),
                None => Ok(None),
            })
            .collect()
    }

    /// Waits for the frame and returns the GPU times of its passes.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn pass_times(&self) -> Result<Vec<PassTime>, RenderError> {
        let renderer = self.stage.world.resource::<Renderer>();
        if renderer.targets().is_none() {
            return Ok(Vec::new());
        }
        renderer.timings().read(renderer.context())
    }

    /// CPU times of the system sets of the last frame.
    pub fn set_times(&self) -> &SetTimes {
        self.stage.world.resource::<SetTimes>()
    }

    /// Messages about one light, and about everything else if `light` is `None`.
    pub fn reports(&self, light: Option<usize>) -> Vec<String> {
        let reports = self.stage.world.resource::<Reports>();
        let wanted = light.and_then(|light| self.stage.lights.get(light));
        let all = reports.iter().filter(|report| match wanted {
            Some(light) => report.entity == Some(*light),
            None => report
                .entity
                .is_none_or(|entity| !self.stage.lights.contains(&entity)),
        });
        all.map(|report| report.message.clone()).collect()
    }
}

/// Reads back a texture of one half float a texel.
fn read_halves(context: &RenderContext, texture: &wgpu::Texture) -> Result<Vec<f32>, RenderError> {
    let all = wgpu::TextureAspect::All;
    let rows = antumbra::render::readback::read_texture(context, texture, all, "visibility")?;
    let halves = rows.bytes.chunks_exact(2);
    Ok(halves
        .map(|bytes| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32())
        .collect())
}
