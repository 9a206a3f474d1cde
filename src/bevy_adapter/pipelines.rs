//! Pipelines of the base draw and of the lights: Bevy's own deferred lighting, with our shaders in its place.
//!
//! Shaders `shaders/bevy/base.wgsl`, `shaders/bevy/light.wgsl`
//! Groups  0 Bevy's view, 1 Bevy's binding arrays, 2 ours, 3 the mask of a light
//!
//! Shader definitions and layouts of groups 0 and 1 depend on features of Bevy that another crate cannot see. So each
//! descriptor is the one that Bevy makes for its own deferred lighting of this view, with shader, group 2, blending and
//! stencil exchanged.

use std::sync::Arc;

use bevy::asset::{Assets, Handle};
use bevy::core_pipeline::FullscreenShader;
use bevy::ecs::prelude::*;
use bevy::pbr::MeshPipelineKey;
use bevy::pbr::deferred::{DEFAULT_PBR_DEFERRED_LIGHTING_PASS_ID, DeferredLightingLayout};
use bevy::platform::collections::HashMap;
use bevy::render::render_resource::binding_types::{
    storage_buffer_read_only_sized, texture_2d, uniform_buffer_sized,
};
use bevy::render::render_resource::{
    BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendComponent, BlendFactor, BlendOperation,
    BlendState, CachedPipelineState, CachedRenderPipelineId, CompareFunction, DepthBiasState,
    DepthStencilState, PipelineCache, RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
    TextureFormat, TextureSampleType, VertexState,
};
use bevy::shader::{Shader, ShaderDefVal};

use super::light_convert::BevyLight;
use super::view_state::LightDraw;
use crate::render::Gpu;
use crate::render::frame::hosted;

/// Where a light's visibility comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VisibilitySource {
    /// The stencil test keeps what is lit.
    Stencil,
    /// The stencil test keeps what is shadowed; of that, what shows no shadows is lit.
    Unshadowed,
    /// A mask, where the stencil test keeps what the light reaches and affects.
    Mask,
    /// The same, and the mask holds for surfaces that show no shadows too.
    Scaled,
}

/// The pipelines of one kind of light in one view, by [`VisibilitySource`].
#[derive(Clone, Copy, Debug)]
pub struct LightPipelines(pub [Option<CachedRenderPipelineId>; 4]);

impl LightPipelines {
    /// That for a kind of visibility, if it was asked for.
    pub fn get(&self, visibility: VisibilitySource) -> Option<CachedRenderPipelineId> {
        self.0[visibility as usize]
    }
}

/// Our shaders, as assets of the main world.
#[derive(Resource, Clone)]
pub struct AntumbraShaders {
    base: Handle<Shader>,
    light: Handle<Shader>,
}

impl AntumbraShaders {
    /// Adds them.
    pub fn add(shaders: &mut Assets<Shader>) -> Self {
        let mut add = |text: &'static str, path: &str| shaders.add(Shader::from_wgsl(text, path));
        Self {
            base: add(
                include_str!("../../shaders/bevy/base.wgsl"),
                "antumbra/bevy/base.wgsl",
            ),
            light: add(
                include_str!("../../shaders/bevy/light.wgsl"),
                "antumbra/bevy/light.wgsl",
            ),
        }
    }
}

/// Layouts of our groups, and every pipeline that was asked for. Made anew with each device.
#[derive(Resource)]
pub struct AntumbraPipelines {
    /// Pipelines, meshes and materials of our own passes, for all views; `None` before the first.
    pub resident: Option<Arc<Gpu>>,
    shaders: AntumbraShaders,
    vertex: VertexState,
    /// Group 2 of the base draw.
    pub base_layout: BindGroupLayoutDescriptor,
    /// Group 2 of a light.
    pub light_layout: BindGroupLayoutDescriptor,
    /// Group 3 of a light with a mask.
    pub mask_layout: BindGroupLayoutDescriptor,
    base: HashMap<MeshPipelineKey, CachedRenderPipelineId>,
    lights: HashMap<(MeshPipelineKey, BevyLight, VisibilitySource, TextureFormat), CachedRenderPipelineId>,
}

/// Makes [`AntumbraPipelines`]. `RenderStartup`: after a lost device too.
pub(super) fn init_pipelines(
    mut commands: Commands,
    shaders: Res<AntumbraShaders>,
    fullscreen: Res<FullscreenShader>,
) {
    let uint = || texture_2d(TextureSampleType::Uint);
    let float = || texture_2d(TextureSampleType::Float { filterable: false });
    let storage = || storage_buffer_read_only_sized(false, None);
    let draw = uniform_buffer_sized(true, std::num::NonZero::new(size_of::<LightDraw>() as u64));
    let layout = |label: &'static str, entries: &[_]| BindGroupLayoutDescriptor::new(label, entries);
    let stage = ShaderStages::FRAGMENT;
    commands.insert_resource(AntumbraPipelines {
        resident: None,
        shaders: shaders.clone(),
        vertex: fullscreen.to_vertex_state(),
        base_layout: layout(
            "antumbra base",
            &BindGroupLayoutEntries::sequential(stage, (storage(), storage(), uint())),
        ),
        light_layout: layout(
            "antumbra light",
            &BindGroupLayoutEntries::sequential(stage, (draw, uint())),
        ),
        mask_layout: layout("antumbra mask", &BindGroupLayoutEntries::single(stage, float())),
        base: HashMap::default(),
        lights: HashMap::default(),
    });
}

