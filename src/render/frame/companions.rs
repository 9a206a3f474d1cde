//! The companions of the frame's lights: what shadows the receivers and by the casters that a light's technique does not know.
//! They give no light. Each leaves its visibility in a mask of its own, by which it darkens the mask of its light.

use super::draw_list::{DrawListBuilder, DrawListInput, ItemFilter, Shadows};
use super::frame_data::{ActiveCompanion, ActiveLight, FrameData, LightArea};
use super::front_lights::LightSurfaces;
use super::recording::Recording;
use super::targets::MaskTargets;
use crate::render::nodes::darker_mask::{self, DarkerArea};
use crate::render::recorder::Leaves;
use crate::render::recorders::Recorders;
use crate::render::renderer::Renderer;
use crate::sets::{CompanionPart, FrameLight, FrameLights};

/// Lists the companions of the frame's lights, with the opaque surfaces that they need.
pub(in crate::render) fn collect_companions(
    frame: &mut FrameData,
    (draw_lists, input): (&mut DrawListBuilder, &DrawListInput),
    lights: &FrameLights,
    techniques: &Recorders,
    area_of: impl Fn(&FrameLight) -> Option<LightArea>,
) {
    let first = lights.scene_count();
    let mut is_known_seen = None;
    for (index, light) in lights.lights.iter().enumerate().skip(first) {
        let (Some(of), Some(technique)) = (light.companion_of, light.technique) else {
            continue;
        };
        if of.part == CompanionPart::Known && !light.is_skipped() {
            is_known_seen = Some(of.light);
        }
        let completed = frame.lights.binary_search_by_key(&of.light, |light| light.entity);
        let (Ok(completed), Some(area)) = (completed, area_of(light)) else {
            continue;
        };
        if !frame.lights[completed].has_mask() || frame.lights[completed].shadow.is_none() {
            continue;
        }
        let shadow = techniques.shadow_of(index, &technique);
        let shows = (Shadows::OnReceivers(light.selection.shows_on), false);
        let first = frame.batches.len();
        let is_drawn = of.part == CompanionPart::Others || technique.needs.draws_receivers;
        let batches = if is_drawn {
            let (batches, instances) = (&mut frame.batches, &mut frame.instances);
            let lit = ItemFilter::OpaqueLit;
            draw_lists.build(input, &light.sets.i, lit, shows, batches, instances)
        } else {
            first..first
        };
        let at = frame.companions.len();
        let of_light = &mut frame.lights[completed].companions;
        if of_light.end == 0 {
            of_light.start = at; // the first one of the light
        }
        of_light.end = at + 1;
        let slot = frame.lights[completed].slot;
        frame.companions.push(ActiveCompanion {
            part: of.part,
            casts: shadow.is_some() && !light.sets.s.is_clear(),
            is_alone: of.part == CompanionPart::Others && is_known_seen != Some(of.light),
            shadow: ActiveLight {
                entity: light.entity,
                light: index,
                slot,
                technique: Some(technique).filter(|_| shadow.is_some()),
                shadow,
                is_scaled: false,
                is_tinted: false,
                scissor: area.scissor,
                depth_range: area.depth_range,
                batches,
                unlit: first..first,
                front: 0..0,
                front_scissor: [0; 4],
                companions: 0..0,
            },
        });
    }
}

/// Lists the blended surfaces that companions need, among those of the front layer of their lights.
pub(in crate::render) fn collect_front_companions(frame: &mut FrameData, lights: &FrameLights) {
    for at in 0..frame.lights.len() {
        let FrameData {
            batches,
            instances,
            lights: active,
            companions,
            ..
        } = &mut *frame;
        let light = &active[at];
        for companion in &mut companions[light.companions.clone()] {
            let shadow = &mut companion.shadow;
            let set = &lights.lights[shadow.light].sets.i;
            let first = batches.len();
            for front in light.front.clone() {
                let batch = batches[front].clone();
                if set.contains(instances[batch.instances.start as usize] as usize) {
                    batches.push(batch);
                }
            }
            shadow.front = first..batches.len();
            shadow.front_scissor = overlap(light.front_scissor, shadow.scissor);
        }
    }
}

/// Returns the overlap of two rectangles: x, y, width, height. Width or height is 0 if there is none.
fn overlap(a: [u32; 4], b: [u32; 4]) -> [u32; 4] {
    let along = |axis: usize| {
        let start = a[axis].max(b[axis]);
        let end = (a[axis] + a[axis + 2]).min(b[axis] + b[axis + 2]);
        (start, end.saturating_sub(start))
    };
    let ([x, width], [y, height]) = (along(0).into(), along(1).into());
    [x, y, width, height]
}

impl Renderer {
    /// Darkens the mask of a light by its companions: on surfaces that the light's technique knows, by casters that it does
    /// not know, and on the others by all casters.
    pub(in crate::render) fn darken_by_companions(
        &self,
        frame: &mut Recording,
        light: &ActiveLight,
        surfaces: LightSurfaces,
    ) {
        let (Some(masks), Some(node)) = (&self.masks, &self.darker_mask) else {
            return;
        };
        let Some(second) = &masks.second else { return };
        let companions = &self.frame.companions[light.companions.clone()];
        let others = companions
            .iter()
            .find(|companion| companion.part == CompanionPart::Others)
            .map_or(0..0, |companion| surfaces.batches(&companion.shadow));
        let others = self.batches(&others);
        for companion in companions.iter().filter(|companion| companion.casts) {
            let shadow = &companion.shadow;
            let area = DarkerArea {
                scissor: surfaces.scissor(shadow),
                depth_range: shadow.depth_range,
                label: self.label_of(shadow),
            };
            let [_, _, width, height] = area.scissor;
            let is_known = companion.part == CompanionPart::Known;
            let is_everywhere = is_known || companion.is_alone;
            if width == 0 || height == 0 || (!is_everywhere && others.is_empty()) {
                continue;
            }
            self.resolve_companion(frame, shadow, surfaces, second);
            if is_known {
                // The other companion shadows these, by more casters.
                darker_mask::clear_surfaces(frame, second, &area, others);
            }
            if is_everywhere {
                node.record(frame, masks, &second.mask_group, &self.light_begin, &area);
            } else {
                darker_mask::record_surfaces(frame, masks, &second.mask_group, &area, others);
            }
        }
    }

    /// Leaves the visibility of a companion in its mask.
    fn resolve_companion(
        &self,
        frame: &mut Recording,
        companion: &ActiveLight,
        surfaces: LightSurfaces,
        masks: &MaskTargets,
    ) {
        let input = self.resolve_input(frame, companion, surfaces, masks);
        match self.leaves(companion) {
            Some(Leaves::Mask(resolve)) => resolve.resolve(companion.light, frame.encoder, &input),
            Some(Leaves::Stencil(mark)) => self.mask_of_stencil(frame, companion, mark, &input),
            None => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rectangles_overlap_in_what_both_have() {
        assert_eq!(overlap([0, 0, 10, 10], [4, 6, 10, 2]), [4, 6, 6, 2]);
        assert_eq!(overlap([4, 6, 10, 2], [0, 0, 10, 10]), [4, 6, 6, 2]);
        let [_, _, width, height] = overlap([0, 0, 4, 4], [6, 1, 3, 2]);
        assert_eq!((width, height), (0, 2));
    }
}
