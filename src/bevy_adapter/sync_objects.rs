//! Synchronisation of the mirrors' objects with the game's meshes.

use std::sync::Arc;

use bevy::asset::Assets;
use bevy::camera::primitives::Aabb as BevyAabb;
use bevy::camera::visibility::NoAutoAabb;
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

use super::cut_outs::CutOutCasters;
use super::light_convert::layer_bits;
use super::mesh_library::{MeshEntry, MeshLibrary, ReadyMesh};
use super::mirror::{HostBounds, Mirror, Mirrors, mirrors};
use super::ranges::Level;
use super::refused::RefusedMeshes;
use super::surfaces::{Surface, Surfaces, standard_material};
use super::sync_models::copy_part;
use crate::geometry::Aabb;
use crate::scene::{
    BlurredGround, ExtraBounds, LocalBounds, MorphWeights, PosedMesh, SceneMaterials, SceneMesh,
    SelectionLayers, ShadowCaster, ShadowReceiver, Skin, SurfaceWeights, WorldBounds,
};
use crate::silhouettes::CasterMeshes;
use crate::silhouettes::casters::{CasterEdges, PosedPlanes};

/// Filter of objects that changed in a way that the mirrors must copy. Transforms are copied by another
/// system.
type ObjectChanged = (
    With<Mesh3d>,
    Or<(
        Changed<Mesh3d>,
        Changed<RenderLayers>,
        Changed<InheritedVisibility>,
        Changed<BevyAabb>,
        Changed<SkinnedMesh>,
        Changed<MeshMorphWeights>,
        Changed<SurfaceWeights>,
        Changed<MeshMaterial3d<StandardMaterial>>,
        Changed<BlurredGround>,
        Added<NotShadowCaster>,
        Added<NotShadowReceiver>,
        Added<NoAutoAabb>,
    )>,
);

/// Removed components that force an object to be synchronised again.
#[derive(bevy::ecs::system::SystemParam)]
pub struct RemovedFromObjects<'w, 's> {
    mesh: Extract<'w, 's, RemovedComponents<'static, 'static, Mesh3d>>,
    layers: Extract<'w, 's, RemovedComponents<'static, 'static, RenderLayers>>,
    not_caster: Extract<'w, 's, RemovedComponents<'static, 'static, NotShadowCaster>>,
    not_receiver: Extract<'w, 's, RemovedComponents<'static, 'static, NotShadowReceiver>>,
    skin: Extract<'w, 's, RemovedComponents<'static, 'static, SkinnedMesh>>,
    weights: Extract<'w, 's, RemovedComponents<'static, 'static, MeshMorphWeights>>,
    material: Extract<'w, 's, RemovedComponents<'static, 'static, MeshMaterial3d<StandardMaterial>>>,
    surface_weights: Extract<'w, 's, RemovedComponents<'static, 'static, SurfaceWeights>>,
    ground: Extract<'w, 's, RemovedComponents<'static, 'static, BlurredGround>>,
}

/// Query of changed morph weights that meshes share. Such a mesh refers to the entity that has the weights.
type SharedWeights<'w, 's> = Query<'w, 's, (), Changed<BevyMorphWeights>>;

/// Copies objects that appeared, changed or were hidden, or whose mesh or material changed, to the mirrors.
///
/// Runs in `ExtractSchedule`. Set: [`Sync`](super::AntumbraExtractSystems::Sync). In a steady frame it only
/// reads change ticks and tests the morphed meshes for shared weights. In frames in which a mesh asset
/// changed it reads the mesh handle of every object.
pub(super) fn sync_objects(
    main: Res<MainWorld>,
    mut mirrors: ResMut<Mirrors>,
    mut refused: ResMut<RefusedMeshes>,
    mut cut_outs: ResMut<CutOutCasters>,
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
    dirty.extend(removed.surface_weights.read());
    dirty.extend(removed.ground.read());
    if surfaces.any_changed() {
        cut_outs.retain(|material| surfaces.is_cut_out(material));
        let uses = materials
            .iter()
            .filter(|(_, material)| surfaces.changed(material.0.id()));
        dirty.extend(uses.map(|(entity, _)| entity));
    }
    if !library.changed().is_empty() {
        let uses = |&(_, mesh): &(Entity, &Mesh3d)| library.has_changed(mesh.0.id());
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
    let game = Game {
        main: &main,
        library: &library,
        surfaces: &surfaces,
    };
    for mirror in mirrors.iter_mut() {
        let mut own = std::mem::take(&mut mirror.dirty);
        let is_fresh = mirror.fresh;
        let mut sync =
            |entity| sync_object(mirror, &game, (&mut refused, &mut cut_outs), &mut waiting, entity);
        if is_fresh {
            all.iter().for_each(|(entity, _)| sync(entity));
        } else {
            own.retain(|entity| dirty.binary_search(entity).is_err());
            own.iter().chain(&*dirty).for_each(|&entity| sync(entity));
        }
        own.clear();
        mirror.dirty = own; // keeps its allocation
    }
}

/// The parts of the game from which objects are copied.
struct Game<'a> {
    main: &'a World,
    library: &'a MeshLibrary,
    surfaces: &'a Surfaces,
}

