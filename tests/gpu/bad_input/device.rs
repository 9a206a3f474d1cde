//! The device goes away.

use antumbra::render::readback::{read_buffer, read_texture};
use antumbra::render::{RenderError, create_target};

use super::*;

#[test]
fn device_loss_is_survived() {
    let context = own_context(RequestedFeatures::default());
    let mut stage = box_on_plane(&context);
    let usual = render(&mut stage);
    assert!(!context.is_lost());

    context.device.destroy();
    // Whether the loss is known yet or not, frames run and draw nothing; new objects come too.
    for frame in 0..4 {
        let at = Transform::from_xyz(frame as f32, 2.0, 0.0);
        let more = stage.world.spawn(object(MeshData::icosphere(0.3, 1), at)).id();
        stage
            .world
            .insert_resource(ViewportSize(SIZE + UVec2::splat(frame)));
        stage.schedule.run(&mut stage.world);
        let mut encoder = context.device.create_command_encoder(&Default::default());
        stage
            .world
            .resource::<Renderer>()
            .record(&mut encoder, &Default::default());
        context.queue.submit([encoder.finish()]);
        stage.world.despawn(more);
        // What an engine does each frame anyway; the result only says that the device is gone.
        let _ = context.device.poll(wgpu::PollType::Poll);
    }
    assert!(context.is_lost());
    stage.schedule.run(&mut stage.world);
    let failure = stage.world.resource_mut::<Renderer>().take_failure();
    assert!(matches!(failure, Some(RenderError::DeviceLost)), "{failure:?}");
    assert!(stage.render().is_err());

    stage.world.insert_resource(ViewportSize(SIZE));
    let fresh = own_context(RequestedFeatures::default());
    stage
        .add_renderer(fresh, RenderSettings::default())
        .expect("a new device draws");
    assert!(same(&usual, &render(&mut stage)), "the picture comes back");
}

/// No error reaches the device's handler of uncaptured errors, which would panic.
#[test]
fn reading_from_a_lost_device_is_an_error() {
    let context = own_context(RequestedFeatures {
        timestamps: true,
        ..Default::default()
    });
    let mut stage = box_on_plane(&context);
    stage.world.insert_resource(ViewportSize(UVec2::new(80, 45)));
    stage.render().expect("the frame renders");
    let timings = stage.world.resource::<Renderer>().timings();
    assert!(timings.is_active(), "the device has timers");
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let texture = create_target(&context, "picture", UVec2::splat(4), format).expect("a texture");
    let buffer = context.device.create_buffer(&wgpu::BufferDescriptor {
        label: None,
        size: 16,
        usage: wgpu::BufferUsages::COPY_SRC,
        mapped_at_creation: false,
    });
    // Nobody has told this context of the loss.
    let unaware = RenderContext::hosted(context.device.clone(), context.queue.clone(), "host".to_owned());

    context.device.destroy();
    let read = |context: &RenderContext| {
        [
            read_texture(context, &texture, wgpu::TextureAspect::All, "picture").map(|_| ()),
            read_buffer(context, &buffer, 16, "numbers").map(|_| ()),
            timings.read(context).map(|_| ()),
        ]
    };
    for result in read(&unaware) {
        assert!(matches!(result, Err(RenderError::Readback { .. })), "{result:?}");
    }
    for result in read(&context) {
        assert!(matches!(result, Err(RenderError::DeviceLost)), "{result:?}");
    }
}
