//! Materials on the GPU.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use glam::Affine2;
use smallvec::SmallVec;
use wgpu::util::DeviceExt;

use super::gpu_types;
use super::textures::{TEXTURE_COUNT, Textures, slots, texture_descriptor, whole_texture};
use crate::conventions::RADIANCE_MAX;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::render::gpu::slots::Slots;
use crate::render::{Gpu, RenderContext};
use crate::scene::{AlphaMode, Material, Texture, TextureSlot};

/// A texture that a host has on the device. It takes the place of a material's own base colour texture.
#[derive(Clone, Debug)]
pub struct HostTexture {
    /// The view of a 2D texture, whose format can be filtered.
    pub view: wgpu::TextureView,
    /// The sampler; it does not compare.
    pub sampler: wgpu::Sampler,
    /// Which set of texture coordinates is used: 0 or 1.
    pub uv_set: u32,
    /// Transform of the texture coordinates, applied before sampling.
    pub uv_transform: Affine2,
}

/// A material that is ready to be bound.
#[derive(Debug)]
pub struct GpuMaterial {
    /// The bind group 2 of drawn surfaces.
    pub bind_group: wgpu::BindGroup,
    /// Keeps the material alive, so that no other material can have its address.
    _source: Arc<Material>,
}

/// The largest scale of a normal texture. At a greater scale its normals would lie in the surface to within a
/// thousandth.
const STEEPEST: f32 = 1e3;

/// The materials that views hold, and their textures and samplers.
#[derive(Debug)]
pub struct SharedMaterials {
    white: wgpu::TextureView,
    known: Mutex<Known>,
}

#[derive(Debug, Default)]
struct Known {
    /// The materials by their addresses. Each entry keeps its material alive.
    materials: HashMap<usize, Weak<GpuMaterial>>,
    /// The base colour textures that a host has given materials, by the materials' addresses. The weak
    /// pointer keeps the address from being used again.
    hosted: HashMap<usize, (Weak<Material>, HostTexture)>,
    textures: Textures,
}

impl SharedMaterials {
    /// Makes a store without materials.
    pub fn new(context: &RenderContext) -> Self {
        let white = context.device.create_texture_with_data(
            &context.queue,
            &texture_descriptor("white", 1, 1, 1, wgpu::TextureFormat::Rgba8Unorm),
            wgpu::wgt::TextureDataOrder::LayerMajor,
            &[255; 4],
        );
        Self {
            white: white.create_view(&Default::default()),
            known: Mutex::default(),
        }
    }

    fn known(&self) -> MutexGuard<'_, Known> {
        self.known.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes a texture of the host the base colour texture of a material. Returns `false`, and changes nothing,
    /// if the material is on the device already. The host must then use another material.
    pub fn host(&self, material: &Arc<Material>, texture: HostTexture) -> bool {
        let mut known = self.known();
        let address = Arc::as_ptr(material) as usize;
        if known
            .materials
            .get(&address)
            .is_some_and(|known| known.strong_count() > 0)
        {
            return false;
        }
        known.hosted.insert(address, (Arc::downgrade(material), texture));
        true
    }

    fn get(&self, gpu: &Gpu, material: &Arc<Material>) -> Arc<GpuMaterial> {
        let address = Arc::as_ptr(material) as usize;
        let find = |known: &Known| known.materials.get(&address).and_then(Weak::upgrade);
        let missing = {
            let known = self.known();
            if let Some(found) = find(&known) {
                return found;
            }
            known.textures.missing(material)
        };
        // Textures are made without the lock: while threads make mipmaps, this one may run another view's system, which
        // asks for materials, too.
        let made: SmallVec<[_; TEXTURE_COUNT]> = missing
            .iter()
            .map(|missing| missing.upload(&gpu.context))
            .collect();
        let mut known = self.known();
        made.into_iter()
            .for_each(|texture| known.textures.insert(texture));
        if let Some(found) = find(&known) {
            return found;
        }
        let made = Arc::new(known.upload(&gpu.context, &gpu.layouts.material, &self.white, material));
        known.materials.insert(address, Arc::downgrade(&made));
        made
    }

    /// Calls `visit` with each texture on the device, in no order.
    pub fn for_each_texture(&self, visit: impl FnMut(&Texture)) {
        self.known().textures.iter().for_each(visit);
    }

    /// Removes the materials and textures that no view holds.
    fn forget_unused(&self) {
        let mut known = self.known();
        known.materials.retain(|_, material| material.strong_count() > 0);
        known
            .hosted
            .retain(|_, (material, _)| material.strong_count() > 0);
        known.textures.forget_unused();
    }
}

