//! The edge meshes of casters: one for all objects that share a mesh, and planes of its own for each posed object.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;

use super::stacks::piece_boxes;
use super::{FacingPlanes, compute_planes, compute_posed_planes};
use crate::geometry::Aabb;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeMeshError, EdgeMeshInput, is_outside_out};
use crate::scene::{MeshData, PosedMesh, SceneMesh, ShadowCaster};

/// What all casters with one mesh share.
#[derive(Debug)]
pub struct CasterMesh {
    /// Welded triangles and their edges.
    pub edges: EdgeMesh,
    /// Planes in the pose that the mesh was made in.
    pub planes: FacingPlanes,
    /// From outside, fronts alone are seen of the mesh as it was made: it is closed, and nowhere inside out.
    pub shows_fronts_alone: bool,
    /// Boxes of its pieces, local space; none of a mesh of one piece.
    pub pieces: Vec<(Aabb, u32)>,
}

/// The edge mesh of a caster. Written by [`build_caster_edges`]; a caster whose mesh has none (it is counted in
/// [`CasterMeshes::failures`]) casts nothing.
#[derive(Component, Clone, Debug)]
pub struct CasterEdges(pub Arc<CasterMesh>);

/// Planes of a posed caster's triangles in this frame's pose.
#[derive(Component, Clone, Debug, Default)]
pub struct PosedPlanes(pub FacingPlanes);

/// The edge meshes in use, by mesh.
#[derive(Resource, Debug, Default)]
pub struct CasterMeshes {
    /// By the address of the mesh, which the weak handle tells from a later mesh at the same address.
    by_address: HashMap<usize, (Weak<MeshData>, Arc<CasterMesh>)>,
    /// Meshes that cannot cast, by name, and why; each once.
    pub failures: Vec<(String, EdgeMeshError)>,
}

impl CasterMesh {
    /// The edge mesh of a mesh: work for a loading thread, in the triangles of the mesh. [`CasterMeshes::insert`] takes
    /// what it made.
    ///
    /// # Errors
    /// [`EdgeMeshError`] names the triangle.
    pub fn build(mesh: &MeshData) -> Result<Self, EdgeMeshError> {
        let keys = pose_keys(mesh);
        let edges = EdgeMesh::build(EdgeMeshInput {
            positions: &mesh.positions,
            indices: &mesh.indices,
            pose_keys: keys.as_deref(),
            weld_epsilon: None,
        })?;
        let mut planes = FacingPlanes::default();
        compute_planes(&edges, &mesh.positions, &mut planes);
        // A pose may turn parts inside out: what it shows is not told from the mesh as it was made.
        let shows_fronts_alone =
            keys.is_none() && edges.is_closed() && is_outside_out(&mesh.positions, edges.corners());
        let pieces = piece_boxes(&edges, &mesh.positions);
        Ok(Self {
            pieces: pieces.into_iter().map(|aabb| (aabb, 1)).collect(),
            edges,
            planes,
            shows_fronts_alone,
        })
    }
}

impl CasterMeshes {
    /// The edge mesh of a mesh, built the first time.
    ///
    /// # Errors
    /// [`EdgeMeshError`] names the triangle.
    pub fn get_or_build(&mut self, mesh: &Arc<MeshData>) -> Result<Arc<CasterMesh>, EdgeMeshError> {
        if let Some((source, built)) = self.by_address.get(&address(mesh))
            && source.upgrade().is_some_and(|source| Arc::ptr_eq(&source, mesh))
        {
            return Ok(built.clone());
        }
        let built = Arc::new(CasterMesh::build(mesh)?);
        self.insert(mesh, built.clone());
        Ok(built)
    }

    /// Keeps an edge mesh that was built elsewhere, of just this mesh.
    pub fn insert(&mut self, mesh: &Arc<MeshData>, built: Arc<CasterMesh>) {
        self.by_address.retain(|_, (source, _)| source.strong_count() > 0);
        self.by_address
            .insert(address(mesh), (Arc::downgrade(mesh), built));
    }

    /// Whether it is there already.
    pub fn contains(&self, mesh: &Arc<MeshData>) -> bool {
        let known = self.by_address.get(&address(mesh));
        known.is_some_and(|(source, _)| source.upgrade().is_some_and(|source| Arc::ptr_eq(&source, mesh)))
    }
}

fn address(mesh: &Arc<MeshData>) -> usize {
    Arc::as_ptr(mesh) as usize
}

/// A number for each vertex, equal where all that moves the vertex in any pose is equal: only such vertices may be
/// welded. `None` for a mesh that is never posed.
fn pose_keys(mesh: &MeshData) -> Option<Vec<u32>> {
    if mesh.joints.is_empty() && mesh.morph_targets.is_empty() {
        return None;
    }
    let mut numbers: HashMap<Vec<u32>, u32> = HashMap::new();
    let bits = |v: Option<&glam::Vec3>| v.map_or([0; 3], |v| (*v + 0.0).to_array().map(f32::to_bits));
    let keys = (0..mesh.positions.len()).map(|vertex| {
        let mut moved_by = Vec::new();
        if let Some(joints) = mesh.joints.get(vertex) {
            moved_by.extend(joints.map(u32::from));
        }
        if let Some(weights) = mesh.joint_weights.get(vertex) {
            moved_by.extend(weights.to_array().map(f32::to_bits));
        }
        for target in &mesh.morph_targets {
            moved_by.extend(bits(target.positions.get(vertex)));
        }
        let next = numbers.len() as u32;
        *numbers.entry(moved_by).or_insert(next)
    });
    Some(keys.collect())
}

/// Gives casters their edge mesh when they appear or exchange their mesh.
///
/// Set: `BuildSilhouettes`, first. Cost: the triangles of new meshes.
pub fn build_caster_edges(
    mut commands: Commands,
    mut meshes: ResMut<CasterMeshes>,
    changed: Query<
        (Entity, &SceneMesh, Option<&PosedMesh>),
        (With<ShadowCaster>, Or<(Added<ShadowCaster>, Changed<SceneMesh>)>),
    >,
) {
    for (entity, mesh, posed) in &changed {
        let mut entity = commands.entity(entity);
        match meshes.get_or_build(&mesh.0) {
            Ok(edges) => {
                entity.insert(CasterEdges(edges));
                if posed.is_some() {
                    entity.insert(PosedPlanes::default());
                }
            }
            Err(error) => {
                entity.remove::<CasterEdges>();
                if !meshes.failures.iter().any(|(name, _)| *name == mesh.0.name) {
                    meshes.failures.push((mesh.0.name.clone(), error));
                }
            }
        }
    }
}

/// Recomputes the planes of casters that were posed.
///
/// Set: `BuildSilhouettes`, after [`build_caster_edges`]. Cost: the triangles of posed casters.
pub fn update_posed_planes(
    mut casters: Query<
        (&CasterEdges, &PosedMesh, &mut PosedPlanes),
        Or<(Changed<PosedMesh>, Changed<CasterEdges>)>,
    >,
) {
    for (edges, posed, mut planes) in &mut casters {
        if posed.positions.len() >= edges.0.edges.vertex_count() {
            compute_posed_planes(&edges.0.edges, &posed.positions, &mut planes.0);
        }
    }
}
