//! Prepass textures of cameras that share a render target but not their number of samples.
//!
//! Bevy gives all cameras of a target the same prepass textures, with the samples of one of them. That is right
//! while all cameras of the target have the same MSAA. A marked camera has none, so beside a camera with MSAA
//! and a prepass of its own, one of the two would draw into textures with the wrong number of samples, and
//! wgpu would stop the app. Such cameras get textures of their own.

use bevy::camera::NormalizedRenderTarget;
use bevy::color::LinearRgba;
use bevy::core_pipeline::prepass::ViewPrepassTextures;
use bevy::diagnostic::FrameCount;
use bevy::ecs::prelude::*;
use bevy::platform::collections::HashMap;
use bevy::render::camera::ExtractedCamera;
use bevy::render::render_resource::{Texture, TextureDescriptor, TextureFormat};
use bevy::render::renderer::RenderDevice;
use bevy::render::texture::{CachedTexture, ColorAttachment, TextureCache};
use bevy::render::view::Msaa;

/// The target, number of samples and format of textures that cameras can share.
type Key = (Option<NormalizedRenderTarget>, u32, TextureFormat);

/// The textures made in this frame, each with the second of a pair that is exchanged from frame to frame.
type Made = HashMap<Key, (CachedTexture, Option<CachedTexture>)>;

/// Replaces prepass textures whose number of samples is not that of their view.
///
/// Runs in `Render`, in `PrepareResources`, after Bevy has made the textures. Cost: the views.
pub(super) fn separate_prepass_textures(
    mut views: Query<(&ExtractedCamera, &Msaa, &mut ViewPrepassTextures)>,
    mut cache: ResMut<TextureCache>,
    device: Res<RenderDevice>,
    frame: Res<FrameCount>,
    mut made: Local<Made>,
) {
    for (camera, msaa, mut textures) in &mut views {
        let textures = textures.bypass_change_detection();
        let samples = msaa.samples();
        let attachments = [
            &mut textures.depth,
            &mut textures.normal,
            &mut textures.motion_vectors,
        ];
        for attachment in attachments.into_iter().flatten() {
            let wrong = &attachment.texture.texture;
            if wrong.sample_count() == samples {
                continue;
            }
            let is_double = attachment.previous_frame_texture.is_some();
            let key = (camera.target.clone(), samples, wrong.format());
            let (first, second) = made.entry(key).or_insert_with(|| {
                let mut get = || cache.get(&device, like(wrong, samples));
                (get(), is_double.then(get))
            });
            let (now, before) = match second.clone() {
                Some(second) if !frame.0.is_multiple_of(2) => (second, Some(first.clone())),
                second => (first.clone(), second),
            };
            *attachment = ColorAttachment::new(now, None, before, Some(LinearRgba::BLACK.into()));
        }
    }
    made.clear(); // the cache keeps the textures for the next frame
}

/// Describes a texture like another, with another number of samples.
fn like(texture: &Texture, samples: u32) -> TextureDescriptor<'static> {
    TextureDescriptor {
        label: Some("antumbra prepass"),
        size: texture.size(),
        mip_level_count: 1,
        sample_count: samples,
        dimension: texture.dimension(),
        format: texture.format(),
        usage: texture.usage(),
        view_formats: &[],
    }
}
