//! Where the ends of edges come from: names, positions of a pose, or positions kept in the order of the edges.

use std::ops::Range;

use glam::Vec3;

use crate::geometry::edge_mesh::EdgeMesh;

/// Positions of boundary and irregular edges in the order in which a light takes them, for meshes that keep their pose.
///
/// A light takes every boundary edge, turned or not: they are copied from one array to another, and what is left of
/// them is a twentieth of the time of `extract_edges` (sampled, interior by mesh).
///
/// Tried for regular edges too and dropped (`benches/silhouettes.rs`, interior by mesh): their positions beside the
/// edges, at 36 bytes a triangle, or positions in the order of the edges under names of their own, at 18 bytes, were
/// not faster beyond noise. A light takes few of them.
#[derive(Clone, Debug, Default)]
pub(super) struct KeptEnds {
    boundary: Vec<[Vec3; 2]>,
    irregular: Vec<[Vec3; 2]>,
}

impl KeptEnds {
    pub(super) fn clear(&mut self) {
        self.boundary.clear();
        self.irregular.clear();
    }

    pub(super) fn gather(&mut self, mesh: &EdgeMesh, positions: &[Vec3]) {
        let gather = |kept: &mut Vec<[Vec3; 2]>, edges: &[[u32; 2]]| {
            kept.clear();
            kept.extend(edges.iter().map(|edge| edge.map(|i| positions[i as usize])));
        };
        gather(&mut self.boundary, mesh.boundary_vertices());
        gather(&mut self.irregular, mesh.irregular_vertices());
    }

    pub(super) fn is_of(&self, mesh: &EdgeMesh) -> bool {
        self.boundary.len() == mesh.boundary_vertices().len()
            && self.irregular.len() == mesh.irregular_vertices().len()
    }

    pub(super) fn byte_count(&self) -> usize {
        size_of_val(&self.boundary[..]) + size_of_val(&self.irregular[..])
    }
}

/// The two ends of each edge of a mesh, in the direction asked for.
///
/// Turned before positions are read: turned afterwards they went through the stack in pieces of another size, which
/// made half of the cost of an edge (stalled store forwarding).
pub(super) trait Ends {
    type End: Copy;

    fn regular(&self, edge: usize, is_forward: bool) -> [Self::End; 2];
    fn irregular(&self, edge: usize, is_forward: bool) -> [Self::End; 2];
    fn boundary(
        &self,
        run: Range<usize>,
        is_forward: impl Fn(usize) -> bool,
    ) -> impl Iterator<Item = [Self::End; 2]>;
}

/// Ends by name, each turned into what is asked for.
pub(super) struct Resolved<'a, F> {
    pub mesh: &'a EdgeMesh,
    pub resolve: F,
}

impl<T: Copy, F: Fn(u32) -> T> Ends for Resolved<'_, F> {
    type End = T;

    #[inline(always)]
    fn regular(&self, edge: usize, is_forward: bool) -> [T; 2] {
        let [a, b] = turned(&self.mesh.regular_vertices()[edge], is_forward);
        [(self.resolve)(a), (self.resolve)(b)]
    }

    #[inline(always)]
    fn irregular(&self, edge: usize, is_forward: bool) -> [T; 2] {
        let [a, b] = turned(&self.mesh.irregular_vertices()[edge], is_forward);
        [(self.resolve)(a), (self.resolve)(b)]
    }

    #[inline(always)]
    fn boundary(
        &self,
        run: Range<usize>,
        is_forward: impl Fn(usize) -> bool,
    ) -> impl Iterator<Item = [T; 2]> {
        let edges = &self.mesh.boundary_vertices()[run];
        edges.iter().enumerate().map(move |(i, edge)| {
            let [a, b] = turned(edge, is_forward(i));
            [(self.resolve)(a), (self.resolve)(b)]
        })
    }
}

/// Ends of regular edges by name, since few of them are taken, all others as they are kept.
pub(super) struct Kept<'a> {
    pub mesh: &'a EdgeMesh,
    pub positions: &'a [Vec3],
    pub kept: &'a KeptEnds,
}

impl Ends for Kept<'_> {
    type End = Vec3;

    #[inline(always)]
    fn regular(&self, edge: usize, is_forward: bool) -> [Vec3; 2] {
        let [a, b] = turned(&self.mesh.regular_vertices()[edge], is_forward);
        [self.positions[a as usize], self.positions[b as usize]]
    }

    #[inline(always)]
    fn irregular(&self, edge: usize, is_forward: bool) -> [Vec3; 2] {
        turned(&self.kept.irregular[edge], is_forward)
    }

    #[inline(always)]
    fn boundary(
        &self,
        run: Range<usize>,
        is_forward: impl Fn(usize) -> bool,
    ) -> impl Iterator<Item = [Vec3; 2]> {
        let edges = &self.kept.boundary[run];
        edges
            .iter()
            .enumerate()
            .map(move |(i, edge)| turned(edge, is_forward(i)))
    }
}

/// By places instead of a choice between two copies.
#[inline(always)]
fn turned<T: Copy>(edge: &[T; 2], is_forward: bool) -> [T; 2] {
    [edge[usize::from(!is_forward)], edge[usize::from(is_forward)]]
}
