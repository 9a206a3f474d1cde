//! Errors of the glTF import. Every variant names the file and the element.

use std::path::{Path, PathBuf};

use super::Element;

/// Why a glTF file was not loaded or spawned.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GltfError {
    /// The file itself cannot be read.
    #[error("{}: {source}", file.display())]
    Io {
        /// Path of the glTF file.
        file: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// The GLB container is broken: wrong magic, version, or a chunk that runs past the end.
    #[error("{}: GLB container: {reason}", file.display())]
    Container {
        /// Path of the glTF file.
        file: PathBuf,
        /// Fault of the container, as a phrase.
        reason: String,
    },
    /// The JSON is malformed or does not follow the glTF schema.
    #[error("{}: JSON: {}{source}", file.display(), before(path))]
    Json {
        /// Path of the glTF file.
        file: PathBuf,
        /// Where in the document parsing stopped, such as `accessors[3].count`. Empty if no element was begun.
        path: String,
        /// Where and why parsing stopped.
        source: gltf::json::Error,
    },
    /// The file is not glTF 2.
    #[error("{}: glTF version {} is not supported, 2.0 is (asset version {version:?})", file.display(), shown(version))]
    Version {
        /// Path of the glTF file.
        file: PathBuf,
        /// The value of `asset.minVersion`, or of `asset.version` if that is absent.
        version: String,
    },
    /// The file requires an extension that is not supported, or not by this build.
    #[error("{}: required extension {extension} {}", file.display(), missing(*cargo_feature))]
    Extension {
        /// Path of the glTF file.
        file: PathBuf,
        /// Name of the extension.
        extension: String,
        /// The cargo feature of this crate that supports the extension, if there is one.
        cargo_feature: Option<&'static str>,
    },
    /// An index points past the end of the list that it refers to.
    #[error("{}: {element}: {target} {index} does not exist, the file has {count}", file.display())]
    Reference {
        /// Path of the glTF file.
        file: PathBuf,
        /// The element that holds the index.
        element: Element,
        /// Kind of element to which the index should refer.
        target: &'static str,
        /// The index that is out of range.
        index: usize,
        /// How many elements of that kind exist.
        count: usize,
    },
    /// An element breaks a rule without which it has no meaning.
    #[error("{}: {element}: {reason}", file.display())]
    Invalid {
        /// Path of the glTF file.
        file: PathBuf,
        /// The element that breaks the rule, or one that reads the data of such an element, which the reason then names.
        element: Element,
        /// The rule, and what was found instead.
        reason: String,
    },
    /// A triangle uses a vertex that the primitive does not have.
    #[error("{}: mesh {mesh} primitive {primitive}: index {index} is out of range, it has {vertex_count} vertices",
        file.display())]
    VertexIndex {
        /// Path of the glTF file.
        file: PathBuf,
        /// Index of the mesh.
        mesh: usize,
        /// Index of the primitive within the mesh.
        primitive: usize,
        /// The vertex index that is out of range.
        index: u32,
        /// Number of vertices of the primitive.
        vertex_count: usize,
    },
    /// Decoding would take far more memory than a file of this size can honestly need.
    #[error("{}: {element}: decoding it takes {bytes} bytes, {left} are left of the limit for a file of this size",
        file.display())]
    TooLarge {
        /// Path of the glTF file.
        file: PathBuf,
        /// The element to decode.
        element: Element,
        /// Bytes that decoding the element would take.
        bytes: u64,
        /// Bytes that are left of the limit.
        left: u64,
    },
}

impl GltfError {
    /// Returns the same error with another element: the one that reads the faulty element. The reason then names the latter.
    pub(super) fn read_by(self, reader: Element) -> Self {
        match self {
            Self::Invalid {
                file,
                element,
                reason,
            } if element != reader => Self::Invalid {
                file,
                element: reader,
                reason: format!("{element}: {reason}"),
            },
            other => other,
        }
    }

    /// The message without the file, and without the element and the extension if it begins with them.
    pub(super) fn reason_in(&self, file: &Path, element: Element, extension: &str) -> String {
        let text = self.to_string();
        let mut rest = text.as_str();
        for part in [
            file.display().to_string(),
            element.to_string(),
            extension.to_owned(),
        ] {
            rest = rest.strip_prefix(&format!("{part}: ")).unwrap_or(rest);
        }
        rest.to_owned()
    }
}

fn before(path: &str) -> String {
    if path.is_empty() {
        String::new()
    } else {
        format!("{path}: ")
    }
}

/// The major version, or all of a later minor version.
fn shown(version: &str) -> &str {
    match version.split('.').next() {
        Some(major) if major != "2" => major,
        _ => version,
    }
}

fn missing(cargo_feature: Option<&str>) -> String {
    match cargo_feature {
        Some(feature) => format!("needs antumbra's cargo feature `{feature}`"),
        None => "is not supported".to_owned(),
    }
}
