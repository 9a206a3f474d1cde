//! Spawning of entities from a loaded file.

use std::sync::Arc;

use bevy_ecs::name::Name;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::nodes::GltfNode;
use super::{Element, GltfError, LoadedGltf};
use super::{cells, layers, reports, skin_winding};
use crate::scene::animation::{AnimationClips, SceneNodes};
use crate::scene::{
    IgnoresScale, MorphWeights, SceneMaterials, SceneMesh, ShadowCaster, ShadowReceiver, Skin,
};

/// The entities of a spawned scene.
#[derive(Clone, Debug)]
pub struct SpawnedScene {
    /// Parent of all other entities. It has [`AnimationClips`], [`SceneNodes`], and an identity transform
    /// with which to place the scene.
    pub root: Entity,
    /// Entities by glTF node index.
    pub nodes: SceneNodes,
    /// Entities with a [`Camera`](crate::scene::Camera), in the order of their nodes.
    pub cameras: Vec<Entity>,
    /// Entities with a [`Light`](crate::scene::Light), in the order of their nodes.
    pub lights: Vec<Entity>,
    /// Entities with a [`SceneMesh`], in the order of their nodes; the instances of a node in their own order.
    pub meshes: Vec<Entity>,
}

impl AsRef<SceneNodes> for SpawnedScene {
    fn as_ref(&self) -> &SceneNodes {
        &self.nodes
    }
}

/// Spawns a scene of the file; `None` spawns the default scene.
///
/// Each node becomes an entity with `Transform`, `Name`, `ChildOf`, and the mesh, light and camera of the
/// node. A node whose matrix shears gets a second entity between it and its parent, which carries the outer
/// part of the matrix. A skinned mesh becomes a separate entity, a child of the root, because glTF ignores
/// the transform of its node. If its joints mirror the mesh, that entity's transform mirrors too, so that fronts
/// stay fronts. Instances of a mesh become separate entities too, children of their node's. A hidden
/// node, and those below it, get no mesh and no light.
///
/// What was left out of the file goes into the [`Reports`](crate::reports::Reports) of the topic `import`, as long as
/// the scene's root lives.
///
/// # Errors
/// A scene that does not exist, or a skin whose joints are not all in the scene; nothing is spawned then. Or a name for
/// which no selection layer is left; the scene is then spawned without the rest of its layers.
pub fn spawn_scene(
    world: &mut World,
    gltf: &LoadedGltf,
    scene_index: Option<usize>,
) -> Result<SpawnedScene, GltfError> {
    let scene_index = scene_index.unwrap_or(gltf.default_scene);
    let scene = gltf.scenes.get(scene_index).ok_or_else(|| GltfError::Reference {
        file: gltf.file.clone(),
        element: Element::File,
        target: "scene",
        index: scene_index,
        count: gltf.scenes.len(),
    })?;
    let parents = parents_in_scene(&gltf.nodes, &scene.roots);
    check_joints(gltf, scene_index, &parents)?;

    let clips = AnimationClips(Arc::clone(&gltf.clips));
    let root = world
        .spawn((Name::new(scene.name.clone()), Transform::IDENTITY, clips))
        .id();
    let mut spawned = SpawnedScene {
        root,
        nodes: SceneNodes {
            nodes: vec![None; gltf.nodes.len()],
            meshes: vec![None; gltf.nodes.len()],
        },
        cameras: Vec::new(),
        lights: Vec::new(),
        meshes: Vec::new(),
    };
    let mut drawn = Vec::new();
    let hidden = hidden_nodes(&gltf.nodes, &scene.roots);
    let in_scene = || (0..gltf.nodes.len()).filter(|&node| parents[node] != Parent::NotInScene);
    for index in in_scene() {
        let node = &gltf.nodes[index];
        spawned.nodes.nodes[index] = Some(world.spawn((Name::new(node.name.clone()), node.transform)).id());
    }
    for index in in_scene() {
        let Some(entity) = spawned.nodes.nodes[index] else {
            continue;
        };
        let parent = match parents[index] {
            Parent::Node(parent) => spawned.nodes.nodes[parent].unwrap_or(root),
            Parent::Scene | Parent::NotInScene => root,
        };
        let parent = match gltf.nodes[index].stretch {
            Some(stretch) => {
                let name = Name::new(format!("{} (sheared)", gltf.nodes[index].name));
                world.spawn((name, stretch, ChildOf(parent))).id()
            }
            None => parent,
        };
        world.entity_mut(entity).insert(ChildOf(parent));
        let before = spawned.meshes.len();
        spawn_node(world, gltf, index, entity, hidden[index], &parents, &mut spawned);
        drawn.extend(spawned.meshes[before..].iter().map(|&mesh| (index, mesh)));
    }
    cells::spawn(world, gltf, &spawned.nodes.nodes, &drawn);
    layers::spawn(world, gltf, |node| parents[node].node(), &drawn)?;
    world.entity_mut(root).insert(spawned.nodes.clone());
    reports::keep(world, gltf, root);
    Ok(spawned)
}

