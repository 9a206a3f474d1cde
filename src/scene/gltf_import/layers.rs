//! Selection layers of the nodes of a spawned scene.

use bevy_ecs::prelude::*;

use super::spawn::{Parent, SpawnedScene};
use super::{Element, GltfError, LoadedGltf};
use crate::scene::{LayerNames, SelectionLayers};

/// Puts the meshes of the scene's nodes on the layers that the extras of the nodes and of their ancestors name.
///
/// # Errors
/// A name for which no layer is left.
pub(super) fn spawn(
    world: &mut World,
    gltf: &LoadedGltf,
    parents: &[Parent],
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
            at = match parents[node] {
                Parent::Node(parent) => Some(parent),
                Parent::Scene | Parent::NotInScene => None,
            };
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
/// Returns `None` if neither a node nor a layer has the name, or if no layer is left.
pub fn layer_of_name(
    world: &mut World,
    gltf: &LoadedGltf,
    spawned: &SpawnedScene,
    name: &str,
) -> Option<u32> {
    let named = |index: &usize| gltf.nodes[*index].name == name && spawned.nodes.nodes[*index].is_some();
    let mut open: Vec<usize> = (0..gltf.nodes.len()).filter(named).collect();
    let mut names = world.get_resource_or_init::<LayerNames>();
    let bit = match names.bit(name) {
        Some(bit) => bit,
        None if open.is_empty() => return None,
        None => names.add(name).ok()?,
    };
    while let Some(node) = open.pop() {
        open.extend(&gltf.nodes[node].children);
        let (entity, of_node) = (spawned.nodes.nodes[node], spawned.nodes.meshes[node]);
        for &mesh in &spawned.meshes {
            // Instances of the node's mesh are children of its entity.
            let parent = world.get::<ChildOf>(mesh).map(ChildOf::parent);
            if Some(mesh) == of_node || (entity.is_some() && parent == entity) {
                put_on(world, mesh, bit);
            }
        }
    }
    Some(bit)
}

fn put_on(world: &mut World, mesh: Entity, bits: u32) {
    let layers = world.get::<SelectionLayers>(mesh).copied().unwrap_or_default();
    world.entity_mut(mesh).insert(SelectionLayers(layers.0 | bits));
}
