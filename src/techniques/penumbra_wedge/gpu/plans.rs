//! The draws of each light and of its parts, and the shader's record of a part.

use std::ops::Range;

use glam::DMat4;

use super::form::Form;
use super::pipelines::Part;
use crate::render::gpu::strided::Strided;
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
    /// True if the caster is counted towards the viewer, which needs no caps.
    pub(in crate::techniques::penumbra_wedge) towards: bool,
}

/// The draws of one part of a light.
#[derive(Clone, Debug)]
pub(in crate::techniques::penumbra_wedge) struct PartPlan {
    /// The index of the part among the frame's parts.
    pub(in crate::techniques::penumbra_wedge) index: u32,
    pub(in crate::techniques::penumbra_wedge) groups: Range<usize>,
    /// The part's share of the light: by colour in rgb, by area in a.
    pub(in crate::techniques::penumbra_wedge) share: [f64; 4],
    pub(in crate::techniques::penumbra_wedge) has_extent: bool,
    pub(in crate::techniques::penumbra_wedge) is_sphere: bool,
}

impl PartPlan {
    /// Returns the offset of the part's record in the buffer of lights, bytes.
    pub(in crate::techniques::penumbra_wedge) fn light_offset(&self) -> u32 {
        Strided::<WedgeLight>::offset(self.index as usize)
    }
}

/// The settings, the form and the parts with which one light is drawn.
#[derive(Clone, Debug)]
pub(in crate::techniques::penumbra_wedge) struct LightPlan {
    pub(in crate::techniques::penumbra_wedge) light: usize,
    pub(in crate::techniques::penumbra_wedge) settings: PenumbraWedge,
    pub(in crate::techniques::penumbra_wedge) form: Form,
    pub(in crate::techniques::penumbra_wedge) parts: Range<usize>,
}

/// Returns whether this part of a wedge has a pipeline that counts towards the viewer.
pub(in crate::techniques::penumbra_wedge) fn counts_towards(part: Part) -> bool {
    matches!(part, Part::Separator | Part::Shell | Part::HardSide)
}

/// Returns the parts of a wedge that the passes of a light draw.
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

/// Makes the shader's record of one part.
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