fn sync_object(
    mirror: &mut Mirror,
    game: &Game,
    (refused, cut_outs): (&mut RefusedMeshes, &mut CutOutCasters),
    waiting: &mut Vec<Entity>,
    entity: Entity,
) {
    let Ok(object) = game.main.get_entity(entity) else {
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
    let ready = match game.library.get(mesh.0.id()) {
        Some(MeshEntry::Ready(ready)) => Some(ready),
        Some(MeshEntry::Refused(refusal)) => {
            refused.insert(mesh.0.id(), mesh.0.path(), entity, *refusal);
            None
        }
        Some(MeshEntry::Building) | None => None,
    };
    let mirrored = mirror.get_or_spawn(entity, transform);
    match ready {
        Some(ready) => {
            insert_mesh(mirror, mirrored, ready);
            if !sync_pose(mirror, game.main, &object, mirrored) {
                waiting.push(entity);
            }
        }
        None => insert_bounds(mirror, mirrored, &object, transform),
    }
    let layers = object.get::<RenderLayers>();
    let bits = SelectionLayers(layer_bits(layers));
    let level = mirror.level(entity);
    let material = standard_material(&object);
    let surface = surface_of(&object, transform, level, game.surfaces);
    let seen = level.is_drawn() && mirror.layers.intersects(layers.unwrap_or_default());
    let mut target = mirror.world.entity_mut(mirrored);
    if target.get::<SelectionLayers>() != Some(&bits) {
        target.insert(bits);
    }
    copy_part::<SurfaceWeights>(&object, &mut target);
    let casts = ready.is_some()
        && level.casts()
        && surface != Surface::NotDrawn
        && !object.contains::<NotShadowCaster>();
    set_part(&mut target, object.get::<BlurredGround>().copied());
    // Bevy measures other meshes itself. While a later shape is not ready but drawn, only Bevy's bounds hold it.
    let is_outdated = ready.is_some() && game.library.is_building(mesh.0.id());
    let counts = is_outdated || object.contains::<NoAutoAabb>();
    let given = object.get::<BevyAabb>().filter(|_| counts);
    set_part(&mut target, given.map(|aabb| ExtraBounds(converted(aabb))));
    set(&mut target, ShadowCaster, casts);
    if casts && material.is_some_and(|material| game.surfaces.is_cut_out(material)) {
        cut_outs.insert(&object);
    }
    let turned = set(
        &mut target,
        ShadowReceiver,
        !object.contains::<NotShadowReceiver>(),
    );
    let mesh = ready.map(|ready| &*ready.data);
    let materials = game.surfaces.materials(surface, material, mesh).filter(|_| seen);
    let same = |known: &SceneMaterials, materials: &SceneMaterials| Arc::ptr_eq(&known.0[0], &materials.0[0]);
    match (target.get::<SceneMaterials>(), materials) {
        (Some(_), None) => {
            target.remove::<SceneMaterials>();
        }
        (Some(known), Some(materials)) if same(known, materials) => {}
        (_, Some(materials)) => {
            target.insert(materials.clone());
        }
        (None, None) => {}
    }
    if turned {
        mirror.receivers_changed.push(entity);
    }
}

/// Returns the surface of an object as a camera sees it.
fn surface_of(object: &EntityRef, transform: &GlobalTransform, level: Level, surfaces: &Surfaces) -> Surface {
    let surface = surfaces.get(standard_material(object));
    match (surface, level) {
        (Surface::NotDrawn, _) => surface,
        (_, Level::Fading { .. }) => Surface::SeenThrough, // a share of its pixels shows what is behind
        // Joints alone place a skinned mesh.
        _ if mirrors(transform) && !object.contains::<SkinnedMesh>() => surface.turned(),
        _ => surface,
    }
}

fn converted(aabb: &BevyAabb) -> Aabb {
    Aabb {
        min: Vec3::from(aabb.min()),
        max: Vec3::from(aabb.max()),
    }
}

/// Inserts, replaces or removes a component where that changes something.
fn set_part<C: Component + PartialEq>(target: &mut EntityWorldMut, wanted: Option<C>) {
    match wanted {
        wanted if target.get::<C>() == wanted.as_ref() => {}
        Some(wanted) => {
            target.insert(wanted);
        }
        None => {
            target.remove::<C>();
        }
    }
}

/// Inserts or removes a marker. Returns whether that changed anything.
fn set<C: Component>(target: &mut EntityWorldMut, marker: C, wanted: bool) -> bool {
    let changes = wanted != target.contains::<C>();
    if changes && wanted {
        target.insert(marker);
    } else if changes {
        target.remove::<C>();
    }
    changes
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

/// Gives an object bounds in place of a mesh that is not ready or was refused. With bounds the object is lit.
fn insert_bounds(mirror: &mut Mirror, mirrored: Entity, object: &EntityRef, transform: &GlobalTransform) {
    let bounds = object.get::<BevyAabb>().map_or(EVERYWHERE, converted);
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

/// Bounds of a mesh to which Bevy has given no bounds, and which Bevy does not cull either. They reach a
/// thousand kilometres: this is far beyond what is drawn, and its square is still exact enough.
const EVERYWHERE: Aabb = Aabb {
    min: Vec3::splat(-1e6),
    max: Vec3::splat(1e6),
};

/// Copies the skin and the morph weights of an object. Returns `false` while the inverse bind poses of its
/// skin are not loaded.
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
