//! The plane of every triangle, and bounds of the planes of each cluster.

use glam::{DVec3, Vec3, Vec4};

use crate::conventions::CLUSTER_TRIANGLES;
use crate::geometry::edge_mesh::{Cluster, EdgeMesh};

/// The planes of one cluster: `x·p.x + y·p.y + z·p.z + offset` is positive on a triangle's front.
///
/// Normals have unit length. A triangle without area and the padding of a short cluster have zeros, so they
/// never face the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PlaneBlock {
    pub x: [f32; CLUSTER_TRIANGLES],
    pub y: [f32; CLUSTER_TRIANGLES],
    pub z: [f32; CLUSTER_TRIANGLES],
    pub offset: [f32; CLUSTER_TRIANGLES],
}

/// Planes of an [`EdgeMesh`] in one pose, in the order of its slots.
#[derive(Clone, Debug, Default)]
pub struct FacingPlanes {
    pub(super) blocks: Vec<PlaneBlock>,
    /// One per cluster, or empty.
    pub(super) bounds: Vec<ClusterBounds>,
    non_finite_triangles: usize,
}

/// Bounds of a cluster's planes, which often decide for all of them on which side a light is.
///
/// They are a cone of normals, as extents along and across its axis, and the range of the planes' distances
/// from the cluster's centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ClusterBounds {
    center: Vec3,
    axis: Vec3,
    /// Smallest and largest `axis · normal`.
    along: [f32; 2],
    /// Largest length of a normal's component across the axis.
    across: f32,
    /// Smallest and largest signed distance of the centre from a plane. The smallest is −∞ if some triangle
    /// never faces.
    offset: [f32; 2],
    /// Bounds the terms to which rounding errors are relative.
    magnitude: f32,
}

/// What [`ClusterBounds`] can decide about a cluster.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Certainty {
    AllFacing,
    NoneFacing,
    Unknown,
}

const EMPTY_BLOCK: PlaneBlock = PlaneBlock {
    x: [0.0; CLUSTER_TRIANGLES],
    y: [0.0; CLUSTER_TRIANGLES],
    z: [0.0; CLUSTER_TRIANGLES],
    offset: [0.0; CLUSTER_TRIANGLES],
};

/// Computes planes, and the cluster bounds, which pay off for a mesh that keeps its pose.
///
/// `positions` are those from which the mesh was built, or a pose of them. There are no planes, and nothing
/// is cast, if there are fewer than [`EdgeMesh::vertex_count`] positions or if a triangle has a corner that
/// is NaN or infinite ([`FacingPlanes::non_finite_triangles`]).
pub fn compute_planes(mesh: &EdgeMesh, positions: &[Vec3], planes: &mut FacingPlanes) {
    compute_posed_planes(mesh, positions, planes);
    if planes.blocks.is_empty() {
        return;
    }
    for (cluster, block) in mesh.clusters().iter().zip(&planes.blocks) {
        planes
            .bounds
            .push(ClusterBounds::of(mesh, cluster, positions, block));
    }
}

/// Computes planes as [`compute_planes`] does, but without cluster bounds, so [`classify`](super::classify)
/// tests every triangle. This is cheaper for a pose that lasts one frame, unless many lights see it.
///
/// One bad corner removes the whole caster for this pose. Removing its triangles alone would turn their
/// neighbours' edges into boundary edges, in every list that was made when the mesh was built. A pose with
/// such a corner is broken in the picture as well.
pub fn compute_posed_planes(mesh: &EdgeMesh, positions: &[Vec3], planes: &mut FacingPlanes) {
    planes.bounds.clear();
    planes.non_finite_triangles = 0;
    if positions.len() < mesh.vertex_count() {
        planes.blocks.clear();
        return;
    }
    planes.blocks.resize(mesh.clusters().len(), EMPTY_BLOCK);
    for (cluster, block) in mesh.clusters().iter().zip(&mut planes.blocks) {
        let corners = &mesh.corners()[cluster.triangles()];
        for (lane, corners) in corners.iter().enumerate().take(CLUSTER_TRIANGLES) {
            let &[a, b, c] = corners;
            let plane = plane_of(
                positions[a as usize],
                positions[b as usize],
                positions[c as usize],
            );
            planes.non_finite_triangles += usize::from(plane.w.is_nan());
            block.x[lane] = plane.x;
            block.y[lane] = plane.y;
            block.z[lane] = plane.z;
            block.offset[lane] = plane.w;
        }
        // The mesh may differ from that of the last call.
        for lane in corners.len()..CLUSTER_TRIANGLES {
            block.x[lane] = 0.0;
            block.y[lane] = 0.0;
            block.z[lane] = 0.0;
            block.offset[lane] = 0.0;
        }
    }
    if planes.non_finite_triangles > 0 {
        planes.blocks.clear();
    }
}

/// Unit normal and offset; zero for a triangle without area.
///
/// The computation is in `f64`, so tiny triangles do not underflow and distant ones keep their offset, and it
/// rounds once. The offset is NaN exactly if a corner is not finite. A coordinate that is not finite leaves a
/// NaN or an infinity in the normal, and normalising turns that into NaN. Three finite corners can overflow
/// only in the last rounding.
fn plane_of(a: Vec3, b: Vec3, c: Vec3) -> Vec4 {
    let (a, b, c) = (a.as_dvec3(), b.as_dvec3(), c.as_dvec3());
    let normal = (b - a).cross(c - a);
    let length_sq = normal.length_squared();
    if length_sq > 0.0 {
        let normal = normal * (1.0 / length_sq.sqrt());
        normal.extend(-normal.dot(a)).as_vec4()
    } else if length_sq == 0.0 {
        Vec4::ZERO
    } else {
        Vec4::NAN
    }
}

