//! The rooms as a Bevy game.

use antumbra::bevy_adapter::prelude::*;
use antumbra::scene::{Material, MeshData, SceneMaterials, SceneMesh, Submesh};
use bevy::app::SubApps;
use bevy::asset::RenderAssetUsages;
use bevy::camera::Hdr;
use bevy::core_pipeline::prepass::{DeferredPrepass, DepthPrepass};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::pbr::DefaultOpaqueRendererMethod;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::render_resource::PollType;
use bevy::render::renderer::{RenderDevice, RenderGraph, RenderGraphSystems};

use std::time::Instant;

use crate::frames;
use crate::rooms::{LUMENS, Mover, RANGE, Rooms};

/// The technique that makes the shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shadows {
    /// No shadows.
    None,
    /// Bevy's shadow maps with their default settings.
    Bevy,
    /// Stencil shadow volumes.
    Antumbra,
}

/// The moment at which the frame's commands were ready for the device.
#[derive(Resource, Clone, Copy)]
struct Recorded(Instant);

/// Marks a moving object of the game.
#[derive(Component, Clone, Copy)]
pub struct Moves(Mover);

/// Converts one of our submeshes to a Bevy mesh.
pub fn mesh_of(data: &MeshData, submesh: &Submesh) -> Mesh {
    let positions: Vec<[f32; 3]> = data.positions.iter().map(|p| p.to_array()).collect();
    let normals: Vec<[f32; 3]> = data.normals.iter().map(|n| n.to_array()).collect();
    let indices = data.indices[data.submesh_range(submesh)].to_vec();
    Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default())
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, positions)
        .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
        .with_inserted_indices(Indices::U32(indices))
}

/// Converts our material to a Bevy material, without its textures. It is visible from both sides, as in the ray
/// caster.
pub fn material_of(material: &Material) -> StandardMaterial {
    let [r, g, b, _] = material.base_color.to_array();
    StandardMaterial {
        base_color: Color::linear_rgb(r, g, b),
        metallic: material.metallic,
        perceptual_roughness: material.roughness,
        double_sided: true,
        cull_mode: None,
        ..default()
    }
}

/// Spawns everything in the rooms, and the first `lights` of their lamps.
pub fn furnish(world: &mut World, rooms: &Rooms, shadows: Shadows, lights: usize) -> Vec<Entity> {
    for entity in rooms.world.iter_entities() {
        let (Some(mesh), Some(materials), Some(transform)) = (
            entity.get::<SceneMesh>(),
            entity.get::<SceneMaterials>(),
            entity.get::<GlobalTransform>(),
        ) else {
            continue;
        };
        for (submesh, material) in mesh.0.submeshes.iter().zip(materials.0.iter()) {
            let mesh = world
                .resource_mut::<Assets<Mesh>>()
                .add(mesh_of(&mesh.0, submesh));
            let mut materials = world.resource_mut::<Assets<StandardMaterial>>();
            let material = materials.add(material_of(material));
            let parts = (
                Mesh3d(mesh),
                MeshMaterial3d(material),
                Transform::from(*transform),
            );
            let mut spawned = world.spawn(parts);
            if let Some(mover) = entity.get::<Mover>() {
                spawned.insert(Moves(*mover));
            }
        }
    }
    let lamps = rooms.lamps.iter().take(lights);
    lamps
        .map(|lamp| {
            let light = PointLight {
                intensity: LUMENS / (lights as f32).sqrt(),
                range: RANGE,
                shadow_maps_enabled: shadows == Shadows::Bevy,
                ..default()
            };
            let mut light = world.spawn((light, Transform::from_translation(*lamp)));
            if shadows == Shadows::Antumbra {
                light.insert(StencilVolume::default());
            }
            light.id()
        })
        .collect()
}

/// Returns the components of every camera.
pub fn lens(rooms: &Rooms) -> impl Bundle {
    let projection = Projection::Perspective(PerspectiveProjection {
        fov: rooms.camera.vertical_fov,
        near: rooms.camera.near,
        ..default()
    });
    let deferred = (Hdr, Msaa::Off, DepthPrepass, DeferredPrepass);
    (Camera3d::default(), deferred, projection, rooms.view)
}

/// A game without a window that runs frame by frame.
pub struct Game {
    apps: SubApps,
    camera: Entity,
    /// The lights, in the order of the lamps.
    pub lights: Vec<Entity>,
}

impl Game {
    /// Starts a game.
    pub fn new(rooms: &Rooms, shadows: Shadows, lights: usize, size: UVec2) -> Self {
        let mut app = frames::app();
        app.insert_resource(DefaultOpaqueRendererMethod::deferred());
        app.insert_resource(GlobalAmbientLight {
            brightness: 20.0,
            ..default()
        });
        if shadows == Shadows::Antumbra {
            app.add_plugins(AntumbraPlugin);
            app.insert_resource(AntumbraSettings {
                immediate_triangles: usize::MAX,
                ..default()
            });
        }
        let world = app.world_mut();
        let lights = furnish(world, rooms, shadows, lights);
        let target = frames::target(world, size);
        let mut camera = world.spawn((lens(rooms), target, Tonemapping::None));
        if shadows == Shadows::Antumbra {
            camera.insert(AntumbraCamera);
        }
        let camera = camera.id();
        app.finish();
        app.cleanup();
        let recorded = |mut commands: Commands| commands.insert_resource(Recorded(Instant::now()));
        let render = app.sub_app_mut(RenderApp);
        render.add_systems(
            RenderGraph,
            recorded
                .after(RenderGraphSystems::Render)
                .before(RenderGraphSystems::Submit),
        );
        let apps = std::mem::take(app.sub_apps_mut());
        Self { apps, camera, lights }
    }

    /// Returns the game's world.
    pub fn world(&mut self) -> &mut World {
        self.apps.main.world_mut()
    }

    /// Turns the camera and moves the moving objects.
    pub fn advance(&mut self, rooms: &Rooms, time: f32) {
        let camera = self.camera;
        let world = self.world();
        let turned = rooms.view.rotation * Quat::from_rotation_y(0.25 * (0.7 * time).sin());
        world.entity_mut(camera).insert(rooms.view.with_rotation(turned));
        let mut movers = world.query::<(&Moves, &mut Transform)>();
        for (mover, mut transform) in movers.iter_mut(world) {
            *transform = mover.0.at(time);
        }
    }

    /// Runs a frame.
    pub fn frame(&mut self) {
        self.apps.update();
    }

    /// Returns the moment at which the commands of the last frame were ready, before they were submitted: a software
    /// device works during submission.
    pub fn recorded(&mut self) -> Instant {
        self.render_world().resource::<Recorded>().0
    }

    /// Waits until the device is idle.
    pub fn wait(&mut self) {
        let device = self.render_world().resource::<RenderDevice>().clone();
        device
            .poll(PollType::wait_indefinitely())
            .expect("the device is there");
    }

    fn render_world(&mut self) -> &mut World {
        frames::render_world(&mut self.apps)
    }

    /// Returns linear radiance, RGB, row by row from the top.
    pub fn radiance(&mut self) -> Vec<Vec3> {
        let (_, texels) = frames::radiance(&mut self.apps, self.camera);
        texels
            .into_iter()
            .map(|texel| Vec3::from_array(texel.map(f32::from)))
            .collect()
    }
}
