//! The pictures of the grounds of each light: two for each face, which the blur fills in turn.

use bevy_ecs::prelude::Entity;

use super::pipelines::{GroundLayouts, PICTURE_FORMAT};
use crate::render::RenderContext;
use crate::render::gpu::bind_groups::bind_in_order;
use crate::techniques::maps::gpu::pool::FaceArray;

/// The pictures of one light.
#[derive(Debug)]
pub struct Pictures {
    light: Entity,
    side: u32,
    /// The colours, later blurred along both axes.
    pub colors: FaceArray,
    /// The colours blurred along the first axis.
    pub half_blurred: FaceArray,
    /// Group 3 with each of the two.
    pub groups: [wgpu::BindGroup; 2],
    in_use: bool,
}

/// The pictures of all lights.
#[derive(Debug, Default)]
pub struct PicturePool {
    all: Vec<Pictures>,
}

impl PicturePool {
    /// Begins to record which pictures are in use.
    pub fn begin(&mut self) {
        self.all.iter_mut().for_each(|pictures| pictures.in_use = false);
    }

    /// Frees the pictures that were not requested since [`PicturePool::begin`].
    pub fn end(&mut self) {
        self.all.retain(|pictures| pictures.in_use);
    }

    /// Returns the pictures of a light.
    pub fn get(&self, light: Entity) -> Option<&Pictures> {
        self.all.iter().find(|pictures| pictures.light == light)
    }

    /// Makes the pictures of a light, unless there are some of the same size.
    pub fn require(
        &mut self,
        context: &RenderContext,
        layouts: &GroundLayouts,
        light: Entity,
        side: u32,
        layers: u32,
    ) {
        let same = |known: &&mut Pictures| {
            known.light == light && known.side == side && known.colors.layers.len() == layers as usize
        };
        if let Some(known) = self.all.iter_mut().find(same) {
            known.in_use = true;
            return;
        }
        self.all.retain(|pictures| pictures.light != light);
        let array = |label| FaceArray::new(context, label, side, layers, PICTURE_FORMAT);
        let [colors, half_blurred] = ["ground colors", "ground half blurred"].map(array);
        let groups = [&colors, &half_blurred].map(|array| {
            let view = array.array_view();
            let resources = [
                wgpu::BindingResource::TextureView(&view),
                wgpu::BindingResource::Sampler(&layouts.bilinear),
            ];
            bind_in_order(&context.device, "ground picture", &layouts.picture, resources)
        });
        self.all.push(Pictures {
            light,
            side,
            colors,
            half_blurred,
            groups,
            in_use: true,
        });
    }
}
