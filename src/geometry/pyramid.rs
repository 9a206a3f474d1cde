//! Rectangular pyramid: the region between the barn doors of a light.

use glam::{DVec2, DVec3, DVec4, Vec3};

use super::convex_solid::HalfSpace;
use super::{Aabb, Emitter, PlaneSet};

/// A rectangular pyramid, which opens from its apex along an axis. It holds the points whose depth along the
/// axis is at most `depth`, and which lie at most `slopes` times their depth to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pyramid {
    /// Tip of the pyramid, metres.
    pub apex: DVec3,
    /// Unit vectors to the right, to the top, and along the axis. They are at right angles.
    pub axes: [DVec3; 3],
    /// Half the width and half the height one metre from the apex, metres; at least 0. They may be infinite.
    pub slopes: DVec2,
    /// Depth at which the pyramid ends, metres. It may be infinite.
    pub depth: f64,
}

/// Slopes from this value on count as infinite. A plane as steep bounds nothing.
const STEEPEST: f64 = 1e3;

/// Share by which slopes and depth grow. It covers the rounding of shaders, which compute in `f32`.
const SLACK: f64 = 1e-5;

impl Pyramid {
    /// The planes of the convex hull of the pyramid and a light, in no particular order. The light is at the apex.
    pub fn planes(&self, light: &Emitter) -> PlaneSet {
        let mut set = PlaneSet::default();
        let mut push = |normal: DVec3, offset: f64| {
            let offset = offset + light.extent(normal);
            set.planes.push(HalfSpace { normal, offset }.to_world(self.apex));
        };
        let [right, up, along] = self.axes;
        for (axis, slope) in [(right, self.slopes.x), (up, self.slopes.y)] {
            if slope < STEEPEST {
                let slope = slope * (1.0 + SLACK) + SLACK;
                push((along * slope - axis).normalize(), 0.0);
                push((along * slope + axis).normalize(), 0.0);
            }
        }
        if self.depth.is_finite() {
            push(-along, self.depth * (1.0 + SLACK));
        }
        set
    }

    /// Homogeneous corners, apex first. An infinite depth gives directions (`w = 0`). `None` if a slope is infinite.
    pub fn corners(&self) -> Option<[DVec4; 5]> {
        if self.slopes.max_element() >= STEEPEST {
            return None;
        }
        let [right, up, along] = self.axes;
        let slopes = self.slopes * (1.0 + SLACK) + SLACK;
        let mut corners = [self.apex.extend(1.0); 5];
        let signs = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
        for (corner, (x, y)) in corners[1..].iter_mut().zip(signs) {
            let ray = along + right * (slopes.x * x) + up * (slopes.y * y);
            *corner = if self.depth.is_finite() {
                (self.apex + ray * (self.depth * (1.0 + SLACK))).extend(1.0)
            } else {
                ray.extend(0.0)
            };
        }
        Some(corners)
    }

    /// The box around the pyramid, padded. `None` if the pyramid is infinite.
    pub fn aabb(&self) -> Option<Aabb> {
        let corners = self.corners().filter(|corners| corners[1].w != 0.0)?;
        let mut aabb = Aabb::EMPTY;
        for corner in corners {
            let point: Vec3 = corner.truncate().as_vec3();
            aabb = aabb.union(Aabb {
                min: point,
                max: point,
            });
        }
        Some(aabb.padded())
    }
}
