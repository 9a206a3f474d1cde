//! Primitives that are compressed by `KHR_draco_mesh_compression`.
//!
//! Such a primitive is decoded before meshes are read, and its accessors then have the decoded elements. The accessors keep
//! their own data, if the file has any for them, without the cargo feature `gltf-draco`, and where the compressed data is
//! broken, unless the file requires the extension.

use std::collections::HashMap;

use gltf::json::mesh::Primitive;

use super::accessors::Accessors;
use super::extensions::{DRACO, why_unread};
use super::{Element, GltfError};

/// The corners of the triangles of each primitive that was decoded, as vertex indices.
pub(super) type Corners = HashMap<Element, Vec<u32>>;

/// Whether the data of a primitive is compressed.
pub(super) fn is_compressed(primitive: &Primitive) -> bool {
    let extensions = primitive.extensions.as_ref();
    extensions.is_some_and(|extensions| extensions.others.contains_key(DRACO))
}

/// Refuses a primitive whose data exists only in compressed form, in a build that cannot read it. Its accessors have no
/// data of their own and would read as zeros.
pub(super) fn refuse_unread(
    accessors: &Accessors<'_>,
    element: Element,
    primitive: &Primitive,
) -> Result<(), GltfError> {
    if cfg!(feature = "gltf-draco") || !is_compressed(primitive) {
        return Ok(());
    }
    match accessor_without_data(accessors, primitive) {
        Some(accessor) => {
            let reason = format!(
                "its data is compressed by {DRACO}, {}, and accessor {accessor} has no other data",
                why_unread(DRACO)
            );
            Err(accessors.invalid(element, reason))
        }
        None => Ok(()),
    }
}

/// The indices of the accessors of a primitive's attributes and triangles.
fn accessors_of(primitive: &Primitive) -> impl Iterator<Item = usize> + '_ {
    let used = primitive.attributes.values().chain(primitive.indices.as_ref());
    used.map(|accessor| accessor.value())
}

/// The first of a primitive's accessors that has no data of its own and would read as zeros.
fn accessor_without_data(accessors: &Accessors<'_>, primitive: &Primitive) -> Option<usize> {
    let is_without = |accessor: &usize| {
        let accessor = accessors.root.accessors.get(*accessor);
        accessor.is_some_and(|accessor| accessor.buffer_view.is_none() && accessor.sparse.is_none())
    };
    accessors_of(primitive).filter(is_without).min()
}

#[cfg(not(feature = "gltf-draco"))]
pub(super) fn decode(
    _accessors: &mut Accessors<'_>,
    _report: &mut super::Report,
) -> Result<Corners, GltfError> {
    Ok(Corners::new())
}

#[cfg(feature = "gltf-draco")]
pub(super) use decoder::decode;

#[cfg(feature = "gltf-draco")]
mod decoder {
    use std::collections::HashMap;

    use draco_core::{DataType, DecodeLimits, DecoderBuffer, Mesh, MeshDecoder, PointAttribute, PointIndex};
    use gltf::json::accessor::ComponentType;
    use gltf::json::mesh::Primitive;
    use gltf::json::validation::Checked;
    use gltf::json::{Index, Value};

    use super::super::accessors::{Accessors, DecodedAccessor};
    use super::super::extensions::{DRACO, report_broken, whole_number};
    use super::super::{Element, GltfError, Report};
    use super::{Corners, accessor_without_data, accessors_of};

    /// Decodes all compressed primitives of the file and gives their accessors the elements. A primitive whose stream is
    /// broken keeps its uncompressed data if it has all of it, which is reported.
    ///
    /// # Errors
    /// A stream that is broken or does not have an attribute that the primitive names, where the primitive has no other data
    /// or the file requires the extension.
    pub(in super::super) fn decode(
        accessors: &mut Accessors<'_>,
        report: &mut Report,
    ) -> Result<Corners, GltfError> {
        let mut corners = Corners::new();
        let root = accessors.root;
        let is_required = accessors.requires(DRACO);
        let mut broken: Vec<(Element, &Primitive, GltfError)> = Vec::new();
        // An accessor may belong to several primitives only if they come from the same stream.
        let mut owners: HashMap<usize, usize> = HashMap::new();
        for (mesh, json) in root.meshes.iter().enumerate() {
            for (index, primitive) in json.primitives.iter().enumerate() {
                let element = Element::Primitive {
                    mesh,
                    primitive: index,
                };
                let others = primitive.extensions.as_ref().map(|extensions| &extensions.others);
                let Some(object) = others.and_then(|others| others.get(DRACO)) else {
                    continue;
                };
                let stream = match read(accessors, element, primitive, object) {
                    Ok(stream) => stream,
                    Err(error) if !is_required && accessor_without_data(accessors, primitive).is_none() => {
                        broken.push((element, primitive, error));
                        continue;
                    }
                    Err(error) => return Err(error),
                };
                corners.insert(element, stream.corners);
                let view = stream.view;
                for (accessor, elements) in stream.attributes {
                    if *owners.entry(accessor).or_insert(view) != view {
                        let first = owners[&accessor];
                        let reason = format!(
                            "{DRACO}: accessor {accessor} is in buffer views {first} and {view}, which differ"
                        );
                        return Err(accessors.invalid(element, reason));
                    }
                    accessors.decode(accessor, elements);
                }
            }
        }
        for (element, primitive, error) in broken {
            // Another stream has given an accessor its own order of vertices.
            if accessors_of(primitive).any(|accessor| owners.contains_key(&accessor)) {
                return Err(error);
            }
            report_broken(report, &accessors.file, element, DRACO, &error);
        }
        Ok(corners)
    }

