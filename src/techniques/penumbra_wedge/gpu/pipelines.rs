//! The pipelines of wedges, as descriptions for the shared cache.

use super::form::Form;
use crate::conventions::{STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS};
use crate::render::Gpu;
use crate::render::frame::targets::{MASK_FORMAT, RADIANCE_FORMAT};
use crate::render::gpu::pipeline_cache::{ADD, EVERYWHERE, PipelineDesc, Stage};
use crate::render::nodes::pipelines::front_face;

/// The part of wedges or hard shadows that a draw covers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Cap triangles on the caster, of these
    /// [layers](crate::techniques::penumbra_wedge::geometry::silhouette_layers).
    NearCap(u8),
    /// Cap triangles pushed to infinity, of these
    /// [layers](crate::techniques::penumbra_wedge::geometry::silhouette_layers).
    FarCap(u8),
    /// Back faces of shells, whether they lie behind the surface or not.
    ShellEverywhere,
    /// Back faces of shells that lie behind the surface.
    Shell,
    /// Separators, together with the sides of the hard shadow.
    Separator,
    /// Sides of the hard shadow.
    HardSide,
    /// Front faces of a half that lie behind the surface. They mark their pixels, as in section 4.4.
    Mark,
    /// Back faces of an outer half, at pixels that are not marked.
    OuterHalf,
    /// Back faces of an inner half, at pixels that are not marked.
    InnerHalf,
    /// Faces of wedges, for the debug view.
    Show,
}

/// Everything that distinguishes two pipelines of the passes that draw wedges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The part that is drawn, which chooses stages and states.
    pub part: Part,
    /// The form of the targets.
    pub form: Form,
    /// True if the light is a sphere.
    pub is_sphere: bool,
    /// True if angles and areas come from tables.
    pub looks_up: bool,
    /// True if faces in front of the surface count instead of those behind it.
    pub towards: bool,
    /// True if the view mirrors.
    pub mirrored: bool,
}

/// Everything that distinguishes two pipelines of the resolve.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResolveKey {
    /// The form of the sums that are read.
    pub form: Form,
    /// True if the light is a sphere.
    pub is_sphere: bool,
    /// True if the resolve writes the combined coverage instead of the mask.
    pub combines: bool,
    /// True if the resolve reads the combined coverage.
    pub is_combined: bool,
}

/// The format of the combined coverage of groups.
pub const COMBINED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

const WEDGE: &str = "techniques/penumbra_wedge/wedge.wgsl";
const RESOLVE: &str = "techniques/penumbra_wedge/resolve.wgsl";

/// The shader files of wedges.
pub const FILES: [&str; 2] = [WEDGE, RESOLVE];

/// Returns the two fragment stages of a part: the stage that sums into floats, and the stage that sums into
/// bytes.
fn fragments(part: Part) -> [&'static str; 2] {
    match part {
        Part::NearCap(_) | Part::FarCap(_) => ["cap", "cap_split"],
        Part::ShellEverywhere | Part::Shell => ["shell", "shell_split"],
        Part::Separator => ["separator", "separator_split"],
        Part::HardSide | Part::Mark => ["hard_side", "hard_side_split"],
        Part::OuterHalf | Part::InnerHalf => ["half", "half_split"],
        Part::Show => ["debug"; 2],
    }
}

