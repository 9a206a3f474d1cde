//! Pipelines of the passes that draw surfaces, made when a frame first needs them and kept.

use super::surface_pass::SurfacePass;
use crate::conventions::STENCIL_IN_BOUNDS;
use crate::render::frame::draw_list::{VARIANT_COUNT, Variant};
use crate::render::frame::targets::{RADIANCE_FORMAT, RECEIVER_PLANE_FORMAT};
use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::pools::gpu_types::SurfaceVertex;
use crate::render::{RenderContext, RenderError, Shaders};

/// Format of the visibility picture; as fine as [`MASK_FORMAT`](crate::render::frame::targets::MASK_FORMAT).
pub const VISIBILITY_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::R16Float;

/// The vertex buffers of a drawn surface: positions, surface attributes, object index an instance.
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

/// The cache.
#[derive(Debug)]
pub struct SurfacePipelines {
    ambient: wgpu::ShaderModule,
    light: wgpu::ShaderModule,
    visibility: wgpu::ShaderModule,
    receiver_plane: wgpu::ShaderModule,
    host_depth: wgpu::ShaderModule,
    unlit_layout: wgpu::PipelineLayout,
    lit_layout: wgpu::PipelineLayout,
    masked_layout: wgpu::PipelineLayout,
    masked_unlit_layout: wgpu::PipelineLayout,
    behind_front_layout: wgpu::PipelineLayout,
    host_layout: wgpu::PipelineLayout,
    pipelines: Vec<Option<wgpu::RenderPipeline>>,
    /// Pipelines made so far; does not grow in a steady frame.
    pub created: usize,
}

/// A stencil test that leaves the stencil as it is.
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

