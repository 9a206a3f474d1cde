//! The drawn objects of a frame: the mesh, the materials and the transform at each dense index.

use std::ops::Range;

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::{DMat4, DVec3, Vec3, Vec4};

use super::gpu_types;
use super::materials::MaterialPool;
use super::meshes::MeshPool;
use crate::render::Gpu;
use crate::scene::{AlphaMode, PosedMesh, SceneMaterials, SceneMesh};
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

/// The components of an object that decide what is drawn of it.
pub type Looks = (
    &'static SceneMesh,
    Option<&'static SceneMaterials>,
    Option<&'static PosedMesh>,
);

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
    /// The objects whose constants were computed in the last update.
    pub changed: FixedBitSet,
    pub(super) constants: Vec<gpu_types::Object>,
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
    /// needed when objects come and go, and where [`ObjectTable::exchange`] does not suffice.
    pub fn rebuild(
        &mut self,
        gpu: &Gpu,
        objects: &Objects,
        looks: &Query<Looks>,
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
            let mesh = self.push_items(gpu, entity, looks, meshes, materials);
            self.mesh.push(mesh);
            self.item_range.push(first..self.items.len() as u32);
        }
        meshes.end(gpu);
        materials.end(gpu);
    }

    /// Looks up the meshes and materials of some objects again, uploads new ones and frees unused ones. Returns `false` if an
    /// object has another number of items than before, or if there is an object that cannot be drawn; then a
    /// [`rebuild`](Self::rebuild) is needed.
    pub fn exchange(
        &mut self,
        gpu: &Gpu,
        objects: &Objects,
        exchanged: &[Entity],
        looks: &Query<Looks>,
        meshes: &mut MeshPool,
        materials: &mut MaterialPool,
    ) -> bool {
        if exchanged.is_empty() {
            return true;
        }
        self.generation += 1;
        if !meshes.oversized.is_empty() {
            return false; // the list names all of them
        }
        let known = exchanged.iter().filter_map(|&entity| objects.index_of(entity));
        let mut rows: Vec<usize> = known.collect();
        rows.sort_unstable(); // new meshes and materials are numbered as in a rebuild
        let mut new_mesh = false;
        for object in rows {
            let (range, end) = (self.item_range[object].clone(), self.items.len());
            let mesh = self.push_items(gpu, objects.entities[object], looks, meshes, materials);
            let is_like = mesh != NO_MESH && self.items.len() - end == range.len();
            if is_like {
                self.items.copy_within(end.., range.start as usize);
            }
            self.items.truncate(end);
            if !is_like {
                return false;
            }
            new_mesh |= std::mem::replace(&mut self.mesh[object], mesh) != mesh;
        }
        if new_mesh {
            meshes.keep(gpu, self.mesh.iter().copied().filter(|mesh| *mesh != NO_MESH));
        }
        materials.keep(gpu, self.items.iter().map(|item| item.material));
        true
    }

    /// Appends the items of an object, and returns the index of its mesh, or [`NO_MESH`].
    fn push_items(
        &mut self,
        gpu: &Gpu,
        entity: Entity,
        looks: &Query<Looks>,
        meshes: &mut MeshPool,
        materials: &mut MaterialPool,
    ) -> u32 {
        let Ok((mesh, object_materials, posed)) = looks.get(entity) else {
            return NO_MESH;
        };
        let Some(mesh_index) = meshes.acquire(gpu, entity, &mesh.0, posed) else {
            return NO_MESH;
        };
        let object_materials = object_materials.map_or(&[][..], |materials| &materials.0);
        for ((part, material), submesh) in mesh.0.submeshes.iter().zip(object_materials).zip(0..) {
            if part.index_count != 0 {
                self.items.push(Item {
                    submesh,
                    material: materials.acquire(gpu, material),
                    blended: material.alpha_mode == AlphaMode::Blend,
                    double_sided: material.double_sided,
                    unlit: material.unlit,
                    coated: material.is_coated(),
                });
            }
        }
        mesh_index
    }

    /// Returns the items of one object.
    pub fn items_of(&self, object: usize) -> &[Item] {
        let range = &self.item_range[object];
        &self.items[range.start as usize..range.end as usize]
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
