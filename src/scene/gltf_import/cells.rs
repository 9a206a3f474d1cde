//! Cells, portals and occluders in the `extras` of nodes.
//!
//! ```json
//! {"extras": {"antumbra": {"cell": "kitchen", "half_size": [2.0, 1.3, 2.5]}}}
//! {"extras": {"antumbra": {"portal": {"joins": ["kitchen", "hall"], "open": true}, "half_size": [0.45, 1.0]}}}
//! {"extras": {"antumbra": {"in_cells": ["kitchen"]}}}
//! {"extras": {"antumbra": {"occluder": false}}}
//! ```
//!
//! A cell is a box around the node's origin, a portal a rectangle in the node's XY plane. Without `half_size`
//! the shape comes from the node's mesh: the bounds of the mesh for a cell, the convex hull of its vertices
//! for a portal. That mesh is then not drawn.
//!
//! If one of these cannot be read, or two cells share a name, all cells and portals of the file are dropped,
//! because a missing portal would hide objects that should be visible.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{DVec3, Vec3};
use gltf::json::{Value, deserialize::from_str};
use smallvec::SmallVec;

use super::accessors::Accessors;
use super::cell_extras::GltfVisibility;
use super::nodes::GltfNode;
use super::{Element, LoadedGltf, Report, SkipKind};
use crate::geometry::Aabb;
use crate::geometry::convex_polygon::CommonPlane;
use crate::scene::{Cell, InCells, MeshData, Occluder, Portal};

/// Reads the extras of all nodes.
pub(super) fn load(accessors: &Accessors<'_>, nodes: &mut [GltfNode], report: &mut Report) {
    let mut sound = true;
    for (index, (json, node)) in accessors.root.nodes.iter().zip(nodes.iter_mut()).enumerate() {
        let Some(extras) = &json.extras else { continue };
        // Extras of other tools may hold anything.
        let Ok(value) = from_str::<Value>(extras.get()) else {
            continue;
        };
        match GltfVisibility::read(&value).and_then(|read| check_shape(read, node.mesh.is_some())) {
            Ok(visibility) => node.visibility = visibility,
            Err(reason) => {
                sound = false;
                report.add(SkipKind::Visibility, Element::Node(index), 1, reason);
            }
        }
    }
    let mut names: HashMap<&str, usize> = HashMap::new();
    for (index, node) in nodes.iter().enumerate() {
        let Some(cell) = &node.visibility.cell else {
            continue;
        };
        if let Some(first) = names.insert(cell, index) {
            sound = false;
            let reason = format!("cell {cell:?} is node {first} too");
            report.add(SkipKind::Visibility, Element::Node(index), 1, reason);
        }
    }
    if !sound {
        for node in nodes {
            node.visibility = GltfVisibility {
                occluder: node.visibility.occluder,
                ..GltfVisibility::default()
            };
        }
    }
}

fn check_shape(visibility: GltfVisibility, has_mesh: bool) -> Result<GltfVisibility, String> {
    if visibility.takes_mesh() && !has_mesh {
        return Err("it has neither half_size nor a mesh".to_owned());
    }
    Ok(visibility)
}

/// Gives the entities of a scene their cells, portals, cell lists and occluders. `entities` are those of the nodes, and
/// `drawn` are the entities with a mesh, each with the index of its node.
pub(super) fn spawn(
    world: &mut World,
    gltf: &LoadedGltf,
    entities: &[Option<Entity>],
    drawn: &[(usize, Entity)],
) {
    let mut cells: HashMap<&str, Entity> = HashMap::new();
    for (node, entity) in gltf.nodes.iter().zip(entities) {
        let (Some(cell), Some(entity)) = (&node.visibility.cell, entity) else {
            continue;
        };
        let half = |half_size| (Vec3::ZERO, half_size);
        let (center, half_size) = node.visibility.half_size.map_or_else(|| bounds(gltf, node), half);
        let place = Transform::from_translation(center);
        cells.insert(
            cell,
            world.spawn((Cell { half_size }, place, ChildOf(*entity))).id(),
        );
    }
    // A name that is not found becomes a placeholder that is no cell: a viewer who looks there sees all.
    let find = |name: &String| cells.get(name.as_str()).copied().unwrap_or(Entity::PLACEHOLDER);
    for (index, node) in gltf.nodes.iter().enumerate() {
        if let (Some(portal), Some(entity)) = (&node.visibility.portal, entities[index]) {
            let joins = [find(&portal.joins[0]), find(&portal.joins[1])];
            let mut component = match node.visibility.half_size {
                Some(half) => Portal::rectangle(joins, half.x, half.y),
                None => Portal {
                    joins,
                    open: true,
                    outline: outline(gltf, node),
                },
            };
            component.open = portal.open;
            world.entity_mut(entity).insert(component);
        }
    }
    for &(index, mesh) in drawn {
        let node = &gltf.nodes[index];
        if let Some(list) = &node.visibility.in_cells {
            world
                .entity_mut(mesh)
                .insert(InCells(list.iter().map(find).collect()));
        }
        match node.visibility.occluder {
            Some(true) => world.entity_mut(mesh).insert(Occluder::Own),
            Some(false) => world.entity_mut(mesh).insert(Occluder::Never),
            None => continue,
        };
    }
}

fn mesh_of<'a>(gltf: &'a LoadedGltf, node: &GltfNode) -> Option<&'a Arc<MeshData>> {
    Some(&gltf.meshes.get(node.mesh?)?.data)
}

/// Centre and half size of a node's mesh.
fn bounds(gltf: &LoadedGltf, node: &GltfNode) -> (Vec3, Vec3) {
    let aabb = mesh_of(gltf, node).map_or(Aabb::EMPTY, |mesh| {
        Aabb::from_points(mesh.positions.iter().copied())
    });
    if aabb.is_empty() {
        return (Vec3::ZERO, Vec3::ZERO);
    }
    (aabb.center(), aabb.half_size())
}

/// The corners of the convex hull of a node's mesh. If the mesh is not flat, they are its vertices, each once.
fn outline(gltf: &LoadedGltf, node: &GltfNode) -> SmallVec<[Vec3; 4]> {
    let positions = mesh_of(gltf, node).map_or(&[][..], |mesh| &mesh.positions);
    let points: Vec<DVec3> = positions.iter().map(|position| position.as_dvec3()).collect();
    match CommonPlane::of(&points).filter(|plane| plane.holds(&points)) {
        Some(plane) => plane.hull(&points).iter().map(|&at| positions[at]).collect(),
        None => {
            let mut known = HashSet::new();
            // 0 and −0 are one place.
            let bits = |position: &Vec3| (*position + Vec3::ZERO).to_array().map(f32::to_bits);
            let each_once = positions.iter().filter(|position| known.insert(bits(position)));
            each_once.copied().collect()
        }
    }
}
