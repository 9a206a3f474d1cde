//! Patches of a caster: connected triangles of one [layer](super::silhouette_layers) that face the same way.
//!
//! Section 5.1 combines the coverage of silhouette loops. A loop alone has no shadow that could be counted
//! away from the viewer; that takes a surface bounded by the loop. The patches are these surfaces. Most have
//! one loop; the further loops of a patch are its holes, whose coverage is negative. A hole must be added to
//! its rim before anything is combined; it means nothing alone.

use glam::Vec3;

use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::EdgeMesh;
use crate::silhouettes::FacingBits;

/// The patch of every triangle. Buffers are reused.
#[derive(Clone, Debug, Default)]
pub struct Patches {
    /// By slot: while [`Patches::find`] runs, a forest; afterwards, the number of the patch.
    of_slot: Vec<u32>,
    count: u32,
}

impl Patches {
    /// Returns the number of patches.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Returns the patch of the triangle in a slot.
    pub fn of_slot(&self, slot: usize) -> u32 {
        self.of_slot[slot]
    }

    /// Finds the patches. `layers_of` returns the layers of a slot, 0 for triangles that are not part of the
    /// shadow.
    ///
    /// Numbers ascend with the lowest slot. Cost: all edges.
    pub fn find(&mut self, mesh: &EdgeMesh, facing: &FacingBits, layers_of: impl Fn(usize) -> u32) {
        let slots = mesh.clusters().len() * CLUSTER_TRIANGLES;
        self.of_slot.clear();
        self.of_slot.extend(0..slots as u32);
        let parents = &mut self.of_slot;
        let mut join = |a: usize, b: usize| {
            let layers = layers_of(a);
            if layers != 0 && layers == layers_of(b) && facing.is_facing(a) == facing.is_facing(b) {
                let (a, b) = (root(parents, a as u32), root(parents, b as u32));
                parents[a.max(b) as usize] = a.min(b);
            }
        };
        for (index, cluster) in mesh.clusters().iter().enumerate() {
            let first = index * CLUSTER_TRIANGLES;
            for edge in &mesh.inner_edges()[cluster.inner()] {
                join(first + edge.side.lane(), first + usize::from(edge.other_lane));
            }
            let sides = mesh.seam_sides()[cluster.seams()].iter();
            for (side, &slot) in sides.zip(&mesh.seam_slots()[cluster.seams()]) {
                join(first + side.lane(), slot as usize);
            }
        }
        for edge in 0..mesh.irregular_vertices().len() {
            let sides = mesh.irregular_sides(edge);
            for (i, a) in sides.iter().enumerate() {
                for b in &sides[i + 1..] {
                    join(a.slot() as usize, b.slot() as usize);
                }
            }
        }
        // A root is the lowest slot of its patch, so its number is known before it is needed.
        self.count = 0;
        for slot in 0..slots {
            let parent = self.of_slot[slot] as usize;
            if parent == slot {
                self.of_slot[slot] = if layers_of(slot) == 0 {
                    u32::MAX
                } else {
                    self.count
                };
                self.count += u32::from(layers_of(slot) != 0);
            } else {
                self.of_slot[slot] = self.of_slot[parent];
            }
        }
    }
}

fn root(parents: &mut [u32], mut slot: u32) -> u32 {
    while parents[slot as usize] != slot {
        let grandparent = parents[parents[slot as usize] as usize];
        parents[slot as usize] = grandparent;
        slot = grandparent;
    }
    slot
}

/// The directions from a light's centre in which a shadow with its penumbra lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShadowCone {
    /// Unit vector, light space; any vector if the cone has all directions.
    pub axis: Vec3,
    /// Half angle, radians.
    pub angle: f32,
}

impl ShadowCone {
    /// The cone of all directions.
    pub const ALL: Self = Self {
        axis: Vec3::Y,
        angle: std::f32::consts::PI,
    };

    /// Returns a cone around the edges between `points` for a light within `radius` of the origin. A point
    /// that sees the light past a point at distance `d` lies within `asin(radius / d)` of that point's
    /// direction.
    pub fn around(points: impl Iterator<Item = Vec3> + Clone, radius: f32) -> Self {
        let axis: Vec3 = points.clone().map(Vec3::normalize_or_zero).sum();
        let Some(axis) = axis.try_normalize() else {
            return Self::ALL;
        };
        let angle = points.fold(0.0f32, |angle, point| {
            let distance = point.length();
            if distance > radius {
                angle.max(axis.angle_between(point) + (radius / distance).asin())
            } else {
                std::f32::consts::PI
            }
        });
        Self { axis, angle }
    }

