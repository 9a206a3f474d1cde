//! Conversion of other primitive modes to triangle lists, and flat normals.

use glam::{Vec3, Vec4};
use gltf::json::mesh::Mode;

use super::accessors::Accessors;
use super::vertices::Vertices;
use super::{Element, GltfError};
use crate::scene::mesh::MorphTarget;

/// The triangles of a primitive, in the order and winding of glTF 2.0 §3.7.2.1.
pub(super) fn triangulate(mode: Mode, corners: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => corners
            .windows(3)
            .enumerate()
            .map(|(i, c)| {
                if i % 2 == 0 {
                    [c[0], c[1], c[2]]
                } else {
                    [c[0], c[2], c[1]]
                }
            })
            .collect(),
        Mode::TriangleFan => match corners.split_first() {
            Some((&center, rim)) => rim.windows(2).map(|c| [c[0], c[1], center]).collect(),
            None => Vec::new(),
        },
        _ => corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]]).collect(),
    }
}

/// Returns the name of a mode's primitives in the plural, with a capital letter.
pub(super) fn plural(mode: Mode) -> &'static str {
    match mode {
        Mode::Points => "Points",
        Mode::Lines => "Lines",
        Mode::LineLoop => "Line loops",
        Mode::LineStrip => "Line strips",
        Mode::Triangles => "Triangles",
        Mode::TriangleStrip => "Triangle strips",
        Mode::TriangleFan => "Triangle fans",
    }
}

/// Gives each triangle separate vertices with the triangle's normal.
pub(super) fn split_flat(
    accessors: &Accessors<'_>,
    element: Element,
    shared: &Vertices,
    triangles: &[[u32; 3]],
) -> Result<Vertices, GltfError> {
    let corners = triangles.as_flattened();
    let moving = shared
        .targets
        .iter()
        .filter(|target| !target.positions.is_empty())
        .count();
    accessors.charge(
        element,
        corners.len(),
        size_of::<[Vec4; 6]>() + moving * size_of::<[Vec3; 2]>(),
    )?;
    fn gather<T: Copy>(stream: &[T], corners: &[u32]) -> Vec<T> {
        corners.iter().map(|&corner| stream[corner as usize]).collect()
    }
    let positions = gather(&shared.positions, corners);
    let normals = flat_normals(&positions);
    // The target's own normals are offsets from smooth normals, which do not exist here. The offsets that are
    // computed instead are exact at weight 1.
    let flat_target = |target: &MorphTarget| {
        if target.positions.is_empty() {
            return MorphTarget::default();
        }
        let deltas = gather(&target.positions, corners);
        let moved: Vec<Vec3> = positions
            .iter()
            .zip(&deltas)
            .map(|(&position, &delta)| position + delta)
            .collect();
        let moved_normals = flat_normals(&moved);
        MorphTarget {
            positions: deltas,
            normals: moved_normals
                .iter()
                .zip(&normals)
                .map(|(&moved, &rest)| moved - rest)
                .collect(),
            tangents: Vec::new(),
        }
    };
    Ok(Vertices {
        tangents: None,
        uv: [&shared.uv[0], &shared.uv[1]].map(|uv| uv.as_ref().map(|uv| gather(uv, corners))),
        colors: shared.colors.as_ref().map(|colors| gather(colors, corners)),
        skin: shared
            .skin
            .as_ref()
            .map(|(joints, weights)| (gather(joints, corners), gather(weights, corners))),
        targets: shared.targets.iter().map(flat_target).collect(),
        normals: Some(normals),
        positions,
    })
}

/// The normal of each triangle, repeated for each of its corners; +Y for a triangle without area.
fn flat_normals(positions: &[Vec3]) -> Vec<Vec3> {
    positions
        .chunks_exact(3)
        .flat_map(|c| {
            [(c[1] - c[0])
                .cross(c[2] - c[0])
                .try_normalize()
                .unwrap_or(Vec3::Y); 3]
        })
        .collect()
}
