//! Where the wedges of a caster end: at a plane beyond all receivers, if one plane stops every ray of its
//! shadow.
//!
//! The part of a wedge beyond the receivers changes no sum, but it is drawn; below a ground it is most of the
//! wedge. The candidates are the planes of the sides of the box around the receivers. Each caster has its own
//! plane, so that sides, shells and far caps still meet.
//!
//! A caster that is counted towards the viewer has no far cap, so nothing on the way from the viewport to a receiver may cross
//! its plane: it lies beyond the viewport too.

use bevy_ecs::prelude::*;
use glam::{DMat4, DVec3, DVec4, Vec3};

use crate::geometry::Aabb;
use crate::scene::placement::Placement;
use crate::sets::{FrameLight, FrameLights, Objects};
use crate::techniques::penumbra_wedge::wedges::{CasterDraw, PenumbraWedges};

/// The plane that stands for none, with which rays reach infinity.
pub const ENDLESS: [f32; 4] = [0.0, 0.0, 0.0, 1.0];

/// Share of the receivers' extent by which a plane lies beyond them, against rounding.
const MARGIN: f64 = 0.01;

/// Limit on the ratio of the plane's distance from the caster to the caster's distance from the light. Beyond
/// it, the end saves nothing.
const FARTHEST: f64 = 100.0;

/// Finds the nearest plane beyond `receivers` and `caster` that every ray from `emitter` through `caster`
/// meets, world space: `dot(xyz, p) = w`. `None` if there is none.
pub fn end_plane(receivers: &Aabb, caster: &Aabb, emitter: &Aabb) -> Option<DVec4> {
    let (receivers, caster, emitter) = (corners(receivers), corners(caster), corners(emitter));
    let around = receivers[0].min(caster[0])..receivers[1].max(caster[1]);
    let extent = (around.end - around.start).length();
    let magnitude = around.start.abs().max(around.end.abs()).max_element();
    let mut best: Option<(f64, DVec4)> = None;
    for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
        let farthest = |[min, max]: [DVec3; 2]| (min[axis] * sign).max(max[axis] * sign);
        let nearest = |[min, max]: [DVec3; 2]| (min[axis] * sign).min(max[axis] * sign);
        let end = farthest([around.start, around.end]) + extent * MARGIN + magnitude * 1e-5;
        let (from_light, to_end) = (nearest(caster) - farthest(emitter), end - nearest(caster));
        let reach = to_end / from_light;
        let is_better = from_light > 0.0 && reach < best.map_or(FARTHEST, |(reach, _)| reach);
        if is_better && end.is_finite() {
            let mut normal = DVec3::ZERO;
            normal[axis] = sign;
            best = Some((reach, normal.extend(end)));
        }
    }
    best.map(|(_, plane)| plane)
}

fn corners(aabb: &Aabb) -> [DVec3; 2] {
    [aabb.min.as_dvec3(), aabb.max.as_dvec3()]
}

/// Transforms a plane to a space from which `world_from_b` leads to the world.
fn in_space(plane: DVec4, world_from_b: &DMat4) -> [f32; 4] {
    // Planes transform as covectors: dot(n, M p + t) = d.
    let b = world_from_b.transpose() * plane.truncate().extend(-plane.w);
    let length = b.truncate().length();
    let scaled = DVec4::new(b.x, b.y, b.z, -b.w) / length;
    if length > 0.0 && scaled.is_finite() {
        scaled.as_vec4().to_array()
    } else {
        ENDLESS
    }
}

/// Returns the box around the visible receivers of the light in this frame.
fn receivers(light: &FrameLight) -> Aabb {
    let boxes = light.region.lit_receivers.iter().copied();
    boxes.reduce(Aabb::union).unwrap_or(Aabb {
        min: Vec3::splat(f32::NEG_INFINITY),
        max: Vec3::INFINITY,
    })
}

impl PenumbraWedges {
    /// Sets the plane where the wedges of each caster end in this frame. Wedges of directional lights have no
    /// such plane, because their far caps are a point at infinity. In orthographic views
    /// [`finite_reach`](crate::techniques::shared::finite_reach) determines where wedges end. `viewport` is the box around the
    /// view's near rectangle.
    pub(in crate::techniques::penumbra_wedge) fn end(
        &mut self,
        viewport: &Aabb,
        lights: &FrameLights,
        objects: &Objects,
        places: &Query<Placement>,
    ) {
        let mut changed = false;
        for of_light in &self.lights {
            let light = &lights.lights[of_light.light];
            let receivers = receivers(light);
            let seen = receivers.union(*viewport);
            for part in &self.parts[of_light.parts.clone()] {
                let center = part.part.point_world;
                let radius = part.part.shape.radius();
                let emitter = Aabb {
                    min: (center.truncate() - radius).as_vec3(),
                    max: (center.truncate() + radius).as_vec3(),
                };
                let casters = self.groups[part.groups.clone()]
                    .iter()
                    .flat_map(|group| group.casters.clone());
                for caster in casters {
                    let CasterDraw { object, towards, .. } = self.casters[caster];
                    let object = object as usize;
                    let before = if towards { &seen } else { &receivers };
                    let plane = (center.w != 0.0 && part.reach == 0.0)
                        .then(|| end_plane(before, &objects.boxes.get(object), &emitter))
                        .flatten();
                    let place = places.get(objects.entities[object]).ok();
                    let ends = match (plane, place.and_then(|place| place.world_from_local())) {
                        (Some(plane), Some(world_from_local)) => [
                            in_space(plane, &world_from_local),
                            in_space(plane, &part.part.world_from_light),
                        ],
                        _ => [ENDLESS; 2],
                    };
                    let record = &mut self.caster_records[caster];
                    changed |= [record.end_local, record.end_light] != ends;
                    [record.end_local, record.end_light] = ends;
                }
            }
        }
        self.casters_generation += u64::from(changed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(center: Vec3, half: f32) -> Aabb {
        Aabb::around(center, Vec3::splat(half))
    }

    #[test]
    fn rays_from_above_end_below_the_ground() {
        let ground = Aabb {
            min: Vec3::new(-10.0, 0.0, -10.0),
            max: Vec3::new(10.0, 0.0, 10.0),
        };
        let plane = end_plane(&ground, &cube(Vec3::Y, 0.5), &cube(Vec3::Y * 5.0, 0.3)).expect("below");
        assert_eq!(plane.truncate(), DVec3::NEG_Y);
        assert!(plane.w > 0.0 && plane.w < 0.5);
        // From a caster beside the light, some rays go up.
        assert!(end_plane(&ground, &cube(Vec3::Y * 4.5, 0.5), &cube(Vec3::Y * 5.0, 0.3)).is_none());
    }

    #[test]
    fn planes_go_with_their_space() {
        let world_from_b = DMat4::from_scale_rotation_translation(
            DVec3::new(2.0, 0.5, -1.0),
            glam::DQuat::from_rotation_x(0.7),
            DVec3::new(3.0, -4.0, 5.0),
        );
        let plane = DVec4::new(0.0, -1.0, 0.0, 2.5);
        let [x, y, z, w] = in_space(plane, &world_from_b);
        for p in [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)] {
            let world = world_from_b.transform_point3(p);
            let (here, there) = (
                plane.truncate().dot(world) - plane.w,
                Vec3::new(x, y, z).as_dvec3().dot(p) - f64::from(w),
            );
            assert!(here.signum() == there.signum() && (here / there).is_finite());
        }
        assert_eq!(in_space(plane, &DMat4::ZERO), ENDLESS);
    }
}
