//! The component that gives a light a profile.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use bevy_ecs::prelude::*;
#[cfg(feature = "bevy")]
use bevy_ecs::reflect::ReflectComponent;

use super::error::ProfileError;
use super::table::ProfileTable;
use super::{eulumdat, ies};

/// Scales a light by direction, as measured: a profile of a luminaire from an IES (LM-63) or EULUMDAT file.
///
/// The profile is relative: it is 1 in the brightest direction of the file. So the light's intensity stays its
/// luminous intensity in that direction, candela, and another profile changes the shape of the light alone. To get
/// the intensity that was measured, set the light's intensity to [`LightProfile::brightest`] with a white colour.
///
/// The light's local −Z is the direction in which the luminaire aims, which is straight down for a luminaire on a
/// ceiling. The plane C0 lies along local +X and the plane C90 along local +Y.
///
/// Between the measured angles the intensity is linear in both angles; outside of them the light is dark. A spot
/// light is dimmed by its cone as well, and a rectangle by its cosine. A directional light has no profile, because all
/// of its light has one direction.
#[derive(Component, Clone, Debug)]
#[cfg_attr(
    feature = "bevy",
    derive(bevy_reflect::Reflect),
    reflect(opaque, Component, Debug, Clone, PartialEq)
)]
pub struct LightProfile {
    table: Arc<ProfileTable>,
}

/// Why a file gives no profile.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LoadProfileError {
    /// The file cannot be read.
    #[error("{}: {error}", path.display())]
    Read {
        /// Path of the file.
        path: PathBuf,
        /// Why the file cannot be read.
        #[source]
        error: std::io::Error,
    },
    /// The ending of the file's name is none of those of profiles.
    #[error("{}: its name must end in .ies for IES or in .ldt for EULUMDAT", path.display())]
    Ending {
        /// Path of the file.
        path: PathBuf,
    },
    /// The text of the file is wrong.
    #[error("{}: {error}", path.display())]
    Text {
        /// Path of the file.
        path: PathBuf,
        /// What is wrong, and in which line.
        error: ProfileError,
    },
}

impl PartialEq for LightProfile {
    /// Profiles are equal if they share one table.
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.table, &other.table)
    }
}

impl LightProfile {
    /// Reads the text of an IES file (LM-63 of 1986 to 2019; photometry of type A, B or C).
    ///
    /// # Errors
    /// [`ProfileError`] names the line and says what is wrong there.
    pub fn from_ies(text: &str) -> Result<Self, ProfileError> {
        ies::read(text).map(Self::new)
    }

    /// Reads the text of a EULUMDAT file.
    ///
    /// # Errors
    /// [`ProfileError`] names the line and says what is wrong there.
    pub fn from_eulumdat(text: &str) -> Result<Self, ProfileError> {
        eulumdat::read(text).map(Self::new)
    }

    /// Reads a file. The ending of its name says the format: `.ies` is IES, `.ldt` or `.eul` is EULUMDAT.
    ///
    /// # Errors
    /// [`LoadProfileError`] names the file and, if its text is wrong, the line.
    pub fn load(path: &Path) -> Result<Self, LoadProfileError> {
        let ending = path.extension().unwrap_or_default().to_ascii_lowercase();
        let read = match ending.to_str() {
            Some("ies") => Self::from_ies,
            Some("ldt" | "eul") => Self::from_eulumdat,
            _ => {
                return Err(LoadProfileError::Ending {
                    path: path.to_owned(),
                });
            }
        };
        let bytes = std::fs::read(path).map_err(|error| LoadProfileError::Read {
            path: path.to_owned(),
            error,
        })?;
        // Names of manufacturers are in any encoding; the numbers are ASCII.
        read(&String::from_utf8_lossy(&bytes)).map_err(|error| LoadProfileError::Text {
            path: path.to_owned(),
            error,
        })
    }

    /// Relative intensity by direction.
    pub fn table(&self) -> &Arc<ProfileTable> {
        &self.table
    }

    /// Intensity of the brightest direction in the file, candela.
    pub fn brightest(&self) -> f32 {
        self.table.brightest()
    }

    fn new(table: ProfileTable) -> Self {
        Self {
            table: Arc::new(table),
        }
    }
}
