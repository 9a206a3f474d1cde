//! The inputs of volumes, kept to find out which lights may keep their volumes.
//!
//! | input | how a change is noticed |
//! | --- | --- |
//! | the light, its sets and region, the view, its objects | [`is_recomputed`](crate::sets::FrameLight::is_recomputed) |
//! | how the view stores depth, occluders before the camera, what hides near caps | [`SharedInputs`] |
//! | settings and silhouettes of the light | [`LightInputs`] |

use super::component::StencilVolume;
use crate::sets::{CameraOcclusion, ViewData, ViewDepth};
use crate::techniques::shared::near_caps::{KeptNearCaps, NearCaps};

/// The inputs of a frame's volumes that all lights share, as far as they may change while no light is computed again.
#[derive(Clone, Debug, Default)]
pub(super) struct SharedInputs {
    /// Depth of an orthographic view, which changes after volumes are built.
    depth: Option<ViewDepth>,
    occlusion: u64,
    near_caps: KeptNearCaps,
}

impl SharedInputs {
    /// Takes over the inputs of this frame, and returns whether they are those of the frame before.
    pub(super) fn follow(
        &mut self,
        view: &ViewData,
        occlusion: &CameraOcclusion,
        near_caps: &NearCaps,
    ) -> bool {
        let now = (Some(view.depth), occlusion.generation);
        let is_same = (self.depth, self.occlusion) == now;
        (self.depth, self.occlusion) = now;
        near_caps.keep(&mut self.near_caps) && is_same
    }
}

/// The inputs of the volumes of one light that may change while the light is not computed again.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct LightInputs {
    pub(super) settings: StencilVolume,
    /// The [revision](crate::silhouettes::LightSilhouettes::revision) of the light's silhouettes, if it has any.
    pub(super) silhouettes: Option<u64>,
}
