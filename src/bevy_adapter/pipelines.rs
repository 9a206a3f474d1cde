//! Pipelines of the base draw and of the lights. They are Bevy's pipelines of deferred lighting with other
//! shaders.
//!
//! Shaders `shaders/bevy/base.wgsl`, `shaders/bevy/light.wgsl`
//! Groups  0 Bevy's view, 1 Bevy's binding arrays, 2 the managed lights or one light, 3 the mask of a light
//!
//! Shader definitions and the layouts of groups 0 and 1 depend on features of Bevy that another crate cannot
//! see. So each descriptor starts as the one that Bevy makes for its own deferred lighting of the view.
//! Shader, group 2, blending and stencil are then replaced.

use std::sync::Arc;

use bevy::asset::{Assets, Handle};
use bevy::core_pipeline::FullscreenShader;
use bevy::ecs::prelude::*;
use bevy::pbr::MeshPipelineKey;
use bevy::pbr::deferred::{DEFAULT_PBR_DEFERRED_LIGHTING_PASS_ID, DeferredLightingLayout};
use bevy::platform::collections::HashMap;
use bevy::render::render_resource::binding_types::{
    storage_buffer_read_only_sized, texture_2d, texture_2d_array, uniform_buffer_sized,
};
use bevy::render::render_resource::{
    BindGroup, BindGroupLayoutDescriptor, BindGroupLayoutEntries, BlendComponent, BlendFactor,
    BlendOperation, BlendState, CachedPipelineState, CachedRenderPipelineId, CompareFunction, DepthBiasState,
    DepthStencilState, PipelineCache, RenderPipelineDescriptor, ShaderStages, SpecializedRenderPipeline,
    TextureFormat, TextureSampleType, VertexState,
};
use bevy::render::renderer::RenderDevice;
use bevy::shader::{Shader, ShaderDefVal};

use super::forward_views::MASK_GROUP;
use super::light_convert::BevyLight;
use super::view_state::LightDraw;
use crate::render::Gpu;
use crate::render::frame::hosted;

/// The source of a light's visibility.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum VisibilitySource {
    /// The stencil test passes lit pixels.
    Stencil,
    /// The stencil test passes shadowed pixels, and the shader lights those whose surface shows no shadows.
    Unshadowed,
    /// The mask holds the visibility, and the stencil test passes pixels that the light reaches and affects.
    /// Surfaces that show no shadows ignore the mask.
    Mask,
    /// The mask holds the visibility as for `Mask`, and it also applies to surfaces that show no shadows.
    Scaled,
    /// The mask holds the visibility of all surfaces, and a second mask the factors of light functions. Ambient,
    /// diffuse and specular light are added apart, with their weights and the colour of the shadow.
    Terms,
}

/// The pipelines of one kind of light in one view, indexed by [`VisibilitySource`].
#[derive(Clone, Copy, Debug)]
pub struct LightPipelines(pub [Option<CachedRenderPipelineId>; 5]);

impl LightPipelines {
    /// Returns the pipeline for a source of visibility, if it was asked for.
    pub fn get(&self, visibility: VisibilitySource) -> Option<CachedRenderPipelineId> {
        self.0[visibility as usize]
    }
}

/// Handles of this crate's shaders for Bevy, which are assets of the main world.
#[derive(Resource, Clone)]
pub struct AntumbraShaders {
    base: Handle<Shader>,
    light: Handle<Shader>,
}

impl AntumbraShaders {
    /// Adds the shaders to the assets.
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

/// Layouts of this crate's bind groups, and every pipeline that was asked for. The resource is made again
/// with each device.
#[derive(Resource)]
pub struct AntumbraPipelines {
    /// Pipelines, meshes and materials of this crate's own passes, shared by all views; `None` before the
    /// first view.
    pub resident: Option<Arc<Gpu>>,
    shaders: AntumbraShaders,
    vertex: VertexState,
    /// Layout of group 2 of the base draw.
    pub base_layout: BindGroupLayoutDescriptor,
    /// Layout of group 2 of a light.
    pub light_layout: BindGroupLayoutDescriptor,
    /// Layout of group 3 of a light with a mask.
    pub mask_layout: BindGroupLayoutDescriptor,
    /// Layout of group 4 of forward meshes; `None` if the device allows four groups only.
    pub forward_layout: Option<BindGroupLayoutDescriptor>,
    /// Group 4 of forward meshes in views that are not ready.
    pub(super) forward_neutral: Option<BindGroup>,
    /// Layout of group 3 of a light whose terms are weighted.
    pub masks_layout: BindGroupLayoutDescriptor,
    base: HashMap<MeshPipelineKey, CachedRenderPipelineId>,
    lights: HashMap<(MeshPipelineKey, BevyLight, VisibilitySource, TextureFormat), CachedRenderPipelineId>,
}

/// Makes [`AntumbraPipelines`].
///
/// Runs in `RenderStartup`, which Bevy also runs after it has replaced a lost device.
pub(super) fn init_pipelines(
    mut commands: Commands,
    shaders: Res<AntumbraShaders>,
    fullscreen: Res<FullscreenShader>,
    device: Res<RenderDevice>,
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
        forward_layout: (device.limits().max_bind_groups as usize > MASK_GROUP).then(|| {
            let masks = texture_2d_array(TextureSampleType::Float { filterable: false });
            layout(
                "antumbra forward masks",
                &BindGroupLayoutEntries::sequential(stage, (storage(), storage(), masks)),
            )
        }),
        forward_neutral: None,
        masks_layout: layout(
            "antumbra masks",
            &BindGroupLayoutEntries::sequential(stage, (float(), float(), float())),
        ),
        base: HashMap::default(),
        lights: HashMap::default(),
    });
}

impl AntumbraPipelines {
    /// Returns the pipeline of the base draw of views with this key. Queues it if it is new.
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

    /// Returns the pipeline of lights of a kind in views with this key. Queues it if it is new.
    /// `depth_stencil` is the format of this crate's depth and stencil attachment.
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
        match visibility {
            VisibilitySource::Mask | VisibilitySource::Scaled => {
                descriptor.layout.push(self.mask_layout.clone())
            }
            VisibilitySource::Terms => descriptor.layout.push(self.masks_layout.clone()),
            VisibilitySource::Stencil | VisibilitySource::Unshadowed => {}
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
                VisibilitySource::Terms => {
                    let defs = ["VISIBILITY_MASK", "MASK_HOLDS_FOR_ALL", "SEPARATE_TERMS"];
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

/// Blending that adds light and keeps alpha.
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

/// Whether a pipeline is compiled, so that this frame can draw with it.
pub(super) fn is_ready(cache: &PipelineCache, id: CachedRenderPipelineId) -> bool {
    matches!(cache.get_render_pipeline_state(id), CachedPipelineState::Ok(_))
}
