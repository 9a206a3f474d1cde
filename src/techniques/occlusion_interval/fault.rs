//! Why maps are not used for a light.

use crate::scene::PathError;

/// Why a light's maps are not used. The light then shines without a shadow, or with those of its second technique alone.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum IntervalFault {
    /// The maps cannot be read.
    #[error("its maps cannot be read: {0}")]
    Maps(String),
    /// The path of the light cannot be used.
    #[error("its path cannot be used: {0}")]
    Path(PathError),
    /// The maps are those of another path.
    #[error("its maps were baked for another path; bake them again")]
    OtherPath,
    /// The path moves a light of another kind.
    #[error("the path of its maps is that of a {0} light")]
    OtherKind(&'static str),
    /// Surfaces that were baked are not in the scene.
    #[error(
        "{missing} of the {all} surfaces in its maps are not in the scene, stand elsewhere, or differ in whether they block the light, the first being mesh \"{first}\"; bake the maps again"
    )]
    OtherScene {
        /// Number of surfaces that are missing.
        missing: usize,
        /// Number of surfaces in the maps.
        all: usize,
        /// Name of the first missing mesh.
        first: String,
    },
}

impl IntervalFault {
    /// Number of the fault in reports.
    pub(super) fn code(&self) -> u32 {
        match self {
            Self::Maps(_) => 1,
            Self::Path(_) => 2,
            Self::OtherPath => 3,
            Self::OtherKind(_) => 4,
            Self::OtherScene { .. } => 5,
        }
    }
}