/// The materials that one view uses, by index.
#[derive(Debug, Default)]
pub struct MaterialPool {
    /// The materials by their addresses. Each entry keeps its material alive.
    slots: Slots<usize, Arc<GpuMaterial>>,
}

impl MaterialPool {
    /// The material at `index`, if it is in use.
    pub fn get(&self, index: u32) -> Option<&GpuMaterial> {
        self.slots.get(index).map(Arc::as_ref)
    }

    /// Begins a new count of the materials in use.
    pub fn begin(&mut self) {
        self.slots.begin();
    }

    /// Frees the materials that were not requested since [`MaterialPool::begin`].
    pub fn end(&mut self, gpu: &Gpu) {
        self.slots.end();
        gpu.materials.forget_unused();
    }

    /// Frees the materials that are not among `indices`.
    pub fn keep(&mut self, gpu: &Gpu, indices: impl Iterator<Item = u32>) {
        self.slots.keep(indices);
        gpu.materials.forget_unused();
    }

    /// Returns the index of a material. The material is uploaded if no view has it yet.
    pub fn acquire(&mut self, gpu: &Gpu, material: &Arc<Material>) -> u32 {
        let address = Arc::as_ptr(material) as usize;
        if let Some(index) = self.slots.acquire(address, |_| true) {
            return index;
        }
        self.slots.insert(address, gpu.materials.get(gpu, material))
    }
}

impl Known {
    fn upload(
        &mut self,
        context: &RenderContext,
        layout: &wgpu::BindGroupLayout,
        white: &wgpu::TextureView,
        material: &Arc<Material>,
    ) -> GpuMaterial {
        let hosted = self.hosted.get(&(Arc::as_ptr(material) as usize));
        let hosted = hosted.map(|(_, texture)| texture.clone());
        let mut constants = constants(material);
        if let Some(texture) = &hosted {
            constants.base_color_slot = present_slot(texture.uv_set, texture.uv_transform);
        }
        let buffer = context
            .device
            .create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some(&material.name),
                contents: bytemuck::bytes_of(&constants),
                usage: wgpu::BufferUsages::UNIFORM,
            });
        let slots = slots(material);
        let mut views: Vec<_> = slots
            .iter()
            .map(|&(slot, encoding)| {
                self.textures
                    .view(slot, encoding)
                    .unwrap_or_else(|| white.clone())
            })
            .collect();
        let mut samplers: Vec<_> = slots
            .iter()
            .map(|&(slot, _)| self.textures.sampler(context, slot.as_ref()))
            .collect();
        if let Some(texture) = hosted {
            (views[0], samplers[0]) = (texture.view, texture.sampler);
        }
        let textures = views.iter().zip(&samplers).flat_map(|(view, sampler)| {
            [
                wgpu::BindingResource::TextureView(view),
                wgpu::BindingResource::Sampler(sampler),
            ]
        });
        let resources = std::iter::once(buffer.as_entire_binding()).chain(textures);
        GpuMaterial {
            bind_group: bind_in_order(&context.device, &material.name, layout, resources),
            _source: material.clone(),
        }
    }
}

/// Returns the constants of a texture. A transform that is not finite becomes the identity.
fn present_slot(uv_set: u32, uv_transform: Affine2) -> gpu_types::Slot {
    let uv_transform = if uv_transform.is_finite() {
        uv_transform
    } else {
        Affine2::IDENTITY
    };
    let [x, y] = [uv_transform.matrix2.x_axis, uv_transform.matrix2.y_axis];
    gpu_types::Slot {
        uv_matrix: [x.x, x.y, y.x, y.y],
        uv_offset: uv_transform.translation.to_array(),
        uv_set,
        present: 1,
    }
}

/// Share by which the shaders' cutoff of a mask is lower than the material's. The interpolation of equal vertex colours
/// rounds, and a surface whose alpha is the cutoff would have holes where it rounds down. Rounding is some 10⁻⁷, and 8-bit
/// alphas are 4 · 10⁻³ apart.
const CUTOFF_ROUNDING: f32 = 1e-4;

