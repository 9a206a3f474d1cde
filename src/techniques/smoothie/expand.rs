//! The vertices of smoothies: twin of the vertex stage of `shaders/techniques/smoothie/edge.wgsl`.
//!
//! A smoothie edge is a rectangle at right angles to the light's rays, from the silhouette edge outwards. The corner
//! at its end is a sector of a disc between the rectangle and that of the next edge, if the silhouette turns outwards
//! there. Elsewhere the rectangles overlap. Rectangles and sectors stand in space and not in one face, so they
//! continue from face to face of a cube, and the hardware clips them at the light's plane.

use glam::{Vec2, Vec3, Vec4};

use super::records::{DISC_ALONE, SECTOR, SmoothieEdge, SmoothieFace};

/// Number of triangles of a corner. Each spans at most 60°, of a whole disc.
pub const CORNER_TRIANGLES: u32 = 6;

/// Number of vertices of an edge with its corner.
pub const VERTICES: u32 = 6 + 3 * CORNER_TRIANGLES;

/// Radians by which a sector overlaps the edges beside it. No pixel centre falls between them.
pub const OVERLAP: f32 = 0.05;

/// Turn to the right in radians beyond which a silhouette turns back on itself, so that rounding decides the sign.
pub const HALF_TURN: f32 = 3.1;

/// Texels by which an edge reaches inside the caster. No pixel centre falls between the edge and the caster.
pub const INSIDE_TEXELS: f32 = 1.5;

/// One vertex of a smoothie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SmoothieVertex {
    /// Clip space of the face. The depth is not used.
    pub position_clip: Vec4,
    /// Offset from the silhouette, metres; alpha is its length over the width.
    pub offset: Vec2,
    /// Width of the smoothie, metres.
    pub width: f32,
    /// Distance from the light along the face's axis, metres.
    pub along: f32,
}

fn away(face: &SmoothieFace, position: Vec3) -> Vec3 {
    if face.is_parallel() {
        Vec4::from(face.row_z).truncate()
    } else {
        position.normalize()
    }
}

/// Returns the unit vector out of the caster, at right angles to an edge and to the rays that meet it.
pub fn outward(face: &SmoothieFace, start: Vec3, end: Vec3) -> Vec3 {
    let ray = if face.is_parallel() {
        Vec4::from(face.row_z).truncate()
    } else {
        start
    };
    ray.cross(end - start).normalize()
}

fn across(direction: Vec3) -> Vec3 {
    let axis = if direction.x.abs() > 0.7 { Vec3::Y } else { Vec3::X };
    direction.cross(axis).normalize()
}

fn place(face: &SmoothieFace, position: Vec3, offset: Vec2, width: f32) -> SmoothieVertex {
    let [x, y, z] = [face.row_x, face.row_y, face.row_z].map(|row| Vec4::from(row).dot(position.extend(1.0)));
    let [half, near, ..] = face.projection;
    let position_clip = if face.is_parallel() {
        Vec4::new(x / half, y / half, 0.5, 1.0)
    } else {
        Vec4::new(x / half, y / half, near, z)
    };
    SmoothieVertex {
        position_clip,
        offset,
        width,
        along: z,
    }
}

fn of_edge(edge: &SmoothieEdge, face: &SmoothieFace, vertex: u32) -> SmoothieVertex {
    let (start, end) = (Vec3::from(edge.start), Vec3::from(edge.end));
    let (position, width) = if matches!(vertex, 1 | 2 | 4) {
        (end, edge.width_end)
    } else {
        (start, edge.width_start)
    };
    let distance = if face.is_parallel() {
        1.0
    } else {
        position.length()
    };
    let offset = if matches!(vertex, 2 | 4 | 5) {
        width
    } else {
        -INSIDE_TEXELS * face.projection[2] * distance
    };
    place(
        face,
        position + outward(face, start, end) * offset,
        Vec2::X * offset,
        width,
    )
}

fn of_corner(edge: &SmoothieEdge, face: &SmoothieFace, vertex: u32) -> SmoothieVertex {
    let end = Vec3::from(edge.end);
    let center = place(face, end, Vec2::ZERO, edge.width_end);
    let direction = away(face, end);
    let normal = if edge.kind == DISC_ALONE {
        across(direction)
    } else {
        outward(face, edge.start.into(), end)
    };
    let tangent = normal.cross(direction);
    let (mut first, mut last) = (0.0, std::f32::consts::TAU);
    if edge.kind == SECTOR {
        let next = outward(face, end, edge.next.into());
        let mut turn = next.dot(tangent).atan2(next.dot(normal));
        if turn < -HALF_TURN {
            turn = std::f32::consts::PI;
        }
        if turn <= 0.0 {
            return center;
        }
        (first, last) = (-OVERLAP, turn + OVERLAP);
    }
    if vertex.is_multiple_of(3) {
        return center;
    }
    let step = (last - first) / CORNER_TRIANGLES as f32;
    let angle = first + step * (vertex / 3 + vertex % 3 - 1) as f32;
    let offset = Vec2::from_angle(angle) * (edge.width_end / (0.5 * step).cos());
    place(
        face,
        end + normal * offset.x + tangent * offset.y,
        offset,
        edge.width_end,
    )
}

/// Returns one of the [`VERTICES`] vertices of an edge with its corner, three for each triangle.
pub fn smoothie_vertex(edge: &SmoothieEdge, face: &SmoothieFace, vertex: u32) -> SmoothieVertex {
    if vertex >= 6 {
        of_corner(edge, face, vertex - 6)
    } else if edge.kind == DISC_ALONE {
        place(face, edge.end.into(), Vec2::ZERO, edge.width_end)
    } else {
        of_edge(edge, face, vertex)
    }
}
