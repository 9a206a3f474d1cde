//! A world with a scene, a camera and lights, and a renderer that draws it headlessly.

use std::time::{Duration, Instant};

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::render::RenderError;
use antumbra::scene::apply_animation;
use antumbra::scene::camera_place;
use antumbra::scene::gltf_import::{LoadedGltf, SpawnedScene, load_gltf, meshes_of_name, spawn_scene};
use antumbra::scene::{BlurredGround, WorldBounds};
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::techniques::{Settings, Techniques, add_row};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::picture;
use super::shared_gpu::shared_gpu;
use super::shot::{Shot, ShotGround};

/// Format of the picture.
pub const PICTURE_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// A world and the schedule that runs a frame of it.
pub struct Stage {
    /// World with the scene, the camera, the lights and the renderer.
    pub world: World,
    /// Schedule that runs once a frame.
    pub schedule: Schedule,
    /// Entity of the camera.
    pub camera: Entity,
    /// Entities of the lights, in the order of the shot.
    pub lights: Vec<Entity>,
    /// Time in which the scene's file was read and its pictures decoded.
    pub load_time: Duration,
}

impl Stage {
    /// Builds a stage with a camera and without a scene.
    pub fn empty(size: UVec2, camera: Camera, transform: Transform) -> Self {
        let mut world = World::new();
        init_resources(&mut world);
        world.insert_resource(ViewportSize(size));
        let camera = world.spawn((camera, transform)).id();
        Self {
            world,
            schedule: standalone_schedule(),
            camera,
            lights: Vec::new(),
            load_time: Duration::ZERO,
        }
    }