fn constants(material: &Material) -> gpu_types::Material {
    let slot = |slot: &Option<TextureSlot>| match slot.as_ref().filter(|_| whole_texture(slot).is_some()) {
        None => gpu_types::Slot {
            uv_matrix: [1.0, 0.0, 0.0, 1.0],
            ..Default::default()
        },
        Some(slot) => present_slot(slot.uv_set, slot.uv_transform),
    };
    // NaN has no nearest allowed number, so it takes the default.
    let within = |x: f32, least: f32, most: f32, default: f32| {
        if x.is_nan() { default } else { x.clamp(least, most) }
    };
    gpu_types::Material {
        base_color: material.base_color.to_array().map(|x| within(x, 0.0, 1.0, 0.0)),
        emissive: material
            .emissive
            .to_array()
            .map(|x| within(x, 0.0, RADIANCE_MAX, 0.0)),
        alpha_cutoff: match material.alpha_mode {
            AlphaMode::Mask(cutoff) => within(cutoff, 0.0, 2.0, 0.5) * (1.0 - CUTOFF_ROUNDING),
            _ => 0.0,
        },
        metallic: within(material.metallic, 0.0, 1.0, 1.0),
        roughness: within(material.roughness, 0.0, 1.0, 1.0),
        normal_scale: within(material.normal_scale, -STEEPEST, STEEPEST, 1.0),
        occlusion_strength: within(material.occlusion_strength, 0.0, 1.0, 1.0),
        unlit: u32::from(material.unlit),
        opaque: u32::from(material.alpha_mode == AlphaMode::Opaque),
        base_color_slot: slot(&material.base_color_texture),
        metallic_roughness_slot: slot(&material.metallic_roughness_texture),
        normal_slot: slot(&material.normal_texture),
        occlusion_slot: slot(&material.occlusion_texture),
        emissive_slot: slot(&material.emissive_texture),
        clearcoat: within(material.clearcoat, 0.0, 1.0, 0.0),
        clearcoat_roughness: within(material.clearcoat_roughness, 0.0, 1.0, 0.0),
        clearcoat_slot: slot(&material.clearcoat_texture),
        clearcoat_roughness_slot: slot(&material.clearcoat_roughness_texture),
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;
    use std::time::Duration;

    use bevy_tasks::{ComputeTaskPool, TaskPool};

    use super::*;
    use crate::render::RequestedFeatures;

    fn square(side: u32) -> Arc<Texture> {
        Arc::new(Texture {
            name: "grey".to_owned(),
            width: side,
            height: side,
            rgba8: vec![128; (4 * side * side) as usize],
            wrap: Default::default(),
            linear_magnify: true,
            linear_minify: true,
        })
    }

    fn slot(texture: Arc<Texture>) -> Option<TextureSlot> {
        Some(TextureSlot {
            texture,
            uv_set: 0,
            uv_transform: Affine2::IDENTITY,
        })
    }

    fn gpu() -> Gpu {
        let context = pollster::block_on(RenderContext::headless(RequestedFeatures::default()));
        Gpu::new(context.expect("a GPU adapter is needed")).expect("shaders compose")
    }

    #[test]
    fn textures_that_no_material_holds_are_freed_even_those_read_in_two_ways() {
        let gpu = gpu();
        let mut pool = MaterialPool::default();
        // Base colour and occlusion are read as colours and as numbers; normals and occlusion both as numbers.
        for (views, color) in [(2, true), (1, false)] {
            let texture = square(4);
            let (weak, of_texture) = (Arc::downgrade(&texture), slot(texture));
            let material = Arc::new(Material {
                base_color_texture: of_texture.clone().filter(|_| color),
                normal_texture: of_texture.clone().filter(|_| !color),
                occlusion_texture: of_texture,
                ..Material::default()
            });
            pool.begin();
            pool.acquire(&gpu, &material);
            drop(material);
            pool.end(&gpu);
            assert_eq!(gpu.materials.known().textures.count(), views, "the view holds it");
            pool.begin();
            pool.end(&gpu);
            assert_eq!(gpu.materials.known().textures.count(), 0);
            assert_eq!(weak.strong_count(), 0);
        }
    }

    #[test]
    fn tasks_that_wait_for_mipmaps_run_others_that_ask_for_materials() {
        let (done, all_done) = channel();
        std::thread::spawn(move || {
            let gpu = gpu();
            let materials: Vec<Arc<Material>> = (0..16)
                .map(|_| {
                    Arc::new(Material {
                        // Mipmaps of this size are made on several threads.
                        base_color_texture: slot(square(512)),
                        ..Material::default()
                    })
                })
                .collect();
            let pool = ComputeTaskPool::get_or_init(TaskPool::default);
            let made = pool.scope(|scope| {
                for material in &materials {
                    scope.spawn(async { gpu.materials.get(&gpu, material) });
                }
            });
            let _ = done.send(made.len());
        });
        assert_eq!(all_done.recv_timeout(Duration::from_secs(60)), Ok(16));
    }
}
