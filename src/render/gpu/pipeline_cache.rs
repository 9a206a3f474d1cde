//! The cache of pipelines. It maps a description to its pipeline, which is made once for all views.

use std::collections::HashMap;
use std::hash::Hash;
use std::sync::{Mutex, MutexGuard, PoisonError};

use smallvec::SmallVec;

use crate::render::{RenderContext, RenderError, Shaders};

/// An entry point of a shader file.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stage {
    /// The path of the file below `shaders/`.
    pub file: &'static str,
    /// The name of the entry point.
    pub entry: &'static str,
}

impl Stage {
    /// Names an entry point of a file.
    pub const fn new(file: &'static str, entry: &'static str) -> Self {
        Self { file, entry }
    }
}

/// The file of the vertex stages that cover the whole target with one triangle.
const FULL_SCREEN: &str = "passes/full_screen.wgsl";

/// Draws one triangle over the whole target.
pub const EVERYWHERE: Stage = Stage::new(FULL_SCREEN, "everywhere");
/// Draws one triangle over the whole target, at the depth whose bits are the instance index.
pub const EVERYWHERE_AT_DEPTH: Stage = Stage::new(FULL_SCREEN, "at_depth");
/// Draws one triangle over the whole target, and gives the instance index to the fragment stage at location
/// 0.
pub const EVERYWHERE_WITH_INSTANCE: Stage = Stage::new(FULL_SCREEN, "with_instance");

/// Everything that distinguishes two pipelines. It is the key of the cache.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct PipelineDesc {
    /// The name that debuggers show.
    pub label: &'static str,
    /// The layouts of the bind groups 0 to 3. A layout is `None` if the pipeline reads no such group.
    pub groups: [Option<wgpu::BindGroupLayout>; 4],
    /// The vertex stage.
    pub vertex: Stage,
    /// The vertex buffers.
    pub buffers: &'static [wgpu::VertexBufferLayout<'static>],
    /// The fragment stage, if the pipeline has one.
    pub fragment: Option<Stage>,
    /// The `override` constants of the fragment stage, and the bits of their values.
    pub constants: SmallVec<[(&'static str, u64); 8]>,
    /// The colour targets.
    pub targets: SmallVec<[Option<wgpu::ColorTargetState>; 4]>,
    /// The topology, the culling and the winding of triangles.
    pub primitive: wgpu::PrimitiveState,
    /// The depth and stencil test, if the pass has such an attachment.
    pub depth_stencil: Option<wgpu::DepthStencilState>,
}

impl PipelineDesc {
    /// Describes a pipeline of triangles without buffers, tests and targets.
    pub fn new(label: &'static str, vertex: Stage, fragment: Option<Stage>) -> Self {
        Self {
            label,
            groups: Default::default(),
            vertex,
            buffers: &[],
            fragment,
            constants: SmallVec::new(),
            targets: SmallVec::new(),
            primitive: Default::default(),
            depth_stencil: None,
        }
    }

    /// Sets the bind groups. A layout is `None` if the pipeline does not read that group.
    pub fn with_groups<const N: usize>(mut self, groups: [Option<&wgpu::BindGroupLayout>; N]) -> Self {
        for (slot, group) in self.groups.iter_mut().zip(groups) {
            *slot = group.cloned();
        }
        self
    }

    /// Adds `override` constants of the fragment stage.
    pub fn with_constants<const N: usize>(mut self, constants: [(&'static str, f64); N]) -> Self {
        self.constants
            .extend(constants.map(|(name, value)| (name, value.to_bits())));
        self
    }

    /// Adds one more colour target.
    pub fn with_target(
        mut self,
        format: wgpu::TextureFormat,
        blend: Option<wgpu::BlendState>,
        write_mask: wgpu::ColorWrites,
    ) -> Self {
        self.targets.push(Some(wgpu::ColorTargetState {
            format,
            blend,
            write_mask,
        }));
        self
    }

    /// Sets the depth and stencil test.
    pub fn with_depth(
        mut self,
        format: wgpu::TextureFormat,
        writes: bool,
        compare: wgpu::CompareFunction,
        stencil: wgpu::StencilState,
    ) -> Self {
        self.depth_stencil = Some(wgpu::DepthStencilState {
            format,
            depth_write_enabled: Some(writes),
            depth_compare: Some(compare),
            stencil,
            bias: Default::default(),
        });
        self
    }
}

/// The blend state that adds.
pub const ADD: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Add,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
};

/// Keeps the lesser of both, component by component.
pub const LESSER: wgpu::BlendState = {
    let component = wgpu::BlendComponent {
        src_factor: wgpu::BlendFactor::One,
        dst_factor: wgpu::BlendFactor::One,
        operation: wgpu::BlendOperation::Min,
    };
    wgpu::BlendState {
        color: component,
        alpha: component,
    }
};

#[derive(Default)]
struct Entries {
    modules: HashMap<&'static str, wgpu::ShaderModule>,
    pipelines: HashMap<PipelineDesc, wgpu::RenderPipeline>,
}

/// The pipelines and shader modules made so far.
#[derive(Default)]
pub struct PipelineCache {
    entries: Mutex<Entries>,
}

impl std::fmt::Debug for PipelineCache {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("PipelineCache")
            .field("count", &self.count())
            .finish_non_exhaustive()
    }
}

impl PipelineCache {
    fn entries(&self) -> MutexGuard<'_, Entries> {
        // An entry is added whole or not at all, so a panic elsewhere leaves the maps usable.
        self.entries.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The number of pipelines made so far. It does not grow in a steady frame.
    pub fn count(&self) -> usize {
        self.entries().pipelines.len()
    }

    /// Returns the module of a shader file. It is composed on first use.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn module(
        &self,
        context: &RenderContext,
        shaders: &Shaders,
        file: &'static str,
    ) -> Result<wgpu::ShaderModule, RenderError> {
        module(&mut self.entries(), context, shaders, file)
    }

    /// Returns the pipeline of a description. It is made on first use.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn pipeline(
        &self,
        context: &RenderContext,
        shaders: &Shaders,
        desc: PipelineDesc,
    ) -> Result<wgpu::RenderPipeline, RenderError> {
        let mut entries = self.entries();
        if let Some(known) = entries.pipelines.get(&desc) {
            return Ok(known.clone());
        }
        let vertex = module(&mut entries, context, shaders, desc.vertex.file)?;
        let fragment = match desc.fragment {
            Some(stage) => Some((module(&mut entries, context, shaders, stage.file)?, stage.entry)),
            None => None,
        };
        let pipeline = create(context, &desc, &vertex, fragment.as_ref());
        entries.pipelines.insert(desc, pipeline.clone());
        Ok(pipeline)
    }
}

