//! A scene that never rests: everything that a game may do to it between two frames, in an order that a seed gives.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::RenderError;
use antumbra::techniques::Techniques;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use fastrand::Rng;
use glam::{Quat, UVec2, Vec3};

use super::stage::Stage;

/// Most objects and most lights that exist at a time.
const MOST: [usize; 2] = [24, 5];

/// Number of frames between two losses of the device.
const LOSS_EVERY: u64 = 1000;

/// A scene, and the source of what happens to it.
pub struct Soak {
    /// World, schedule and renderer.
    pub stage: Stage,
    size: UVec2,
    device: Box<dyn Fn() -> RenderContext>,
    random: Rng,
    frame: u64,
    objects: Vec<Entity>,
    meshes: Vec<Arc<MeshData>>,
    /// Frames that were drawn with a picture.
    pub drawn: u64,
    /// Devices that were lost and replaced.
    pub lost: u64,
}

impl Soak {
    /// Builds a ground under a camera. `device` makes a device, also after one was lost.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn new(
        size: UVec2,
        seed: u64,
        device: impl Fn() -> RenderContext + 'static,
    ) -> Result<Self, RenderError> {
        let view = Transform::from_xyz(0.0, 4.0, 8.0).looking_at(Vec3::ZERO, Vec3::Y);
        let mut stage = Stage::empty(size, Camera::default(), view);
        stage.add_renderer(device(), RenderSettings::default())?;
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::plane(8.0))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            ShadowReceiver,
            Transform::default(),
        ));
        Ok(Self {
            stage,
            size,
            device: Box::new(device),
            random: Rng::with_seed(seed),
            frame: 0,
            objects: Vec::new(),
            meshes: vec![
                Arc::new(MeshData::cuboid(Vec3::splat(0.4))),
                Arc::new(MeshData::icosphere(0.5, 2)),
                Arc::new(MeshData::plane(0.6)),
            ],
            drawn: 0,
            lost: 0,
        })
    }

    /// Changes the scene and draws a frame of it. Every thousandth frame, the device is lost, and replaced.
    ///
    /// # Errors
    /// Something that the device refuses. The loss that the soak itself brings about is none.
    pub fn step(&mut self) -> Result<(), RenderError> {
        self.frame += 1;
        for _ in 0..3 {
            self.change();
        }
        if self.frame.is_multiple_of(LOSS_EVERY) {
            self.lose_the_device()?;
        }
        let size = self.stage.world.resource::<ViewportSize>().0;
        self.stage.draw()?;
        self.drawn += u64::from(size.min_element() > 0);
        Ok(())
    }

    /// Takes away everything that came, and draws until nothing is kept of it.
    ///
    /// # Errors
    /// Something that the device refuses.
    pub fn clear(&mut self, frames: u64) -> Result<(), RenderError> {
        for entity in self.objects.drain(..).chain(self.stage.lights.drain(..)) {
            self.stage.world.despawn(entity);
        }
        self.stage.world.insert_resource(ViewportSize(self.size));
        (0..frames).try_for_each(|_| self.stage.draw())
    }

    /// The device that draws now.
    pub fn context(&self) -> &RenderContext {
        self.stage.world.resource::<Renderer>().context()
    }

    /// Loses the device and goes on with another.
    ///
    /// # Errors
    /// Something that the new device refuses.
    pub fn lose_the_device(&mut self) -> Result<(), RenderError> {
        self.context().device.destroy();
        // The frame that meets the loss draws nothing and fails.
        let _ = self.stage.draw();
        self.lost += 1;
        self.stage
            .add_renderer((self.device)(), RenderSettings::default())
    }

    fn place(&mut self) -> Transform {
        let mut within = |from: f32, to: f32| from + (to - from) * self.random.f32();
        Transform {
            translation: Vec3::new(within(-5.0, 5.0), within(0.2, 3.0), within(-5.0, 5.0)),
            rotation: Quat::from_rotation_y(within(0.0, 6.0)) * Quat::from_rotation_x(within(-2.0, -1.0)),
            scale: Vec3::splat(within(0.5, 1.5)),
        }
    }

    /// One change, as a game makes it.
    fn change(&mut self) {
        let object = self.random.choice(&self.objects).copied();
        let light = self.random.choice(&self.stage.lights).copied();
        match self.random.u32(0..10) {
            0 | 1 => self.spawn_object(),
            2 => self.despawn(),
            3 => self.spawn_light(),
            4 | 5 => {
                let place = self.place();
                if let Some(entity) = object.or(light) {
                    self.stage.world.entity_mut(entity).insert(place);
                }
            }
            6 => {
                let material = self.material();
                if let Some(entity) = object {
                    self.stage.world.entity_mut(entity).insert(material);
                }
            }
            7 => {
                let at = self.random.usize(0..self.meshes.len());
                let mesh = SceneMesh(self.meshes[at].clone());
                if let Some(entity) = object {
                    self.stage.world.entity_mut(entity).insert(mesh);
                }
            }
            8 => self.swap_technique(light),
            _ => self.resize(),
        }
    }

    fn material(&mut self) -> SceneMaterials {
        let color = Vec3::new(self.random.f32(), self.random.f32(), self.random.f32());
        let mut material = Material::matte(color);
        if self.random.u32(0..4) == 0 {
            material.alpha_mode = AlphaMode::Blend;
            material.base_color.w = 0.5;
        }
        SceneMaterials([Arc::new(material)].into())
    }

    fn spawn_object(&mut self) {
        if self.objects.len() >= MOST[0] {
            return;
        }
        // Some meshes are new, and go with their last object.
        let mesh = match self.random.usize(0..=self.meshes.len()) {
            at if at < self.meshes.len() => self.meshes[at].clone(),
            _ => Arc::new(MeshData::icosphere(0.3 + 0.3 * self.random.f32(), 1)),
        };
        let (materials, place) = (self.material(), self.place());
        let object = (SceneMesh(mesh), materials, ShadowCaster, ShadowReceiver, place);
        self.objects.push(self.stage.world.spawn(object).id());
    }

    fn despawn(&mut self) {
        let lists = [&mut self.objects, &mut self.stage.lights];
        let [list, _] = if self.random.bool() {
            lists
        } else {
            let [a, b] = lists;
            [b, a]
        };
        if !list.is_empty() {
            let entity = list.swap_remove(self.random.usize(0..list.len()));
            self.stage.world.despawn(entity);
        }
    }

    fn spawn_light(&mut self) {
        if self.stage.lights.len() >= MOST[1] {
            return;
        }
        let kind = match self.random.u32(0..5) {
            0 => LightKind::Spot {
                inner_angle: 0.4,
                outer_angle: 0.7,
            },
            1 => LightKind::Directional,
            2 => LightKind::Sphere { radius: 0.3 },
            3 => LightKind::Rect {
                width: 0.8,
                height: 0.4,
            },
            _ => LightKind::Point,
        };
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 10.0, 12.0)
        };
        let place = self.place();
        let light = self.stage.spawn_light(light, place, None::<()>);
        self.swap_technique(Some(light));
    }

    /// Gives a light another technique, or none. A technique that does not fit the light is refused.
    fn swap_technique(&mut self, light: Option<Entity>) {
        let Some(light) = light else { return };
        let techniques = self.stage.world.resource::<Techniques>().clone();
        let mut entity = self.stage.world.entity_mut(light);
        techniques.take(&mut entity);
        if let Some(row) = techniques
            .rows()
            .get(self.random.usize(0..=techniques.rows().len()))
        {
            row.defaults().insert(&mut entity);
        }
    }

    /// Resizes the target; a window that is minimized has no size.
    fn resize(&mut self) {
        let size = match self.random.u32(0..6) {
            0 => UVec2::ZERO,
            1 => self.size / 2,
            _ => self.size,
        };
        self.stage.world.insert_resource(ViewportSize(size));
    }
}
