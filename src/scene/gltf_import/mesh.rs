//! Import of meshes: the primitives of a glTF mesh become the submeshes of one [`MeshData`].

use std::collections::HashMap;
use std::sync::Arc;

use glam::Vec3;
use gltf::json::mesh::{Mesh, Mode, Primitive, Semantic};
use gltf::json::validation::Checked;
use smallvec::SmallVec;

use super::accessors::Accessors;
use super::append_vertices::append;
use super::draco::{self, Corners};
use super::triangles::{plural, split_flat, triangulate};
use super::vertex_alpha::VertexAlpha;
use super::vertices::{self, Vertices, attribute};
use super::{Element, GltfError, Report, SkipKind, incomplete};
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

/// All meshes of the file. The materials come with what the alpha of vertex colours means under each.
pub(super) fn load(
    accessors: &Accessors<'_>,
    (materials, vertex_alpha): (&[Arc<Material>], &[VertexAlpha]),
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
            vertex_alpha,
            index,
            report,
            data,
            vertex_runs: HashMap::new(),
            loaded: Vec::new(),
        };
        let mut used_materials = SmallVec::new();
        for (primitive_index, primitive) in mesh.primitives.iter().enumerate() {
            if import.primitive(primitive_index, primitive)? {
                let element = Element::Primitive {
                    mesh: index,
                    primitive: primitive_index,
                };
                let material = match primitive.material {
                    Some(material) => accessors.get(materials, material, element, "material")?,
                    None => &default_material,
                };
                incomplete::report_coordinates(element, primitive, material, import.report);
                used_materials.push(Arc::clone(material));
            }
        }
        incomplete::report_unbound(&import.loaded, import.report);
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
    /// The meaning of the vertex colours' alpha under each material.
    vertex_alpha: &'i [VertexAlpha],
    index: usize,
    report: &'i mut Report,
    data: MeshData,
    /// First vertex and vertex count, by what the vertices are made from. Exporters often cut one
    /// vertex buffer into primitives by index alone.
    vertex_runs: HashMap<Vec<Option<usize>>, (usize, usize)>,
    /// The submeshes' primitives, with their numbers of vertices and whether they have joints.
    loaded: Vec<(Element, usize, bool)>,
}

/// The vertices of one primitive.
enum VertexRun {
    /// The mesh has them, since another primitive uses the same accessors.
    Known {
        /// Index of the first vertex.
        base: usize,
        count: usize,
    },
    /// They were read and are in no mesh yet.
    Fresh(Vertices),
}

impl VertexRun {
    fn vertex_count(&self) -> usize {
        match self {
            Self::Known { count, .. } => *count,
            Self::Fresh(vertices) => vertices.positions.len(),
        }
    }
}

impl Import<'_, '_> {
    /// Appends a primitive as a submesh. Returns `false` if the primitive has no triangles.
    fn primitive(&mut self, primitive_index: usize, primitive: &Primitive) -> Result<bool, GltfError> {
        let element = Element::Primitive {
            mesh: self.index,
            primitive: primitive_index,
        };
        let Some(mode) = self.surface_mode(element, primitive)? else {
            return Ok(false);
        };
        let Some(position_accessor) = attribute(primitive, Semantic::Positions) else {
            self.report
                .add(SkipKind::EmptyPrimitive, element, 1, "it has no POSITION");
            return Ok(false);
        };
        draco::refuse_unread(self.accessors, element, primitive)?;
        let run = self.vertex_run(element, primitive, position_accessor)?;
        let corners = self.corners(element, primitive_index, primitive, run.vertex_count())?;
        let mut triangles = self.triangles(element, mode, &corners, &run)?;
        if triangles.is_empty() {
            self.report
                .add(SkipKind::EmptyPrimitive, element, 1, "it has no triangles");
            return Ok(false);
        }
        if incomplete::lacks_area(primitive, self.positions(&run), &triangles) {
            let reason = "its triangles have no area";
            self.report.add(SkipKind::EmptyPrimitive, element, 1, reason);
        }
        let has_joints = attribute(primitive, Semantic::Joints(0)).is_some();
        self.loaded.push((element, run.vertex_count(), has_joints));
        let base = self.place(element, primitive, run, &mut triangles)?;
        self.push_submesh(element, base, &triangles)?;
        Ok(true)
    }

    /// Returns how the primitive's indices form triangles; `None`, reported, for points and lines.
    fn surface_mode(&mut self, element: Element, primitive: &Primitive) -> Result<Option<Mode>, GltfError> {
        // Compressed primitives are lists of triangles, whatever mode the file states.
        if self.decoded.contains_key(&element) {
            return Ok(Some(Mode::Triangles));
        }
        match primitive.mode {
            Checked::Valid(mode @ (Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan)) => {
                Ok(Some(mode))
            }
            Checked::Valid(mode) => {
                let reason = format!("{} have no surface", plural(mode));
                self.report.add(SkipKind::DrawMode, element, 1, reason);
                Ok(None)
            }
            Checked::Invalid => Err(self.accessors.invalid(element, "its mode is unknown")),
        }
    }