impl FacingPlanes {
    /// Number of triangles with a corner that is NaN or infinite in this pose. If there are any, the caster
    /// is left out. Triangles that were already so when the mesh was built do not count, nor do vertices that
    /// no triangle uses.
    pub fn non_finite_triangles(&self) -> usize {
        self.non_finite_triangles
    }

    /// Bytes per triangle of `mesh`, including a share of the cluster bounds.
    pub fn bytes_per_triangle(&self, mesh: &EdgeMesh) -> f64 {
        let bytes = size_of_val(&self.blocks[..]) + size_of_val(&self.bounds[..]);
        bytes as f64 / mesh.triangle_count().max(1) as f64
    }

    /// Returns all slots, also those without a triangle, whose planes are zero.
    pub fn slots(&self) -> std::ops::Range<usize> {
        0..self.blocks.len() * CLUSTER_TRIANGLES
    }

    /// Returns the plane of a slot as (normal, offset).
    pub fn plane(&self, slot: usize) -> Vec4 {
        let (block, lane) = (&self.blocks[slot / CLUSTER_TRIANGLES], slot % CLUSTER_TRIANGLES);
        Vec4::new(block.x[lane], block.y[lane], block.z[lane], block.offset[lane])
    }
}

impl ClusterBounds {
    /// Bounds the planes after rounding, because the test of a triangle sees those.
    fn of(mesh: &EdgeMesh, cluster: &Cluster, positions: &[Vec3], block: &PlaneBlock) -> Self {
        let corners = mesh.corners()[cluster.triangles()].as_flattened();
        let (low, high) = corners
            .iter()
            .map(|&i| positions[i as usize])
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| {
                (low.min(p), high.max(p))
            });
        let center = (low * 0.5 + high * 0.5).as_dvec3();
        let planes = || {
            (0..cluster.triangle_count as usize).map(|lane| {
                let normal = Vec3::new(block.x[lane], block.y[lane], block.z[lane]);
                (normal.as_dvec3(), f64::from(block.offset[lane]))
            })
        };
        let axis: DVec3 = planes().map(|(normal, _)| normal).sum();
        let axis = axis.normalize_or_zero().as_vec3().as_dvec3();
        let mut along = [f64::INFINITY, f64::NEG_INFINITY];
        let mut offset = [f64::INFINITY, f64::NEG_INFINITY];
        let (mut across, mut magnitude) = (0.0f64, 0.0f64);
        let mut some_never_face = false;
        for (normal, distance) in planes() {
            // A triangle that never faces does not contradict "none faces", but it rules out "all face".
            if normal == DVec3::ZERO {
                some_never_face = true;
                continue;
            }
            let parallel = axis.dot(normal);
            let center_distance = normal.dot(center) + distance;
            along = [along[0].min(parallel), along[1].max(parallel)];
            offset = [offset[0].min(center_distance), offset[1].max(center_distance)];
            across = across.max((normal - axis * parallel).length());
            magnitude = magnitude.max(distance.abs());
            // `min` and `max` would lose a NaN.
            some_never_face |= !center_distance.is_finite();
        }
        if along[0] > along[1] {
            (along, offset) = ([0.0; 2], [0.0; 2]);
        }
        if some_never_face {
            offset[0] = f64::NEG_INFINITY;
        }
        Self {
            center: center.as_vec3(),
            axis: axis.as_vec3(),
            along: along.map(|value| value as f32),
            across: across as f32,
            offset: offset.map(|value| value as f32),
            magnitude: (magnitude + 2.0 * center.abs().element_sum()) as f32,
        }
    }

    /// Decides whether all triangles face the light or none does, only where the test of each triangle, with
    /// its rounding errors, would agree.
    ///
    /// With `v` from the centre to the light, a plane's value is `n·v + w·offset`. The term `n·v` splits into
    /// `(n·axis)(axis·v)` along the axis and at most `across · |v − axis (axis·v)|` across it. This is
    /// tighter than a sphere and a cone's half-angle and needs no special cases: offsets replace the radius,
    /// and no angle can exceed π.
    pub(super) fn certainty(&self, light_local: Vec4) -> Certainty {
        self.certainty_around(light_local, 0.0)
    }

    /// Decides like [`certainty`](Self::certainty), for all points within `radius` of the light at once.
    pub(super) fn certainty_around(&self, light_local: Vec4, radius: f32) -> Certainty {
        let w = light_local.w;
        let v = light_local.truncate() - self.center * w;
        let t = self.axis.dot(v);
        let across = self.across * (v - self.axis * t).length();
        let (a, b) = (self.along[0] * t, self.along[1] * t);
        // A dozen roundings here and four in the test of a triangle, each at most 2⁻²⁴ of the terms.
        const ROUNDING: f32 = 32.0 / (1 << 24) as f32;
        let terms = light_local.truncate().abs().element_sum() + w.abs() * self.magnitude;
        let margin = radius + ROUNDING * terms + f32::MIN_POSITIVE;
        // NaN and ∞ − ∞ fail both comparisons. With w < 0, smallest and largest offset would trade places.
        if w < 0.0 {
            Certainty::Unknown
        } else if a.min(b) - across + w * self.offset[0] > margin {
            Certainty::AllFacing
        } else if a.max(b) + across + w * self.offset[1] < -margin {
            Certainty::NoneFacing
        } else {
            Certainty::Unknown
        }
    }
}
