//! The bytes of buffer views, stored or compressed.

use gltf::json::Index;

use super::accessors::Accessors;
use super::{Element, GltfError, extensions, meshopt};

impl Accessors<'_> {
    /// The bytes of a buffer view that `element` refers to, decompressed if the file has them compressed.
    pub fn view(&self, element: Element, index: Index<gltf::json::buffer::View>) -> Result<&[u8], GltfError> {
        let view = self.get(&self.root.buffer_views, index, element, "buffer view")?;
        let stored = || self.stored(element, index.value());
        let Some((extension, compressed)) = meshopt::Compressed::of(view) else {
            return stored();
        };
        if !meshopt::IS_SUPPORTED
            && let Ok(stored) = stored()
        {
            return Ok(stored); // the fallback that the file offers
        }
        let known = &self.views[index.value()];
        if let Some(bytes) = known.get() {
            return bytes.as_deref().map_or_else(stored, Ok);
        }
        let own = Element::BufferView(index.value());
        let bytes = match self.decompressed(own, compressed, view.byte_length.0) {
            Ok(bytes) => Some(bytes),
            Err(error) if !self.requires(extension) && stored().is_ok() => {
                let mut report = self.uncompressed.borrow_mut();
                extensions::report_broken(&mut report, &self.file, own, extension, &error);
                None
            }
            Err(error) => return Err(error),
        };
        known.get_or_init(|| bytes).as_deref().map_or_else(stored, Ok)
    }

    /// Whether the file requires an extension.
    pub fn requires(&self, extension: &str) -> bool {
        self.root.extensions_required.iter().any(|name| name == extension)
    }

    /// Decompresses the buffer view `own`, which should have `needed` bytes.
    fn decompressed(
        &self,
        own: Element,
        compressed: Result<meshopt::Compressed<'_>, String>,
        needed: u64,
    ) -> Result<Vec<u8>, GltfError> {
        let compressed = compressed.map_err(|reason| self.invalid(own, reason))?;
        let buffer = Index::new(u32::try_from(compressed.buffer).unwrap_or(u32::MAX));
        let (offset, length) = (compressed.offset as u64, compressed.length as u64);
        let source = self.slice(own, own, buffer, offset, length);
        let source = source.map_err(|error| error.read_by(own))?;
        self.charge(own, compressed.count, compressed.stride)?;
        let bytes = compressed.decode(source, needed);
        bytes.map_err(|reason| self.invalid(own, reason))
    }

    /// The bytes of a buffer view as they are stored.
    fn stored(&self, element: Element, index: usize) -> Result<&[u8], GltfError> {
        let view = &self.root.buffer_views[index];
        let offset = view.byte_offset.map_or(0, |offset| offset.0);
        self.slice(
            element,
            Element::BufferView(index),
            view.buffer,
            offset,
            view.byte_length.0,
        )
    }

    /// A range of the bytes of a buffer, which `part` of the file names and `user` reads.
    pub fn slice(
        &self,
        user: Element,
        part: Element,
        buffer: Index<gltf::json::Buffer>,
        offset: u64,
        length: u64,
    ) -> Result<&[u8], GltfError> {
        let buffer_index = buffer.value();
        let bytes = self.get(&self.buffers, buffer, part, "buffer")?;
        let bytes = bytes
            .as_ref()
            .map_err(|reason| self.invalid(Element::Buffer(buffer_index), reason))?;
        let range = offset.checked_add(length).and_then(|end| {
            let range = usize::try_from(offset).ok()?..usize::try_from(end).ok()?;
            bytes.get(range)
        });
        range.ok_or_else(|| {
            let has = bytes.len();
            let reason = format!(
                "{part} ({length} bytes from {offset}) runs past the end of buffer {buffer_index}, which has {has} bytes"
            );
            self.invalid(user, reason)
        })
    }
}
