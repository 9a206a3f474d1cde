//! Pipelines of the passes that draw surfaces: a table of the passes, and the pipelines that a view has
//! needed so far.

use super::surface_pass::SurfacePass;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::{VARIANT_COUNT, Variant};
use crate::render::frame::targets::{MASK_FORMAT, RADIANCE_FORMAT, RECEIVER_PLANE_FORMAT};
use crate::render::gpu::pipeline_cache::{ADD, LESSER, PipelineDesc, Stage};
use crate::render::pools::gpu_types::SurfaceVertex;
use crate::render::{Gpu, RenderError};

/// The format of the picture of visibility. It is as fine as
/// [`MASK_FORMAT`](crate::render::frame::targets::MASK_FORMAT).
pub const VISIBILITY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// The vertex buffers of a drawn surface: positions, surface attributes, and the object index of each
/// instance.
pub const SURFACE_BUFFERS: [wgpu::VertexBufferLayout<'static>; 3] = [
    wgpu::VertexBufferLayout {
        array_stride: 12,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![0 => Float32x3],
    },
    wgpu::VertexBufferLayout {
        array_stride: size_of::<SurfaceVertex>() as u64,
        step_mode: wgpu::VertexStepMode::Vertex,
        attributes: &wgpu::vertex_attr_array![1 => Float32x3, 2 => Float32x4, 3 => Float32x4, 4 => Float32x4],
    },
    wgpu::VertexBufferLayout {
        array_stride: 4,
        step_mode: wgpu::VertexStepMode::Instance,
        attributes: &wgpu::vertex_attr_array![5 => Uint32],
    },
];

/// Returns a stencil test that leaves the stencil unchanged.
pub fn stencil_test(compare: wgpu::CompareFunction, read_mask: u32) -> wgpu::StencilState {
    let face = wgpu::StencilFaceState {
        compare,
        fail_op: wgpu::StencilOperation::Keep,
        depth_fail_op: wgpu::StencilOperation::Keep,
        pass_op: wgpu::StencilOperation::Keep,
    };
    wgpu::StencilState {
        front: face,
        back: face,
        read_mask,
        write_mask: 0,
    }
}

/// Returns a stencil test that a pixel passes once: what passes sets its stencil to 0.
fn once(compare: wgpu::CompareFunction) -> wgpu::StencilState {
    let mut state = stencil_test(compare, 0xff);
    for face in [&mut state.front, &mut state.back] {
        face.pass_op = wgpu::StencilOperation::Zero;
    }
    wgpu::StencilState {
        write_mask: 0xff,
        ..state
    }
}

/// The bind groups that a pass reads beside the view and the material.
#[derive(Clone, Copy, Debug)]
enum Groups {
    /// The pass reads no further groups.
    Unlit,
    /// The pass reads the light.
    Lit,
    /// The pass reads the light and its mask.
    Masked,
    /// The pass reads the light, its mask, and the mask of the functions that scale it.
    Tinted,
    /// The pass reads the mask of a light.
    MaskedUnlit,
    /// The pass reads the light and the depth of the front layer.
    BehindFront,
    /// The pass reads the depth of a host.
    Host,
}

/// The pixels at which a pass draws, by the stencil that the beginning of the light and its technique left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Where {
    /// The pass draws everywhere.
    Everywhere,
    /// The pass draws within the light's depth bounds, each pixel once: of surfaces in one place, the first.
    Once,
    /// The pass draws where the light is seen, each pixel once. Surfaces that show no shadow are drawn as under `Once`.
    Lit,
    /// The pass draws where the light is not seen.
    Shadowed,
}

/// The shader stages and the fixed state of one pass that draws surfaces.
#[derive(Clone, Copy, Debug)]
struct PassState {
    file: &'static str,
    fragment: &'static str,
    /// The fragment stage for surfaces that show no shadow. It may equal `fragment`.
    unshadowed: &'static str,
    groups: Groups,
    /// The format of the colour target; `None` if the pass writes no colour.
    format: Option<wgpu::TextureFormat>,
    blend: Option<wgpu::BlendState>,
    /// True if the surfaces are blended. The shader then multiplies by their alpha.
    is_blended: bool,
    writes_depth: bool,
    compare: wgpu::CompareFunction,
    stencil: Where,
}

impl PassState {
    /// Returns whether the pass evaluates the material's reflection or emission.
    fn is_shaded(&self) -> bool {
        self.format.is_some() && (self.file == AMBIENT || self.file == LIGHT)
    }
}

const AMBIENT: &str = "passes/ambient.wgsl";
const LIGHT: &str = "passes/light_accumulate.wgsl";
const LIGHT_MODELLED: &str = "passes/light_modelled.wgsl";
const VISIBILITY: &str = "passes/visibility.wgsl";
const RECEIVER_PLANE: &str = "passes/receiver_plane.wgsl";
const HOST_DEPTH: &str = "passes/host_depth.wgsl";

