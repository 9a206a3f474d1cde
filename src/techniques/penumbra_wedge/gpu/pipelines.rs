//! Pipelines of wedges, made when a frame first needs them and kept.

use super::form::Form;
use crate::conventions::{STENCIL_COUNT_MASK, STENCIL_IN_BOUNDS};
use crate::render::frame::targets::{MASK_FORMAT, RADIANCE_FORMAT};
use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::nodes::pipelines::front_face;
use crate::render::{RenderContext, RenderError, Shaders};

/// What a draw draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// The casters' own triangles of these [layers](crate::techniques::penumbra_wedge::geometry::silhouette_layers).
    NearCap(u8),
    /// The same at infinity.
    FarCap(u8),
    /// Back faces of shells, wherever the surface is.
    ShellEverywhere,
    /// Back faces of shells that lie behind the surface.
    Shell,
    /// Separators with the hard shadow's sides.
    Separator,
    /// Sides of the hard shadow.
    HardSide,
    /// Marks what lies before a half, for section 4.4.
    Mark,
    /// Back faces of an outer half, where it is not marked.
    OuterHalf,
    /// Back faces of an inner half, where it is not marked.
    InnerHalf,
    /// The debug view.
    Show,
}

/// All that tells two pipelines of these passes apart; the key of the cache.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// Stages and states.
    pub part: Part,
    /// Targets.
    pub form: Form,
    /// The light is a sphere.
    pub is_sphere: bool,
    /// Angles and areas come from tables.
    pub looks_up: bool,
    /// Faces before the surface count, not those behind it.
    pub towards: bool,
    /// The view mirrors.
    pub mirrored: bool,
}

/// All that tells two pipelines of the resolve apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ResolveKey {
    /// What is read.
    pub form: Form,
    /// The light is a sphere.
    pub is_sphere: bool,
    /// Writes the combined coverage rather than the mask.
    pub combines: bool,
    /// Reads the combined coverage.
    pub is_combined: bool,
}

/// Format of the combined coverage of groups.
pub const COMBINED_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;

/// The cache.
#[derive(Debug)]
pub struct WedgePipelines {
    wedge: wgpu::ShaderModule,
    resolve: wgpu::ShaderModule,
    wedge_layout: wgpu::PipelineLayout,
    /// Without receivers: the debug view is drawn into the light pass.
    debug_layout: wgpu::PipelineLayout,
    resolve_layout: wgpu::PipelineLayout,
    wedges: Vec<(Key, wgpu::RenderPipeline)>,
    resolves: Vec<(ResolveKey, wgpu::RenderPipeline)>,
}

const fn adding() -> wgpu::BlendState {
    let add = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: add,
        alpha: add,
    }
}

