//! Which technique shadows a light in this frame.

use bevy_ecs::prelude::*;

use super::refusal::RefusedLight;
use super::techniques::Techniques;
use crate::sets::{FrameLight, FrameLights, LightTechnique};

/// Finds the technique of every light of the frame: the first of the world's list whose component is on the light,
/// unless it refuses the light ([`Technique::check`](super::Technique::check)).
///
/// One light has one technique. Of several components the first of the list counts, whichever was inserted first, so that
/// a frame depends on what is there and not on what was; the others do nothing, and are reported. Nothing is kept from
/// frame to frame: a technique may be added, removed or exchanged at any time.
///
/// Set: `CollectSets`, after `collect_frame_lights`. Exclusive: components are asked for by the list. Writes
/// [`FrameLight::technique`]. Cost: a look at each light for each technique.
pub fn choose_techniques(world: &mut World) {
    let mut frame = std::mem::take(&mut *world.resource_mut::<FrameLights>());
    let mut techniques = world.resource_mut::<Techniques>();
    let mut refused = std::mem::take(&mut techniques.refused);
    refused.clear();
    let techniques = world.resource::<Techniques>();
    for light in &mut frame.lights {
        light.technique = world
            .get_entity(light.entity)
            .ok()
            .and_then(|entity| choose(techniques, entity, light, &mut refused));
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
    let (index, row) = rows.into_iter().find(|(_, row)| row.is_on(&entity))?;
    if let Err(refusal) = row.check(&entity, &light.light) {
        refused.push(RefusedLight {
            entity: light.entity,
            row: index,
            refusal,
        });
        return None;
    }
    Some(LightTechnique {
        row: index,
        name: row.name(),
        component: row.component(),
        needs: row.needs(),
    })
}
