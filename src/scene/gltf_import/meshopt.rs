//! Buffer views that are compressed by `EXT_meshopt_compression` or `KHR_meshopt_compression`.
//!
//! The bytes that a view should have come out of another range, which the extension names. Some files fill the view's own
//! range as well. It is read without the cargo feature `gltf-meshopt`, and where the compressed bytes are broken, unless the
//! file requires the extension.

use gltf::json::Value;
use gltf::json::buffer::View;

use super::extensions::{MESHOPT_EXT, MESHOPT_KHR, whole_number};

/// Whether this build decompresses.
pub(super) const IS_SUPPORTED: bool = cfg!(feature = "gltf-meshopt");

/// Contents of the extension object of a compressed buffer view.
pub(super) struct Compressed<'a> {
    extension: &'static str,
    /// The buffer that holds the compressed bytes, and their range in it.
    pub buffer: usize,
    pub offset: usize,
    pub length: usize,
    /// Number of elements.
    pub count: usize,
    /// Size of an element, bytes.
    pub stride: usize,
    mode: &'a str,
    filter: &'a str,
}

impl<'a> Compressed<'a> {
    /// The name of the extension by which a view is compressed, and its object. `None` if the view is not compressed.
    ///
    /// # Errors
    /// A sentence about what has no meaning in the object.
    pub fn of(view: &'a View) -> Option<(&'static str, Result<Self, String>)> {
        let others = &view.extensions.as_ref()?.others;
        [MESHOPT_KHR, MESHOPT_EXT].into_iter().find_map(|extension| {
            let object = others.get(extension)?;
            Some((extension, Self::read(extension, object)))
        })
    }

    fn read(extension: &'static str, object: &'a Value) -> Result<Self, String> {
        let number = |key: &str| {
            whole_number(object.get(key)).ok_or_else(|| format!("{extension}: {key} is not a whole number"))
        };
        let text = |key: &str| object.get(key).and_then(Value::as_str);
        Ok(Self {
            extension,
            buffer: number("buffer")?,
            offset: object.get("byteOffset").map_or(Ok(0), |_| number("byteOffset"))?,
            length: number("byteLength")?,
            count: number("count")?,
            stride: number("byteStride")?,
            mode: text("mode").unwrap_or_default(),
            filter: text("filter").unwrap_or("NONE"),
        })
    }

    /// The bytes that the view should have, at least `needed`, from the compressed ones.
    ///
    /// # Errors
    /// A sentence about compressed bytes that are broken or have no meaning, or a build that does not decompress.
    pub fn decode(&self, source: &[u8], needed: u64) -> Result<Vec<u8>, String> {
        let of_extension = |reason: String| format!("{}: {reason}", self.extension);
        let bytes = decompress(self, source).map_err(of_extension)?;
        if (bytes.len() as u64) < needed {
            let has = bytes.len();
            return Err(of_extension(format!("it has {has} bytes, the view has {needed}")));
        }
        Ok(bytes)
    }
}

#[cfg(not(feature = "gltf-meshopt"))]
fn decompress(compressed: &Compressed<'_>, _source: &[u8]) -> Result<Vec<u8>, String> {
    let _ = (compressed.mode, compressed.filter);
    Err(super::extensions::why_unread(MESHOPT_EXT))
}

#[cfg(feature = "gltf-meshopt")]
use decoder::decompress;

#[cfg(feature = "gltf-meshopt")]
mod decoder {
    use meshopt::{
        decode_filter_color, decode_filter_exp, decode_filter_oct, decode_filter_quat, decode_index_buffer,
        decode_index_sequence, decode_vertex_buffer,
    };

    use super::Compressed;

    /// Source: glTF extension `KHR_meshopt_compression`, sections "Specifying compressed views" and "Filters".
    pub(super) fn decompress(compressed: &Compressed<'_>, source: &[u8]) -> Result<Vec<u8>, String> {
        let &Compressed {
            count,
            stride,
            mode,
            filter,
            ..
        } = compressed;
        let broken = |error: meshopt::Error| format!("the compressed bytes are broken: {error}");
        if mode != "ATTRIBUTES" && filter != "NONE" {
            return Err(format!("filter {filter} cannot be used with mode {mode}"));
        }
        match (mode, stride) {
            ("ATTRIBUTES", _) if stride > 0 && stride <= 256 && stride.is_multiple_of(4) => {
                let bytes = vertices(source, count, stride).map_err(broken)?;
                filtered(bytes, filter, stride)
            }
            ("TRIANGLES", 2) if count.is_multiple_of(3) => decode_index_buffer::<u16>(source, count)
                .map(|indices| indices.iter().flat_map(|index| index.to_le_bytes()).collect())
                .map_err(broken),
            ("TRIANGLES", 4) if count.is_multiple_of(3) => decode_index_buffer::<u32>(source, count)
                .map(|indices| indices.iter().flat_map(|index| index.to_le_bytes()).collect())
                .map_err(broken),
            ("INDICES", 2) => decode_index_sequence::<u16>(source, count)
                .map(|indices| indices.iter().flat_map(|index| index.to_le_bytes()).collect())
                .map_err(broken),
            ("INDICES", 4) => decode_index_sequence::<u32>(source, count)
                .map(|indices| indices.iter().flat_map(|index| index.to_le_bytes()).collect())
                .map_err(broken),
            _ => Err(format!(
                "mode {mode:?} cannot have {count} elements of {stride} bytes"
            )),
        }
    }

