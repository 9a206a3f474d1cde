//! A buffer of lines, and shapes made of lines.

use glam::{DVec3, Vec3};

use crate::geometry::{Aabb, Plane};

/// Lines that a buffer keeps at most. More would be a blot, and would take longer to draw than the scene.
pub const MOST_DEBUG_LINES: usize = 100_000;

/// A line in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DebugLine {
    /// Ends of the line, world space, metres. They are finite.
    pub ends: [Vec3; 2],
    /// Colour of the line, sRGB, 0 to 255.
    pub color: [u8; 3],
}

/// A buffer of lines in world space.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DebugLines {
    lines: Vec<DebugLine>,
    left_out: usize,
}

/// Segments of a circle.
const STEPS: usize = 48;

/// Share of a solid's size by which its corners may lie outside its planes, for rounding.
const SLACK: f64 = 1e-5;

impl DebugLines {
    /// Returns the lines.
    pub fn lines(&self) -> &[DebugLine] {
        &self.lines
    }

    /// Returns the number of lines that were left out because the buffer has [`MOST_DEBUG_LINES`].
    pub fn left_out(&self) -> usize {
        self.left_out
    }

    /// Removes all lines, and keeps the memory.
    pub fn clear(&mut self) {
        self.lines.clear();
        self.left_out = 0;
    }

    /// Adds a line, unless one of its ends is not finite.
    pub fn line(&mut self, color: [u8; 3], a: Vec3, b: Vec3) {
        if !(a.is_finite() && b.is_finite()) {
            return;
        }
        if self.lines.len() >= MOST_DEBUG_LINES {
            self.left_out += 1;
            return;
        }
        self.lines.push(DebugLine { ends: [a, b], color });
    }

    /// Adds the outline of a polygon.
    pub fn polygon(&mut self, color: [u8; 3], corners: &[Vec3]) {
        for (index, &corner) in corners.iter().enumerate() {
            self.line(color, corner, corners[(index + 1) % corners.len()]);
        }
    }

    /// Adds an ellipse, given by its centre and its two half axes.
    pub fn ellipse(&mut self, color: [u8; 3], center: Vec3, axes: [Vec3; 2]) {
        let corners: [Vec3; STEPS] = std::array::from_fn(|step| {
            let (sin, cos) = (step as f32 / STEPS as f32 * std::f32::consts::TAU).sin_cos();
            center + axes[0] * cos + axes[1] * sin
        });
        self.polygon(color, &corners);
    }

    /// Adds three circles about a centre, in the planes of three axes at right angles.
    pub fn sphere(&mut self, color: [u8; 3], center: Vec3, radius: f32, axes: [Vec3; 3]) {
        let [x, y, z] = axes.map(|axis| axis * radius);
        for pair in [[x, y], [y, z], [z, x]] {
            self.ellipse(color, center, pair);
        }
    }

    /// Adds the edges of a solid with eight corners. Bits 0, 1 and 2 of an index choose the end on three axes.
    pub fn hexahedron(&mut self, color: [u8; 3], corners: [Vec3; 8]) {
        for from in 0..8_usize {
            for axis in (0..3).filter(|axis| from >> axis & 1 == 0) {
                self.line(color, corners[from], corners[from | 1 << axis]);
            }
        }
    }

    /// Adds the edges of a box; none if the box is empty.
    pub fn aabb(&mut self, color: [u8; 3], aabb: &Aabb) {
        if !aabb.is_empty() {
            self.hexahedron(color, aabb.corners());
        }
    }

    /// Adds the edges of a convex solid within a box: the intersection of half-spaces. Edges that two sides of the box
    /// have alone are left out. O(planes³).
    pub fn convex(&mut self, color: [u8; 3], planes: &[Plane], within: &Aabb) {
        if within.is_empty() {
            return;
        }
        let origin = within.center().as_dvec3();
        let half = within.half_size().as_dvec3();
        let sides = DVec3::AXES
            .into_iter()
            .flat_map(|axis| [axis, -axis].map(|normal| (normal, half.dot(axis))));
        let own = planes.iter().map(|plane| {
            let normal = plane.normal.as_dvec3();
            (normal, normal.dot(origin) + f64::from(plane.offset))
        });
        let all: Vec<(DVec3, f64)> = own.chain(sides).collect();
        for first in 0..planes.len() {
            for second in first + 1..all.len() {
                if let Some(ends) = edge(&all, [first, second], half.length()) {
                    let [a, b] = ends.map(|end| (origin + end).as_vec3());
                    self.line(color, a, b);
                }
            }
        }
    }
}