fn spawn_node(
    world: &mut World,
    gltf: &LoadedGltf,
    index: usize,
    entity: Entity,
    is_hidden: bool,
    parents: &[Parent],
    spawned: &mut SpawnedScene,
) {
    let node = &gltf.nodes[index];
    if let Some(light) = node
        .light
        .and_then(|light| gltf.lights.get(light))
        .filter(|_| !is_hidden)
    {
        world.entity_mut(entity).insert(light.clone());
        spawned.lights.push(entity);
    }
    if let Some(camera) = node
        .camera
        .and_then(|camera| gltf.cameras.get(camera).copied().flatten())
    {
        world.entity_mut(entity).insert((camera, IgnoresScale));
        spawned.cameras.push(entity);
    }
    if node.visibility.takes_mesh() || is_hidden {
        return; // a mesh that only gives the shape of a cell or portal is not drawn either
    }
    let Some(mesh) = node.mesh.and_then(|mesh| gltf.meshes.get(mesh)) else {
        return;
    };
    let drawn = (
        SceneMesh(Arc::clone(&mesh.data)),
        SceneMaterials(mesh.materials.clone()),
        ShadowCaster,
        ShadowReceiver,
    );
    if let Some(instances) = &node.instances {
        for (instance, transform) in instances.iter().enumerate() {
            let name = Name::new(format!("{} (instance {instance})", node.name));
            let mut copy = world.spawn((name, *transform, ChildOf(entity), drawn.clone()));
            if !node.weights.is_empty() {
                copy.insert(MorphWeights(node.weights.clone()));
            }
            spawned.meshes.push(copy.id());
        }
        return;
    }
    let mesh_entity = match node.skin.and_then(|skin| gltf.skins.get(skin)) {
        Some(skin) => {
            let mirrors = skin_winding::mirrors(gltf, skin, &mesh.data, |node| parents[node].node());
            // The pose takes this transform out again; only the winding of fronts follows it.
            let transform = Transform::from_scale(Vec3::new(if mirrors { -1.0 } else { 1.0 }, 1.0, 1.0));
            let joints = skin
                .joints
                .iter()
                .filter_map(|&joint| spawned.nodes.nodes[joint])
                .collect();
            let skin = Skin {
                joints,
                inverse_bind: Arc::clone(&skin.inverse_bind),
            };
            let name = Name::new(format!("{} (skinned)", node.name));
            world
                .spawn((name, transform, ChildOf(spawned.root), skin, drawn))
                .id()
        }
        None => world.entity_mut(entity).insert(drawn).id(),
    };
    if !node.weights.is_empty() {
        world
            .entity_mut(mesh_entity)
            .insert(MorphWeights(node.weights.clone()));
    }
    spawned.nodes.meshes[index] = Some(mesh_entity);
    spawned.meshes.push(mesh_entity);
}

/// The nodes that are hidden, by themselves or by one above them.
fn hidden_nodes(nodes: &[GltfNode], roots: &[usize]) -> Vec<bool> {
    let mut hidden: Vec<bool> = nodes.iter().map(|node| !node.visible).collect();
    let mut open = roots.to_vec();
    while let Some(node) = open.pop() {
        for &child in &nodes[node].children {
            hidden[child] |= hidden[node];
            open.push(child);
        }
    }
    hidden
}

#[derive(Clone, Copy, PartialEq)]
enum Parent {
    NotInScene,
    Scene,
    Node(usize),
}

impl Parent {
    fn node(self) -> Option<usize> {
        match self {
            Self::Node(node) => Some(node),
            Self::Scene | Self::NotInScene => None,
        }
    }
}

fn parents_in_scene(nodes: &[GltfNode], roots: &[usize]) -> Vec<Parent> {
    let mut parents = vec![Parent::NotInScene; nodes.len()];
    let mut open: Vec<usize> = Vec::new();
    for &root in roots {
        parents[root] = Parent::Scene;
        open.push(root);
    }
    while let Some(node) = open.pop() {
        for &child in &nodes[node].children {
            parents[child] = Parent::Node(node);
            open.push(child);
        }
    }
    parents
}

fn check_joints(gltf: &LoadedGltf, scene_index: usize, parents: &[Parent]) -> Result<(), GltfError> {
    for (index, node) in gltf.nodes.iter().enumerate() {
        let Some(skin_index) = node.skin.filter(|_| parents[index] != Parent::NotInScene) else {
            continue;
        };
        let joints = gltf.skins.get(skin_index).map_or(&[][..], |skin| &skin.joints);
        if let Some(joint) = joints.iter().find(|&&joint| parents[joint] == Parent::NotInScene) {
            return Err(GltfError::Invalid {
                file: gltf.file.clone(),
                element: Element::Skin(skin_index),
                reason: format!(
                    "its joint, node {joint}, is not in scene {scene_index}, but node {index} is"
                ),
            });
        }
    }
    Ok(())
}
