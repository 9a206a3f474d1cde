//! The contour of anything is closed, and is what brute force says.

use antumbra::geometry::edge_mesh::{EdgeMesh, EdgeMeshError, EdgeMeshInput};
use antumbra::silhouettes::{
    CapMode, Contour, FacingBits, FacingPlanes, LoopError, Loops, classify, classify_scalar, compute_planes,
    extract_contour, link_loops,
};
use glam::{DVec3, Vec3, Vec4};
use proptest::prelude::*;

mod checks;
mod hard_cases;
mod layers;
#[cfg(feature = "gltf")]
mod models;
mod shapes;
mod volume;

use checks::{MODES, assert_holds, cast, counted, edge_bits, icosphere, slots};
use shapes::{Soup, light_of, light_seeds, shuffled, soups};
use volume::{Corner, is_crossed, unbalanced_edge, volume, winding};

const LIGHTS: [Vec4; 10] = [
    Vec4::new(3.0, 4.0, 5.0, 1.0),
    Vec4::new(0.1, 0.05, -0.1, 1.0),
    Vec4::new(0.0, 0.0, 0.0, 1.0),
    Vec4::new(-0.3, 1.0, 0.2, 1.0),
    Vec4::new(1e5, -2e5, 1e4, 1.0),
    Vec4::new(1.0, 2.0, 3.0, 0.0),
    Vec4::new(0.0, 1.0, 0.0, 0.0),
    Vec4::new(0.0, 0.0, 0.0, 0.0),
    Vec4::new(f32::NAN, 0.0, 0.0, 1.0),
    Vec4::new(f32::INFINITY, 0.0, 0.0, 1.0),
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn volume_edges_cancel_bit_for_bit(soup in soups(), light in light_seeds()) {
        assert_holds(&soup, light_of(&soup.positions, &soup.indices, light));
    }

    #[test]
    fn any_facing_bits_leave_the_volume_closed(soup in soups(), words in prop::collection::vec(any::<u64>(), 8)) {
        let mesh = soup.build();
        let bits = FacingBits::from_words(&mesh, words);
        for mode in MODES {
            let mut contour = Contour::default();
            extract_contour(&mesh, &bits, mode, &mut contour);
            prop_assert_eq!(unbalanced_edge(&volume(&contour, &soup.positions)), None);
        }
    }

    /// Thin, bent and far spheres, lights on their planes and at their vertices: where bounds could be too bold.
    #[test]
    fn cluster_bounds_never_change_a_bit(
        scale in [0.001..2.0f32, 0.1..2.0f32, 0.1..2.0f32],
        size in prop::sample::select(vec![1e-12f32, 1e-3, 1.0, 1e3, 1e12]),
        offset in prop::sample::select(vec![0.0f32, 1.0, 100.0, 1e5]),
        seed in light_seeds(),
    ) {
        let mut sphere = icosphere(1.0, 3);
        for position in &mut sphere.positions {
            *position = (*position * Vec3::from(scale) + offset) * size;
        }
        let mut light = light_of(&sphere.positions, &sphere.indices, seed);
        if seed.0 < 2 {
            light = ((light.truncate() + offset) * size).extend(1.0);
        }
        let mesh = sphere.build();
        let mut planes = FacingPlanes::default();
        compute_planes(&mesh, &sphere.positions, &mut planes);
        let (mut culled, mut scalar) = (FacingBits::default(), FacingBits::default());
        classify(&mesh, &planes, light, &mut culled);
        classify_scalar(&mesh, &planes, light, &mut scalar);
        prop_assert_eq!(culled.words(), scalar.words());
    }

    #[test]
    fn volume_winds_as_often_as_triangles_are_in_the_way(
        soup in soups(), light in light_seeds(), point in [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64],
    ) {
        let light = light_of(&soup.positions, &soup.indices, light);
        let point = DVec3::from(point);
        let cast = cast(&soup, light);
        let crossed: Option<Vec<bool>> = slots(&cast.mesh)
            .map(|(_, corners)| is_crossed(corners.map(|i| soup.positions[i as usize]), light, point))
            .collect();
        let winding = winding(&volume(&cast.contours[1], &soup.positions), light, point);
        // Rejects are counted: too many of them fail the test.
        prop_assume!(crossed.is_some() && winding.is_some());
        let crossed = crossed.into_iter().flatten().filter(|&crossed| crossed).count();
        prop_assert_eq!(winding, Some(crossed as i64));
    }

    /// With the light outside of a sphere: outside one layer of back faces, or of facing ones, blocks.
    #[test]
    fn back_facing_caps_shadow_what_is_behind_a_solid(
        light in [-3.0..3.0f32, -3.0..3.0f32, -3.0..3.0f32], point in [-3.0..3.0f64, -3.0..3.0f64, -3.0..3.0f64],
    ) {
        let (light, point) = (Vec3::from(light).extend(1.0), DVec3::from(point));
        prop_assume!(light.truncate().length() > 1.1 && point.length() > 1.1);
        let sphere = icosphere(1.0, 2);
        let cast = cast(&sphere, light);
        let crossed: Option<Vec<bool>> = slots(&cast.mesh)
            .map(|(_, corners)| is_crossed(corners.map(|i| sphere.positions[i as usize]), light, point))
            .collect();
        let windings = cast.contours.each_ref().map(|contour| winding(&volume(contour, &sphere.positions), light, point));
        prop_assume!(crossed.is_some() && windings.iter().all(Option::is_some));
        let crossed = crossed.into_iter().flatten().filter(|&crossed| crossed).count() as i64;
        prop_assert_eq!(windings, [Some(crossed / 2), Some(crossed), Some(crossed / 2)]);
    }
}

