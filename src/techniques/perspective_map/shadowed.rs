//! The part of space in which a directional light's casters can darken something.
//!
//! A map need not show a ground beyond all shadows: what no face shows is lit.

use glam::{DVec3, DVec4};
use smallvec::SmallVec;

use super::view_space::ViewSpace;
use crate::sets::{FrameLight, Objects, ViewData};
use crate::techniques::maps::cascade_range::{last_shadow, travel, with_room};

/// Adds the half-spaces, in view coordinates, of the box around all shadows, and of the depth up to which shadows are
/// seen. `reach` is the distance to which filters carry a shadow beyond its edge, metres.
///
/// Each caster moves along the light until it has left the bounds of the receivers; the box holds all that it passes. A
/// ground below which nothing is adds nothing, however large it is. Lights at a position are left alone, because their
/// cone or range bounds their shadows.
pub fn push_half_spaces(
    light: &FrameLight,
    objects: &Objects,
    view: &ViewData,
    space: &ViewSpace,
    casters: impl Iterator<Item = usize>,
    reach: f64,
    half_spaces: &mut SmallVec<[DVec4; 20]>,
) {
    if light.point_world.w != 0.0 {
        return;
    }
    let along = -light.point_world.truncate();
    let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for index in casters {
        let (center, half) = objects.boxes.center_half(index);
        let length = travel(center, half, along, &light.region.receiver_bounds);
        if length > 0.0 {
            let moved = along * length;
            min = min.min(center - half + moved.min(DVec3::ZERO));
            max = max.max(center + half + moved.max(DVec3::ZERO));
        }
    }
    if min.cmpgt(max).any() {
        half_spaces.push(DVec4::NEG_W); // nothing casts, so nothing is to be shown
        return;
    }
    let margin = reach + 1e-4 * (max - min).max_element();
    for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
        half_spaces.push(space.half_space(axis, min - margin));
        half_spaces.push(space.half_space(-axis, max + margin));
    }
    let scale = view.frustum.shape().forward.length();
    let far = with_room(last_shadow(light, objects, view), reach / scale);
    half_spaces.push(DVec4::new(0.0, 0.0, -1.0, far));
}
