//! What changes every frame: draw lists and lights, ready to record.

use std::ops::Range;

use bevy_ecs::prelude::Entity;
use fixedbitset::FixedBitSet;
use glam::UVec2;

use super::draw_list::Batch;
use crate::render::nodes::blended::{BlendedDraw, BlendedLight};
use crate::render::recorder::ShadowKind;
use crate::sets::LightTechnique;

/// The part of the targets that the view has.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Viewport {
    /// Its upper left corner, pixels.
    pub origin: UVec2,
    /// Pixels.
    pub size: UVec2,
}

impl Viewport {
    /// Maps NDC to it in a pass that draws geometry.
    pub fn set(&self, pass: &mut wgpu::RenderPass) {
        let [x, y] = self.origin.as_vec2().to_array();
        let [width, height] = self.size.as_vec2().to_array();
        pass.set_viewport(x, y, width, height, 0.0, 1.0);
    }

    /// A rectangle of the view in the targets.
    pub fn place(&self, [x, y, width, height]: [u32; 4]) -> [u32; 4] {
        [x + self.origin.x, y + self.origin.y, width, height]
    }
}

/// A recorder of a renderer, by the order in which they were added.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct TechniqueIndex(pub usize);

/// The place of a light among those that a frame draws, and of its constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightSlot(pub usize);

/// How the shadow of one light is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LightShadow {
    /// The recorder that draws the shadow.
    pub technique: TechniqueIndex,
    /// What the technique leaves of the light.
    pub kind: ShadowKind,
}

/// One light of the frame, ready to record.
#[derive(Clone, Debug, PartialEq)]
pub struct ActiveLight {
    /// Its entity.
    pub entity: Entity,
    /// Index into [`FrameLights`](crate::sets::FrameLights).
    pub light: usize,
    /// Slot of the light's constants.
    pub slot: LightSlot,
    /// The technique of the light; `None` if nothing shadows the light.
    pub technique: Option<LightTechnique>,
    /// How the light's shadow is drawn; `None` if nothing shadows the light.
    pub shadow: Option<LightShadow>,
    /// A [`LightFunction`](crate::render::LightFunction) scales the light, which then has a mask.
    pub is_scaled: bool,
    /// x, y, width, height; pixels of the targets.
    pub scissor: [u32; 4],
    /// Nearest and farthest depth that it reaches, 1 ≥ near ≥ far ≥ 0.
    pub depth_range: (f32, f32),
    /// Range of [`FrameData::batches`].
    pub batches: Range<usize>,
    /// Range of [`FrameData::batches`]: in a host's frame, surfaces in view that it does not affect or does not see.
    pub unlit: Range<usize>,
    /// Range of [`FrameData::batches`]: blended surfaces, whose front layer it lights with its shadows. Empty without a
    /// technique.
    pub front: Range<usize>,
    /// The part of the scissor that shows them.
    pub front_scissor: [u32; 4],
}

impl ActiveLight {
    /// Whether its technique leaves a mask.
    pub fn has_mask(&self) -> bool {
        self.kind() == Some(ShadowKind::Mask)
    }

    /// What the light is added by: what its technique leaves, or the mask if a function scales it; `None` without either.
    pub fn kind(&self) -> Option<ShadowKind> {
        if self.is_scaled {
            return Some(ShadowKind::Mask);
        }
        self.shadow.map(|shadow| shadow.kind)
    }

    /// Whether its technique leaves a mask that is made from the planes of the receivers.
    pub fn reads_planes(&self) -> bool {
        self.has_mask()
            && self
                .technique
                .is_some_and(|technique| technique.needs.receiver_planes)
    }
}

/// What changes every frame; its memory is kept.
#[derive(Debug, Default)]
pub struct FrameData {
    /// All draws of surfaces.
    pub batches: Vec<Batch>,
    /// Objects by instance.
    pub instances: Vec<u32>,
    /// Range of `batches`: the visible set V.
    pub ambient: Range<usize>,
    /// Lights with something to light.
    pub lights: Vec<ActiveLight>,
    /// By index into [`FrameLights`](crate::sets::FrameLights), ranges of `batches`: surfaces that the light does not see.
    /// Drawn into pictures of its visibility alone.
    pub dark: Vec<(usize, Range<usize>)>,
    /// Blended surfaces, farthest first.
    pub blended: Vec<BlendedDraw>,
    /// The lights of blended surfaces.
    pub blended_lights: Vec<BlendedLight>,
    /// Range of `batches`: all blended surfaces.
    pub blended_batches: Range<usize>,
    /// For each of `lights` the casters whose shadows can reach its front layer, by dense object index.
    pub front_casters: Vec<FixedBitSet>,
    /// Where the view is in the targets.
    pub viewport: Viewport,
    /// Whether there is a view to draw.
    pub has_view: bool,
    /// For sorting blended surfaces: distance, object, item.
    pub blended_order: Vec<(u32, u32, u32)>,
    /// For collecting what a light leaves out.
    pub unlit: FixedBitSet,
}

impl FrameData {
    /// Forgets the last frame's draws, and keeps their memory.
    pub(in crate::render) fn clear(&mut self) {
        self.batches.clear();
        self.instances.clear();
        self.lights.clear();
        self.dark.clear();
        self.blended.clear();
        self.blended_lights.clear();
        self.ambient = 0..0;
    }

    /// Whether a shadowed light reaches a blended surface.
    pub fn has_front_layer(&self) -> bool {
        self.lights.iter().any(|light| !light.front.is_empty())
    }
}
