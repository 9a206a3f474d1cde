//! Composition of the WGSL files with naga_oil into plain modules.

use std::borrow::Cow;
use std::sync::{Mutex, MutexGuard, PoisonError};

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderLanguage, ShaderType,
};

use super::RenderError;

/// One WGSL file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShaderFile {
    /// The path of the file below the folder `shaders`, for messages and for [`Shaders::module`].
    pub path: &'static str,
    /// The text of the file.
    pub source: &'static str,
}

impl ShaderFile {
    /// Returns whether other files import this one. An imported file has no entry points.
    pub fn is_imported(&self) -> bool {
        let defines = |line: &str| line.trim_start().starts_with("#define_import_path");
        self.source.lines().any(defines)
    }
}

/// Lists files of the folder `shaders` with their texts.
macro_rules! shader_files {
    ($($path:literal),* $(,)?) => {
        &[$($crate::render::shaders::ShaderFile {
            path: $path,
            source: include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $path)),
        }),*]
    };
}
pub(crate) use shader_files;

/// The files of the renderer, each after the files that it imports. The files of techniques are added with
/// the techniques.
pub const FILES: &[ShaderFile] = shader_files![
    "common/conventions.wgsl",
    "common/view.wgsl",
    "common/receiver.wgsl",
    "common/surface.wgsl",
    "common/brdf.wgsl",
    "common/area_light.wgsl",
    "common/angles.wgsl",
    "common/light_shape.wgsl",
    "common/light_texture.wgsl",
    "common/light.wgsl",
    "common/coat.wgsl",
    "common/mask.wgsl",
    "common/factors.wgsl",
    "common/front.wgsl",
    "passes/ambient.wgsl",
    "passes/darker_mask.wgsl",
    "passes/depth_copy.wgsl",
    "passes/full_screen.wgsl",
    "passes/host_depth.wgsl",
    "passes/host_weights.wgsl",
    "passes/keep_visibility.wgsl",
    "passes/light_accumulate.wgsl",
    "passes/light_begin.wgsl",
    "passes/light_function.wgsl",
    "passes/light_modelled.wgsl",
    "passes/light_model.wgsl",
    "passes/light_texture.wgsl",
    "passes/receiver_plane.wgsl",
    "passes/visibility.wgsl",
    "passes/tonemap.wgsl",
];

/// Composes shader modules from the crate's files and from those of third parties.
pub struct Shaders {
    known: Mutex<Known>,
}

#[derive(Default)]
struct Known {
    composer: Composer,
    files: Vec<ShaderFile>,
}

impl std::fmt::Debug for Shaders {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shaders").finish_non_exhaustive()
    }
}

impl Shaders {
    /// Makes a composer that knows the `FILES` of the renderer.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new() -> Result<Self, RenderError> {
        let shaders = Self {
            known: Mutex::default(),
        };
        shaders.add(FILES)?;
        Ok(shaders)
    }

    /// Makes files known, each after the files that it imports. A file that is known already is not replaced.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn add(&self, files: &[ShaderFile]) -> Result<(), RenderError> {
        let Known {
            composer,
            files: known,
        } = &mut *self.lock();
        for file in files {
            if known.iter().any(|known| known.path == file.path) {
                continue;
            }
            if file.is_imported() {
                let added = composer
                    .add_composable_module(ComposableModuleDescriptor {
                        source: file.source,
                        file_path: file.path,
                        language: ShaderLanguage::Wgsl,
                        ..Default::default()
                    })
                    .map(|_| ());
                added.map_err(|error| shader_error(file.path, &error, composer))?;
            }
            known.push(*file);
        }
        Ok(())
    }

    /// Composes the whole module of one file, with all imports resolved.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn compose(&self, path: &str, source: &str) -> Result<wgpu::naga::Module, RenderError> {
        let composer = &mut self.lock().composer;
        let module = composer.make_naga_module(NagaModuleDescriptor {
            source,
            file_path: path,
            shader_type: ShaderType::Wgsl,
            ..Default::default()
        });
        module.map_err(|error| shader_error(path, &error, composer))
    }

    /// Makes the wgpu module of a known file with entry points.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place, or says that there is no such file.
    pub fn module(&self, device: &wgpu::Device, path: &str) -> Result<wgpu::ShaderModule, RenderError> {
        let file = self.lock().files.iter().copied().find(|file| file.path == path);
        let file = file.ok_or_else(|| RenderError::Shader {
            name: path.to_owned(),
            reason: "there is no such file".to_owned(),
        })?;
        let module = self.compose(path, file.source)?;
        Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(path),
            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
        }))
    }

    fn lock(&self) -> MutexGuard<'_, Known> {
        // A poisoned composer has lost nothing: each composition starts from the imported files.
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn shader_error(path: &str, error: &ComposerError, composer: &Composer) -> RenderError {
    RenderError::Shader {
        name: path.to_owned(),
        reason: error.emit_to_string(composer),
    }
}
