//! Boxes around the visible receivers of a light. A large receiver has one for each of its parts.
//!
//! A town that is one mesh, or a room around the viewer, has bounds that say nothing of where its surfaces are: the near
//! plane would be the view's, and most of what the light's camera must show would be air.

use std::sync::{Arc, Weak};

use bevy_ecs::prelude::*;
use glam::Vec3;

use crate::geometry::Aabb;
use crate::scene::placement::Placement;
use crate::scene::{MeshData, PosedMesh, SceneMesh};
use crate::sets::{FrameLight, Objects, VisibleParts};

/// Largest number of parts of a mesh.
const MOST_PARTS: usize = 64;

/// Number of triangles up to which a mesh is not divided.
const FEW_TRIANGLES: usize = 16;

/// Largest number of receivers whose parts are taken for one light.
const MOST_DIVIDED: usize = 16;

/// Number of receivers from which on none is divided, and neighbours are joined.
const MANY_RECEIVERS: usize = 256;

/// Number of boxes up to which neighbours stay apart.
const MOST_JOINED: usize = 128;

/// The parts of the meshes that were divided so far.
#[derive(Clone, Debug, Default)]
pub struct MeshParts {
    /// Sorted by the address of the mesh, which a weak reference keeps from being used again.
    known: Vec<(Weak<MeshData>, Vec<Aabb>)>,
    /// Memory for boxes with their cells.
    celled: Vec<(Cell, Aabb)>,
}

/// A cell of a grid around the eye: the level, and the place in the grid of that level.
type Cell = [i32; 4];

/// Returns the cell of a box. Cells double with the distance from the eye and with the size of the box; each is
/// `2^-finer` times the greater of the two.
fn cell(eye: Vec3, aabb: &Aabb, finer: i32) -> Cell {
    let half = aabb.half_size();
    let offset = aabb.center() - eye;
    let distance = (offset.abs() - half).max(Vec3::ZERO).length();
    let level = distance.max(half.length()).max(1e-3).log2().floor() as i32 - finer;
    let [x, y, z] = (offset / (level as f32).exp2()).floor().as_ivec3().to_array();
    [level, x, y, z]
}

/// Joins the boxes of each cell. The joined boxes are small as seen from the eye, and about as far away as what they hold:
/// the near plane follows from them. `celled` is working memory.
fn join(eye: Vec3, boxes: &mut Vec<Aabb>, celled: &mut Vec<(Cell, Aabb)>) {
    for finer in [1, 0, -1] {
        celled.clear();
        celled.extend(boxes.iter().map(|aabb| (cell(eye, aabb, finer), *aabb)));
        celled.sort_unstable_by_key(|(cell, _)| *cell);
        boxes.clear();
        for of_cell in celled.chunk_by(|(a, _), (b, _)| a == b) {
            let joined = of_cell
                .iter()
                .fold(Aabb::EMPTY, |joined, (_, aabb)| joined.union(*aabb));
            boxes.push(joined);
        }
        if boxes.len() <= MOST_JOINED {
            return;
        }
    }
}

impl MeshParts {
    /// Returns the boxes around the parts of a mesh, in local space. They are found once for each mesh, in
    /// O(n log n) for n triangles.
    fn of(&mut self, mesh: &Arc<MeshData>) -> &[Aabb] {
        let address = Arc::as_ptr(mesh).addr();
        let at = self
            .known
            .partition_point(|(known, _)| known.as_ptr().addr() < address);
        let is_known = self
            .known
            .get(at)
            .is_some_and(|(known, _)| known.as_ptr().addr() == address);
        if is_known {
            return &self.known[at].1;
        }
        self.known.retain(|(known, _)| known.strong_count() > 0);
        let at = self
            .known
            .partition_point(|(known, _)| known.as_ptr().addr() < address);
        self.known.insert(at, (Arc::downgrade(mesh), divide(mesh)));
        &self.known[at].1
    }
}

/// Divides the triangles of a mesh at their medians, again and again, and returns the boxes around what results.
fn divide(mesh: &MeshData) -> Vec<Aabb> {
    let corner = |index: &u32| mesh.positions.get(*index as usize).copied().unwrap_or_default();
    let corners = |triangle: &[u32]| [corner(&triangle[0]), corner(&triangle[1]), corner(&triangle[2])];
    let mut boxes: Vec<Aabb> = mesh
        .indices
        .chunks_exact(3)
        .map(|triangle| Aabb::from_points(corners(triangle)))
        .filter(|aabb| !aabb.is_empty())
        .collect();
    let mut parts = Vec::new();
    divide_boxes(&mut boxes, MOST_PARTS, &mut parts);
    parts
}

fn divide_boxes(boxes: &mut [Aabb], most: usize, parts: &mut Vec<Aabb>) {
    let whole = boxes.iter().fold(Aabb::EMPTY, |whole, part| whole.union(*part));
    if most < 2 || boxes.len() <= FEW_TRIANGLES {
        if !whole.is_empty() {
            parts.push(whole);
        }
        return;
    }
    let size = (whole.max - whole.min).to_array();
    let axis = (0..3).max_by(|&a, &b| size[a].total_cmp(&size[b])).unwrap_or(0);
    let middle = boxes.len() / 2;
    boxes.select_nth_unstable_by(middle, |a, b| a.center()[axis].total_cmp(&b.center()[axis]));
    let (low, high) = boxes.split_at_mut(middle);
    divide_boxes(low, most / 2, parts);
    divide_boxes(high, most / 2, parts);
}

