//! The data that changes every frame: draw lists and lights, ready to record.

use std::ops::Range;

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::UVec2;

use super::draw_list::Batch;
use crate::render::nodes::blended::{BlendedDraw, BlendedLight};
use crate::render::recorder::ShadowKind;
use crate::sets::{CompanionPart, LightTechnique};

/// The part of the targets that the view covers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Viewport {
    /// Upper left corner of the view in the targets, pixels.
    pub origin: UVec2,
    /// Size of the view, pixels.
    pub size: UVec2,
}

impl Viewport {
    /// Maps NDC to the view, in a pass that draws geometry.
    pub fn set(&self, pass: &mut wgpu::RenderPass) {
        let [x, y] = self.origin.as_vec2().to_array();
        let [width, height] = self.size.as_vec2().to_array();
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
    }

    /// Moves a rectangle from the view to the targets, pixels.
    pub fn place(&self, [x, y, width, height]: [u32; 4]) -> [u32; 4] {
        [x + self.origin.x, y + self.origin.y, width, height]
    }
}

/// The index of a recorder in its renderer, in the order in which the recorders were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueIndex(pub usize);

/// The index of a light among those that a frame draws, and of its constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightSlot(pub usize);

/// The recorder that draws the shadow of one light, and the kind of its result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightShadow {
    /// The recorder that draws the shadow.
    pub technique: TechniqueIndex,
    /// The kind of result that the technique leaves of the light.
    pub kind: ShadowKind,
}

/// One light of the frame, ready to record.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveLight {
    /// The entity of the light.
    pub entity: Entity,
    /// Index of the light in [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// The slot of the light's constants.
    pub slot: LightSlot,
    /// The technique of the light; `None` if nothing shadows the light.
    pub technique: Option<LightTechnique>,
    /// The recorder and the kind of the light's shadow; `None` if nothing shadows the light.
    pub shadow: Option<LightShadow>,
    /// True if a [`LightFunction`](crate::render::LightFunction) scales the light. The light then has a mask.
    pub is_scaled: bool,
    /// True if the light gives something to surfaces that it does not see: ambient light, or the colour of its
    /// shadow. The light then has a mask, and the functions that scale it have one of their own.
    pub is_tinted: bool,
    /// Rectangle of the light: x, y, width, height, in pixels of the targets.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that the light reaches, 1 ≥ near ≥ far ≥ 0.
    pub depth_range: (f32, f32),
    /// Range of [`FrameData::batches`]: the opaque surfaces that the light lights.
    pub batches: Range<usize>,
    /// Range of [`FrameData::batches`]: the surfaces in view that the light does not affect or does not see.
    /// It is filled only in a host's frame.
    pub unlit: Range<usize>,
    /// Range of [`FrameData::batches`]: the blended surfaces that the light reaches. It lights their front
    /// layer with its shadows. The range is empty without a technique.
    pub front: Range<usize>,
    /// The part of the light's scissor that shows its blended surfaces: x, y, width, height, in pixels of the
    /// targets.
    pub front_scissor: [u32; 4],
    /// Range of [`FrameData::companions`]: those that complete the shadow of the light.
    pub companions: Range<usize>,
}

/// The part of the picture and the depths that a light reaches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightArea {
    /// Rectangle of the light: x, y, width, height, in pixels of the targets.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that the light reaches, 1 ≥ near ≥ far ≥ 0.
    pub depth_range: (f32, f32),
}

/// One companion of a light of the frame, ready to record.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveCompanion {
    /// The companion as a light that shadows but is not added. Its slot is that of the light that it completes. Of its surfaces
    /// only those are listed that its passes draw.
    pub shadow: ActiveLight,
    /// The receivers on which it shadows.
    pub part: CompanionPart,
    /// True if some caster can shadow what is seen.
    pub casts: bool,
    /// True if it shadows everything that is seen of its light, because the technique of the light knows nothing of it.
    pub is_alone: bool,
}

impl ActiveLight {
    /// Returns whether the light is added through a mask.
    pub fn has_mask(&self) -> bool {
        self.kind() == Some(ShadowKind::Mask)
    }

    /// Returns the kind of result by which the light is added: that of its technique, or the mask if a
    /// function scales the light or its shadow has a colour. It is `None` without any of them.
    pub fn kind(&self) -> Option<ShadowKind> {
        if self.is_scaled || self.is_tinted {
            return Some(ShadowKind::Mask);
        }
        self.shadow.map(|shadow| shadow.kind)
    }