impl AntumbraPipelines {
    /// The pipeline of the base draw of views with this key.
    pub fn base(
        &mut self,
        cache: &PipelineCache,
        bevy: &DeferredLightingLayout,
        key: MeshPipelineKey,
    ) -> CachedRenderPipelineId {
        if let Some(&known) = self.base.get(&key) {
            return known;
        }
        let mut descriptor =
            self.descriptor(bevy, key, "antumbra base", &self.shaders.base, &self.base_layout);
        descriptor.depth_stencil = None;
        let queued = cache.queue_render_pipeline(descriptor);
        self.base.insert(key, queued);
        queued
    }

    /// The pipeline of lights of a kind in views with this key. `depth_stencil` is the format of our attachment.
    pub fn light(
        &mut self,
        cache: &PipelineCache,
        bevy: &DeferredLightingLayout,
        key: MeshPipelineKey,
        kind: BevyLight,
        visibility: VisibilitySource,
        depth_stencil: TextureFormat,
    ) -> CachedRenderPipelineId {
        let variant = (key, kind, visibility, depth_stencil);
        if let Some(&known) = self.lights.get(&variant) {
            return known;
        }
        let mut descriptor = self.descriptor(
            bevy,
            key,
            "antumbra light",
            &self.shaders.light,
            &self.light_layout,
        );
        let is_masked = matches!(visibility, VisibilitySource::Mask | VisibilitySource::Scaled);
        if is_masked {
            descriptor.layout.push(self.mask_layout.clone());
        }
        descriptor.depth_stencil = Some(DepthStencilState {
            format: depth_stencil,
            depth_write_enabled: Some(false),
            depth_compare: Some(CompareFunction::Always),
            stencil: match visibility {
                VisibilitySource::Unshadowed => hosted::stencil_shadowed(),
                _ => hosted::stencil_lit(),
            },
            bias: DepthBiasState::default(),
        });
        if let Some(fragment) = &mut descriptor.fragment {
            let kind = match kind {
                BevyLight::Point => "LIGHT_POINT",
                BevyLight::Spot => "LIGHT_SPOT",
                BevyLight::Directional => "LIGHT_DIRECTIONAL",
                BevyLight::Rect => "LIGHT_RECT",
            };
            fragment.shader_defs.push(kind.into());
            match visibility {
                VisibilitySource::Mask => fragment.shader_defs.push("VISIBILITY_MASK".into()),
                VisibilitySource::Scaled => {
                    let defs = ["VISIBILITY_MASK", "MASK_HOLDS_FOR_ALL"];
                    fragment.shader_defs.extend(defs.map(ShaderDefVal::from));
                }
                VisibilitySource::Unshadowed => fragment.shader_defs.push("UNSHADOWED_ONLY".into()),
                VisibilitySource::Stencil => {}
            }
            for target in fragment.targets.iter_mut().flatten() {
                target.blend = Some(ADD);
            }
        }
        let queued = cache.queue_render_pipeline(descriptor);
        self.lights.insert(variant, queued);
        queued
    }

    fn descriptor(
        &self,
        bevy: &DeferredLightingLayout,
        key: MeshPipelineKey,
        label: &'static str,
        shader: &Handle<Shader>,
        own: &BindGroupLayoutDescriptor,
    ) -> RenderPipelineDescriptor {
        let mut descriptor = bevy.specialize(key);
        descriptor.label = Some(label.into());
        descriptor.layout.truncate(2);
        descriptor.layout.push(own.clone());
        descriptor.vertex = self.vertex.clone();
        if let Some(fragment) = &mut descriptor.fragment {
            fragment.shader = shader.clone();
            fragment.entry_point = Some("fragment".into());
            fragment.shader_defs.push(ShaderDefVal::UInt(
                "DEFERRED_PASS_ID".into(),
                u32::from(DEFAULT_PBR_DEFERRED_LIGHTING_PASS_ID),
            ));
        }
        descriptor
    }
}

/// Adds light; alpha stays.
const ADD: BlendState = BlendState {
    color: BlendComponent {
        src_factor: BlendFactor::One,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    },
    alpha: BlendComponent {
        src_factor: BlendFactor::Zero,
        dst_factor: BlendFactor::One,
        operation: BlendOperation::Add,
    },
};

/// Whether a pipeline can be drawn with in this frame, or will be before it is drawn.
pub(super) fn is_ready(cache: &PipelineCache, id: CachedRenderPipelineId) -> bool {
    matches!(cache.get_render_pipeline_state(id), CachedPipelineState::Ok(_))
}
