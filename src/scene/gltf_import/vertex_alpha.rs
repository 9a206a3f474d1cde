//! The alpha of vertex colours under materials that become blended although the file calls them opaque or masked.

use glam::Vec4;

/// The effect of the vertex colours' alpha on the surface of a material.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum VertexAlpha {
    /// It multiplies the alpha of the surface, as in every material whose mode is that of the file.
    #[default]
    Multiplies,
    /// It has no meaning, because the file calls the surface opaque.
    Ignored,
    /// The surface is absent where the product with `base` is below `cutoff`.
    Cut {
        /// Alpha of the base colour.
        base: f32,
        /// Least alpha of what is there.
        cutoff: f32,
    },
    /// A texture decides together with it where the surface is absent. The import keeps the texture's part alone.
    CutWithTexture,
}

impl VertexAlpha {
    /// Writes into the colours what their alpha means once the material is blended. Returns the number of vertices whose
    /// alpha is lost.
    pub fn apply(self, colors: &mut [Vec4]) -> usize {
        let mut lost = 0;
        for color in colors {
            color.w = match self {
                Self::Multiplies => color.w,
                Self::Ignored => 1.0,
                Self::Cut { base, cutoff } => f32::from(base * color.w >= cutoff),
                Self::CutWithTexture => {
                    lost += usize::from(color.w != 1.0);
                    1.0
                }
            };
        }
        lost
    }
}
