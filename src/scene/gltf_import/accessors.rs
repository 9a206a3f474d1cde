//! Reading of accessors. Every bound is checked before a byte is read and before memory is allocated.

use std::cell::{Cell, OnceCell, RefCell};
use std::collections::HashMap;
use std::path::PathBuf;

use gltf::json::accessor::{ComponentType, Type};
use gltf::json::validation::Checked;
use gltf::json::{Index, Root};

use super::buffers::BufferBytes;
use super::components::{component_f32, component_u32};
use super::{Element, GltfError, Report};

/// Decoded bytes that even an empty file may take. This is enough for accessors without a view, which are all
/// zeros.
const BUDGET_BASE_BYTES: u64 = 512 << 20;

/// Decoded bytes that each byte of the file and its buffers may take. By eye: flat normals take most, about
/// 30 for a triangle of 8-bit indices over quantised positions.
const BUDGET_PER_BYTE: u64 = 64;

/// The accessors of a file, and how much memory decoding them may still take.
pub(super) struct Accessors<'a> {
    pub file: PathBuf,
    pub root: &'a Root,
    pub buffers: Vec<BufferBytes<'a>>,
    budget_bytes: Cell<u64>,
    /// The buffer views that were stored compressed and have been read, decompressed. `None` stands for one whose compressed
    /// bytes are broken and which has its bytes uncompressed as well.
    pub views: Vec<OnceCell<Option<Vec<u8>>>>,
    /// Reports of elements whose compressed bytes are broken and whose uncompressed ones were read instead.
    pub uncompressed: RefCell<Report>,
    /// Accessors whose elements come from compressed primitives instead of their buffer views.
    decoded: HashMap<usize, DecodedAccessor>,
}

/// The elements of an accessor that a compressed primitive holds.
#[cfg_attr(not(feature = "gltf-draco"), allow(dead_code, reason = "nothing is decoded"))]
pub(super) struct DecodedAccessor {
    /// The elements one after the other, little-endian.
    pub bytes: Vec<u8>,
    /// The type of each component.
    pub component: ComponentType,
    /// Number of components of each element.
    pub width: usize,
}

impl DecodedAccessor {
    /// Number of elements.
    pub fn count(&self) -> usize {
        self.bytes.len() / (self.component.size() * self.width).max(1)
    }
}

/// The bytes of a series of elements in a buffer, with bounds checked.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
}

/// An accessor whose bounds and types are checked.
struct Layout<'a> {
    count: usize,
    component: ComponentType,
    width: usize,
    normalized: bool,
    /// The stored elements. `None` means that all are zero.
    base: Option<Elements<'a>>,
    sparse: Option<(Vec<u32>, Elements<'a>)>,
}

impl<'a> Accessors<'a> {
    pub fn new(file: PathBuf, root: &'a Root, buffers: Vec<BufferBytes<'a>>, file_bytes: usize) -> Self {
        let in_buffers: u64 = buffers.iter().flatten().map(|buffer| buffer.len() as u64).sum();
        let stored = file_bytes as u64 + in_buffers;
        let budget_bytes = BUDGET_BASE_BYTES.saturating_add(stored.saturating_mul(BUDGET_PER_BYTE));
        Self {
            file,
            root,
            buffers,
            budget_bytes: Cell::new(budget_bytes),
            views: vec![OnceCell::new(); root.buffer_views.len()],
            uncompressed: RefCell::default(),
            decoded: HashMap::new(),
        }
    }

    /// Gives an accessor the elements of a compressed primitive. From now on it reads them.
    #[cfg(feature = "gltf-draco")]
    pub fn decode(&mut self, accessor: usize, elements: DecodedAccessor) {
        self.decoded.insert(accessor, elements);
    }

    /// An error about an element of this file.
    pub fn invalid(&self, element: Element, reason: impl Into<String>) -> GltfError {
        GltfError::Invalid {
            file: self.file.clone(),
            element,
            reason: reason.into(),
        }
    }

