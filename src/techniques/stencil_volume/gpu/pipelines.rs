//! The pipelines of shadow volumes, as descriptions for the shared cache.

use crate::conventions::{STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS};
use crate::render::Gpu;
use crate::render::frame::targets::RADIANCE_FORMAT;
use crate::render::gpu::pipeline_cache::{ADD, PipelineDesc, Stage};
use crate::render::gpu::stencil_only::without_color;
use crate::render::nodes::pipelines::front_face;

/// The part of a volume that a draw covers, which chooses the vertex stage.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// Quads between a silhouette edge and the same edge pushed away from the light.
    Side,
    /// The caster's own triangles.
    NearCap,
    /// The caster's own triangles, pushed away from the light.
    FarCap,
}

/// Everything that distinguishes two pipelines of the pass that marks volumes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The part that is drawn, which chooses the vertex stage.
    pub part: Part,
    /// True if the volume is counted towards the viewer.
    pub depth_pass: bool,
    /// True if the part's outward faces wind clockwise on the screen. They do if either the view or the
    /// caster mirrors, but not both. Triangles that are wound inward wind the other way round.
    pub clockwise: bool,
}

/// The purpose of drawing a volume.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The volume is counted in the stencil.
    Count,
    /// The volume is shown by the debug view.
    Show,
}

/// The shader file of shadow volumes.
pub const FILE: &str = "techniques/stencil_volume/volume.wgsl";

/// Describes the pipeline of a key; `casters` is the layout of group 2.
pub fn describe(gpu: &Gpu, casters: &wgpu::BindGroupLayout, key: Key, purpose: Purpose) -> PipelineDesc {
    const POSITIONS: &[wgpu::VertexBufferLayout] = &[wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    }];
    let (entry, buffers) = match key.part {
        Part::Side => ("side", &[] as &[_]),
        Part::NearCap => ("near_cap", POSITIONS),
        Part::FarCap => ("far_cap", POSITIONS),
    };
    let desc = |fragment| {
        PipelineDesc::new(
            "stencil volume",
            Stage::new(FILE, entry),
            Some(Stage::new(FILE, fragment)),
        )
    };
    let (desc, stencil) = match purpose {
        Purpose::Count => (without_color(desc("no_color")), counting_stencil(key.depth_pass)),
        Purpose::Show => {
            // Colours are RGBA bytes with red lowest. Depth-pass shows blue fronts and green backs.
            // Depth-fail shows orange fronts and magenta backs.
            let [front, back] = if key.depth_pass {
                [0xff40_1000_u32, 0xff10_4000]
            } else {
                [0xff00_2040, 0xff30_0040]
            };
            let colors = [("DEBUG_FRONT", f64::from(front)), ("DEBUG_BACK", f64::from(back))];
            let desc = desc("debug").with_constants(colors);
            let desc = desc.with_target(RADIANCE_FORMAT, Some(ADD), wgpu::ColorWrites::COLOR);
            (desc, Default::default())
        }
    };
    let layouts = &gpu.layouts;
    PipelineDesc {
        buffers,
        primitive: wgpu::PrimitiveState {
            front_face: front_face(key.clockwise),
            ..Default::default()
        },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: gpu.context.depth_stencil_format(),
            depth_write_enabled: Some(false),
            depth_compare: Some(wgpu::CompareFunction::Greater),
            stencil,
            bias: ALL_FARTHER,
        }),
        ..desc.with_groups([Some(&layouts.view), None, Some(casters), Some(&layouts.positions)])
    }
}

/// Pushes every face of a volume farther from the viewer by as much as the rasterizer rounds: half a step of
/// the grid of 1/256 pixel to which vertices snap, and one unit of depth.
///
/// Where two faces meet in an edge on a surface, rounding may put one in front of the surface and the other
/// behind it. The volume then counts −1 there, which cancels another volume's shadow. A face at the depth of
/// a surface counts as behind it; with this bias, so does a face that differs from it only by rounding. The
/// cost is that shadows move by 1/512 pixel. Of 39 models, 7 had a wrong pixel off the edges
/// without it and 3 have with it. 1/128 was worse at edges; 1/2048 was not enough.
const ALL_FARTHER: wgpu::DepthBiasState = wgpu::DepthBiasState {
    constant: -1,
    slope_scale: -1.0 / 512.0,
    clamp: 0.0,
};

/// Counts faces modulo 128 in the low bits, on pixels whose in-bounds bit is set.
fn counting_stencil(depth_pass: bool) -> wgpu::StencilState {
    use wgpu::StencilOperation::{DecrementWrap, IncrementWrap, Keep};
    let face = |depth_fail_op, pass_op| wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Equal,
        fail_op: Keep,
        depth_fail_op,
        pass_op,
    };
    let (front, back) = if depth_pass {
        (face(Keep, IncrementWrap), face(Keep, DecrementWrap))
    } else {
        (face(DecrementWrap, Keep), face(IncrementWrap, Keep))
    };
    wgpu::StencilState {
        front,
        back,
        read_mask: STENCIL_IN_BOUNDS,
        write_mask: STENCIL_COUNT_MASK,
    }
}
