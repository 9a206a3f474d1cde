//! Time and memory of silhouettes on one thread, beside a plain loop of GPU Gems chapter 9.
//!
//! ```sh
//! ANTUMBRA_MODELS=assets cargo bench --bench silhouettes [-- --short]
//! ```
//!
//! Each repetition takes the next of 48 lights: directional, or on shells at 1.2, 2, 4 and 16 radii around the mesh, in
//! random order, so that neither branch predictor nor caches know the answer. Figures are medians over repetitions,
//! mode `ClosedBackFacing`; edges are counted in all, not only those found. `shuffled`: triangles and vertices of the
//! input in random order. Chapter 9 emits indices of both caps, ours of the one whose copy the GPU extrudes.

use std::hint::black_box;
use std::time::{Duration, Instant};

use antumbra::conventions::CLUSTER_TRIANGLES;
use antumbra::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput};
use antumbra::silhouettes::{
    CapMode, Contour, FacingBits, FacingPlanes, classify, classify_scalar, compute_planes,
    compute_posed_planes, extract_caps, extract_contour, extract_edges,
};
use glam::{Vec3, Vec4};

#[path = "silhouettes/chapter_9.rs"]
mod chapter_9;
#[cfg(feature = "gltf")]
#[path = "../tests/silhouette_closed/models.rs"]
mod models;
#[path = "silhouettes/workload.rs"]
mod workload;

use chapter_9::{ChapterMesh, ChapterVolume};
use workload::{Workload, icosphere, lights_around, shuffled};

const MODE: CapMode = CapMode::ClosedBackFacing;

fn main() {
    let is_short = std::env::args().any(|argument| argument == "--short");
    let budget = Duration::from_millis(if is_short { 10 } else { 300 });
    println!("{}", HEAD[0].map(|text| format!("{text:>8}")).join(""));
    println!("{}", HEAD[1].map(|text| format!("{text:>8}")).join(""));
    let sizes: &[_] = if is_short {
        &[("1k", 3), ("20k", 5)]
    } else {
        &[("1k", 3), ("20k", 5), ("82k", 6), ("1.3M", 8)]
    };
    for &(name, subdivisions) in sizes {
        let mesh = icosphere(name, subdivisions);
        print_row(&mesh, budget);
        print_row(&shuffled(&mesh), budget);
    }
    for model in model_workloads() {
        print_row(&model, budget);
    }
    println!(
        "Anchor, Doom 3 BFG, SIMD job on one thread (its hardware, not this one): classify 2.8 ns/tri, sides 1.8 ns/edge,"
    );
    println!("caps 1.9 ns/tri, all 7.3 ns/tri.");
}

const HEAD: [[&str; 17]; 2] = [
    [
        "", "", "", "tris", "closed", "mixed", "classify", "edges", "caps", "all", "posed", "+bounds",
        "touched", "mesh", "planes", "ch. 9", "ratio",
    ],
    [
        "mesh", "", "", "", "%", "%", "ns/tri", "ns/edge", "ns/tri", "ns/tri", "ns/tri", "ns/tri", "B/tri",
        "B/tri", "B/tri", "ns/tri", "",
    ],
];

#[cfg(feature = "gltf")]
fn model_workloads() -> Vec<Workload> {
    let Some(folder) = std::env::var_os("ANTUMBRA_MODELS") else {
        println!("models skipped: ANTUMBRA_MODELS names no folder");
        return Vec::new();
    };
    let files = ["copy/a-closed/deer.glb", "copy/d-scenes/interior.glb"];
    let workloads = files.map(|file| {
        let mut all = Workload {
            name: file.rsplit('/').next().unwrap_or(file).into(),
            positions: vec![],
            indices: vec![],
        };
        for mesh in models::meshes(&std::path::Path::new(&folder).join(file)) {
            let first = all.positions.len() as u32;
            all.positions.extend(mesh.positions);
            all.indices.extend(mesh.indices.iter().map(|index| first + index));
        }
        all
    });
    workloads.into()
}

#[cfg(not(feature = "gltf"))]
fn model_workloads() -> Vec<Workload> {
    Vec::new()
}

