//! Moves the opaque meshes of marked cameras from Bevy's forward phases to its deferred phases.
//!
//! Bevy stores with a prepared material whether it is deferred, and thus decides for all cameras at once. We
//! leave materials forward, which is Bevy's default, so that unmarked cameras render as before. Bevy queues
//! the meshes that are new or changed in a view. After that, the meshes of a marked view that can be drawn
//! deferred ([`Deferral`]) are removed from the forward phases and added to the deferred ones, with the
//! pipeline that Bevy would give a deferred material.

use std::mem::swap;

use bevy::asset::UntypedAssetId;
use bevy::core_pipeline::core_3d::{AlphaMask3d, Opaque3d};
use bevy::core_pipeline::deferred::{AlphaMask3dDeferred, Opaque3dDeferred};
use bevy::core_pipeline::prepass::{
    AlphaMask3dPrepass, DeferredPrepass, DepthPrepass, Opaque3dPrepass, OpaqueNoLightmap3dBatchSetKey,
    OpaqueNoLightmap3dBinKey,
};
use bevy::ecs::prelude::*;
use bevy::material::key::{ErasedMaterialPipelineKey, ErasedMeshPipelineKey};
use bevy::material::{MaterialProperties, OpaqueRendererMethod, RenderPhaseType};
use bevy::mesh::Mesh3d;
use bevy::pbr::{
    DeferredAlphaMaskDrawFunction, DeferredOpaqueDrawFunction, MeshPipelineKey,
    PendingPrepassMeshMaterialQueues, PreparedMaterial, PrepassFragmentShader, PrepassPipeline,
    PrepassPipelineSpecializer, PrepassVertexShader, RenderMaterialInstances, RenderMeshInstanceFlags,
    RenderMeshInstances, RenderMeshQueueData, ViewKeyPrepassCache, alpha_mode_pipeline_key,
};
use bevy::platform::collections::HashSet;
use bevy::render::batching::gpu_preprocessing::GpuPreprocessingSupport;
use bevy::render::camera::{DirtySpecializations, ExtractedCamera};
use bevy::render::erased_render_asset::ErasedRenderAssets;
use bevy::render::mesh::RenderMesh;
use bevy::render::mesh::allocator::MeshAllocator;
use bevy::render::render_asset::RenderAssets;
use bevy::render::render_phase::{BinnedRenderPhase, BinnedRenderPhaseType, ViewBinnedRenderPhases};
use bevy::render::render_resource::{CachedRenderPipelineId, PipelineCache, SpecializedMeshPipelines};
use bevy::render::sync_world::MainEntity;
use bevy::render::view::{
    ExtractedView, Msaa, RenderVisibilityRanges, RenderVisibleEntities, RetainedViewEntity,
};

use super::deferral::{Deferral, Forward};
use super::forward_views::{ForwardQueue, ForwardResources};
use super::mirror::Mirrors;

/// The views whose opaque meshes this module moves to the deferred phases, now and in the frame before. It is
/// in the render world.
#[derive(Resource, Default)]
pub(super) struct DeferredViews {
    now: HashSet<RetainedViewEntity>,
    before: HashSet<RetainedViewEntity>,
}

/// Filter of the views of cameras that draw a depth prepass and a deferred prepass.
type CanBeDeferred = (With<ExtractedCamera>, With<DepthPrepass>, With<DeferredPrepass>);

/// Makes Bevy queue all meshes of a view again if the view's camera was marked or unmarked in this frame.
///
/// Runs in `Render`, in `PrepareAssets`.
pub(super) fn collect_deferred_views(
    mut deferred: ResMut<DeferredViews>,
    mut dirty: ResMut<DirtySpecializations>,
    mut mirrors: ResMut<Mirrors>,
    views: Query<(&ExtractedView, &MainEntity), CanBeDeferred>,
) {
    let DeferredViews { now, before } = &mut *deferred;
    swap(now, before);
    now.clear();
    let marked = views
        .iter()
        .filter(|(_, camera)| mirrors.get(camera.id()).is_some());
    now.extend(marked.map(|(view, _)| view.retained_view_entity));
    dirty.views.extend(now.symmetric_difference(before).copied());
    // The pipeline of a forward mesh depends on whether it shows shadows.
    for mirror in mirrors.iter_mut() {
        let changed = mirror.receivers_changed.drain(..).map(MainEntity::from);
        dirty.changed_renderables.extend(changed);
    }
}

