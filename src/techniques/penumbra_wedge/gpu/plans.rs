//! What the recorder draws for each light and part of it, and the shader's view of a part.

use std::ops::Range;

use glam::DMat4;

use super::form::Form;
use super::pipelines::Part;
use crate::render::gpu::bind_groups::LIGHT_STRIDE;
use crate::sets::ViewData;
use crate::techniques::penumbra_wedge::component::{PenumbraWedge, WedgeCulling};
use crate::techniques::penumbra_wedge::geometry::records::WedgeLight;
use crate::techniques::penumbra_wedge::light_parts::PartShape;
use crate::techniques::penumbra_wedge::wedges::PartWedges;

/// The caps of one caster.
#[derive(Clone, Debug)]
pub(in crate::techniques::penumbra_wedge) struct CapDraw {
    pub(in crate::techniques::penumbra_wedge) mesh: u32,
    pub(in crate::techniques::penumbra_wedge) caps: [Range<u32>; 6],
    pub(in crate::techniques::penumbra_wedge) has_far: bool,
    /// Without caps: counted towards the viewer.
    pub(in crate::techniques::penumbra_wedge) towards: bool,
}

/// What is recorded for one part.
#[derive(Clone, Debug)]
pub(in crate::techniques::penumbra_wedge) struct PartPlan {
    /// Of the frame's parts.
    pub(in crate::techniques::penumbra_wedge) index: u32,
    pub(in crate::techniques::penumbra_wedge) groups: Range<usize>,
    /// Of the light, by colour and area.
    pub(in crate::techniques::penumbra_wedge) share: [f64; 4],
    pub(in crate::techniques::penumbra_wedge) has_extent: bool,
    pub(in crate::techniques::penumbra_wedge) is_sphere: bool,
}

impl PartPlan {
    /// Of the part's record, bytes.
    pub(in crate::techniques::penumbra_wedge) fn light_offset(&self) -> u32 {
        self.index * LIGHT_STRIDE as u32
    }
}

/// What is recorded for one light.
#[derive(Clone, Debug)]
pub(in crate::techniques::penumbra_wedge) struct LightPlan {
    pub(in crate::techniques::penumbra_wedge) light: usize,
    pub(in crate::techniques::penumbra_wedge) settings: PenumbraWedge,
    pub(in crate::techniques::penumbra_wedge) form: Form,
    pub(in crate::techniques::penumbra_wedge) parts: Range<usize>,
}

/// Whether there is a way to count these towards the viewer.
pub(in crate::techniques::penumbra_wedge) fn counts_towards(part: Part) -> bool {
    matches!(part, Part::Separator | Part::Shell | Part::HardSide)
}

/// What the passes of a light draw.
pub(in crate::techniques::penumbra_wedge) fn passes(
    culling: WedgeCulling,
    has_extent: bool,
) -> &'static [Part] {
    use Part::{HardSide, InnerHalf, Mark, OuterHalf, Separator, Shell, ShellEverywhere};
    match (culling, has_extent) {
        (_, false) => &[HardSide],
        (WedgeCulling::Depth, true) => &[Separator, Shell],
        (WedgeCulling::None, true) => &[Separator, ShellEverywhere],
        (WedgeCulling::Stencil, true) => &[HardSide, Mark, OuterHalf, InnerHalf],
    }
}

/// The shader's view of one part.
pub(in crate::techniques::penumbra_wedge) fn light_record(
    wedges: &PartWedges,
    view: &ViewData,
) -> WedgeLight {
    let part = &wedges.part;
    let clip_from_light = view.clip_from_world * part.world_from_light;
    let light_from_relative = part.world_from_light.inverse() * DMat4::from_translation(view.eye);
    let rows = light_from_relative.transpose().as_mat4();
    let half_size = match part.shape {
        PartShape::Point => [0.0; 2],
        PartShape::Rect { half } => half.as_vec2().to_array(),
        PartShape::Sphere { radius } => [radius as f32; 2],
    };
    WedgeLight {
        clip_from_light: clip_from_light.as_mat4().to_cols_array_2d(),
        light_from_relative_x: rows.x_axis.to_array(),
        light_from_relative_y: rows.y_axis.to_array(),
        light_from_relative_z: rows.z_axis.to_array(),
        half_size,
        table: 0,
        reach: wedges.reach,
        place: part.place,
        whole: part
            .whole_center
            .as_vec3()
            .extend(part.whole_radius as f32)
            .to_array(),
    }
}
