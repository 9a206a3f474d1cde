//! The recorders of the techniques.

use std::any::TypeId;
use std::sync::LazyLock;

use bevy_ecs::prelude::*;

use super::Techniques;
use super::technique::Technique;
use crate::render::gpu::bind_groups::BindGroupLayouts;
use crate::render::recorder::Recorder;
use crate::render::shaders::{FILES, ShaderFile};
use crate::render::{RenderContext, RenderError, Renderer, Shaders};

/// What a recorder is made with.
#[derive(Clone, Copy, Debug)]
pub struct RecorderInput<'a> {
    /// The device.
    pub context: &'a RenderContext,
    /// Shader composition.
    pub shaders: &'a Shaders,
    /// The layouts that passes share.
    pub layouts: &'a BindGroupLayouts,
}

/// The GPU side of a [`Row`](super::Row).
#[derive(Clone, Copy)]
pub(super) struct GpuRow {
    kind: TypeId,
    shaders: &'static [ShaderFile],
    make: fn(&RecorderInput) -> Result<Box<dyn Recorder>, RenderError>,
}

impl GpuRow {
    pub(super) fn of<T: Technique>() -> Self {
        Self {
            kind: TypeId::of::<T::Recorder>(),
            shaders: T::SHADERS,
            make: |input| T::recorder(input).map(|recorder| Box::new(recorder) as Box<dyn Recorder>),
        }
    }
}

impl super::Row {
    /// The technique's WGSL files, each after those that it imports.
    pub fn shaders(&self) -> &'static [ShaderFile] {
        self.gpu.shaders
    }
}

/// Gives a renderer the recorder of each technique, one for all techniques whose recorders are of one type.
///
/// Set: `PrepareGpu`, before `prepare_techniques`. Only a frame after which there are more techniques does more than
/// compare two numbers.
pub fn add_recorders(mut renderer: ResMut<Renderer>, techniques: Res<Techniques>) {
    for row in techniques.rows.iter().skip(renderer.recorders().row_count()) {
        let made = renderer.add_recorder(row.gpu.kind, |renderer| {
            renderer.shaders().add(row.gpu.shaders)?;
            (row.gpu.make)(&RecorderInput {
                context: renderer.context(),
                shaders: renderer.shaders(),
                layouts: renderer.layouts(),
            })
        });
        if let Err(error) = made {
            renderer.fail(error);
            return; // and again in the next frame
        }
    }
}

/// Path and text of every WGSL file that others import, of the renderer and of the crate's techniques.
pub static COMMON: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| files(true));

/// Path and text of every WGSL file with entry points.
pub static PASSES: LazyLock<Vec<(&str, &str)>> = LazyLock::new(|| files(false));

fn files(imported: bool) -> Vec<(&'static str, &'static str)> {
    let techniques = Techniques::default();
    let of_techniques = techniques.rows.iter().flat_map(|row| row.gpu.shaders);
    let mut files: Vec<(&str, &str)> = Vec::new();
    for file in FILES.iter().chain(of_techniques) {
        // Several techniques may share a file.
        if file.is_imported() == imported && !files.iter().any(|(path, _)| *path == file.path) {
            files.push((file.path, file.source));
        }
    }
    files
}
