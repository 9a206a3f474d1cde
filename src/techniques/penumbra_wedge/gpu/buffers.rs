//! The textures in which visibility is summed, and the report of overflow.

use std::sync::{Arc, Mutex, PoisonError};

use glam::UVec2;

use super::form::Form;
use super::pipelines::COMBINED_FORMAT;
use crate::render::frame::targets::create_target;
use crate::render::gpu::bind_groups::buffer_entry;
use crate::render::{Gpu, RenderContext, RenderError};

/// The textures of one form.
#[derive(Debug)]
pub struct Sums {
    /// The form of the textures, which is their number and format.
    pub form: Form,
    /// The views of the textures: one or two for each layer, the facing layer first, then the averted one.
    /// Some forms have one texture for both layers.
    pub views: Vec<wgpu::TextureView>,
    /// The bind groups for group 3 of the resolve, one for each of the two combined textures that it may
    /// read.
    pub groups: [wgpu::BindGroup; 2],
}

/// The layout of [`Sums::groups`], which all views share.
#[derive(Debug)]
struct SumLayout(wgpu::BindGroupLayout);

fn sum_layout(device: &wgpu::Device) -> wgpu::BindGroupLayout {
    let fragment = wgpu::ShaderStages::FRAGMENT;
    let texture = |binding| wgpu::BindGroupLayoutEntry {
        binding,
        visibility: fragment,
        ty: wgpu::BindingType::Texture {
            sample_type: wgpu::TextureSampleType::Float { filterable: false },
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    };
    let storage = wgpu::BufferBindingType::Storage { read_only: false };
    device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
        label: Some("visibility sums"),
        entries: &[
            texture(0),
            texture(1),
            texture(2),
            texture(4),
            texture(5),
            buffer_entry(3, fragment, storage, false, 4),
        ],
    })
}

/// All textures of one frame size.
#[derive(Debug)]
pub struct SumTextures {
    size: UVec2,
    all: Vec<Sums>,
    combined: Option<[wgpu::TextureView; 2]>,
    layout: Arc<SumLayout>,
    overflow: OverflowReport,
}

impl SumTextures {
    /// Makes a store without textures.
    pub fn new(gpu: &Gpu) -> Self {
        Self {
            size: UVec2::ZERO,
            all: Vec::new(),
            combined: None,
            layout: gpu.part(|gpu| SumLayout(sum_layout(&gpu.context.device))),
            overflow: OverflowReport::new(&gpu.context),
        }
    }

    /// The layout of [`Sums::groups`].
    pub fn layout(&self) -> &wgpu::BindGroupLayout {
        &self.layout.0
    }

    /// The report of overflow.
    pub fn overflow(&self) -> &OverflowReport {
        &self.overflow
    }

    /// Returns the textures of a form, if [`SumTextures::require`] has made them.
    pub fn get(&self, form: Form) -> Option<&Sums> {
        self.all.iter().find(|sums| sums.form == form)
    }

    /// The two textures that take turns to hold the combined coverage.
    pub fn combined(&self) -> Option<&[wgpu::TextureView; 2]> {
        self.combined.as_ref()
    }

    /// Makes the textures of a form that are missing at this size, and drops textures of another size.
    ///
    /// # Errors
    /// [`RenderError::Limit`] beyond the device's largest texture.
    pub fn require(&mut self, context: &RenderContext, size: UVec2, form: Form) -> Result<(), RenderError> {
        if size != self.size {
            self.all.clear();
            self.combined = None;
            self.size = size;
        }
        if self.get(form).is_some() {
            return Ok(());
        }
        let view = |label, format| -> Result<_, RenderError> {
            let texture = create_target(context, label, size, format)?;
            Ok(texture.create_view(&Default::default()))
        };
        if self.combined.is_none() {
            self.combined = Some([
                view("combined coverage", COMBINED_FORMAT)?,
                view("combined coverage", COMBINED_FORMAT)?,
            ]);
        }
        let views = form
            .formats()
            .iter()
            .map(|&format| view("visibility sums", format))
            .collect::<Result<Vec<_>, _>>()?;
        let Some(combined) = &self.combined else {
            return Ok(());
        };
        // A form with one layer is read as both layers.
        let (averted, second) = form.averted_and_second();
        let groups = [0, 1].map(|source: usize| {
            let texture = |binding, view| wgpu::BindGroupEntry {
                binding,
                resource: wgpu::BindingResource::TextureView(view),
            };
            context.device.create_bind_group(&wgpu::BindGroupDescriptor {
                label: Some("visibility sums"),
                layout: &self.layout.0,
                entries: &[
                    texture(0, &views[0]),
                    texture(1, &views[second]),
                    texture(4, &views[averted]),
                    texture(5, &views[averted + second]),
                    texture(2, &combined[source]),
                    wgpu::BindGroupEntry {
                        binding: 3,
                        resource: self.overflow.counter.as_entire_binding(),
                    },
                ],
            })
        });
        self.all.push(Sums { form, views, groups });
        Ok(())
    }
}

