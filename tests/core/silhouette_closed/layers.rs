//! The layers that penumbra wedges sum: their edges bound what faces the light, wherever it is seen from.

use std::collections::BTreeMap;

use antumbra::conventions::CLUSTER_TRIANGLES;
use antumbra::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput};
use antumbra::insides::silhouette_layers::{
    AVERTED, FACING, Facets, LayeredContour, LayeredEdge, Side, extract_layers,
};
use antumbra::silhouettes::{
    CapMode, FacingBits, FacingPlanes, LightExtent, classify, compute_planes, compute_posed_planes,
    find_turning,
};
use glam::{Quat, Vec3};
use proptest::prelude::*;

use super::checks::{MODES, icosphere, slots};
use super::shapes::{Soup, soups};

/// How often each edge is passed, less how often the other way; without those that cancel.
type Chain = BTreeMap<[[u32; 3]; 2], i32>;

fn pass(chain: &mut Chain, [from, to]: [Vec3; 2], times: i32) {
    let key = |place: Vec3| place.to_array().map(f32::to_bits);
    let (edge, sign) = if key(from) < key(to) {
        ([key(from), key(to)], 1)
    } else {
        ([key(to), key(from)], -1)
    };
    *chain.entry(edge).or_default() += sign * times;
}

fn without_zeros(mut chain: Chain) -> Chain {
    chain.retain(|_, times| *times != 0);
    chain
}

fn bit(words: &[u64], slot: usize) -> bool {
    words[slot / CLUSTER_TRIANGLES] >> (slot % CLUSTER_TRIANGLES) & 1 != 0
}

/// What a triangle does in a layer: 1 as it is wound, −1 the other way, 0 if it is not part of it.
fn part(layer: u32, is_facing: bool, alone: Option<CapMode>, is_mixed: bool) -> i32 {
    match (alone, is_mixed, layer) {
        (Some(CapMode::ClosedFacing), _, _) => i32::from(is_facing),
        (Some(_), _, _) => -i32::from(!is_facing),
        (None, false, _) => {
            if is_facing {
                1
            } else {
                -1
            }
        }
        (None, true, FACING) => i32::from(is_facing),
        (None, true, _) => -i32::from(!is_facing),
    }
}

/// The borders of a layer's triangles.
fn borders(mesh: &EdgeMesh, soup: &Soup, of: impl Fn(usize) -> i32) -> Chain {
    let mut chain = Chain::new();
    for (slot, corners) in slots(mesh) {
        let corners = corners.map(|corner| soup.positions[corner as usize]);
        for i in 0..3 {
            pass(&mut chain, [corners[i], corners[(i + 1) % 3]], of(slot));
        }
    }
    without_zeros(chain)
}

/// How often an edge counts in a layer's penumbra, as the shader has it.
fn times(edge: &LayeredEdge, layer: u32, seen: &[u64]) -> i32 {
    let faces = |side: Side| match side {
        Side::Facing => 1,
        Side::Averted => 0,
        Side::Open => i32::from(layer == AVERTED),
        Side::Turning(slot) => i32::from(bit(seen, slot as usize)),
    };
    i32::from(edge.soft_layers & layer != 0) * (faces(edge.sides[0]) - faces(edge.sides[1]))
}

/// What the edges add up to in a layer's penumbra.
fn soft_chain(edges: &[LayeredEdge], layer: u32, seen: &[u64]) -> Chain {
    let mut chain = Chain::new();
    for edge in edges {
        pass(&mut chain, edge.ends, times(edge, layer, seen));
    }
    without_zeros(chain)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    /// For any bits: what faces the centre, what turns, and what of that faces the light from elsewhere.
    #[test]
    fn edges_bound_the_layers_from_everywhere(
        soup in soups(),
        words in prop::collection::vec(any::<[u64; 3]>(), 8),
        some_turn in any::<bool>(),
    ) {
        let mesh = soup.build();
        let facing = FacingBits::from_words(&mesh, words.iter().map(|words| words[0]));
        let clusters = || mesh.clusters().iter().zip(&words);
        let turning: Vec<u64> = clusters()
            .map(|(cluster, words)| if some_turn { words[1] & cluster.full_word() } else { 0 })
            .collect();
        let seen: Vec<u64> = clusters()
            .zip(&turning)
            .zip(facing.words())
            .map(|(((_, words), turning), facing)| (words[2] & turning) | (facing & !turning))
            .collect();
        let closed_slots = mesh.closed_cluster_count() * CLUSTER_TRIANGLES;
        for mode in MODES {
            let mut contour = LayeredContour::default();
            let facets = Facets { facing: &facing, turning: &turning, grazed: &[], level: &[] };
            extract_layers(&mesh, &soup.positions, facets, mode, false, &mut contour);
            let alone = |slot| Some(mode).filter(|&mode| mode != CapMode::AllTriangles && slot < closed_slots);
            let open = || slots(&mesh).map(|(slot, _)| slot).filter(|&slot| alone(slot).is_none());
            let is_mixed = open().any(|slot| bit(&turning, slot))
                || (open().any(|slot| facing.is_facing(slot)) && open().any(|slot| !facing.is_facing(slot)));
            for layer in [FACING, AVERTED] {
                let expected = |faces: &dyn Fn(usize) -> bool| {
                    borders(&mesh, &soup, |slot| part(layer, faces(slot), alone(slot), is_mixed))
                };
                let mut hard = Chain::new();
                for edge in &contour.edges {
                    pass(&mut hard, edge.ends, i32::from(edge.layers & layer != 0));
                }
                prop_assert_eq!(without_zeros(hard), expected(&|slot| facing.is_facing(slot)));
                let soft = soft_chain(&contour.edges, layer, &seen);
                prop_assert_eq!(soft, expected(&|slot| bit(&seen, slot)));
            }
        }
    }
}

