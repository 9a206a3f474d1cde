//! From Bevy's lights to ours, and from render layers to selection masks.

use bevy::camera::visibility::RenderLayers;
use bevy::color::{Color, ColorToComponents, LinearRgba};
use bevy::ecs::world::EntityRef;
use bevy::light::{DirectionalLight, PointLight, RectLight, SpotLight};
use glam::Vec3;

use crate::scene::{Light, LightKind, LightSelection};

/// Which of Bevy's light functions a light is computed by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BevyLight {
    /// `PointLight`.
    Point,
    /// `SpotLight`.
    Spot,
    /// `DirectionalLight`.
    Directional,
    /// `RectLight`.
    Rect,
}

/// Our light for an entity with one of Bevy's; `None` if it has none. A point light with a radius is a sphere, which
/// techniques of soft shadows take as it is. Of colour and intensity only whether there is any matters here: Bevy's own
/// functions shade.
pub fn convert_light(entity: &EntityRef) -> Option<(BevyLight, Light)> {
    if let Some(light) = entity.get::<PointLight>() {
        let kind = if light.radius > 0.0 {
            LightKind::Sphere { radius: light.radius }
        } else {
            LightKind::Point
        };
        return Some((
            BevyLight::Point,
            make(kind, light.color, light.intensity, light.range),
        ));
    }
    if let Some(light) = entity.get::<SpotLight>() {
        // Bevy allows cones that are sharp at their edge and as wide as a half space.
        let outer_angle = light.outer_angle.min(std::f32::consts::FRAC_PI_2);
        let kind = LightKind::Spot {
            inner_angle: 0.0,
            outer_angle,
        };
        return Some((
            BevyLight::Spot,
            make(kind, light.color, light.intensity, light.range),
        ));
    }
    if let Some(light) = entity.get::<DirectionalLight>() {
        let light = make(
            LightKind::Directional,
            light.color,
            light.illuminance,
            f32::INFINITY,
        );
        return Some((BevyLight::Directional, light));
    }
    let light = entity.get::<RectLight>()?;
    let kind = LightKind::Rect {
        width: light.width,
        height: light.height,
    };
    Some((
        BevyLight::Rect,
        make(kind, light.color, light.intensity, light.range),
    ))
}

fn make(kind: LightKind, color: Color, intensity: f32, range: f32) -> Light {
    Light {
        kind,
        color: Vec3::from_array(LinearRgba::from(color).to_f32_array_no_alpha()),
        intensity,
        range,
    }
}

/// Layers as bits. Layer 31 stands for itself and all beyond: what is on one of those is selected by lights on any.
pub fn layer_bits(layers: Option<&RenderLayers>) -> u32 {
    let Some(layers) = layers else {
        return 1;
    };
    let mut bits = 0u32;
    for (block, &word) in layers.bits().iter().enumerate() {
        if block == 0 {
            bits |= word as u32;
        }
        let beyond = if block == 0 { word >> 32 } else { word };
        bits |= u32::from(beyond != 0) << 31;
    }
    bits
}

/// What a light acts on: it lights all, as Bevy's lights do, and is blocked by what shares a layer with it, as Bevy's
/// shadow maps have it. A [`LightSelection`] of its own cuts both further.
pub fn selection(layers: Option<&RenderLayers>, own: Option<&LightSelection>) -> LightSelection {
    let own = own.copied().unwrap_or_default();
    LightSelection {
        affects: own.affects,
        casts_for: own.casts_for & layer_bits(layers),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layers_beyond_the_mask_share_its_last_bit() {
        assert_eq!(layer_bits(None), 1);
        assert_eq!(layer_bits(Some(&RenderLayers::from_layers(&[0, 3]))), 0b1001);
        assert_eq!(layer_bits(Some(&RenderLayers::from_layers(&[31]))), 1 << 31);
        assert_eq!(layer_bits(Some(&RenderLayers::from_layers(&[40]))), 1 << 31);
        assert_eq!(layer_bits(Some(&RenderLayers::from_layers(&[130]))), 1 << 31);
        assert_eq!(layer_bits(Some(&RenderLayers::none())), 0);
    }
}
