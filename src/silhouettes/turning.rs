//! One bit per triangle: whether its plane cuts the light, so that part of the light is in front of it and
//! part behind.
//!
//! Only the edges of such triangles can be silhouette edges from one point of the light and not from another.
//! Together with the silhouette edges from the centre they are the potential silhouette edges of Laine, Aila,
//! Assarsson, Lehtinen & Akenine-Möller 2005, "Soft Shadow Volumes for Ray Tracing", section 3.

use glam::{Vec3, Vec4};

use super::planes::{Certainty, FacingPlanes};
use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::EdgeMesh;

/// The extent of a light around its centre, in the caster's space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightExtent {
    /// A parallelogram, given by half of each of its two sides.
    Sides([Vec3; 2]),
    /// An ellipsoid, which is a sphere in the world, given by its half axes at any angle to one another.
    Ellipsoid([Vec3; 3]),
}

impl LightExtent {
    /// Largest distance from the centre along a direction.
    fn along(&self, normal: Vec3) -> f32 {
        match self {
            Self::Sides(sides) => sides.iter().map(|side| normal.dot(*side).abs()).sum(),
            Self::Ellipsoid(axes) => Vec3::from(axes.map(|axis| normal.dot(axis))).length(),
        }
    }

    /// Upper bound of the largest distance from the centre.
    fn radius(&self) -> f32 {
        match self {
            Self::Sides(sides) => sides.iter().map(|side| side.length()).sum(),
            Self::Ellipsoid(axes) => axes.iter().map(|axis| axis.length_squared()).sum::<f32>().sqrt(),
        }
    }
}

/// Decides for each triangle whether its plane cuts a light around the position `light_local`. There is one
/// word per cluster, as in [`FacingBits`](super::FacingBits).
///
/// The bit of a triangle without area is 0. If `planes` are not those of `mesh`, there are no words.
///
/// Cost: each cluster's bounds, and the triangles of clusters whose bounds do not decide.
pub fn find_turning(
    mesh: &EdgeMesh,
    planes: &FacingPlanes,
    light_local: Vec3,
    extent: &LightExtent,
    words: &mut Vec<u64>,
) {
    /// A plane that only touches the light, up to rounding, does not cut it.
    const SHRINK: f32 = 0.999;
    words.clear();
    if planes.blocks.len() != mesh.clusters().len() {
        return;
    }
    let radius = extent.radius();
    for (index, (cluster, block)) in mesh.clusters().iter().zip(&planes.blocks).enumerate() {
        let is_open = planes.bounds.get(index).is_none_or(|bounds| {
            bounds.certainty_around(light_local.extend(1.0), radius) == Certainty::Unknown
        });
        let mut word = 0;
        if is_open {
            for lane in 0..CLUSTER_TRIANGLES.min(cluster.triangle_count as usize) {
                let normal = Vec3::new(block.x[lane], block.y[lane], block.z[lane]);
                let value = Vec4::from((normal, block.offset[lane])).dot(light_local.extend(1.0));
                word |= u64::from(value.abs() < extent.along(normal) * SHRINK) << lane;
            }
        }
        words.push(word);
    }
}
