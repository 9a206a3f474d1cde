//! From Bevy's meshes to the objects of the mirrors.

use std::sync::Arc;

use bevy::asset::Assets;
use bevy::camera::primitives::Aabb as BevyAabb;
use bevy::camera::visibility::{InheritedVisibility, RenderLayers};
use bevy::ecs::prelude::*;
use bevy::ecs::world::EntityRef;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::mesh::Mesh3d;
use bevy::mesh::morph::{MeshMorphWeights, MorphWeights as BevyMorphWeights};
use bevy::mesh::skinning::{SkinnedMesh, SkinnedMeshInverseBindposes};
use bevy::pbr::{MeshMaterial3d, StandardMaterial};
use bevy::render::{Extract, MainWorld};
use bevy::transform::components::GlobalTransform;
use glam::Vec3;

use super::light_convert::layer_bits;
use super::mesh_library::{MeshEntry, MeshLibrary, ReadyMesh};
use super::mirror::{HostBounds, Mirror, Mirrors};
use super::refused::RefusedMeshes;
use super::surfaces::Surfaces;
use crate::geometry::Aabb;
use crate::scene::{
    LocalBounds, MorphWeights, PosedMesh, SceneMaterials, SceneMesh, SelectionLayers, ShadowCaster,
    ShadowReceiver, Skin, WorldBounds,
};
use crate::silhouettes::CasterMeshes;
use crate::silhouettes::casters::{CasterEdges, PosedPlanes};

/// An object changed in a way that is to be taken over. Places are taken over by themselves.
type ObjectChanged = (
    With<Mesh3d>,
    Or<(
        Changed<Mesh3d>,
        Changed<RenderLayers>,
        Changed<InheritedVisibility>,
        Changed<BevyAabb>,
        Changed<SkinnedMesh>,
        Changed<MeshMorphWeights>,
        Changed<MeshMaterial3d<StandardMaterial>>,
        Added<NotShadowCaster>,
        Added<NotShadowReceiver>,
    )>,
);

/// Of what an object lost, that which matters.
#[derive(bevy::ecs::system::SystemParam)]
pub struct RemovedFromObjects<'w, 's> {
    mesh: Extract<'w, 's, RemovedComponents<'static, 'static, Mesh3d>>,
    layers: Extract<'w, 's, RemovedComponents<'static, 'static, RenderLayers>>,
    not_caster: Extract<'w, 's, RemovedComponents<'static, 'static, NotShadowCaster>>,
    not_receiver: Extract<'w, 's, RemovedComponents<'static, 'static, NotShadowReceiver>>,
    skin: Extract<'w, 's, RemovedComponents<'static, 'static, SkinnedMesh>>,
    weights: Extract<'w, 's, RemovedComponents<'static, 'static, MeshMorphWeights>>,
    material: Extract<'w, 's, RemovedComponents<'static, 'static, MeshMaterial3d<StandardMaterial>>>,
}

/// Weights that meshes share by naming the entity that has them.
type SharedWeights<'w, 's> = Query<'w, 's, (), Changed<BevyMorphWeights>>;

