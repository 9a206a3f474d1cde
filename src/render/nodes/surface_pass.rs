//! The passes that draw surfaces.

use crate::render::recorder::ShadowKind;

/// A pass that draws surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfacePass {
    /// Ambient and emissive light and depth.
    Ambient,
    /// The same for a blended surface, over what is behind.
    AmbientBlended,
    /// One light, where the stencil says lit.
    Light,
    /// One light times its mask.
    LightMasked,
    /// One light on a blended surface.
    LightBlended,
    /// The same, but not on the front layer.
    LightBehindFront,
    /// Depth of a blended surface.
    FrontDepth,
    /// One light on the front layer, where the stencil says lit.
    FrontLight,
    /// One light times its mask on the front layer.
    FrontLightMasked,
    /// Writes 0 where the stencil says shadowed.
    Visibility,
    /// Writes the mask.
    VisibilityMasked,
    /// Writes 1, where the front layer hides what was there.
    VisibilityFront,
    /// Writes 0 wherever the surface is seen: objects that the light does not see.
    Dark,
    /// Writes the plane of the triangle.
    ReceiverPlane,
    /// One light times its mask, on surfaces that show no shadows as well: a function scales it.
    LightScaled,
    /// The same on the front layer.
    FrontLightScaled,
    /// Writes a mask of 1.
    WholeMask,
    /// Depth, where a host shows the surface.
    HostSurface,
}

impl SurfacePass {
    /// How many there are.
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
            Self::WholeMask => "whole mask",
            Self::HostSurface => "host surface",
        }
    }

    /// The pass that adds a light whose technique leaves this.
    pub fn light(visibility: Option<ShadowKind>) -> Self {
        match visibility {
            Some(ShadowKind::Mask) => Self::LightMasked,
            Some(ShadowKind::Stencil) | None => Self::Light,
        }
    }

    /// The pass that adds such a light to the front layer.
    pub fn front_light(visibility: ShadowKind) -> Self {
        match visibility {
            ShadowKind::Mask => Self::FrontLightMasked,
            ShadowKind::Stencil => Self::FrontLight,
        }
    }

    /// The pass that shows the visibility of a light whose technique leaves this.
    pub fn visibility(visibility: ShadowKind) -> Self {
        match visibility {
            ShadowKind::Mask => Self::VisibilityMasked,
            ShadowKind::Stencil => Self::Visibility,
        }
    }
}
