//! Visibility that is given as pictures, as a technique: the ray-traced truth is shaded by the same light pass as
//! everything that it judges.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{RayScene, SceneTriangle, VisibilityImage};
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

impl GivenPicture {
    /// Returns ray-cast visibility as a picture. Pixels that do not count are lit, because the light pass leaves them dark
    /// by itself.
    pub fn of(image: &VisibilityImage) -> Self {
        let texels = image.values().iter().flat_map(|&value| {
            let value = if value.is_nan() { 1.0 } else { value };
            let half = half::f16::from_f32(value.clamp(0.0, 1.0)).to_le_bytes();
            [half[0], half[1]].repeat(4)
        });
        Self {
            size: image.size(),
            texels: texels.collect(),
        }
    }
}

/// Gives a light the visibility of pictures.
#[derive(Component, Clone, Debug, Default)]
pub struct GivenVisibility {
    /// Visibility of the nearest surface of each pixel, opaque or blended. Without a picture the light is seen everywhere.
    pub nearest: Option<Arc<GivenPicture>>,
    /// Visibility of the nearest opaque surface of each pixel. Without a picture it is that of the nearest surface, so a
    /// surface behind glass has the shadows of the glass.
    pub opaque: Option<Arc<GivenPicture>>,
}

impl PartialEq for GivenVisibility {
    fn eq(&self, other: &Self) -> bool {
        let are_equal = |a: &Option<Arc<GivenPicture>>, b: &Option<Arc<GivenPicture>>| match (a, b) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (None, None) => true,
            _ => false,
        };
        are_equal(&self.nearest, &other.nearest) && are_equal(&self.opaque, &other.opaque)
    }
}

/// Returns the scene with blended surfaces that the camera does not see. They block light as before. `None` if there are no
/// blended surfaces.
pub fn opaque_alone(world: &World, scene: &RayScene) -> Option<RayScene> {
    let is_blended = |triangle: &SceneTriangle| {
        let object = triangle.entity?;
        let mesh = &world.get::<SceneMesh>(object)?.0;
        let mut submeshes = mesh.submeshes.iter();
        let submesh = submeshes.position(|submesh| {
            let first = submesh.first_index / 3;
            (first..first + submesh.index_count / 3).contains(&triangle.source_index)
        })?;
        let material = world.get::<SceneMaterials>(object)?.0.get(submesh)?;
        Some(material.alpha_mode == AlphaMode::Blend)
    };
    let seen = scene.triangles().iter().map(|triangle| SceneTriangle {
        is_primary: triangle.is_primary && is_blended(triangle) != Some(true),
        ..*triangle
    });
    let seen: Vec<_> = seen.collect();
    let has_blended = seen.iter().zip(scene.triangles()).any(|(a, b)| a != b);
    has_blended.then(|| RayScene::from_scene_triangles(seen))
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

/// The pictures of a light on the GPU.
struct Held {
    light: usize,
    entity: Entity,
    source: GivenVisibility,
    nearest: Option<wgpu::Texture>,
    opaque: Option<wgpu::Texture>,
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
            self.pictures.push(match held {
                Some(at) => Held {
                    light,
                    ..before.swap_remove(at)
                },
                None => Held {
                    light,
                    entity: frame.entity,
                    source: source.clone(),
                    nearest: upload(input, source.nearest.as_deref())?,
                    opaque: upload(input, source.opaque.as_deref())?,
                },
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

fn upload(
    input: &PrepareInput,
    picture: Option<&GivenPicture>,
) -> Result<Option<wgpu::Texture>, RenderError> {
    let Some(picture) = picture else {
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
        // Only the front layer of blended surfaces selects the casters that matter.
        let is_front = input.record.casters.is_some();
        let texture = held.and_then(|held| match &held.opaque {
            Some(opaque) if !is_front => Some(opaque),
            _ => held.nearest.as_ref(),
        });
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
