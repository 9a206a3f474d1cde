//! Lets the opaque meshes that stay forward in marked views show our shadows.
//!
//! Such a mesh is drawn by a copy of Bevy's pipeline with an extended shader ([`ForwardShaders`]) and one more
//! bind group: the visibility of the managed lights, which the light pass of the view has kept
//! ([`ForwardMasks`](super::forward_masks::ForwardMasks)). Until shader and pipeline are ready, Bevy's own draws
//! the mesh.
//!
//! The device must allow five bind groups, because Bevy's materials use four.

use bevy::core_pipeline::core_3d::{AlphaMask3d, Opaque3d, Opaque3dBatchSetKey, Opaque3dBinKey};
use bevy::core_pipeline::prepass::{OpaqueNoLightmap3dBatchSetKey, OpaqueNoLightmap3dBinKey};
use bevy::ecs::prelude::*;
use bevy::ecs::query::ROQueryItem;
use bevy::ecs::system::SystemParamItem;
use bevy::ecs::system::lifetimeless::Read;
use bevy::material::RenderPhaseType;
use bevy::pbr::{
    DrawMesh, MATERIAL_BIND_GROUP_INDEX, MaterialFragmentShader, PreparedMaterial, SetMaterialBindGroup,
    SetMeshBindGroup, SetMeshViewBindGroup, SetMeshViewBindingArrayBindGroup,
    SpecializedMaterialPipelineCache,
};
use bevy::platform::collections::HashMap;
use bevy::render::render_phase::{
    BinnedRenderPhaseType, DrawFunctions, PhaseItem, RenderCommand, RenderCommandResult, SetItemPipeline,
    TrackedRenderPass,
};
use bevy::render::render_resource::{BindGroup, CachedRenderPipelineId, PipelineCache};
use bevy::render::sync_world::{MainEntity, MainEntityHashSet};
use bevy::render::view::{RenderVisibleEntitiesClass, RetainedViewEntity};

use super::deferred_views::{Meshes, ViewPhases};
use super::forward_shaders::ForwardShaders;
use super::pipelines::{AntumbraPipelines, is_ready};

/// Index of the bind group of the masks: the first that Bevy's materials leave free.
pub(super) const MASK_GROUP: usize = MATERIAL_BIND_GROUP_INDEX + 1;

/// Bind group of a view with the visibility of its managed lights.
#[derive(Component, Clone)]
pub struct ForwardGroup(pub BindGroup);

/// Draws a mesh as Bevy does, with the masks of the view.
pub(super) type DrawShadowed = (
    SetItemPipeline,
    SetMeshViewBindGroup<0>,
    SetMeshViewBindingArrayBindGroup<1>,
    SetMeshBindGroup<2>,
    SetMaterialBindGroup<MATERIAL_BIND_GROUP_INDEX>,
    SetMasks,
    DrawMesh,
);

/// Sets the bind group of the masks.
pub struct SetMasks;

impl<P: PhaseItem> RenderCommand<P> for SetMasks {
    type Param = ();
    type ViewQuery = Option<Read<ForwardGroup>>;
    type ItemQuery = ();

    fn render<'w>(
        _: &P,
        group: ROQueryItem<'w, '_, Self::ViewQuery>,
        _: Option<()>,
        (): SystemParamItem<'w, '_, Self::Param>,
        pass: &mut TrackedRenderPass<'w>,
    ) -> RenderCommandResult {
        let Some(group) = group else {
            return RenderCommandResult::Skip;
        };
        pass.set_bind_group(MASK_GROUP, &group.0, &[]);
        RenderCommandResult::Success
    }
}

/// The forward meshes of marked views, and their pipelines. The resource is in the render world.
#[derive(Resource, Default)]
pub struct ForwardViews {
    /// Our copy of each of Bevy's pipelines; `None` if it cannot be extended.
    pipelines: HashMap<CachedRenderPipelineId, Option<CachedRenderPipelineId>>,
    /// Meshes of each view that Bevy's own pipelines draw until ours are ready.
    pending: HashMap<RetainedViewEntity, MainEntityHashSet>,
    /// Meshes of each view that are drawn with our masks.
    shadowed: HashMap<RetainedViewEntity, MainEntityHashSet>,
}

