//! What must hold for any mesh and light, by brute force.

use std::collections::BTreeMap;

use antumbra::conventions::CLUSTER_TRIANGLES;
use antumbra::geometry::edge_mesh::EdgeMesh;
use antumbra::scene::MeshData;
use antumbra::silhouettes::{
    CapMode, Contour, FacingBits, FacingPlanes, classify, classify_scalar, compute_planes,
    compute_posed_planes, extract_contour, link_loops,
};
use glam::Vec4;
use rustc_hash::FxHashMap;

use super::shapes::Soup;
use super::volume::{unbalanced_edge, volume};

pub const MODES: [CapMode; 3] = [
    CapMode::ClosedBackFacing,
    CapMode::AllTriangles,
    CapMode::ClosedFacing,
];

pub struct Cast {
    pub mesh: EdgeMesh,
    pub bits: FacingBits,
    pub contours: [Contour; 3],
}

pub fn cast(soup: &Soup, light: Vec4) -> Cast {
    cast_of(soup.build(), soup, light)
}

fn cast_of(mesh: EdgeMesh, soup: &Soup, light: Vec4) -> Cast {
    let mut planes = FacingPlanes::default();
    compute_planes(&mesh, &soup.positions, &mut planes);
    let mut bits = FacingBits::default();
    classify(&mesh, &planes, light, &mut bits);
    let contours = MODES.map(|mode| {
        let mut contour = Contour::default();
        extract_contour(&mesh, &bits, mode, &mut contour);
        contour
    });
    Cast { mesh, bits, contours }
}

pub fn icosphere(radius: f32, subdivisions: u32) -> Soup {
    let mesh = MeshData::icosphere(radius, subdivisions);
    Soup {
        positions: mesh.positions,
        indices: mesh.indices,
    }
}

pub fn slots(mesh: &EdgeMesh) -> impl Iterator<Item = (usize, [u32; 3])> + '_ {
    mesh.clusters().iter().enumerate().flat_map(|(i, cluster)| {
        (i * CLUSTER_TRIANGLES..).zip(mesh.corners()[cluster.triangles()].iter().copied())
    })
}

/// Whether each triangle (by slot) is of a closed piece that is wound outward: flood fill over a hash map of edges.
fn closed_by_brute_force(mesh: &EdgeMesh, soup: &Soup) -> FxHashMap<usize, bool> {
    let mut at_edge: FxHashMap<[u32; 2], Vec<(usize, i32)>> = FxHashMap::default();
    for (slot, [a, b, c]) in slots(mesh) {
        for (a, b) in [(a, b), (b, c), (c, a)] {
            let sign = if a < b { 1 } else { -1 };
            at_edge
                .entry([a.min(b), a.max(b)])
                .or_default()
                .push((slot, sign));
        }
    }
    let corners: FxHashMap<usize, [u32; 3]> = slots(mesh).collect();
    let mut closed = FxHashMap::default();
    for (start, _) in slots(mesh) {
        if closed.contains_key(&start) {
            continue;
        }
        let (mut piece, mut is_closed, mut next) = (vec![start], true, 0);
        closed.insert(start, true);
        while next < piece.len() {
            let [a, b, c] = corners[&piece[next]];
            next += 1;
            for (a, b) in [(a, b), (b, c), (c, a)] {
                let sides = &at_edge[&[a.min(b), a.max(b)]];
                is_closed &= sides.iter().map(|side| side.1).sum::<i32>() == 0;
                for &(slot, _) in sides {
                    if closed.insert(slot, true).is_none() {
                        piece.push(slot);
                    }
                }
            }
        }
        let origin = soup.positions[corners[&start][0] as usize].as_dvec3();
        let terms = piece.iter().map(|slot| {
            let [a, b, c] = corners[slot].map(|i| soup.positions[i as usize].as_dvec3() - origin);
            a.cross(b).dot(c)
        });
        let (volume, sizes) = terms.fold((0.0, 0.0), |(sum, sizes), term| (sum + term, sizes + term.abs()));
        is_closed &= volume > 1e-9 * sizes;
        for slot in piece {
            closed.insert(slot, is_closed);
        }
    }
    closed
}

