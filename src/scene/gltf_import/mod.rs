//! glTF 2.0 import. A file becomes a [`LoadedGltf`] on the CPU, and a scene of it becomes entities.
//!
//! | step | file |
//! | --- | --- |
//! | GLB container, version | `container.rs` |
//! | JSON, and what is mended in it | `schema.rs` |
//! | extensions: supported, ignored, refused | `extensions.rs` |
//! | buffers from chunk, data URI, file | `buffers.rs` |
//! | buffer views, compressed ones, compressed primitives | `views.rs`, `meshopt.rs`, `draco.rs` |
//! | accessors, with bounds checked first | `accessors.rs`, `components.rs` |
//! | primitives to triangle lists, several to one mesh | `mesh.rs`, `vertices.rs`, `triangles.rs`, `incomplete.rs` |
//! | textures, their pictures | `texture.rs`, `images.rs` |
//! | materials, those of other models, computed textures | `material.rs`, `clearcoat.rs`, `specular_glossiness.rs`, `transmission.rs`, `vertex_alpha.rs`, `bake.rs` |
//! | node forest, lights, cameras, skins | `nodes.rs`, `transforms.rs`, `singular.rs`, `instancing.rs`, `scenes.rs` |
//! | cells, portals, occluders in extras | `cells.rs`, `cell_extras.rs` |
//! | animation clips | `clips.rs` |
//! | entities, reports about them | `spawn.rs`, `skin_winding.rs`, `reports.rs` |
//!
//! Content without a possible meaning is a [`GltfError`]. Content that the rest can do without is left out
//! and listed in the [`Report`]; a spawned scene raises its lines in the [`Reports`](crate::reports::Reports). Of the
//! `gltf` crate only the JSON schema is used, because its readers and its validation panic on some malformed files.
//!
//! # What is supported
//!
//! | part of a file | what becomes of it |
//! | --- | --- |
//! | GLB and JSON of glTF 2.x; buffers in the chunk, in data URIs, in files | loaded |
//! | triangle lists, strips and fans, indexed or not; sparse, quantised and normalised accessors | loaded |
//! | skins, morph targets, animations of nodes and weights | loaded |
//! | PNG and JPEG pictures, samplers, two sets of texture coordinates | loaded |
//! | `KHR_lights_punctual`, `KHR_materials_emissive_strength`, `KHR_materials_unlit`, `KHR_mesh_quantization`, `KHR_texture_transform` | loaded |
//! | `EXT_mesh_gpu_instancing` | an entity for each instance; a skinned mesh is drawn once, reported |
//! | `KHR_node_visibility` | hidden nodes get no mesh and no light; animations of it are reported |
//! | `KHR_materials_clearcoat` | loaded, but for its normal texture: the coat is as smooth as the mesh, reported |
//! | `KHR_materials_pbrSpecularGlossiness` | converted to metallic-roughness, textures texel by texel |
//! | `KHR_materials_transmission`, with `KHR_materials_ior` and `KHR_materials_volume` | blended by what passes, not refracted and not tinted; casts as blended surfaces do |
//! | `KHR_draco_mesh_compression` | loaded with the cargo feature `gltf-draco` (default) |
//! | `EXT_texture_webp` | loaded with the cargo feature `gltf-webp` (default) |
//! | `EXT_meshopt_compression`, `KHR_meshopt_compression` | loaded with the cargo feature `gltf-meshopt`, which needs a C++ compiler |
//! | `KHR_texture_basisu` | loaded with the cargo feature `gltf-basisu` |
//! | whole numbers written `24.0`, scenes that list children, unread buffers that are missing, undeclared extensions | loaded; what it changes is reported |
//! | points, lines, empty primitives, pictures that are missing or broken, third sets of coordinates | left out, reported |
//! | compressed data that is broken, and not required, beside the same data uncompressed; WebP and KTX2 pictures that are broken beside another picture | the other is loaded, reported |
//! | cameras, lights, animation channels, material numbers without a meaning | left out or clamped, reported |
//! | other extensions in `extensionsUsed`, such as `KHR_materials_specular`, `_sheen`, `_variants` | ignored, reported |
//! | other extensions in `extensionsRequired`; those above without their feature | an error that names the extension and the feature |
//! | glTF 1.0, broken JSON, indices out of range, forests that are none, data that runs past its end | an error that names the element |

mod accessors;
mod append_vertices;
mod bake;
mod buffers;
mod cell_extras;
mod cells;
mod clearcoat;
mod clips;
mod components;
mod container;
mod draco;
mod error;
mod extensions;
mod images;
mod incomplete;
mod instancing;
mod layers;
mod material;
mod mesh;
mod meshopt;
mod nodes;
mod report;
mod reports;
mod scenes;
mod schema;
mod singular;
mod skin_winding;
mod spawn;
mod specular_glossiness;
mod texture;
mod transforms;
mod transmission;
mod triangles;
mod vertex_alpha;
mod vertices;
mod views;

use std::path::{Path, PathBuf};
use std::sync::Arc;

pub use cell_extras::{GltfPortal, GltfVisibility};
pub use error::GltfError;
pub use extensions::SUPPORTED_EXTENSIONS;
pub use layers::{layer_of_name, meshes_of_name};
pub use mesh::GltfMesh;
pub use nodes::{GltfNode, GltfSkin, MAX_NODE_DEPTH};
pub use report::{Element, Report, Skip, SkipKind};
pub(crate) use reports::report_imports;
pub use scenes::GltfSceneRoots;
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
    let buffers = buffers::load(&document.root, document.binary_chunk, base_dir);
    let mut accessors = Accessors::new(file.to_owned(), &document.root, buffers, bytes.len());
    let decoded = draco::decode(&mut accessors, &mut report)?;

    let mut textures = Textures::new(&accessors, base_dir);
    let (materials, vertex_alpha) = material::load(&accessors, &mut textures, &mut report)?;
    let meshes = mesh::load(&accessors, (&materials, &vertex_alpha), &decoded, &mut report)?;
    let skins = nodes::load_skins(&accessors, &mut report)?;
    let mut nodes = nodes::load(&accessors, &meshes, &skins, &mut report)?;
    cells::load(&accessors, &mut nodes, &mut report);
    let (scenes, default_scene) = scenes::load(&accessors, &nodes, &mut report)?;
    let lights = nodes::load_lights(&accessors, &mut report);
    let cameras = nodes::load_cameras(&accessors, &mut report);
    let clips: Arc<[AnimationClip]> = clips::load(&accessors, &nodes, &mut report)?.into();
    singular::report(&nodes, &meshes, &clips, &mut report);
    report.skips.append(&mut accessors.uncompressed.take().skips);
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