/// Takes over objects that appeared, changed, were hidden, or whose mesh changed.
///
/// `ExtractSchedule`, [`Sync`](super::AntumbraExtractSystems::Sync). In a steady frame it only reads change ticks; in
/// frames in which a mesh changed it asks every object for its mesh.
pub(super) fn sync_objects(
    main: Res<MainWorld>,
    mut mirrors: ResMut<Mirrors>,
    mut refused: ResMut<RefusedMeshes>,
    changed: Extract<Query<Entity, ObjectChanged>>,
    all: Extract<Query<(Entity, &Mesh3d)>>,
    morphed: Extract<Query<(Entity, &MeshMorphWeights), With<Mesh3d>>>,
    weights: Extract<SharedWeights>,
    mut removed: RemovedFromObjects,
    library: Extract<Res<MeshLibrary>>,
    surfaces: Res<Surfaces>,
    materials: Extract<Query<(Entity, &MeshMaterial3d<StandardMaterial>), With<Mesh3d>>>,
    mut dirty: Local<Vec<Entity>>,
    mut waiting: Local<Vec<Entity>>,
) {
    dirty.clear();
    dirty.append(&mut waiting);
    dirty.extend(changed.iter());
    dirty.extend(removed.mesh.read());
    dirty.extend(removed.layers.read());
    dirty.extend(removed.not_caster.read());
    dirty.extend(removed.not_receiver.read());
    dirty.extend(removed.skin.read());
    dirty.extend(removed.weights.read());
    dirty.extend(removed.material.read());
    if surfaces.any_changed() {
        let uses = materials
            .iter()
            .filter(|(_, material)| surfaces.changed(material.0.id()));
        dirty.extend(uses.map(|(entity, _)| entity));
    }
    if !library.changed().is_empty() {
        let uses = |&(_, mesh): &(Entity, &Mesh3d)| library.changed().contains(&mesh.0.id());
        dirty.extend(all.iter().filter(uses).map(|(entity, _)| entity));
        let is_refused = |mesh| matches!(library.get(mesh), Some(MeshEntry::Refused(_)));
        refused.resolve(library.changed(), is_refused);
    }
    for (entity, weighted) in &morphed {
        if let MeshMorphWeights::Reference(shared) = weighted
            && weights.contains(*shared)
        {
            dirty.push(entity);
        }
    }
    dirty.sort_unstable();
    dirty.dedup();
    for mirror in mirrors.iter_mut() {
        if mirror.fresh {
            for (entity, _) in &all {
                sync_object(
                    mirror,
                    &main,
                    &library,
                    &surfaces,
                    &mut refused,
                    &mut waiting,
                    entity,
                );
            }
        } else {
            for &entity in &*dirty {
                sync_object(
                    mirror,
                    &main,
                    &library,
                    &surfaces,
                    &mut refused,
                    &mut waiting,
                    entity,
                );
            }
        }
    }
}

fn sync_object(
    mirror: &mut Mirror,
    main: &World,
    library: &MeshLibrary,
    surfaces: &Surfaces,
    refused: &mut RefusedMeshes,
    waiting: &mut Vec<Entity>,
    entity: Entity,
) {
    let Ok(object) = main.get_entity(entity) else {
        mirror.despawn(entity);
        return;
    };
    let is_visible = object
        .get::<InheritedVisibility>()
        .is_none_or(|visibility| visibility.get());
    let (true, Some(mesh), Some(transform)) = (
        is_visible,
        object.get::<Mesh3d>(),
        object.get::<GlobalTransform>(),
    ) else {
        mirror.remove_object(entity);
        return;
    };
    let ready = match library.get(mesh.0.id()) {
        Some(MeshEntry::Ready(ready)) => Some(ready),
        Some(MeshEntry::Refused(refusal)) => {
            refused.insert(mesh.0.id(), mesh.0.path(), entity, *refusal);
            None
        }
        Some(MeshEntry::Building(_)) | None => None,
    };
    let mirrored = mirror.get_or_spawn(entity, transform);
    match ready {
        Some(ready) => {
            insert_mesh(mirror, mirrored, ready);
            if !sync_pose(mirror, main, &object, mirrored) {
                waiting.push(entity);
            }
        }
        None => insert_bounds(mirror, mirrored, &object, transform),
    }
    let layers = object.get::<RenderLayers>();
    let seen = mirror.layers.intersects(layers.unwrap_or_default());
    let bits = SelectionLayers(layer_bits(layers));
    let mut target = mirror.world.entity_mut(mirrored);
    if target.get::<SelectionLayers>() != Some(&bits) {
        target.insert(bits);
    }
    set(
        &mut target,
        ShadowCaster,
        ready.is_some() && !object.contains::<NotShadowCaster>(),
    );
    set(
        &mut target,
        ShadowReceiver,
        !object.contains::<NotShadowReceiver>(),
    );
    let materials = surfaces.materials(surfaces.of_object(&object));
    let same = |known: &SceneMaterials| Arc::ptr_eq(&known.0[0], &materials.0[0]);
    if !seen {
        target.remove::<SceneMaterials>();
    } else if !target.get::<SceneMaterials>().is_some_and(same) {
        target.insert(materials.clone());
    }
}

