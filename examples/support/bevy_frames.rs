//! Games of Bevy's without a window, frame by frame, and what their cameras see in numbers.

#[path = "bevy_windowless.rs"]
mod windowless;

use bevy::app::{AppLabel, SubApps};
use bevy::camera::RenderTarget;
use bevy::prelude::*;
use bevy::render::RenderApp;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{
    BufferDescriptor, BufferUsages, CommandEncoderDescriptor, MapMode, PollType, TexelCopyBufferInfo,
    TexelCopyBufferLayout, TextureFormat,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::sync_world::RenderEntity;
use bevy::render::view::ViewTarget;
use windowless::{picture, plugins};

/// Bevy's plugins, with pipelines and results in the same frame, on black.
pub fn app() -> App {
    with_plugins(App::new())
}

/// Adds them to an app that may have others already.
pub fn with_plugins(mut app: App) -> App {
    let plugins = plugins().disable::<PipelinedRenderingPlugin>();
    // Apps of one process would each set the logger.
    #[cfg(feature = "bevy-window")]
    let plugins = plugins.disable::<bevy::log::LogPlugin>();
    app.add_plugins(plugins);
    app.insert_resource(ClearColor(Color::BLACK));
    app
}

/// A picture to render into.
pub fn target(world: &mut World, size: UVec2) -> RenderTarget {
    RenderTarget::Image(picture(world, size).into())
}

/// The renderer's world.
pub fn render_world(apps: &mut SubApps) -> &mut World {
    let render = apps.sub_apps.get_mut(&RenderApp.intern()).expect("a renderer");
    render.world_mut()
}

/// Linear radiance that a camera saw in the last frame: pixels, and RGB by row from the top.
pub fn radiance(apps: &mut SubApps, camera: Entity) -> (UVec2, Vec<[half::f16; 3]>) {
    let (size, format, bytes) = texels(apps, camera);
    assert_eq!(format, TextureFormat::Rgba16Float);
    let radiance = bytes.chunks_exact(8).map(|texel| {
        let channel = |c: usize| half::f16::from_le_bytes([texel[2 * c], texel[2 * c + 1]]);
        [channel(0), channel(1), channel(2)]
    });
    (size, radiance.collect())
}

/// Bytes of what a camera saw in the last frame, by row from the top, whatever its dynamic range.
pub fn texels(apps: &mut SubApps, camera: Entity) -> (UVec2, TextureFormat, Vec<u8>) {
    let main = apps.main.world();
    let view = main.get::<RenderEntity>(camera).expect("a camera").id();
    let world = render_world(apps);
    let device = world.resource::<RenderDevice>().clone();
    let queue = world.resource::<RenderQueue>().clone();
    let texture = world.get::<ViewTarget>(view).expect("a view").main_texture();
    let format = texture.format();
    let size = UVec2::new(texture.width(), texture.height());
    let used = size.x as usize * format.block_copy_size(None).expect("a colour") as usize;
    let row = RenderDevice::align_copy_bytes_per_row(used);
    let buffer = device.create_buffer(&BufferDescriptor {
        label: None,
        size: u64::from(size.y) * row as u64,
        usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor::default());
    encoder.copy_texture_to_buffer(
        texture.as_image_copy(),
        TexelCopyBufferInfo {
            buffer: &buffer,
            layout: TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(row as u32),
                rows_per_image: None,
            },
        },
        texture.size(),
    );
    queue.submit([encoder.finish()]);
    let mapped = |result: Result<(), _>| result.expect("it is read");
    buffer.slice(..).map_async(MapMode::Read, mapped);
    device
        .poll(PollType::wait_indefinitely())
        .expect("the device is there");
    let bytes = buffer.slice(..).get_mapped_range();
    let rows = bytes.chunks(row).flat_map(|line| &line[..used]);
    (size, format, rows.copied().collect())
}