    /// Reads the vertices of a primitive, or finds them among those that the mesh already has.
    fn vertex_run(
        &mut self,
        element: Element,
        primitive: &Primitive,
        position_accessor: usize,
    ) -> Result<VertexRun, GltfError> {
        // Vertices without normals are split by triangle, so no other primitive can use them.
        let has_normals = attribute(primitive, Semantic::Normals).is_some();
        let known = self.vertex_runs.get(&self.run_key(primitive)).copied();
        if let Some((base, count)) = known.filter(|_| has_normals) {
            return Ok(VertexRun::Known { base, count });
        }
        let mut vertices =
            vertices::read(self.accessors, element, primitive, position_accessor, self.report)?;
        let colors = vertices.colors.as_deref_mut().unwrap_or_default();
        let lost = self.vertex_alpha_of(primitive).apply(colors);
        if lost > 0 {
            let reason = "its vertices' alpha takes no part in the mask of a material that transmits";
            self.report.add(SkipKind::VertexData, element, lost, reason);
        }
        Ok(VertexRun::Fresh(vertices))
    }

    fn vertex_alpha_of(&self, primitive: &Primitive) -> VertexAlpha {
        let material = primitive
            .material
            .and_then(|material| self.vertex_alpha.get(material.value()));
        material.copied().unwrap_or_default()
    }

    /// The sources of a primitive's vertices: its accessors, and its material if that changes them.
    fn run_key(&self, primitive: &Primitive) -> Vec<Option<usize>> {
        let mut key = vertex_key(primitive);
        let changes = self.vertex_alpha_of(primitive) != VertexAlpha::Multiplies;
        key.push(
            primitive
                .material
                .filter(|_| changes)
                .map(|material| material.value()),
        );
        key
    }

    fn positions<'r>(&'r self, run: &'r VertexRun) -> &'r [Vec3] {
        match run {
            VertexRun::Fresh(vertices) => &vertices.positions,
            VertexRun::Known { base, count } => &self.data.positions[*base..base + count],
        }
    }

    /// Returns the triangles whose corners are finite, and reports what is left out.
    fn triangles(
        &mut self,
        element: Element,
        mode: Mode,
        corners: &[u32],
        run: &VertexRun,
    ) -> Result<Vec<[u32; 3]>, GltfError> {
        self.accessors.charge(element, corners.len(), 36)?;
        let mut triangles = triangulate(mode, corners);
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
        let positions = self.positions(run);
        let before = triangles.len();
        let is_finite = |corner: &u32| positions[*corner as usize].is_finite();
        triangles.retain(|corners| corners.iter().all(is_finite));
        if triangles.len() < before {
            let count = before - triangles.len();
            self.report.add(
                SkipKind::NonFiniteTriangle,
                element,
                count,
                "a corner is not finite",
            );
        }
        Ok(triangles)
    }

    /// Puts the vertices of a primitive into the mesh and returns the index of the first. Vertices without normals
    /// are split by triangle, which changes the corners of `triangles`.
    fn place(
        &mut self,
        element: Element,
        primitive: &Primitive,
        run: VertexRun,
        triangles: &mut [[u32; 3]],
    ) -> Result<usize, GltfError> {
        let vertices = match run {
            VertexRun::Known { base, .. } => return Ok(base),
            VertexRun::Fresh(vertices) => vertices,
        };
        if attribute(primitive, Semantic::Normals).is_some() {
            let count = vertices.positions.len();
            let base = append(self.accessors, element, &mut self.data, vertices)?;
            self.vertex_runs.insert(self.run_key(primitive), (base, count));
            return Ok(base);
        }
        let flat = split_flat(self.accessors, element, &vertices, triangles)?;
        for (triangle, corners) in triangles.iter_mut().enumerate() {
            *corners = [0, 1, 2].map(|corner| (triangle * 3 + corner) as u32);
        }
        append(self.accessors, element, &mut self.data, flat)
    }

    /// Appends the indices of `triangles`, which count from the vertex `base`, as a submesh.
    fn push_submesh(
        &mut self,
        element: Element,
        base: usize,
        triangles: &[[u32; 3]],
    ) -> Result<(), GltfError> {
        let first_index = self.data.indices.len();
        // `append` holds the number of vertices below 2³², so these sums fit.
        let corners = triangles.as_flattened().iter();
        self.data
            .indices
            .extend(corners.map(|&corner| base as u32 + corner));
        if self.data.indices.len() > u32::MAX as usize {
            return Err(self
                .accessors
                .invalid(element, "the mesh has more than 2³² indices"));
        }
        self.data.submeshes.push(Submesh {
            first_index: first_index as u32,
            index_count: (triangles.len() * 3) as u32,
        });
        Ok(())
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
            (None, Some(accessor)) => self
                .accessors
                .read_u32::<1>(accessor.value(), element)?
                .into_flattened(),
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