/// Bevy's resources about the meshes of the frame, in the order of [`Meshes`].
///
/// Parameters of systems are tuples in this module and its neighbours. For a struct, `SystemParam` derives bounds with which
/// the compiler proves anew that all types of wgpu within are [`Send`]; that takes it seconds for each struct.
pub(super) type MeshResources<'w> = (
    Res<'w, RenderAssets<RenderMesh>>,
    Res<'w, ErasedRenderAssets<PreparedMaterial>>,
    Res<'w, RenderMeshInstances>,
    Res<'w, RenderMaterialInstances>,
    Res<'w, RenderVisibilityRanges>,
    Res<'w, MeshAllocator>,
    Res<'w, GpuPreprocessingSupport>,
);

/// The meshes of the frame, with their materials and buffers, as Bevy holds them.
pub(super) struct Meshes<'a> {
    pub meshes: &'a RenderAssets<RenderMesh>,
    pub materials: &'a ErasedRenderAssets<PreparedMaterial>,
    pub instances: &'a RenderMeshInstances,
    pub material_instances: &'a RenderMaterialInstances,
    ranges: &'a RenderVisibilityRanges,
    pub allocator: &'a MeshAllocator,
    pub preprocessing: &'a GpuPreprocessingSupport,
}

impl<'a> Meshes<'a> {
    fn of(resources: &'a MeshResources) -> Self {
        let (meshes, materials, instances, material_instances, ranges, allocator, preprocessing) = resources;
        Self {
            meshes,
            materials,
            instances,
            material_instances,
            ranges,
            allocator,
            preprocessing,
        }
    }
}

/// The meshes that Bevy has queued in this frame.
type Queued<'w> = (
    Res<'w, ViewKeyPrepassCache>,
    Res<'w, DirtySpecializations>,
    Res<'w, PendingPrepassMeshMaterialQueues>,
);

type Phase<'w, P> = ResMut<'w, ViewBinnedRenderPhases<P>>;

/// The phases of all views between which meshes are moved, in the order of [`ViewPhases`].
type Phases<'w> = (
    Phase<'w, Opaque3d>,
    Phase<'w, AlphaMask3d>,
    Phase<'w, Opaque3dPrepass>,
    Phase<'w, AlphaMask3dPrepass>,
    Phase<'w, Opaque3dDeferred>,
    Phase<'w, AlphaMask3dDeferred>,
);

/// The phases of one view between which meshes are moved.
pub(super) struct ViewPhases<'a> {
    pub opaque: &'a mut BinnedRenderPhase<Opaque3d>,
    pub masked: &'a mut BinnedRenderPhase<AlphaMask3d>,
    opaque_prepass: &'a mut BinnedRenderPhase<Opaque3dPrepass>,
    masked_prepass: &'a mut BinnedRenderPhase<AlphaMask3dPrepass>,
    opaque_deferred: &'a mut BinnedRenderPhase<Opaque3dDeferred>,
    masked_deferred: &'a mut BinnedRenderPhase<AlphaMask3dDeferred>,
}

impl<'a> ViewPhases<'a> {
    fn of(view: RetainedViewEntity, all: &'a mut Phases) -> Option<Self> {
        let (opaque, masked, opaque_prepass, masked_prepass, opaque_deferred, masked_deferred) = all;
        Some(Self {
            opaque: opaque.get_mut(&view)?,
            masked: masked.get_mut(&view)?,
            opaque_prepass: opaque_prepass.get_mut(&view)?,
            masked_prepass: masked_prepass.get_mut(&view)?,
            opaque_deferred: opaque_deferred.get_mut(&view)?,
            masked_deferred: masked_deferred.get_mut(&view)?,
        })
    }
}

