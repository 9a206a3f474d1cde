//! Import of the node forest, its transforms, and the lights, cameras and skins of nodes.

use std::sync::Arc;

use bevy_transform::prelude::Transform;
use glam::{Mat4, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual::{Light as JsonLight, Type as LightType};
use gltf::json::scene::Node;
use gltf::json::validation::Checked;

use super::accessors::Accessors;
use super::cell_extras::GltfVisibility;
use super::extensions::NODE_VISIBILITY;
use super::instancing;
use super::mesh::GltfMesh;
use super::transforms::{NodeTransform, transform_of};
use super::{Element, GltfError, Report, SkipKind};
use crate::scene::{Camera, Light, LightKind, MeshData};

/// Deepest nesting of nodes. The limit exists because transform propagation and despawning recurse once a
/// level.
pub const MAX_NODE_DEPTH: usize = 512;

/// A node of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfNode {
    /// Name of the node, or "node 3" if it has none.
    pub name: String,
    /// Transform relative to the parent, or to `stretch` if there is one. It may be singular or not finite; the
    /// report then lists it, a singular one only if a mesh is lost by it.
    pub transform: Transform,
    /// Transform between the parent and `transform`, of a node whose matrix shears. No single translation, rotation
    /// and scale makes such a matrix; two of them one after the other do.
    pub stretch: Option<Transform>,
    /// Indices of the node's children.
    pub children: Vec<usize>,
    /// Index of the node's mesh in [`LoadedGltf::meshes`](super::LoadedGltf::meshes).
    pub mesh: Option<usize>,
    /// Index of the node's skin in [`LoadedGltf::skins`](super::LoadedGltf::skins). Present only if the node
    /// has a mesh with joints.
    pub skin: Option<usize>,
    /// Index of the node's light in [`LoadedGltf::lights`](super::LoadedGltf::lights).
    pub light: Option<usize>,
    /// Index of the node's camera in [`LoadedGltf::cameras`](super::LoadedGltf::cameras).
    pub camera: Option<usize>,
    /// Transforms relative to the node of the copies of its mesh (`EXT_mesh_gpu_instancing`). `None` if the mesh is
    /// drawn once, at the node itself.
    pub instances: Option<Vec<Transform>>,
    /// Whether the node and those below it are drawn and shine (`KHR_node_visibility`).
    pub visible: bool,
    /// Weights of the mesh's morph targets, one for each.
    pub weights: Vec<f32>,
    /// Cells, portals and occluders from the node's extras.
    pub visibility: GltfVisibility,
}

/// A skin: the joints that move the vertices of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct GltfSkin {
    /// Name of the skin, or "skin 0" if it has none.
    pub name: String,
    /// Joints of the skin, as indices into [`LoadedGltf::nodes`](super::LoadedGltf::nodes).
    pub joints: Vec<usize>,
    /// Inverse bind matrices, one for each joint: from the mesh's bind space to the joint's local space.
    pub inverse_bind: Arc<[Mat4]>,
}

