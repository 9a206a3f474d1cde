//! Finds casters that exist only to be culled: closed surfaces that are turned inside out, as outlines of characters are.

use std::collections::HashMap;
use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;

use super::frame_view::View;
use crate::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput, is_outside_out};
use crate::scene::{
    CulledCasters, FaceCulling, MeshData, ObjectChurn, SceneMaterials, SceneMesh, ShadowCaster, WorldBounds,
};

/// Casters that the camera sees only from behind, and that therefore cast no shadow. Written by
/// [`find_inverted_hulls`].
#[derive(Resource, Debug, Default)]
pub struct InvertedHulls {
    /// The casters that are left out in this frame, ascending.
    left_out: Vec<Entity>,
    /// The casters that are left out wherever the camera is outside of their bounds.
    hulls: Vec<Entity>,
    /// Whether each mesh is inverted, by its address.
    meshes: HashMap<usize, (Weak<MeshData>, bool)>,
    seen: Option<(u64, FaceCulling, CulledCasters)>,
}

impl InvertedHulls {
    /// Whether a caster is left out in this frame.
    pub fn leaves_out(&self, entity: Entity) -> bool {
        self.left_out.binary_search(&entity).is_ok()
    }

    fn is_inverted(&mut self, mesh: &Arc<MeshData>) -> bool {
        let address = Arc::as_ptr(mesh) as usize;
        if let Some((known, inverted)) = self.meshes.get(&address)
            && known.upgrade().is_some_and(|known| Arc::ptr_eq(&known, mesh))
        {
            return *inverted;
        }
        let inverted = is_inverted_hull(mesh);
        self.meshes.insert(address, (Arc::downgrade(mesh), inverted));
        inverted
    }
}

/// Finds the casters that are left out under [`CulledCasters::LeaveOut`].
///
/// Set: `CollectSets`, after the view and before the objects. Cost: all casters where one came, went or exchanged its
/// mesh or material; the hulls alone in other frames. A mesh is examined once, and only if its volume is negative.
pub fn find_inverted_hulls(
    mut found: ResMut<InvertedHulls>,
    mut churn: ResMut<ObjectChurn>,
    view: Res<View>,
    culling: Res<FaceCulling>,
    setting: Res<CulledCasters>,
    casters: Query<(Entity, &SceneMesh, &SceneMaterials), (With<ShadowCaster>, With<WorldBounds>)>,
    exchanged: Query<(), Or<(Changed<SceneMesh>, Changed<SceneMaterials>)>>,
    bounds: Query<&WorldBounds>,
) {
    let found = &mut *found;
    let now = Some((churn.0, *culling, *setting));
    if found.seen != now || !exchanged.is_empty() {
        let mut hulls = std::mem::take(&mut found.hulls);
        hulls.clear();
        found.meshes.retain(|_, (mesh, _)| mesh.strong_count() > 0);
        if *culling == FaceCulling::SingleSided && *setting == CulledCasters::LeaveOut {
            for (entity, mesh, materials) in &casters {
                let culled = materials.0.iter().all(|material| !material.double_sided);
                if culled && !materials.0.is_empty() && found.is_inverted(&mesh.0) {
                    hulls.push(entity);
                }
            }
        }
        hulls.sort_unstable();
        found.hulls = hulls;
    }
    let eye = view.data.as_ref().map(|view| view.eye.as_vec3());
    let is_outside = |entity: Entity| {
        let bounds = bounds.get(entity).map(|bounds| bounds.0);
        eye.zip(bounds.ok())
            .is_none_or(|(eye, bounds)| !bounds.contains(eye))
    };
    let culled = found.hulls.iter().copied().filter(|&entity| is_outside(entity));
    if !culled.clone().eq(found.left_out.iter().copied()) {
        let culled: Vec<Entity> = culled.collect();
        found.left_out = culled;
        churn.0 += 1; // the objects are collected anew
    }
    found.seen = Some((churn.0, *culling, *setting));
}

/// Whether a mesh is closed and shows only backs from everywhere around it.
fn is_inverted_hull(mesh: &MeshData) -> bool {
    let corner = |index: u32| {
        mesh.positions
            .get(index as usize)
            .map(|position| position.as_dvec3())
    };
    let volume: Option<f64> = mesh
        .indices
        .as_chunks::<3>()
        .0
        .iter()
        .map(|&[a, b, c]| Some(corner(a)?.dot(corner(b)?.cross(corner(c)?))))
        .sum();
    if !volume.is_some_and(|volume| volume < 0.0) {
        return false;
    }
    let edges = EdgeMesh::build(EdgeMeshInput {
        positions: &mesh.positions,
        indices: &mesh.indices,
        pose_keys: None,
        weld_epsilon: None,
    });
    edges.is_ok_and(|edges| {
        let turned: Vec<[u32; 3]> = edges.corners().iter().map(|&[a, b, c]| [a, c, b]).collect();
        edges.is_closed() && is_outside_out(&mesh.positions, &turned)
    })
}