const FILES: [&str; 5] = [AMBIENT, LIGHT, VISIBILITY, RECEIVER_PLANE, HOST_DEPTH];

const OVER: wgpu::BlendState = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;

const fn drawing(file: &'static str, format: wgpu::TextureFormat) -> PassState {
    PassState {
        file,
        fragment: "fragment",
        unshadowed: "fragment",
        groups: Groups::Unlit,
        format: Some(format),
        blend: None,
        is_blended: false,
        writes_depth: false,
        compare: wgpu::CompareFunction::Equal,
        stencil: Where::Everywhere,
    }
}

/// The state of a pass that adds a light to the surfaces that the frame's depth shows.
const LIT: PassState = PassState {
    groups: Groups::Lit,
    blend: Some(ADD),
    stencil: Where::Once,
    ..drawing(LIGHT, RADIANCE_FORMAT)
};

/// The state of a pass whose surfaces become the depth of the frame.
const NEAREST: PassState = PassState {
    writes_depth: true,
    compare: wgpu::CompareFunction::Greater,
    ..drawing(AMBIENT, RADIANCE_FORMAT)
};

/// The state of a pass that draws a picture of one light's visibility.
const SEEN: PassState = drawing(VISIBILITY, VISIBILITY_FORMAT);

impl SurfacePass {
    /// Returns the state of a pass: this is the table of the passes.
    const fn state(self) -> PassState {
        use wgpu::CompareFunction::{Always, GreaterEqual};
        match self {
            Self::Ambient => NEAREST,
            Self::AmbientBlended => PassState {
                groups: Groups::Lit,
                blend: Some(OVER),
                is_blended: true,
                compare: GreaterEqual,
                ..drawing(AMBIENT, RADIANCE_FORMAT)
            },
            Self::Light => PassState {
                stencil: Where::Lit,
                ..LIT
            },
            Self::FrontLight => PassState {
                stencil: Where::Lit,
                is_blended: true,
                ..LIT
            },
            Self::LightMasked => PassState {
                groups: Groups::Masked,
                fragment: "masked",
                ..LIT
            },
            Self::FrontLightMasked => PassState {
                groups: Groups::Masked,
                fragment: "masked",
                is_blended: true,
                ..LIT
            },
            Self::LightTinted => PassState {
                groups: Groups::Tinted,
                fragment: "tinted",
                unshadowed: "tinted_unshadowed",
                ..LIT
            },
            Self::FrontLightTinted => PassState {
                groups: Groups::Tinted,
                fragment: "tinted",
                unshadowed: "tinted_unshadowed",
                is_blended: true,
                ..LIT
            },
            Self::LightBlended => PassState {
                is_blended: true,
                compare: GreaterEqual,
                stencil: Where::Everywhere,
                ..LIT
            },
            Self::LightBehindFront => PassState {
                groups: Groups::BehindFront,
                fragment: "behind_front",
                unshadowed: "behind_front",
                is_blended: true,
                compare: GreaterEqual,
                stencil: Where::Everywhere,
                ..LIT
            },
            Self::FrontDepth => PassState {
                fragment: "depth_of_blended",
                unshadowed: "depth_of_blended",
                format: None,
                ..NEAREST
            },
            Self::HostSurface => PassState {
                fragment: "surface",
                unshadowed: "surface",
                groups: Groups::Host,
                format: None,
                writes_depth: true,
                compare: Always,
                ..drawing(HOST_DEPTH, RADIANCE_FORMAT)
            },
            Self::Dark => SEEN,
            Self::Visibility => PassState {
                stencil: Where::Shadowed,
                ..SEEN
            },
            Self::VisibilityFront => PassState {
                fragment: "lit",
                unshadowed: "lit",
                ..SEEN
            },
            Self::VisibilityMasked => PassState {
                groups: Groups::MaskedUnlit,
                fragment: "masked",
                ..SEEN
            },
            Self::LightScaled => PassState {
                groups: Groups::Masked,
                fragment: "masked",
                unshadowed: "masked",
                ..LIT
            },
            Self::FrontLightScaled => PassState {
                groups: Groups::Masked,
                fragment: "masked",
                unshadowed: "masked",
                is_blended: true,
                ..LIT
            },
            Self::WholeMask => PassState {
                fragment: "lit",
                unshadowed: "lit",
                ..drawing(VISIBILITY, MASK_FORMAT)
            },
            Self::DarkerMask => PassState {
                fragment: "darker",
                groups: Groups::MaskedUnlit,
                blend: Some(LESSER),
                ..drawing(VISIBILITY, MASK_FORMAT)
            },
            Self::LightCount => PassState {
                fragment: "lit",
                unshadowed: "lit",
                blend: Some(ADD),
                ..SEEN
            },
            Self::ReceiverPlane => drawing(RECEIVER_PLANE, RECEIVER_PLANE_FORMAT),
        }
    }
}

