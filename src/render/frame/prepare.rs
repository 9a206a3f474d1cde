//! Systems of the set `PrepareGpu`: from the frame's sets to buffers and draw lists.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;
use glam::{DMat4, UVec2};

use super::draw_list::{Batch, DrawListInput, ItemFilter, Variant};
use super::frame_data::{ActiveLight, FrameData, Viewport};
use super::front_surfaces::collect_front;
use crate::render::RenderError;
use crate::render::gpu::bind_groups::LIGHT_STRIDE;
use crate::render::nodes::blended::{BlendedDraw, BlendedLight};
use crate::render::pools::gpu_types;
use crate::render::pools::light_constants::light_constants;
use crate::render::pools::objects::NO_MESH;
use crate::render::recorder::PrepareInput;
use crate::render::renderer::Renderer;
use crate::scene::FaceCulling;
use crate::scene::placement::Placement;
use crate::scene::{PosedMesh, SceneMaterials, SceneMesh};
use crate::sets::{FrameLight, FrameLights, Objects, View, ViewData, ViewportSize, VisibleSet};

/// Uploads meshes, materials and matrices that changed, sizes the targets, and forgets the last frame's draws.
///
/// Set: `PrepareGpu`, first. Reads [`Objects`], [`View`]; writes [`Renderer`].
pub fn prepare_objects(
    mut renderer: ResMut<Renderer>,
    objects: Res<Objects>,
    view: Res<View>,
    viewport: Res<ViewportSize>,
    appearance: Query<(&SceneMesh, Option<&SceneMaterials>, Option<&PosedMesh>)>,
    exchanged: Query<(), Or<(Changed<SceneMesh>, Changed<SceneMaterials>)>>,
    posed: Query<(Entity, &PosedMesh), Changed<PosedMesh>>,
    places: Query<Placement>,
) {
    let renderer = renderer.as_mut();
    renderer.frame.has_view = false;
    renderer.failure = None;
    if renderer.context.notice_loss() {
        renderer.failure = Some(RenderError::DeviceLost);
        return;
    }
    let host = renderer.host;
    let size = match (&view.data, host) {
        (None, _) => UVec2::ZERO,
        (Some(_), None) => viewport.0,
        (Some(_), Some(host)) => host.target_size,
    };
    renderer.frame.viewport = Viewport {
        origin: host.map_or(UVec2::ZERO, |host| host.viewport_origin),
        size: viewport.0,
    };
    let fits = host.map_or(Ok(()), |host| host.check(viewport.0));
    if let Err(error) = fits.and_then(|()| renderer.resize(size)) {
        renderer.failure = Some(error);
        return;
    }
    let rebuilt =
        renderer.table_generation != Some(objects.flags_generation) || exchanged.iter().next().is_some();
    if rebuilt {
        renderer.table.rebuild(
            &renderer.context,
            &renderer.layouts,
            &objects,
            &appearance,
            &mut renderer.meshes,
            &mut renderer.materials,
        );
        renderer.table_generation = Some(objects.flags_generation);
    }
    for (entity, pose) in &posed {
        if let Some(object) = objects.index_of(entity) {
            let mesh = renderer.table.mesh[object];
            if mesh != NO_MESH {
                renderer.meshes.write_pose(&renderer.context, mesh, pose);
            }
        }
    }
    let Some(current) = &view.data else {
        return;
    };
    renderer.frame.has_view = true;
    let still = !rebuilt
        && renderer.last_clip_from_world == Some(current.clip_from_world)
        && objects.moved.is_clear();
    if !still {
        renderer
            .table
            .update_constants(&objects.entities, &places, current.clip_from_world, current.eye);
        renderer.write_objects();
        renderer.last_clip_from_world = Some(current.clip_from_world);
    }
    if let (Some(host), Some(host_depth)) = (&renderer.host, &renderer.host_depth) {
        host_depth.write(&renderer.context, host, current);
    }
    let ambient = renderer.settings.sanitized().ambient;
    let relative_from_ndc = (current.clip_from_world * DMat4::from_translation(current.eye)).inverse();
    let [width, height] = current.viewport.as_vec2().to_array();
    let constants = gpu_types::View {
        ambient: [ambient.x, ambient.y, ambient.z, 0.0],
        relative_from_ndc: relative_from_ndc.as_mat4().to_cols_array_2d(),
        size: [width, height, width.recip(), height.recip()],
        origin: renderer
            .frame
            .viewport
            .origin
            .as_vec2()
            .extend(0.0)
            .extend(0.0)
            .to_array(),
        eye: if current.is_orthographic() {
            let towards = -current.frustum.shape().forward.normalize();
            towards.as_vec3().extend(0.0).to_array()
        } else {
            [0.0, 0.0, 0.0, 1.0]
        },
    };
    renderer
        .context
        .queue
        .write_buffer(&renderer.view_buffer, 0, bytemuck::bytes_of(&constants));
}

