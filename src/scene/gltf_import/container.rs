//! From bytes to a document: the GLB container, the version and the extensions.

use std::path::Path;

use gltf::json::Root;

use super::schema::{SchemaError, is_version_2, parse_json};
use super::{GltfError, Report, extensions};

/// The document and, for GLB, the bytes of its binary chunk.
pub(super) struct Document<'a> {
    pub root: Root,
    pub binary_chunk: Option<&'a [u8]>,
}

/// Parses GLB or JSON bytes. Refuses files that the import cannot show at all.
pub(super) fn parse<'a>(
    bytes: &'a [u8],
    file: &Path,
    report: &mut Report,
) -> Result<Document<'a>, GltfError> {
    let (json, binary_chunk) = if bytes.starts_with(b"glTF") {
        split_glb(bytes).map_err(|reason| GltfError::Container {
            file: file.to_owned(),
            reason,
        })?
    } else {
        (bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes), None)
    };
    let root = parse_json(json, report).map_err(|error| match error {
        SchemaError::Version(version) => GltfError::Version {
            file: file.to_owned(),
            version,
        },
        SchemaError::Json { path, source } => GltfError::Json {
            file: file.to_owned(),
            path,
            source,
        },
    })?;
    // A file of a later minor version can be read as 2.0, unless it says that it needs more.
    let least = root.asset.min_version.as_ref();
    let needed = least.unwrap_or(&root.asset.version);
    if !is_version_2(needed) || least.is_some_and(|least| least != "2.0") {
        return Err(GltfError::Version {
            file: file.to_owned(),
            version: needed.clone(),
        });
    }
    extensions::check(&root, file, report)?;
    Ok(Document { root, binary_chunk })
}

/// Splits a GLB file into its JSON chunk and its first binary chunk. Source: glTF 2.0 §4.4, "Binary glTF
/// Layout".
fn split_glb(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at: usize| {
        let field = bytes.get(at..at.checked_add(4)?)?;
        Some(u32::from_le_bytes(field.try_into().ok()?))
    };
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(format!("the header has 12 bytes, the file has {}", bytes.len()));
    };
    if version != 2 {
        return Err(format!("version {version} is not supported, 2 is"));
    }
    let length = length as usize;
    if length > bytes.len() {
        return Err(format!(
            "the header says {length} bytes, the file has {}",
            bytes.len()
        ));
    }
    let mut json = None;
    let mut binary = None;
    let mut at = 12;
    let mut chunk_index = 0;
    while at < length {
        let (Some(chunk_length), Some(kind)) = (word(at), bytes.get(at + 4..at + 8)) else {
            return Err(format!("chunk {chunk_index} is cut short"));
        };
        let start = at + 8;
        let end = start.saturating_add(chunk_length as usize);
        let Some(chunk) = bytes[..length].get(start..end) else {
            let left = length.saturating_sub(start);
            return Err(format!(
                "chunk {chunk_index} says {chunk_length} bytes, {left} are left"
            ));
        };
        match kind {
            b"JSON" if chunk_index == 0 => json = Some(chunk),
            b"BIN\0" if binary.is_none() => binary = Some(chunk),
            _ => {} // unknown chunks must be ignored
        }
        at = end;
        chunk_index += 1;
    }
    match json {
        Some(json) => Ok((json, binary)),
        None => Err("the first chunk is not JSON".to_owned()),
    }
}
