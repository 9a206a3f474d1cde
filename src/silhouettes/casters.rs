//! Edge meshes of casters. All objects with one mesh share its edge mesh; each posed object has planes of its
//! own.

use std::borrow::Cow;
use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;
use bevy_ecs::system::SystemParam;
use glam::Vec3;

use super::stacks::piece_boxes;
use super::{FacingPlanes, compute_planes, compute_posed_planes};
use crate::geometry::Aabb;
use crate::geometry::convex_shell::middle_of_shell;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeMeshError, EdgeMeshInput, is_outside_out};
use crate::scene::changes::any_changed;
use crate::scene::{LeftOutSubmeshes, MeshData, PosedMesh, SceneMesh, ShadowCaster, Submeshes};

/// Edges and planes that all casters with one mesh share, as far as they leave out the same submeshes.
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
    /// A number that is equal for meshes whose triangles are equal, and otherwise different but by chance.
    pub fingerprint: u64,
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

/// The edge meshes in use, one for each mesh and each choice of submeshes that are left out of it.
#[derive(Resource, Debug, Default)]
pub struct CasterMeshes {
    /// Keyed by the address of the mesh, and the submeshes that are left out. The weak handle distinguishes a later mesh at
    /// the same address.
    known: HashMap<(usize, Submeshes), (Weak<MeshData>, Arc<CasterMesh>)>,
}

impl CasterMesh {
    /// Builds the edge mesh of a mesh. The time is linear in the mesh's triangles, so do it on a loading
    /// thread and hand the result to [`CasterMeshes::insert`].
    ///
    /// # Errors
    /// [`EdgeMeshError`] names the triangle.
    pub fn build(mesh: &MeshData) -> Result<Self, EdgeMeshError> {
        Self::build_without(mesh, &[])
    }

    /// Builds the edge mesh of a mesh without these submeshes.
    ///
    /// # Errors
    /// [`EdgeMeshError`] names the triangle.
    fn build_without(mesh: &MeshData, left_out: &[u32]) -> Result<Self, EdgeMeshError> {
        let keys = pose_keys(mesh);
        let edges = EdgeMesh::build(EdgeMeshInput {
            positions: &mesh.positions,
            indices: &casting_indices(mesh, left_out),
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
            fingerprint: fingerprint(&edges, &mesh.positions),
            edges,
            planes,
            shows_fronts_alone,
            middle_of_shell,
        })
    }
}

/// Hashes the corners of all triangles.
fn fingerprint(edges: &EdgeMesh, positions: &[Vec3]) -> u64 {
    let corners = edges.corners().iter().flatten();
    let coordinates = corners.flat_map(|&corner| (positions[corner as usize] + 0.0).to_array());
    mixed(coordinates.map(f32::to_bits))
}

/// Mixes numbers to one.
pub(super) fn mixed(numbers: impl IntoIterator<Item = u32>) -> u64 {
    // The odd part of the golden ratio times 2⁶⁴, as in Fibonacci hashing (Knuth, vol. 3, §6.4).
    const FACTOR: u64 = 0x9e37_79b9_7f4a_7c15;
    numbers.into_iter().fold(FACTOR, |mix, number| {
        let mix = (mix ^ u64::from(number)).wrapping_mul(FACTOR);
        mix ^ (mix >> 29)
    })
}

impl CasterMeshes {
    /// Returns the edge mesh of a mesh, and builds it on first use.
    ///
    /// # Errors
    /// [`EdgeMeshError`] names the triangle.
    pub fn get_or_build(&mut self, mesh: &Arc<MeshData>) -> Result<Arc<CasterMesh>, EdgeMeshError> {
        self.get_or_build_without(mesh, &Submeshes::new())
    }

    fn get_or_build_without(
        &mut self,
        mesh: &Arc<MeshData>,
        left_out: &Submeshes,
    ) -> Result<Arc<CasterMesh>, EdgeMeshError> {
        if let Some(built) = self.get(mesh, left_out) {
            return Ok(built.clone());
        }
        let built = Arc::new(CasterMesh::build_without(mesh, left_out)?);
        self.keep(mesh, left_out, built.clone());
        Ok(built)
    }

    /// Keeps an edge mesh that was built elsewhere, from exactly this mesh.
    pub fn insert(&mut self, mesh: &Arc<MeshData>, built: Arc<CasterMesh>) {
        self.keep(mesh, &Submeshes::new(), built);
    }

    fn keep(&mut self, mesh: &Arc<MeshData>, left_out: &Submeshes, built: Arc<CasterMesh>) {
        self.known.retain(|_, (source, _)| source.strong_count() > 0);
        let key = (Arc::as_ptr(mesh) as usize, left_out.clone());
        self.known.insert(key, (Arc::downgrade(mesh), built));
    }

