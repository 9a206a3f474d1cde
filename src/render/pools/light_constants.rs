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
    let model = &light.model;
    let [emission, shadow_emission] = [light.light.color, model.tint.color]
        .map(|color| (color * light.light.intensity).min(Vec3::splat(BRIGHTEST)));
    let (scale, offset) = match light.light.kind {
        LightKind::Spot {
            inner_angle,
            outer_angle,
        } => cone(inner_angle, outer_angle).into(),
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

/// Slope of the intensity over the cosine at the edge of a cone without a rim. The intensity rises from 0 to 1 within two
/// steps of an `f32` below 1.
const SHARP: f64 = (1 << 23) as f64;

/// Returns the factor and the summand that make the intensity of a spot light, 0 to 1, from the cosine of the angle to its axis.
///
/// Source: Khronos, KHR_lights_punctual, "Inner and Outer Cone Angles". That source takes the difference of the two cosines to be
/// at least 0.001, and so leaves cones of a degree or two nearly dark.
fn cone(inner_angle: f32, outer_angle: f32) -> [f32; 2] {
    let (inner, outer) = (f64::from(inner_angle), f64::from(outer_angle));
    // The cosines of small angles cancel in `f32`.
    let difference = 2.0 * (0.5 * (outer + inner)).sin() * (0.5 * (outer - inner)).sin();
    let scale = (1.0 / difference).min(SHARP);
    [scale as f32, (-outer.cos() * scale) as f32]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cone_has_full_intensity_inside_the_inner_angle_and_none_outside_the_outer_one() {
        for (inner, outer) in [
            (0.0, 1.0),
            (0.8, 1.0),
            (2.0, 3.0),
            (10.0, 10.2),
            (20.0, 45.0),
            (0.0, 90.0),
        ] {
            let [scale, offset] = cone(f32::to_radians(inner), f32::to_radians(outer));
            let at = |degrees: f32| degrees.to_radians().cos() * scale + offset;
            assert!((at(inner) - 1.0).abs() < 0.01, "{inner} {outer}: {}", at(inner));
            assert!(at(outer).abs() < 0.01, "{inner} {outer}: {}", at(outer));
        }
        let [scale, offset] = cone(1.0, 1.0);
        assert!((0.9999_f32.cos() * scale + offset) >= 1.0);
        assert!((1.0001_f32.cos() * scale + offset) <= 0.0);
    }
}
