//! Time and memory of silhouettes on one thread, beside a plain loop of GPU Gems chapter 9.
//!
//! ```sh
//! cargo bench --bench silhouettes [-- --short]
//! ```
//!
//! Each repetition takes the next of 48 lights: directional, or on shells at 1.2, 2, 4 and 16 radii around the mesh, in
//! random order, so that neither branch predictor nor caches know the answer. Mode `ClosedBackFacing`; how the figures
//! come about: [`time_ns`]. Edges are counted in all (`ns/edge`), not only those found (`found`, in the last light).
//! `shuffled`: triangles and vertices of the input in random order. `by mesh`: each mesh of the file has its own edge
//! mesh, as in a scene, and a light takes them all; without it they are one mesh. `posed` and `static`: planes without
//! and with what is kept for meshes that keep their pose. Chapter 9 emits indices of both caps, ours of the one whose
//! copy the GPU extrudes. `ANTUMBRA_BENCH_ONLY=interior` measures only what has that in its name.

use std::hint::black_box;
use std::time::{Duration, Instant};

use antumbra::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput};
use antumbra::silhouettes::{
    CapMode, Contour, FacingBits, FacingPlanes, classify, classify_scalar, compute_planes,
    compute_posed_planes, extract_caps, extract_contour, extract_edges,
};
use glam::{Vec3, Vec4};

#[path = "silhouettes/chapter_9.rs"]
mod chapter_9;
#[cfg(feature = "gltf")]
#[path = "../tests/core/silhouette_closed/models.rs"]
mod models;
#[path = "silhouettes/workload.rs"]
mod workload;

use chapter_9::{ChapterMesh, ChapterVolume};
use workload::{Workload, icosphere, joined, lights_around, shuffled};

const MODE: CapMode = CapMode::ClosedBackFacing;

fn main() {
    let is_short = std::env::args().any(|argument| argument == "--short");
    let only = std::env::var("ANTUMBRA_BENCH_ONLY").unwrap_or_default();
    let effort = Effort {
        rounds: if is_short { 5 } else { 10 },
        budget: Duration::from_millis(if is_short { 20 } else { 300 }),
    };
    println!(
        "Nanoseconds: median over 48 lights, of each light the least of {} or more rounds.",
        effort.rounds
    );
    println!("{}", HEAD[0].map(|text| format!("{text:>8}")).join(""));
    println!("{}", HEAD[1].map(|text| format!("{text:>8}")).join(""));
    let sizes: &[_] = if is_short {
        &[("1k", 3), ("20k", 5)]
    } else {
        &[("1k", 3), ("20k", 5), ("82k", 6), ("1.3M", 8)]
    };
    let spheres = sizes.iter().flat_map(|&(name, subdivisions)| {
        let mesh = icosphere(name, subdivisions);
        [shuffled(&mesh), mesh]
    });
    for workload in spheres.filter(|mesh| mesh.name.contains(&only)) {
        print_row(&workload, effort);
    }
    for workload in model_workloads().iter().filter(|mesh| mesh.name.contains(&only)) {
        print_row(workload, effort);
    }
    println!(
        "Anchor, Doom 3 BFG, SIMD job on one thread (its hardware, not this one): classify 2.8 ns/tri, sides 1.8 ns/edge,"
    );
    println!("caps 1.9 ns/tri, all 7.3 ns/tri.");
}

const HEAD: [[&str; 18]; 2] = [
    [
        "", "", "", "tris", "closed", "mixed", "found", "classify", "edges", "edges", "caps", "all", "posed",
        "static", "mesh", "planes", "ch. 9", "ratio",
    ],
    [
        "mesh", "", "", "", "%", "%", "/tri", "ns/tri", "ns/edge", "ns/tri", "ns/tri", "ns/tri", "ns/tri",
        "ns/tri", "B/tri", "B/tri", "ns/tri", "",
    ],
];

/// How long to measure.
#[derive(Clone, Copy)]
struct Effort {
    rounds: usize,
    budget: Duration,
}

#[cfg(feature = "gltf")]
fn model_workloads() -> Vec<Workload> {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models");
    let workloads = ["deer.glb", "interior.glb"].into_iter().flat_map(|file| {
        let parts = models::meshes(&folder.join(file));
        let parts = parts.into_iter().map(|mesh| (mesh.positions, mesh.indices));
        let by_mesh = Workload {
            name: format!("{file} by mesh"),
            parts: parts.collect(),
        };
        [joined(&by_mesh), by_mesh]
    });
    workloads.collect()
}

#[cfg(not(feature = "gltf"))]
fn model_workloads() -> Vec<Workload> {
    Vec::new()
}

/// All that is kept of a part of a workload, and what a light leaves behind.
struct Part<'a> {
    positions: &'a [Vec3],
    mesh: EdgeMesh,
    planes: FacingPlanes,
    baseline: ChapterMesh,
    /// Bits of every light, made beforehand: extraction is also timed alone.
    all_bits: Vec<FacingBits>,
    contour: Contour,
    volume: ChapterVolume,
}

impl<'a> Part<'a> {
    fn new((positions, indices): &'a (Vec<Vec3>, Vec<u32>), lights: &[Vec4]) -> Self {
        let input = EdgeMeshInput {
            positions,
            indices,
            ..EdgeMeshInput::default()
        };
        let mesh = EdgeMesh::build(input).expect("workloads are meshes");
        let mut planes = FacingPlanes::default();
        compute_planes(&mesh, positions, &mut planes);
        let baseline = ChapterMesh::new(positions, indices, &mesh);
        assert_answer(&mesh, positions, &planes, &baseline, lights);
        let all_bits = lights.iter().map(|&light| bits_of(&mesh, &planes, light));
        Self {
            positions,
            baseline,
            all_bits: all_bits.collect(),
            contour: Contour::default(),
            volume: ChapterVolume::default(),
            mesh,
            planes,
        }
    }
}

