//! The system of the set `PrepareGpu` that turns the frame's sets into draw lists.

use bevy_ecs::prelude::*;
use fixedbitset::FixedBitSet;

use super::companions::{collect_companions, collect_front_companions};
use super::draw_list::{Batch, DrawListBuilder, DrawListInput, ItemFilter, Shadows, Variant};
use super::frame_data::{ActiveLight, FrameData, LightArea, LightSlot, Viewport};
use super::front_surfaces::collect_front;
use crate::render::nodes::blended::{BlendedDraw, BlendedLight};
use crate::render::pools::light_constants::light_constants;
use crate::render::pools::meshes::MeshPool;
use crate::render::pools::objects::{NO_MESH, distance_from_eye};
use crate::render::renderer::Renderer;
use crate::render::settings::RenderSettings;
use crate::scene::FaceCulling;
use crate::sets::{FrameLight, FrameLights, Objects, View, ViewData, VisibleSet};

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
    renderer.is_preparing = false;
    renderer.frame.clear();
    renderer.lights.constants.clear();
    let Some(current) = view.data.as_ref().filter(|_| renderer.failure.is_none()) else {
        return;
    };
    let cull_back_faces = *face_culling == FaceCulling::SingleSided;
    collect_draws(renderer, &objects, &visible, &lights, current, cull_back_faces);
    let instances = bytemuck::cast_slice(&renderer.frame.instances);
    renderer.instances.write(&renderer.gpu.context, instances);
    renderer.write_lights();
    if let Err(error) = renderer
        .require_targets()
        .and_then(|()| renderer.require_pipelines())
    {
        renderer.failure.get_or_insert(error);
        renderer.frame.lights.clear();
    }
}

/// The list shows no shadows, and is for no light.
const UNSHOWN: (Shadows, bool) = (Shadows::Nowhere, false);

/// Whether some receiver may not show the shadows of a light.
fn shows_selectively(light: &FrameLight, objects: &Objects) -> bool {
    objects.common_layers() & light.selection.shows_on == 0
}

/// Fills the frame's lists: the draws for the view, for each light, and of blended surfaces.
fn collect_draws(
    renderer: &mut Renderer,
    objects: &Objects,
    visible: &VisibleSet,
    lights: &FrameLights,
    current: &ViewData,
    cull_back_faces: bool,
) {
    let (host, host_terms) = (renderer.host, renderer.host_terms);
    let is_hosted = host.is_some();
    let Renderer {
        frame,
        table,
        draw_lists,
        labels,
        meshes,
        techniques,
        functions,
        settings,
        lights: uniforms,
        ..
    } = renderer;
    let input = DrawListInput {
        table,
        objects,
        mirrored_view: current.mirrored,
        // A host has already chosen the faces that it shows, perhaps by other rules.
        cull_back_faces: cull_back_faces && !is_hosted,
    };
    let (batches, instances) = (&mut frame.batches, &mut frame.instances);
    let (opaque, shown) = (ItemFilter::Opaque, (Shadows::OnReceivers(u32::MAX), false));
    frame.ambient = draw_lists.build(&input, &visible.set, opaque, shown, batches, instances);
    if is_hosted && host_terms {
        frame.unlit.clone_from(&visible.set);
        frame.unlit.intersect_with(&input.table.weighted);
        if !frame.unlit.is_clear() {
            frame.weighted = draw_lists.build(&input, &frame.unlit, opaque, UNSHOWN, batches, instances);
        }
    }
    let has_weights = !frame.weighted.is_empty();
    labels.follow(lights);
    let viewport = frame.viewport;
    let area_of = |light: &FrameLight| light_area(light, settings, viewport, current);
    for (index, light) in lights.of_scene().iter().enumerate() {
        let Some(area) = area_of(light) else {
            continue; // nothing that is visible receives it
        };
        let shadow = light
            .technique
            .and_then(|technique| techniques.shadow_of(index, &technique));
        let shadows = if shadow.is_some() {
            Shadows::OnReceivers(light.selection.shows_on)
        } else {
            Shadows::Nowhere
        };
        let (batches, instances) = (&mut frame.batches, &mut frame.instances);
        let lit = ItemFilter::OpaqueLit;
        // A host computes light by itself, so it must weight the terms by itself as well.
        let is_weighted = light.model.is_weighted() || has_weights;
        let is_tinted = match host {
            Some(_) => host_terms && is_weighted,
            None => light.model.lights_shadows(),
        };
        let shown = (shadows, is_weighted);
        let drawn = draw_lists.build(&input, &light.sets.i, lit, shown, batches, instances);
        let mut unlit = drawn.end..drawn.end;
        if is_hosted && collect_unlit(&mut frame.unlit, objects, visible, light) {
            let set = &frame.unlit;
            unlit = draw_lists.build(&input, set, opaque, UNSHOWN, batches, instances);
        }
        uniforms.constants.push(&light_constants(light, current.eye));
        let slot = LightSlot(frame.lights.len());
        frame.lights.push(ActiveLight {
            entity: light.entity,
            light: index,
            slot,
            technique: light.technique.filter(|_| shadow.is_some()),
            shadow,
            is_scaled: functions.iter().any(|function| function.scales(index))
                || (is_hosted && shadow.is_some() && shows_selectively(light, objects)),
            is_tinted,
            scissor: area.scissor,
            depth_range: area.depth_range,
            batches: drawn,
            unlit,
            front: 0..0,
            front_scissor: [0; 4],
            companions: 0..0,
        });
    }
    collect_companions(frame, (draw_lists, &input), lights, techniques, area_of);
    collect_dark(frame, draw_lists, &input, lights);
    if !is_hosted {
        collect_blended(frame, &input, meshes, (visible, lights), current);
        collect_front(frame, &input, objects, lights, current);
        collect_front_companions(frame, lights);
    }
}

