//! Far corners of shadow volumes and the bounds of their parts. [`far_position`] is the twin of the function of the
//! same name in `shaders/techniques/stencil_volume/volume.wgsl`.

use glam::{DVec3, DVec4, Vec3, Vec4};

use crate::geometry::{Aabb, BoxShadow};

/// Extrusion of a volume that reaches infinity.
pub const TO_INFINITY: f32 = 0.0;

/// A vertex pushed away from the light, homogeneous: to infinity (`w = 0`) if `extrusion` is [`TO_INFINITY`], else to
/// `extrusion` times its distance from the light, or by `extrusion` metres if that is at infinity.
pub fn far_position(light_local: Vec4, extrusion: f32, position_local: Vec3) -> Vec4 {
    let from_light = position_local * light_local.w - light_local.truncate();
    if extrusion > TO_INFINITY {
        let base = light_local.truncate() * light_local.w + position_local * (1.0 - light_local.w);
        (base + from_light * extrusion).extend(1.0)
    } else {
        from_light.extend(0.0)
    }
}

/// The factor that takes every point of a caster beyond all that it may shadow: beyond the light's range, `range` over the
/// light's distance from the caster's bounds, or beyond the receivers, whichever is less. `None`: it shadows none of them.
///
/// Scaling about the light keeps each side in its plane, so a finite volume is a part of the infinite one; and as the whole
/// far cap is the caster scaled, no part of it dips back into what is lit, however wide it is.
///
/// [`TO_INFINITY`] for directional lights, and where the light is inside or so near the bounds that a factor would be no
/// gain. `receivers`: boxes that are not empty.
/// Source: Lloyd et al. 2004, "CC Shadow Volumes", for clamping volumes to receivers; how is ours.
pub fn finite_extrusion(
    light_world: DVec4,
    range: f32,
    bounds_world: &Aabb,
    receivers: &[Aabb],
) -> Option<f32> {
    /// Beyond, far corners lie so far out that nothing is saved; by eye.
    const LARGEST: f64 = 1000.0;
    /// Keeps rounding on the far side of what is lit.
    const SLACK: f64 = 1.001;
    if light_world.w == 0.0 || bounds_world.is_empty() {
        return Some(TO_INFINITY);
    }
    let light = light_world.truncate();
    let nearest = light.clamp(bounds_world.min.as_dvec3(), bounds_world.max.as_dvec3());
    let to_range = f64::from(range) / light.distance(nearest);
    let to_receivers = f64::from(BoxShadow::new(light, bounds_world).farthest(receivers)?);
    let factor = to_receivers.min(to_range) * SLACK;
    Some(if factor <= LARGEST {
        factor.max(1.0) as f32
    } else {
        TO_INFINITY
    })
}

/// The corners of a box and the same pushed away from the light: near ones, then far ones. Their convex hull holds the
/// whole shadow volume of anything in the box, its second half the far cap.
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