impl SurfacePipelines {
    /// Compiles the shaders; pipelines come later.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
    ) -> Result<Self, RenderError> {
        let layout = |label, light: Option<&wgpu::BindGroupLayout>, mask: Option<&wgpu::BindGroupLayout>| {
            context
                .device
                .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some(label),
                    bind_group_layouts: &[Some(&layouts.view), light, Some(&layouts.material), mask],
                    immediate_size: 0,
                })
        };
        Ok(Self {
            ambient: shaders.module(&context.device, "passes/ambient.wgsl")?,
            light: shaders.module(&context.device, "passes/light_accumulate.wgsl")?,
            visibility: shaders.module(&context.device, "passes/visibility.wgsl")?,
            receiver_plane: shaders.module(&context.device, "passes/receiver_plane.wgsl")?,
            host_depth: shaders.module(&context.device, "passes/host_depth.wgsl")?,
            unlit_layout: layout("surface", None, None),
            lit_layout: layout("lit surface", Some(&layouts.light), None),
            masked_layout: layout("masked surface", Some(&layouts.light), Some(&layouts.mask)),
            masked_unlit_layout: layout("mask of a surface", None, Some(&layouts.mask)),
            behind_front_layout: layout(
                "behind the front layer",
                Some(&layouts.light),
                Some(&layouts.depth),
            ),
            host_layout: layout("surface of a host", None, Some(&layouts.host)),
            pipelines: vec![None; SurfacePass::COUNT * VARIANT_COUNT],
            created: 0,
        })
    }

    /// The pipeline, if [`SurfacePipelines::require`] has made it.
    pub fn get(&self, pass: SurfacePass, variant: Variant) -> Option<&wgpu::RenderPipeline> {
        self.pipelines[slot(pass, variant)].as_ref()
    }

    /// Makes the pipeline if it does not exist yet. None is made for the visibility of surfaces that show no shadow,
    /// which leaves them out of that picture.
    pub fn require(&mut self, context: &RenderContext, pass: SurfacePass, variant: Variant) {
        if variant.unshadowed && matches!(pass, SurfacePass::Visibility | SurfacePass::VisibilityMasked) {
            return;
        }
        let slot = slot(pass, variant);
        if self.pipelines[slot].is_none() {
            self.pipelines[slot] = Some(self.create(context, pass, variant));
            self.created += 1;
        }
    }

    fn create(&self, context: &RenderContext, pass: SurfacePass, variant: Variant) -> wgpu::RenderPipeline {
        use wgpu::CompareFunction::{Always, Equal, Greater, GreaterEqual, Less};
        let add = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let adding = wgpu::BlendState {
            color: add,
            alpha: add,
        };
        let over = wgpu::BlendState::PREMULTIPLIED_ALPHA_BLENDING;
        // The in-bounds bit alone has a value greater than it only where shadow volumes were counted.
        let (module, layout, format, blend, depth_write, depth_compare, stencil) = match pass {
            SurfacePass::Ambient => (
                &self.ambient,
                &self.unlit_layout,
                RADIANCE_FORMAT,
                None,
                true,
                Greater,
                Default::default(),
            ),
            SurfacePass::AmbientBlended => (
                &self.ambient,
                &self.lit_layout,
                RADIANCE_FORMAT,
                Some(over),
                false,
                GreaterEqual,
                Default::default(),
            ),
            SurfacePass::Light | SurfacePass::FrontLight => (
                &self.light,
                &self.lit_layout,
                RADIANCE_FORMAT,
                Some(adding),
                false,
                Equal,
                if variant.unshadowed {
                    Default::default()
                } else {
                    stencil_test(Equal, 0xff)
                },
            ),
            SurfacePass::LightMasked | SurfacePass::FrontLightMasked => (
                &self.light,
                &self.masked_layout,
                RADIANCE_FORMAT,
                Some(adding),
                false,
                Equal,
                Default::default(),
            ),
            SurfacePass::LightBlended => (
                &self.light,
                &self.lit_layout,
                RADIANCE_FORMAT,
                Some(adding),
                false,
                GreaterEqual,
                Default::default(),
            ),
            SurfacePass::LightBehindFront => (
                &self.light,
                &self.behind_front_layout,
                RADIANCE_FORMAT,
                Some(adding),
                false,
                GreaterEqual,
                Default::default(),
            ),
            SurfacePass::FrontDepth => (
                &self.ambient,
                &self.unlit_layout,
                RADIANCE_FORMAT,
                None,
                true,
                Greater,
                Default::default(),
            ),
            SurfacePass::VisibilityFront | SurfacePass::Dark => (
                &self.visibility,
                &self.unlit_layout,
                VISIBILITY_FORMAT,
                None,
                false,
                Equal,
                Default::default(),
            ),
            SurfacePass::Visibility => (
                &self.visibility,
                &self.unlit_layout,
                VISIBILITY_FORMAT,
                None,
                false,
                Equal,
                stencil_test(Less, 0xff),
            ),
            SurfacePass::ReceiverPlane => (
                &self.receiver_plane,
                &self.unlit_layout,
                RECEIVER_PLANE_FORMAT,
                None,
                false,
                Equal,
                Default::default(),
            ),
            SurfacePass::HostSurface => (
                &self.host_depth,
                &self.host_layout,
                RADIANCE_FORMAT,
                None,
                true,
                Always,
                Default::default(),
            ),
            SurfacePass::VisibilityMasked => (
                &self.visibility,
                &self.masked_unlit_layout,
                VISIBILITY_FORMAT,
                None,
                false,
                Equal,
                Default::default(),
            ),
        };
        let fragment = match pass {
            SurfacePass::FrontDepth => "depth_of_blended",
            SurfacePass::LightBehindFront => "behind_front",
            SurfacePass::HostSurface => "surface",
            SurfacePass::VisibilityFront => "lit",
            SurfacePass::LightMasked | SurfacePass::FrontLightMasked | SurfacePass::VisibilityMasked
                if !variant.unshadowed =>
            {
                "masked"
            }
            _ => "fragment",
        };
        let color = Some(wgpu::ColorTargetState {
            format,
            blend,
            write_mask: wgpu::ColorWrites::ALL,
        });
        debug_assert_eq!(STENCIL_IN_BOUNDS, 0x80, "the tests above rely on the top bit");
        let blended = matches!(
            pass,
            SurfacePass::AmbientBlended
                | SurfacePass::LightBlended
                | SurfacePass::LightBehindFront
                | SurfacePass::FrontLight
                | SurfacePass::FrontLightMasked
        );
        let constants: &[(&str, f64)] = if blended { &[("BLENDED", 1.0)] } else { &[] };
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&format!("{pass:?} {variant:?}")),
                layout: Some(layout),
                vertex: wgpu::VertexState {
                    module,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &SURFACE_BUFFERS,
                },
                primitive: wgpu::PrimitiveState {
                    front_face: front_face(variant.mirrored),
                    cull_mode: variant.culled.then_some(wgpu::Face::Back),
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: context.depth_stencil_format(),
                    depth_write_enabled: Some(depth_write),
                    depth_compare: Some(depth_compare),
                    stencil,
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants,
                        ..Default::default()
                    },
                    targets: if matches!(pass, SurfacePass::FrontDepth | SurfacePass::HostSurface) {
                        &[]
                    } else {
                        std::slice::from_ref(&color)
                    },
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// How fronts wind on the screen.
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
