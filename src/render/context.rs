//! The device, the optional features that can be asked of it, and what is lost without each of them.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::UVec2;

/// The reason why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No driver offers an adapter. The field holds the reason that wgpu gave.
    #[error(
        "no GPU adapter: {0}. Install a Vulkan driver; Mesa's software driver is enough (Debian: apt-get install \
         libvulkan1 mesa-vulkan-drivers)"
    )]
    NoAdapter(String),
    /// No adapter has the name that the environment variable `WGPU_ADAPTER_NAME` asks for.
    #[error(
        "no GPU adapter is called {wanted} (WGPU_ADAPTER_NAME), there are: {known}. Name one of them, or install its \
         driver"
    )]
    UnknownAdapter {
        /// The value of the variable.
        wanted: String,
        /// The names of the adapters, separated by commas; `none` if there are none.
        known: String,
    },
    /// The adapter gave no device.
    #[error("adapter {adapter} gave no device: {reason}")]
    NoDevice {
        /// The name of the adapter.
        adapter: String,
        /// The reason that the adapter gave.
        reason: String,
    },
    /// A shader does not compile.
    #[error("shader {name}: {reason}")]
    Shader {
        /// The path of the shader's file.
        name: String,
        /// The place and the cause of the error in the shader.
        reason: String,
    },
    /// The device was lost. Make a new [`RenderContext`] and a new [`Renderer`](super::Renderer).
    #[error("the GPU device was lost")]
    DeviceLost,
    /// The view lies outside of its host's targets, or its projection cannot be inverted.
    #[error(
        "a view of {viewport} pixels at {origin} does not lie in the targets of its host, of {target_size}, or its \
         projection cannot be inverted"
    )]
    HostView {
        /// The size of the view, pixels.
        viewport: UVec2,
        /// The upper left corner of the view in the targets, pixels.
        origin: UVec2,
        /// The size of the host's targets, texels.
        target_size: UVec2,
    },
    /// A texture or a buffer could not be read back.
    #[error("reading back {what}: {reason}")]
    Readback {
        /// The name of the texture or buffer.
        what: String,
        /// The reason that wgpu gave.
        reason: String,
    },
    /// Something is too large for the device.
    #[error("{what} needs {needed}, the device allows {limit}")]
    Limit {
        /// The name of what is too large.
        what: &'static str,
        /// The size that it needs, bytes or texels.
        needed: u64,
        /// The largest size that the device allows, bytes or texels.
        limit: u64,
    },
}

/// The optional features of the device to ask for. A feature that the adapter lacks is left out without an
/// error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestedFeatures {
    /// Asks for the format `Depth32FloatStencil8`, true by default. Without it depth has 24 bits: it is
    /// coarser far from the near plane, and may take less memory.
    pub float_depth: bool,
    /// Asks for blending into 32-bit floats, and for up to 64 bytes of colour attachments a pixel; true by default. Without
    /// it, techniques that sum in floats sum in bytes instead, or in half floats if they sum by colour. Penumbra wedges then
    /// add up penumbrae that overlap, and err several times as much.
    pub float_blend: bool,
    /// Asks for timers of each pass on the GPU. The default is true with the crate's feature `profile`, else
    /// false. Without timers no GPU times are reported.
    pub timestamps: bool,
}

impl Default for RequestedFeatures {
    fn default() -> Self {
        Self {
            float_depth: true,
            float_blend: true,
            timestamps: cfg!(feature = "profile"),
        }
    }
}

impl RequestedFeatures {
    /// Asks for nothing beyond WebGPU's baseline.
    pub const BASELINE: Self = Self {
        float_depth: false,
        float_blend: false,
        timestamps: false,
    };

    /// Describes a device with those of the features that an adapter has, and with the limits that they need. An engine that
    /// makes its own device enables these, beside its own.
    pub fn descriptor(self, adapter: &wgpu::Adapter) -> wgpu::DeviceDescriptor<'static> {
        let mut features = wgpu::Features::empty();
        features.set(wgpu::Features::DEPTH32FLOAT_STENCIL8, self.float_depth);
        features.set(wgpu::Features::FLOAT32_BLENDABLE, self.float_blend);
        features.set(wgpu::Features::TIMESTAMP_QUERY, self.timestamps);
        // With sums of 64 bytes for a pixel, penumbra wedges place more samples on the light.
        let most_bytes = if self.float_blend { 64 } else { 32 };
        let bytes = adapter.limits().max_color_attachment_bytes_per_sample;
        wgpu::DeviceDescriptor {
            label: Some("antumbra"),
            required_features: features & adapter.features(),
            required_limits: wgpu::Limits {
                max_color_attachment_bytes_per_sample: bytes.clamp(32, most_bytes),
                ..wgpu::Limits::default()
            },
            ..Default::default()
        }
    }
}

/// A device and its queue. A clone is cheap and shares them.
#[derive(Clone, Debug)]
pub struct RenderContext {
    /// The wgpu device.
    pub device: wgpu::Device,
    /// The queue of the device.
    pub queue: wgpu::Queue,
    /// The name and the driver of the adapter, for reports.
    pub adapter: String,
    /// The largest anisotropy of material textures: the number of texels along the longer axis of a texture
    /// footprint, 1 to 16. Higher values keep textures sharper at grazing angles, and cost more texture
    /// fetches. The default is 8 on GPUs and 1 on software adapters, where each fetch costs its full price
    /// (and where Mesa 22.3's llvmpipe does not return from footprints without end).
    pub anisotropy: u16,
    lost: Arc<AtomicBool>,
}

