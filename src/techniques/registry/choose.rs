//! The choice of the technique that shadows a light in this frame.

use bevy_ecs::prelude::*;

use super::companions::chosen;
use super::refusal::RefusedLight;
use super::row::Row;
use super::techniques::Techniques;
use crate::sets::{FrameLight, FrameLights, LightTechnique};

/// Chooses the technique of every light of the frame. It is the first technique of the world's list whose
/// component is on the light. If that technique refuses the light
/// ([`Technique::check`](super::Technique::check)), the light has none.
///
/// A light with several components uses the first in the order of the list, not in the order of insertion, so
/// that a frame does not depend on history. The other components have no effect and are reported. Nothing is
/// kept from frame to frame, so techniques may be added, removed or exchanged at any time.
///
/// A technique that leaves objects to others ([`Technique::LEAVES_OTHERS`](super::Technique::LEAVES_OTHERS)) comes first, and
/// the first of the others is that of the light's companions. It is the technique of the light if the former refuses the
/// light; the companions then have none.
///
/// Set: `CollectSets`, after `collect_frame_lights`. The system is exclusive, because the list determines
/// which components it reads. Writes [`FrameLight::technique`]. Cost: one component lookup for each light and
/// technique.
pub fn choose_techniques(world: &mut World) {
    let mut frame = std::mem::take(&mut *world.resource_mut::<FrameLights>());
    let mut techniques = world.resource_mut::<Techniques>();
    let mut refused = std::mem::take(&mut techniques.refused);
    refused.clear();
    let techniques = world.resource::<Techniques>();
    let scene_count = frame.scene_count();
    let (of_scene, companions) = frame.lights.split_at_mut(scene_count);
    for light in &mut *of_scene {
        light.technique = world
            .get_entity(light.entity)
            .ok()
            .and_then(|entity| choose(techniques, entity, light, &mut refused));
    }
    for companion in companions {
        let leaves = companion.companion_of.is_some_and(|of| {
            let at = of_scene.binary_search_by_key(&of.light, |light| light.entity);
            let technique = at.ok().and_then(|at| of_scene[at].technique);
            technique.is_some_and(|technique| techniques.rows[technique.row].leaves_others())
        });
        let was_in_use = companion.technique.is_some();
        companion.technique = world
            .get_entity(companion.entity)
            .ok()
            .filter(|_| leaves)
            .and_then(|entity| choose(techniques, entity, companion, &mut refused));
        // The sets of a companion without a technique are empty.
        companion.moved |= companion.technique.is_some() != was_in_use;
    }
    world.resource_mut::<Techniques>().refused = refused;
    *world.resource_mut::<FrameLights>() = frame;
}

fn choose(
    techniques: &Techniques,
    entity: EntityRef,
    light: &FrameLight,
    refused: &mut Vec<RefusedLight>,
) -> Option<LightTechnique> {
    let rows = techniques.rows.iter().enumerate();
    let chosen = chosen(rows.filter(|(_, row)| row.is_on(&entity)))?;
    let mut usable = |(index, row): (usize, &Row)| match row.check(&entity, &light.light) {
        Ok(()) => Some(LightTechnique {
            row: index,
            name: row.name(),
            component: row.component(),
            needs: row.needs(),
        }),
        Err(refusal) => {
            refused.push(RefusedLight {
                entity: light.entity,
                row: index,
                refusal,
            });
            None
        }
    };
    usable(chosen.first).or_else(|| usable(chosen.second?))
}