impl WedgePipelines {
    /// Compiles the shaders.
    ///
    /// # Errors
    /// [`RenderError::Shader`].
    pub fn new(
        context: &RenderContext,
        shaders: &Shaders,
        layouts: &BindGroupLayouts,
        wedges: &wgpu::BindGroupLayout,
        sums: &wgpu::BindGroupLayout,
    ) -> Result<Self, RenderError> {
        let device = &context.device;
        let layout = |label, groups: &[Option<&wgpu::BindGroupLayout>]| {
            device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
                label: Some(label),
                bind_group_layouts: groups,
                immediate_size: 0,
            })
        };
        Ok(Self {
            wedge: shaders.module(device, "techniques/penumbra_wedge/wedge.wgsl")?,
            resolve: shaders.module(device, "techniques/penumbra_wedge/resolve.wgsl")?,
            wedge_layout: layout(
                "penumbra wedge",
                &[Some(&layouts.view), Some(&layouts.receiver), Some(wedges)],
            ),
            debug_layout: layout("wedge debug view", &[Some(&layouts.view), None, Some(wedges)]),
            resolve_layout: layout(
                "penumbra wedge resolve",
                &[
                    Some(&layouts.view),
                    Some(&layouts.receiver),
                    Some(wedges),
                    Some(sums),
                ],
            ),
            wedges: Vec::new(),
            resolves: Vec::new(),
        })
    }

    /// The pipeline, if [`WedgePipelines::require`] has made it.
    pub fn get(&self, key: Key) -> Option<&wgpu::RenderPipeline> {
        let found = self.wedges.iter().find(|(known, _)| *known == key);
        found.map(|(_, pipeline)| pipeline)
    }

    /// The pipeline, if [`WedgePipelines::require_resolve`] has made it.
    pub fn get_resolve(&self, key: ResolveKey) -> Option<&wgpu::RenderPipeline> {
        let found = self.resolves.iter().find(|(known, _)| *known == key);
        found.map(|(_, pipeline)| pipeline)
    }

    /// Makes the pipeline if it does not exist yet.
    pub fn require(&mut self, context: &RenderContext, key: Key) {
        if self.get(key).is_none() {
            let pipeline = self.create(context, key);
            self.wedges.push((key, pipeline));
        }
    }

    /// Makes the pipeline if it does not exist yet.
    pub fn require_resolve(&mut self, context: &RenderContext, key: ResolveKey) {
        if self.get_resolve(key).is_none() {
            let pipeline = self.create_resolve(context, key);
            self.resolves.push((key, pipeline));
        }
    }

    fn create(&self, context: &RenderContext, key: Key) -> wgpu::RenderPipeline {
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
        let is_split = key.form == Form::Split8;
        let fragment = match (key.part, is_split) {
            (Part::NearCap(_) | Part::FarCap(_), false) => "cap",
            (Part::NearCap(_) | Part::FarCap(_), true) => "cap_split",
            (Part::ShellEverywhere | Part::Shell, false) => "shell",
            (Part::ShellEverywhere | Part::Shell, true) => "shell_split",
            (Part::Separator, false) => "separator",
            (Part::Separator, true) => "separator_split",
            (Part::HardSide | Part::Mark, false) => "hard_side",
            (Part::HardSide | Part::Mark, true) => "hard_side_split",
            (Part::OuterHalf | Part::InnerHalf, false) => "half",
            (Part::OuterHalf | Part::InnerHalf, true) => "half_split",
            (Part::Show, _) => "debug",
        };
        let debug = key.part == Part::Show;
        let sign = if key.part == Part::OuterHalf { -1.0 } else { 1.0 };
        let layers = match key.part {
            Part::NearCap(layers) | Part::FarCap(layers) => f64::from(layers),
            _ => 3.0,
        };
        let constants = [
            ("IS_SPHERE", f64::from(key.is_sphere)),
            ("HALF_SIGN", sign),
            ("FACE_SIGN", if key.towards { -1.0 } else { 1.0 }),
            ("CAP_LAYERS", layers),
            ("LOOKS_UP", f64::from(key.looks_up)),
            ("IS_TEXTURED", f64::from(key.form.is_textured())),
            ("IS_SAMPLED", f64::from(key.form.is_sampled())),
            ("IS_DEEP", f64::from(key.form.is_deep())),
            // Beside counts of 256 there is less room for what comes after the point.
            ("STEPS", if key.form.is_deep() { 1024.0 } else { 16384.0 }),
        ];
        let formats = if debug {
            &[RADIANCE_FORMAT][..]
        } else {
            key.form.formats()
        };
        let targets: Vec<_> = formats
            .iter()
            .map(|&format| {
                Some(wgpu::ColorTargetState {
                    format,
                    blend: Some(adding()),
                    write_mask: if key.part == Part::Mark {
                        wgpu::ColorWrites::empty()
                    } else {
                        wgpu::ColorWrites::ALL
                    },
                })
            })
            .collect();
        // Faces behind the surface or on it count: what lies on it counts as behind for both halves and for caps. Counted
        // towards the viewer, it is the rest that counts.
        let depth_compare = match key.part {
            Part::ShellEverywhere => Always,
            Part::Show => Greater,
            _ if key.towards => Greater,
            _ => LessEqual,
        };
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&format!("penumbra wedge {key:?}")),
                layout: Some(if debug {
                    &self.debug_layout
                } else {
                    &self.wedge_layout
                }),
                vertex: wgpu::VertexState {
                    module: &self.wedge,
                    entry_point: Some(vertex),
                    compilation_options: Default::default(),
                    buffers,
                },
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
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: context.depth_stencil_format(),
                    depth_write_enabled: Some(false),
                    depth_compare: Some(depth_compare),
                    stencil: stencil(key.part),
                    bias: Default::default(),
                }),
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &self.wedge,
                    entry_point: Some(fragment),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    targets: &targets,
                }),
                multiview_mask: None,
                cache: None,
            })
    }

    fn create_resolve(&self, context: &RenderContext, key: ResolveKey) -> wgpu::RenderPipeline {
        let constants = [
            ("IS_SPLIT", f64::from(key.form == Form::Split8)),
            ("IS_SPHERE", f64::from(key.is_sphere)),
            ("IS_TEXTURED", f64::from(key.form.is_textured())),
            ("IS_SAMPLED", f64::from(key.form.is_sampled())),
            ("IS_DEEP", f64::from(key.form.is_deep())),
            (
                "IS_SCALAR",
                f64::from(matches!(key.form, Form::Float | Form::Half)),
            ),
            ("IS_COMBINED", f64::from(key.is_combined)),
        ];
        let weighted = wgpu::BlendComponent {
            src_factor: wgpu::BlendFactor::Constant,
            dst_factor: wgpu::BlendFactor::One,
            operation: wgpu::BlendOperation::Add,
        };
        let (entry_point, format, blend) = if key.combines {
            ("combine", COMBINED_FORMAT, None)
        } else {
            let blend = wgpu::BlendState {
                color: weighted,
                alpha: weighted,
            };
            ("resolve", MASK_FORMAT, Some(blend))
        };
        context
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some(&format!("penumbra wedge {key:?}")),
                layout: Some(&self.resolve_layout),
                vertex: wgpu::VertexState {
                    module: &self.resolve,
                    entry_point: Some("vertex"),
                    compilation_options: Default::default(),
                    buffers: &[],
                },
                primitive: Default::default(),
                depth_stencil: None,
                multisample: Default::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &self.resolve,
                    entry_point: Some(entry_point),
                    compilation_options: wgpu::PipelineCompilationOptions {
                        constants: &constants,
                        ..Default::default()
                    },
                    targets: &[Some(wgpu::ColorTargetState {
                        format,
                        blend,
                        write_mask: wgpu::ColorWrites::ALL,
                    })],
                }),
                multiview_mask: None,
                cache: None,
            })
    }
}

/// Draws look at pixels in bounds. Section 4.4: fronts of a half that lie behind the surface mark it, backs are shaded
/// where nothing is marked, and take the mark away where something is. The paper marks with what lies before the
/// surface; marking with what lies behind it stays right when the eye is inside of the wedge.
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
