//! Draws of casters into faces. Equal meshes become one instanced draw, whatever their opaque materials.

use std::ops::Range;

use bevy_ecs::prelude::{Entity, World};
use fixedbitset::FixedBitSet;
use glam::{DMat4, Vec3};

use super::gpu_types::MapCaster;
use crate::render::pools::materials::MaterialPool;
use crate::render::pools::meshes::MeshPool;
use crate::render::pools::objects::NO_MESH;
use crate::render::recorder::PrepareInput;
use crate::scene::placement::world_from_local;
use crate::scene::{AlphaMode, LeftOutSubmeshes, LocalBounds, SceneMaterials};
use crate::sets::Objects;
use crate::techniques::maps::face::MapFace;

/// One draw call, or one for each run of consecutive submeshes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MapDraw {
    /// Index of the material whose alpha cuts holes; `None` for solid casters.
    pub material: Option<u32>,
    /// Index of the mesh in the mesh pool.
    pub mesh: u32,
    /// Index of the submesh among those of its mesh; `None` for all submeshes.
    pub submesh: Option<u32>,
    /// Range of [`MapDraws::casters`] that the call draws.
    pub casters: Range<u32>,
}

/// A caster in a face, or one submesh of a caster.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    material: Option<u32>,
    mesh: u32,
    submesh: Option<u32>,
    object: u32,
}

/// The draws of a frame. The memory is reused.
#[derive(Debug, Default)]
pub struct MapDraws {
    /// All draws of the frame.
    pub draws: Vec<MapDraw>,
    /// The matrices of the casters of all draws.
    pub casters: Vec<MapCaster>,
    /// Dense object index of each caster of a draw. Matrices that were added otherwise may follow.
    pub objects: Vec<u32>,
    parts: Vec<Part>,
}

/// A mesh whose centre is farther from its local origin than this many times its half size is taken from its centre. Nearer
/// meshes keep their coordinates, which loses at most this many times the rounding of the others.
const FAR: f32 = 16.0;

/// Returns the point of an object's local space from which its positions are taken: the local origin, or its centre far from that.
fn center_of(world: &World, entity: Entity) -> Vec3 {
    let bounds = world.get::<LocalBounds>(entity).map(|bounds| bounds.0);
    let is_far = |center: &Vec3, half: Vec3| center.abs().max_element() > FAR * half.max_element();
    bounds
        .filter(|bounds| !bounds.is_empty())
        .map(|bounds| (bounds.center(), bounds.half_size()))
        .filter(|(center, half)| center.is_finite() && is_far(center, *half))
        .map_or(Vec3::ZERO, |(center, _)| center)
}

impl MapDraws {
    /// Removes the draws of the last frame.
    pub fn clear(&mut self) {
        self.draws.clear();
        self.casters.clear();
        self.objects.clear();
    }

    /// Adds the draws of a set of objects into a face, and returns their range.
    pub fn push(
        &mut self,
        world: &World,
        input: &PrepareInput,
        objects: &Objects,
        face: &MapFace,
        set: &FixedBitSet,
    ) -> Range<usize> {
        self.parts.clear();
        for object in set.ones() {
            self.push_parts(world, input, objects, object);
        }
        self.parts.sort_unstable();
        let first = self.draws.len();
        let clip_from_world = face.clip_from_world();
        for part in &self.parts {
            let entity = objects.entities[part.object as usize];
            let world_from_local = world_from_local(world, entity).unwrap_or(DMat4::ZERO);
            let at = self.casters.len() as u32;
            self.objects.resize(self.casters.len(), u32::MAX);
            self.objects.push(part.object);
            let center = center_of(world, entity);
            let world_from_centered = world_from_local * DMat4::from_translation(center.as_dvec3());
            self.casters.push(MapCaster {
                clip_from_centered: (clip_from_world * world_from_centered)
                    .as_mat4()
                    .to_cols_array_2d(),
                center_local: center.extend(0.0).to_array(),
            });
            if let Some(last) = self.draws[first..].last_mut()
                && (last.material, last.mesh, last.submesh) == (part.material, part.mesh, part.submesh)
            {
                last.casters.end = at + 1;
            } else {
                self.draws.push(MapDraw {
                    material: part.material,
                    mesh: part.mesh,
                    submesh: part.submesh,
                    casters: at..at + 1,
                });
            }
        }
        first..self.draws.len()
    }

