//! Conversion of Bevy meshes to [`MeshData`].

use bevy::mesh::{
    Indices, Mesh, MeshAccessError, MeshVertexAttribute, PrimitiveTopology, VertexAttributeValues,
};
use glam::{Vec2, Vec3, Vec4};

use crate::scene::{MeshData, MorphTarget, Submesh};

/// The reason why a Bevy mesh cannot cast shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MeshRefusal {
    /// The mesh's data were moved to the render world before they could be read.
    #[error(
        "its vertices are in the render world only; its asset usage must hold MAIN_WORLD, or it must be changed together with its data"
    )]
    RenderWorldOnly,
    /// The mesh has no positions of three 32-bit floats.
    #[error("it has no Mesh::ATTRIBUTE_POSITION of Float32x3")]
    NoPositions,
    /// The mesh consists of points or lines, which block no light.
    #[error("it is a mesh of {0:?}, not of triangles")]
    NotTriangles(PrimitiveTopology),
    /// An index refers to a vertex that the mesh does not have.
    #[error("triangle {triangle} names vertex {vertex}, of {count}")]
    Index {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// Index of the missing vertex.
        vertex: u32,
        /// Number of vertices of the mesh.
        count: usize,
    },
}

impl From<MeshAccessError> for MeshRefusal {
    fn from(error: MeshAccessError) -> Self {
        match error {
            MeshAccessError::ExtractedToRenderWorld => Self::RenderWorldOnly,
            MeshAccessError::NotFound => Self::NoPositions,
        }
    }
}

/// Copies the parts of a mesh that shadows need: positions, triangles, normals, texture coordinates, colours,
/// joints and morph targets.
/// Triangle strips become triangles, and meshes without indices get indices. Cost: the vertices of the mesh.
///
/// # Errors
/// [`MeshRefusal`] says why the mesh cannot cast shadows.
pub fn convert_mesh(mesh: &Mesh, name: &str) -> Result<MeshData, MeshRefusal> {
    let topology = mesh.primitive_topology();
    if !matches!(
        topology,
        PrimitiveTopology::TriangleList | PrimitiveTopology::TriangleStrip
    ) {
        return Err(MeshRefusal::NotTriangles(topology));
    }
    let Some(VertexAttributeValues::Float32x3(positions)) =
        mesh.try_attribute_option(Mesh::ATTRIBUTE_POSITION)?
    else {
        return Err(MeshRefusal::NoPositions);
    };
    let count = positions.len();
    let list: Vec<u32> = match mesh.try_indices_option()? {
        Some(Indices::U16(indices)) => indices.iter().map(|&index| u32::from(index)).collect(),
        Some(Indices::U32(indices)) => indices.clone(),
        None => (0..count as u32).collect(),
    };
    let indices = triangles(list, topology);
    if let Some(at) = indices.iter().position(|&index| index as usize >= count) {
        return Err(MeshRefusal::Index {
            triangle: at / 3,
            vertex: indices[at],
            count,
        });
    }
    let positions = positions.iter().copied().map(Vec3::from_array).collect();
    let mut data = MeshData::from_triangles(name, positions, indices);
    if let Some(VertexAttributeValues::Float32x3(normals)) =
        mesh.try_attribute_option(Mesh::ATTRIBUTE_NORMAL)?
        && normals.len() == count
    {
        data.normals = normals.iter().copied().map(Vec3::from_array).collect();
    }
    data.uv0 = texture_coordinates(mesh, Mesh::ATTRIBUTE_UV_0, count)?;
    data.uv1 = texture_coordinates(mesh, Mesh::ATTRIBUTE_UV_1, count)?;
    if let Some(VertexAttributeValues::Float32x4(colors)) =
        mesh.try_attribute_option(Mesh::ATTRIBUTE_COLOR)?
        && colors.len() == count
    {
        data.colors = colors.iter().copied().map(Vec4::from_array).collect();
    }
    if let (Some(VertexAttributeValues::Uint16x4(joints)), Some(VertexAttributeValues::Float32x4(weights))) = (
        mesh.try_attribute_option(Mesh::ATTRIBUTE_JOINT_INDEX)?,
        mesh.try_attribute_option(Mesh::ATTRIBUTE_JOINT_WEIGHT)?,
    ) && joints.len() == count
        && weights.len() == count
    {
        data.joints.clone_from(joints);
        data.joint_weights = weights.iter().copied().map(Vec4::from_array).collect();
    }
    data.morph_targets = morph_targets(mesh, count)?;
    data.submeshes = vec![Submesh {
        first_index: 0,
        index_count: data.indices.len() as u32,
    }];
    Ok(data)
}

