//! The passes that draw surfaces.

use crate::render::recorder::ShadowKind;

/// A pass that draws surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfacePass {
    /// Draws ambient and emissive light, and depth.
    Ambient,
    /// Draws ambient and emissive light of a blended surface, over what lies behind it.
    AmbientBlended,
    /// Adds one light where the stencil says lit.
    Light,
    /// Adds one light times its mask.
    LightMasked,
    /// Adds one light to a blended surface, without shadows.
    LightBlended,
    /// Adds one light to a blended surface, without shadows, except on the front layer.
    LightBehindFront,
    /// Draws the depth of a blended surface.
    FrontDepth,
    /// Adds one light to the front layer, where the stencil says lit.
    FrontLight,
    /// Adds one light times its mask to the front layer.
    FrontLightMasked,
    /// Writes a visibility of 0 where the stencil says shadowed.
    Visibility,
    /// Writes the mask as visibility.
    VisibilityMasked,
    /// Writes a visibility of 1 on the front layer, over the visibility of the surfaces behind it.
    VisibilityFront,
    /// Writes a visibility of 0 on surfaces of objects that the light does not see.
    Dark,
    /// Writes the plane of the triangle that each pixel shows.
    ReceiverPlane,
    /// Adds one light times its mask, also to surfaces that show no shadows, because a function scales the
    /// light.
    LightScaled,
    /// Adds one light times its mask to the front layer, also to surfaces that show no shadows, because a
    /// function scales the light.
    FrontLightScaled,
    /// Adds one light whose shadow has a colour, by its mask and by the mask of its functions.
    LightTinted,
    /// Adds one light whose shadow has a colour to the front layer, by its mask and by the mask of its functions.
    FrontLightTinted,
    /// Writes 1 into the mask.
    WholeMask,
    /// Darkens the mask by that of a companion.
    DarkerMask,
    /// Adds 1 to the number of lights.
    LightCount,
    /// Draws depth where a host shows the surface.
    HostSurface,
}

impl SurfacePass {
    /// The number of passes that draw surfaces.
    pub const COUNT: usize = Self::HostSurface as usize + 1;

    /// The name that debuggers show.
    pub const fn label(self) -> &'static str {
        match self {
            Self::Ambient => "ambient",
            Self::AmbientBlended => "ambient blended",
            Self::Light => "light",
            Self::LightMasked => "light masked",
            Self::LightBlended => "light blended",
            Self::LightBehindFront => "light behind front",
            Self::FrontDepth => "front depth",
            Self::FrontLight => "front light",
            Self::FrontLightMasked => "front light masked",
            Self::Visibility => "visibility",
            Self::VisibilityMasked => "visibility masked",
            Self::VisibilityFront => "visibility front",
            Self::Dark => "dark",
            Self::ReceiverPlane => "receiver plane",
            Self::LightScaled => "light scaled",
            Self::FrontLightScaled => "front light scaled",
            Self::LightTinted => "light tinted",
            Self::FrontLightTinted => "front light tinted",
            Self::WholeMask => "whole mask",
            Self::DarkerMask => "darker mask",
            Self::LightCount => "light count",
            Self::HostSurface => "host surface",
        }
    }

    /// Returns the pass that adds a light to opaque surfaces, by the kind of result of its technique.
    pub fn light(visibility: Option<ShadowKind>) -> Self {
        match visibility {
            Some(ShadowKind::Mask) => Self::LightMasked,
            Some(ShadowKind::Stencil) | None => Self::Light,
        }
    }

    /// Returns the pass that adds a light to the front layer, by the kind of result of its technique.
    pub fn front_light(visibility: ShadowKind) -> Self {
        match visibility {
            ShadowKind::Mask => Self::FrontLightMasked,
            ShadowKind::Stencil => Self::FrontLight,
        }
    }

    /// Returns the pass that shows the visibility of a light, by the kind of result of its technique.
    pub fn visibility(visibility: ShadowKind) -> Self {
        match visibility {
            ShadowKind::Mask => Self::VisibilityMasked,
            ShadowKind::Stencil => Self::Visibility,
        }
    }
}