    /// A decoded primitive.
    struct Stream {
        /// The buffer view that held it.
        view: usize,
        /// The corners of its triangles.
        corners: Vec<u32>,
        /// The accessors of its attributes and their elements.
        attributes: Vec<(usize, DecodedAccessor)>,
    }

    fn read(
        accessors: &Accessors<'_>,
        element: Element,
        primitive: &Primitive,
        object: &Value,
    ) -> Result<Stream, GltfError> {
        let invalid = |reason: String| accessors.invalid(element, format!("{DRACO}: {reason}"));
        let view = whole_number(object.get("bufferView"))
            .ok_or_else(|| invalid("bufferView is not an index".to_owned()))?;
        let stream = accessors
            .view(element, Index::new(view as u32))
            .map_err(|error| error.read_by(element))?;
        let limits = limits(accessors.budget_left());
        let mut mesh = Mesh::new();
        let mut buffer = DecoderBuffer::new(stream).with_limits(limits);
        MeshDecoder::new()
            .decode(&mut buffer, &mut mesh)
            .map_err(|error| invalid(format!("buffer view {view} cannot be decoded: {error}")))?;

        let (points, faces) = (mesh.num_points(), mesh.num_faces());
        accessors.charge(element, faces, 12)?;
        let mut attributes = Vec::new();
        for (semantic, accessor) in &primitive.attributes {
            let Checked::Valid(semantic) = semantic else {
                continue;
            };
            let name = semantic.to_string();
            let Some(id) = object.get("attributes").and_then(|named| named.get(&name)) else {
                continue; // it is not compressed
            };
            let attribute = whole_number(Some(id))
                .and_then(|id| mesh.attribute_by_unique_id(u32::try_from(id).ok()?))
                .ok_or_else(|| invalid(format!("buffer view {view} has no attribute {id} for {name}")))?;
            let width = usize::from(attribute.num_components());
            accessors.charge(element, points, 4 * width)?;
            let elements = elements(attribute, points)
                .ok_or_else(|| invalid(format!("{name} has elements of no type that glTF has")))?;
            attributes.push((accessor.value(), elements));
        }
        let corners = mesh.faces().iter().flatten().map(|point| point.0).collect();
        Ok(Stream {
            view,
            corners,
            attributes,
        })
    }

    /// Limits by which a broken stream is refused before it takes memory.
    fn limits(budget_bytes: u64) -> DecodeLimits {
        let mut limits = DecodeLimits::default();
        limits.max_points = limits.max_points.min(budget_bytes / 12);
        limits.max_faces = limits.max_faces.min(budget_bytes / 12);
        limits.max_decoded_bytes = limits.max_decoded_bytes.min(budget_bytes);
        limits
    }

    /// The values of an attribute in the order of points. `None` for a type of numbers that glTF does not have.
    fn elements(attribute: &PointAttribute, points: usize) -> Option<DecodedAccessor> {
        let width = usize::from(attribute.num_components());
        let component = match attribute.data_type() {
            DataType::Int8 => ComponentType::I8,
            DataType::Uint8 | DataType::Bool => ComponentType::U8,
            DataType::Int16 => ComponentType::I16,
            DataType::Uint16 => ComponentType::U16,
            DataType::Uint32 => ComponentType::U32,
            DataType::Float32 => ComponentType::F32,
            _ => return None,
        };
        let size = component.size() * width;
        let (stride, data) = (attribute.byte_stride() as usize, attribute.buffer().data());
        let mut bytes = Vec::with_capacity(points * size);
        for point in 0..points {
            let value = attribute.mapped_index(PointIndex(point as u32)).0 as usize;
            let start = value.checked_mul(stride)?;
            bytes.extend_from_slice(data.get(start..start.checked_add(size)?)?);
        }
        Some(DecodedAccessor {
            bytes,
            component,
            width,
        })
    }
}
