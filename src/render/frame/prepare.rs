//! Systems of the set `PrepareGpu` that upload objects, the view and the data of techniques.

use bevy_ecs::prelude::*;
use glam::{DMat4, UVec2};

use super::frame_data::Viewport;
use crate::render::RenderError;
use crate::render::pools::gpu_types;
use crate::render::pools::objects::NO_MESH;
use crate::render::recorder::PrepareInput;
use crate::render::renderer::Renderer;
use crate::scene::changes::NewAppearances;
use crate::scene::placement::Placement;
use crate::scene::{PosedMesh, SceneMaterials, SceneMesh, SurfaceWeights};
use crate::sets::{FrameLights, Objects, View, ViewData, ViewportSize};

/// Uploads the meshes, materials and matrices that changed, sizes the targets, and resets the state of the
/// last frame.
///
/// Set: `PrepareGpu`, first. Reads [`Objects`], [`View`]; writes [`Renderer`].
pub fn prepare_objects(
    mut renderer: ResMut<Renderer>,
    objects: Res<Objects>,
    view: Res<View>,
    viewport: Res<ViewportSize>,
    appearance: Query<(&SceneMesh, Option<&SceneMaterials>, Option<&PosedMesh>)>,
    mut appearances: NewAppearances,
    posed: Query<(Entity, Ref<PosedMesh>)>,
    places: Query<Placement>,
    (weights, weights_changed): (Query<&SurfaceWeights>, Query<(), Changed<SurfaceWeights>>),
    mut weights_removed: RemovedComponents<SurfaceWeights>,
) {
    let renderer = renderer.as_mut();
    if let Err(error) = begin_frame(renderer, &view, viewport.0) {
        renderer.failure = Some(error);
        renderer.has_missed_changes = true;
        return;
    }
    let missed = std::mem::take(&mut renderer.has_missed_changes);
    let rebuilt = appearances.take() || missed || renderer.table_generation != Some(objects.flags_generation);
    if rebuilt {
        renderer.table.rebuild(
            &renderer.gpu,
            &objects,
            &appearance,
            &mut renderer.meshes,
            &mut renderer.materials,
        );
        renderer.table_generation = Some(objects.flags_generation);
    }
    for (entity, pose) in posed.iter().filter(|(_, pose)| missed || pose.is_changed()) {
        if let Some(object) = objects.index_of(entity) {
            let mesh = renderer.table.mesh[object];
            if mesh != NO_MESH {
                renderer.meshes.write_pose(&renderer.gpu.context, mesh, &pose);
            }
        }
    }
    let Some(current) = &view.data else {
        renderer.last_clip_from_world = None; // the next view needs all matrices again
        return;
    };
    renderer.frame.has_view = true;
    let reweighted = weights_removed.read().count() > 0 || !weights_changed.is_empty();
    let still = !rebuilt
        && !reweighted
        && renderer.last_clip_from_world == Some(current.clip_from_world)
        && objects.moved.is_clear();
    if !still {
        let (clip_from_world, eye) = (current.clip_from_world, current.eye);
        renderer
            .table
            .update_constants(&objects.entities, &places, &weights, clip_from_world, eye);
        if let Err(error) = renderer.write_objects() {
            renderer.failure = Some(error);
            renderer.frame.has_view = false;
            renderer.last_clip_from_world = None; // the next frame needs all matrices again
            return;
        }
        renderer.last_clip_from_world = Some(clip_from_world);
    }
    write_view(renderer, current);
}

/// Sizes the targets, and resets the state of the last frame.
fn begin_frame(renderer: &mut Renderer, view: &View, viewport: UVec2) -> Result<(), RenderError> {
    renderer.frame.has_view = false;
    renderer.failure = None;
    if renderer.gpu.context.notice_loss() {
        return Err(RenderError::DeviceLost);
    }
    let host = renderer.host;
    renderer.frame.viewport = Viewport {
        origin: host.map_or(UVec2::ZERO, |host| host.viewport_origin),
        size: viewport,
    };
    let size = match (&view.data, host) {
        (None, _) => UVec2::ZERO,
        (Some(_), None) => viewport,
        (Some(_), Some(host)) => host.target_size,
    };
    if let Some(host) = host {
        host.check(viewport)?;
    }
    renderer.resize(size)
}

/// Uploads the constants of the view, and those that convert a host's depth to ours.
fn write_view(renderer: &Renderer, current: &ViewData) {
    let context = &renderer.gpu.context;
    if let (Some(host), Some(host_depth)) = (&renderer.host, &renderer.host_depth) {
        host_depth.write(context, host, current);
    }
    let ambient = renderer.settings.sanitized().ambient;
    let relative_from_ndc = (current.clip_from_world * DMat4::from_translation(current.eye)).inverse();
    let [width, height] = current.viewport.as_vec2().to_array();
    let [x, y] = renderer.frame.viewport.origin.as_vec2().to_array();
    let constants = gpu_types::View {
        ambient: [ambient.x, ambient.y, ambient.z, 0.0],
        relative_from_ndc: relative_from_ndc.as_mat4().to_cols_array_2d(),
        size: [width, height, width.recip(), height.recip()],
        origin: [x, y, 0.0, 0.0],
        eye: if current.is_orthographic() {
            let towards = -current.frustum.shape().forward.normalize();
            towards.as_vec3().extend(0.0).to_array()
        } else {
            [0.0, 0.0, 0.0, 1.0]
        },
    };
    let bytes = bytemuck::bytes_of(&constants);
    context.queue.write_buffer(&renderer.view_buffer, 0, bytes);
}

/// Lets every technique upload the data that its lights need.
///
/// Set: `PrepareGpu`, after [`prepare_objects`]. Exclusive: a technique may read anything.
pub fn prepare_techniques(world: &mut World) {
    world.resource_scope(|world, mut renderer: Mut<Renderer>| {
        let renderer = &mut *renderer;
        if renderer.failure.is_some() {
            return; // the table of objects may be that of an earlier frame
        }
        if let Err(error) = renderer.require_light_model(world.resource::<FrameLights>()) {
            renderer.failure = Some(error);
            return;
        }
        let mirrored_view = world
            .resource::<View>()
            .data
            .as_ref()
            .is_some_and(|view| view.mirrored);
        let target_size = renderer
            .targets
            .as_ref()
            .map_or(UVec2::ZERO, |targets| targets.size);
        let input = PrepareInput {
            context: &renderer.gpu.context,
            gpu: &renderer.gpu,
            meshes: &renderer.meshes,
            table: &renderer.table,
            target_size,
            mirrored_view,
            debug_view: renderer.settings.debug_volumes,
            is_hosted: renderer.host.is_some(),
        };
        for technique in renderer.techniques.iter_mut() {
            if let Err(error) = technique.prepare(world, &input) {
                renderer.failure.get_or_insert(error);
            }
        }
        for function in &mut renderer.functions {
            if let Err(error) = function.prepare(world, &input) {
                renderer.failure.get_or_insert(error);
            }
        }
    });
}