impl ForwardViews {
    /// Whether a mesh of a view reads masks.
    pub fn reads_masks(&self, view: RetainedViewEntity) -> bool {
        self.shadowed.get(&view).is_some_and(|meshes| !meshes.is_empty())
    }

    /// Forgets the pipelines, which are lost with the device.
    pub(super) fn clear(&mut self) {
        *self = Self::default();
    }
}

/// Resources with which forward meshes get our pipelines, in the order of [`ForwardQueue`].
pub(super) type ForwardResources<'w> = (
    ResMut<'w, ForwardViews>,
    ResMut<'w, ForwardShaders>,
    Res<'w, SpecializedMaterialPipelineCache>,
    Res<'w, DrawFunctions<Opaque3d>>,
    Res<'w, DrawFunctions<AlphaMask3d>>,
    Res<'w, AntumbraPipelines>,
);

/// Gives forward meshes our pipelines.
pub(super) struct ForwardQueue<'a> {
    views: &'a mut ForwardViews,
    shaders: &'a mut ForwardShaders,
    specialized: &'a SpecializedMaterialPipelineCache,
    opaque: &'a DrawFunctions<Opaque3d>,
    masked: &'a DrawFunctions<AlphaMask3d>,
    own: &'a AntumbraPipelines,
}

/// Whether a mesh is drawn with our masks.
enum Progress {
    /// It is, or it never will be.
    Done,
    /// Shader or pipeline are not ready.
    Waits,
}

impl<'a> ForwardQueue<'a> {
    pub fn of(resources: &'a mut ForwardResources) -> Self {
        let (views, shaders, specialized, opaque, masked, own) = resources;
        Self {
            views,
            shaders,
            specialized,
            opaque,
            masked,
            own,
        }
    }

    /// Whether the device has room for the masks.
    pub fn is_supported(&self) -> bool {
        self.own.forward_layout.is_some()
    }

    /// Forgets that a mesh of a view reads masks, because Bevy queues it anew.
    pub fn forget(&mut self, view: RetainedViewEntity, mesh: MainEntity) {
        if let Some(meshes) = self.views.shadowed.get_mut(&view) {
            meshes.remove(&mesh);
        }
    }

    /// Takes up a mesh that Bevy has queued in a forward phase of a view.
    pub fn push(&mut self, view: RetainedViewEntity, mesh: MainEntity) {
        self.views.pending.entry(view).or_default().insert(mesh);
    }

    /// Gives our pipelines to the meshes of a view whose pipelines are ready.
    pub fn queue(
        &mut self,
        view: RetainedViewEntity,
        visible: &RenderVisibleEntitiesClass,
        meshes: &Meshes,
        phases: &mut ViewPhases,
        cache: &PipelineCache,
    ) {
        if let Some(shadowed) = self.views.shadowed.get_mut(&view) {
            for (_, gone) in &visible.removed_entities {
                shadowed.remove(gone);
            }
        }
        let Some(waiting) = self.views.pending.remove(&view) else {
            return;
        };
        // Bevy queues a mesh again when it becomes visible again, so one that is not visible is forgotten.
        let seen = visible.iter_visible().map(|(_, entity)| *entity);
        let mut pending: MainEntityHashSet = seen.filter(|entity| waiting.contains(entity)).collect();
        pending.retain(|&mesh| {
            let progress = self.queue_mesh(view, mesh, meshes, phases, cache);
            matches!(progress, Some(Progress::Waits))
        });
        if !pending.is_empty() {
            self.views.pending.insert(view, pending);
        }
    }

    /// Forgets the meshes of views which are gone.
    pub fn keep_views(&mut self, is_there: impl Fn(&RetainedViewEntity) -> bool) {
        self.views.pending.retain(|view, _| is_there(view));
        self.views.shadowed.retain(|view, _| is_there(view));
    }