    /// Builds the stage of a shot file, without a renderer.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn of_shot(shot: &Shot) -> Result<Self, String> {
        let start = Instant::now();
        let loaded = load_gltf(&shot.scene).map_err(|error| one_line(&error))?;
        let load_time = start.elapsed();
        let in_shot = |error: String| {
            let file = shot.path.display().to_string();
            if file.is_empty() {
                error
            } else {
                format!("{file}: {error}")
            }
        };
        let mut stage = Self::of_scene(shot, &loaded).map_err(in_shot)?;
        stage.load_time = load_time;
        if stage.object_count() == 0 {
            eprintln!("{}: nothing to draw", shot.scene.display());
        }
        Ok(stage)
    }

    /// Builds the stage of a shot whose scene is loaded.
    fn of_scene(shot: &Shot, loaded: &LoadedGltf) -> Result<Self, String> {
        let size = shot.size();
        let mut stage = Self::empty(size, Camera::default(), Transform::IDENTITY);
        let spawned = spawn_scene(&mut stage.world, loaded, None).map_err(|error| one_line(&error))?;
        blur_grounds(&mut stage.world, (loaded, &spawned), &shot.blurred_grounds)?;
        if let Some(animation) = shot.animation {
            stage.pose(loaded, &spawned, animation.clip, animation.time)?;
        }
        // Only the stage's own camera draws.
        for &camera in &spawned.cameras {
            stage.world.entity_mut(camera).remove::<Camera>();
        }
        stage.world.entity_mut(stage.camera).remove::<Camera>();
        stage.schedule.run(&mut stage.world);
        let (camera, transform) = match &shot.camera {
            Some(camera) => (camera.camera(size), camera.transform()?),
            None => stage.choose_camera(loaded, &spawned, size),
        };
        stage.world.entity_mut(stage.camera).insert((camera, transform));
        match &shot.lights {
            Some(lights) => {
                for &light in &spawned.lights {
                    stage.world.entity_mut(light).remove::<Light>();
                }
                for (index, light) in lights.iter().enumerate() {
                    let parts = light.parts(&shot.techniques)?;
                    let entity = stage.spawn_shadowed(parts.light, parts.transform, parts.shadow.as_ref());
                    if let Some(moving) = &parts.moving {
                        stage.shadow(entity, moving);
                    }
                    if let Some(path) = parts.path {
                        stage.world.entity_mut(entity).insert(path);
                    }
                    parts
                        .model
                        .insert(&mut stage.world, entity, (loaded, &spawned))
                        .map_err(|error| format!("lights[{index}].{error}"))?;
                    if let Some(path) = parts.texture {
                        let texture = picture::light_texture(&path)
                            .map_err(|error| format!("lights[{index}].texture: {error}"))?;
                        stage.world.entity_mut(entity).insert(texture);
                    }
                }
            }
            None => {
                for &light in &spawned.lights {
                    stage.shadow_by_default(light);
                    stage.lights.push(light);
                }
            }
        }
        Ok(stage)
    }

    /// Reads the files that the lights' techniques name, so that faults in them are errors instead of reports.
    ///
    /// # Errors
    /// One line that names the light, the file and the element.
    pub fn load_files(&mut self) -> Result<(), String> {
        let rows = self.world.resource::<Techniques>().rows().to_vec();
        for (index, &light) in self.lights.iter().enumerate() {
            for row in &rows {
                row.load_files(&mut self.world, light)
                    .map_err(|error| format!("lights[{index}].shadow.{error}"))?;
            }
        }
        Ok(())
    }

    fn pose(
        &mut self,
        loaded: &LoadedGltf,
        spawned: &SpawnedScene,
        clip: usize,
        time: f32,
    ) -> Result<(), String> {
        let clip_data = loaded.clips.get(clip).ok_or_else(|| {
            format!(
                "{}: animation.clip {clip}: the scene has {} clips",
                loaded.file.display(),
                loaded.clips.len()
            )
        })?;
        apply_animation(&mut self.world, spawned, clip_data, time);
        Ok(())
    }

    /// Spawns a light and adds it to the end of the list.
    pub fn spawn_light(&mut self, light: Light, transform: Transform, shadow: Option<impl Bundle>) -> Entity {
        let mut entity = self.world.spawn((light, transform));
        if let Some(shadow) = shadow {
            entity.insert(shadow);
        }
        let entity = entity.id();
        self.lights.push(entity);
        entity
    }

    /// Spawns a light with the settings of any technique. Adds the technique to the stage if it is missing there.
    pub fn spawn_shadowed(
        &mut self,
        light: Light,
        transform: Transform,
        shadow: Option<&Settings>,
    ) -> Entity {
        let entity = self.spawn_light(light, transform, None::<()>);
        if let Some(shadow) = shadow {
            self.shadow(entity, shadow);
        }
        entity
    }

    /// Gives a light a technique. Adds the technique to the stage if it is missing there.
    pub fn shadow(&mut self, light: Entity, settings: &Settings) {
        add_row(settings.row(), &mut self.world, &mut self.schedule);
        settings.insert(&mut self.world.entity_mut(light));
    }

    /// Gives a light the first technique of the stage's list.
    pub fn shadow_by_default(&mut self, light: Entity) {
        let first = self.world.resource::<Techniques>().rows().first().copied();
        if let Some(first) = first {
            first.defaults().insert(&mut self.world.entity_mut(light));
        }
    }

    /// Returns the number of objects with a mesh.
    pub fn object_count(&mut self) -> usize {
        self.world.query::<&SceneMesh>().iter(&self.world).count()
    }

    /// Returns the world bounds of all objects in the last frame.
    pub fn scene_bounds(&mut self) -> Aabb {
        self.world
            .query::<&WorldBounds>()
            .iter(&self.world)
            .fold(Aabb::EMPTY, |all, bounds| all.union(bounds.0))
    }

    fn choose_camera(
        &mut self,
        loaded: &LoadedGltf,
        spawned: &SpawnedScene,
        size: UVec2,
    ) -> (Camera, Transform) {
        let aspect = size.x as f32 / size.y.max(1) as f32;
        let first = spawned.cameras.first().and_then(|&entity| {
            let node = spawned
                .nodes
                .nodes
                .iter()
                .position(|node| *node == Some(entity))?;
            let camera = loaded
                .cameras
                .get(loaded.nodes[node].camera?)
                .copied()
                .flatten()?;
            let transform = camera_place(&self.world, entity)?.compute_transform();
            Some((Camera { aspect, ..camera }, transform))
        });
        first.unwrap_or_else(|| framing_camera(self.scene_bounds(), aspect))
    }

    /// Adds a renderer to the stage. It shares shaders and pipelines with other stages on the same device.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn add_renderer(
        &mut self,
        context: RenderContext,
        settings: RenderSettings,
    ) -> Result<(), RenderError> {
        let mut renderer = Renderer::on(shared_gpu(context)?)?;
        renderer.settings = settings;
        self.world.insert_resource(renderer);
        Ok(())
    }

    /// Returns the indices of the stage's lights in this frame's `FrameLights`; `None` for lights that cannot shine.
    pub fn light_indices(&self) -> Vec<Option<usize>> {
        let frame = self.world.resource::<FrameLights>();
        self.lights
            .iter()
            .map(|light| frame.lights.iter().position(|entry| entry.entity == *light))
            .collect()
    }

    /// Runs the systems of a frame.
    pub fn run(&mut self) {
        self.schedule.run(&mut self.world);
        self.world.clear_trackers();
    }
}