/// Describes the pipeline of a draw of wedges; `wedges` is the layout of group 2.
pub fn describe(gpu: &Gpu, wedges: &wgpu::BindGroupLayout, key: Key) -> PipelineDesc {
    use wgpu::CompareFunction::{Always, Greater, LessEqual};
    const POSITIONS: &[wgpu::VertexBufferLayout] = &[wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    }];
    let (vertex, buffers) = match key.part {
        Part::NearCap(_) => ("near_cap", POSITIONS),
        Part::FarCap(_) => ("far_cap", POSITIONS),
        Part::Separator | Part::HardSide => ("separator_vertex", &[] as &[_]),
        _ => ("wedge_vertex", &[] as &[_]),
    };
    let fragment = fragments(key.part)[usize::from(key.form == Form::Split8)];
    let layers = match key.part {
        Part::NearCap(layers) | Part::FarCap(layers) => f64::from(layers),
        _ => 3.0,
    };
    let debug = key.part == Part::Show;
    let layouts = &gpu.layouts;
    // The debug view is drawn into the light pass, where no receivers are bound.
    let receiver = (!debug).then_some(&layouts.receiver);
    let mut desc = PipelineDesc::new(
        "penumbra wedge",
        Stage::new(WEDGE, vertex),
        Some(Stage::new(WEDGE, fragment)),
    )
    .with_groups([Some(&layouts.view), receiver, Some(wedges)])
    .with_constants([
        ("IS_SPHERE", f64::from(key.is_sphere)),
        ("HALF_SIGN", if key.part == Part::OuterHalf { -1.0 } else { 1.0 }),
        (
            "DRAWS_CUTS",
            f64::from(matches!(
                key.part,
                Part::Shell | Part::ShellEverywhere | Part::OuterHalf
            )),
        ),
        ("FACE_SIGN", if key.towards { -1.0 } else { 1.0 }),
        ("CAP_LAYERS", layers),
        ("LOOKS_UP", f64::from(key.looks_up)),
        ("IS_TEXTURED", f64::from(key.form.is_textured())),
        ("IS_SAMPLED", f64::from(key.form.sampled().is_some())),
        (
            "IS_DENSE",
            f64::from(key.form.sampled().is_some_and(|sampled| sampled.is_dense)),
        ),
        ("IS_DEEP", f64::from(key.form.is_deep())),
        // A larger count of hard shadows leaves less room for the digits after the point.
        ("STEPS", if key.form.is_deep() { 1024.0 } else { 16384.0 }),
    ]);
    let writes = if key.part == Part::Mark {
        wgpu::ColorWrites::empty()
    } else {
        wgpu::ColorWrites::ALL
    };
    let formats = if debug {
        &[RADIANCE_FORMAT][..]
    } else {
        key.form.formats()
    };
    for &format in formats {
        desc = desc.with_target(format, Some(ADD), writes);
    }
    // Faces behind the surface count, and so do faces on it, for both halves and for caps. If a caster is
    // counted towards the viewer, the faces in front of the surface count instead.
    let compare = match key.part {
        Part::ShellEverywhere => Always,
        Part::Show => Greater,
        _ if key.towards => Greater,
        _ => LessEqual,
    };
    let format = gpu.context.depth_stencil_format();
    PipelineDesc {
        buffers,
        primitive: wgpu::PrimitiveState {
            // The far cap has the near cap's triangles, seen from the other end.
            front_face: front_face(key.mirrored != matches!(key.part, Part::FarCap(_))),
            cull_mode: match key.part {
                Part::Shell if key.towards => Some(wgpu::Face::Back),
                Part::ShellEverywhere | Part::Shell | Part::OuterHalf | Part::InnerHalf => {
                    Some(wgpu::Face::Front)
                }
                Part::Mark => Some(wgpu::Face::Back),
                _ => None,
            },
            ..Default::default()
        },
        ..desc.with_depth(format, false, compare, stencil(key.part))
    }
}

/// Describes the pipeline of a resolve; `wedges` and `sums` are the layouts of groups 2 and 3.
pub fn describe_resolve(
    gpu: &Gpu,
    wedges: &wgpu::BindGroupLayout,
    sums: &wgpu::BindGroupLayout,
    key: ResolveKey,
) -> PipelineDesc {
    let weighted = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::Constant,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    let blend = wgpu::BlendState {
        color: weighted,
        alpha: weighted,
    };
    let (entry, format, blend) = if key.combines {
        ("combine", COMBINED_FORMAT, None)
    } else {
        ("resolve", MASK_FORMAT, Some(blend))
    };
    let layouts = &gpu.layouts;
    let is_scalar = matches!(key.form, Form::Float | Form::Half);
    PipelineDesc::new(
        "penumbra wedge resolve",
        EVERYWHERE,
        Some(Stage::new(RESOLVE, entry)),
    )
    .with_groups([
        Some(&layouts.view),
        Some(&layouts.receiver),
        Some(wedges),
        Some(sums),
    ])
    .with_constants([
        ("IS_SPLIT", f64::from(key.form == Form::Split8)),
        ("IS_SPHERE", f64::from(key.is_sphere)),
        ("IS_TEXTURED", f64::from(key.form.is_textured())),
        ("IS_SAMPLED", f64::from(key.form.sampled().is_some())),
        (
            "IS_DENSE",
            f64::from(key.form.sampled().is_some_and(|sampled| sampled.is_dense)),
        ),
        ("IS_DEEP", f64::from(key.form.is_deep())),
        ("IS_SCALAR", f64::from(is_scalar)),
        ("IS_COMBINED", f64::from(key.is_combined)),
    ])
    .with_target(format, blend, wgpu::ColorWrites::ALL)
}

/// Returns the stencil state of a part. Every draw tests the in-bounds bit.
///
/// As in section 4.4 of the paper, front faces of a half that are behind the surface mark their pixels. Back
/// faces are shaded where nothing is marked, and clear the mark elsewhere. The paper marks faces in front of
/// the surface instead. Marking faces behind it stays right when the eye is inside the wedge.
fn stencil(part: Part) -> wgpu::StencilState {
    use wgpu::StencilOperation::{IncrementClamp, Keep, Zero};
    let (fail_op, pass_op, write_mask, read_mask) = match part {
        Part::Show => return Default::default(),
        Part::Mark => (Keep, IncrementClamp, STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS),
        Part::OuterHalf | Part::InnerHalf => (Zero, Keep, STENCIL_COUNT_MASK, 0xff),
        _ => (Keep, Keep, 0, STENCIL_IN_BOUNDS),
    };
    let face = wgpu::StencilFaceState {
        compare: wgpu::CompareFunction::Equal,
        fail_op,
        depth_fail_op: Keep,
        pass_op,
    };
    wgpu::StencilState {
        front: face,
        back: face,
        read_mask,
        write_mask,
    }
}