/// All nodes of the file. They form a forest at most [`MAX_NODE_DEPTH`] deep, and all their indices exist.
pub(super) fn load(
    accessors: &Accessors<'_>,
    meshes: &[GltfMesh],
    skins: &[GltfSkin],
    report: &mut Report,
) -> Result<Vec<GltfNode>, GltfError> {
    let json = &accessors.root.nodes;
    let joint_counts: Vec<usize> = meshes.iter().map(|mesh| joint_count(&mesh.data)).collect();
    let mut nodes = Vec::with_capacity(json.len());
    for (index, node) in json.iter().enumerate() {
        let element = Element::Node(index);
        let NodeTransform {
            transform,
            stretch,
            problem,
        } = transform_of(node);
        if let Some(problem) = problem {
            report.add(SkipKind::NodeTransform, element, 1, problem);
        }
        let mut children = Vec::new();
        for &child in node.children.iter().flatten() {
            accessors.get(json, child, element, "node")?;
            children.push(child.value());
        }
        let mesh = match node.mesh {
            Some(mesh) => Some((mesh.value(), accessors.get(meshes, mesh, element, "mesh")?)),
            None => None,
        };
        let skin = match node.skin {
            Some(skin) => Some((skin.value(), accessors.get(skins, skin, element, "skin")?)),
            None => None,
        };
        if let Some(camera) = node.camera {
            accessors.get(&accessors.root.cameras, camera, element, "camera")?;
        }
        let light = node
            .extensions
            .as_ref()
            .and_then(|extensions| extensions.khr_lights_punctual.as_ref());
        if let Some(light) = light {
            accessors.get(json_lights(accessors), light.light, element, "light")?;
        }
        let joint_count = mesh.map_or(0, |(mesh, _)| joint_counts[mesh]);
        let skin = check_skin(accessors, element, joint_count, skin, report)?;
        let mesh_data = mesh.map(|(_, mesh)| &mesh.data);
        if let Some(data) = mesh_data.filter(|data| skin.is_some() || !data.morph_targets.is_empty()) {
            // Each such node is posed separately, so its vertices and weights count like those of the file.
            accessors.charge(element, data.positions.len(), size_of::<[Vec3; 3]>())?;
            accessors.charge(element, data.morph_targets.len(), size_of::<f32>())?;
        }
        nodes.push(GltfNode {
            name: node.name.clone().unwrap_or_else(|| element.to_string()),
            transform,
            stretch,
            children,
            weights: mesh.map_or_else(Vec::new, |(_, mesh)| node_weights(node, mesh, element, report)),
            mesh: mesh.map(|(index, _)| index),
            skin,
            light: light.map(|light| light.light.value()),
            instances: load_instances(accessors, element, node, skin, mesh_data, report)?,
            visible: is_visible(element, node, report),
            camera: node.camera.map(|camera| camera.value()),
            visibility: GltfVisibility::default(),
        });
    }
    check_forest(accessors, &nodes)?;
    Ok(nodes)
}

/// The instances of a node, as far as its mesh can be drawn by instances.
fn load_instances(
    accessors: &Accessors<'_>,
    element: Element,
    node: &Node,
    skin: Option<usize>,
    mesh: Option<&Arc<MeshData>>,
    report: &mut Report,
) -> Result<Option<Vec<Transform>>, GltfError> {
    let instances = instancing::load(accessors, element, node, report)?;
    let Some(count) = instances.as_ref().map(Vec::len) else {
        return Ok(None);
    };
    if skin.is_some() {
        let reason = "a skin moves its mesh, which is drawn once";
        report.add(SkipKind::Instance, element, count, reason);
        return Ok(None);
    }
    if let Some(data) = mesh.filter(|data| !data.morph_targets.is_empty()) {
        accessors.charge(
            element,
            data.positions.len().saturating_mul(count),
            size_of::<[Vec3; 3]>(),
        )?;
        let reason = "they have morph targets, which animation does not move";
        report.add(SkipKind::Instance, element, count, reason);
    }
    Ok(instances)
}

fn is_visible(element: Element, node: &Node, report: &mut Report) -> bool {
    let others = node.extensions.as_ref().map(|extensions| &extensions.others);
    let Some(object) = others.and_then(|others| others.get(NODE_VISIBILITY)) else {
        return true;
    };
    let visible = object.as_object().and_then(|object| match object.get("visible") {
        Some(visible) => visible.as_bool(),
        None => Some(true),
    });
    visible.unwrap_or_else(|| {
        let reason = format!("{NODE_VISIBILITY} is {object}, which hides nothing");
        report.add(SkipKind::Extension, element, 1, reason);
        true
    })
}

/// Number of joints that a mesh needs.
fn joint_count(data: &MeshData) -> usize {
    let largest = data.joints.iter().flatten().max();
    largest.map_or(0, |&joint| usize::from(joint) + 1)
}