/// Blurs the shadows on grounds of a scene, and no longer on others.
///
/// # Errors
/// One line that names the ground: no node of the scene has its name. No ground is blurred then.
pub fn blur_grounds(
    world: &mut World,
    (loaded, spawned): (&LoadedGltf, &SpawnedScene),
    grounds: &[ShotGround],
) -> Result<(), String> {
    let mut blurred = world.query_filtered::<Entity, With<BlurredGround>>();
    let before: Vec<Entity> = blurred.iter(world).collect();
    for mesh in before {
        world.entity_mut(mesh).remove::<BlurredGround>();
    }
    let mut found = Vec::new();
    for (index, ground) in grounds.iter().enumerate() {
        let node = &ground.node;
        let meshes = meshes_of_name(world, loaded, &spawned.nodes, node)
            .ok_or_else(|| format!("blurred_grounds[{index}].node: no node has the name `{node}`"))?;
        let radius = ground.radius;
        found.extend(meshes.into_iter().map(|mesh| (mesh, BlurredGround { radius })));
    }
    for (mesh, ground) in found {
        world.entity_mut(mesh).insert(ground);
    }
    Ok(())
}

/// Returns a camera that sees the whole box from the front, the right and above.
pub fn framing_camera(bounds: Aabb, aspect: f32) -> (Camera, Transform) {
    let (center, radius) = if bounds.is_empty() {
        (Vec3::ZERO, 1.0)
    } else {
        (bounds.center(), bounds.half_size().length().max(1e-3))
    };
    let vertical_fov = std::f32::consts::FRAC_PI_4;
    let narrow = (vertical_fov * 0.5).tan() * aspect.min(1.0);
    let distance = radius / narrow.atan().sin();
    let eye = center + Vec3::new(0.5, 0.45, 0.9).normalize() * distance;
    let camera = Camera {
        vertical_fov,
        near: (distance - radius).max(distance * 1e-3) * 0.5,
        aspect,
        ..Camera::default()
    };
    (
        camera,
        Transform::from_translation(eye).looking_at(center, Vec3::Y),
    )
}

/// Formats an error and its sources as one line.
pub fn one_line(error: &dyn std::error::Error) -> String {
    let mut line = error.to_string().replace('\n', " ");
    let mut source = error.source();
    while let Some(inner) = source {
        let text = inner.to_string();
        if !line.contains(&text) {
            line = format!("{line}: {}", text.replace('\n', " "));
        }
        source = inner.source();
    }
    line
}
