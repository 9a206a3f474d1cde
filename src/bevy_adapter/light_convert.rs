//! Conversion of Bevy's lights to [`Light`], and of render layers to selection masks.

use bevy::camera::visibility::RenderLayers;
use bevy::color::{Color, ColorToComponents, LinearRgba};
use bevy::ecs::world::EntityRef;
use bevy::light::{DirectionalLight, PointLight, RectLight, SpotLight};
use bevy::transform::components::GlobalTransform;
use glam::Vec3;

use crate::scene::{Light, LightKind, LightSelection};

/// The kind of a Bevy light. It selects the light function by which Bevy's shaders compute the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BevyLight {
    /// The light is a `PointLight`.
    Point,
    /// The light is a `SpotLight`.
    Spot,
    /// The light is a `DirectionalLight`.
    Directional,
    /// The light is a `RectLight`.
    Rect,
}

/// Converts the Bevy light of an entity; `None` if the entity has none.
///
/// A point light with a radius becomes a sphere, so that techniques with soft shadows know its size. A
/// rectangle's size is multiplied by the scale of its transform, because Bevy shades it with that size. Colour
/// and intensity only show whether the light is dark, because Bevy's own functions shade.
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
        // Bevy allows cones with a sharp edge and cones as wide as a half space.
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
    // Bevy scales rectangles by the lengths of the transform's axes.
    let axes = entity
        .get::<GlobalTransform>()
        .copied()
        .unwrap_or_default()
        .affine();
    let kind = LightKind::Rect {
        width: light.width * axes.matrix3.x_axis.length(),
        height: light.height * axes.matrix3.y_axis.length(),
    };
    Some((
        BevyLight::Rect,
        make(kind, light.color, light.intensity, light.range),
    ))
}

/// Returns the place of a Bevy rectangle for a [`Light`], which shines to the side of local −Z. Bevy shines along
/// `up × right` whichever way Z points, so the Z axis of a mirrored transform is turned round.
pub fn place_of_rect(transform: &GlobalTransform) -> GlobalTransform {
    let mut affine = transform.affine();
    if affine.matrix3.determinant() < 0.0 {
        affine.matrix3.z_axis = -affine.matrix3.z_axis;
    }
    affine.into()
}

fn make(kind: LightKind, color: Color, intensity: f32, range: f32) -> Light {
    Light {
        kind,
        color: Vec3::from_array(LinearRgba::from(color).to_f32_array_no_alpha()),
        intensity,
        range,
    }
}

/// Converts layers to bits. Layers from 31 on share bit 31, so a light on one of them selects objects on any
/// of them. An entity without layers is on layer 0.
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

/// Returns the selection of a light. The light affects all objects, as Bevy's lights do, and objects that
/// share a layer with it cast for it, as in Bevy's shadow maps. A [`LightSelection`] on the light's entity
/// (`own`) restricts both further.
pub fn selection(layers: Option<&RenderLayers>, own: Option<&LightSelection>) -> LightSelection {
    let own = own.copied().unwrap_or_default();
    LightSelection {
        affects: own.affects,
        casts_for: own.casts_for & layer_bits(layers),
        shows_on: own.shows_on,
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