fn set<C: Component>(target: &mut EntityWorldMut, marker: C, wanted: bool) {
    if wanted != target.contains::<C>() {
        if wanted {
            target.insert(marker);
        } else {
            target.remove::<C>();
        }
    }
}

fn insert_mesh(mirror: &mut Mirror, mirrored: Entity, ready: &ReadyMesh) {
    let same = |mesh: &SceneMesh| Arc::ptr_eq(&mesh.0, &ready.data);
    if mirror.world.get::<SceneMesh>(mirrored).is_some_and(same) {
        return;
    }
    if let Ok(edges) = &ready.edges {
        let mut known = mirror.world.resource_mut::<CasterMeshes>();
        if !known.contains(&ready.data) {
            known.insert(&ready.data, edges.clone());
        }
    }
    let mut target = mirror.world.entity_mut(mirrored);
    target.remove::<HostBounds>();
    target.insert(SceneMesh(ready.data.clone()));
}

/// A mesh that is not there, or never will be, is lit all the same: its bounds say where.
fn insert_bounds(mirror: &mut Mirror, mirrored: Entity, object: &EntityRef, transform: &GlobalTransform) {
    let bounds = object.get::<BevyAabb>().map_or(EVERYWHERE, |aabb| Aabb {
        min: Vec3::from(aabb.min()),
        max: Vec3::from(aabb.max()),
    });
    let mut target = mirror.world.entity_mut(mirrored);
    target.remove::<(
        SceneMesh,
        LocalBounds,
        Skin,
        MorphWeights,
        PosedMesh,
        CasterEdges,
        PosedPlanes,
    )>();
    if target.get::<HostBounds>() != Some(&HostBounds(bounds)) {
        let world = WorldBounds(bounds.transformed(&transform.affine()));
        target.insert((HostBounds(bounds), world));
    }
}

/// Of a mesh without bounds, which Bevy does not cull either. A thousand kilometres: far beyond what is drawn, and exact
/// enough when squared.
const EVERYWHERE: Aabb = Aabb {
    min: Vec3::splat(-1e6),
    max: Vec3::splat(1e6),
};

/// Skin and morph weights, as Bevy has them; `false` while the asset of a skin is not there.
fn sync_pose(mirror: &mut Mirror, main: &World, object: &EntityRef, mirrored: Entity) -> bool {
    let binds = main.resource::<Assets<SkinnedMeshInverseBindposes>>();
    let skin = object.get::<SkinnedMesh>().and_then(|skin| {
        let inverse_bind = binds.get(&skin.inverse_bindposes)?;
        let joints = skin.joints.iter().map(|&joint| {
            let transform = main.get::<GlobalTransform>(joint).copied().unwrap_or_default();
            mirror.get_or_spawn(joint, &transform)
        });
        Some((joints.collect::<Vec<_>>(), &inverse_bind[..]))
    });
    let weights = object
        .get::<MeshMorphWeights>()
        .and_then(|weights| match weights {
            MeshMorphWeights::Value { weights } => Some(&weights[..]),
            MeshMorphWeights::Reference(shared) => main
                .get::<BevyMorphWeights>(*shared)
                .map(|shared| shared.weights()),
        });
    let mut target = mirror.world.entity_mut(mirrored);
    match skin {
        Some((joints, inverse_bind)) => {
            let same = |skin: &Skin| skin.joints == joints && *skin.inverse_bind == *inverse_bind;
            if !target.get::<Skin>().is_some_and(same) {
                target.insert(Skin {
                    joints,
                    inverse_bind: inverse_bind.into(),
                });
            }
        }
        None => {
            target.remove::<Skin>();
        }
    }
    match weights {
        Some(weights) => {
            if !target
                .get::<MorphWeights>()
                .is_some_and(|known| known.0 == weights)
            {
                target.insert(MorphWeights(weights.to_vec()));
            }
        }
        None => {
            target.remove::<MorphWeights>();
        }
    }
    !object.contains::<SkinnedMesh>() || target.contains::<Skin>()
}
