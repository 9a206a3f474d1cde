//! The long-lived part of the GPU, which all views of a device share.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::gpu::bind_groups::BindGroupLayouts;
use super::gpu::pipeline_cache::{PipelineCache, PipelineDesc, Variants};
use super::pools::materials::{HostTexture, SharedMaterials};
use super::pools::meshes::SharedMeshes;
use super::{RenderContext, RenderError, Shaders};
use crate::scene::Material;

/// The device, and everything on the device that no frame changes: shaders, layouts, pipelines, meshes and
/// materials.
///
/// Views share it by an `Arc` ([`Renderer::on`](super::Renderer::on)). A view holds handles into it, so
/// recording takes no lock. A lock is taken only where something new is made.
pub struct Gpu {
    /// The device and its queue.
    pub context: RenderContext,
    /// The composer of shader modules.
    pub shaders: Shaders,
    /// The bind group layouts that passes share.
    pub layouts: BindGroupLayouts,
    /// The pipelines of all passes and techniques.
    pub pipelines: PipelineCache,
    pub(in crate::render) meshes: SharedMeshes,
    pub(in crate::render) materials: SharedMaterials,
    parts: Mutex<HashMap<TypeId, Arc<dyn Any + Send + Sync>>>,
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gpu")
            .field("context", &self.context)
            .field("pipelines", &self.pipelines)
            .finish_non_exhaustive()
    }
}

impl Gpu {
    /// Makes the long-lived part of a device. It compiles nothing yet: shaders are compiled with the first
    /// pass that needs them.
    ///
    /// # Errors
    /// [`RenderError::Shader`] if a shader that others import does not compose.
    pub fn new(context: RenderContext) -> Result<Self, RenderError> {
        Ok(Self {
            shaders: Shaders::new()?,
            layouts: BindGroupLayouts::new(&context.device),
            pipelines: PipelineCache::default(),
            meshes: SharedMeshes::default(),
            materials: SharedMaterials::new(&context),
            parts: Mutex::default(),
            context,
        })
    }

    /// Returns the pipeline of a description. It is made when a view first asks for it.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn pipeline(&self, desc: PipelineDesc) -> Result<wgpu::RenderPipeline, RenderError> {
        self.pipelines.pipeline(&self.context, &self.shaders, desc)
    }

    /// Composes these shader files now, so that an error in one of them shows before the first frame.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn compile(&self, files: &[&'static str]) -> Result<(), RenderError> {
        for file in files {
            self.pipelines.module(&self.context, &self.shaders, file)?;
        }
        Ok(())
    }

    /// Gives a recorder the pipeline of a key. `describe` is called only if the recorder does not have the
    /// pipeline yet.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn require<K: Copy + PartialEq>(
        &self,
        variants: &mut Variants<K>,
        key: K,
        describe: impl FnOnce(&Self) -> PipelineDesc,
    ) -> Result<(), RenderError> {
        if variants.get(key).is_none() {
            variants.insert(key, self.pipeline(describe(self))?);
        }
        Ok(())
    }

    /// Returns a part of a technique that no frame changes, such as layouts, constant buffers and textures.
    /// The part is made on first use, and is then the same for all views. The type `T` is its key.
    pub fn part<T: Any + Send + Sync>(&self, make: impl FnOnce(&Self) -> T) -> Arc<T> {
        let known = |parts: &HashMap<TypeId, Arc<dyn Any + Send + Sync>>| {
            parts
                .get(&TypeId::of::<T>())
                .and_then(|part| part.clone().downcast::<T>().ok())
        };
        let lock = || self.parts.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(part) = known(&lock()) {
            return part;
        }
        // The part is made without the lock, because a part may need another part. If two threads make the
        // same part at once, the first one stays.
        let made = Arc::new(make(self));
        let mut parts = lock();
        known(&parts).unwrap_or_else(|| {
            parts.insert(TypeId::of::<T>(), made.clone());
            made
        })
    }

    /// Makes a texture that the host has on the device the base colour texture of a material. Its alpha then
    /// cuts holes into the shadows of casters with that material, under techniques that draw maps. Call it
    /// before a view uses the material. Returns `false`, and changes nothing, if a view uses it already; the
    /// host must then give its objects another material.
    pub fn host_texture(&self, material: &Arc<Material>, texture: HostTexture) -> bool {
        self.materials.host(material, texture)
    }

    /// The number of bytes that meshes and their poses take on the device.
    pub fn mesh_bytes(&self) -> u64 {
        self.meshes.bytes()
    }

    /// The number of pipelines made so far for all views. It does not grow in a steady frame.
    pub fn pipeline_count(&self) -> usize {
        self.pipelines.count()
    }
}
