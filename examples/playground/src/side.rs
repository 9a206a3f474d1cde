//! A world with the scene and the lights of a document, and a renderer that draws one of the pictures to compare.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::readback::read_texture;
use antumbra::render::{Gpu, PassTime, RECEIVER_PLANE_FORMAT, RenderError, VISIBILITY_FORMAT, create_target};
use antumbra::reports::Reports;
use antumbra::scene::apply_animation;
use antumbra::scene::gltf_import::{LoadedGltf, SpawnedScene, spawn_scene};
use antumbra::schedule::SetTimes;
use antumbra::sets::View;
use antumbra::techniques::penumbra_wedge::EmitterTexture;
use antumbra::techniques::{Techniques, add_row};
use antumbra_stage::given::{GivenPicture, GivenVisibility};
use antumbra_stage::picture::light_texture;
use antumbra_stage::shot::{LightParts, ShotGround, ShotModel};
use antumbra_stage::stage::{Stage, blur_grounds, one_line};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};
use serde_json::{Map, Value};

use crate::document::{Document, LightDoc, Pose, Side};
use crate::measures::{Measured, Pixels};
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
    /// The lights of the document that was applied last.
    lights: Vec<LightDoc>,
    applied: Vec<Applied>,
    grounds: Vec<ShotGround>,
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