/// Copies a set of texture coordinates. The set is empty if the mesh has no such coordinates.
fn texture_coordinates(
    mesh: &Mesh,
    set: MeshVertexAttribute,
    vertices: usize,
) -> Result<Vec<Vec2>, MeshRefusal> {
    Ok(match mesh.try_attribute_option(set)? {
        Some(VertexAttributeValues::Float32x2(uvs)) if uvs.len() == vertices => {
            uvs.iter().copied().map(Vec2::from_array).collect()
        }
        _ => Vec::new(),
    })
}

/// Returns the whole triangles of a list or strip, all wound like the first. Every other triangle of a strip
/// is turned for this.
fn triangles(mut list: Vec<u32>, topology: PrimitiveTopology) -> Vec<u32> {
    if topology == PrimitiveTopology::TriangleList {
        list.truncate(list.len() - list.len() % 3);
        return list;
    }
    let corners = list.windows(3).enumerate();
    corners
        .flat_map(|(at, corner)| {
            let odd = at % 2;
            [corner[odd], corner[1 - odd], corner[2]]
        })
        .collect()
}

/// Converts the morph targets. Bevy stores one target after the other, with one entry for each vertex.
fn morph_targets(mesh: &Mesh, vertices: usize) -> Result<Vec<MorphTarget>, MeshRefusal> {
    let targets = match mesh.try_morph_targets() {
        Ok(targets) => targets,
        Err(MeshAccessError::NotFound) => return Ok(Vec::new()),
        Err(error) => return Err(error.into()),
    };
    if vertices == 0 {
        return Ok(Vec::new());
    }
    let target = |target: &[bevy::mesh::morph::MorphAttributes]| MorphTarget {
        positions: target.iter().map(|vertex| vertex.position).collect(),
        normals: target.iter().map(|vertex| vertex.normal).collect(),
        tangents: Vec::new(),
    };
    Ok(targets.chunks_exact(vertices).map(target).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::asset::RenderAssetUsages;

    fn mesh(topology: PrimitiveTopology, points: usize) -> Mesh {
        let at = |i: usize| [i as f32, (i % 2) as f32, 0.0];
        Mesh::new(topology, RenderAssetUsages::default())
            .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, (0..points).map(at).collect::<Vec<_>>())
    }

    #[test]
    fn strips_and_lists_give_triangles_wound_alike() {
        let strip = convert_mesh(&mesh(PrimitiveTopology::TriangleStrip, 5), "strip").unwrap();
        assert_eq!(strip.indices, [0, 1, 2, 2, 1, 3, 2, 3, 4]);
        let list = convert_mesh(&mesh(PrimitiveTopology::TriangleList, 7), "list").unwrap();
        assert_eq!(list.indices, [0, 1, 2, 3, 4, 5]);
        let indexed =
            mesh(PrimitiveTopology::TriangleList, 4).with_inserted_indices(Indices::U16(vec![0, 2, 3, 1]));
        assert_eq!(convert_mesh(&indexed, "indexed").unwrap().indices, [0, 2, 3]);
    }

    #[test]
    fn refusals_say_why() {
        let lines = mesh(PrimitiveTopology::LineList, 4);
        let refusal = convert_mesh(&lines, "lines").unwrap_err();
        assert_eq!(refusal, MeshRefusal::NotTriangles(PrimitiveTopology::LineList));
        let bare = Mesh::new(PrimitiveTopology::TriangleList, RenderAssetUsages::default());
        assert_eq!(convert_mesh(&bare, "bare").unwrap_err(), MeshRefusal::NoPositions);
        let wild =
            mesh(PrimitiveTopology::TriangleList, 3).with_inserted_indices(Indices::U32(vec![0, 1, 9]));
        let refusal = convert_mesh(&wild, "wild").unwrap_err();
        assert_eq!(refusal.to_string(), "triangle 0 names vertex 9, of 3");
    }
}
