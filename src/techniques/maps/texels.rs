//! Texels of maps, for debug views.

use bevy_ecs::prelude::*;

use super::Maps;
use super::cascades::BORDER;
use super::request::MapShape;
use crate::techniques::registry::TexelLookup;
use crate::techniques::shared::pictures::{Chosen, Picture, texel_lookup};

/// Returns what counts the texels of a light's map, as it was drawn last; `None` if it is not looked up.
pub fn texels(world: &World, light: usize) -> Option<TexelLookup<'_>> {
    let map = world.get_resource::<Maps>()?.of_light(light)?;
    let drawn = map.faces.iter().filter(|face| face.revision != 0);
    let pictures = drawn.map(|face| Picture {
        clip_from_world: face.face.clip_from_world(),
        resolution: map.resolution,
    });
    let chosen = match map.request.shape {
        MapShape::Cascades => Chosen::First { border: BORDER },
        MapShape::Spot | MapShape::Cube | MapShape::Matrices => Chosen::Innermost,
    };
    Some(texel_lookup(pictures.collect(), chosen))
}
