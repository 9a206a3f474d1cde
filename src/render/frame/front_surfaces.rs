//! For each shadowed light, the blended surfaces that it reaches, and the casters whose shadows can reach
//! them.

use fixedbitset::FixedBitSet;

use super::draw_list::{Batch, DrawListInput, Shadows, Variant};
use super::frame_data::{ActiveLight, FrameData};
use crate::geometry::{Aabb, LightHull};
use crate::sets::{FrameLight, FrameLights, Objects, Projector, ScissorRect, ViewData};

/// Lists the blended surfaces of each shadowed light, and restricts the light on them: to their part of the
/// screen, and to the casters that touch the convex hull of light and surfaces. Without the restriction,
/// marking a light again would cost as much as the first time. Mostly few casters stand before a pane.
pub(in crate::render) fn collect_front(
    frame: &mut FrameData,
    input: &DrawListInput,
    objects: &Objects,
    lights: &FrameLights,
    view: &ViewData,
) {
    let FrameData {
        batches,
        instances,
        lights: active,
        blended,
        blended_lights,
        front_casters,
        ..
    } = frame;
    front_casters.resize_with(active.len().max(front_casters.len()), FixedBitSet::new);
    for (light, casters) in active.iter_mut().zip(front_casters) {
        let first = batches.len();
        light.front = first..first;
        if light.kind().is_none() {
            continue;
        }
        let frame_light = &lights.lights[light.light];
        let reach = frame_light.lit.aabb();
        let shows = Shadows::OnReceivers(frame_light.selection.shows_on);
        let mut bounds = Aabb::EMPTY;
        for draw in blended.iter() {
            let reached = &blended_lights[draw.lights.clone()];
            // The lights of a draw are in the order of their slots.
            let found = reached.binary_search_by_key(&light.slot.0, |reached| reached.slot.0);
            if found.is_ok() {
                let batch = batches[draw.batch].clone();
                let object = instances[batch.instances.start as usize] as usize;
                bounds = bounds.union(objects.boxes.get(object).intersection(reach));
                batches.push(Batch {
                    variant: Variant {
                        unshadowed: !shows.shown_on(objects, object),
                        modelled: frame_light.model.is_weighted() || input.table.weighted.contains(object),
                        ..batch.variant
                    },
                    ..batch
                });
            }
        }
        match front_scissor(light, &bounds, view) {
            Some(scissor) => {
                light.front.end = batches.len();
                light.front_scissor = scissor;
                select_casters(casters, frame_light, objects, &bounds);
            }
            None => batches.truncate(first),
        }
    }
}

/// Returns the part of the light's scissor that shows the bounds, or `None` if no part does.
fn front_scissor(light: &ActiveLight, bounds: &Aabb, view: &ViewData) -> Option<[u32; 4]> {
    if bounds.is_empty() {
        return None;
    }
    let (center, half) = (bounds.center().as_dvec3(), bounds.half_size().as_dvec3());
    let shown = ScissorRect::around(&Projector::new(view).bounds_of_box(center, half), view.viewport)?;
    let [x, y, width, height] = light.scissor;
    let (left, top) = (x.max(shown.x), y.max(shown.y));
    let right = (x + width).min(shown.x + shown.width);
    let bottom = (y + height).min(shown.y + shown.height);
    (left < right && top < bottom).then(|| [left, top, right - left, bottom - top])
}

fn select_casters(casters: &mut FixedBitSet, light: &FrameLight, objects: &Objects, bounds: &Aabb) {
    let hull = LightHull::of_aabb(bounds, &light.emitter);
    casters.clear();
    casters.grow(objects.len());
    for object in light.sets.s.ones() {
        if !hull.planes.excludes_aabb(&objects.boxes.get(object)) {
            casters.insert(object);
        }
    }
}