/// The part of a light's document that its entity already has.
#[derive(Clone, Debug, Default, PartialEq)]
struct Applied {
    /// Keys whose components it has; `None` if they could not be used.
    keys: Option<Map<String, Value>>,
    /// Value of `shadow` whose technique it has; `None` without a technique.
    shadow: Option<Map<String, Value>>,
}

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
            lights: Vec::new(),
            applied: Vec::new(),
            grounds: Vec::new(),
            errors: Vec::new(),
            posed: None,
        })
    }

    /// Makes the world that of a document.
    ///
    /// # Errors
    /// One line that names the ground that the scene does not have.
    pub fn apply(&mut self, document: &Document, size: UVec2) -> Result<(), String> {
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
        if self.grounds != document.blurred_grounds {
            blur_grounds(world, (&self.loaded, &self.spawned), &document.blurred_grounds)?;
            self.grounds.clone_from(&document.blurred_grounds);
        }
        let mut renderer = world.resource_mut::<Renderer>();
        renderer.settings.ambient = document.ambient.into();
        renderer.settings.exposure = document.exposure;
        self.apply_lights(document.lights());
        Ok(())
    }

    fn apply_lights(&mut self, lights: &[LightDoc]) {
        if self.lights == lights {
            return;
        }
        let kept = lights.len().min(self.stage.lights.len());
        for light in self.stage.lights.drain(kept..) {
            self.stage.world.despawn(light);
        }
        self.applied.resize(lights.len(), Applied::default());
        self.applied[kept..].fill(Applied::default());
        self.errors.resize(lights.len(), None);
        for (index, light) in lights.iter().enumerate() {
            if self.lights.get(index) == Some(light) && index < kept {
                continue;
            }
            if index == self.stage.lights.len() {
                self.stage.lights.push(self.stage.world.spawn_empty().id());
            }
            self.errors[index] = match self.apply_light(index, light) {
                Ok(note) => note,
                Err(error) => Some(error),
            };
        }
        self.lights = lights.to_vec();
    }

    /// Changes what differs of one light. A light that cannot be used stays as it was, but its technique is taken
    /// from it if only that is wrong. Returns what is left out of the light.
    fn apply_light(&mut self, index: usize, light: &LightDoc) -> Result<Option<String>, String> {
        let entity = self.stage.lights[index];
        let side = match self.shading {
            Shading::Techniques(side) => side,
            Shading::Given => Side::A,
        };
        let techniques = self.stage.world.resource::<Techniques>().clone();
        let (parts, note) = match light.parts(side, &techniques) {
            Ok(whole) => whole,
            Err(error) => (light.bare_parts(&techniques)?, Some(error)),
        };
        let shadow = parts.shadow.as_ref().map(|_| light.shadows[side.index()].clone());
        let world = &mut self.stage.world;
        world
            .entity_mut(entity)
            .insert((parts.light.clone(), parts.transform));
        // Which components the keys give depends on the technique as well.
        if self.applied[index].keys.as_ref() != Some(&light.keys) || self.applied[index].shadow != shadow {
            self.applied[index].keys = None;
            self.apply_model(entity, &parts)?;
            self.applied[index].keys = Some(light.keys.clone());
        }
        let mut entity = self.stage.world.entity_mut(entity);
        match self.shading {
            Shading::Given if !entity.contains::<GivenVisibility>() => {
                entity.insert(GivenVisibility::default());
            }
            Shading::Given => {}
            Shading::Techniques(_) if self.applied[index].shadow == shadow => {}
            Shading::Techniques(_) => {
                let shadows = || parts.shadow.iter().chain(&parts.moving);
                for row in techniques.rows() {
                    if shadows().all(|shadow| shadow.row() != *row) {
                        row.remove(&mut entity);
                    }
                }
                for shadow in shadows() {
                    shadow.insert(&mut entity);
                }
            }
        }
        self.applied[index].shadow = shadow;
        Ok(note)
    }

    /// Gives a light the components of its model, its path and its texture, and takes all others from it.
    fn apply_model(&mut self, light: Entity, parts: &LightParts) -> Result<(), String> {
        let world = &mut self.stage.world;
        let mut entity = world.entity_mut(light);
        ShotModel::remove(&mut entity);
        entity.remove::<(EmitterTexture, LightPath)>();
        if let Some(path) = &parts.path {
            entity.insert(path.clone());
        }
        let scene = (&*self.loaded, &self.spawned);
        parts.model.insert(world, light, scene)?;
        if let Some(path) = &parts.texture {
            let texture = light_texture(path).map_err(|error| format!("texture: {error}"))?;
            world.entity_mut(light).insert(texture);
        }
        Ok(())
    }

    /// Places the lights that follow a path on another stage as they are placed there, so that all pictures show the
    /// same moment. A light that follows a path here as well goes its own way.
    pub fn place_as(&mut self, other: &Self) {
        for (&light, &there) in self.stage.lights.iter().zip(&other.stage.lights) {
            if other.stage.world.get::<LightPath>(there).is_none() {
                continue;
            }
            let place = other.stage.world.get::<Transform>(there).copied();
            if let (Some(place), Some(mut here)) = (place, self.stage.world.get_mut::<Transform>(light)) {
                here.set_if_neq(place);
            }
        }
    }

    /// Gives the lights the visibility of the truth.
    pub fn give(&mut self, pictures: &[Option<Arc<GivenPicture>>]) {
        for (&light, picture) in self.stage.lights.iter().zip(pictures) {
            let given = GivenVisibility {
                nearest: picture.clone(),
                opaque: None,
            };
            if self.stage.world.get::<GivenVisibility>(light) != Some(&given)
                && let Ok(mut light) = self.stage.world.get_entity_mut(light)
            {
                light.insert(given);
            }
        }
    }

    /// Draws a frame into the target. With `judged`, returns the visibility of that light of the document, unless it
    /// cannot shine.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn draw(&mut self, target: &Target, judged: Option<usize>) -> Result<Option<Vec<f32>>, RenderError> {
        self.stage.run();
        let mut renderer = self.stage.world.resource_mut::<Renderer>();
        if let Some(failure) = renderer.take_failure() {
            return Err(failure);
        }
        renderer.prepare_output(Target::FORMAT);
        let context = renderer.context().clone();
        let lights = &self.stage.world.resource::<FrameLights>().lights;
        let entity = judged.and_then(|light| self.stage.lights.get(light));
        let index = entity.and_then(|entity| lights.iter().position(|light| light.entity == *entity));
        let mask = |label: &'static str| create_target(&context, label, target.size, VISIBILITY_FORMAT);
        let (mut wanted, mut views) = (None, Vec::new());
        if let Some(index) = index {
            // A frame draws the visibility of all lights or of none. All others share a texture that nobody reads.
            let others = mask("other visibility")?.create_view(&Default::default());
            views = vec![others; lights.len()];
            let texture = mask("visibility")?;
            views[index] = texture.create_view(&Default::default());
            wanted = Some(texture);
        }
        let mut encoder = context.device.create_command_encoder(&Default::default());
        let renderer = self.stage.world.resource::<Renderer>();
        renderer.record(
            &mut encoder,
            &FrameOutputs {
                picture: Some(&target.view),
                visibility: &views,
            },
        );
        context.queue.submit([encoder.finish()]);
        wanted.map(|mask| read_halves(&context, &mask)).transpose()
    }

    /// Counts the lights that the last frame drew at each pixel. `None` without a view.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn lights_per_pixel(&self) -> Result<Option<Measured>, String> {
        self.measured(&|_| true, |pixels| pixels.lights())
    }

    /// Counts the texels of a light's map for each pixel of the last frame. `None` without a view, and if the light's
    /// technique looks up no picture.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn texels(&self, light: Option<usize>) -> Result<Option<Measured>, String> {
        let world = &self.stage.world;
        let entity = light.and_then(|light| self.stage.lights.get(light));
        let lights = &world.resource::<FrameLights>().lights;
        let index = entity.and_then(|entity| lights.iter().position(|light| light.entity == *entity));
        let techniques = world.resource::<Techniques>();
        let Some((index, lookup)) = index.and_then(|index| Some((index, techniques.texels(world, index)?)))
        else {
            return Ok(None);
        };
        self.measured(&|light| light == index, |pixels| pixels.texels(&lookup))
    }

    /// Reads back what the pixels of the last frame show, with the number of lights among those that count.
    fn measured(
        &self,
        counts: &dyn Fn(usize) -> bool,
        measure: impl FnOnce(&Pixels) -> Measured,
    ) -> Result<Option<Measured>, String> {
        let Some(view) = &self.stage.world.resource::<View>().data else {
            return Ok(None);
        };
        let renderer = self.stage.world.resource::<Renderer>();
        let context = renderer.context();
        let bytes = 8 * u64::from(view.viewport.x) * u64::from(view.viewport.y);
        if bytes > context.device.limits().max_buffer_size {
            return Err("the view is too large to be measured on this device".to_owned());
        }
        let texture = |label, format| {
            create_target(context, label, view.viewport, format).map_err(|error| one_line(&error))
        };
        let (planes, lights) = (
            texture("planes", RECEIVER_PLANE_FORMAT)?,
            texture("lights", VISIBILITY_FORMAT)?,
        );
        let mut encoder = context.device.create_command_encoder(&Default::default());
        renderer.record_planes(&mut encoder, &planes.create_view(&Default::default()));
        renderer.record_light_count(&mut encoder, &lights.create_view(&Default::default()), counts);
        context.queue.submit([encoder.finish()]);
        let all = wgpu::TextureAspect::All;
        let rows = read_texture(context, &planes, all, "planes").map_err(|error| one_line(&error))?;
        let half = |bytes: &[u8]| u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]]);
        let texels = rows.bytes.chunks_exact(8);
        let planes: Vec<[u32; 2]> = texels
            .map(|texel| [half(&texel[..4]), half(&texel[4..])])
            .collect();
        let lights = read_halves(context, &lights).map_err(|error| one_line(&error))?;
        Ok(Some(measure(&Pixels {
            view,
            planes: &planes,
            lights: &lights,
        })))
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
    let rows = read_texture(context, texture, all, "visibility")?;
    let halves = rows.bytes.chunks_exact(2);
    Ok(halves
        .map(|bytes| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32())
        .collect())
}