/// Resources that specialize the pipelines of Bevy's deferred prepass.
type Pipelines<'w> = (
    Res<'w, PipelineCache>,
    Res<'w, PrepassPipeline>,
    ResMut<'w, SpecializedMeshPipelines<PrepassPipelineSpecializer>>,
);

/// Moves those meshes of marked views that are new or changed in this frame.
///
/// Runs in `Render`, in `QueueMeshes`, after Bevy has queued the prepass and the main pass.
pub(super) fn queue_deferred(
    deferred: Res<DeferredViews>,
    mut deferral: ResMut<Deferral>,
    mirrors: Res<Mirrors>,
    views: Query<(&ExtractedView, &MainEntity, &RenderVisibleEntities, &Msaa), CanBeDeferred>,
    meshes: MeshResources,
    (view_keys, dirty, pending): Queued,
    mut phases: Phases,
    mut pipelines: Pipelines,
    mut forward: ForwardResources,
) {
    let meshes = Meshes::of(&meshes);
    let mut forward = ForwardQueue::of(&mut forward);
    for (extracted, camera, visible, msaa) in &views {
        let view = extracted.retained_view_entity;
        if !deferred.now.contains(&view) {
            continue;
        }
        let (Some(visible), Some(pending), Some(mut phases), Some(&view_key)) = (
            visible.get::<Mesh3d>(),
            pending.get(&view),
            ViewPhases::of(view, &mut phases),
            view_keys.get(&view),
        ) else {
            continue;
        };
        let queued = dirty.iter_to_queue(view, visible, &pending.prev_frame);
        for (&render_entity, &entity) in queued {
            forward.forget(view, entity);
            let stays = queue_mesh(
                (render_entity, entity),
                view_key,
                msaa,
                &meshes,
                (&deferral, forward.is_supported()),
                &mut phases,
                &mut pipelines,
            );
            let Some((id, why)) = stays else {
                continue;
            };
            if !forward.is_supported() || !why.allows_masks() {
                deferral.report(entity, id, &why);
            } else if mirrors
                .get(camera.id())
                .is_some_and(|mirror| mirror.shows_shadows(entity.id()))
            {
                forward.push(view, entity);
            }
        }
        forward.queue(view, visible, &meshes, &mut phases, &pipelines.0);
    }
    forward.keep_views(|view| deferred.now.contains(view));
}

/// Moves a mesh to the deferred phases of a view. Returns the material and the reason if it stays forward.
fn queue_mesh(
    (render_entity, entity): (Entity, MainEntity),
    view_key: MeshPipelineKey,
    msaa: &Msaa,
    meshes: &Meshes,
    (deferral, has_masks): (&Deferral, bool),
    phases: &mut ViewPhases,
    pipelines: &mut Pipelines,
) -> Option<(UntypedAssetId, Forward)> {
    let id = meshes.material_instances.instances.get(&entity)?.asset_id;
    let material = meshes.materials.get(id)?;
    let properties = &material.properties;
    let is_masked = match properties.render_phase_type {
        RenderPhaseType::Opaque => false,
        RenderPhaseType::AlphaMask => true,
        RenderPhaseType::Transmissive | RenderPhaseType::Transparent => return None,
    };
    if properties.render_method == OpaqueRendererMethod::Deferred {
        // Bevy has queued the mesh in a deferred phase. Bevy also queues a masked mesh in the forward phase,
        // where it would be drawn over the deferred light.
        phases.masked.remove(entity);
        return None;
    }
    if let Err(why) = deferral.check(id, properties, has_masks) {
        return Some((id, why));
    }
    let mesh = meshes.instances.render_mesh_queue_data(entity)?;
    if mesh.shared.lightmap_slab_index().is_some() {
        return Some((id, Forward::Lightmapped));
    }
    let slabs = meshes.allocator.mesh_slabs(&mesh.mesh_asset_id())?;
    let draw_function = match is_masked {
        false => properties.get_draw_function(DeferredOpaqueDrawFunction)?,
        true => properties.get_draw_function(DeferredAlphaMaskDrawFunction)?,
    };
    let render_mesh = meshes.meshes.get(mesh.mesh_asset_id())?;
    let key = view_key
        | MeshPipelineKey::from_bits_retain(render_mesh.key_bits.bits())
        | alpha_mode_pipeline_key(properties.alpha_mode, msaa)
        | mesh_key(entity, view_key, &mesh, properties, meshes);
    let pipeline = specialize(key, id.type_id(), render_mesh, material, pipelines)?;
    let batch_set = OpaqueNoLightmap3dBatchSetKey {
        draw_function,
        pipeline,
        material_bind_group_index: Some(material.binding.group.0),
        slabs,
    };
    let bin = OpaqueNoLightmap3dBinKey {
        asset_id: mesh.mesh_asset_id().into(),
    };
    let kind = BinnedRenderPhaseType::mesh(mesh.should_batch(), meshes.preprocessing);
    let both = (render_entity, entity);
    if is_masked {
        phases.masked.remove(entity);
        phases.masked_prepass.remove(entity);
        phases.masked_deferred.remove(entity);
        let index = mesh.current_uniform_index;
        phases.masked_deferred.add(batch_set, bin, both, index, kind);
    } else {
        phases.opaque.remove(entity);
        phases.opaque_prepass.remove(entity);
        phases.opaque_deferred.remove(entity);
        let index = mesh.current_uniform_index;
        phases.opaque_deferred.add(batch_set, bin, both, index, kind);
    }
    None
}

