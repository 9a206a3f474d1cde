//! Outlines of the patches of a cutting surface, without the vertices that lie on straight lines.
//!
//! A vertex may go only where two patches, or a patch and a border, meet along a chain. Both patches then lose it, so they
//! still meet without gap. Vertices that are not on a border move to where the planes of the patches around them meet, so
//! that a coarse ball is neither within the fine one nor around it. The polygons fill an outline from one of its vertices.
//! Their signed areas add up to the patch, also where it is not convex or has holes.
//!
//! Source of the moves: Garland & Heckbert 1997, "Surface Simplification Using Quadric Error Metrics".

use glam::{DMat3, DVec3};

use super::cut_pieces::{CutPolygon, CutTriangle, NONE, Patch, side_of};

/// The greatest number of edges of a chain that one edge replaces. It bounds the time, which is quadratic in it.
const LONGEST: usize = 1024;

/// An edge between two patches, or of one.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    /// The patches beside it, the lower number first; [`NONE`] stands for none.
    patches: [u32; 2],
    is_used: bool,
}

/// A vertex of outlines.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    name: u32,
    position: DVec3,
    /// The number of edges that meet here, and the first two of them.
    edge_count: u32,
    edges: [u32; 2],
    is_kept: bool,
    /// Whether an edge that meets here has a patch on one side alone.
    is_on_border: bool,
    /// Sum over the patches that meet here of the products of their normals.
    quadric: DMat3,
    /// Sum over the patches that meet here of their normals, times the distance of the vertex below the plane.
    pull: DVec3,
}

/// Weight with which a vertex stays where it is, against the squares of its distances from planes.
const STAYS: f64 = 0.01;

/// A side of a triangle on the outline of its patch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct OutlineSide {
    patch: u32,
    from: u32,
    to: u32,
}

/// The outlines of all patches of a surface. Buffers are reused.
#[derive(Debug, Default)]
pub(super) struct Outlines {
    vertices: Vec<Vertex>,
    edges: Vec<Edge>,
    sides: Vec<OutlineSide>,
    used: Vec<bool>,
    chain: Vec<u32>,
    dropped: Vec<u32>,
    points: Vec<DVec3>,
}

impl Outlines {
    /// Finds the outlines, and which of their vertices are kept if an outline may be off by `tolerance`, metres.
    pub(super) fn find(
        &mut self,
        triangles: &[CutTriangle],
        mates: &[u32],
        patch_of: &[u32],
        patches: &[Patch],
        tolerance: f64,
    ) {
        let patch_of_side = |side: u32| {
            let patch = patch_of.get(side as usize / 3).copied().unwrap_or(NONE);
            patches
                .get(patch as usize)
                .map_or(NONE, |found| if found.is_level { NONE } else { patch })
        };
        let outline = || {
            (0..mates.len() as u32).filter_map(|side| {
                let [own, other] = [side, mates[side as usize]].map(patch_of_side);
                (own != NONE && own != other).then_some((side, own, other))
            })
        };
        let ends_of = |side: u32| side_of(triangles[side as usize / 3].vertices, side as usize % 3);
        self.vertices.clear();
        for (side, _, _) in outline() {
            let triangle = &triangles[side as usize / 3];
            for corner in [side as usize % 3, (side as usize + 1) % 3] {
                self.vertices.push(Vertex {
                    name: triangle.vertices[corner],
                    position: triangle.corners[corner],
                    edge_count: 0,
                    edges: [NONE; 2],
                    is_kept: true,
                    is_on_border: false,
                    quadric: DMat3::from_diagonal(DVec3::splat(STAYS)),
                    pull: DVec3::ZERO,
                });
            }
        }
        self.vertices.sort_unstable_by_key(|vertex| vertex.name);
        self.vertices.dedup_by_key(|vertex| vertex.name);
        self.edges.clear();
        self.sides.clear();
        for (side, own, other) in outline() {
            let ends = ends_of(side).map(|name| {
                let at = self.vertices.binary_search_by_key(&name, |vertex| vertex.name);
                at.unwrap_or(0) as u32 // all are there
            });
            self.sides.push(OutlineSide {
                patch: own,
                from: ends[0],
                to: ends[1],
            });
            // The other side of the edge is in the outline of the other patch.
            if other == NONE || side < mates[side as usize] {
                self.push_edge(ends, [own.min(other), own.max(other)]);
            }
        }
        self.sides.sort_unstable();
        self.drop_vertices(tolerance);
        self.move_vertices(patches);
    }

    /// Moves vertices that are not on a border towards the planes of their patches.
    fn move_vertices(&mut self, patches: &[Patch]) {
        for side in &self.sides {
            let (vertex, patch) = (
                &mut self.vertices[side.from as usize],
                patches[side.patch as usize],
            );
            let normal = patch.normal;
            vertex.quadric += DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
            vertex.pull -= normal * (normal.dot(vertex.position) + patch.offset);
        }
        for vertex in &mut self.vertices {
            if vertex.is_kept && !vertex.is_on_border {
                vertex.position += vertex.quadric.inverse() * vertex.pull;
            }
        }
    }

