//! The view depths among which cascades are shared out: from the receivers near the camera to the last visible shadow.

use glam::DVec3;

use super::cascades::{DepthRange, split_depths};
use super::frame_scene::pixel_metres;
use super::light_map::LightMap;
use crate::geometry::Aabb;
use crate::sets::{FrameLight, Objects, Projector, ViewData};

/// Share of a pixel below which the length of a shadow does not matter.
const VISIBLE_PIXELS: f64 = 0.5;

/// Side of a pixel at view depth 1, metres, that counts at most. In pictures of a few pixels, each of them is as large as what
/// the scene shows, and half of it would hide every shadow.
const LARGEST_PIXEL: f64 = 1.0 / 32.0;

/// Share by which the range ends beyond the last shadow. A box is hardly larger than the part of the view that it shows, and
/// filters need room around a shadow. By eye.
const ROOM: f64 = 0.25;

/// Returns the range of view depth in which a directional light's shadows are seen. `distance` is the view depth beyond
/// which none is wanted, `softness` the radius of the filter, both in metres.
///
/// Cost: O(set S), and the receivers near the camera.
pub fn cascade_range(
    light: &FrameLight,
    objects: &Objects,
    view: &ViewData,
    distance: f64,
    softness: f64,
) -> DepthRange {
    let seen = light
        .region
        .depth_bounds
        .map_or(f64::INFINITY, |bounds| f64::from(bounds.far));
    let scale = view.frustum.shape().forward.length();
    let last = with_room(last_shadow(light, objects, view), softness / scale);
    let (around, apart) = nearest_receivers(light, objects, view.eye);
    let end = distance / scale;
    DepthRange {
        near: view.near,
        nearest: around.min(apart) / scale,
        apart: apart / scale,
        far: seen.min(end).min(last),
        end: end.is_finite().then_some(end),
    }
}

/// Returns how many pixels along a side a texel covers, where the nearest receiver of a directional light is that the camera
/// is not in: of a room or of the player's own body, the bounds do not tell where its surface is.
pub fn pixels_of_texel(map: &LightMap, range: &DepthRange, view: &ViewData) -> f64 {
    let pixel = pixel_metres(view);
    if view.is_orthographic() {
        let face = map.faces.first();
        return face.map_or(0.0, |face| face.face.texel_metres(map.resolution) / pixel);
    }
    let depth = range.apart.max(range.near);
    let splits = split_depths(&map.request.cascades, range);
    let shows = map.faces.iter().zip(&splits[1..]).find(|(_, end)| **end >= depth);
    shows.map_or(0.0, |(face, _)| {
        face.face.texel_metres(map.resolution) / (pixel * depth)
    })
}

/// Returns a depth some way beyond the last shadow. `softness` is the radius of the filter, in units of depth.
pub fn with_room(last: f64, softness: f64) -> f64 {
    (last + 2.0 * softness) * (1.0 + ROOM)
}

/// Returns the view depth beyond which no visible surface is shadowed by a caster of set S. Each caster moves along the
/// light until it has left the bounds of the receivers. A shadow that is shorter than half a pixel does not count, and a pixel
/// has at most the side [`LARGEST_PIXEL`]. So a ground that holds the receivers up, and shadows nothing below it, adds nothing,
/// however large it is.
pub fn last_shadow(light: &FrameLight, objects: &Objects, view: &ViewData) -> f64 {
    let projector = Projector::new(view);
    let gradient = projector.depth_gradient();
    let along = -light.point_world.truncate();
    let receivers = &light.region.receiver_bounds;
    let pixel = pixel_metres(view).min(LARGEST_PIXEL);
    let mut last = view.near;
    for index in light.sets.s.ones() {
        let (center, half) = objects.boxes.center_half(index);
        let length = travel(center, half, along, receivers);
        if length <= 0.0 {
            continue;
        }
        let depth = projector.depth(center);
        let mut far = depth.max(depth + gradient.dot(along) * length) + gradient.abs().dot(half);
        if !view.is_orthographic() {
            far = far.min(length / (VISIBLE_PIXELS * pixel));
        }
        last = last.max(far);
    }
    last
}

/// Returns how far a box moves along a unit direction until it has left the bounds; not positive if it is beyond them.
pub fn travel(center: DVec3, half: DVec3, along: DVec3, bounds: &Aabb) -> f64 {
    let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
    let mut length = f64::INFINITY;
    for axis in 0..3 {
        let room = if along[axis] > 0.0 {
            max[axis] - (center[axis] - half[axis])
        } else {
            center[axis] + half[axis] - min[axis]
        };
        let speed = along[axis].abs();
        if speed > 0.0 {
            length = length.min(room / speed);
        }
    }
    length
}

/// Returns the distances from the eye to the nearest of the receivers that the light reaches, metres: of those whose boxes
/// hold the eye, to the nearest side of a box; and of the others. They do not depend on the direction of the view, so
/// cascades keep their sizes while the view turns.
fn nearest_receivers(light: &FrameLight, objects: &Objects, eye: DVec3) -> (f64, f64) {
    let outside = |(center, half): (DVec3, DVec3)| (eye - center).abs() - half;
    let (mut around, mut apart) = (f64::INFINITY, f64::INFINITY);
    let words = light.sets.l.as_slice().iter().zip(objects.receivers.as_slice());
    for (word, (reached, receivers)) in words.enumerate() {
        let mut members = reached & receivers;
        if members == 0 {
            continue;
        }
        let of_word = outside(objects.clusters.words.center_half(word));
        let nearest = of_word.max(DVec3::ZERO).length();
        while members != 0 && nearest < apart {
            let index = word * usize::BITS as usize + members.trailing_zeros() as usize;
            members &= members - 1;
            let outside = outside(objects.boxes.center_half(index));
            if outside.max_element() > 0.0 {
                apart = apart.min(outside.max(DVec3::ZERO).length());
            } else {
                around = around.min(-outside.max_element());
            }
        }
    }
    (around, apart)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn boxes_travel_until_their_last_corner_has_left() {
        let bounds = Aabb {
            min: Vec3::new(-10.0, 0.0, -10.0),
            max: Vec3::new(10.0, 5.0, 10.0),
        };
        let along = DVec3::new(0.6, -0.8, 0.0);
        let pillar = travel(DVec3::new(0.0, 1.0, 0.0), DVec3::splat(1.0), along, &bounds);
        assert!((pillar - 2.0 / 0.8).abs() < 1e-12, "{pillar}");
        let at_the_side = travel(DVec3::new(9.0, 4.0, 0.0), DVec3::splat(1.0), along, &bounds);
        assert!((at_the_side - 2.0 / 0.6).abs() < 1e-12, "{at_the_side}");
        let ground = travel(DVec3::ZERO, DVec3::new(10.0, 0.0, 10.0), along, &bounds);
        assert_eq!(ground, 0.0);
        assert!(travel(DVec3::new(0.0, -3.0, 0.0), DVec3::splat(1.0), along, &bounds) < 0.0);
    }
}
