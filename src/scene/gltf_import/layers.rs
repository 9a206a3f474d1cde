//! Selection layers of the nodes of a spawned scene.

use bevy_ecs::prelude::*;

use super::{Element, GltfError, LoadedGltf};
use crate::scene::{LayerNames, SceneMesh, SceneNodes, SelectionLayers, TooManyLayers};

/// Puts the meshes of the scene's nodes on the layers that the extras of the nodes and of their ancestors name.
/// `parent` gives the parent of a node in the scene, and `drawn` the meshes with their nodes.
///
/// # Errors
/// A name for which no layer is left.
pub(super) fn spawn(
    world: &mut World,
    gltf: &LoadedGltf,
    parent: impl Fn(usize) -> Option<usize>,
    drawn: &[(usize, Entity)],
) -> Result<(), GltfError> {
    if gltf.nodes.iter().all(|node| node.visibility.layers.is_none()) {
        return Ok(());
    }
    for &(index, mesh) in drawn {
        let mut bits = 0;
        let mut at = Some(index);
        while let Some(node) = at {
            for name in gltf.nodes[node].visibility.layers.iter().flatten() {
                let mut names = world.get_resource_or_init::<LayerNames>();
                bits |= names.add(name).map_err(|error| GltfError::Invalid {
                    file: gltf.file.clone(),
                    element: Element::Node(node),
                    reason: error.to_string(),
                })?;
            }
            at = parent(node);
        }
        if bits != 0 {
            put_on(world, mesh, bits);
        }
    }
    Ok(())
}

/// Puts the meshes of all nodes with this name, and of their descendants, on a layer that has the same name. Returns
/// the layer's bit for the masks of a [`LightSelection`](crate::scene::LightSelection). A name that the extras of
/// some node gave to a layer, or to which no node answers, puts nothing on the layer.
///
/// Returns `None` if neither a node nor a layer has the name.
///
/// # Errors
/// A node has the name, but no layer is left for it.
pub fn layer_of_name(
    world: &mut World,
    gltf: &LoadedGltf,
    nodes: &SceneNodes,
    name: &str,
) -> Result<Option<u32>, TooManyLayers> {
    let meshes = meshes_of_name(world, gltf, nodes, name);
    let mut names = world.get_resource_or_init::<LayerNames>();
    let bit = match names.bit(name) {
        Some(bit) => bit,
        None if meshes.is_none() => return Ok(None),
        None => names.add(name)?,
    };
    for mesh in meshes.into_iter().flatten() {
        put_on(world, mesh, bit);
    }
    Ok(Some(bit))
}

/// Returns the meshes of all nodes with this name, and of their descendants. `None` if no node has the name.
pub fn meshes_of_name(
    world: &World,
    gltf: &LoadedGltf,
    nodes: &SceneNodes,
    name: &str,
) -> Option<Vec<Entity>> {
    let named = |index: &usize| gltf.nodes[*index].name == name && nodes.nodes[*index].is_some();
    let mut open: Vec<usize> = (0..gltf.nodes.len()).filter(named).collect();
    let is_known = !open.is_empty();
    let mut found = Vec::new();
    while let Some(node) = open.pop() {
        open.extend(&gltf.nodes[node].children);
        // Instances of the node's mesh are children of its entity.
        let below = nodes.nodes[node].and_then(|entity| world.get::<Children>(entity));
        let meshes = below.into_iter().flat_map(|below| below.iter());
        let meshes = meshes.chain(nodes.meshes[node]);
        found.extend(meshes.filter(|mesh| world.get::<SceneMesh>(*mesh).is_some()));
    }
    is_known.then_some(found)
}

fn put_on(world: &mut World, mesh: Entity, bits: u32) {
    let layers = world.get::<SelectionLayers>(mesh).copied().unwrap_or_default();
    world.entity_mut(mesh).insert(SelectionLayers(layers.0 | bits));
}
