//! The device, each optional feature that is asked for, and what is lost without it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use glam::UVec2;

/// Why there is no picture.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RenderError {
    /// No driver offers an adapter.
    #[error("no GPU adapter: {0} (a software Vulkan driver such as Mesa's lavapipe is enough)")]
    NoAdapter(String),
    /// The adapter refused a device.
    #[error("adapter {adapter} gave no device: {reason}")]
    NoDevice {
        /// The adapter's name.
        adapter: String,
        /// What it said.
        reason: String,
    },
    /// A shader does not compile.
    #[error("shader {name}: {reason}")]
    Shader {
        /// File of the shader.
        name: String,
        /// Where and why.
        reason: String,
    },
    /// The device was lost; make a new [`RenderContext`] and [`Renderer`](super::Renderer).
    #[error("the GPU device was lost")]
    DeviceLost,
    /// A view outside of its host's targets, or a projection that cannot be inverted.
    #[error(
        "a view of {viewport} pixels at {origin} does not lie in the targets of its host, of {target_size}, or its \
         projection cannot be inverted"
    )]
    HostView {
        /// Pixels.
        viewport: UVec2,
        /// Its upper left corner.
        origin: UVec2,
        /// Texels of the host's targets.
        target_size: UVec2,
    },
    /// A result could not be read back.
    #[error("reading back {what}: {reason}")]
    Readback {
        /// The texture or buffer.
        what: String,
        /// What wgpu said.
        reason: String,
    },
    /// Something is too large for the device.
    #[error("{what} needs {needed}, the device allows {limit}")]
    Limit {
        /// What is too large.
        what: &'static str,
        /// What it needs, bytes or texels.
        needed: u64,
        /// What there is.
        limit: u64,
    },
}

/// Which optional features to ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RequestedFeatures {
    /// `Depth32FloatStencil8`; without it depth has 24 bits, which is coarser far from the near plane.
    pub float_depth: bool,
    /// Blending into 32-bit floats; without it techniques that sum in floats take a form in bytes.
    pub float_blend: bool,
    /// GPU timers per pass; without them no GPU times are reported.
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
    /// Nothing beyond WebGPU's baseline.
    pub const BASELINE: Self = Self {
        float_depth: false,
        float_blend: false,
        timestamps: false,
    };
}

/// A device and its queue; cheap to clone.
#[derive(Clone, Debug)]
pub struct RenderContext {
    /// The device.
    pub device: wgpu::Device,
    /// Its queue.
    pub queue: wgpu::Queue,
    /// Name and driver of the adapter, for reports.
    pub adapter: String,
    /// Texels along the longer axis of a material texture's footprint, 1 to 16. 8 on GPUs, 1 on software adapters,
    /// where each costs its full price (and where Mesa 22.3's llvmpipe does not return from footprints without end).
    pub anisotropy: u16,
    lost: Arc<AtomicBool>,
}

impl RenderContext {
    /// A device of its own, without a window. wgpu's environment variables (`WGPU_BACKEND` and so on) are heard.
    ///
    /// # Errors
    /// [`RenderError::NoAdapter`] and [`RenderError::NoDevice`].
    pub async fn headless(requested: RequestedFeatures) -> Result<Self, RenderError> {
        let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle_from_env());
        let adapter = instance
            .request_adapter(&wgpu::RequestAdapterOptions {
                power_preference: wgpu::PowerPreference::HighPerformance,
                ..Default::default()
            })
            .await
            .map_err(|error| RenderError::NoAdapter(error.to_string()))?;
        let info = adapter.get_info();
        let mut features = wgpu::Features::empty();
        if requested.float_depth {
            features |= wgpu::Features::DEPTH32FLOAT_STENCIL8;
        }
        if requested.float_blend {
            features |= wgpu::Features::FLOAT32_BLENDABLE;
        }
        if requested.timestamps {
            features |= wgpu::Features::TIMESTAMP_QUERY;
        }
        let (device, queue) = adapter
            .request_device(&wgpu::DeviceDescriptor {
                label: Some("antumbra"),
                required_features: features & adapter.features(),
                required_limits: wgpu::Limits::default(),
                ..Default::default()
            })
            .await
            .map_err(|error| RenderError::NoDevice {
                adapter: info.name.clone(),
                reason: error.to_string(),
            })?;
        let adapter = format!("{} ({:?}, {})", info.name, info.backend, info.driver_info);
        let mut context = Self::from_device(device, queue, adapter);
        if info.device_type == wgpu::DeviceType::Cpu {
            context.anisotropy = 1;
        }
        Ok(context)
    }

    /// Renders with an engine's own device, and hears of its loss: the device's callback is taken. `adapter` is a name
    /// for reports.
    pub fn from_device(device: wgpu::Device, queue: wgpu::Queue, adapter: String) -> Self {
        let context = Self::hosted(device, queue, adapter);
        let flag = context.lost.clone();
        context
            .device
            .set_device_lost_callback(move |_, _| flag.store(true, Ordering::Release));
        context
    }

    /// Renders with the device of an engine that has its own callback for the loss of it, and says
    /// [`RenderContext::set_lost`] then. `adapter` is a name for reports.
    pub fn hosted(device: wgpu::Device, queue: wgpu::Queue, adapter: String) -> Self {
        Self {
            device,
            queue,
            adapter,
            anisotropy: 8,
            lost: Arc::new(AtomicBool::new(false)),
        }
    }

    /// Says that the device is gone.
    pub fn set_lost(&self) {
        self.lost.store(true, Ordering::Release);
    }

    /// Whether the device is gone; nothing that it held can be used again.
    pub fn is_lost(&self) -> bool {
        self.lost.load(Ordering::Acquire)
    }

    /// Asks the device whether it is gone; before a frame, as a loss is told only to those who poll. Does not wait.
    pub fn notice_loss(&self) -> bool {
        // An error says what the flag says.
        let _ = self.device.poll(wgpu::PollType::Poll);
        self.is_lost()
    }

    /// The combined depth and stencil format: with 32-bit float depth where the device has it.
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