    /// Orders cones by angle, the widest first, and then by axis.
    fn compare(&self, other: &Self) -> std::cmp::Ordering {
        let axes = self.axis.to_array().into_iter().zip(other.axis.to_array());
        let by_axis = axes.map(|(a, b)| a.total_cmp(&b));
        other
            .angle
            .total_cmp(&self.angle)
            .then(by_axis.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then))
    }

    /// Returns the cone of all directions for shadows of edges between `points`. Its axis is the mean of the points.
    pub fn everywhere(points: impl Iterator<Item = Vec3>) -> Self {
        let (sum, count) = points.fold((Vec3::ZERO, 0u32), |(sum, count), point| (sum + point, count + 1));
        Self {
            axis: sum / count.max(1) as f32,
            ..Self::ALL
        }
    }

    /// Whether two shadows may meet.
    pub fn meets(&self, other: &Self) -> bool {
        let everywhere = std::f32::consts::PI;
        self.angle >= everywhere
            || other.angle >= everywhere
            || self.axis.angle_between(other.axis) <= self.angle + other.angle
    }
}

/// Largest number of sums of one part of a light. Patches that meet have different sums up to this number;
/// beyond it, a patch joins the sum in which it meets the fewest others.
pub const MAX_SUMS: usize = 16;

/// Gives every shadow a sum such that shadows of one sum do not meet, as far as [`MAX_SUMS`] allows. Returns
/// the number of sums. Greedy, O(n²).
///
/// Shadows are considered by width and direction, so sums do not depend on the order in which casters were made. `order`
/// is scratch space.
pub fn share_sums(cones: &[ShadowCone], order: &mut Vec<u32>, sums: &mut Vec<u32>) -> u32 {
    order.clear();
    order.extend(0..cones.len() as u32);
    order.sort_unstable_by(|&a, &b| cones[a as usize].compare(&cones[b as usize]).then(a.cmp(&b)));
    sums.clear();
    sums.resize(cones.len(), 0);
    for (at, &index) in order.iter().enumerate() {
        let cone = &cones[index as usize];
        let mut met = [0u32; MAX_SUMS];
        for &other in &order[..at] {
            met[sums[other as usize] as usize] += u32::from(cones[other as usize].meets(cone));
        }
        let best = (0..MAX_SUMS).min_by_key(|&sum| met[sum]).unwrap_or(0);
        sums[index as usize] = best as u32;
    }
    sums.iter().max().map_or(0, |last| last + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cone(degrees: f32, angle: f32) -> ShadowCone {
        let (sin, cos) = degrees.to_radians().sin_cos();
        ShadowCone {
            axis: Vec3::new(sin, cos, 0.0),
            angle: angle.to_radians(),
        }
    }

    #[test]
    fn shadows_that_meet_have_sums_of_their_own() {
        let cones = [cone(0.0, 5.0), cone(20.0, 5.0), cone(8.0, 5.0), cone(10.0, 40.0)];
        let (mut order, mut sums) = (Vec::new(), Vec::new());
        assert_eq!(share_sums(&cones, &mut order, &mut sums), 3);
        // The widest comes first, then those of 0 and 8 degrees, which meet.
        assert_eq!(sums, [1, 1, 2, 0]);
    }

    #[test]
    fn more_than_there_are_sums_share_them() {
        let cones = vec![cone(0.0, 10.0); MAX_SUMS + 3];
        let (mut order, mut sums) = (Vec::new(), Vec::new());
        assert_eq!(share_sums(&cones, &mut order, &mut sums), MAX_SUMS as u32);
        assert_eq!(sums[MAX_SUMS..], [0, 1, 2]);
    }

    #[test]
    fn sums_do_not_depend_on_the_order_of_casters() {
        let cones: Vec<_> = (0..40)
            .map(|i| cone(3.0 * i as f32, 20.0 + (i * 7 % 5) as f32))
            .collect();
        let (mut order, mut sums) = (Vec::new(), Vec::new());
        assert_eq!(share_sums(&cones, &mut order, &mut sums), MAX_SUMS as u32);
        let turned: Vec<_> = cones.iter().rev().copied().collect();
        let mut turned_sums = Vec::new();
        share_sums(&turned, &mut order, &mut turned_sums);
        turned_sums.reverse();
        assert_eq!(sums, turned_sums);
    }

    #[test]
    fn a_cone_holds_its_points_and_their_penumbra() {
        let points = [Vec3::new(0.0, -2.0, 0.0), Vec3::new(1.0, -2.0, 0.0)];
        let narrow = ShadowCone::around(points.into_iter(), 0.0);
        let wide = ShadowCone::around(points.into_iter(), 0.5);
        assert!((narrow.angle - 0.5 * 0.5f32.atan()).abs() < 1e-5);
        assert!((wide.angle - narrow.angle - 0.25f32.asin()).abs() < 1e-5);
        assert_eq!(
            ShadowCone::around(points.into_iter(), 3.0).angle,
            std::f32::consts::PI
        );
    }
}
