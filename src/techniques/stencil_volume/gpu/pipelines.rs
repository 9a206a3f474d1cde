//! Pipelines of shadow volumes, made when a frame first needs them and kept.

use crate::conventions::{STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS};
use crate::render::frame::targets::RADIANCE_FORMAT;
use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::gpu::stencil_only::no_color;
use crate::render::nodes::pipelines::front_face;
use crate::render::{RenderContext, RenderError, Shaders};

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

/// Everything that distinguishes two pipelines of this pass; the key of the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Key {
    /// The part that is drawn, which chooses the vertex stage.
    pub part: Part,
    /// Whether the volume is counted towards the viewer.
    pub depth_pass: bool,
    /// Whether the part's outward faces wind clockwise on the screen. They do if view or caster mirrors, but
    /// not both, and the other way round for triangles that are wound inward.
    pub clockwise: bool,
}

impl Key {
    fn index(self) -> usize {
        self.part as usize * 4 + usize::from(self.depth_pass) * 2 + usize::from(self.clockwise)
    }
}

const KEY_COUNT: usize = 12;

/// What a volume is drawn for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// Counting in the stencil.
    Count,
    /// The debug view.
    Show,
}

/// The pipelines of shadow volumes, cached.
#[derive(Debug)]
pub struct VolumePipelines {
    module: wgpu::ShaderModule,
    layout: wgpu::PipelineLayout,
    pipelines: [[Option<wgpu::RenderPipeline>; KEY_COUNT]; 2],
}

impl VolumePipelines {
    /// Compiles the shader; `casters` is the layout of group 2.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
        casters: &wgpu::BindGroupLayout,
    ) -> Result<Self, RenderError> {
        Ok(Self {
            module: shaders.module(&context.device, "techniques/stencil_volume/volume.wgsl")?,
            layout: context
                .device
                .create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                    label: Some("stencil volume"),
                    bind_group_layouts: &[Some(&layouts.view), None, Some(casters), Some(&layouts.positions)],
                    immediate_size: 0,
                }),
            pipelines: Default::default(),
        })
    }

    /// The pipeline, if [`VolumePipelines::require`] has made it.
    pub fn get(&self, key: Key, purpose: Purpose) -> Option<&wgpu::RenderPipeline> {
        self.pipelines[purpose as usize][key.index()].as_ref()
    }

    /// Makes the pipeline if it does not exist yet.
    pub fn require(&mut self, context: &RenderContext, key: Key, purpose: Purpose) {
        if self.get(key, purpose).is_none() {
            self.pipelines[purpose as usize][key.index()] = Some(self.create(context, key, purpose));
        }
    }

    fn create(&self, context: &RenderContext, key: Key, purpose: Purpose) -> wgpu::RenderPipeline {
        let debug = purpose == Purpose::Show;
        const POSITIONS: &[wgpu::VertexBufferLayout] = &[wgpu::VertexBufferLayout {
            array_stride: 12,
            step_mode: wgpu::VertexStepMode::Vertex,
            attributes: &wgpu::vertex_attr_array![0 => Float32x3],
        }];
        let (entry_point, buffers) = match key.part {
            Part::Side => ("side", &[] as &[_]),
            Part::NearCap => ("near_cap", POSITIONS),
            Part::FarCap => ("far_cap", POSITIONS),
        };
        // RGBA bytes, red lowest. Depth-pass: blue fronts, green backs; depth-fail: orange fronts, magenta backs.
        let [front, back] = if key.depth_pass {
            [0xff40_1000_u32, 0xff10_4000]
        } else {
            [0xff00_2040, 0xff30_0040]
        };
        let constants = [("DEBUG_FRONT", f64::from(front)), ("DEBUG_BACK", f64::from(back))];
        let added = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::One,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let debug_targets = [Some(wgpu::ColorTargetState {
            format: RADIANCE_FORMAT,
            blend: Some(wgpu::BlendState {
                color: added,
                alpha: added,
            }),
            write_mask: wgpu::ColorWrites::COLOR,
        })];
        let fragment = if debug {
            wgpu::FragmentState {
                module: &self.module,
                entry_point: Some("debug"),
                compilation_options: wgpu::PipelineCompilationOptions {
                    constants: &constants,
                    ..Default::default()
                },
                targets: &debug_targets,
            }
        } else {
            no_color(&self.module)
        };
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&format!("stencil volume {key:?}")),
                layout: Some(&self.layout),
                vertex: wgpu::VertexState {
                    module: &self.module,
                    entry_point: Some(entry_point),
                    compilation_options: Default::default(),
                    buffers,
                },
                primitive: wgpu::PrimitiveState {
                    front_face: front_face(key.clockwise),
                    cull_mode: None,
                    ..Default::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: context.depth_stencil_format(),
                    depth_write_enabled: Some(false),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: if debug {
                        Default::default()
                    } else {
                        counting_stencil(key.depth_pass)
                    },
                    bias: ALL_FARTHER,
                }),
                multisample: Default::default(),
                fragment: Some(fragment),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// Pushes every face of a volume farther from the viewer by as much as the rasterizer rounds: half a step of
/// the grid of 1/256 pixel to which vertices snap, and one unit of depth.
///
/// Where two faces meet in an edge on a surface, rounding may put one in front of the surface and the other
/// behind it. The volume then counts −1 there, which cancels another volume's shadow. A face at the depth of
/// a surface counts as behind it; with this bias, so does a face that differs from it only by rounding. The
/// cost is that shadows move by 1/512 pixel. Of the 39 models of the tests, 7 had a wrong pixel off the edges
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
