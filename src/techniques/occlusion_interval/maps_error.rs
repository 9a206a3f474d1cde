//! Errors of maps on disk.

use std::path::{Path, PathBuf};

/// Why maps cannot be read or written. Variants name the file and the element.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum MapsError {
    /// The file cannot be read or written.
    #[error("{}: {error}", file.display())]
    File {
        /// The file.
        file: PathBuf,
        /// Message of the operating system.
        error: std::io::Error,
    },
    /// The manifest is no JSON, or lacks something.
    #[error("{}: {error}", file.display())]
    Manifest {
        /// The manifest.
        file: PathBuf,
        /// What is wrong, and where.
        error: serde_json::Error,
    },
    /// The file is a picture that cannot be decoded or encoded.
    #[error("{}: {error}", file.display())]
    Picture {
        /// The picture.
        file: PathBuf,
        /// What is wrong.
        error: image::ImageError,
    },
    /// The file holds something else than it should.
    #[error("{}: {element}: {problem}", file.display())]
    Content {
        /// The file.
        file: PathBuf,
        /// The part of the file.
        element: String,
        /// Description of the fault.
        problem: String,
    },
}

/// The error of a part of a file.
pub(super) fn content(file: &Path, element: impl Into<String>, problem: impl Into<String>) -> MapsError {
    MapsError::Content {
        file: file.to_owned(),
        element: element.into(),
        problem: problem.into(),
    }
}
