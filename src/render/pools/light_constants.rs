//! The constants of each light in the light pass.

use glam::{DVec3, Vec3};

use super::gpu_types;
use crate::render::light_model::constants::shape_constants;
use crate::scene::LightKind;
use crate::sets::FrameLight;

/// Makes the shader's constants of one light.
pub fn light_constants(light: &FrameLight, eye_world: DVec3) -> gpu_types::Light {
    let shining = &light.shining;
    let point = shining.emitter.point;
    let point_relative = if point.w == 0.0 {
        point.as_vec4()
    } else {
        (point.truncate() - eye_world).as_vec3().extend(1.0)
    };
    let range = shining.range;
    let inverse_range_sq = if range.is_finite() && point.w != 0.0 {
        1.0 / (range * range)
    } else {
        0.0
    };
    /// The largest emission. A larger one would overflow when it is divided by the least squared distance.
    const BRIGHTEST: f32 = 1e30;
    /// Slope of the intensity over the cosine at the edge of a cone without a rim. The intensity rises from 0 to 1 within two
    /// steps of an `f32` below 1.
    const SHARP: f32 = (1 << 23) as f32;
    let model = &light.model;
    let [emission, shadow_emission] = [light.light.color, model.tint.color]
        .map(|color| (color * light.light.intensity).min(Vec3::splat(BRIGHTEST)));
    let (scale, offset) = match light.light.kind {
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => {
            // Source: Khronos, KHR_lights_punctual, "Inner and Outer Cone Angles".
            // Without a rim, which that source divides by, intensity rises within one step of the cosine.
            let scale = if inner_angle == outer_angle {
                SHARP
            } else {
                1.0 / (inner_angle.cos() - outer_angle.cos()).max(1e-3)
            };
            (scale, -outer_angle.cos() * scale)
        }
        _ => (0.0, 1.0),
    };
    let [right, up] = shining.emitter.half_sides.map(|side| side.as_vec3());
    let radius = shining.emitter.radius as f32;
    let has_extent = radius > 0.0 || (right != Vec3::ZERO && up != Vec3::ZERO);
    gpu_types::Light {
        point_relative: point_relative.to_array(),
        emission: emission.extend(inverse_range_sq).to_array(),
        axis: light
            .direction
            .extend(f32::from(matches!(light.light.kind, LightKind::Rect { .. })))
            .to_array(),
        cone: [scale, offset, 0.0, 0.0],
        half_right: right.extend(radius).to_array(),
        half_up: up.extend(if has_extent { 1.0 } else { 0.0 }).to_array(),
        weights: model.weights.to_vec3().extend(model.tint.darkness).to_array(),
        shadow_emission: shadow_emission.extend(0.0).to_array(),
        shape: shape_constants(light, eye_world),
    }
}
