//! The drawn objects of a frame: the mesh, the materials and the transform at each dense index.

use std::ops::Range;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::{DMat4, DVec3, Vec3, Vec4};

use super::gpu_types;
use super::materials::MaterialPool;
use super::meshes::MeshPool;
use crate::render::Gpu;
use crate::scene::placement::Placement;
use crate::scene::{AlphaMode, PosedMesh, SceneMaterials, SceneMesh, SurfaceWeights};
use crate::sets::{Objects, ViewData};

/// One submesh of one object, with its material. A draw draws one item, or several equal ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Item {
    /// Index of the submesh among those of its mesh.
    pub submesh: u32,
    /// Index of the material in the [`MaterialPool`].
    pub material: u32,
    /// True if the item is blended over the surfaces behind it, after all lights.
    pub blended: bool,
    /// True if the item is drawn from both sides.
    pub double_sided: bool,
    /// True if the item takes no light.
    pub unlit: bool,
    /// True if the item has a clearcoat.
    pub coated: bool,
}

/// The mesh index of an object that is not drawn.
pub const NO_MESH: u32 = u32::MAX;

/// The mesh and the materials of each object, by dense object index.
#[derive(Debug, Default)]
pub struct ObjectTable {
    /// The index of each object's mesh in the [`MeshPool`], or [`NO_MESH`].
    pub mesh: Vec<u32>,
    /// The range of each object's items in [`ObjectTable::items`].
    pub item_range: Vec<Range<u32>>,
    /// The items of all objects.
    pub items: Vec<Item>,
    /// The sign of the determinant of each object's transform; 0 if the object cannot be drawn.
    pub handedness: Vec<f32>,
    /// The objects with [`SurfaceWeights`].
    pub weighted: FixedBitSet,
    /// Increases when meshes and materials were looked up again, so that any index may differ.
    pub generation: u64,
    constants: Vec<gpu_types::Object>,
}

/// Returns the distance of a place from the eye, metres, along the lines of sight if these are parallel. The place is relative
/// to the eye.
pub fn distance_from_eye(relative: Vec3, view: &ViewData) -> f32 {
    if view.is_orthographic() {
        relative.dot(view.frustum.shape().forward.normalize().as_vec3())
    } else {
        relative.length()
    }
}

impl ObjectTable {
    /// The matrices of all objects, for upload. They are never empty.
    pub fn constants(&self) -> &[gpu_types::Object] {
        &self.constants
    }

    /// Returns the distance of a point from the eye, metres. The point is local to an object. In an orthographic view the
    /// distance is measured along the lines of sight.
    pub fn distance_of(&self, object: usize, point_local: Vec3, view: &ViewData) -> f32 {
        let constants = &self.constants[object];
        let rows = [
            constants.relative_from_local_x,
            constants.relative_from_local_y,
            constants.relative_from_local_z,
        ];
        let relative = Vec3::from(rows.map(|row| Vec4::from(row).dot(point_local.extend(1.0))));
        distance_from_eye(relative, view)
    }

    /// Looks up the meshes and materials of all objects, uploads new ones and frees unused ones. This is
    /// needed when objects come and go, or when they exchange a mesh or material.
    pub fn rebuild(
        &mut self,
        gpu: &Gpu,
        objects: &Objects,
        appearance: &Query<(&SceneMesh, Option<&SceneMaterials>, Option<&PosedMesh>)>,
        meshes: &mut MeshPool,
        materials: &mut MaterialPool,
    ) {
        self.generation += 1;
        self.mesh.clear();
        self.item_range.clear();
        self.items.clear();
        meshes.begin();
        materials.begin();
        for &entity in &objects.entities {
            let first = self.items.len() as u32;
            let mut mesh_index = NO_MESH;
            if let Ok((mesh, object_materials, posed)) = appearance.get(entity) {
                mesh_index = meshes.acquire(gpu, entity, &mesh.0, posed).unwrap_or(NO_MESH);
                for (submesh, part) in mesh.0.submeshes.iter().enumerate() {
                    let Some(material) = object_materials.and_then(|materials| materials.0.get(submesh))
                    else {
                        continue;
                    };
                    if part.index_count == 0 || mesh_index == NO_MESH {
                        continue;
                    }
                    self.items.push(Item {
                        submesh: submesh as u32,
                        material: materials.acquire(gpu, material),
                        blended: material.alpha_mode == AlphaMode::Blend,
                        double_sided: material.double_sided,
                        unlit: material.unlit,
                        coated: material.is_coated(),
                    });
                }
            }
            self.mesh.push(mesh_index);
            self.item_range.push(first..self.items.len() as u32);
        }
        meshes.end(gpu);
        materials.end(gpu);
    }

    /// Returns the items of one object.
    pub fn items_of(&self, object: usize) -> &[Item] {
        let range = &self.item_range[object];
        &self.items[range.start as usize..range.end as usize]
    }

    /// Computes the matrices of all objects for this view, in f64.
    ///
    /// World positions are made relative to the eye before they are rounded. So a scene far from the world's
    /// origin is shaded and depth-tested as exactly as a scene near the origin.
    pub fn update_constants(
        &mut self,
        entities: &[Entity],
        places: &Query<Placement>,
        weights: &Query<&SurfaceWeights>,
        clip_from_world: DMat4,
        eye_world: DVec3,
    ) {
        self.constants.clear();
        self.handedness.clear();
        self.weighted.clear();
        self.weighted.grow(entities.len());
        for (index, &entity) in entities.iter().enumerate() {
            let place = places.get(entity).ok();
            let world_from_local = place
                .and_then(|place| place.world_from_local())
                .unwrap_or(DMat4::ZERO);
            let handedness = world_from_local.determinant().signum() as f32;
            let usable = world_from_local.is_finite() && handedness != 0.0;
            self.handedness.push(if usable { handedness } else { 0.0 });
            self.constants.push(if usable {
                object_constants(world_from_local, clip_from_world, eye_world)
            } else {
                gpu_types::Object::default()
            });
            if let Ok(weights) = weights.get(entity)
                && *weights != SurfaceWeights::default()
            {
                let constants = &mut self.constants[index].handedness;
                constants[1..].copy_from_slice(&weights.to_vec3().to_array());
                self.weighted.insert(index);
            }
        }
        if self.constants.is_empty() {
            self.constants.push(gpu_types::Object::default());
        }
    }
}

/// Makes the shader's constants of one object.
pub fn object_constants(
    world_from_local: DMat4,
    clip_from_world: DMat4,
    eye_world: DVec3,
) -> gpu_types::Object {
    let relative = DMat4::from_translation(-eye_world) * world_from_local;
    let rows = relative.transpose().as_mat4();
    gpu_types::Object {
        clip_from_local: (clip_from_world * world_from_local).as_mat4().to_cols_array_2d(),
        relative_from_local_x: rows.x_axis.to_array(),
        relative_from_local_y: rows.y_axis.to_array(),
        relative_from_local_z: rows.z_axis.to_array(),
        handedness: [world_from_local.determinant().signum() as f32, 1.0, 1.0, 1.0],
    }
}
