use antumbra::geometry::edge_mesh::*;
#[path = "../tests/silhouette_closed/models.rs"]
mod models;
fn main() {
    let mut h = std::collections::BTreeMap::<(usize, i32), usize>::new();
    let (mut b, mut s, mut r, mut n, mut nc) = (0, 0, 0, 0, 0);
    for m in models::meshes(std::path::Path::new(
        "/work/shared/assets/copy/d-scenes/interior.glb",
    )) {
        let e = EdgeMesh::build(EdgeMeshInput {
            positions: &m.positions,
            indices: &m.indices,
            ..Default::default()
        })
        .unwrap();
        n += 1;
        nc += e.clusters().len();
        b += e.boundary_slots().len();
        s += e.seams().len();
        r += e.regular_lanes().len();
        for i in 0..e.irregular_vertices().len() {
            let k = e.irregular_sides(i);
            let sum: i32 = k.iter().map(|s| if s.is_reversed() { -1 } else { 1 }).sum();
            *h.entry((k.len(), sum.abs())).or_default() += 1;
        }
    }
    println!("meshes {n} clusters {nc} boundary {b} seams {s} regular {r} irregular {h:?}");
}
