//! Systems of the set `PrepareGpu` that upload objects, the view and the data of techniques.

use bevy_ecs::prelude::*;
use bevy_ecs::world::WorldId;
use glam::{DMat4, UVec2};

use super::frame_data::{MatrixWork, Viewport};
use crate::render::RenderError;
use crate::render::pools::gpu_types;
use crate::render::pools::object_rows::{ObjectParts, ObjectView};
use crate::render::pools::objects::{Looks, NO_MESH};
use crate::render::recorder::PrepareInput;
use crate::render::renderer::Renderer;
use crate::scene::PosedMesh;
use crate::scene::changes::{Exchanges, NewAppearances};
use crate::sets::{FrameLights, Objects, View, ViewData, ViewportSize};

/// Uploads the meshes, materials and matrices that changed, sizes the targets, and resets the state of the
/// last frame.
///
/// Set: `PrepareGpu`, first. Reads [`Objects`], [`View`]; writes [`Renderer`]. Cost: the matrices of all objects for another
/// view, on all threads, and otherwise of those that moved; the meshes and materials of all objects where one came or went, and
/// otherwise of those that exchanged theirs.
pub fn prepare_objects(
    mut renderer: ResMut<Renderer>,
    objects: Res<Objects>,
    view: Res<View>,
    viewport: Res<ViewportSize>,
    looks: Query<Looks>,
    mut appearances: NewAppearances,
    posed: Query<(Entity, Ref<PosedMesh>)>,
    mut parts: ObjectParts,
    world: WorldId,
) {
    let renderer = renderer.as_mut();
    renderer.enter(world);
    // A renderer that was out of the world for some frames has missed what changed in them.
    let was_away = std::mem::replace(&mut renderer.last_frame, objects.frame) + 1 != objects.frame;
    renderer.frame.matrices = MatrixWork::default();
    if let Err(error) = begin_frame(renderer, &view, viewport.0) {
        renderer.failure = Some(error);
        renderer.has_missed_changes = true;
        return;
    }
    let missed = std::mem::take(&mut renderer.has_missed_changes) || was_away;
    let exchanged = match appearances.take() {
        Exchanges::Of(entities) if !missed => Some(entities),
        _ => None,
    };
    let same_objects = renderer.table_generation == Some(objects.flags_generation);
    let exchanged = exchanged.filter(|_| same_objects);
    let (table, meshes, materials) = (&mut renderer.table, &mut renderer.meshes, &mut renderer.materials);
    let gpu = &renderer.gpu;
    let suffices =
        exchanged.is_some_and(|some| table.exchange(gpu, &objects, some, &looks, meshes, materials));
    if !suffices {
        table.rebuild(gpu, &objects, &looks, meshes, materials);
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
        renderer.matrices_of = None; // the next view needs all matrices again
        return;
    };
    renderer.frame.has_view = true;
    let object_view = ObjectView {
        clip_from_world: current.clip_from_world,
        eye_world: current.eye,
    };
    let matrices_of = Some((objects.layout_generation, object_view));
    let is_new = missed || renderer.matrices_of != matrices_of;
    renderer
        .table
        .update_constants(&objects, &mut parts, object_view, is_new);
    if let Err(error) = renderer.write_objects(is_new) {
        renderer.failure = Some(error);
        renderer.frame.has_view = false;
        renderer.matrices_of = None; // the next frame needs all matrices again
        return;
    }
    renderer.matrices_of = matrices_of;
    write_view(renderer, current);
}

/// Sizes the targets, and resets the state of the last frame.
fn begin_frame(renderer: &mut Renderer, view: &View, viewport: UVec2) -> Result<(), RenderError> {
    renderer.frame.has_view = false;
    renderer.failure = None;
    renderer.is_preparing = true;
    if renderer.gpu.context.notice_loss() {
        return Err(RenderError::DeviceLost);
    }
    if let Some(error) = renderer.late_failure.take() {
        return Err(error);
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
