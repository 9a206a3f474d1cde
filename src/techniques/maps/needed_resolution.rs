//! The resolution at which a texel of a light's map is as large as a pixel, where the light's receivers are seen.

use glam::{DVec2, DVec3};
use smallvec::SmallVec;

use super::frame_scene::pixel_metres;
use super::request::{MapRequest, MapShape};
use super::spot::spot_picture;
use crate::geometry::Aabb;
use crate::sets::{FrameLight, Projector, ViewData};

/// Lines of sight along the width and the height of the light's scissor.
const LINES: [u32; 2] = [8, 6];

/// Returns the number of texels along a side at which a texel is no larger than a pixel at three of four sampled points.
/// `None` for cascades, and if no line of sight meets a receiver.
///
/// The points are where lines of sight enter the boxes of the visible receivers, or leave the box that they begin in.
/// Cost: 48 lines times the boxes.
pub fn needed_resolution(request: &MapRequest, light: &FrameLight, view: &ViewData) -> Option<f64> {
    let scissor = light.region.scissor?;
    let size = view.viewport.as_dvec2();
    let projector = Projector::new(view);
    let world_from_clip = view.clip_from_world.inverse();
    let pixel = pixel_metres(view);
    let (first, extent) = (
        DVec2::new(f64::from(scissor.x), f64::from(scissor.y)),
        DVec2::new(f64::from(scissor.width), f64::from(scissor.height)),
    );
    let mut needs = SmallVec::<[f64; 48]>::new();
    for row in 0..LINES[1] {
        for column in 0..LINES[0] {
            let share = (DVec2::new(f64::from(column), f64::from(row)) + 0.5)
                / DVec2::new(f64::from(LINES[0]), f64::from(LINES[1]));
            let ndc = ((first + extent * share) / size - 0.5) * DVec2::new(2.0, -2.0);
            let begin = world_from_clip.project_point3(ndc.extend(1.0));
            let direction = world_from_clip.project_point3(ndc.extend(0.5)) - begin;
            let Some(t) = nearest_surface(&light.region.lit_receivers, begin, direction) else {
                continue;
            };
            let point = begin + direction * t;
            let pixel = if view.is_orthographic() {
                pixel
            } else {
                pixel * projector.depth(point)
            };
            let need = side_of_face(request, light, point)? / pixel;
            if need.is_finite() {
                needs.push(need);
            }
        }
    }
    needs.sort_unstable_by(f64::total_cmp);
    needs.get(needs.len() * 3 / 4).copied()
}

/// Returns the side of the map's picture at the distance of a point, metres.
fn side_of_face(request: &MapRequest, light: &FrameLight, point: DVec3) -> Option<f64> {
    let offset = point - light.point_world.truncate();
    match request.shape {
        MapShape::Cube => Some(2.0 * offset.abs().max_element()),
        MapShape::Spot => {
            let (axis, tangent) = spot_picture(light, request.filter)?;
            Some(2.0 * tangent * offset.dot(axis).max(0.0))
        }
        MapShape::Cascades | MapShape::Matrices => None,
    }
}

/// Returns where a line first enters one of the boxes, or first leaves one that it begins in.
fn nearest_surface(boxes: &[Aabb], begin: DVec3, direction: DVec3) -> Option<f64> {
    let hits = boxes.iter().filter_map(|aabb| {
        let (enter, leave) = aabb.crossed_by(begin, direction)?;
        (leave > 0.0).then_some(if enter > 0.0 { enter } else { leave })
    });
    hits.reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn lines_stop_where_they_enter_or_leave() {
        let around = |x: f32, half: f32| Aabb::around(Vec3::new(x, 0.0, 0.0), Vec3::splat(half));
        let boxes = [around(0.0, 8.0), around(5.0, 1.0)];
        let hit = |boxes: &[Aabb], x: f64| nearest_surface(boxes, DVec3::new(x, 0.1, 0.2), DVec3::X);
        assert_eq!(hit(&boxes, 0.0), Some(4.0));
        assert_eq!(hit(&boxes[..1], 0.0), Some(8.0));
        assert_eq!(hit(&boxes[1..], 7.0), None);
        assert_eq!(hit(&boxes, -10.0), Some(2.0));
    }

    #[test]
    fn lines_in_the_plane_of_a_side_meet_the_box() {
        let aabb = Aabb::around(Vec3::new(5.0, 1.0, 0.0), Vec3::ONE);
        for y in [0.0, 2.0] {
            assert_eq!(
                nearest_surface(&[aabb], DVec3::new(0.0, y, 0.2), DVec3::X),
                Some(4.0)
            );
        }
        assert_eq!(
            nearest_surface(&[aabb], DVec3::new(0.0, 2.1, 0.2), DVec3::X),
            None
        );
    }
}
