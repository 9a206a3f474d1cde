//! Finds casters that exist only to be culled: closed surfaces that are turned inside out, as outlines of characters are. Such
//! a surface is a whole object, or a submesh of one.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;
use glam::{DVec3, Vec3};

use super::frame_view::View;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput, is_outside_out};
use crate::scene::changes::NewAppearances;
use crate::scene::{
    CulledCasters, FaceCulling, MeshData, ObjectChurn, SceneMaterials, SceneMesh, ShadowCaster, Submeshes,
    WorldBounds,
};

/// Casters and submeshes that the camera sees only from behind, and that therefore cast no shadow. Written by
/// [`find_inverted_hulls`].
#[derive(Resource, Debug, Default)]
pub struct InvertedHulls {
    /// The casters that are left out in this frame, ascending.
    left_out: Vec<Entity>,
    /// The submeshes that are left out in this frame while others of their caster are not, ascending by entity.
    parts: Vec<(Entity, Submeshes)>,
    /// The casters that are left out wherever the camera is outside of their bounds, ascending by entity. The list of
    /// submeshes is empty for a caster that is left out as a whole.
    hulls: Vec<(Entity, Submeshes)>,
    /// The inverted parts of each mesh, by its address.
    meshes: HashMap<usize, (Weak<MeshData>, Inverted)>,
    seen: Option<(u64, FaceCulling, CulledCasters)>,
}

/// The inverted parts of a mesh, whatever its materials are.
#[derive(Clone, Debug, Default)]
struct Inverted {
    whole: bool,
    /// Submeshes that are inverted hulls by themselves; empty for a mesh of one submesh.
    submeshes: Submeshes,
}

impl InvertedHulls {
    /// Whether a caster is left out in this frame as a whole.
    pub fn leaves_out(&self, entity: Entity) -> bool {
        self.left_out.binary_search(&entity).is_ok()
    }

    /// The submeshes that are left out in this frame while others of their caster are not, ascending by entity.
    pub(in crate::sets) fn parts(&self) -> &[(Entity, Submeshes)] {
        &self.parts
    }

    fn inverted(&mut self, mesh: &Arc<MeshData>) -> &Inverted {
        let address = Arc::as_ptr(mesh) as usize;
        let entry = self.meshes.entry(address);
        let entry = entry.or_insert_with(|| (Weak::new(), Inverted::default()));
        if !entry.0.upgrade().is_some_and(|known| Arc::ptr_eq(&known, mesh)) {
            *entry = (Arc::downgrade(mesh), Inverted::of(mesh));
        }
        &entry.1
    }

    /// Returns what of a caster is culled: no submeshes stand for the whole. `None` if nothing is.
    fn hull(&mut self, mesh: &Arc<MeshData>, materials: &SceneMaterials) -> Option<Submeshes> {
        let materials = &materials.0;
        if materials.iter().all(|material| material.double_sided) {
            return None;
        }
        let inverted = self.inverted(mesh);
        if inverted.whole && materials.iter().all(|material| !material.double_sided) {
            return Some(Submeshes::new());
        }
        let is_culled = |part: &&u32| {
            let material = materials.get(**part as usize);
            material.is_some_and(|material| !material.double_sided)
        };
        let culled: Submeshes = inverted.submeshes.iter().filter(is_culled).copied().collect();
        (!culled.is_empty()).then_some(culled)
    }
}

impl Inverted {
    fn of(mesh: &MeshData) -> Self {
        let parts = (0u32..).zip(&mesh.submeshes);
        let is_hull = |indices: &[u32]| is_inverted_hull(mesh, indices);
        let hulls = parts.filter(|(_, part)| is_hull(&mesh.indices[mesh.submesh_range(part)]));
        Self {
            whole: is_hull(&mesh.indices),
            submeshes: match mesh.submeshes.len() {
                0 | 1 => Submeshes::new(),
                _ => hulls.map(|(index, _)| index).collect(),
            },
        }
    }
}

/// Finds the casters and submeshes that are left out under [`CulledCasters::LeaveOut`].
///
/// Set: `CollectSets`, after the view and before the objects. Cost: all casters where one came or went, those that exchanged
/// their mesh or material, and the hulls in every frame. A mesh is examined once, and a surface of it only if its volume is
/// negative.
pub fn find_inverted_hulls(
    mut found: ResMut<InvertedHulls>,
    mut churn: ResMut<ObjectChurn>,
    view: Res<View>,
    culling: Res<FaceCulling>,
    setting: Res<CulledCasters>,
    casters: Query<(Entity, &SceneMesh, &SceneMaterials), (With<ShadowCaster>, With<WorldBounds>)>,
    mut appearances: NewAppearances,
    bounds: Query<&WorldBounds>,
) {
    let found = &mut *found;
    let now = Some((churn.0, *culling, *setting));
    let exchanges = appearances.take();
    let same_casters = found.seen == now;
    if !same_casters || !exchanges.is_none() {
        let are_culled = *culling == FaceCulling::SingleSided && *setting == CulledCasters::LeaveOut;
        let mut hulls = std::mem::take(&mut found.hulls);
        found.meshes.retain(|_, (mesh, _)| mesh.strong_count() > 0);
        let mut hull_of = |(entity, mesh, materials): (Entity, &SceneMesh, &SceneMaterials)| {
            let parts = are_culled.then(|| found.hull(&mesh.0, materials))?;
            parts.map(|parts| (entity, parts))
        };
        if let Some(entities) = exchanges.few().filter(|_| same_casters) {
            for &entity in entities {
                let at = hulls.partition_point(|(listed, _)| *listed < entity);
                if hulls.get(at).is_some_and(|(listed, _)| *listed == entity) {
                    hulls.remove(at);
                }
                if let Some(hull) = casters.get(entity).ok().and_then(&mut hull_of) {
                    hulls.insert(at, hull);
                }
            }
        } else {
            hulls.clear();
            hulls.extend(casters.iter().filter_map(hull_of));
            hulls.sort_unstable();
        }
        found.hulls = hulls;
    }
    let eye = view.data.as_ref().map(|view| view.eye.as_vec3());
    let is_outside = |entity: Entity| {
        let bounds = bounds.get(entity).map(|bounds| bounds.0);
        eye.zip(bounds.ok())
            .is_none_or(|(eye, bounds)| !bounds.contains(eye))
    };
    let culled = || found.hulls.iter().filter(|(entity, _)| is_outside(*entity));
    let whole = culled().filter(|(_, parts)| parts.is_empty());
    let whole = whole.map(|(entity, _)| *entity);
    if !whole.clone().eq(found.left_out.iter().copied()) {
        found.left_out = whole.collect();
        churn.0 += 1; // the objects are collected anew
    }
    let parts = culled().filter(|(_, parts)| !parts.is_empty());
    if !parts.clone().eq(&found.parts) {
        found.parts = parts.cloned().collect();
    }
    found.seen = Some((churn.0, *culling, *setting));
}

