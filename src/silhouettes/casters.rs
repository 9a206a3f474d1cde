//! Edge meshes of casters. All objects with one mesh share its edge mesh; each posed object has planes of its
//! own.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;
use glam::Vec3;

use super::stacks::piece_boxes;
use super::{FacingPlanes, compute_planes, compute_posed_planes};
use crate::geometry::Aabb;
use crate::geometry::convex_shell::middle_of_shell;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeMeshError, EdgeMeshInput, is_outside_out};
use crate::scene::{MeshData, PosedMesh, SceneMesh, ShadowCaster};

/// Edges and planes that all casters with one mesh share.
#[derive(Debug)]
pub struct CasterMesh {
    /// Welded triangles and their edges.
    pub edges: EdgeMesh,
    /// Planes of the triangles in the mesh's rest pose.
    pub planes: FacingPlanes,
    /// Whether only fronts of the mesh are seen from outside in any pose: it is closed, never posed, and nowhere inside
    /// out.
    pub shows_fronts_alone: bool,
    /// A point inside of the convex body on whose surface the mesh lies, local space, as for a room or a sky dome. `None` for
    /// any other mesh, and for one that is posed.
    pub middle_of_shell: Option<Vec3>,
    /// Boxes of the pieces, local space, each with weight 1. Empty for a mesh of one piece.
    pub pieces: Vec<(Aabb, u32)>,
}

/// The edge mesh of a caster, written by `build_caster_edges`.
///
/// A caster whose mesh has no edge mesh does not have this component but a [`RefusedCaster`], and casts nothing.
#[derive(Component, Clone, Debug)]
pub struct CasterEdges(pub Arc<CasterMesh>);

/// Why a caster casts nothing. Written by `build_caster_edges`; it stays as long as the entity has the mesh.
#[derive(Component, Clone, Debug, PartialEq)]
pub struct RefusedCaster(pub EdgeMeshError);

/// Planes of a posed caster's triangles in this frame's pose. Written by `update_posed_planes`.
#[derive(Component, Clone, Debug, Default)]
pub struct PosedPlanes(pub FacingPlanes);

/// The edge meshes in use, one per mesh.
#[derive(Resource, Debug, Default)]
pub struct CasterMeshes {
    /// Keyed by the address of the mesh. The weak handle distinguishes a later mesh at the same address.
    by_address: HashMap<usize, (Weak<MeshData>, Arc<CasterMesh>)>,
}

impl CasterMesh {
    /// Builds the edge mesh of a mesh. The time is linear in the mesh's triangles, so do it on a loading
    /// thread and hand the result to [`CasterMeshes::insert`].
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
        // A pose may turn parts inside out, which the rest pose does not show.
        let shows_fronts_alone =
            keys.is_none() && edges.is_closed() && is_outside_out(&mesh.positions, edges.corners());
        let middle_of_shell = match keys {
            Some(_) => None,
            None => middle_of_shell(&mesh.positions, edges.corners()),
        };
        let pieces = piece_boxes(&edges, &mesh.positions);
        Ok(Self {
            pieces: pieces.into_iter().map(|aabb| (aabb, 1)).collect(),
            edges,
            planes,
            shows_fronts_alone,
            middle_of_shell,
        })
    }
}

impl CasterMeshes {
    /// Returns the edge mesh of a mesh, and builds it on first use.
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

    /// Keeps an edge mesh that was built elsewhere, from exactly this mesh.
    pub fn insert(&mut self, mesh: &Arc<MeshData>, built: Arc<CasterMesh>) {
        self.by_address.retain(|_, (source, _)| source.strong_count() > 0);
        self.by_address
            .insert(address(mesh), (Arc::downgrade(mesh), built));
    }

    /// Whether the edge mesh of this mesh is known already.
    pub fn contains(&self, mesh: &Arc<MeshData>) -> bool {
        let known = self.by_address.get(&address(mesh));
        known.is_some_and(|(source, _)| source.upgrade().is_some_and(|source| Arc::ptr_eq(&source, mesh)))
    }
}

fn address(mesh: &Arc<MeshData>) -> usize {
    Arc::as_ptr(mesh) as usize
}

/// A number for each vertex. Two vertices have equal numbers if every pose moves them alike; only such
/// vertices may be welded. `None` for a mesh that is never posed.
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

/// Gives a caster its edge mesh when it appears or when its mesh is exchanged.
///
/// Set: `BuildSilhouettes`, first. Cost: linear in the triangles of new meshes.
pub fn build_caster_edges(
    mut commands: Commands,
    mut meshes: ResMut<CasterMeshes>,
    changed: Query<
        (Entity, &SceneMesh, Option<&PosedMesh>, Has<RefusedCaster>),
        (With<ShadowCaster>, Or<(Added<ShadowCaster>, Changed<SceneMesh>)>),
    >,
) {
    for (entity, mesh, posed, was_refused) in &changed {
        let mut entity = commands.entity(entity);
        match meshes.get_or_build(&mesh.0) {
            Ok(edges) => {
                entity.insert(CasterEdges(edges));
                if was_refused {
                    entity.remove::<RefusedCaster>();
                }
                if posed.is_some() {
                    entity.insert(PosedPlanes::default());
                }
            }
            Err(error) => {
                entity.remove::<CasterEdges>().insert(RefusedCaster(error));
            }
        }
    }
}

/// Recomputes the planes of casters whose pose changed.
///
/// Set: `BuildSilhouettes`, after [`build_caster_edges`]. Cost: linear in the triangles of posed casters.
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
