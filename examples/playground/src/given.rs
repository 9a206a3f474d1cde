//! Visibility that is given as a picture, as a technique: the ray-traced truth is shaded by the same light pass as
//! everything that it judges.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::{
    Gpu, Leaves, PrepareInput, RecordInput, Recorder, RenderError, Resolve, ResolveInput, create_target,
};
use antumbra::techniques::{Needs, Technique};
use bevy_ecs::prelude::*;
use glam::UVec2;

/// Visibility of a light at each pixel.
#[derive(Debug)]
pub struct GivenPicture {
    /// Size, pixels.
    pub size: UVec2,
    /// Half floats, four equal channels a pixel, rows from the top.
    pub texels: Vec<u8>,
}

/// Gives a light the visibility of a picture. Without a picture the light is seen everywhere.
#[derive(Component, Clone, Debug, Default)]
pub struct GivenVisibility(pub Option<Arc<GivenPicture>>);

impl PartialEq for GivenVisibility {
    fn eq(&self, other: &Self) -> bool {
        match (&self.0, &other.0) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        }
    }
}

impl Technique for GivenVisibility {
    const NAME: &'static str = "given_visibility";
    const NEEDS: Needs = Needs::NOTHING;

    type Recorder = GivenRecorder;

    fn recorder(_: &Gpu) -> Result<GivenRecorder, RenderError> {
        Ok(GivenRecorder::default())
    }
}

/// Copies the pictures into the mask.
#[derive(Default)]
pub struct GivenRecorder {
    pictures: Vec<Held>,
}

/// A picture on the GPU.
struct Held {
    light: usize,
    entity: Entity,
    source: GivenVisibility,
    texture: Option<wgpu::Texture>,
}

impl Recorder for GivenRecorder {
    fn prepare(&mut self, world: &World, input: &PrepareInput) -> Result<(), RenderError> {
        let mut before = std::mem::take(&mut self.pictures);
        for (light, frame) in world.resource::<FrameLights>().lights.iter().enumerate() {
            let Some(source) = world
                .get::<GivenVisibility>(frame.entity)
                .filter(|_| frame.is_shadowed_by::<GivenVisibility>())
            else {
                continue;
            };
            let held = before
                .iter()
                .position(|held| held.entity == frame.entity && held.source == *source);
            let texture = match held {
                Some(at) => before.swap_remove(at).texture,
                None => upload(input, source)?,
            };
            self.pictures.push(Held {
                light,
                entity: frame.entity,
                source: source.clone(),
                texture,
            });
        }
        Ok(())
    }

    fn light(&self, light: usize) -> Option<Leaves<'_>> {
        let held = self.pictures.iter().any(|held| held.light == light);
        held.then_some(Leaves::Mask(self))
    }

    fn debug(&self, _: usize, _: &mut wgpu::RenderPass, _: &RecordInput) {}

    fn batch_count(&self, _: usize) -> usize {
        1
    }
}

fn upload(input: &PrepareInput, source: &GivenVisibility) -> Result<Option<wgpu::Texture>, RenderError> {
    let Some(picture) = &source.0 else {
        return Ok(None);
    };
    let format = wgpu::TextureFormat::Rgba16Float; // that of the mask
    let texture = create_target(input.context, "given visibility", picture.size, format)?;
    input.context.queue.write_texture(
        texture.as_image_copy(),
        &picture.texels,
        wgpu::TexelCopyBufferLayout {
            offset: 0,
            bytes_per_row: Some(picture.size.x * 8),
            rows_per_image: None,
        },
        texture.size(),
    );
    Ok(Some(texture))
}

impl Resolve for GivenRecorder {
    fn resolve(&self, light: usize, encoder: &mut wgpu::CommandEncoder, input: &ResolveInput) {
        let held = self.pictures.iter().find(|held| held.light == light);
        let texture = held.and_then(|held| held.texture.as_ref());
        let mask = &input.masks.mask;
        match texture.filter(|texture| texture.size() == mask.size()) {
            Some(texture) => {
                encoder.copy_texture_to_texture(texture.as_image_copy(), mask.as_image_copy(), mask.size());
            }
            None => {
                encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("given visibility"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &input.masks.mask_view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations {
                            load: wgpu::LoadOp::Clear(wgpu::Color::WHITE),
                            store: wgpu::StoreOp::Store,
                        },
                    })],
                    ..Default::default()
                });
            }
        }
    }
}
