//! Triangles of glTF files, without the crate's own importer: the check shares no code with it.

use std::path::{Path, PathBuf};

use glam::Vec3;
use gltf::mesh::Mode;

pub struct Triangles {
    pub name: String,
    pub positions: Vec<Vec3>,
    pub indices: Vec<u32>,
}

/// Every `.glb` below `folder`, by name.
#[allow(dead_code, reason = "the bench names its two files")]
pub fn glb_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "glb") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// The meshes of a file, the primitives of each put together. Primitives that are no triangles, or whose data
/// the `gltf` crate cannot read (compressed), are left out.
pub fn meshes(path: &Path) -> Vec<Triangles> {
    let bytes = std::fs::read(path).unwrap();
    let file = gltf::Gltf::from_slice_without_validation(&bytes).unwrap();
    let blob = file.blob.as_deref().unwrap_or_default();
    let mut meshes = Vec::new();
    for mesh in file.meshes() {
        let mut triangles = Triangles {
            name: format!("{} mesh {}", path.display(), mesh.index()),
            positions: Vec::new(),
            indices: Vec::new(),
        };
        for primitive in mesh.primitives() {
            let reader = primitive.reader(|buffer| (buffer.index() == 0).then_some(blob));
            let Some(positions) = reader.read_positions() else {
                println!(
                    "{}: primitive {} has no readable positions",
                    triangles.name,
                    primitive.index()
                );
                continue;
            };
            let first = triangles.positions.len() as u32;
            triangles.positions.extend(positions.map(Vec3::from));
            let count = triangles.positions.len() as u32 - first;
            let corners: Vec<u32> = match reader.read_indices() {
                Some(indices) => indices.into_u32().collect(),
                None => (0..count).collect(),
            };
            let list: Vec<u32> = match primitive.mode() {
                Mode::Triangles => corners,
                Mode::TriangleStrip => corners
                    .windows(3)
                    .enumerate()
                    .flat_map(|(i, c)| {
                        if i % 2 == 0 {
                            [c[0], c[1], c[2]]
                        } else {
                            [c[1], c[0], c[2]]
                        }
                    })
                    .collect(),
                Mode::TriangleFan => corners[1..]
                    .windows(2)
                    .flat_map(|c| [corners[0], c[0], c[1]])
                    .collect(),
                _ => continue,
            };
            triangles.indices.extend(list.iter().map(|corner| first + corner));
        }
        meshes.push(triangles);
    }
    meshes
}