/// Returns the edge of a convex solid between two of its planes `normal · p + offset ≥ 0`. `None` if the planes do not
/// meet on the solid. `size` is the radius of a sphere about the origin that holds the solid.
fn edge(planes: &[(DVec3, f64)], pair: [usize; 2], size: f64) -> Option<[DVec3; 2]> {
    let [(a, a_offset), (b, b_offset)] = pair.map(|plane| planes[plane]);
    let along = a.cross(b);
    let square = along.length_squared();
    if square < 1e-12 {
        return None; // parallel planes
    }
    let point = (a * b_offset - b * a_offset).cross(along) / square;
    let along = along / square.sqrt();
    let slack = SLACK * size;
    let (mut from, mut to) = (-2.0 * size, 2.0 * size);
    for (index, &(normal, offset)) in planes.iter().enumerate() {
        if pair.contains(&index) {
            continue;
        }
        let (height, slope) = (normal.dot(point) + offset + slack, normal.dot(along));
        if slope.abs() < 1e-9 {
            if height < 0.0 {
                return None;
            }
        } else if slope > 0.0 {
            from = from.max(-height / slope);
        } else {
            to = to.min(-height / slope);
        }
    }
    (to - from > 4.0 * slack).then(|| [from, to].map(|at| point + along * at))
}

#[cfg(test)]
mod tests {
    use super::*;

    const COLOR: [u8; 3] = [1, 2, 3];

    fn length(lines: &DebugLines) -> f32 {
        lines
            .lines()
            .iter()
            .map(|line| line.ends[0].distance(line.ends[1]))
            .sum()
    }

    #[test]
    fn a_convex_solid_has_its_edges() {
        let box_planes = |aabb: &Aabb| {
            let mut planes = Vec::new();
            for axis in Vec3::AXES {
                planes.extend(Plane::through(aabb.min, axis));
                planes.extend(Plane::through(aabb.max, -axis));
            }
            planes
        };
        let inner = Aabb::around(Vec3::new(1.0, 2.0, 3.0), Vec3::new(0.5, 1.0, 1.5));
        let outer = Aabb::around(Vec3::ZERO, Vec3::splat(10.0));
        let mut lines = DebugLines::default();
        lines.convex(COLOR, &box_planes(&inner), &outer);
        assert_eq!(lines.lines().len(), 12);
        assert!(
            (length(&lines) - 4.0 * (1.0 + 2.0 + 3.0)).abs() < 0.01,
            "{}",
            length(&lines)
        );
        // A half-space has the outline of the section with the box.
        lines.clear();
        lines.convex(COLOR, &box_planes(&inner)[..1], &outer);
        assert_eq!(lines.lines().len(), 4);
        assert!((length(&lines) - 80.0).abs() < 0.01, "{}", length(&lines));
        // Half-spaces without a common point have no edge.
        lines.clear();
        let apart = [
            Plane::through(Vec3::X, Vec3::X),
            Plane::through(-Vec3::X, -Vec3::X),
        ];
        let apart: Vec<Plane> = apart.into_iter().flatten().collect();
        lines.convex(COLOR, &apart, &outer);
        assert!(lines.lines().is_empty(), "{:?}", lines.lines());
    }

    #[test]
    fn boxes_have_twelve_edges_and_empty_ones_none() {
        let mut lines = DebugLines::default();
        lines.aabb(COLOR, &Aabb::around(Vec3::ZERO, Vec3::new(1.0, 2.0, 3.0)));
        assert_eq!((lines.lines().len(), length(&lines)), (12, 48.0));
        lines.clear();
        lines.aabb(COLOR, &Aabb::EMPTY);
        assert!(lines.lines().is_empty());
    }

    #[test]
    fn lines_that_are_not_finite_are_left_out() {
        let mut lines = DebugLines::default();
        lines.line(COLOR, Vec3::ZERO, Vec3::splat(f32::INFINITY));
        lines.line(COLOR, Vec3::NAN, Vec3::ZERO);
        lines.polygon(COLOR, &[]);
        assert_eq!((lines.lines().len(), lines.left_out()), (0, 0));
    }

    #[test]
    fn what_the_buffer_has_no_room_for_is_counted() {
        let mut lines = DebugLines::default();
        for _ in 0..MOST_DEBUG_LINES + 7 {
            lines.line(COLOR, Vec3::ZERO, Vec3::ONE);
        }
        assert_eq!((lines.lines().len(), lines.left_out()), (MOST_DEBUG_LINES, 7));
        lines.clear();
        assert_eq!((lines.lines().len(), lines.left_out()), (0, 0));
    }
}
