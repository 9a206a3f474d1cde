//! Composition of the WGSL files with naga_oil into plain modules.

use std::borrow::Cow;
use std::sync::Mutex;

use naga_oil::compose::{
    ComposableModuleDescriptor, Composer, ComposerError, NagaModuleDescriptor, ShaderLanguage, ShaderType,
};

use super::RenderError;

macro_rules! sources {
    ($($path:literal),* $(,)?) => {
        [$(($path, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/shaders/", $path)))),*]
    };
}

/// Imported files without entry points, each after those that it imports.
pub const COMMON: [(&str, &str); 12] = sources![
    "common/conventions.wgsl",
    "common/view.wgsl",
    "common/receiver.wgsl",
    "common/surface.wgsl",
    "common/brdf.wgsl",
    "common/area_light.wgsl",
    "common/light.wgsl",
    "common/mask.wgsl",
    "common/front.wgsl",
    "common/coverage.wgsl",
    "common/wedge_light.wgsl",
    "common/map.wgsl",
];

/// Files with entry points.
pub const PASSES: [(&str, &str); 17] = sources![
    "passes/ambient.wgsl",
    "passes/depth_copy.wgsl",
    "passes/full_screen.wgsl",
    "passes/host_depth.wgsl",
    "passes/light_accumulate.wgsl",
    "passes/light_begin.wgsl",
    "passes/light_function.wgsl",
    "passes/receiver_plane.wgsl",
    "passes/visibility.wgsl",
    "passes/tonemap.wgsl",
    "techniques/stencil_volume/volume.wgsl",
    "techniques/penumbra_wedge/wedge.wgsl",
    "techniques/penumbra_wedge/resolve.wgsl",
    "techniques/maps/caster.wgsl",
    "techniques/maps/convert.wgsl",
    "techniques/maps/frustum.wgsl",
    "techniques/maps/resolve.wgsl",
];

/// Composes shader modules from the crate's files and from those of third parties.
pub struct Shaders {
    composer: Mutex<Composer>,
}

impl std::fmt::Debug for Shaders {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Shaders").finish_non_exhaustive()
    }
}

impl Shaders {
    /// A composer that knows the [`COMMON`] files.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn new() -> Result<Self, RenderError> {
        let mut composer = Composer::default();
        for (path, source) in COMMON {
            let added = composer
                .add_composable_module(ComposableModuleDescriptor {
                    source,
                    file_path: path,
                    language: ShaderLanguage::Wgsl,
                    ..Default::default()
                })
                .map(|_| ());
            added.map_err(|error| shader_error(path, &error, &composer))?;
        }
        Ok(Self {
            composer: Mutex::new(composer),
        })
    }

    /// The whole module of one file, imports resolved.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn compose(&self, path: &str, source: &str) -> Result<wgpu::naga::Module, RenderError> {
        // A poisoned composer has lost nothing: each composition starts from the common modules.
        let mut composer = self
            .composer
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let module = composer.make_naga_module(NagaModuleDescriptor {
            source,
            file_path: path,
            shader_type: ShaderType::Wgsl,
            ..Default::default()
        });
        module.map_err(|error| shader_error(path, &error, &composer))
    }

    /// A wgpu module of one of [`PASSES`].
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place, or says that there is no such file.
    pub fn module(&self, device: &wgpu::Device, path: &str) -> Result<wgpu::ShaderModule, RenderError> {
        let (_, source) =
            PASSES
                .iter()
                .find(|(name, _)| *name == path)
                .ok_or_else(|| RenderError::Shader {
                    name: path.to_owned(),
                    reason: "there is no such file".to_owned(),
                })?;
        let module = self.compose(path, source)?;
        Ok(device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(path),
            source: wgpu::ShaderSource::Naga(Cow::Owned(module)),
        }))
    }
}

fn shader_error(path: &str, error: &ComposerError, composer: &Composer) -> RenderError {
    RenderError::Shader {
        name: path.to_owned(),
        reason: error.emit_to_string(composer),
    }
}