fn module(
    entries: &mut Entries,
    context: &RenderContext,
    shaders: &Shaders,
    file: &'static str,
) -> Result<wgpu::ShaderModule, RenderError> {
    if let Some(known) = entries.modules.get(file) {
        return Ok(known.clone());
    }
    let module = shaders.module(&context.device, file)?;
    entries.modules.insert(file, module.clone());
    Ok(module)
}

fn create(
    context: &RenderContext,
    desc: &PipelineDesc,
    vertex: &wgpu::ShaderModule,
    fragment: Option<&(wgpu::ShaderModule, &'static str)>,
) -> wgpu::RenderPipeline {
    let device = &context.device;
    let last = desc
        .groups
        .iter()
        .rposition(Option::is_some)
        .map_or(0, |at| at + 1);
    let groups: SmallVec<[_; 4]> = desc.groups[..last].iter().map(Option::as_ref).collect();
    let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
        label: Some(desc.label),
        bind_group_layouts: &groups,
        immediate_size: 0,
    });
    let constants: SmallVec<[_; 8]> = desc
        .constants
        .iter()
        .map(|&(name, bits)| (name, f64::from_bits(bits)))
        .collect();
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some(desc.label),
        layout: Some(&layout),
        vertex: wgpu::VertexState {
            module: vertex,
            entry_point: Some(desc.vertex.entry),
            compilation_options: Default::default(),
            buffers: desc.buffers,
        },
        primitive: desc.primitive,
        depth_stencil: desc.depth_stencil.clone(),
        multisample: Default::default(),
        fragment: fragment.map(|(module, entry)| wgpu::FragmentState {
            module,
            entry_point: Some(entry),
            compilation_options: wgpu::PipelineCompilationOptions {
                constants: &constants,
                ..Default::default()
            },
            targets: &desc.targets,
        }),
        multiview_mask: None,
        cache: None,
    })
}

/// The pipelines with which one recorder draws, by a key of the recorder's own. They are handles into the
/// shared cache, so recording takes no lock.
#[derive(Debug)]
pub struct Variants<K> {
    known: Vec<(K, wgpu::RenderPipeline)>,
}

impl<K> Default for Variants<K> {
    fn default() -> Self {
        Self { known: Vec::new() }
    }
}

impl<K: Copy + PartialEq> Variants<K> {
    /// Returns the pipeline of a key, if [`Variants::insert`] has stored it. The search is linear, because a
    /// recorder has few pipelines.
    pub fn get(&self, key: K) -> Option<&wgpu::RenderPipeline> {
        let found = self.known.iter().find(|(known, _)| *known == key);
        found.map(|(_, pipeline)| pipeline)
    }

    /// Stores the pipeline of a key.
    pub fn insert(&mut self, key: K, pipeline: wgpu::RenderPipeline) {
        self.known.push((key, pipeline));
    }
}
