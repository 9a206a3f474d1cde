//! Copies of textures and buffers back to the CPU, for pictures and tests.

use glam::UVec2;

use crate::render::{RenderContext, RenderError};

/// The texels of a texture in rows from the top, without padding.
#[derive(Clone, Debug, PartialEq)]
pub struct TexelRows {
    /// The size of the picture, texels.
    pub size: UVec2,
    /// The size of one texel, bytes.
    pub texel_size: usize,
    /// The bytes of all texels.
    pub bytes: Vec<u8>,
}

/// Waits for the GPU and reads the first `size` bytes of a buffer. The buffer must have the usage `COPY_SRC`.
///
/// # Errors
/// [`RenderError::Readback`] if the copy fails, [`RenderError::DeviceLost`] if the device is lost.
pub fn read_buffer(
    context: &RenderContext,
    buffer: &wgpu::Buffer,
    size: u64,
    what: &str,
) -> Result<Vec<u8>, RenderError> {
    check_device(context)?;
    let staging = staging(context, size);
    let mut encoder = context.device.create_command_encoder(&Default::default());
    encoder.copy_buffer_to_buffer(buffer, 0, &staging, 0, size);
    context.queue.submit([encoder.finish()]);
    map(context, &staging, what)
}

/// Waits for the GPU and reads one aspect of a 2D texture. `what` names the texture in errors.
///
/// # Errors
/// [`RenderError::Readback`] if the copy fails, [`RenderError::DeviceLost`] if the device is lost.
pub fn read_texture(
    context: &RenderContext,
    texture: &wgpu::Texture,
    aspect: wgpu::TextureAspect,
    what: &str,
) -> Result<TexelRows, RenderError> {
    check_device(context)?;
    let size = UVec2::new(texture.width(), texture.height());
    let texel_size = texture
        .format()
        .block_copy_size(Some(aspect))
        .ok_or_else(|| RenderError::Readback {
            what: what.to_owned(),
            reason: format!("{:?} of {:?} cannot be copied", aspect, texture.format()),
        })? as usize;
    let row = size.x as usize * texel_size;
    let padded = row.next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT as usize);
    let staging = staging(context, padded as u64 * u64::from(size.y));
    let mut encoder = context.device.create_command_encoder(&Default::default());
    encoder.copy_texture_to_buffer(
        wgpu::TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: wgpu::Origin3d::ZERO,
            aspect,
        },
        wgpu::TexelCopyBufferInfo {
            buffer: &staging,
            layout: wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(padded as u32),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    context.queue.submit([encoder.finish()]);
    let padded_rows = map(context, &staging, what)?;
    let mut bytes = Vec::with_capacity(row * size.y as usize);
    for padded_row in padded_rows.chunks_exact(padded) {
        bytes.extend_from_slice(&padded_row[..row]);
    }
    Ok(TexelRows {
        size,
        texel_size,
        bytes,
    })
}

/// On a lost device nothing can be copied, of which wgpu would complain to whoever takes its uncaptured errors.
fn check_device(context: &RenderContext) -> Result<(), RenderError> {
    if context.notice_loss() {
        return Err(RenderError::DeviceLost);
    }
    Ok(())
}

fn staging(context: &RenderContext, size: u64) -> wgpu::Buffer {
    context.device.create_buffer(&wgpu::BufferDescriptor {
        label: Some("readback"),
        size,
        usage: wgpu::BufferUsages::COPY_DST | wgpu::BufferUsages::MAP_READ,
        mapped_at_creation: false,
    })
}

fn map(context: &RenderContext, staging: &wgpu::Buffer, what: &str) -> Result<Vec<u8>, RenderError> {
    let failed = |reason: String| {
        if context.is_lost() {
            RenderError::DeviceLost
        } else {
            RenderError::Readback {
                what: what.to_owned(),
                reason,
            }
        }
    };
    let wait = || {
        let waited = context.device.poll(wgpu::PollType::wait_indefinitely());
        waited.map_err(|error| failed(error.to_string()))
    };
    // The copy is done before its buffer is mapped, so that a loss meanwhile is an error of the mapping. Reading a buffer
    // that is lost after it was mapped would panic.
    wait()?;
    let (sender, receiver) = std::sync::mpsc::channel();
    // A device that was lost before the copy has no buffer to map. The callback hears of that error, too.
    let scope = context.device.push_error_scope(wgpu::ErrorFilter::Validation);
    staging.slice(..).map_async(wgpu::MapMode::Read, move |result| {
        // The receiver is gone only if polling failed. That error is reported below.
        let _ = sender.send(result);
    });
    drop(scope);
    wait()?;
    receiver
        .recv()
        .map_err(|error| failed(error.to_string()))?
        .map_err(|error| failed(error.to_string()))?;
    let bytes = staging.slice(..).get_mapped_range().to_vec();
    staging.unmap();
    Ok(bytes)
}