    fn push_edge(&mut self, ends: [u32; 2], patches: [u32; 2]) {
        let number = self.edges.len() as u32;
        for end in ends {
            let vertex = &mut self.vertices[end as usize];
            if let Some(free) = vertex.edges.get_mut(vertex.edge_count as usize) {
                *free = number;
            }
            vertex.edge_count += 1;
            vertex.is_on_border |= patches.contains(&NONE);
        }
        self.edges.push(Edge {
            ends,
            patches,
            is_used: false,
        });
    }

    /// Whether outlines branch at a vertex.
    fn is_corner(&self, vertex: u32) -> bool {
        let Vertex {
            edge_count, edges, ..
        } = self.vertices[vertex as usize];
        let patches = |edge: u32| self.edges[edge as usize].patches;
        edge_count != 2 || patches(edges[0]) != patches(edges[1])
    }

    /// Follows each chain of edges between corners, then each loop without corners.
    fn drop_vertices(&mut self, tolerance: f64) {
        for edge in 0..self.edges.len() {
            for end in self.edges[edge].ends {
                if !self.edges[edge].is_used && self.is_corner(end) {
                    self.follow(end, edge as u32);
                    self.straighten(tolerance);
                }
            }
        }
        for edge in 0..self.edges.len() {
            if !self.edges[edge].is_used {
                self.follow(self.edges[edge].ends[0], edge as u32);
                // The farthest vertex of a loop is a corner that it needs.
                self.chain.pop();
                let distance = |vertex: &u32| self.vertices[*vertex as usize].position.length_squared();
                let farthest = (0..self.chain.len())
                    .max_by(|a, b| distance(&self.chain[*a]).total_cmp(&distance(&self.chain[*b])));
                self.chain.rotate_left(farthest.unwrap_or(0));
                self.chain.extend_from_within(..1);
                self.straighten(tolerance);
            }
        }
    }

    /// Collects the chain that begins at a vertex with an edge, up to the next corner or back to the vertex.
    fn follow(&mut self, first: u32, first_edge: u32) {
        self.chain.clear();
        self.chain.push(first);
        let (mut at, mut edge) = (first, first_edge);
        loop {
            let this = &mut self.edges[edge as usize];
            this.is_used = true;
            at = if this.ends[0] == at {
                this.ends[1]
            } else {
                this.ends[0]
            };
            self.chain.push(at);
            if at == first || self.is_corner(at) {
                return;
            }
            let [one, other] = self.vertices[at as usize].edges;
            edge = if one == edge { other } else { one };
        }
    }

    /// Drops the vertices of the chain that are near the lines between those that are kept.
    fn straighten(&mut self, tolerance: f64) {
        let Self {
            vertices,
            chain,
            dropped,
            ..
        } = self;
        let position = |at: usize| vertices[chain[at] as usize].position;
        dropped.clear();
        let mut anchor = 0;
        for at in 2..chain.len() {
            let (from, along) = (position(anchor), position(at) - position(anchor));
            let scale = along.length_squared().max(f64::MIN_POSITIVE).recip();
            let is_near = |between: usize| {
                let across = position(between) - from;
                let share = (across.dot(along) * scale).clamp(0.0, 1.0);
                (across - along * share).length_squared() <= tolerance * tolerance
            };
            if at - anchor > LONGEST || !(anchor + 1..at).all(is_near) {
                anchor = at - 1;
            } else {
                dropped.push(chain[at - 1]);
            }
        }
        for &vertex in &*dropped {
            vertices[vertex as usize].is_kept = false;
        }
    }

    /// Fills the outlines with polygons, in the order of the patches.
    pub(super) fn push_polygons(&mut self, polygons: &mut Vec<CutPolygon>) {
        polygons.clear();
        self.used.clear();
        self.used.resize(self.sides.len(), false);
        for first in 0..self.sides.len() {
            if self.used[first] {
                continue;
            }
            let OutlineSide { patch, from, .. } = self.sides[first];
            self.points.clear();
            let mut at = Some(first);
            // As many sides leave a vertex as arrive at it, so each loop closes.
            while let Some(side) = at {
                self.used[side] = true;
                let OutlineSide { from: vertex, to, .. } = self.sides[side];
                let vertex = self.vertices[vertex as usize];
                if vertex.is_kept {
                    self.points.push(vertex.position);
                }
                at = (to != from).then(|| self.free_side(patch, to)).flatten();
            }
            push_fan(&self.points, patch, polygons);
        }
    }

    /// Finds a side of a patch that leaves a vertex and is in no loop yet.
    fn free_side(&self, patch: u32, from: u32) -> Option<usize> {
        let first = self
            .sides
            .partition_point(|side| (side.patch, side.from) < (patch, from));
        let leaving = self.sides[first..].iter().zip(&self.used[first..]);
        let here = leaving.take_while(|(side, _)| (side.patch, side.from) == (patch, from));
        here.enumerate()
            .find(|(_, (_, used))| !**used)
            .map(|(number, _)| first + number)
    }
}

/// Fills a loop with polygons of four corners around its first vertex.
fn push_fan(points: &[DVec3], patch: u32, polygons: &mut Vec<CutPolygon>) {
    for second in (1..points.len().saturating_sub(1)).step_by(2) {
        let last = (second + 2).min(points.len() - 1);
        polygons.push(CutPolygon {
            corners: [points[0], points[second], points[second + 1], points[last]],
            patch,
        });
    }
}
