//! From bytes to JSON: the GLB container, the schema, the version and the required extensions.

use std::path::Path;

use gltf::json::{Error as JsonError, Root, Value, deserialize};

use super::{Element, GltfError, Report, SkipKind};

/// The glTF extensions that the import supports.
pub const SUPPORTED_EXTENSIONS: [&str; 5] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_materials_unlit",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

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
    let root = parse_json(json, report).map_err(|source| GltfError::Json {
        file: file.to_owned(),
        source,
    })?;

    let needed = root.asset.min_version.as_ref().unwrap_or(&root.asset.version);
    if needed.split('.').next() != Some("2") {
        return Err(GltfError::Version {
            file: file.to_owned(),
            version: needed.clone(),
        });
    }
    let supported = |name: &str| SUPPORTED_EXTENSIONS.contains(&name);
    if let Some(extension) = root.extensions_required.iter().find(|name| !supported(name)) {
        return Err(GltfError::Extension {
            file: file.to_owned(),
            extension: extension.clone(),
        });
    }
    for extension in root.extensions_used.iter().filter(|name| !supported(name)) {
        report.add(
            SkipKind::Extension,
            Element::File,
            1,
            format!("{extension} is ignored"),
        );
    }
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

/// Reads the schema. Fields that the specification leaves optional but `gltf::json` requires are filled in on
/// a second try. A good file thus pays nothing, and a bad one reports the line and column of the first error.
fn parse_json(json: &[u8], report: &mut Report) -> Result<Root, JsonError> {
    let first_error = match deserialize::from_slice::<Root>(json) {
        Ok(root) => return Ok(root),
        Err(error) => error,
    };
    let Ok(mut document) = deserialize::from_slice::<Value>(json) else {
        return Err(first_error);
    };
    let mut unknown_targets = Vec::new();
    for scene in array_mut(&mut document, "scenes") {
        if let Some(scene) = scene.as_object_mut() {
            scene.entry("nodes").or_insert_with(|| Value::Array(Vec::new()));
        }
    }
    for (index, animation) in array_mut(&mut document, "animations").iter_mut().enumerate() {
        if let Some(channels) = animation.get_mut("channels").and_then(Value::as_array_mut) {
            let before = channels.len();
            channels.retain(|channel| {
                let target = channel.get("target");
                target.is_some_and(|target| {
                    target.get("node").is_some() && target.get("path").is_some_and(|path| path != "pointer")
                })
            });
            unknown_targets.push((index, before - channels.len()));
        }
    }
    let root = deserialize::from_value(document).map_err(|_| first_error)?;
    for (animation, count) in unknown_targets.into_iter().filter(|&(_, count)| count > 0) {
        let reason = "the target is not a node";
        report.add(
            SkipKind::AnimationChannel,
            Element::Animation(animation),
            count,
            reason,
        );
    }
    Ok(root)
}

fn array_mut<'a>(document: &'a mut Value, key: &str) -> &'a mut [Value] {
    match document.get_mut(key).and_then(Value::as_array_mut) {
        Some(items) => items,
        None => &mut [],
    }
}