/// Returns the part of the picture and the depths that a light reaches; `None` if it reaches nothing visible.
fn light_area(
    light: &FrameLight,
    settings: &RenderSettings,
    viewport: Viewport,
    current: &ViewData,
) -> Option<LightArea> {
    let scissor = light.region.scissor?;
    let bounds = light.region.depth_bounds.filter(|_| settings.depth_bounds);
    let [width, height] = current.viewport.to_array();
    Some(LightArea {
        scissor: viewport.place(if settings.scissor {
            [scissor.x, scissor.y, scissor.width, scissor.height]
        } else {
            [0, 0, width, height]
        }),
        depth_range: bounds.map_or((1.0, 0.0), |bounds| (bounds.depth_max, bounds.depth_min)),
    })
}

/// Collects the surfaces that lights do not see, for pictures of visibility.
fn collect_dark(
    frame: &mut FrameData,
    draw_lists: &mut DrawListBuilder,
    input: &DrawListInput,
    lights: &FrameLights,
) {
    let not_clear = |(_, light): &(usize, &FrameLight)| !light.sets.dark.is_clear();
    for (index, light) in lights.of_scene().iter().enumerate().filter(not_clear) {
        let (batches, instances) = (&mut frame.batches, &mut frame.instances);
        let (lit, nowhere) = (ItemFilter::OpaqueLit, UNSHOWN);
        let drawn = draw_lists.build(input, &light.sets.dark, lit, nowhere, batches, instances);
        frame.dark.push((index, drawn));
    }
}

/// Collects the objects of the set V that a light does not affect or does not see. Returns whether there are
/// any.
fn collect_unlit(
    unlit: &mut FixedBitSet,
    objects: &Objects,
    visible: &VisibleSet,
    light: &FrameLight,
) -> bool {
    let affects = light.selection.affects;
    unlit.clone_from(&light.sets.dark);
    if objects.common_layers() & affects == 0 {
        let unaffected = |object: &usize| objects.layers[*object] & affects == 0;
        unlit.extend(visible.set.ones().filter(unaffected));
    }
    !unlit.is_clear()
}

/// Returns a key that sorts floats in descending order. The float must not be NaN.
fn descending(value: f32) -> u32 {
    let bits = value.to_bits();
    // The bits of non-negative floats sort as the floats do, and the bits of negative floats sort in reverse.
    if bits >> 31 == 0 { !bits ^ (1 << 31) } else { bits }
}

/// Lists blended surfaces of the set V, farthest first by the middles of their bounds, each with the lights that reach its object.
fn collect_blended(
    frame: &mut FrameData,
    input: &DrawListInput,
    meshes: &MeshPool,
    (visible, lights): (&VisibleSet, &FrameLights),
    current: &ViewData,
) {
    frame.blended_order.clear();
    for object in visible.set.ones() {
        if input.table.mesh[object] == NO_MESH || input.table.handedness[object] == 0.0 {
            continue;
        }
        for (item, part) in input
            .table
            .items_of(object)
            .iter()
            .enumerate()
            .filter(|(_, item)| item.blended)
        {
            let mesh = meshes.get(input.table.mesh[object]);
            let distance = match mesh.and_then(|mesh| mesh.middles.get(part.submesh as usize)) {
                Some(middle) => input.table.distance_of(object, *middle, current),
                None => {
                    let (center, _) = input.objects.boxes.center_half(object);
                    distance_from_eye((center - current.eye).as_vec3(), current)
                }
            };
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
        let mut modelled = input.table.weighted.contains(object as usize);
        for active in &frame.lights {
            let light = &lights.lights[active.light];
            if !part.unlit && light.sets.i.contains(object as usize) {
                modelled |= light.model.is_weighted() || light.model.is_shaped();
                frame.blended_lights.push(BlendedLight {
                    slot: active.slot,
                    behind_front: active.kind().is_some(),
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
                modelled,
                coated: part.coated,
            },
            material: part.material,
            mesh: input.table.mesh[object as usize],
            submesh: part.submesh,
            instances: at..at + 1,
        });
    }
    frame.blended_batches = first_batch..frame.batches.len();
}