    /// An element of `N` words. Arrays of more than 32 words have no default of their own.
    #[derive(Clone)]
    struct Words<const N: usize>([u32; N]);

    impl<const N: usize> Default for Words<N> {
        fn default() -> Self {
            Self([0; N])
        }
    }

    fn words<const N: usize>(source: &[u8], count: usize) -> Result<Vec<u8>, meshopt::Error> {
        let elements = decode_vertex_buffer::<Words<N>>(source, count)?;
        // The decoder writes bytes, so that each word is in the machine's own order.
        let bytes = elements
            .iter()
            .flat_map(|element| &element.0)
            .flat_map(|word| word.to_ne_bytes());
        Ok(bytes.collect())
    }

    /// Elements of `stride` bytes. The size of an element is a type for the decoder, so there is one call for each.
    fn vertices(source: &[u8], count: usize, stride: usize) -> Result<Vec<u8>, meshopt::Error> {
        macro_rules! by_size {
            ($($words:literal)*) => {
                match stride / 4 {
                    $($words => words::<$words>(source, count),)*
                    _ => words::<64>(source, count),
                }
            };
        }
        by_size!(1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20 21 22 23 24 25 26 27 28 29 30 31 32 33 34 35 36 37
            38 39 40 41 42 43 44 45 46 47 48 49 50 51 52 53 54 55 56 57 58 59 60 61 62 63)
    }

    fn filtered(bytes: Vec<u8>, filter: &str, stride: usize) -> Result<Vec<u8>, String> {
        match (filter, stride) {
            ("NONE", _) => Ok(bytes),
            ("OCTAHEDRAL", 4) => Ok(by_element(
                &bytes,
                |[byte]| i8::from_ne_bytes([byte]),
                decode_filter_oct,
                |x| x.to_ne_bytes(),
            )),
            ("OCTAHEDRAL", 8) => Ok(by_element(
                &bytes,
                i16::from_ne_bytes,
                decode_filter_oct,
                i16::to_ne_bytes,
            )),
            ("QUATERNION", 8) => Ok(by_element(
                &bytes,
                i16::from_ne_bytes,
                decode_filter_quat,
                i16::to_ne_bytes,
            )),
            ("COLOR", 4) => Ok(by_element(
                &bytes,
                |[byte]| byte,
                decode_filter_color,
                |byte: u8| [byte],
            )),
            ("COLOR", 8) => Ok(by_element(
                &bytes,
                u16::from_ne_bytes,
                decode_filter_color,
                u16::to_ne_bytes,
            )),
            ("EXPONENTIAL", _) => Ok(by_element::<u32, 4, 1>(
                &bytes,
                u32::from_ne_bytes,
                decode_filter_exp,
                u32::to_ne_bytes,
            )),
            _ => Err(format!(
                "filter {filter:?} is unknown for elements of {stride} bytes"
            )),
        }
    }

    /// Calls a filter on bytes as elements of `N` components of `SIZE` bytes.
    fn by_element<T: Copy + Default, const SIZE: usize, const N: usize>(
        bytes: &[u8],
        from: impl Fn([u8; SIZE]) -> T,
        filter: impl Fn(&mut [[T; N]]),
        to: impl Fn(T) -> [u8; SIZE],
    ) -> Vec<u8> {
        let components = bytes.as_chunks::<SIZE>().0.iter().map(|&bytes| from(bytes));
        let components: Vec<T> = components.collect();
        let mut elements: Vec<[T; N]> = components.as_chunks::<N>().0.to_vec();
        filter(&mut elements);
        elements
            .iter()
            .flatten()
            .flat_map(|&component| to(component))
            .collect()
    }
}