/// Counts the pixels whose bytes overflowed, and reads the count back some frames later without waiting for
/// the GPU.
#[derive(Debug)]
pub struct OverflowReport {
    counter: wgpu::Buffer,
    staging: wgpu::Buffer,
    state: SharedState,
}

/// The progress of one copy of the count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    /// There is no copy.
    Idle,
    /// The copy is recorded, and perhaps submitted. Its buffer may not be mapped before it is done, because a
    /// mapped buffer cannot be submitted.
    Recorded,
    /// The GPU has copied.
    Copied,
    Mapping,
    Mapped,
    /// The buffer cannot be mapped, because the device is lost. Nothing is counted any more.
    Lost,
}

/// The state that is shared with the callbacks of wgpu.
#[derive(Clone, Debug)]
struct SharedState(Arc<Mutex<State>>);

impl SharedState {
    fn get(&self) -> State {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, state: State) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = state;
    }
}

/// A copy that is recorded. Dropping it allows another copy, as with an encoder that is never submitted.
struct RecordedCopy {
    state: SharedState,
    then: State,
}

impl RecordedCopy {
    fn finish(mut self) {
        self.then = State::Copied;
    }
}

impl Drop for RecordedCopy {
    fn drop(&mut self) {
        self.state.set(self.then);
    }
}

impl OverflowReport {
    fn new(context: &RenderContext) -> Self {
        let buffer = |label, usage| {
            context.device.create_buffer(&wgpu::BufferDescriptor {
                label: Some(label),
                size: 4,
                usage,
                mapped_at_creation: false,
            })
        };
        use wgpu::BufferUsages as Usage;
        Self {
            counter: buffer(
                "overflowing pixels",
                Usage::STORAGE | Usage::COPY_SRC | Usage::COPY_DST,
            ),
            staging: buffer("overflowing pixels, read", Usage::MAP_READ | Usage::COPY_DST),
            state: SharedState(Arc::new(Mutex::new(State::Idle))),
        }
    }

    /// Records the copy of the frame's count, if the last copy was read, and restarts the count.
    pub fn record(&self, encoder: &mut wgpu::CommandEncoder) {
        if self.state.get() == State::Idle {
            encoder.copy_buffer_to_buffer(&self.counter, 0, &self.staging, 0, 4);
            encoder.clear_buffer(&self.counter, 0, None);
            self.state.set(State::Recorded);
            // wgpu drops this closure without calling it if the encoder is never submitted.
            let copy = RecordedCopy {
                state: self.state.clone(),
                then: State::Idle,
            };
            encoder.on_submitted_work_done(move || copy.finish());
        }
    }

    /// Returns the count of an earlier frame when it has arrived. Call it once a frame, before the frame is
    /// recorded.
    pub fn take(&self, context: &RenderContext) -> Option<u32> {
        if self.state.get() == State::Copied {
            self.state.set(State::Mapping);
            let state = self.state.clone();
            self.staging
                .slice(..)
                .map_async(wgpu::MapMode::Read, move |result| {
                    state.set(if result.is_ok() {
                        State::Mapped
                    } else {
                        State::Lost
                    });
                });
            // Since the copy is done, this maps the buffer at once (in browsers, later). No loss of the device
            // comes between the mapping and the read, which would panic.
            let _ = context.device.poll(wgpu::PollType::Poll);
        }
        if self.state.get() != State::Mapped {
            return None;
        }
        let count = bytemuck::pod_read_unaligned(&self.staging.slice(..).get_mapped_range());
        self.staging.unmap();
        self.state.set(State::Idle);
        Some(count)
    }
}
