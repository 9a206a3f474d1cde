//! The recorders of one view.

use std::any::TypeId;
use std::ops::Index;

use bevy_ecs::prelude::World;

use super::RenderError;
use super::frame::frame_data::{LightShadow, TechniqueIndex};
use super::recorder::{Leaves, PrepareInput, RecordInput, Recorder};
use crate::sets::LightTechnique;

/// The recorder of a technique that a host draws by itself: lights are without shadow in what the crate draws.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoRecorder;

impl Recorder for NoRecorder {
    fn prepare(&mut self, _: &World, _: &PrepareInput) -> Result<(), RenderError> {
        Ok(())
    }

    fn light(&self, _: usize) -> Option<Leaves<'_>> {
        None
    }

    fn debug(&self, _: usize, _: &mut wgpu::RenderPass, _: &RecordInput) {}

    fn batch_count(&self, _: usize) -> usize {
        0
    }
}

/// The recorders of the world's techniques, one for all techniques whose recorders are of one type.
#[derive(Default)]
pub struct Recorders {
    recorders: Vec<Box<dyn Recorder>>,
    /// Type of each recorder.
    kinds: Vec<TypeId>,
    /// Index of the recorder of each technique, in the order of the world's list.
    of_row: Vec<usize>,
}

impl Recorders {
    /// Number of techniques that have a recorder: the first ones of the world's list.
    pub fn row_count(&self) -> usize {
        self.of_row.len()
    }

    /// Number of recorders.
    pub fn count(&self) -> usize {
        self.recorders.len()
    }

    /// How the shadow of the light at `light` in [`FrameLights`](crate::sets::FrameLights) is drawn.
    pub(super) fn shadow_of(&self, light: usize, technique: &LightTechnique) -> Option<LightShadow> {
        let recorder = *self.of_row.get(technique.row)?;
        Some(LightShadow {
            technique: TechniqueIndex(recorder),
            kind: self.recorders[recorder].light(light)?.kind(),
        })
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = &dyn Recorder> {
        self.recorders.iter().map(Box::as_ref)
    }

    pub(super) fn iter_mut(&mut self) -> impl Iterator<Item = &mut Box<dyn Recorder>> {
        self.recorders.iter_mut()
    }

    pub(super) fn knows(&self, kind: TypeId) -> bool {
        self.kinds.contains(&kind)
    }

    pub(super) fn push(&mut self, kind: TypeId, recorder: Box<dyn Recorder>) {
        self.recorders.push(recorder);
        self.kinds.push(kind);
    }

    /// The next technique of the list is drawn by the recorder of this type.
    pub(super) fn add_row(&mut self, kind: TypeId) {
        self.of_row
            .extend(self.kinds.iter().position(|known| *known == kind));
    }
}

impl Index<usize> for Recorders {
    type Output = Box<dyn Recorder>;

    fn index(&self, recorder: usize) -> &Self::Output {
        &self.recorders[recorder]
    }
}