/// Sum of signs over a hash map, with each cap triangle turned to face the light.
fn contour_by_brute_force(
    cast: &Cast,
    closed: &FxHashMap<usize, bool>,
    mode: CapMode,
) -> BTreeMap<[u32; 2], usize> {
    let mut sums: FxHashMap<[u32; 2], i32> = FxHashMap::default();
    for (slot, [a, b, c]) in slots(&cast.mesh) {
        let is_facing = cast.bits.is_facing(slot);
        let left_out = match mode {
            CapMode::ClosedBackFacing => is_facing,
            CapMode::AllTriangles => false,
            CapMode::ClosedFacing => !is_facing,
        };
        if left_out && closed[&slot] {
            continue;
        }
        let [b, c] = if is_facing { [b, c] } else { [c, b] };
        for (a, b) in [(a, b), (b, c), (c, a)] {
            *sums.entry([a.min(b), a.max(b)]).or_default() += if a < b { 1 } else { -1 };
        }
    }
    sums.into_iter()
        .filter(|&(_, sum)| sum != 0)
        .map(|([a, b], sum)| (if sum > 0 { [a, b] } else { [b, a] }, sum.unsigned_abs() as usize))
        .collect()
}

pub fn counted<T: Ord>(values: impl IntoIterator<Item = T>) -> BTreeMap<T, usize> {
    let mut counts = BTreeMap::new();
    for value in values {
        *counts.entry(value).or_default() += 1;
    }
    counts
}

/// Edges by the bits of their ends.
pub fn edge_bits(contour: &Contour, soup: &Soup) -> BTreeMap<[[u32; 3]; 2], usize> {
    let bits = |i: u32| soup.positions[i as usize].to_array().map(|x| (x + 0.0).to_bits());
    counted(contour.all_edges().map(|edge| edge.map(bits)))
}

pub fn assert_loops(edge_vertices: &[[u32; 2]]) {
    let loops = link_loops(edge_vertices).unwrap();
    let mut used = loops.edges.clone();
    used.sort_unstable();
    assert!(used.into_iter().eq(0..edge_vertices.len() as u32));
    for edges in loops.iter() {
        for (i, &edge) in edges.iter().enumerate() {
            let next = edges[(i + 1) % edges.len()];
            assert_eq!(edge_vertices[edge as usize][1], edge_vertices[next as usize][0]);
        }
        let visits = counted(edges.iter().map(|&edge| edge_vertices[edge as usize][0]));
        assert!(visits.values().all(|&count| count == 1), "a loop meets itself");
    }
}

/// All that must hold for any mesh and light.
pub fn assert_holds(soup: &Soup, light: Vec4) {
    assert_holds_under(soup, [light]);
}

/// All that must hold for any mesh and each of the lights.
pub fn assert_holds_under(soup: &Soup, lights: impl IntoIterator<Item = Vec4>) {
    let mesh = soup.build();
    let closed = closed_by_brute_force(&mesh, soup);
    for light in lights {
        assert_cast_holds(&cast_of(mesh.clone(), soup, light), &closed, soup, light);
    }
}

fn assert_cast_holds(cast: &Cast, closed: &FxHashMap<usize, bool>, soup: &Soup, light: Vec4) {
    let mut planes = FacingPlanes::default();
    compute_posed_planes(&cast.mesh, &soup.positions, &mut planes);
    let mut bits = FacingBits::default();
    classify_scalar(&cast.mesh, &planes, light, &mut bits);
    assert_eq!(
        bits.words(),
        cast.bits.words(),
        "bounds and SIMD give the bits of the scalar test"
    );
    for (mode, contour) in MODES.into_iter().zip(&cast.contours) {
        let edge_vertices: Vec<_> = contour.all_edges().collect();
        assert_eq!(
            unbalanced_edge(&volume(contour, &soup.positions)),
            None,
            "{mode:?} {light}"
        );
        assert_eq!(
            counted(edge_vertices.iter().copied()),
            contour_by_brute_force(cast, closed, mode)
        );
        assert_loops(&edge_vertices);
    }
    if cast.mesh.is_closed() {
        let [single, double, facing] = cast
            .contours
            .each_ref()
            .map(|contour| counted(contour.all_edges()));
        assert_eq!(single, facing);
        assert_eq!(
            double,
            single
                .into_iter()
                .map(|(edge, count)| (edge, count * 2))
                .collect()
        );
    }
}