    fn queue_mesh(
        &mut self,
        view: RetainedViewEntity,
        entity: MainEntity,
        meshes: &Meshes,
        phases: &mut ViewPhases,
        cache: &PipelineCache,
    ) -> Option<Progress> {
        let id = meshes.material_instances.instances.get(&entity)?.asset_id;
        let material = meshes.materials.get(id)?;
        let bevys = *self.specialized.get(&view)?.get(&entity)?;
        let pipeline = match self.pipeline(bevys, material, cache) {
            Ok(pipeline) => pipeline,
            Err(progress) => return Some(progress),
        };
        let mesh = meshes.instances.render_mesh_queue_data(entity)?;
        let slabs = meshes.allocator.mesh_slabs(&mesh.mesh_asset_id())?;
        let material_bind_group_index = Some(material.binding.group.0);
        let kind = BinnedRenderPhaseType::mesh(mesh.should_batch(), meshes.preprocessing);
        let both = (Entity::PLACEHOLDER, entity);
        let index = mesh.current_uniform_index;
        let asset_id = mesh.mesh_asset_id().into();
        match material.properties.render_phase_type {
            RenderPhaseType::Opaque => {
                let batch_set = Opaque3dBatchSetKey {
                    pipeline,
                    draw_function: self.opaque.read().get_id::<DrawShadowed>()?,
                    material_bind_group_index,
                    slabs,
                    lightmap_slab: mesh.shared.lightmap_slab_index().map(|slab| *slab),
                };
                phases.opaque.remove(entity);
                phases
                    .opaque
                    .add(batch_set, Opaque3dBinKey { asset_id }, both, index, kind);
            }
            RenderPhaseType::AlphaMask => {
                let batch_set = OpaqueNoLightmap3dBatchSetKey {
                    pipeline,
                    draw_function: self.masked.read().get_id::<DrawShadowed>()?,
                    material_bind_group_index,
                    slabs,
                };
                phases.masked.remove(entity);
                phases.masked.add(
                    batch_set,
                    OpaqueNoLightmap3dBinKey { asset_id },
                    both,
                    index,
                    kind,
                );
            }
            RenderPhaseType::Transmissive | RenderPhaseType::Transparent => return None,
        }
        self.views.shadowed.entry(view).or_default().insert(entity);
        Some(Progress::Done)
    }

    /// Returns our copy of one of Bevy's pipelines, once it is ready.
    fn pipeline(
        &mut self,
        bevys: CachedRenderPipelineId,
        material: &PreparedMaterial,
        cache: &PipelineCache,
    ) -> Result<CachedRenderPipelineId, Progress> {
        let known = match self.views.pipelines.get(&bevys) {
            Some(&known) => known,
            None => {
                let original = material
                    .properties
                    .get_shader(MaterialFragmentShader)
                    .ok_or(Progress::Done)?;
                if self.shaders.is_refused(&original) {
                    return Err(Progress::Done);
                }
                // Only a compiled pipeline has its descriptor in the cache.
                if !is_ready(cache, bevys) {
                    return Err(Progress::Waits);
                }
                let shader = self.shaders.get(&original).ok_or(Progress::Waits)?;
                let mut descriptor = cache.get_render_pipeline_descriptor(bevys).clone();
                let made = match (&mut descriptor.fragment, &self.own.forward_layout) {
                    (Some(fragment), Some(layout)) if descriptor.layout.len() == MASK_GROUP => {
                        fragment.shader = shader;
                        descriptor.layout.push(layout.clone());
                        Some(cache.queue_render_pipeline(descriptor))
                    }
                    _ => None, // it already has a group of its own there
                };
                self.views.pipelines.insert(bevys, made);
                made
            }
        };
        let ours = known.ok_or(Progress::Done)?;
        if is_ready(cache, ours) {
            Ok(ours)
        } else {
            Err(Progress::Waits)
        }
    }
}