/// Checks that the skin has every joint that a vertex of the mesh follows. A skin counts only if the mesh has
/// joints.
fn check_skin(
    accessors: &Accessors<'_>,
    element: Element,
    joint_count: usize,
    skin: Option<(usize, &GltfSkin)>,
    report: &mut Report,
) -> Result<Option<usize>, GltfError> {
    let Some((index, skin)) = skin else {
        return Ok(None);
    };
    let has = skin.joints.len();
    if joint_count == 0 {
        report.add(
            SkipKind::NodeMesh,
            element,
            1,
            format!("skin {index} has no mesh with joints to move"),
        );
        return Ok(None);
    }
    if joint_count > has {
        let reason = format!(
            "its mesh uses joint {}, skin {index} has {has} joints",
            joint_count - 1
        );
        return Err(accessors.invalid(element, reason));
    }
    accessors.charge(element, has, size_of::<usize>())?;
    Ok(Some(index))
}

fn node_weights(node: &Node, mesh: &GltfMesh, element: Element, report: &mut Report) -> Vec<f32> {
    let Some(weights) = &node.weights else {
        return mesh.weights.clone();
    };
    let mut weights = weights.clone();
    let target_count = mesh.data.morph_targets.len();
    if weights.len() != target_count {
        let reason = format!(
            "it has {} weights for {target_count} morph targets",
            weights.len()
        );
        report.add(SkipKind::NodeMesh, element, 1, reason);
        weights.resize(target_count, 0.0);
    }
    weights
}

/// Checks that no node has two parents, is its own ancestor, or is nested too deep.
fn check_forest(accessors: &Accessors<'_>, nodes: &[GltfNode]) -> Result<(), GltfError> {
    let mut parents: Vec<Option<usize>> = vec![None; nodes.len()];
    for (parent, node) in nodes.iter().enumerate() {
        for &child in &node.children {
            if let Some(first) = parents[child].replace(parent) {
                let reason = format!("it has two parents, node {first} and node {parent}");
                return Err(accessors.invalid(Element::Node(child), reason));
            }
        }
    }
    // As every node has at most one parent, only the nodes of a cycle cannot be reached from the roots.
    let mut reached = vec![false; nodes.len()];
    let mut level: Vec<usize> = (0..nodes.len()).filter(|&node| parents[node].is_none()).collect();
    for _ in 0..MAX_NODE_DEPTH {
        level.iter().for_each(|&node| reached[node] = true);
        level = level
            .iter()
            .flat_map(|&node| nodes[node].children.iter().copied())
            .collect();
    }
    if let Some(&node) = level.first() {
        let reason = format!("it is nested more than {MAX_NODE_DEPTH} nodes deep");
        return Err(accessors.invalid(Element::Node(node), reason));
    }
    match reached.iter().position(|&reached| !reached) {
        Some(node) => Err(accessors.invalid(Element::Node(node), "it is its own ancestor")),
        None => Ok(()),
    }
}

fn json_lights<'a>(accessors: &Accessors<'a>) -> &'a [JsonLight] {
    let extensions = accessors.root.extensions.as_ref();
    extensions
        .and_then(|extensions| extensions.khr_lights_punctual.as_ref())
        .map_or(&[], |extension| &extension.lights)
}

