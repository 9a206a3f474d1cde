//! Import of meshes: the primitives of a glTF mesh become the submeshes of one [`MeshData`].

use std::collections::HashMap;
use std::sync::Arc;

use glam::{Vec2, Vec3, Vec4};
use gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use smallvec::SmallVec;

use super::accessors::Accessors;
use super::draco::{self, Corners};
use super::triangles::{split_flat, triangulate};
use super::vertices::{self, Vertices, attribute};
use super::{Element, GltfError, Report, SkipKind};
use crate::scene::mesh::MorphTarget;
use crate::scene::{Material, MeshData, Submesh};

/// A mesh and its materials.
#[derive(Clone, Debug)]
pub struct GltfMesh {
    /// The mesh. Its submeshes are the primitives that have triangles.
    pub data: Arc<MeshData>,
    /// The materials, one for each submesh.
    pub materials: SmallVec<[Arc<Material>; 1]>,
    /// Weight of each morph target, for nodes that give no weights of their own.
    pub weights: Vec<f32>,
}

/// All meshes of the file.
pub(super) fn load(
    accessors: &Accessors<'_>,
    materials: &[Arc<Material>],
    decoded: &Corners,
    report: &mut Report,
) -> Result<Vec<GltfMesh>, GltfError> {
    let default_material = Arc::new(Material {
        name: "default".to_owned(),
        ..Material::default()
    });
    let mut meshes = Vec::with_capacity(accessors.root.meshes.len());
    for (index, mesh) in accessors.root.meshes.iter().enumerate() {
        let data = MeshData {
            name: mesh
                .name
                .clone()
                .unwrap_or_else(|| Element::Mesh(index).to_string()),
            ..MeshData::default()
        };
        let mut import = Import {
            accessors,
            decoded,
            index,
            report,
            data,
            vertex_runs: HashMap::new(),
        };
        let mut used_materials = SmallVec::new();
        for (primitive_index, primitive) in mesh.primitives.iter().enumerate() {
            if import.primitive(primitive_index, primitive)? {
                let element = Element::Primitive {
                    mesh: index,
                    primitive: primitive_index,
                };
                used_materials.push(match primitive.material {
                    Some(material) => Arc::clone(accessors.get(materials, material, element, "material")?),
                    None => Arc::clone(&default_material),
                });
            }
        }
        let mut data = import.data;
        replace_non_finite_positions(&mut data.positions);
        let weights = morph_weights(mesh, data.morph_targets.len(), index, report);
        meshes.push(GltfMesh {
            data: Arc::new(data),
            materials: used_materials,
            weights,
        });
    }
    Ok(meshes)
}

fn morph_weights(mesh: &Mesh, target_count: usize, index: usize, report: &mut Report) -> Vec<f32> {
    let mut weights = mesh.weights.clone().unwrap_or_default();
    if !weights.is_empty() && weights.len() != target_count {
        let reason = format!(
            "it has {} weights for {target_count} morph targets",
            weights.len()
        );
        report.add(SkipKind::NodeMesh, Element::Mesh(index), 1, reason);
    }
    weights.resize(target_count, 0.0);
    weights
}

/// Replaces positions that are not finite. No triangle uses those vertices any more, but bounds and buffers
/// must be able to hold them.
fn replace_non_finite_positions(positions: &mut [Vec3]) {
    let stand_in = positions
        .iter()
        .copied()
        .find(|position| position.is_finite())
        .unwrap_or(Vec3::ZERO);
    for position in positions.iter_mut().filter(|position| !position.is_finite()) {
        *position = stand_in;
    }
}

struct Import<'i, 'a> {
    accessors: &'i Accessors<'a>,
    /// The triangles of compressed primitives.
    decoded: &'i Corners,
    index: usize,
    report: &'i mut Report,
    data: MeshData,
    /// First vertex and vertex count, by the accessors that the vertices came from. Exporters often cut one
    /// vertex buffer into primitives by index alone.
    vertex_runs: HashMap<Vec<Option<usize>>, (usize, usize)>,
}