fn print_row(workload: &Workload, effort: Effort) {
    let lights = lights_around(&joined(workload).parts[0].0);
    let parts = workload.parts.iter().map(|part| Part::new(part, &lights));
    let mut parts: Vec<Part> = parts.collect();
    let mut bits = FacingBits::default();

    let sum = |count: fn(&Part) -> usize| parts.iter().map(count).sum::<usize>() as f64;
    let triangle_count = sum(|part| part.mesh.triangle_count());
    let edge_count = sum(|part| part.mesh.edge_count());
    let closed = sum(|part| part.mesh.closed_triangle_count());
    let clusters = sum(|part| part.mesh.clusters().len());
    let mixed = sum(|part| part.all_bits.iter().map(FacingBits::mixed_cluster_count).sum()) / 48.0;
    let bytes = |count: fn(&Part) -> f64| parts.iter().map(count).sum::<f64>();
    let mesh_bytes = bytes(|part| part.mesh.bytes_per_triangle() * part.mesh.triangle_count() as f64);
    let planes_bytes =
        bytes(|part| part.planes.bytes_per_triangle(&part.mesh) * part.mesh.triangle_count() as f64);

    let classify_ns = time_ns(effort, &mut parts, |i, part| {
        classify(&part.mesh, &part.planes, lights[i], &mut bits)
    });
    let edges_ns = time_ns(effort, &mut parts, |i, part| {
        extract_edges(&part.mesh, &part.all_bits[i], MODE, &mut part.contour)
    });
    let found = parts.iter().map(|part| part.contour.edge_count()).sum::<usize>();
    let caps_ns = time_ns(effort, &mut parts, |i, part| {
        extract_caps(&part.mesh, &part.all_bits[i], MODE, &mut part.contour)
    });
    let all_ns = time_ns(effort, &mut parts, |i, part| {
        classify(&part.mesh, &part.planes, lights[i], &mut bits);
        extract_contour(&part.mesh, &bits, MODE, &mut part.contour);
    });
    let chapter_ns = time_ns(effort, &mut parts, |i, part| {
        part.baseline
            .mark_shadows(part.positions, lights[i], &mut part.volume)
    });
    let posed_ns = time_ns(effort, &mut parts, |_, part| {
        compute_posed_planes(&part.mesh, part.positions, &mut part.planes)
    });
    let static_ns = time_ns(effort, &mut parts, |_, part| {
        compute_planes(&part.mesh, part.positions, &mut part.planes)
    });
    let per_triangle = |value: f64| value / triangle_count;
    println!(
        "{:<24}{triangle_count:>8}{:>8.0}{:>8.1}{:>8.2}{:>8.3}{:>8.3}{:>8.3}{:>8.3}{:>8.3}{:>8.2}{:>8.2}{:>8.1}{:>8.1}{:>8.2}{:>8.1}",
        workload.name,
        100.0 * per_triangle(closed),
        100.0 * mixed / clusters,
        per_triangle(found as f64),
        per_triangle(classify_ns),
        edges_ns / edge_count,
        per_triangle(edges_ns),
        per_triangle(caps_ns),
        per_triangle(all_ns),
        per_triangle(posed_ns),
        per_triangle(static_ns),
        per_triangle(mesh_bytes),
        per_triangle(planes_bytes),
        per_triangle(chapter_ns),
        chapter_ns / all_ns,
    );
}

/// Nanoseconds to do the work for every part in one light: of each light the least over the rounds, since what else the
/// machine does can only add; of these the median over the lights, so that one that is dear does not speak for all.
///
/// The least of each round's median was not enough: on a busy machine no round was quiet from first to last. Work on
/// small meshes is done for several lights at a time, so that the clock is not what is measured.
fn time_ns(effort: Effort, parts: &mut [Part], mut work: impl FnMut(usize, &mut Part)) -> f64 {
    let start = Instant::now();
    for light in 0..48 {
        parts.iter_mut().for_each(|part| work(light, part)); // buffers have grown after this
    }
    let once_ns = start.elapsed().as_nanos() / 48;
    let batch = (20_000 / once_ns.max(1)).clamp(1, 48) as usize;
    let (mut least, start, mut round) = ([f64::INFINITY; 48], Instant::now(), 0);
    while round < effort.rounds || start.elapsed() < effort.budget {
        for (first, least) in least.iter_mut().enumerate() {
            let sample_start = Instant::now();
            for next in 0..batch {
                let light = black_box((first * batch + next) % 48);
                parts.iter_mut().for_each(|part| work(light, part));
            }
            *least = least.min(sample_start.elapsed().as_nanos() as f64 / batch as f64);
        }
        round += 1;
    }
    least.sort_by(f64::total_cmp);
    least[24]
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
        extract_contour(mesh, &bits, MODE, &mut contour);
        baseline.mark_shadows(positions, light, &mut volume);
        if mesh.is_closed() && mesh.irregular_vertices().is_empty() {
            let (ours, theirs) = (contour.edge_count(), volume.sides.len() / 4);
            assert!(
                ours.abs_diff(theirs) * 100 <= theirs,
                "{ours} edges, chapter 9 finds {theirs}"
            );
        }
    }
}
