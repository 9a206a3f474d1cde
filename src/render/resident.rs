//! What lives long on the GPU, and is shared by all views of a device.

use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

use super::gpu::bind_groups::BindGroupLayouts;
use super::gpu::pipeline_cache::{PipelineCache, PipelineDesc, Variants};
use super::pools::materials::SharedMaterials;
use super::pools::meshes::SharedMeshes;
use super::{RenderContext, RenderError, Shaders};

/// The device, and everything on it that no frame changes: shaders, layouts, pipelines, meshes and materials.
///
/// Views share it by an `Arc` ([`Renderer::on`](super::Renderer::on)). What a view holds of it are handles, so recording
/// takes no lock; a lock is taken where something new is made.
pub struct Gpu {
    /// The device.
    pub context: RenderContext,
    /// Shader composition.
    pub shaders: Shaders,
    /// The layouts that passes share.
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
    /// Compiles nothing yet: shaders come with the first pass that needs them.
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

    /// The pipeline of a description, made on first use by any view.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn pipeline(&self, desc: PipelineDesc) -> Result<wgpu::RenderPipeline, RenderError> {
        self.pipelines.pipeline(&self.context, &self.shaders, desc)
    }

    /// Composes the shader files of these stages, so that a fault in them shows before the first frame.
    ///
    /// # Errors
    /// [`RenderError::Shader`] names the file and the place.
    pub fn compile(&self, files: &[&'static str]) -> Result<(), RenderError> {
        for file in files {
            self.pipelines.module(&self.context, &self.shaders, file)?;
        }
        Ok(())
    }

    /// Gives a recorder the pipeline of a key, described only where the recorder does not have it yet.
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

    /// A part of a technique that no frame changes (layouts, constant buffers and textures): made on first use, and then
    /// the same for all views. `T` is its key.
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
        // Made without the lock, for a part may be made of another; of two that are made at once the first stays.
        let made = Arc::new(make(self));
        let mut parts = lock();
        known(&parts).unwrap_or_else(|| {
            parts.insert(TypeId::of::<T>(), made.clone());
            made
        })
    }

    /// The number of bytes that meshes take on the device, those of poses included.
    pub fn mesh_bytes(&self) -> u64 {
        self.meshes.bytes()
    }

    /// The number of pipelines made so far for all views; it does not grow in a steady frame.
    pub fn pipeline_count(&self) -> usize {
        self.pipelines.count()
    }
}
