//! Triangles that cut the light: parts of the light lie on both sides of them.
//!
//! Seen from such a triangle, the light is not on one side of a silhouette. The part of the triangle that lies behind the
//! light hides nothing, and it ends at a line across the light that is no edge of the mesh. So cutting triangles have
//! neither silhouette edges nor hard shadow. A few polygons stand for all of them ([`cut_patches`](super::cut_patches)).
//! Each has a record of its own, which is drawn over the whole picture. At each pixel the shader clips the polygon to what
//! is before the light, and subtracts the share of the light behind it. What remains is the part of the light that lies
//! outside of the surface.
//!
//! A triangle whose plane contains the light's centre has no side from which the centre sees it, so it has no hard shadow at
//! any distance. Otherwise rounding would decide what it hides from surfaces in its own plane.
//!
//! Triangles nearer to a point of light than [`LightClearance`](crate::sets::LightClearance) block nothing: those
//! that lie in the plane of a rectangle. What lies behind a rectangle blocks nothing either.

use glam::{DMat4, DVec3, DVec4, Vec3};
use smallvec::SmallVec;

use super::cut_pieces::{CutPolygon, CutTriangle, Patch};
use super::records::{CUT, SOFT, SOFT_LAYERS_SHIFT, Wedge};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::convex_polygon::clip;
use crate::geometry::distance_to_triangle;
use crate::geometry::edge_mesh::EdgeMesh;
use crate::techniques::penumbra_wedge::light_parts::PartShape;

/// The number of polygons of one caster and one part of a light above which the surface that cuts is drawn more coarsely.
pub const ENOUGH_CUTS: usize = 128;

/// The greatest number of polygons with which one caster cuts one part of a light. Each is drawn over all pixels of the
/// light. Where the coarsest surface needs more, those farthest from the light's centre are left out, so the light shines
/// through them.
pub const MOST_CUTS: usize = 256;

/// Factor on a sphere's radius within which triangles count as cutting it, against rounding.
const SPHERE_MARGIN: f64 = 1.005;

/// Returns the distance from the part's centre within which triangles may cut the part, or block nothing; metres.
/// `clearance` is the distance within which surfaces do not block light.
pub fn cutting_distance(shape: PartShape, clearance: f64) -> f64 {
    match shape {
        PartShape::Point => clearance,
        PartShape::Rect { half } => clearance.max(half.length() * SPHERE_MARGIN),
        PartShape::Sphere { radius } => clearance.max(radius * SPHERE_MARGIN),
    }
}

/// Returns whether triangles can cut a part. One within the clearance counts as a point.
pub fn can_be_cut(shape: PartShape, clearance: f64) -> bool {
    shape.radius() > clearance
}

/// The effect of a triangle near a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// It hides light like any other.
    Usual,
    /// It hides nothing.
    Nothing,
    /// It cuts the light.
    Cuts,
}

/// Returns the effect of a triangle that lies within the [`cutting_distance`] of a part that can be cut, or whose plane
/// contains the part's centre. Corners are in light space.
pub fn effect_of(corners: [DVec3; 3], shape: PartShape, clearance: f64) -> Effect {
    let PartShape::Rect { half } = shape else {
        return Effect::Cuts;
    };
    let lowest = corners
        .iter()
        .map(|corner| corner.z)
        .fold(f64::INFINITY, f64::min);
    if lowest >= -clearance {
        return Effect::Nothing; // behind the rectangle, or in its plane
    }
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let offset = -normal.dot(a);
    // The greatest distance of the plane from the rectangle, along z.
    let tilt = offset.abs() + normal.x.abs() * half.x + normal.y.abs() * half.y;
    if tilt <= normal.z.abs() * clearance {
        return Effect::Nothing;
    }
    if offset.abs() <= 1e-9 * normal.length() * half.max_element() {
        return Effect::Cuts;
    }
    // What is left of it within the column over the rectangle and behind the rectangle's plane.
    let sides = [
        DVec4::new(1.0, 0.0, 0.0, half.x),
        DVec4::new(-1.0, 0.0, 0.0, half.x),
        DVec4::new(0.0, 1.0, 0.0, half.y),
        DVec4::new(0.0, -1.0, 0.0, half.y),
    ];
    let mut rest: SmallVec<[DVec3; 8]> = corners.into_iter().collect();
    for side in sides {
        rest = clip(&rest, |point: DVec3| side.truncate().dot(point) + side.w);
    }
    if rest.iter().any(|point| point.z > -clearance) {
        Effect::Cuts
    } else {
        Effect::Usual
    }
}

/// Returns the extent of a part of which the tolerances of cutting surfaces are a share, metres.
pub fn tolerance_extent(shape: PartShape) -> f64 {
    match shape {
        PartShape::Point => 0.0,
        PartShape::Sphere { radius } => radius,
        PartShape::Rect { half } => half.min_element().max(0.1 * half.max_element()),
    }
}