/// The pipelines with which a view draws surfaces. They are handles into the shared cache.
#[derive(Debug)]
pub struct SurfacePipelines {
    pipelines: Vec<Option<wgpu::RenderPipeline>>,
}

impl SurfacePipelines {
    /// Compiles the shaders. The pipelines are made when a frame needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new(gpu: &Gpu) -> Result<Self, RenderError> {
        gpu.compile(&FILES)?;
        Ok(Self {
            pipelines: vec![None; SurfacePass::COUNT * VARIANT_COUNT],
        })
    }

    /// Returns the pipeline, if [`SurfacePipelines::require`] has taken it.
    pub fn get(&self, pass: SurfacePass, variant: Variant) -> Option<&wgpu::RenderPipeline> {
        self.pipelines[slot(pass, variant)].as_ref()
    }

    /// Takes the pipeline from the shared cache, unless it was taken before. The picture of visibility leaves
    /// out surfaces that show no shadow, so no pipeline is taken for them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn require(&mut self, gpu: &Gpu, pass: SurfacePass, variant: Variant) -> Result<(), RenderError> {
        if variant.unshadowed && matches!(pass, SurfacePass::Visibility | SurfacePass::VisibilityMasked) {
            return Ok(());
        }
        let slot = slot(pass, variant);
        if self.pipelines[slot].is_none() {
            self.pipelines[slot] = Some(gpu.pipeline(describe(gpu, pass, variant))?);
        }
        Ok(())
    }
}

fn describe(gpu: &Gpu, pass: SurfacePass, variant: Variant) -> PipelineDesc {
    let state = pass.state();
    let layouts = &gpu.layouts;
    let (light, own) = match state.groups {
        Groups::Unlit => (None, None),
        Groups::Lit => (Some(&layouts.light), None),
        Groups::Masked => (Some(&layouts.light), Some(&layouts.mask)),
        Groups::Tinted => (Some(&layouts.light), Some(&layouts.masks)),
        Groups::MaskedUnlit => (None, Some(&layouts.mask)),
        Groups::BehindFront => (Some(&layouts.light), Some(&layouts.depth)),
        Groups::Host => (None, Some(&layouts.host)),
    };
    // A stencil value is greater than the in-bounds bit alone only where shadow volumes were counted.
    debug_assert_eq!(STENCIL_IN_BOUNDS, 0x80, "the tests rely on the top bit");
    let stencil = match state.stencil {
        Where::Lit if !variant.unshadowed => once(wgpu::CompareFunction::Equal),
        Where::Lit | Where::Once => once(wgpu::CompareFunction::LessEqual),
        Where::Shadowed => stencil_test(wgpu::CompareFunction::Less, 0xff),
        Where::Everywhere => Default::default(),
    };
    let entry = if variant.unshadowed {
        state.unshadowed
    } else {
        state.fragment
    };
    let is_modelled = variant.modelled && state.file == LIGHT;
    let (file, entry) = match (is_modelled, pass) {
        // The shape of a light is a factor of its mask, except on blended surfaces, which have none.
        (true, SurfacePass::LightBlended) => (LIGHT_MODELLED, "blended"),
        (true, _) => (LIGHT_MODELLED, entry),
        (false, _) => (state.file, entry),
    };
    let vertex = Stage::new(file, "vertex");
    let mut desc = PipelineDesc::new(pass.label(), vertex, Some(Stage::new(file, entry)))
        .with_groups([Some(&layouts.view), light, Some(&layouts.material), own])
        .with_depth(
            gpu.context.depth_stencil_format(),
            state.writes_depth,
            state.compare,
            stencil,
        );
    if state.is_blended {
        desc = desc.with_constants([("BLENDED", 1.0)]);
    }
    if variant.coated && state.is_shaded() {
        desc = desc.with_constants([("COATED", 1.0)]);
    }
    if let Some(format) = state.format {
        desc = desc.with_target(format, state.blend, wgpu::ColorWrites::ALL);
    }
    PipelineDesc {
        buffers: &SURFACE_BUFFERS,
        primitive: wgpu::PrimitiveState {
            front_face: front_face(variant.mirrored),
            cull_mode: variant.culled.then_some(wgpu::Face::Back),
            ..Default::default()
        },
        ..desc
    }
}

/// Returns the winding of front faces on the screen.
pub fn front_face(mirrored: bool) -> wgpu::FrontFace {
    if mirrored {
        wgpu::FrontFace::Cw
    } else {
        wgpu::FrontFace::Ccw
    }
}

fn slot(pass: SurfacePass, variant: Variant) -> usize {
    pass as usize * VARIANT_COUNT + variant.index()
}
