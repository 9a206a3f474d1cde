//! The scenes of a file: which nodes are at the top of each.

use super::accessors::Accessors;
use super::nodes::GltfNode;
use super::{Element, GltfError, Report, SkipKind};

/// A scene of the file, which can be spawned.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GltfSceneRoots {
    /// Name of the scene, or "scene 0" if it has none.
    pub name: String,
    /// Indices of the nodes at the top of the scene. A parent of such a node is in no case part of the scene.
    pub roots: Vec<usize>,
}

/// All scenes, and the index of the default one. A file without scenes gets one that holds every node without
/// a parent.
///
/// Exporters list nodes that have a parent. If the parent is in the scene as well, such a node stays below it. If not,
/// the node is placed as if it had none, which is what three.js, Babylon.js and Bevy do.
pub(super) fn load(
    accessors: &Accessors<'_>,
    nodes: &[GltfNode],
    report: &mut Report,
) -> Result<(Vec<GltfSceneRoots>, usize), GltfError> {
    let root = accessors.root;
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        node.children
            .iter()
            .for_each(|&child| parents[child] = Some(parent));
    }
    let mut listed_by: Vec<Option<usize>> = vec![None; nodes.len()];
    let mut scenes = Vec::with_capacity(root.scenes.len());
    for (index, scene) in root.scenes.iter().enumerate() {
        let element = Element::Scene(index);
        for &node in &scene.nodes {
            accessors.get(nodes, node, element, "node")?;
        }
        let mut listed = Vec::with_capacity(scene.nodes.len());
        for node in scene.nodes.iter().map(|node| node.value()) {
            if listed_by[node].replace(index) == Some(index) {
                let reason = format!("it lists node {node} twice, once is enough");
                report.add(SkipKind::SceneRoot, element, 1, reason);
            } else {
                listed.push(node);
            }
        }
        let mut roots = Vec::with_capacity(listed.len());
        for node in listed {
            let mut above = std::iter::successors(parents[node], |&parent| parents[parent]);
            let in_scene = above.find(|&ancestor| listed_by[ancestor] == Some(index));
            match (in_scene, parents[node]) {
                (Some(ancestor), _) => {
                    let reason =
                        format!("it lists node {node}, which is below node {ancestor} and stays there");
                    report.add(SkipKind::SceneRoot, element, 1, reason);
                }
                (None, Some(parent)) => {
                    let reason = format!(
                        "it lists node {node}, whose parent, node {parent}, is not in the scene and does not move it"
                    );
                    report.add(SkipKind::SceneRoot, element, 1, reason);
                    roots.push(node);
                }
                (None, None) => roots.push(node),
            }
        }
        let name = scene.name.clone().unwrap_or_else(|| element.to_string());
        scenes.push(GltfSceneRoots { name, roots });
    }
    let default_scene = match root.scene {
        Some(scene) => {
            accessors.get(&root.scenes, scene, Element::File, "scene")?;
            scene.value()
        }
        None => 0,
    };
    if scenes.is_empty() {
        let roots = (0..nodes.len()).filter(|&node| parents[node].is_none()).collect();
        scenes.push(GltfSceneRoots {
            name: Element::Scene(0).to_string(),
            roots,
        });
    }
    Ok((scenes, default_scene))
}