impl Import<'_, '_> {
    /// Appends a primitive as a submesh. Returns `false` if the primitive has no triangles.
    fn primitive(&mut self, primitive_index: usize, primitive: &Primitive) -> Result<bool, GltfError> {
        let element = Element::Primitive {
            mesh: self.index,
            primitive: primitive_index,
        };
        let mode = match primitive.mode {
            // Compressed primitives are lists of triangles, whatever mode the file states.
            _ if self.decoded.contains_key(&element) => Mode::Triangles,
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => mode,
            Checked::Valid(mode) => {
                self.report.add(
                    SkipKind::DrawMode,
                    element,
                    1,
                    format!("{mode:?} have no surface"),
                );
                return Ok(false);
            }
            Checked::Invalid => return Err(self.accessors.invalid(element, "its mode is unknown")),
        };
        let Some(position_accessor) = attribute(primitive, Semantic::Positions) else {
            self.report
                .add(SkipKind::EmptyPrimitive, element, 1, "it has no POSITION");
            return Ok(false);
        };

        draco::refuse_unread(self.accessors, element, primitive)?;
        let has_normals = attribute(primitive, Semantic::Normals).is_some();
        let key = vertex_key(primitive);
        let known = self.vertex_runs.get(&key).copied().filter(|_| has_normals);
        let (fresh, vertex_count) = match known {
            Some((_, count)) => (None, count),
            None => {
                let vertices =
                    vertices::read(self.accessors, element, primitive, position_accessor, self.report)?;
                let count = vertices.positions.len();
                (Some(vertices), count)
            }
        };

        let corners = self.corners(element, primitive_index, primitive, vertex_count)?;
        self.accessors.charge(element, corners.len(), 36)?;
        let mut triangles = triangulate(mode, &corners);
        let left_over = if mode == Mode::Triangles {
            corners.len() % 3
        } else {
            0
        };
        if left_over > 0 {
            let reason = format!("{} indices are no whole number of triangles", corners.len());
            self.report
                .add(SkipKind::IncompleteTriangle, element, left_over, reason);
        }

        let known_base = known.map_or(0, |(base, _)| base);
        let positions = match &fresh {
            Some(vertices) => &vertices.positions,
            None => &self.data.positions[known_base..known_base + vertex_count],
        };
        let before = triangles.len();
        triangles.retain(|corners| {
            corners
                .iter()
                .all(|&corner| positions[corner as usize].is_finite())
        });
        if triangles.len() < before {
            let count = before - triangles.len();
            self.report.add(
                SkipKind::NonFiniteTriangle,
                element,
                count,
                "a corner is not finite",
            );
        }
        if triangles.is_empty() {
            self.report
                .add(SkipKind::EmptyPrimitive, element, 1, "it has no triangles");
            return Ok(false);
        }

        let base = match fresh {
            Some(vertices) if has_normals => {
                let base = self.append(element, vertices)?;
                self.vertex_runs.insert(key, (base, vertex_count));
                base
            }
            Some(vertices) => {
                let flat = split_flat(self.accessors, element, &vertices, &triangles)?;
                for (triangle, corners) in triangles.iter_mut().enumerate() {
                    *corners = [0, 1, 2].map(|corner| (triangle * 3 + corner) as u32);
                }
                self.append(element, flat)?
            }
            None => known_base,
        };
        let first_index = self.data.indices.len();
        // `append` holds the number of vertices below 2³², so these sums fit.
        self.data.indices.extend(
            triangles
                .as_flattened()
                .iter()
                .map(|&corner| base as u32 + corner),
        );
        if self.data.indices.len() > u32::MAX as usize {
            return Err(self
                .accessors
                .invalid(element, "the mesh has more than 2³² indices"));
        }
        self.data.submeshes.push(Submesh {
            first_index: first_index as u32,
            index_count: (triangles.len() * 3) as u32,
        });
        Ok(true)
    }