/// Lets every technique upload what its lights need.
///
/// Set: `PrepareGpu`, after [`prepare_objects`]. Exclusive: a technique may read anything.
pub fn prepare_techniques(world: &mut World) {
    world.resource_scope(|world, mut renderer: Mut<Renderer>| {
        let renderer = &mut *renderer;
        if renderer.failure.is_some() {
            return; // the table of objects may be that of an earlier frame
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
            context: &renderer.context,
            shaders: &renderer.shaders,
            layouts: &renderer.layouts,
            meshes: &renderer.meshes,
            table: &renderer.table,
            target_size,
            mirrored_view,
            debug_view: renderer.settings.debug_volumes,
        };
        for technique in &mut renderer.techniques {
            if let Err(error) = technique.prepare(world, &input) {
                renderer.failure.get_or_insert(error);
            }
        }
    });
}

/// Builds the frame's draw lists and light constants.
///
/// Set: `PrepareGpu`, last. Reads the sets; writes [`Renderer`].
pub fn prepare_draws(
    mut renderer: ResMut<Renderer>,
    objects: Res<Objects>,
    view: Res<View>,
    visible: Res<VisibleSet>,
    lights: Res<FrameLights>,
    face_culling: Res<FaceCulling>,
) {
    let renderer = renderer.as_mut();
    let frame = &mut renderer.frame;
    frame.batches.clear();
    frame.instances.clear();
    frame.lights.clear();
    frame.dark.clear();
    frame.blended.clear();
    frame.blended_lights.clear();
    frame.light_constants.clear();
    frame.ambient = 0..0;
    let Some(current) = view.data.as_ref().filter(|_| renderer.failure.is_none()) else {
        return;
    };
    let input = DrawListInput {
        table: &renderer.table,
        receivers: &objects.receivers,
        mirrored_view: current.mirrored,
        // A host has chosen already, perhaps by other rules.
        cull_back_faces: *face_culling == FaceCulling::SingleSided && renderer.host.is_none(),
    };
    renderer.draw_lists.build(
        &input,
        &visible.set,
        ItemFilter::Opaque,
        false,
        &mut frame.batches,
        &mut frame.instances,
    );
    frame.ambient = 0..frame.batches.len();

    let [width, height] = current.viewport.to_array();
    for (index, light) in lights.lights.iter().enumerate() {
        if renderer.labels.len() <= index {
            renderer.labels.push(format!("light {index}"));
        }
        let Some(scissor) = light.scissor else {
            continue; // nothing that is visible receives it
        };
        let shadow = renderer
            .techniques
            .iter()
            .enumerate()
            .find_map(|(technique, shadow)| Some((technique, shadow.visibility(index)?)));
        let first = frame.batches.len();
        renderer.draw_lists.build(
            &input,
            &light.i,
            ItemFilter::OpaqueLit,
            shadow.is_none(),
            &mut frame.batches,
            &mut frame.instances,
        );
        let first_unlit = frame.batches.len();
        if renderer.host.is_some() && collect_unlit(&mut frame.unlit, &objects, &visible, light) {
            renderer.draw_lists.build(
                &input,
                &frame.unlit,
                ItemFilter::Opaque,
                true,
                &mut frame.batches,
                &mut frame.instances,
            );
        }
        let unlit = first_unlit..frame.batches.len();
        let slot = frame.lights.len();
        let at = frame.light_constants.len();
        frame.light_constants.resize(at + LIGHT_STRIDE as usize, 0);
        let constants = light_constants(light, current.eye);
        frame.light_constants[at..at + size_of::<gpu_types::Light>()]
            .copy_from_slice(bytemuck::bytes_of(&constants));
        let bounds = light.depth_bounds.filter(|_| renderer.settings.depth_bounds);
        frame.lights.push(ActiveLight {
            entity: light.entity,
            light: index,
            slot,
            shadow,
            scissor: frame.viewport.place(if renderer.settings.scissor {
                [scissor.x, scissor.y, scissor.width, scissor.height]
            } else {
                [0, 0, width, height]
            }),
            depth_range: bounds.map_or((1.0, 0.0), |bounds| (bounds.depth_max, bounds.depth_min)),
            batches: first..first_unlit,
            unlit,
            front: 0..0,
            front_scissor: [0; 4],
        });
    }
    for (index, light) in lights
        .lights
        .iter()
        .enumerate()
        .filter(|(_, light)| !light.dark.is_clear())
    {
        let first = frame.batches.len();
        renderer.draw_lists.build(
            &input,
            &light.dark,
            ItemFilter::OpaqueLit,
            true,
            &mut frame.batches,
            &mut frame.instances,
        );
        frame.dark.push((index, first..frame.batches.len()));
    }
    if renderer.host.is_none() {
        collect_blended(frame, &input, &visible, &lights, current);
        collect_front(frame, &input, &objects, &lights, current);
    }
    renderer
        .instances
        .write(&renderer.context, bytemuck::cast_slice(&frame.instances));
    renderer.write_lights();
    if let Err(error) = renderer.require_targets() {
        renderer.failure.get_or_insert(error);
        renderer.frame.lights.clear();
    }
    renderer.require_pipelines();
}

