//! The plugin in a `bevy_app` `App` that draws without a window.
//!
//! ```sh
//! cargo run --example with_app -- --out DIR
//! ```

use std::error::Error;
use std::f32::consts::TAU;
use std::path::PathBuf;
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::create_target;
use antumbra::render::readback::read_texture;
use bevy_app::prelude::*;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use clap::Parser;
use glam::{UVec2, Vec3};

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// Spawns objects, a camera, and a light that chooses its technique.
fn spawn_scene(mut commands: Commands) {
    let material = |color| SceneMaterials([Arc::new(Material::matte(color))].into());
    let floor = SceneMesh(Arc::new(MeshData::plane(6.0)));
    commands.spawn((floor, material(Vec3::splat(0.7)), ShadowReceiver));
    let cube = Arc::new(MeshData::cuboid(Vec3::new(0.3, 0.8, 0.3)));
    for turn in 0..7 {
        let angle = turn as f32 * TAU / 7.0;
        commands.spawn((
            SceneMesh(cube.clone()),
            material(Vec3::new(0.8, 0.5, 0.3)),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(2.0 * angle.cos(), 0.8, 2.0 * angle.sin()),
        ));
    }
    let view = Transform::from_xyz(0.0, 4.0, 7.0).looking_at(Vec3::Y * 0.3, Vec3::Y);
    commands.spawn((Camera::default(), view));
    let lamp = Light::point(Vec3::new(1.0, 0.9, 0.7), 30.0, 20.0);
    let place = Transform::from_xyz(0.0, 2.2, 0.0);
    commands.spawn((lamp, StencilVolume::default(), place));
}

/// Draws one frame, and writes it as a PNG.
#[derive(Parser)]
struct Arguments {
    /// Folder of the picture; created if missing.
    #[arg(long, default_value = "out")]
    out: PathBuf,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let size = UVec2::new(640, 360);
    let context = pollster::block_on(RenderContext::headless(RequestedFeatures::default()))?;
    let mut renderer = Renderer::new(context.clone())?;
    renderer.prepare_output(FORMAT);

    let mut app = App::new();
    app.add_plugins(AntumbraPlugin)
        .insert_resource(ViewportSize(size))
        .insert_resource(renderer)
        .add_systems(Startup, spawn_scene);
    app.update();

    let picture = create_target(&context, "picture", size, FORMAT)?;
    let mut encoder = context.device.create_command_encoder(&Default::default());
    let outputs = FrameOutputs {
        picture: Some(&picture.create_view(&Default::default())),
        visibility: &[],
    };
    let mut renderer = app.world_mut().resource_mut::<Renderer>();
    if let Some(failure) = renderer.take_failure() {
        return Err(failure.into());
    }
    renderer.record(&mut encoder, &outputs);
    context.queue.submit([encoder.finish()]);

    std::fs::create_dir_all(&arguments.out)?;
    let rows = read_texture(&context, &picture, wgpu::TextureAspect::All, "picture")?;
    let path = arguments.out.join("with_app.png");
    let color = image::ExtendedColorType::Rgba8;
    image::save_buffer(&path, &rows.bytes, size.x, size.y, color)?;
    println!("{}", path.display());
    Ok(())
}
