//! Far corners of shadow volumes and the bounds of their parts. [`far_position`] is the twin of the function
//! of the same name in `shaders/techniques/stencil_volume/volume.wgsl`.

use glam::{DVec3, DVec4, Vec3, Vec4};

use crate::geometry::{Aabb, BoxReceivers};

/// The extrusion of a volume that reaches infinity.
pub const TO_INFINITY: f32 = 0.0;

/// Pushes a vertex away from the light and returns it as a homogeneous point.
///
/// With [`TO_INFINITY`] the result is at infinity (`w = 0`). Otherwise `extrusion` is a factor on the
/// vertex's distance from the light or, for a light at infinity, a distance in metres.
pub fn far_position(light_local: Vec4, extrusion: f32, position_local: Vec3) -> Vec4 {
    let from_light = position_local * light_local.w - light_local.truncate();
    if extrusion > TO_INFINITY {
        let base = light_local.truncate() * light_local.w + position_local * (1.0 - light_local.w);
        (base + from_light * extrusion).extend(1.0)
    } else {
        from_light.extend(0.0)
    }
}

/// Returns the factor on the distance from the light that moves every point of a caster beyond everything it
/// may shadow, which ends at the light's range or at the farthest receiver, whichever is nearer. Returns
/// `None` if the caster shadows no receiver.
///
/// Scaling about the light keeps each side in its plane, so a finite volume is a part of the infinite one.
/// The whole far cap is the scaled caster, so no part of it reaches back to lit surfaces, however wide the
/// caster is.
///
/// Returns [`TO_INFINITY`] for directional lights, and where the light is inside the bounds or so near them
/// that a finite volume saves nothing. `receivers` are relative to this light. Cost: the receivers, eight at a time.
/// Source: Lloyd et al. 2004, "CC Shadow Volumes", for clamping volumes to receivers; the method is ours.
pub fn finite_extrusion(
    light_world: DVec4,
    range: f32,
    bounds_world: &Aabb,
    receivers: &BoxReceivers,
) -> Option<f32> {
    /// Above this factor the far corners are so far out that a finite volume saves nothing. Chosen by eye.
    const LARGEST: f64 = 1000.0;
    /// Keeps the far cap beyond the lit surfaces in spite of rounding.
    const SLACK: f64 = 1.001;
    /// Distance of the far cap from the caster as a share of the farthest corner's distance from the light. Depths of a
    /// triangle are rounded as its corners are: the cap of a ground of kilometres is centimetres off beneath a lamp. Caps that
    /// were closer than 3e-8 came out before the ground.
    const ROUNDING: f64 = 1e-6;
    if light_world.w == 0.0 || bounds_world.is_empty() {
        return Some(TO_INFINITY);
    }
    let light = light_world.truncate();
    let nearest = light.clamp(bounds_world.min.as_dvec3(), bounds_world.max.as_dvec3());
    let distance = light.distance(nearest);
    let to_range = f64::from(range) / distance;
    let to_receivers = f64::from(receivers.farthest(bounds_world)?);
    let farthest = bounds_world
        .corners()
        .map(|corner| light.distance(corner.as_dvec3()));
    let farthest = farthest.into_iter().fold(0.0, f64::max);
    let factor = to_receivers.min(to_range) * SLACK.max(1.0 + ROUNDING * farthest / distance);
    Some(if factor <= LARGEST {
        factor.max(1.0) as f32
    } else {
        TO_INFINITY
    })
}

/// Returns the corners of a box, then the same corners pushed away from the light. Their convex hull contains
/// the whole shadow volume of anything in the box; the hull of the second half contains the far cap.
pub fn volume_corners(light_world: DVec4, extrusion: f32, bounds_world: &Aabb) -> [Vec4; 16] {
    let near = bounds_world.corners();
    std::array::from_fn(|i| {
        let corner: DVec3 = near[i % 8].as_dvec3();
        if i < 8 {
            return corner.extend(1.0).as_vec4();
        }
        let from_light = corner * light_world.w - light_world.truncate();
        if extrusion > TO_INFINITY {
            let base = light_world.truncate() * light_world.w + corner * (1.0 - light_world.w);
            (base + from_light * f64::from(extrusion)).extend(1.0).as_vec4()
        } else {
            from_light.normalize_or_zero().extend(0.0).as_vec4()
        }
    })
}
