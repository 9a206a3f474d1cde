//! Sources of bytes: the binary chunk, data URIs and external files.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::Path;

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use gltf::json::Root;

/// Decoder that accepts base64 with and without padding, because exporters differ.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// The bytes of a buffer, exactly `byteLength` of them, or why there are none.
pub(super) type BufferBytes<'a> = Result<Cow<'a, [u8]>, String>;

/// The bytes of every buffer. A buffer that cannot be read is an error only where something reads it: exporters leave
/// placeholders without a URI, for decompressed data and for binary chunks that they wrote elsewhere.
pub(super) fn load<'a>(
    root: &Root,
    binary_chunk: Option<&'a [u8]>,
    base_dir: Option<&Path>,
) -> Vec<BufferBytes<'a>> {
    let buffers = root.buffers.iter().enumerate().map(|(index, buffer)| {
        let length = buffer.byte_length.0;
        let bytes = match (&buffer.uri, binary_chunk) {
            (Some(uri), _) => read_uri(uri, base_dir, Some(length)).map(Cow::Owned),
            (None, Some(chunk)) if index == 0 => Ok(Cow::Borrowed(chunk)),
            (None, _) => Err("it has no URI and there is no binary chunk for it".to_owned()),
        };
        let bytes = bytes?;
        let has = bytes.len() as u64;
        if has < length {
            return Err(format!("byteLength is {length}, {has} bytes are there"));
        }
        Ok(match bytes {
            Cow::Borrowed(bytes) => Cow::Borrowed(&bytes[..length as usize]),
            Cow::Owned(mut bytes) => {
                bytes.truncate(length as usize);
                Cow::Owned(bytes)
            }
        })
    });
    buffers.collect()
}

/// Reads a data URI, or at most `limit` bytes of a file beside the glTF file. The error states the reason.
pub(super) fn read_uri(uri: &str, base_dir: Option<&Path>, limit: Option<u64>) -> Result<Vec<u8>, String> {
    if let Some(data) = data_of(uri) {
        return decode_data_uri(data);
    }
    // A scheme consists of letters before a colon. Schemes other than `data` point outside the file system.
    if let Some((scheme, _)) = uri.split_once(':')
        && scheme
            .chars()
            .all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
    {
        return Err(format!("URI scheme {scheme:?} is not supported"));
    }
    let Some(base_dir) = base_dir else {
        return Err(format!("it refers to {uri:?}, but there is no folder to look in"));
    };
    let decoded = percent_encoding::percent_decode_str(uri).decode_utf8_lossy();
    let mut path = base_dir.join(&*decoded);
    if !path.exists() && base_dir.join(uri).exists() {
        path = base_dir.join(uri); // the name has a percent sign and was written without encoding
    }
    let read = || -> std::io::Result<Vec<u8>> {
        // Reading a pipe or a device might never end.
        if !std::fs::metadata(&path)?.is_file() {
            return Err(std::io::Error::other("not a file"));
        }
        let mut bytes = Vec::new();
        File::open(&path)?
            .take(limit.unwrap_or(u64::MAX))
            .read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    read().map_err(|error| format!("cannot read {}: {error}", path.display()))
}

/// Returns the part of a data URI after `data:`; `None` for other URIs. Schemes have no case (RFC 3986 §3.1).
pub(super) fn data_of(uri: &str) -> Option<&str> {
    let (scheme, data) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("data").then_some(data)
}

/// Decodes the part of a data URI after `data:`. Source: RFC 2397.
fn decode_data_uri(data: &str) -> Result<Vec<u8>, String> {
    let (head, payload) = data.split_once(',').ok_or("the data URI has no comma")?;
    let bytes = percent_encoding::percent_decode_str(payload);
    let is_base64 = head
        .rsplit_once(';')
        .is_some_and(|(_, last)| last.eq_ignore_ascii_case("base64"));
    if is_base64 {
        let text: Cow<'_, [u8]> = bytes.into();
        BASE64
            .decode(&*text)
            .map_err(|error| format!("the data URI is not base64: {error}"))
    } else {
        Ok(bytes.collect())
    }
}
