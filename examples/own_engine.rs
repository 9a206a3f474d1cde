//! An engine with its own wgpu device, target and encoder, and without an `App`: a world, a schedule, and one call
//! for each frame.
//!
//! ```sh
//! cargo run --example own_engine -- --out DIR
//! ```

use std::error::Error;
use std::path::PathBuf;
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::create_target;
use antumbra::render::readback::read_texture;
use antumbra::schedule::{init_resources, standalone_schedule};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use clap::Parser;
use glam::{UVec2, Vec3};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Draws one frame, and writes it as a PNG.
#[derive(Parser)]
struct Arguments {
    /// Folder of the picture; created if missing.
    #[arg(long, default_value = "out")]
    out: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    // An engine has these already: a device, a queue and a texture to draw into.
    let size = UVec2::new(640, 360);
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor::new_without_display_handle());
    let adapter = pollster::block_on(instance.request_adapter(&Default::default()))?;
    // Without these optional features everything is drawn as well, but soft shadows err more.
    let descriptor = RequestedFeatures::default().descriptor(&adapter);
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))?;
    let name = adapter.get_info().name;

    // Do this once: add the systems to a world, and create a renderer on the device.
    let context = RenderContext::from_device(device.clone(), queue.clone(), name);
    let frame = create_target(&context, "frame", size, FORMAT)?;
    let mut renderer = Renderer::new(context.clone())?;
    renderer.prepare_output(FORMAT);
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(size));
    world.insert_resource(renderer);
    let mut schedule = standalone_schedule();

    let matte = |color| SceneMaterials([Arc::new(Material::matte(color))].into());
    let floor = SceneMesh(Arc::new(MeshData::plane(5.0)));
    world.spawn((floor, matte(Vec3::ONE), ShadowReceiver));
    let ball = SceneMesh(Arc::new(MeshData::icosphere(0.8, 3)));
    let place = Transform::from_xyz(0.0, 1.0, 0.0);
    world.spawn((ball, matte(Vec3::X), ShadowCaster, ShadowReceiver, place));
    let view = Transform::from_xyz(2.0, 3.0, 6.0).looking_at(Vec3::Y * 0.5, Vec3::Y);
    let camera = Camera {
        aspect: size.x as f32 / size.y as f32,
        ..Camera::default()
    };
    world.spawn((camera, view));
    let sun = Light::directional(Vec3::ONE, 3.0);
    let towards = Transform::IDENTITY.looking_to(Vec3::new(-1.0, -2.0, -1.0), Vec3::Y);
    world.spawn((sun, StencilVolume::default(), towards));

    // Do this every frame: run the systems, record into the engine's own encoder, and submit.
    schedule.run(&mut world);
    world.clear_trackers(); // after all schedules of the frame
    let mut renderer = world.resource_mut::<Renderer>();
    if let Some(failure) = renderer.take_failure() {
        return Err(failure.into());
    }
    let mut encoder = device.create_command_encoder(&Default::default());
    let view = frame.create_view(&Default::default());
    renderer.record(
        &mut encoder,
        &FrameOutputs {
            picture: Some(&view),
            visibility: &[],
        },
    );
    queue.submit([encoder.finish()]);

    std::fs::create_dir_all(&arguments.out)?;
    let rows = read_texture(&context, &frame, wgpu::TextureAspect::All, "frame")?;
    let path = arguments.out.join("own_engine.png");
    let color = image::ExtendedColorType::Rgba8;
    image::save_buffer(&path, &rows.bytes, size.x, size.y, color)?;
    println!("{}", path.display());
    Ok(())
}