#[test]
fn spheres_hold_in_any_order() {
    for subdivisions in 0..4 {
        let sphere = icosphere(1.0, subdivisions);
        let other = shuffled(&sphere, 7);
        for light in LIGHTS {
            assert_holds(&sphere, light);
            assert_holds(&other, light);
            let (a, b) = (cast(&sphere, light), cast(&other, light));
            assert!(a.mesh.is_closed());
            for (a, b) in a.contours.iter().zip(&b.contours) {
                assert_eq!(edge_bits(a, &sphere), edge_bits(b, &other));
                assert_eq!(a.caps.len(), b.caps.len());
            }
        }
    }
}

#[test]
fn closed_and_open_pieces_keep_apart() {
    let mut soup = icosphere(1.0, 2);
    let mut open = icosphere(0.5, 2);
    open.indices.truncate(open.indices.len() - 3);
    let first = soup.positions.len() as u32;
    soup.positions.extend(open.positions.iter().map(|&p| p + 3.0));
    soup.indices.extend(open.indices.iter().map(|i| first + i));
    let mesh = soup.build();
    assert_eq!((mesh.closed_triangle_count(), mesh.triangle_count()), (320, 639));
    assert_eq!(mesh.boundary_vertices().len(), 3);
    assert!(!mesh.is_closed());
    let (full, last) = mesh.clusters().split_at(mesh.clusters().len() - 1);
    assert!(full.iter().all(|cluster| cluster.triangle_count == 64) && last[0].triangle_count == 63);
    for light in LIGHTS {
        assert_holds(&soup, light);
    }
}

#[test]
fn caps_are_triangles_of_the_input_corner_for_corner() {
    let sphere = icosphere(1.0, 3);
    let input = counted(sphere.indices.chunks_exact(3));
    for contour in cast(&sphere, LIGHTS[0]).contours {
        assert!(
            contour
                .caps
                .chunks_exact(3)
                .all(|corners| input.contains_key(corners))
        );
    }
}

#[test]
fn checks_fail_when_an_edge_is_dropped_or_a_vertex_moves() {
    let soup = icosphere(1.0, 2);
    let cast = cast(&soup, LIGHTS[0]);
    for contour in cast.contours {
        let mut edge_vertices: Vec<_> = contour.all_edges().collect();
        let polygons = volume(&contour, &soup.positions);
        assert_eq!(unbalanced_edge(&polygons), None);
        let mut dropped = contour.clone();
        dropped.edges.pop().or(dropped.double_edges.pop());
        edge_vertices.pop();
        assert!(unbalanced_edge(&volume(&dropped, &soup.positions)).is_some());
        assert!(matches!(
            link_loops(&edge_vertices),
            Err(LoopError::Unbalanced { .. })
        ));
        let mut moved = polygons;
        let Corner { position, .. } = &mut moved[0][0];
        position.x = position.x.next_up();
        assert!(unbalanced_edge(&moved).is_some());
    }
}

#[test]
fn buffers_serve_another_mesh() {
    let (large, small) = (icosphere(1.0, 3), icosphere(2.0, 0));
    let (mut planes, mut bits, mut contour) =
        (FacingPlanes::default(), FacingBits::default(), Contour::default());
    let mut loops = Loops::default();
    for soup in [&large, &small, &large] {
        let mesh = soup.build();
        compute_planes(&mesh, &soup.positions, &mut planes);
        classify(&mesh, &planes, LIGHTS[0], &mut bits);
        extract_contour(&mesh, &bits, CapMode::AllTriangles, &mut contour);
        let edge_vertices: Vec<_> = contour.all_edges().collect();
        loops.link(&edge_vertices).unwrap();
        let fresh = cast(soup, LIGHTS[0]);
        assert_eq!((&bits, &contour), (&fresh.bits, &fresh.contours[1]));
        assert_eq!(loops.edges, link_loops(&edge_vertices).unwrap().edges);
    }
    // Bits and positions of another mesh cast nothing.
    let mesh = small.build();
    extract_contour(&mesh, &bits, CapMode::AllTriangles, &mut contour);
    assert_eq!(contour, Contour::default());
    compute_planes(&mesh, &[], &mut planes);
    classify(&mesh, &planes, LIGHTS[0], &mut bits);
    assert!(bits.words().is_empty());
}