    /// The item of `list` that `element` refers to.
    pub fn get<'l, T, S>(
        &self,
        list: &'l [T],
        index: Index<S>,
        element: Element,
        target: &'static str,
    ) -> Result<&'l T, GltfError> {
        list.get(index.value()).ok_or_else(|| GltfError::Reference {
            file: self.file.clone(),
            element,
            target,
            index: index.value(),
            count: list.len(),
        })
    }

    /// Takes memory from the budget. Call this before allocating.
    pub fn charge(&self, element: Element, count: usize, bytes_each: usize) -> Result<(), GltfError> {
        let bytes = (count as u64).saturating_mul(bytes_each as u64);
        let left = self.budget_bytes.get();
        let remaining = left.checked_sub(bytes);
        self.budget_bytes
            .set(remaining.ok_or_else(|| GltfError::TooLarge {
                file: self.file.clone(),
                element,
                bytes,
                left,
            })?);
        Ok(())
    }

    /// Bytes that decoding may still take.
    #[cfg(feature = "gltf-draco")]
    pub fn budget_left(&self) -> u64 {
        self.budget_bytes.get()
    }

    /// Number of elements. For elements that are not compressed it is what the file states, unchecked; 0 if the
    /// accessor does not exist.
    pub fn count(&self, accessor: usize) -> usize {
        if let Some(decoded) = self.decoded.get(&accessor) {
            return decoded.count();
        }
        self.root
            .accessors
            .get(accessor)
            .map_or(0, |accessor| accessor.count.0 as usize)
    }

    /// Whether the accessor has four components. Colours may have three.
    pub fn is_vec4(&self, accessor: usize) -> bool {
        self.root
            .accessors
            .get(accessor)
            .is_some_and(|accessor| matches!(accessor.type_, Checked::Valid(Type::Vec4)))
    }

    /// Reads elements of `N` numbers. Integers become −1..=1 or 0..=1 if they are normalised, and otherwise
    /// keep their value. `referrer` is the element that refers to the accessor.
    pub fn read_f32<const N: usize>(
        &self,
        accessor: usize,
        referrer: Element,
    ) -> Result<Vec<[f32; N]>, GltfError> {
        let layout = self.layout(accessor, N, referrer)?;
        self.charge(Element::Accessor(accessor), layout.count, 4 * N)?;
        Ok(layout.collect([0.0; N], |bytes| {
            let size = layout.component.size();
            std::array::from_fn(|i| component_f32(&bytes[i * size..], layout.component, layout.normalized))
        }))
    }

    /// Reads elements of `N` unsigned integers, such as vertex or joint indices. `referrer` is the element that refers to
    /// the accessor.
    pub fn read_u32<const N: usize>(
        &self,
        accessor: usize,
        referrer: Element,
    ) -> Result<Vec<[u32; N]>, GltfError> {
        let layout = self.layout(accessor, N, referrer)?;
        use ComponentType::{U8, U16, U32};
        if !matches!(layout.component, U8 | U16 | U32) {
            let reason = format!("indices must be unsigned integers, it has {:?}", layout.component);
            let error = self.invalid(Element::Accessor(accessor), reason);
            return Err(error.read_by(referrer));
        }
        self.charge(Element::Accessor(accessor), layout.count, 4 * N)?;
        Ok(layout.collect([0; N], |bytes| {
            let size = layout.component.size();
            std::array::from_fn(|i| component_u32(&bytes[i * size..], layout.component))
        }))
    }

    /// Checks everything that reading relies on. Errors name the element that refers to the accessor, and the accessor.
    fn layout(&self, index: usize, width: usize, referrer: Element) -> Result<Layout<'_>, GltfError> {
        let layout = self.checked_layout(index, width, referrer);
        layout.map_err(|error| error.read_by(Element::Accessor(index)).read_by(referrer))
    }

    fn checked_layout(&self, index: usize, width: usize, referrer: Element) -> Result<Layout<'_>, GltfError> {
        let element = Element::Accessor(index);
        let invalid = |reason: String| self.invalid(element, reason);
        let accessor = self
            .root
            .accessors
            .get(index)
            .ok_or_else(|| GltfError::Reference {
                file: self.file.clone(),
                element: referrer,
                target: "accessor",
                index,
                count: self.root.accessors.len(),
            })?;
        let (Checked::Valid(component), Checked::Valid(type_)) = (&accessor.component_type, &accessor.type_)
        else {
            return Err(invalid("its type or component type is unknown".to_owned()));
        };
        if let Some(decoded) = self.decoded.get(&index) {
            return self.decoded_layout(element, decoded, width, accessor.normalized);
        }
        let component = component.0;
        // Matrices of 8-bit and 16-bit numbers have padded columns, which this import does not read.
        let is_plain =
            !matches!(type_, Type::Mat2 | Type::Mat3) && (width != 16 || component == ComponentType::F32);
        if type_.multiplicity() != width || !is_plain {
            return Err(invalid(format!(
                "it holds {type_:?} of {component:?}, {width} numbers each are needed here"
            )));
        }
        let count =
            usize::try_from(accessor.count.0).map_err(|_| invalid("count is too large".to_owned()))?;
        let size = component.size() * width;
        let base = accessor
            .buffer_view
            .map(|view| {
                let offset = accessor.byte_offset.map_or(0, |offset| offset.0);
                self.elements(element, view, offset, count, size, true)
            })
            .transpose()?;
        let sparse = match &accessor.sparse {
            None => None,
            Some(sparse) => {
                let Checked::Valid(index_type) = &sparse.indices.component_type else {
                    return Err(invalid("its sparse index type is unknown".to_owned()));
                };
                let changed = usize::try_from(sparse.count.0)
                    .ok()
                    .filter(|&changed| changed <= count)
                    .ok_or_else(|| {
                        invalid(format!("{} sparse values for {count} elements", sparse.count.0))
                    })?;
                let indices = &sparse.indices;
                let offset = indices.byte_offset.0;
                let index_size = index_type.0.size();
                let places =
                    self.elements(element, indices.buffer_view, offset, changed, index_size, false)?;
                let places: Vec<u32> = (0..changed)
                    .map(|i| component_u32(&places.bytes[i * places.stride..], index_type.0))
                    .collect();
                if let Some(outside) = places.iter().find(|&&place| place as usize >= count) {
                    return Err(invalid(format!(
                        "sparse index {outside} is out of range, it has {count} elements"
                    )));
                }
                let values = &sparse.values;
                let values = self.elements(
                    element,
                    values.buffer_view,
                    values.byte_offset.0,
                    changed,
                    size,
                    false,
                )?;
                Some((places, values))
            }
        };
        Ok(Layout {
            count,
            component,
            width,
            normalized: accessor.normalized,
            base,
            sparse,
        })
    }

    fn decoded_layout<'d>(
        &self,
        element: Element,
        decoded: &'d DecodedAccessor,
        width: usize,
        normalized: bool,
    ) -> Result<Layout<'d>, GltfError> {
        if decoded.width != width {
            let reason = format!(
                "its compressed elements have {} numbers, {width} are needed here",
                decoded.width
            );
            return Err(self.invalid(element, reason));
        }
        Ok(Layout {
            count: decoded.count(),
            component: decoded.component,
            width,
            normalized,
            base: Some(Elements {
                bytes: &decoded.bytes,
                stride: decoded.component.size() * width,
            }),
            sparse: None,
        })
    }

    /// The bytes of `count` elements of `size` bytes each, from the start of the first to the end of the
    /// last.
    fn elements(
        &self,
        element: Element,
        view: Index<gltf::json::buffer::View>,
        offset: u64,
        count: usize,
        size: usize,
        may_be_strided: bool,
    ) -> Result<Elements<'_>, GltfError> {
        let bytes = self.view(element, view)?;
        let stride = match &self.root.buffer_views[view.value()].byte_stride {
            Some(stride) if may_be_strided && stride.0 != 0 => stride.0,
            _ => size,
        };
        if stride < size {
            return Err(self.invalid(
                element,
                format!("byteStride {stride} is less than its element's {size} bytes"),
            ));
        }
        let length = match count {
            0 => Some(0),
            _ => (count - 1)
                .checked_mul(stride)
                .and_then(|before| before.checked_add(size)),
        };
        let range = usize::try_from(offset)
            .ok()
            .zip(length)
            .and_then(|(offset, length)| {
                let end = offset.checked_add(length)?;
                bytes.get(offset..end)
            });
        let bytes = range.ok_or_else(|| {
            let (view, has) = (view.value(), bytes.len());
            let reason =
                format!("{count} elements from byte {offset} run past the end of buffer view {view}, which has {has} bytes");
            self.invalid(element, reason)
        })?;
        Ok(Elements { bytes, stride })
    }
}

impl Layout<'_> {
    fn collect<T: Copy>(&self, zero: T, read: impl Fn(&[u8]) -> T) -> Vec<T> {
        let size = self.component.size() * self.width;
        let at = |elements: &Elements<'_>, i: usize| {
            let start = i * elements.stride;
            read(&elements.bytes[start..start + size])
        };
        let mut values = match &self.base {
            Some(base) => (0..self.count).map(|i| at(base, i)).collect(),
            None => vec![zero; self.count],
        };
        if let Some((places, changed)) = &self.sparse {
            for (i, &place) in places.iter().enumerate() {
                values[place as usize] = at(changed, i);
            }
        }
        values
    }
}
