//! The device goes away.

use antumbra::render::RenderError;

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
