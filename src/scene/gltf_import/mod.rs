//! glTF 2.0 import: a file becomes a [`LoadedGltf`] on the CPU, a scene of it becomes entities.
//!
//! | step | file |
//! | --- | --- |
//! | GLB container, JSON, required extensions | `container.rs` |
//! | buffers from chunk, data URI, file | `buffers.rs` |
//! | accessors, bounds first | `accessors.rs` |
//! | primitives to triangle lists, several to one mesh | `mesh.rs`, `vertices.rs`, `triangles.rs` |
//! | materials, textures | `material.rs`, `texture.rs` |
//! | node forest, lights, cameras, skins | `nodes.rs`, `transforms.rs` |
//! | cells, portals, occluders in extras | `cells.rs`, `cell_extras.rs` |
//! | animation clips | `clips.rs` |
//! | entities | `spawn.rs` |
//!
//! What a file cannot mean is a [`GltfError`]; what can be left out is left out and listed in the [`Report`].
//! The `gltf` crate gives the JSON schema only: its readers and its validation panic on some malformed files.

mod accessors;
mod buffers;
mod cell_extras;
mod cells;
mod clips;
mod container;
mod error;
mod material;
mod mesh;
mod nodes;
mod report;
mod spawn;
mod texture;
mod transforms;
mod triangles;
mod vertices;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use cell_extras::{GltfPortal, GltfVisibility};
pub use container::SUPPORTED_EXTENSIONS;
pub use error::GltfError;
pub use mesh::GltfMesh;
pub use nodes::{GltfNode, GltfSceneRoots, GltfSkin, MAX_NODE_DEPTH};
pub use report::{Element, Report, Skip, SkipKind};
pub use spawn::{SpawnedScene, spawn_scene};

use super::animation::AnimationClip;
use super::{Camera, Light, Material};
use accessors::Accessors;
use texture::Textures;

/// A glTF file on the CPU. Lists are indexed as in the file.
#[derive(Clone, Debug)]
pub struct LoadedGltf {
    /// Where it came from, for messages.
    pub file: PathBuf,
    /// Meshes with their materials.
    pub meshes: Vec<GltfMesh>,
    /// Materials.
    pub materials: Vec<Arc<Material>>,
    /// A forest.
    pub nodes: Vec<GltfNode>,
    /// At least one.
    pub scenes: Vec<GltfSceneRoots>,
    /// Index of the scene to show first.
    pub default_scene: usize,
    /// Lights of `KHR_lights_punctual`.
    pub lights: Vec<Light>,
    /// Cameras; `None` for those that are not supported.
    pub cameras: Vec<Option<Camera>>,
    /// Skins.
    pub skins: Vec<GltfSkin>,
    /// Animations.
    pub clips: Arc<[AnimationClip]>,
    /// What was left out.
    pub report: Report,
}

impl LoadedGltf {
    /// Triangles of all meshes, each mesh once.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.data.triangle_count()).sum()
    }
}

/// Loads a `.glb` or `.gltf` file; files that it refers to are looked for beside it.
///
/// # Errors
/// [`GltfError`] names the file and the element.
pub fn load_gltf(path: impl AsRef<Path>) -> Result<LoadedGltf, GltfError> {
    let path = path.as_ref();
    let read = || {
        // a pipe or a device would never end
        if !std::fs::metadata(path)?.is_file() {
            return Err(std::io::Error::other("not a file"));
        }
        std::fs::read(path)
    };
    let bytes = read().map_err(|source| GltfError::Io {
        file: path.to_owned(),
        source,
    })?;
    load(&bytes, path.parent(), path)
}

/// Loads GLB or glTF JSON from memory. External files are looked for in `base_dir`; `name` stands for the file
/// in messages.
///
/// # Errors
/// [`GltfError`] names the file and the element.
pub fn load_gltf_slice(bytes: &[u8], base_dir: Option<&Path>, name: &str) -> Result<LoadedGltf, GltfError> {
    load(bytes, base_dir, Path::new(name))
}

fn load(bytes: &[u8], base_dir: Option<&Path>, file: &Path) -> Result<LoadedGltf, GltfError> {
    let mut report = Report::default();
    let document = container::parse(bytes, file, &mut report)?;
    let buffers = buffers::load(&document.root, document.binary_chunk, base_dir, file)?;
    let accessors = Accessors::new(file.to_owned(), &document.root, buffers, bytes.len());

    let mut textures = Textures::new(&accessors, base_dir);
    let materials = material::load(&accessors, &mut textures, &mut report)?;
    let meshes = mesh::load(&accessors, &materials, &mut report)?;
    let skins = nodes::load_skins(&accessors, &mut report)?;
    let mut nodes = nodes::load(&accessors, &meshes, &skins, &mut report)?;
    cells::load(&accessors, &mut nodes, &mut report);
    let (scenes, default_scene) = nodes::load_scenes(&accessors, &nodes)?;
    let lights = nodes::load_lights(&accessors, &mut report);
    let cameras = nodes::load_cameras(&accessors, &mut report);
    let clips = clips::load(&accessors, &nodes, &mut report)?.into();
    Ok(LoadedGltf {
        file: file.to_owned(),
        meshes,
        materials,
        nodes,
        scenes,
        default_scene,
        lights,
        cameras,
        skins,
        clips,
        report,
    })
}
