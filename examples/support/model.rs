//! A model on a ground, ready to be lit. Benches, tables and tests judge shadows on it.

use std::path::Path;
use std::sync::Arc;

use antumbra::geometry::Aabb;
use antumbra::prelude::*;
use antumbra::scene::apply_animation;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use super::solid::make_alpha_solid;
use super::stage::{Stage, one_line};

/// A model on a ground plane, without lights and cameras of its own.
pub struct Model {
    /// World, schedule and renderer.
    pub stage: Stage,
    /// World bounds of the model without the ground.
    pub bounds: Aabb,
    /// A point on the model's surface.
    pub vertex: Vec3,
}

impl Model {
    /// Loads a model, poses it in the middle of its first clip, and puts a ground under it. Returns `None` if it has
    /// no triangles.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn load(path: &Path, context: &RenderContext, size: UVec2) -> Result<Option<Self>, String> {
        let mut stage = Stage::empty(size, Camera::default(), Transform::IDENTITY);
        stage.world.insert_resource(FaceCulling::None);
        let added = stage.add_renderer(context.clone(), RenderSettings::default());
        added.map_err(|error| one_line(&error))?;
        let loaded = load_gltf(path).map_err(|error| one_line(&error))?;
        let spawned = spawn_scene(&mut stage.world, &loaded, None).map_err(|error| one_line(&error))?;
        if let Some(clip) = loaded.clips.first() {
            // In the middle of a motion, the pose differs from the one in which the mesh was made.
            apply_animation(&mut stage.world, &spawned, clip, 0.37 * clip.duration());
        }
        for &light in &spawned.lights {
            stage.world.entity_mut(light).remove::<Light>();
        }
        for &camera in &spawned.cameras {
            stage.world.entity_mut(camera).remove::<Camera>();
        }
        make_alpha_solid(&mut stage);
        stage.run();
        let bounds = stage.scene_bounds();
        if bounds.is_empty() {
            return Ok(None);
        }
        let vertex = some_vertex(&mut stage);
        let radius = bounds.half_size().length().max(1e-3);
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::plane(6.0 * radius))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(bounds.center().with_y(bounds.min.y - 0.01 * radius)),
        ));
        stage.run();
        Ok(Some(Self {
            stage,
            bounds,
            vertex,
        }))
    }
}

/// Returns a vertex of the first mesh in world space.
fn some_vertex(stage: &mut Stage) -> Vec3 {
    let mut query = stage.world.query::<(&SceneMesh, &GlobalTransform)>();
    query
        .iter(&stage.world)
        .find_map(|(mesh, transform)| {
            let middle = mesh.0.positions.get(mesh.0.positions.len() / 2)?;
            Some(transform.transform_point(*middle))
        })
        .unwrap_or_default()
}
