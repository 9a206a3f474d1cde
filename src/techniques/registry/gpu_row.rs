//! The GPU side of a row.

use std::any::TypeId;

use super::technique::Technique;
use crate::render::recorder::Recorder;
use crate::render::shaders::ShaderFile;
use crate::render::{Gpu, RenderError};

/// The GPU side of a [`Row`](super::Row).
#[derive(Clone, Copy)]
pub(super) struct GpuRow {
    pub kind: TypeId,
    pub shaders: &'static [ShaderFile],
    pub make: fn(&Gpu) -> Result<Box<dyn Recorder>, RenderError>,
}

impl GpuRow {
    pub(super) fn of<T: Technique>() -> Self {
        Self {
            kind: TypeId::of::<T::Recorder>(),
            shaders: T::SHADERS,
            make: |gpu| T::recorder(gpu).map(|recorder| Box::new(recorder) as Box<dyn Recorder>),
        }
    }
}