fn print_row(workload: &Workload, budget: Duration) {
    let Workload {
        name,
        positions,
        indices,
    } = workload;
    let input = EdgeMeshInput {
        positions,
        indices,
        ..EdgeMeshInput::default()
    };
    let mesh = EdgeMesh::build(input).expect("workloads are meshes");
    let mut planes = FacingPlanes::default();
    compute_planes(&mesh, positions, &mut planes);
    let baseline = ChapterMesh::new(positions, indices, &mesh);
    let lights = lights_around(positions);
    let (mut bits, mut contour) = (FacingBits::default(), Contour::default());
    let mut volume = ChapterVolume::default();
    assert_answer(&mesh, positions, &planes, &baseline, &lights);

    let triangle_count = mesh.triangle_count() as f64;
    // Extraction alone: bits of every light, made beforehand.
    let all_bits: Vec<FacingBits> = lights
        .iter()
        .map(|&light| bits_of(&mesh, &planes, light))
        .collect();
    let classify_ns = median_ns(budget, |i| classify(&mesh, &planes, lights[i % 48], &mut bits));
    let edges_ns = median_ns(budget, |i| {
        extract_edges(&mesh, positions, &all_bits[i % 48], MODE, &mut contour)
    });
    let caps_ns = median_ns(budget, |i| {
        extract_caps(&mesh, positions, &all_bits[i % 48], MODE, &mut contour)
    });
    let all_ns = median_ns(budget, |i| {
        classify(&mesh, &planes, lights[i % 48], &mut bits);
        extract_contour(&mesh, positions, &bits, MODE, &mut contour);
    });
    let chapter_ns = median_ns(budget, |i| {
        baseline.mark_shadows(positions, lights[i % 48], &mut volume)
    });
    let touched = lights
        .iter()
        .zip(&all_bits)
        .map(|(_, bits)| touched_bytes(&mesh, &planes, positions, bits))
        .sum::<f64>()
        / 48.0;
    let mixed = all_bits
        .iter()
        .map(FacingBits::mixed_cluster_count)
        .sum::<usize>() as f64
        / 48.0;
    let planes_bytes = planes.bytes_per_triangle(&mesh);
    let posed_ns = median_ns(budget, |_| compute_posed_planes(&mesh, positions, &mut planes));
    let bounds_ns = median_ns(budget, |_| compute_planes(&mesh, positions, &mut planes)) - posed_ns;
    println!(
        "{name:<24}{:>8}{:>8.0}{:>8.1}{:>8.3}{:>8.3}{:>8.3}{:>8.3}{:>8.2}{:>8.2}{:>8.1}{:>8.1}{:>8.1}{:>8.2}{:>8.1}",
        mesh.triangle_count(),
        100.0 * mesh.closed_triangle_count() as f64 / triangle_count,
        100.0 * mixed / mesh.clusters().len() as f64,
        classify_ns / triangle_count,
        edges_ns / mesh.edge_count() as f64,
        caps_ns / triangle_count,
        all_ns / triangle_count,
        posed_ns / triangle_count,
        bounds_ns / triangle_count,
        touched / triangle_count,
        mesh.bytes_per_triangle(),
        planes_bytes,
        chapter_ns / triangle_count,
        chapter_ns / all_ns,
    );
}

/// Nanoseconds of a call: median over as many as fit the budget, five at least; small work is put together so that the
/// clock is not what is measured.
fn median_ns(budget: Duration, mut work: impl FnMut(usize)) -> f64 {
    for i in 0..48 {
        work(i); // buffers have grown after this
        if i == 4 && budget < Duration::from_millis(100) {
            break;
        }
    }
    let start = Instant::now();
    work(0);
    let batch =
        (Duration::from_micros(200).as_nanos() / start.elapsed().as_nanos().max(1)).clamp(1, 48) as usize;
    let (mut samples, mut next, start) = (Vec::new(), 0, Instant::now());
    while samples.len() < 5 || start.elapsed() < budget {
        let batch_start = Instant::now();
        for _ in 0..batch {
            work(black_box(next));
            next += 1;
        }
        samples.push(batch_start.elapsed().as_nanos() as f64 / batch as f64);
    }
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

fn bits_of(mesh: &EdgeMesh, planes: &FacingPlanes, light: Vec4) -> FacingBits {
    let mut bits = FacingBits::default();
    classify(mesh, planes, light, &mut bits);
    bits
}

/// The bits are those of the scalar twin, and on a closed mesh there are as many sides as chapter 9 finds, but for
/// triangles so near to edge-on that its rounding decides otherwise.
fn assert_answer(
    mesh: &EdgeMesh,
    positions: &[Vec3],
    planes: &FacingPlanes,
    baseline: &ChapterMesh,
    lights: &[Vec4],
) {
    let (mut scalar, mut contour, mut volume) = (
        FacingBits::default(),
        Contour::default(),
        ChapterVolume::default(),
    );
    for &light in &lights[..4] {
        let bits = bits_of(mesh, planes, light);
        classify_scalar(mesh, planes, light, &mut scalar);
        assert_eq!(bits.words(), scalar.words());
        extract_contour(mesh, positions, &bits, MODE, &mut contour);
        baseline.mark_shadows(positions, light, &mut volume);
        if mesh.is_closed() {
            let (ours, theirs) = (contour.edges.len(), volume.sides.len() / 4);
            assert!(
                ours.abs_diff(theirs) * 100 <= theirs,
                "{ours} edges, chapter 9 finds {theirs}"
            );
        }
    }
}

/// Bytes that a light reads and writes, counted from what the functions look at; vertices as 12 bytes each.
fn touched_bytes(mesh: &EdgeMesh, planes: &FacingPlanes, positions: &[Vec3], bits: &FacingBits) -> f64 {
    let mut contour = Contour::default();
    extract_contour(mesh, positions, bits, MODE, &mut contour);
    let cluster_count = mesh.clusters().len();
    let is_mixed = |cluster: u32| {
        let full = mesh.clusters()[cluster as usize].full_word();
        let word = bits.words()[cluster as usize];
        word != 0 && word != full
    };
    let tested_edges: u32 = (0u32..)
        .zip(mesh.clusters())
        .filter(|&(i, _)| is_mixed(i))
        .map(|(_, c)| c.edge_count)
        .sum();
    let tested_seams: u32 = mesh
        .seams()
        .iter()
        .filter(|seam| seam.clusters.iter().any(|&cluster| is_mixed(cluster)))
        .map(|seam| seam.edge_count)
        .sum();
    let blocks = bits.tested_cluster_count() * CLUSTER_TRIANGLES * 16;
    let bounds = (planes.bytes_per_triangle(mesh) * mesh.triangle_count() as f64) as usize
        - cluster_count * CLUSTER_TRIANGLES * 16;
    let words = cluster_count * (8 + 1 + 16) * 3;
    let edges = size_of_val(mesh.seams()) + (tested_edges + tested_seams) as usize * 2;
    let found = contour.edges.len() * (8 + 24 + 24 + 8) + mesh.boundary_slots().len() * 4;
    let caps = contour.caps.len() * 4 * 2;
    (blocks + bounds + words + edges + found + caps) as f64
}