/// Largest sum of a closed surface's areas as vectors, as a share of their sum as numbers. It is 0 but for rounding.
const OPEN: f64 = 1e-3;

/// Whether triangles of a mesh form a closed surface that shows only backs from everywhere around it.
fn is_inverted_hull(mesh: &MeshData, indices: &[u32]) -> bool {
    let corner = |index: u32| mesh.positions.get(index as usize).map(|at| at.as_dvec3());
    let (mut volume, mut outward, mut area) = (0.0, DVec3::ZERO, 0.0);
    for &[a, b, c] in indices.as_chunks::<3>().0 {
        let (Some(a), Some(b), Some(c)) = (corner(a), corner(b), corner(c)) else {
            return false;
        };
        volume += a.dot(b.cross(c));
        let across = (b - a).cross(c - a);
        outward += across;
        area += across.length();
    }
    // Most surfaces are found out here. What is not finite is no hull.
    if !(volume < 0.0 && outward.length() <= OPEN * area) {
        return false;
    }
    // Turned around it is an ordinary closed mesh; as it is, its pieces count as open.
    let (positions, mut turned) = own_vertices(&mesh.positions, indices.as_chunks::<3>().0.as_flattened());
    for corners in turned.as_chunks_mut::<3>().0 {
        corners.swap(1, 2);
    }
    let edges = EdgeMesh::build(EdgeMeshInput {
        positions: &positions,
        indices: &turned,
        pose_keys: None,
        weld_epsilon: None,
    });
    edges.is_ok_and(|edges| edges.is_closed() && is_outside_out(&positions, edges.corners()))
}

/// The vertices that `indices` name, in the order of the mesh, and `indices` counted among them. O(n log n) in the number of
/// indices: a mesh of many submeshes has each of its vertices welded once, not once for each submesh.
///
/// All indices must be in range.
fn own_vertices(positions: &[Vec3], indices: &[u32]) -> (Vec<Vec3>, Vec<u32>) {
    let mut named = indices.to_vec();
    named.sort_unstable();
    named.dedup();
    let number = |index: &u32| named.partition_point(|named| named < index) as u32;
    let numbers = indices.iter().map(number).collect();
    (
        named.iter().map(|&index| positions[index as usize]).collect(),
        numbers,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Submesh;

    /// A mesh of boxes that are inside out, with a submesh each.
    fn boxes(count: u32) -> MeshData {
        let mut mesh = MeshData::default();
        for place in 0..count {
            let part = MeshData::cuboid(Vec3::splat(0.25));
            let base = mesh.positions.len() as u32;
            let corners = part.indices.as_chunks::<3>().0.iter();
            mesh.submeshes.push(Submesh {
                first_index: mesh.indices.len() as u32,
                index_count: part.indices.len() as u32,
            });
            mesh.indices
                .extend(corners.flat_map(|&[a, b, c]| [base + a, base + c, base + b]));
            let shift = place as f32 * Vec3::X;
            mesh.positions.extend(part.positions.iter().map(|at| at + shift));
        }
        mesh
    }

    #[test]
    fn a_submesh_is_examined_with_its_own_vertices_alone() {
        let mesh = boxes(50);
        let each = mesh.positions.len() / 50;
        let mut examined = 0;
        for part in &mesh.submeshes {
            let indices = &mesh.indices[mesh.submesh_range(part)];
            let (positions, numbers) = own_vertices(&mesh.positions, indices);
            assert_eq!(positions.len(), each);
            examined += positions.len();
            for (&number, &index) in numbers.iter().zip(indices) {
                assert_eq!(positions[number as usize], mesh.positions[index as usize]);
            }
        }
        assert_eq!(examined, mesh.positions.len(), "each vertex once");
        let found = Inverted::of(&mesh);
        assert!(found.whole);
        assert_eq!(found.submeshes.to_vec(), Vec::from_iter(0..50));
    }

    #[test]
    fn vertices_keep_their_order_and_unnamed_ones_are_left_out() {
        let positions: Vec<Vec3> = (0..6).map(|x| Vec3::X * x as f32).collect();
        let (own, numbers) = own_vertices(&positions, &[5, 1, 3, 3, 1, 5]);
        assert_eq!(own, [positions[1], positions[3], positions[5]]);
        assert_eq!(numbers, [2, 0, 1, 1, 0, 2]);
    }
}