/// Collects objects of V that a light does not affect, or of which it sees nothing that is in view; whether there are any.
fn collect_unlit(
    unlit: &mut FixedBitSet,
    objects: &Objects,
    visible: &VisibleSet,
    light: &FrameLight,
) -> bool {
    let affects = light.selection.affects;
    unlit.clone_from(&light.dark);
    if objects.common_layers() & affects == 0 {
        let unaffected = |object: &usize| objects.layers[*object] & affects == 0;
        unlit.extend(visible.set.ones().filter(unaffected));
    }
    !unlit.is_clear()
}

/// Sorts floats that are not NaN in descending order.
fn descending(value: f32) -> u32 {
    let bits = value.to_bits();
    // The bits of floats that are not negative sort as the floats do, those of others the other way.
    if bits >> 31 == 0 { !bits ^ (1 << 31) } else { bits }
}

/// Lists blended surfaces of V, farthest first, each with the lights that reach its object.
fn collect_blended(
    frame: &mut FrameData,
    input: &DrawListInput,
    visible: &VisibleSet,
    lights: &FrameLights,
    current: &ViewData,
) {
    frame.blended_order.clear();
    for object in visible.set.ones() {
        if input.table.mesh[object] == NO_MESH || input.table.handedness[object] == 0.0 {
            continue;
        }
        for (item, _) in input
            .table
            .items_of(object)
            .iter()
            .enumerate()
            .filter(|(_, item)| item.blended)
        {
            let distance = input.table.distance_of(object, current);
            frame
                .blended_order
                .push((descending(distance), object as u32, item as u32));
        }
    }
    frame.blended_order.sort_unstable();
    let first_batch = frame.batches.len();
    for &(_, object, item) in &frame.blended_order {
        let part = input.table.items_of(object as usize)[item as usize];
        let first_light = frame.blended_lights.len();
        for active in &frame.lights {
            if !part.unlit && lights.lights[active.light].i.contains(object as usize) {
                frame.blended_lights.push(BlendedLight {
                    slot: active.slot as u32,
                    behind_front: active.shadow.is_some(),
                });
            }
        }
        let at = frame.instances.len() as u32;
        frame.instances.push(object);
        frame.blended.push(BlendedDraw {
            batch: frame.batches.len(),
            lights: first_light..frame.blended_lights.len(),
        });
        frame.batches.push(Batch {
            variant: Variant {
                mirrored: (input.table.handedness[object as usize] < 0.0) != current.mirrored,
                culled: input.cull_back_faces && !part.double_sided,
                unshadowed: true,
            },
            material: part.material,
            mesh: input.table.mesh[object as usize],
            submesh: part.submesh,
            instances: at..at + 1,
        });
    }
    frame.blended_batches = first_batch..frame.batches.len();
}