#[test]
fn a_dropped_edge_and_another_view_are_told() {
    let soup = icosphere(1.0, 2);
    let mesh = soup.build();
    let (light, extent) = (Vec3::new(0.0, 3.0, 0.0), LightExtent::Sides([Vec3::X, Vec3::Z]));
    let (mut planes, mut facing, mut turning) = (FacingPlanes::default(), FacingBits::default(), Vec::new());
    compute_planes(&mesh, &soup.positions, &mut planes);
    classify(&mesh, &planes, light.extend(1.0), &mut facing);
    find_turning(&mesh, &planes, light, &extent, &mut turning);
    let facets = Facets {
        facing: &facing,
        turning: &turning,
        grazed: &[],
        level: &[],
    };
    let mut contour = LayeredContour::default();
    extract_layers(
        &mesh,
        &soup.positions,
        facets,
        CapMode::ClosedBackFacing,
        false,
        &mut contour,
    );
    let seen = facing.words();
    let whole = soft_chain(&contour.edges, FACING, seen);
    let other: Vec<u64> = seen
        .iter()
        .zip(&turning)
        .map(|(seen, turning)| seen ^ turning)
        .collect();
    assert!(!whole.is_empty() && whole != soft_chain(&contour.edges, FACING, &other));
    let counts = |edge: &LayeredEdge| times(edge, FACING, seen) != 0;
    let dropped = contour
        .edges
        .iter()
        .position(counts)
        .expect("an edge of the silhouette");
    contour.edges.remove(dropped);
    assert_ne!(whole, soft_chain(&contour.edges, FACING, seen));
}

/// By the definition: not all of many places on the light are on one side of the plane.
fn turns(plane: glam::Vec4, light: Vec3, extent: &LightExtent) -> Option<bool> {
    let value = plane.truncate().dot(light) + plane.w;
    let reach = match extent {
        LightExtent::Sides([a, b]) => [(1.0, 1.0), (1.0, -1.0)]
            .map(|(x, y)| plane.truncate().dot(*a * x + *b * y).abs())
            .into_iter()
            .fold(0.0, f32::max),
        LightExtent::Ellipsoid(axes) => (0..20_000)
            .map(|i| {
                let height = 1.0 - 2.0 * (i as f32 + 0.5) / 20_000.0;
                let (sin, cos) = (2.399_963_2 * i as f32).sin_cos();
                let flat = (1.0 - height * height).sqrt();
                let place = axes[0] * (flat * cos) + axes[1] * (flat * sin) + axes[2] * height;
                plane.truncate().dot(place)
            })
            .fold(0.0, f32::max),
    };
    // What only touches may be either.
    ((value.abs() - reach).abs() > 0.02 * reach).then_some(value.abs() < reach)
}

#[test]
fn triangles_turn_whose_planes_cut_the_light() {
    let soup = icosphere(1.0, 4);
    let mesh = soup.build();
    let light = Vec3::new(2.0, 1.5, 0.5);
    let turn = Quat::from_rotation_arc(Vec3::Z, light.normalize());
    let axes = [Vec3::X * 0.7, Vec3::Y * 0.3, Vec3::Z * 0.5].map(|axis| turn * axis);
    for extent in [
        LightExtent::Sides([axes[0], axes[1]]),
        LightExtent::Ellipsoid(axes),
        LightExtent::Ellipsoid([Vec3::X, Vec3::new(0.5, 0.5, 0.0), Vec3::Z * 0.1]),
    ] {
        // With the bounds of clusters and without.
        let mut answers = [(); 2].map(|()| Vec::new());
        for (posed, words) in [false, true].into_iter().zip(&mut answers) {
            let mut planes = FacingPlanes::default();
            if posed {
                compute_posed_planes(&mesh, &soup.positions, &mut planes);
            } else {
                compute_planes(&mesh, &soup.positions, &mut planes);
            }
            find_turning(&mesh, &planes, light, &extent, words);
            let mut count = 0;
            for (slot, _) in slots(&mesh) {
                let got = bit(words, slot);
                count += usize::from(got);
                if let Some(expected) = turns(planes.plane(slot), light, &extent) {
                    assert_eq!(got, expected, "{extent:?} {slot}");
                }
            }
            assert!(count > 100 && count < mesh.triangle_count() / 2, "{count}");
        }
        assert_eq!(answers[0], answers[1]);
    }
}

#[test]
fn without_planes_of_the_mesh_nothing_turns() {
    let mesh = EdgeMesh::build(EdgeMeshInput {
        positions: &[Vec3::ZERO, Vec3::X, Vec3::Y],
        indices: &[0, 1, 2],
        ..EdgeMeshInput::default()
    })
    .unwrap();
    let mut words = vec![u64::MAX];
    let extent = LightExtent::Sides([Vec3::X, Vec3::Y]);
    find_turning(&mesh, &FacingPlanes::default(), Vec3::Z, &extent, &mut words);
    assert!(words.is_empty());
}