#[test]
fn bad_input_is_named_or_counted() {
    let positions = [
        Vec3::ZERO,
        Vec3::X,
        Vec3::Y,
        Vec3::NAN,
        Vec3::INFINITY,
        Vec3::X * 2.0,
    ];
    let build = |indices: &[u32]| {
        EdgeMesh::build(EdgeMeshInput {
            positions: &positions,
            indices,
            ..EdgeMeshInput::default()
        })
    };
    assert_eq!(
        build(&[0, 1, 2, 0, 1, 6]).unwrap_err(),
        EdgeMeshError::IndexOutOfRange {
            triangle: 1,
            index: 6,
            vertex_count: 6
        }
    );
    assert_eq!(
        build(&[0, 1, 2, 0]).unwrap_err(),
        EdgeMeshError::IncompleteTriangle {
            index_count: 4,
            triangle: 1
        }
    );
    let input = EdgeMeshInput {
        positions: &positions,
        indices: &[0, 1, 2],
        ..EdgeMeshInput::default()
    };
    assert!(matches!(
        EdgeMesh::build(EdgeMeshInput {
            pose_keys: Some(&[1]),
            ..input
        }),
        Err(EdgeMeshError::PoseKeyCount {
            key_count: 1,
            vertex_count: 6
        })
    ));
    for epsilon in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let mesh = EdgeMesh::build(EdgeMeshInput {
            weld_epsilon: Some(epsilon),
            ..input
        });
        assert!(matches!(mesh, Err(EdgeMeshError::WeldEpsilon(_))));
    }
    let mesh = build(&[0, 1, 2, 0, 1, 3, 4, 1, 2, 1, 1, 2]).unwrap();
    assert_eq!(
        (
            mesh.report().non_finite_triangles,
            mesh.report().collapsed_triangles
        ),
        (2, 1)
    );
    assert_eq!(mesh.triangle_count(), 1);

    // Nothing, only collapsed ones, a single one, one of no area.
    for (indices, count) in [
        (vec![], 0),
        (vec![1, 1, 2, 0, 0, 0], 0),
        (vec![0, 1, 2], 1),
        (vec![0, 1, 5], 1),
    ] {
        let soup = Soup {
            positions: positions.to_vec(),
            indices,
        };
        assert_eq!(soup.build().triangle_count(), count);
        for light in LIGHTS {
            let cast = cast(&soup, light);
            for contour in &cast.contours {
                assert_eq!(contour.edge_count(), count * 3);
                assert_eq!(unbalanced_edge(&volume(contour, &positions)), None);
            }
        }
    }
}

#[test]
fn on_the_plane_and_of_no_area_is_not_facing() {
    let soup = Soup {
        positions: vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::X * 2.0],
        indices: vec![0, 1, 2, 0, 1, 3],
    };
    for (light, words) in [
        (Vec4::new(0.0, 0.0, 1.0, 1.0), 1),
        (Vec4::new(5.0, 3.0, 0.0, 1.0), 0),
        (Vec4::new(0.0, 0.0, -1.0, 1.0), 0),
        (Vec4::new(0.0, 0.0, 1.0, 0.0), 1),
        (Vec4::new(1.0, 0.0, 0.0, 0.0), 0),
    ] {
        assert_eq!(cast(&soup, light).bits.words(), [words], "{light}");
    }
}

#[cfg(feature = "gltf")]
#[test]
fn models_hold() {
    let bundled = || concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models").into();
    let folder = std::env::var_os("ANTUMBRA_MODELS").unwrap_or_else(bundled);
    let mut mesh_count = 0;
    for path in models::glb_files(std::path::Path::new(&folder)) {
        let (mut triangles, mut closed, mut boundary, mut irregular) = (0, 0, 0, 0);
        for mesh in models::meshes(&path) {
            let soup = Soup {
                positions: mesh.positions,
                indices: mesh.indices,
            };
            let mesh = soup.build();
            triangles += mesh.triangle_count();
            closed += mesh.closed_triangle_count();
            boundary += mesh.boundary_vertices().len();
            irregular += mesh.irregular_vertices().len();
            let light = |seed| light_of(&soup.positions, &soup.indices, (seed, 5, [2.0, 3.0, -1.0]));
            checks::assert_holds_under(&soup, (0..7).map(light));
            mesh_count += 1;
        }
        println!(
            "{}: {triangles} triangles, {closed} closed; {boundary} boundary, {irregular} irregular edges",
            path.display()
        );
    }
    assert!(mesh_count > 0, "no models in {}", folder.display());
}
