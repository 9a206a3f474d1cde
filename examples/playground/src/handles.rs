//! The handles that move and turn a light in the picture.
//!
//! They are our own: `transform-gizmo-egui` 0.9 is for another egui, its later versions are for a later Rust, and it
//! turns on a feature of `glam` that would compile the whole workspace a second time.

use glam::{Vec2, Vec3};

use crate::document::LightDoc;
use crate::orbit::Lens;

/// Length of the handles, pixels.
pub const LENGTH: f32 = 76.0;

/// Distance from a handle within which it is picked, pixels.
const REACH: f32 = 9.0;

/// A handle of the selected light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handle {
    /// Moves along X, Y or Z.
    Axis(usize),
    /// Moves in the plane of the picture.
    Plane,
    /// Turns the direction.
    Direction,
}

/// The axes of the world.
pub const AXES: [Vec3; 3] = [Vec3::X, Vec3::Y, Vec3::Z];

/// Where a light and its handles are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Where the light is shown, metres. A directional light is nowhere and is shown beside the scene.
    pub position: Vec3,
    /// Direction in which it shines, if it has one.
    pub direction: Option<Vec3>,
    /// Whether it can be moved.
    pub has_position: bool,
}

/// Returns the place of a light in a scene with these bounds.
pub fn place(light: &LightDoc, bounds: (Vec3, f32)) -> Place {
    let direction = light.vector("direction").and_then(Vec3::try_normalize);
    match light.vector("position") {
        Some(position) => Place {
            position,
            direction,
            has_position: true,
        },
        None => Place {
            position: bounds.0 - direction.unwrap_or(Vec3::NEG_Y) * bounds.1 * 0.7,
            direction,
            has_position: false,
        },
    }
}

impl Place {
    /// Length of the handles at the light, metres.
    pub fn length(&self, lens: &Lens) -> f32 {
        LENGTH * lens.metres_per_pixel(self.position)
    }

    /// Returns the pixel of the end of a handle.
    pub fn end(&self, handle: Handle, lens: &Lens) -> Option<Vec2> {
        let length = self.length(lens);
        match handle {
            Handle::Axis(axis) => lens.pixel(self.position + AXES[axis] * length),
            Handle::Plane => lens.pixel(self.position),
            Handle::Direction => lens.pixel(self.position + self.direction? * length * 1.35),
        }
    }

    /// The handles that the light has.
    pub fn handles(&self) -> impl Iterator<Item = Handle> {
        let moves = [Handle::Plane, Handle::Axis(0), Handle::Axis(1), Handle::Axis(2)];
        let moves = moves.into_iter().filter(|_| self.has_position);
        let turns = self.direction.map(|_| Handle::Direction);
        turns.into_iter().chain(moves)
    }

    /// Returns the handle at a pixel.
    pub fn pick(&self, pixel: Vec2, lens: &Lens) -> Option<Handle> {
        let start = lens.pixel(self.position)?;
        let distance = |handle: Handle| -> Option<f32> {
            let end = self.end(handle, lens)?;
            Some(match handle {
                Handle::Axis(_) => to_segment(pixel, start, end),
                Handle::Plane | Handle::Direction => pixel.distance(end) - 4.0,
            })
        };
        let near = self
            .handles()
            .filter_map(|handle| Some((handle, distance(handle)?)));
        near.filter(|(_, distance)| *distance < REACH)
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(handle, _)| handle)
    }

    /// Returns the place after a handle was dragged from one pixel to another.
    pub fn dragged(&self, handle: Handle, from: Vec2, to: Vec2, lens: &Lens) -> Self {
        let mut place = *self;
        match handle {
            Handle::Axis(axis) => {
                let along = |pixel: Vec2| along_line(self.position, AXES[axis], lens.ray(pixel));
                if let (Some(from), Some(to)) = (along(from), along(to)) {
                    place.position += AXES[axis] * (to - from);
                }
            }
            Handle::Plane => {
                let on = |pixel: Vec2| on_plane(self.position, lens.forward(), lens.ray(pixel));
                if let (Some(from), Some(to)) = (on(from), on(to)) {
                    place.position += to - from;
                }
            }
            Handle::Direction => {
                let Some(direction) = self.direction else {
                    return place;
                };
                let end = self.position + direction * self.length(lens) * 1.35;
                let on = |pixel: Vec2| on_plane(end, lens.forward(), lens.ray(pixel));
                if let (Some(from), Some(to)) = (on(from), on(to)) {
                    place.direction = (end + to - from - self.position)
                        .try_normalize()
                        .or(place.direction);
                }
            }
        }
        if place.position.is_finite() { place } else { *self }
    }
}

fn to_segment(point: Vec2, a: Vec2, b: Vec2) -> f32 {
    let along = b - a;
    let share = (point - a).dot(along) / along.length_squared().max(1e-6);
    // The part near the light belongs to the handle of the plane.
    point.distance(a + along * share.clamp(0.2, 1.0))
}

/// Returns where a line is nearest to a ray, metres along the line.
fn along_line(start: Vec3, axis: Vec3, (origin, direction): (Vec3, Vec3)) -> Option<f32> {
    let dot = axis.dot(direction);
    let scale = 1.0 - dot * dot;
    if scale < 1e-4 {
        return None; // the line is seen from its end
    }
    let offset = origin - start;
    Some((offset.dot(axis) - offset.dot(direction) * dot) / scale)
}

fn on_plane(point: Vec3, normal: Vec3, (origin, direction): (Vec3, Vec3)) -> Option<Vec3> {
    let facing = direction.dot(normal);
    if facing.abs() < 1e-4 {
        return None;
    }
    Some(origin + direction * ((point - origin).dot(normal) / facing))
}

#[cfg(test)]
mod tests {
    use antumbra::prelude::*;
    use glam::UVec2;

    use super::*;
    use crate::document::Eye;

    fn lens() -> Lens {
        let eye = Eye {
            eye: Vec3::new(0.0, 1.0, 6.0),
            target: Vec3::new(0.0, 1.0, 0.0),
            up: Vec3::Y,
            camera: Camera::default(),
        };
        eye.lens(UVec2::new(400, 300))
    }

    #[test]
    fn a_dragged_handle_follows_the_pointer() {
        let lens = lens();
        let place = Place {
            position: Vec3::new(0.3, 1.2, 0.5),
            direction: Some(Vec3::NEG_Y),
            has_position: true,
        };
        for handle in place.handles().collect::<Vec<_>>() {
            if handle == Handle::Axis(2) {
                continue; // towards the viewer
            }
            let from = place.end(handle, &lens).unwrap();
            assert_eq!(place.pick(from, &lens), Some(handle));
            let along = if handle == Handle::Axis(1) {
                Vec2::Y
            } else {
                Vec2::X
            };
            let to = from + along * 20.0;
            let dragged = place.dragged(handle, from, to, &lens);
            if handle != Handle::Direction {
                let end = dragged.end(handle, &lens).unwrap();
                assert!(end.distance(to) < 0.6, "{handle:?}: {end} is not {to}");
            } else {
                assert!(dragged.direction.unwrap().x > 0.05);
            }
        }
        assert_eq!(place.pick(Vec2::ZERO, &lens), None);
    }
}
