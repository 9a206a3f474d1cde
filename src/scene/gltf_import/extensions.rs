//! The extensions of glTF: which are supported, and what becomes of the others.

use std::collections::BTreeMap;
use std::path::Path;

use gltf::json::{Root, Value};

use super::clearcoat::CLEARCOAT;
use super::{Element, GltfError, Report, SkipKind};

/// The glTF extensions that the import supports with the cargo features of this build.
pub const SUPPORTED_EXTENSIONS: &[&str] = &[
    INSTANCING,
    #[cfg(feature = "gltf-meshopt")]
    MESHOPT_EXT,
    #[cfg(feature = "gltf-webp")]
    WEBP,
    #[cfg(feature = "gltf-draco")]
    DRACO,
    "KHR_lights_punctual",
    CLEARCOAT,
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_pbrSpecularGlossiness",
    "KHR_materials_transmission",
    "KHR_materials_unlit",
    "KHR_materials_volume",
    "KHR_mesh_quantization",
    #[cfg(feature = "gltf-meshopt")]
    MESHOPT_KHR,
    NODE_VISIBILITY,
    #[cfg(feature = "gltf-basisu")]
    BASISU,
    "KHR_texture_transform",
];

/// The extension of compressed meshes.
pub(super) const DRACO: &str = "KHR_draco_mesh_compression";
/// The extension of compressed buffer views, as it was before Khronos took it over.
pub(super) const MESHOPT_EXT: &str = "EXT_meshopt_compression";
/// The extension of compressed buffer views.
pub(super) const MESHOPT_KHR: &str = "KHR_meshopt_compression";
/// The extension of WebP pictures.
pub(super) const WEBP: &str = "EXT_texture_webp";
/// The extension of KTX2 pictures with Basis Universal.
pub(super) const BASISU: &str = "KHR_texture_basisu";
/// The extension of hidden nodes.
pub(super) const NODE_VISIBILITY: &str = "KHR_node_visibility";
/// The extension of meshes that are placed many times.
pub(super) const INSTANCING: &str = "EXT_mesh_gpu_instancing";

/// The cargo feature that reads an extension, for those extensions that need one.
pub(super) fn cargo_feature(extension: &str) -> Option<&'static str> {
    match extension {
        DRACO => Some("gltf-draco"),
        MESHOPT_EXT | MESHOPT_KHR => Some("gltf-meshopt"),
        WEBP => Some("gltf-webp"),
        BASISU => Some("gltf-basisu"),
        _ => None,
    }
}

/// Says why an extension is not read, as the end of a sentence.
pub(super) fn why_unread(extension: &str) -> String {
    match cargo_feature(extension) {
        Some(feature) => format!("which needs antumbra's cargo feature `{feature}`"),
        None => "which is not supported".to_owned(),
    }
}

/// An index, count or size in an extension that `gltf::json` leaves unparsed. Some exporters write whole numbers with a
/// fraction of zero.
pub(super) fn whole_number(value: Option<&Value>) -> Option<usize> {
    let value = value?;
    let whole = value.as_u64().or_else(|| {
        let number = value.as_f64()?;
        (number.fract() == 0.0 && (0.0..9e15).contains(&number)).then_some(number as u64)
    });
    usize::try_from(whole?).ok()
}

/// Reports an element whose data is read uncompressed because that of an extension is broken.
pub(super) fn report_broken(
    report: &mut Report,
    file: &Path,
    element: Element,
    extension: &str,
    error: &GltfError,
) {
    let reason = error.reason_in(file, element, extension);
    let reason = format!("{extension} is broken, the uncompressed data is read instead: {reason}");
    report.add(SkipKind::Extension, element, 1, reason);
}

/// Refuses extensions that the file requires and the import lacks. Reports the others that it uses, whether it
/// declares them or not.
pub(super) fn check(root: &Root, file: &Path, report: &mut Report) -> Result<(), GltfError> {
    let supported = |name: &str| SUPPORTED_EXTENSIONS.contains(&name);
    if let Some(extension) = root.extensions_required.iter().find(|name| !supported(name)) {
        return Err(GltfError::Extension {
            file: file.to_owned(),
            extension: extension.clone(),
            cargo_feature: cargo_feature(extension),
        });
    }
    let mut ignored: BTreeMap<&str, usize> = BTreeMap::new();
    for name in root.extensions_used.iter().filter(|name| !supported(name)) {
        ignored.entry(name).or_default();
    }
    for name in unparsed(root).filter(|name| !supported(name)) {
        *ignored.entry(name).or_default() += 1;
    }
    for (name, uses) in ignored {
        let needs = cargo_feature(name).map_or_else(String::new, |feature| {
            format!(": it needs antumbra's cargo feature `{feature}`")
        });
        let places = if uses > 0 {
            format!(" ({uses} elements have it)")
        } else {
            String::new()
        };
        report.add(
            SkipKind::Extension,
            Element::File,
            1,
            format!("{name} is ignored{places}{needs}"),
        );
    }
    Ok(())
}

/// The names of all extension objects on the elements that commonly have some.
fn unparsed(root: &Root) -> impl Iterator<Item = &str> {
    let nodes = root
        .nodes
        .iter()
        .filter_map(|node| Some(&node.extensions.as_ref()?.others));
    let materials = root
        .materials
        .iter()
        .filter_map(|material| Some(&material.extensions.as_ref()?.others));
    let textures = root
        .textures
        .iter()
        .filter_map(|texture| Some(&texture.extensions.as_ref()?.others));
    let views = root
        .buffer_views
        .iter()
        .filter_map(|view| Some(&view.extensions.as_ref()?.others));
    let primitives = root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let primitives = primitives.filter_map(|primitive| Some(&primitive.extensions.as_ref()?.others));
    nodes
        .chain(materials)
        .chain(textures)
        .chain(views)
        .chain(primitives)
        .flat_map(|others| others.keys().map(String::as_str))
}
