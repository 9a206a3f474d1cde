//! Triangles that cut the light: parts of the light lie on both sides of them.
//!
//! Seen from such a triangle, the light is not on one side of a silhouette. The part of the triangle that lies behind the
//! light hides nothing, and it ends at a line across the light that is no edge of the mesh. So cutting triangles have
//! neither silhouette edges nor hard shadow. Each has a record of its own, which is drawn over the whole picture. At
//! each pixel the shader clips the triangle to what is before the light, and subtracts the share of the light behind it.
//! What remains is the part of the light that lies outside of the surface.
//!
//! A triangle whose plane contains the light's centre has no side from which the centre sees it, so it is treated the
//! same way at any distance. Otherwise rounding would decide what it hides from surfaces in its own plane.
//!
//! Triangles nearer to a point of light than [`LightClearance`](crate::sets::LightClearance) block nothing: those
//! that lie in the plane of a rectangle. What lies behind a rectangle blocks nothing either.

use glam::{DMat4, DVec3, DVec4, Vec3};
use smallvec::SmallVec;

use super::records::{CUT, SOFT, SOFT_LAYERS_SHIFT, Wedge};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::convex_polygon::clip;
use crate::geometry::distance_to_triangle;
use crate::geometry::edge_mesh::EdgeMesh;
use crate::techniques::penumbra_wedge::light_parts::PartShape;

/// The greatest number of triangles of one caster that cut one part of a light and are drawn. Each is drawn over all
/// pixels of the light. Of further ones, those farthest from the light's centre are left out, so the light shines
/// through them.
pub const MOST_CUTS: usize = 64;

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

/// Sorts out the triangles of `words` that act as [usual](Effect::Usual), and lists those that cut: the slot and the
/// distance from the centre. Of more than [`MOST_CUTS`], the nearest are kept. Returns the number of those that were left
/// out.
pub fn find_cuts(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    light_from_local: &DMat4,
    (shape, clearance): (PartShape, f64),
    words: &mut [u64],
    cuts: &mut Vec<(u32, f64)>,
) -> u32 {
    cuts.clear();
    for (index, (cluster, word)) in mesh.clusters().iter().zip(words.iter_mut()).enumerate() {
        let corners = &mesh.corners()[cluster.triangles()];
        let marked = *word;
        for lane in (0..corners.len()).filter(|lane| marked >> lane & 1 != 0) {
            let corners = in_light(corners[lane], positions, light_from_local);
            match effect_of(corners, shape, clearance) {
                Effect::Usual => *word &= !(1 << lane),
                Effect::Nothing => {}
                Effect::Cuts => {
                    let distance = distance_to_triangle(DVec3::ZERO, corners);
                    cuts.push(((index * CLUSTER_TRIANGLES + lane) as u32, distance));
                }
            }
        }
    }
    let left_out = cuts.len().saturating_sub(MOST_CUTS);
    if left_out > 0 {
        cuts.sort_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        cuts.truncate(MOST_CUTS);
    }
    left_out as u32
}

/// Returns the corners of a triangle in light space.
pub fn in_light(corners: [u32; 3], positions: &[Vec3], light_from_local: &DMat4) -> [DVec3; 3] {
    corners.map(|vertex| light_from_local.transform_point3(positions[vertex as usize].as_dvec3()))
}

/// Makes the record of a triangle that cuts the light. `plane` is the triangle's, in light space.
pub fn cut_record(corners: [DVec3; 3], plane: [f32; 4]) -> Wedge {
    let [start, end, third] = corners.map(|corner| corner.as_vec3());
    let mut record = Wedge {
        start_light: start.to_array(),
        end_light: end.to_array(),
        flags: SOFT | CUT | 3 << SOFT_LAYERS_SHIFT,
        sides: [plane, [0.0; 4]],
        ..Wedge::default()
    };
    record.rims[0] = third.extend(0.0).to_array();
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