/// Sorts out the triangles of `words` that act as [usual](Effect::Usual), and lists those that cut.
pub fn find_cuts(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    light_from_local: &DMat4,
    (shape, clearance): (PartShape, f64),
    words: &mut [u64],
    cuts: &mut Vec<CutTriangle>,
) {
    for (index, (cluster, word)) in mesh.clusters().iter().zip(words.iter_mut()).enumerate() {
        let triangles = &mesh.corners()[cluster.triangles()];
        let marked = *word;
        for lane in (0..triangles.len()).filter(|lane| marked >> lane & 1 != 0) {
            let vertices = triangles[lane];
            let corners = in_light(vertices, positions, light_from_local);
            match effect_of(corners, shape, clearance) {
                Effect::Usual => *word &= !(1 << lane),
                Effect::Nothing => {}
                Effect::Cuts => cuts.push(CutTriangle {
                    slot: (index * CLUSTER_TRIANGLES + lane) as u32,
                    vertices,
                    corners,
                    distance: distance_to_triangle(DVec3::ZERO, corners),
                }),
            }
        }
    }
}

/// Returns the corners of a triangle in light space.
fn in_light(corners: [u32; 3], positions: &[Vec3], light_from_local: &DMat4) -> [DVec3; 3] {
    corners.map(|vertex| light_from_local.transform_point3(positions[vertex as usize].as_dvec3()))
}

/// Makes the record of a polygon that cuts the light. `front` is a vector on the side of the front of the mesh, light
/// space. `clearance` is the distance from the light within which surfaces block nothing, metres; a patch that is curved
/// by more than that has none, so that its polygons agree at their common edges. The polygon turns counter-clockwise about
/// the plane of the record, whose normal is on that side.
pub fn cut_record(polygon: &CutPolygon, patch: &Patch, front: Vec3, clearance: f64) -> Wedge {
    let mut corners = polygon.corners.map(|corner| corner.as_vec3());
    let mut plane = patch.normal.extend(patch.offset).as_vec4();
    if plane.truncate().dot(front) < 0.0 {
        corners.reverse(); // the caster mirrors
        plane = -plane;
    }
    let [start, end, third, fourth] = corners;
    let mut record = Wedge {
        start_light: start.to_array(),
        end_light: end.to_array(),
        flags: SOFT | CUT | 3 << SOFT_LAYERS_SHIFT,
        sides: [
            plane.to_array(),
            [
                patch.tolerance as f32,
                (clearance - patch.tolerance).max(0.0) as f32,
                0.0,
                0.0,
            ],
        ],
        ..Wedge::default()
    };
    record.rims[0] = third.extend(0.0).to_array();
    record.rims[1] = fourth.extend(0.0).to_array();
    record
}

#[cfg(test)]
mod tests {
    use glam::DVec2;

    use super::*;

    const RECT: PartShape = PartShape::Rect {
        half: DVec2::new(0.5, 0.2),
    };

    fn effect(corners: [[f64; 3]; 3]) -> Effect {
        effect_of(corners.map(DVec3::from_array), RECT, 1e-4)
    }

    #[test]
    fn a_rectangle_is_cut_by_what_crosses_it() {
        // A wall across it.
        assert_eq!(
            effect([[0.1, -1.0, -1.0], [0.1, 1.0, -1.0], [0.1, 0.0, 1.0]]),
            Effect::Cuts
        );
        // A wall beside it, which crosses its plane.
        assert_eq!(
            effect([[0.6, -1.0, -1.0], [0.6, 1.0, -1.0], [0.6, 0.0, 1.0]]),
            Effect::Usual
        );
        // A board before it.
        assert_eq!(
            effect([[-0.1, -0.1, -0.1], [0.1, -0.1, -0.1], [0.0, 0.1, -0.1]]),
            Effect::Usual
        );
        // What lies behind it, and the ceiling in which it is.
        assert_eq!(
            effect([[-1.0, -1.0, 0.3], [1.0, -1.0, 0.3], [0.0, 1.0, 0.1]]),
            Effect::Nothing
        );
        assert_eq!(
            effect([[-9.0, -9.0, -1e-5], [9.0, -9.0, 1e-5], [0.0, 9.0, 0.0]]),
            Effect::Nothing
        );
    }

    #[test]
    fn spheres_are_cut_by_all_that_is_near() {
        let sphere = PartShape::Sphere { radius: 0.5 };
        let corners = [[0.1, -1.0, -1.0], [0.1, 1.0, -1.0], [0.1, 0.0, 1.0]].map(DVec3::from_array);
        assert_eq!(effect_of(corners, sphere, 1e-4), Effect::Cuts);
        assert!(can_be_cut(sphere, 1e-4) && !can_be_cut(sphere, 0.6));
        assert!(!can_be_cut(PartShape::Point, 0.0));
    }
}
