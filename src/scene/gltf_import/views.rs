//! The bytes of buffer views, stored or compressed.

use gltf::json::Index;

use super::accessors::Accessors;
use super::{Element, GltfError, meshopt};

impl Accessors<'_> {
    /// The bytes of a buffer view that `element` refers to, decompressed if the file has them compressed.
    pub fn view(&self, element: Element, index: Index<gltf::json::buffer::View>) -> Result<&[u8], GltfError> {
        let view = self.get(&self.root.buffer_views, index, element, "buffer view")?;
        let Some(compressed) = meshopt::Compressed::of(view) else {
            return self.stored(element, index.value());
        };
        if !meshopt::IS_SUPPORTED && self.stored(element, index.value()).is_ok() {
            return self.stored(element, index.value()); // the fallback that the file offers
        }
        let known = &self.views[index.value()];
        if let Some(bytes) = known.get() {
            return Ok(bytes);
        }
        let own = Element::BufferView(index.value());
        let compressed = compressed.map_err(|reason| self.invalid(own, reason))?;
        let buffer = Index::new(u32::try_from(compressed.buffer).unwrap_or(u32::MAX));
        let source = self.slice(
            own,
            own,
            buffer,
            compressed.offset as u64,
            compressed.length as u64,
        )?;
        self.charge(own, compressed.count, compressed.stride)?;
        let bytes = compressed.decode(source, view.byte_length.0);
        let bytes = bytes.map_err(|reason| self.invalid(own, reason))?;
        Ok(known.get_or_init(|| bytes))
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