    /// Whether the edge mesh of this whole mesh is known already.
    pub fn contains(&self, mesh: &Arc<MeshData>) -> bool {
        self.get(mesh, &Submeshes::new()).is_some()
    }

    fn get(&self, mesh: &Arc<MeshData>, left_out: &Submeshes) -> Option<&Arc<CasterMesh>> {
        let key = (Arc::as_ptr(mesh) as usize, left_out.clone());
        let (source, built) = self.known.get(&key)?;
        let is_same = source.upgrade().is_some_and(|source| Arc::ptr_eq(&source, mesh));
        is_same.then_some(built)
    }
}

/// The indices of a mesh without those of these submeshes.
fn casting_indices<'m>(mesh: &'m MeshData, left_out: &[u32]) -> Cow<'m, [u32]> {
    if left_out.is_empty() {
        return Cow::Borrowed(&mesh.indices);
    }
    let mut casts = vec![true; mesh.indices.len()];
    for part in left_out
        .iter()
        .filter_map(|&part| mesh.submeshes.get(part as usize))
    {
        casts[mesh.submesh_range(part)].fill(false);
    }
    let casting = mesh.indices.iter().zip(casts).filter(|(_, casts)| *casts);
    Cow::Owned(casting.map(|(index, _)| *index).collect())
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

/// Everything that a caster's edge mesh is built from.
#[derive(SystemParam)]
pub struct CasterSources<'w, 's> {
    casters: Query<'w, 's, Ref<'static, ShadowCaster>>,
    meshes: Query<'w, 's, Ref<'static, SceneMesh>, With<ShadowCaster>>,
    left_out: Query<'w, 's, Ref<'static, LeftOutSubmeshes>>,
}

impl CasterSources<'_, '_> {
    fn any_changed(&self) -> bool {
        any_changed(&self.casters) || any_changed(&self.meshes) || any_changed(&self.left_out)
    }
}

/// Gives a caster its edge mesh when it appears, when its mesh is exchanged, or when other submeshes of it are left out.
///
/// Set: `BuildSilhouettes`, first. Cost: linear in the triangles of new meshes; at rest columns of change ticks are read.
pub fn build_caster_edges(
    mut commands: Commands,
    mut meshes: ResMut<CasterMeshes>,
    sources: CasterSources,
    changed: Query<
        (
            Entity,
            &SceneMesh,
            Option<&PosedMesh>,
            Option<&LeftOutSubmeshes>,
            Has<RefusedCaster>,
        ),
        (
            With<ShadowCaster>,
            Or<(Added<ShadowCaster>, Changed<SceneMesh>, Changed<LeftOutSubmeshes>)>,
        ),
    >,
    without_planes: Query<Entity, (With<CasterEdges>, With<PosedMesh>, Without<PosedPlanes>)>,
) {
    // A pose may come later than its mesh.
    for entity in &without_planes {
        commands.entity(entity).insert(PosedPlanes::default());
    }
    if !sources.any_changed() {
        return;
    }
    let whole = LeftOutSubmeshes::default();
    for (entity, mesh, posed, left_out, was_refused) in &changed {
        let mut entity = commands.entity(entity);
        match meshes.get_or_build_without(&mesh.0, &left_out.unwrap_or(&whole).0) {
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
        Or<(Changed<PosedMesh>, Changed<CasterEdges>, Added<PosedPlanes>)>,
    >,
) {
    for (edges, posed, mut planes) in &mut casters {
        if posed.positions.len() >= edges.0.edges.vertex_count() {
            compute_posed_planes(&edges.0.edges, &posed.positions, &mut planes.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pose_that_comes_after_its_mesh_has_planes() {
        let mut world = World::new();
        world.init_resource::<CasterMeshes>();
        let mut schedule = Schedule::default();
        schedule.add_systems((build_caster_edges, update_posed_planes).chain());
        let mesh = Arc::new(MeshData::cuboid(Vec3::ONE));
        let posed = PosedMesh {
            positions: mesh
                .positions
                .iter()
                .map(|at| Vec3::new(at.x + at.y, at.y, at.z))
                .collect(),
            ..PosedMesh::default()
        };
        let caster = (SceneMesh(mesh), ShadowCaster);
        let late = world.spawn(caster.clone()).id();
        schedule.run(&mut world);
        let early = world.spawn((caster, posed.clone())).id();
        world.entity_mut(late).insert(posed);
        schedule.run(&mut world);
        let planes = |entity| {
            world
                .get::<PosedPlanes>(entity)
                .map(|planes| format!("{planes:?}"))
        };
        assert!(planes(early).is_some());
        assert_eq!(planes(late), planes(early));
    }
}