/// Returns the part of a pipeline's key that comes from one mesh of the game. It follows Bevy's key for
/// deferred materials (`specialize_prepass_material_meshes`). Meshes with a lightmap are not deferred.
fn mesh_key(
    entity: MainEntity,
    view_key: MeshPipelineKey,
    mesh: &RenderMeshQueueData,
    material: &MaterialProperties,
    meshes: &Meshes,
) -> MeshPipelineKey {
    let mut key = MeshPipelineKey::DEFERRED_PREPASS;
    key.set(
        MeshPipelineKey::VISIBILITY_RANGE_DITHER,
        meshes.ranges.entity_has_crossfading_visibility_ranges(entity),
    );
    key.set(
        MeshPipelineKey::PREPASS_READS_MATERIAL,
        material.get_shader(PrepassVertexShader).is_some()
            || material.get_shader(PrepassFragmentShader).is_some(),
    );
    let moves = view_key.contains(MeshPipelineKey::MOTION_VECTOR_PREPASS);
    let had = |flag: RenderMeshInstanceFlags| moves && mesh.flags().contains(flag);
    key.set(
        MeshPipelineKey::HAS_PREVIOUS_SKIN,
        had(RenderMeshInstanceFlags::HAS_PREVIOUS_SKIN),
    );
    key.set(
        MeshPipelineKey::HAS_PREVIOUS_MORPH,
        had(RenderMeshInstanceFlags::HAS_PREVIOUS_MORPH),
    );
    key
}

/// Returns Bevy's pipeline of the deferred prepass. All meshes with this key share it.
fn specialize(
    key: MeshPipelineKey,
    material_type: std::any::TypeId,
    mesh: &RenderMesh,
    material: &PreparedMaterial,
    pipelines: &mut Pipelines,
) -> Option<CachedRenderPipelineId> {
    let (cache, prepass, specialized) = pipelines;
    let specializer = PrepassPipelineSpecializer {
        pipeline: prepass.clone(),
        properties: material.properties.clone(),
    };
    let key = ErasedMaterialPipelineKey {
        type_id: material_type,
        mesh_key: ErasedMeshPipelineKey::new(key),
        material_key: material.properties.material_key.clone(),
    };
    match specialized.specialize(cache, &specializer, key, &mesh.layout) {
        Ok(pipeline) => Some(pipeline),
        Err(error) => {
            tracing::error!("a mesh stays forward: {error}");
            None
        }
    }
}