    fn push_parts(&mut self, world: &World, input: &PrepareInput, objects: &Objects, object: usize) {
        let mesh = input.table.mesh[object];
        if mesh == NO_MESH || input.table.handedness[object] == 0.0 {
            return;
        }
        let object_index = object as u32;
        let entity = objects.entities[object];
        let materials = world.get::<SceneMaterials>(entity);
        let left_out = world.get::<LeftOutSubmeshes>(entity);
        let left_out = left_out.map_or(&[][..], |left_out| &left_out.0);
        let is_masked = |submesh: usize| {
            let material = materials.and_then(|materials| materials.0.get(submesh));
            material.is_some_and(|material| matches!(material.alpha_mode, AlphaMode::Mask(_)))
        };
        let submeshes = input.meshes.get(mesh).map_or(0, |mesh| mesh.submeshes.len());
        if left_out.is_empty() && !(0..submeshes).any(is_masked) {
            self.parts.push(Part {
                material: None,
                mesh,
                submesh: None,
                object: object_index,
            });
            return;
        }
        // Both lists are in the order of the submeshes.
        let items = input.table.items_of(object);
        for submesh in (0..submeshes).filter(|submesh| left_out.binary_search(&(*submesh as u32)).is_err()) {
            let item = items.binary_search_by_key(&(submesh as u32), |item| item.submesh);
            let item = item.ok().map(|at| &items[at]);
            self.parts.push(Part {
                material: item.filter(|_| is_masked(submesh)).map(|item| item.material),
                mesh,
                submesh: Some(submesh as u32),
                object: object_index,
            });
        }
    }

    /// Returns the kinds of pipelines that a range of draws needs: `true` for casters with holes, `false` for
    /// solid casters.
    pub fn masked(&self, range: Range<usize>) -> impl Iterator<Item = bool> + use<> {
        let has = |masked| {
            self.draws[range.clone()]
                .iter()
                .any(|draw| draw.material.is_some() == masked)
        };
        let [solid, masked] = [false, true].map(has);
        [solid.then_some(false), masked.then_some(true)]
            .into_iter()
            .flatten()
    }

    /// Records a range of draws. Groups 0 and 1 must be set. `pipeline` returns the pipeline for casters with holes (`true`)
    /// or for solid casters; draws without one are left out.
    pub fn record<'a>(
        &self,
        range: Range<usize>,
        pass: &mut wgpu::RenderPass,
        pipeline: impl Fn(bool) -> Option<&'a wgpu::RenderPipeline>,
        meshes: &MeshPool,
        materials: &MaterialPool,
    ) {
        let mut last_masked = None;
        for draw in &self.draws[range] {
            let Some(mesh) = meshes.get(draw.mesh) else {
                continue;
            };
            let masked = draw.material.is_some();
            if last_masked != Some(masked) {
                let Some(pipeline) = pipeline(masked) else {
                    continue;
                };
                pass.set_pipeline(pipeline);
                last_masked = Some(masked);
            }
            if let Some(material) = draw.material {
                let Some(material) = materials.get(material) else {
                    continue;
                };
                pass.set_bind_group(2, &material.bind_group, &[]);
                pass.set_vertex_buffer(1, mesh.surface.slice(..));
            }
            pass.set_vertex_buffer(0, mesh.positions.slice(..));
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            let submeshes = match draw.submesh {
                Some(submesh) => &mesh.submeshes[submesh as usize..=submesh as usize],
                None => &mesh.submeshes[..],
            };
            // Consecutive submeshes are one draw.
            let mut indices = 0..0;
            for submesh in submeshes {
                let next = submesh.first_index..submesh.first_index + submesh.index_count;
                if next.start == indices.end && !indices.is_empty() {
                    indices.end = next.end;
                    continue;
                }
                if !indices.is_empty() {
                    pass.draw_indexed(indices, 0, draw.casters.clone());
                }
                indices = next;
            }
            if !indices.is_empty() {
                pass.draw_indexed(indices, 0, draw.casters.clone());
            }
        }
    }
}
