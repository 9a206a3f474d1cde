//! glTF 2.0 import. A file becomes a [`LoadedGltf`] on the CPU, and a scene of it becomes entities.
//!
//! | step | file |
//! | --- | --- |
//! | GLB container, JSON, required extensions | `container.rs` |
//! | buffers from chunk, data URI, file | `buffers.rs` |
//! | accessors, with bounds checked first | `accessors.rs` |
//! | primitives to triangle lists, several to one mesh | `mesh.rs`, `vertices.rs`, `triangles.rs` |
//! | materials, textures | `material.rs`, `texture.rs` |
//! | node forest, lights, cameras, skins | `nodes.rs`, `transforms.rs` |
//! | cells, portals, occluders in extras | `cells.rs`, `cell_extras.rs` |
//! | animation clips | `clips.rs` |
//! | entities | `spawn.rs` |
//!
//! Content without a possible meaning is a [`GltfError`]. Content that the rest can do without is left out
//! and listed in the [`Report`]. Of the `gltf` crate only the JSON schema is used, because its readers and
//! its validation panic on some malformed files.

mod accessors;
mod buffers;
mod cell_extras;
mod cells;
mod clips;
mod container;
mod error;
mod layers;
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
pub use layers::layer_of_name;
pub use mesh::GltfMesh;
pub use nodes::{GltfNode, GltfSceneRoots, GltfSkin, MAX_NODE_DEPTH};
pub use report::{Element, Report, Skip, SkipKind};
pub use spawn::{SpawnedScene, spawn_scene};

use super::animation::AnimationClip;
use super::{Camera, Light, Material};
use accessors::Accessors;
use texture::Textures;

/// A glTF file on the CPU. Lists have the same indices as in the file.
#[derive(Clone, Debug)]
pub struct LoadedGltf {
    /// Path or name of the file, used in messages.
    pub file: PathBuf,
    /// Meshes with their materials.
    pub meshes: Vec<GltfMesh>,
    /// Materials of the file.
    pub materials: Vec<Arc<Material>>,
    /// Nodes of the file. They form a forest.
    pub nodes: Vec<GltfNode>,
    /// Scenes of the file; there is at least one.
    pub scenes: Vec<GltfSceneRoots>,
    /// Index of the scene to show first.
    pub default_scene: usize,
    /// Lights of `KHR_lights_punctual`.
    pub lights: Vec<Light>,
    /// Cameras of the file. `None` for a camera whose numbers make no projection.
    pub cameras: Vec<Option<Camera>>,
    /// Skins of the file.
    pub skins: Vec<GltfSkin>,
    /// Animation clips of the file.
    pub clips: Arc<[AnimationClip]>,
    /// Everything that was left out or repaired.
    pub report: Report,
}

impl LoadedGltf {
    /// Number of triangles of all meshes, counting each mesh once.
    pub fn triangle_count(&self) -> usize {
        self.meshes.iter().map(|mesh| mesh.data.triangle_count()).sum()
    }
}

/// Loads a `.glb` or `.gltf` file. Relative references to other files start at its folder.
///
/// # Errors
/// [`GltfError`] names the file and the element.
pub fn load_gltf(path: impl AsRef<Path>) -> Result<LoadedGltf, GltfError> {
    let path = path.as_ref();
    let read = || {
        // Reading a pipe or a device might never end.
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

/// Loads GLB or glTF JSON from memory. External files are looked for in `base_dir`; messages call the file
/// `name`.
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