impl RenderContext {
    /// Makes a device for this context alone, without a window. The adapter is that of [`RenderContext::adapter_for`].
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] if no driver offers an adapter, [`RenderError::UnknownAdapter`] if none has the
    /// name, [`RenderError::NoDevice`] if the adapter gives no device.
    pub async fn headless(requested: RequestedFeatures) -> Result<Self, RenderError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = Self::adapter_for(&instance, None).await?;
        Self::on_adapter(&adapter, requested).await
    }

    /// Chooses an adapter: the one that the environment variable `WGPU_ADAPTER_NAME` asks for by a part of its name, or
    /// else the fastest that draws on the surface, if there is one.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] if no driver offers an adapter, [`RenderError::UnknownAdapter`] if none has the
    /// name.
    pub async fn adapter_for(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
    ) -> Result<wgpu::Adapter, RenderError> {
        match std::env::var("WGPU_ADAPTER_NAME") {
            Ok(wanted) if !wanted.is_empty() => named_adapter(instance, wanted).await,
            _ => instance
                .request_adapter(&wgpu::RequestAdapterOptions {
                    power_preference: wgpu::PowerPreference::HighPerformance,
                    compatible_surface: surface,
                    ..Default::default()
                })
                .await
                .map_err(|error| RenderError::NoAdapter(error.to_string())),
        }
    }

    /// Makes a device of an adapter for this context alone.
    ///
    /// # Errors
    /// [`RenderError::NoDevice`] if the adapter gives no device.
    pub async fn on_adapter(
        adapter: &wgpu::Adapter,
        requested: RequestedFeatures,
    ) -> Result<Self, RenderError> {
        let info = adapter.get_info();
        let (device, queue) = adapter
            .request_device(&requested.descriptor(adapter))
            .await
            .map_err(|error| RenderError::NoDevice {
                adapter: info.name.clone(),
                reason: error.to_string(),
            })?;
        let name = format!("{} ({:?}, {})", info.name, info.backend, info.driver_info);
        Ok(Self::from_device(device, queue, name))
    }

    /// Makes a context on the device of an engine. It replaces the device's callback for its loss, to hear of
    /// the loss itself. `adapter` is a name for reports.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue, adapter: String) -> Self {
        let context = Self::hosted(device, queue, adapter);
        let flag = context.lost.clone();
        context
            .device
            .set_device_lost_callback(move |_, _| flag.store(true, Ordering::Release));
        context
    }

    /// Makes a context on the device of an engine that keeps its own callback for the device's loss. That
    /// engine calls [`RenderContext::set_lost`] when the device is lost. `adapter` is a name for reports.
    pub fn hosted(device: wgpu::Device, queue: wgpu::Queue, adapter: String) -> Self {
        Self {
            anisotropy: match device.adapter_info().device_type {
                wgpu::DeviceType::Cpu => 1,
                _ => 8,
            },
            device,
            queue,
            adapter,
            lost: Arc::new(AtomicBool::new(false)),
        }
    }

    /// Marks the device as lost.
    pub fn set_lost(&self) {
        self.lost.store(true, Ordering::Release);
    }

    /// Returns true if `other` is a clone of this context. (`wgpu::Device` cannot tell: devices of two instances may
    /// be equal.)
    pub fn is_clone_of(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.lost, &other.lost)
    }

    /// Returns whether the device is lost. Nothing that a lost device held can be used again.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Acquire)
    }

    /// Polls the device, and returns whether it is lost. Call it before a frame, because wgpu reports a loss
    /// only to those who poll. It does not wait.
    pub fn notice_loss(&self) -> bool {
        // An error of the poll adds nothing to the flag.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.is_lost()
    }

    /// The combined format of depth and stencil. It has 32-bit float depth where the device offers it.
    pub fn depth_stencil_format(&self) -> wgpu::TextureFormat {
        if self
            .device
            .features()
            .contains(wgpu::Features::DEPTH32FLOAT_STENCIL8)
        {
            wgpu::TextureFormat::Depth32FloatStencil8
        } else {
            wgpu::TextureFormat::Depth24PlusStencil8
        }
    }
}

/// Returns the first adapter whose name contains `wanted`, whatever the case of its letters.
async fn named_adapter(instance: &wgpu::Instance, wanted: String) -> Result<wgpu::Adapter, RenderError> {
    let adapters = instance.enumerate_adapters(wgpu::Backends::all()).await;
    let names: Vec<String> = adapters.iter().map(|adapter| adapter.get_info().name).collect();
    let is_wanted = |name: &String| name.to_lowercase().contains(&wanted.to_lowercase());
    let index = names.iter().position(is_wanted);
    match index.and_then(|index| adapters.into_iter().nth(index)) {
        Some(adapter) => Ok(adapter),
        None => Err(RenderError::UnknownAdapter {
            wanted,
            known: if names.is_empty() {
                "none".to_owned()
            } else {
                names.join(", ")
            },
        }),
    }
}