    /// Returns whether the light's technique counts in the stencil, of which a mask is then made.
    pub fn makes_mask_of_stencil(&self) -> bool {
        self.has_mask()
            && self
                .shadow
                .is_some_and(|shadow| shadow.kind == ShadowKind::Stencil)
    }

    /// Returns whether the mask of the light is made from the depth of the receivers: by its technique, or by a function that
    /// scales the light.
    pub fn reads_depth(&self) -> bool {
        let draws_receivers = || {
            self.technique
                .is_some_and(|technique| technique.needs.draws_receivers)
        };
        self.has_mask() && (self.is_scaled || self.is_tinted || !draws_receivers())
    }

    /// Returns whether the light's technique leaves a mask that is made from the planes of the receivers.
    pub fn reads_planes(&self) -> bool {
        self.has_mask()
            && self
                .technique
                .is_some_and(|technique| technique.needs.receiver_planes)
    }
}

/// How many matrices of objects a frame took.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MatrixWork {
    /// Number of objects whose matrices were computed.
    pub computed: usize,
    /// Number of objects whose matrices were uploaded, at 128 bytes each. It may be more than were computed.
    pub uploaded: usize,
    /// Number of calls that uploaded them.
    pub uploads: usize,
}

/// The data that changes every frame. Its memory is kept.
#[derive(Debug, Default)]
pub struct FrameData {
    /// All draws of surfaces in the frame.
    pub batches: Vec<Batch>,
    /// The dense index of the object of each instance.
    pub instances: Vec<u32>,
    /// Range of `batches`: the opaque surfaces of the visible set V.
    pub ambient: Range<usize>,
    /// Range of `batches`: the opaque surfaces of V whose objects have weights, for a host that weights the terms of
    /// lights.
    pub weighted: Range<usize>,
    /// The lights that have something to light.
    pub lights: Vec<ActiveLight>,
    /// The companions of the lights, in the order of the lights.
    pub companions: Vec<ActiveCompanion>,
    /// For lights by index into [`FrameLights`](crate::sets::FrameLights), ranges of `batches` with the
    /// surfaces that the light does not see. They are drawn only into pictures of the light's visibility.
    pub dark: Vec<(usize, Range<usize>)>,
    /// The blended surfaces, farthest first.
    pub blended: Vec<BlendedDraw>,
    /// The lights of the blended surfaces. Each entry of `blended` has a range of them.
    pub blended_lights: Vec<BlendedLight>,
    /// Range of `batches`: all blended surfaces.
    pub blended_batches: Range<usize>,
    /// For each of `lights`, the casters whose shadows can reach its front layer, by dense object index.
    pub front_casters: Vec<FixedBitSet>,
    /// The part of the targets that the view covers.
    pub viewport: Viewport,
    /// True if there is a view to draw.
    pub has_view: bool,
    /// The matrices of objects that the frame computed and uploaded.
    pub matrices: MatrixWork,
    /// Scratch memory for sorting blended surfaces: the key of the distance, the object, and the index of the
    /// item within the object.
    pub blended_order: Vec<(u32, u32, u32)>,
    /// Scratch memory for collecting the objects that a light does not light.
    pub unlit: FixedBitSet,
}

impl FrameData {
    /// Clears the last frame's draws, and keeps their memory.
    pub(in crate::render) fn clear(&mut self) {
        self.batches.clear();
        self.instances.clear();
        self.lights.clear();
        self.companions.clear();
        self.dark.clear();
        self.blended.clear();
        self.blended_lights.clear();
        self.ambient = 0..0;
        self.weighted = 0..0;
    }

    /// Returns the companions of a light of the frame, as lights that are not added.
    pub fn companions_of<'a>(
        &'a self,
        light: &ActiveLight,
    ) -> impl Iterator<Item = &'a ActiveLight> + use<'a> {
        let companions = &self.companions[light.companions.clone()];
        companions.iter().map(|companion| &companion.shadow)
    }

    /// Returns whether a shadowed light reaches a blended surface.
    pub fn has_front_layer(&self) -> bool {
        self.lights.iter().any(|light| !light.front.is_empty())
    }
}