/// All lights of `KHR_lights_punctual`. Intensities are kept as they are, in candela or lux. An inner angle of a cone that
/// is larger than the outer one becomes the outer one.
pub(super) fn load_lights(accessors: &Accessors<'_>, report: &mut Report) -> Vec<Light> {
    let lights = json_lights(accessors).iter().enumerate().map(|(index, json)| {
        let spot = json.spot.as_ref();
        let kind = match json.type_ {
            Checked::Valid(LightType::Spot) => {
                let inner_angle = spot.map_or(0.0, |spot| spot.inner_cone_angle);
                let outer_angle = spot.map_or(std::f32::consts::FRAC_PI_4, |spot| spot.outer_cone_angle);
                if inner_angle > outer_angle {
                    let problem = format!(
                        "its inner angle, {inner_angle}, is larger than its outer one, {outer_angle}, so the cone has a \
                         sharp edge there"
                    );
                    report.add(SkipKind::LightValue, Element::Light(index), 1, problem);
                }
                LightKind::Spot {
                    inner_angle: inner_angle.min(outer_angle),
                    outer_angle,
                }
            }
            Checked::Valid(LightType::Directional) => LightKind::Directional,
            Checked::Valid(LightType::Point) | Checked::Invalid => LightKind::Point,
        };
        let mut light = Light {
            kind,
            color: Vec3::from(json.color),
            intensity: json.intensity,
            range: json.range.unwrap_or(f32::INFINITY),
        };
        let known = matches!(json.type_, Checked::Valid(_));
        let problem = if known {
            light.validate().err().map(|error| error.to_string())
        } else {
            Some("its type is unknown".to_owned())
        };
        if let Some(problem) = problem {
            report.add(SkipKind::Light, Element::Light(index), 1, problem);
        }
        if !known {
            light.intensity = 0.0;
        }
        light
    });
    lights.collect()
}

/// All cameras. `None` for those whose numbers make no projection.
pub(super) fn load_cameras(accessors: &Accessors<'_>, report: &mut Report) -> Vec<Option<Camera>> {
    let cameras = accessors.root.cameras.iter().enumerate().map(|(index, json)| {
        let perspective = json.perspective.as_ref().map(|perspective| Camera {
            vertical_fov: perspective.yfov,
            near: perspective.znear,
            aspect: perspective.aspect_ratio.unwrap_or(Camera::default().aspect),
            ..Camera::default()
        });
        let orthographic = json.orthographic.as_ref().map(|view| {
            let (right, up) = (view.xmag.abs(), view.ymag.abs()); // half of the picture's size each
            Camera::orthographic(2.0 * up, view.znear, view.zfar, right / up)
        });
        let usable = perspective.or(orthographic).filter(Camera::is_valid);
        if usable.is_none() {
            let reason = "its numbers make no projection";
            report.add(SkipKind::Camera, Element::Camera(index), 1, reason);
        }
        usable
    });
    cameras.collect()
}

/// All skins. A joint without an inverse bind matrix gets the identity.
pub(super) fn load_skins(accessors: &Accessors<'_>, report: &mut Report) -> Result<Vec<GltfSkin>, GltfError> {
    let mut skins = Vec::with_capacity(accessors.root.skins.len());
    for (index, skin) in accessors.root.skins.iter().enumerate() {
        let element = Element::Skin(index);
        let mut joints = Vec::with_capacity(skin.joints.len());
        for &joint in &skin.joints {
            accessors.get(&accessors.root.nodes, joint, element, "node")?;
            joints.push(joint.value());
        }
        let mut inverse_bind: Vec<Mat4> = match skin.inverse_bind_matrices {
            Some(accessor) => {
                let matrices = accessors.read_f32::<16>(accessor.value(), element)?;
                if matrices.len() < joints.len() {
                    let (count, joints) = (matrices.len(), joints.len());
                    let reason = format!(
                        "accessor {} has {count} matrices for {joints} joints",
                        accessor.value()
                    );
                    return Err(accessors.invalid(element, reason));
                }
                matrices.iter().map(Mat4::from_cols_array).collect()
            }
            None => vec![Mat4::IDENTITY; joints.len()],
        };
        inverse_bind.truncate(joints.len());
        let broken = inverse_bind.iter().filter(|matrix| !matrix.is_finite()).count();
        if broken > 0 {
            let reason = "an inverse bind matrix is not finite, the identity is used";
            report.add(SkipKind::NodeMesh, element, broken, reason);
            inverse_bind
                .iter_mut()
                .filter(|matrix| !matrix.is_finite())
                .for_each(|matrix| *matrix = Mat4::IDENTITY);
        }
        let name = skin.name.clone().unwrap_or_else(|| element.to_string());
        skins.push(GltfSkin {
            name,
            joints,
            inverse_bind: inverse_bind.into(),
        });
    }
    Ok(skins)
}