    /// Vertex indices in drawing order, all of them in range.
    fn corners(
        &self,
        element: Element,
        primitive_index: usize,
        primitive: &Primitive,
        vertex_count: usize,
    ) -> Result<Vec<u32>, GltfError> {
        let corners = match (self.decoded.get(&element), primitive.indices) {
            (Some(corners), _) => corners.clone(),
            (None, Some(accessor)) => self.accessors.read_u32::<1>(accessor.value())?.into_flattened(),
            (None, None) => {
                self.accessors.charge(element, vertex_count, 4)?;
                return Ok((0..vertex_count as u32).collect());
            }
        };
        match corners.iter().find(|&&index| index as usize >= vertex_count) {
            Some(&index) => Err(GltfError::VertexIndex {
                file: self.accessors.file.clone(),
                mesh: self.index,
                primitive: primitive_index,
                index,
                vertex_count,
            }),
            None => Ok(corners),
        }
    }

    /// Appends streams to those of the mesh. Where only one side has a stream, default values fill the other
    /// side. Returns the index of the first new vertex.
    fn append(&mut self, element: Element, new: Vertices) -> Result<usize, GltfError> {
        let base = self.data.positions.len();
        let end = base + new.positions.len();
        if end > u32::MAX as usize {
            return Err(self
                .accessors
                .invalid(element, "the mesh has more than 2³² vertices"));
        }
        let join = Join {
            accessors: self.accessors,
            element,
            base,
            end,
        };
        let data = &mut self.data;
        join.stream(&mut data.positions, Some(new.positions), Vec3::ZERO)?;
        join.stream(&mut data.normals, new.normals, Vec3::Y)?;
        join.stream(&mut data.tangents, new.tangents, Vec4::X)?;
        let [uv0, uv1] = new.uv;
        join.stream(&mut data.uv0, uv0, Vec2::ZERO)?;
        join.stream(&mut data.uv1, uv1, Vec2::ZERO)?;
        join.stream(&mut data.colors, new.colors, Vec4::ONE)?;
        let (joints, weights) = new.skin.unzip();
        join.stream(&mut data.joints, joints, [0; 4])?;
        join.stream(&mut data.joint_weights, weights, Vec4::X)?;

        let mut targets = new.targets;
        let target_count = targets.len().max(data.morph_targets.len());
        targets.resize_with(target_count, MorphTarget::default);
        data.morph_targets.resize_with(target_count, MorphTarget::default);
        for (target, new) in data.morph_targets.iter_mut().zip(targets) {
            let present = |stream: Vec<Vec3>| Some(stream).filter(|stream| !stream.is_empty());
            join.stream(&mut target.positions, present(new.positions), Vec3::ZERO)?;
            join.stream(&mut target.normals, present(new.normals), Vec3::ZERO)?;
            join.stream(&mut target.tangents, present(new.tangents), Vec3::ZERO)?;
        }
        Ok(base)
    }
}

struct Join<'j, 'a> {
    accessors: &'j Accessors<'a>,
    element: Element,
    base: usize,
    end: usize,
}

impl Join<'_, '_> {
    fn stream<T: Clone>(&self, stream: &mut Vec<T>, new: Option<Vec<T>>, fill: T) -> Result<(), GltfError> {
        if new.is_none() && stream.is_empty() {
            return Ok(());
        }
        self.accessors
            .charge(self.element, self.end - stream.len(), size_of::<T>())?;
        stream.resize(self.base, fill.clone());
        stream.extend(new.into_iter().flatten());
        stream.resize(self.end, fill);
        Ok(())
    }
}

/// The accessors that a primitive's vertices come from, in a fixed order.
fn vertex_key(primitive: &Primitive) -> Vec<Option<usize>> {
    let mut key: Vec<Option<usize>> = Vec::new();
    for semantic in [
        Semantic::Positions,
        Semantic::Normals,
        Semantic::Tangents,
        Semantic::TexCoords(0),
        Semantic::TexCoords(1),
        Semantic::Colors(0),
    ] {
        key.push(attribute(primitive, semantic));
    }
    let mut set = 0;
    while let Some(joints) = attribute(primitive, Semantic::Joints(set)) {
        key.extend([Some(joints), attribute(primitive, Semantic::Weights(set))]);
        set += 1;
    }
    key.push(None); // separates the joints from the targets
    for target in primitive.targets.iter().flatten() {
        key.extend([target.positions, target.normals, target.tangents].map(|a| a.map(|a| a.value())));
    }
    key
}