/// The components from which a receiver's boxes are computed.
pub type Receiver = (&'static SceneMesh, Placement, Has<PosedMesh>);

/// Collects boxes, in world space, that hold every visible point of a light's receivers. Many receivers are joined with
/// their neighbours.
pub fn collect_boxes(
    light: &FrameLight,
    objects: &Objects,
    visible: &VisibleParts,
    eye: Vec3,
    meshes: &Query<Receiver>,
    known: &mut MeshParts,
    boxes: &mut Vec<Aabb>,
) {
    boxes.clear();
    let shows = |&object: &usize| objects.layers[object] & light.selection.shows_on != 0;
    let receivers = || light.sets.i.intersection(&objects.receivers).filter(shows);
    let reach = light.lit.aabb();
    if receivers().take(MANY_RECEIVERS).count() == MANY_RECEIVERS {
        let lit = receivers().map(|object| visible.get(objects, object).intersection(reach));
        boxes.extend(lit.filter(|lit| !lit.is_empty()));
        join(eye, boxes, &mut known.celled);
        return;
    }
    let mut divided = 0;
    for object in receivers() {
        let lit = visible.get(objects, object).intersection(reach);
        if lit.is_empty() {
            continue;
        }
        let half = lit.half_size();
        let distance = ((eye - lit.center()).abs() - half).max(Vec3::ZERO).length();
        let is_large = divided < MOST_DIVIDED && distance < half.length() && half.min_element() > 0.0;
        let parts = meshes.get(objects.entities[object]).ok().filter(|_| is_large);
        let parts = parts.and_then(|(mesh, placement, posed)| {
            let affine = placement.affine().filter(|_| !posed)?;
            Some((known.of(&mesh.0), affine))
        });
        match parts {
            Some((parts, affine)) if parts.len() > 1 => {
                divided += 1;
                let placed = parts
                    .iter()
                    .map(|part| part.transformed(&affine).padded().intersection(lit));
                boxes.extend(placed.filter(|part| !part.is_empty()));
            }
            _ => boxes.push(lit),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_hold_every_triangle_and_are_small() {
        let mut mesh = MeshData::default();
        for x in 0..30u32 {
            for z in 0..30u32 {
                let at = Vec3::new(x as f32, ((x * 7 + z * 3) % 5) as f32 * 0.1, z as f32);
                let first = mesh.positions.len() as u32;
                mesh.positions.extend([at, at + Vec3::X, at + Vec3::Z]);
                mesh.indices.extend([first, first + 1, first + 2]);
            }
        }
        let parts = divide(&mesh);
        assert_eq!(parts.len(), 64);
        for triangle in mesh.positions.chunks_exact(3) {
            let aabb = Aabb::from_points(triangle.iter().copied());
            assert!(parts.iter().any(|part| part.union(aabb) == *part), "{aabb:?}");
        }
        let area = |aabb: &Aabb| (aabb.max.x - aabb.min.x) * (aabb.max.z - aabb.min.z);
        let sum: f32 = parts.iter().map(area).sum();
        assert!(sum < 2.0 * 900.0, "{sum}");
    }

    #[test]
    fn joined_boxes_are_few_and_as_far_from_the_eye_as_what_they_hold() {
        let eye = Vec3::new(100.0, 1.7, -50.0);
        let distance = |aabb: &Aabb| aabb.distance_sq(eye).sqrt();
        for spacing in [0.7, 4.0, 31.0] {
            let mut all = Vec::new();
            for x in -30..30 {
                for z in -30..30 {
                    let at = eye + Vec3::new(x as f32, 0.0, z as f32) * spacing;
                    let height = ((x * 7 + z * 3) % 5) as f32 * 0.3;
                    all.push(Aabb::around(
                        at - Vec3::Y * (1.9 + height),
                        Vec3::splat(0.1 * spacing),
                    ));
                }
            }
            let mut boxes = all.clone();
            join(eye, &mut boxes, &mut Vec::new());
            assert!(boxes.len() < all.len() / 8, "{spacing}: {}", boxes.len());
            let holds = |joined: &Aabb, aabb: &Aabb| joined.union(*aabb) == *joined;
            for aabb in &all {
                assert!(
                    boxes.iter().any(|joined| holds(joined, aabb)),
                    "{spacing}: {aabb:?}"
                );
            }
            for joined in &boxes {
                let held = all.iter().filter(|aabb| holds(joined, aabb));
                let nearest = held.map(distance).fold(f32::INFINITY, f32::min);
                assert!(
                    distance(joined) >= 0.3 * nearest,
                    "{spacing}: {joined:?}, {nearest}"
                );
            }
        }
    }

    #[test]
    fn a_mesh_is_divided_once_and_forgotten_with_its_last_owner() {
        let mut parts = MeshParts::default();
        let mesh = |half: f32| Arc::new(MeshData::cuboid(Vec3::splat(half)));
        let (a, b) = (mesh(1.0), mesh(2.0));
        assert_eq!(parts.of(&a).len(), 1);
        assert_eq!(parts.of(&b)[0].max, Vec3::splat(2.0));
        assert_eq!(parts.of(&a)[0].max, Vec3::splat(1.0));
        assert_eq!(parts.known.len(), 2);
        drop(a);
        let c = mesh(3.0);
        assert_eq!(parts.of(&c)[0].max, Vec3::splat(3.0));
        assert_eq!(parts.known.len(), 2);
    }
}
