//! A headless game, and what its cameras see.

use bevy::app::{AppLabel, SubApps};
use bevy::asset::RenderAssetUsages;
use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::pipelined_rendering::PipelinedRenderingPlugin;
use bevy::render::render_resource::{
    BufferDescriptor, BufferUsages, CommandEncoderDescriptor, Extent3d, MapMode, PollType,
    TexelCopyBufferInfo, TexelCopyBufferLayout, TextureDimension, TextureFormat, TextureUsages,
};
use bevy::render::renderer::{RenderDevice, RenderQueue};
use bevy::render::sync_world::RenderEntity;
use bevy::render::view::ViewTarget;
use bevy::render::{RenderApp, RenderPlugin};
use bevy::window::ExitCondition;

use antumbra::bevy_adapter::prelude::*;

/// Size of test pictures.
pub const SIZE: UVec2 = UVec2::new(128, 72);

/// The plugins of a game without a window, with results in the same frame.
pub fn headless() -> App {
    crate::setup::listen();
    let mut app = App::new();
    let plugins = DefaultPlugins
        .set(WindowPlugin {
            primary_window: None,
            exit_condition: ExitCondition::DontExit,
            ..default()
        })
        .set(RenderPlugin {
            synchronous_pipeline_compilation: true,
            ..default()
        })
        .disable::<PipelinedRenderingPlugin>();
    #[cfg(feature = "bevy-window")]
    let plugins = plugins
        .disable::<bevy::winit::WinitPlugin>()
        .disable::<bevy::log::LogPlugin>();
    app.add_plugins(plugins);
    app.insert_resource(ClearColor(Color::BLACK));
    app.insert_resource(GlobalAmbientLight {
        brightness: 50.0,
        ..default()
    });
    app
}

/// The same, with ours. Meshes are ready in the frame in which they appear.
pub fn antumbra() -> App {
    let mut app = headless();
    app.add_plugins(AntumbraPlugin);
    app.insert_resource(AntumbraSettings {
        immediate_triangles: usize::MAX,
        ..default()
    });
    app
}

/// A picture to render into.
pub fn target(world: &mut World, size: UVec2) -> RenderTarget {
    let mut image = Image::new_uninit(
        Extent3d {
            width: size.x,
            height: size.y,
            depth_or_array_layers: 1,
        },
        TextureDimension::D2,
        TextureFormat::Rgba8UnormSrgb,
        RenderAssetUsages::RENDER_WORLD,
    );
    image.texture_descriptor.usage |= TextureUsages::RENDER_ATTACHMENT;
    let image = world.resource_mut::<Assets<Image>>().add(image);
    RenderTarget::Image(image.into())
}

/// What every camera of the tests has.
pub fn camera(world: &mut World, transform: Transform) -> Entity {
    let target = target(world, SIZE);
    world
        .spawn((
            Camera3d::default(),
            bevy::camera::Hdr,
            Msaa::Off,
            Tonemapping::None,
            target,
            transform,
        ))
        .id()
}

/// Some material.
pub fn matte(world: &mut World) -> MeshMaterial3d<StandardMaterial> {
    MeshMaterial3d(
        world
            .resource_mut::<Assets<StandardMaterial>>()
            .add(StandardMaterial::default()),
    )
}

/// A game that runs.
pub struct Game {
    pub apps: SubApps,
}

impl Game {
    /// Starts it.
    pub fn start(mut app: App) -> Self {
        app.finish();
        app.cleanup();
        Self {
            apps: std::mem::take(app.sub_apps_mut()),
        }
    }

    /// Runs frames.
    pub fn run(&mut self, frames: usize) -> &mut Self {
        for _ in 0..frames {
            self.apps.update();
        }
        self
    }

    /// The game's world.
    pub fn world(&mut self) -> &mut World {
        self.apps.main.world_mut()
    }

    /// The renderer's world.
    pub fn render_world(&mut self) -> &mut World {
        let render = self
            .apps
            .sub_apps
            .get_mut(&RenderApp.intern())
            .expect("a renderer");
        render.world_mut()
    }

    /// What a camera sees once two frames in a row are the same: Bevy's clusters grow over frames.
    pub fn settled(&mut self, camera: Entity) -> Picture {
        let mut last = self.radiance(camera);
        for _ in 0..30 {
            let next = self.run(3).radiance(camera);
            if next == last {
                return next;
            }
            last = next;
        }
        panic!("the picture never settles");
    }

    /// Linear radiance that a camera sees.
    pub fn radiance(&mut self, camera: Entity) -> Picture {
        let view = self.world().get::<RenderEntity>(camera).expect("a camera").id();
        let world = self.render_world();
        let device = world.resource::<RenderDevice>().clone();
        let queue = world.resource::<RenderQueue>().clone();
        let texture = world.get::<ViewTarget>(view).expect("a view").main_texture();
        let size = UVec2::new(texture.width(), texture.height());
        assert_eq!(texture.format(), TextureFormat::Rgba16Float);
        let row = RenderDevice::align_copy_bytes_per_row(size.x as usize * 8);
        let buffer = device.create_buffer(&BufferDescriptor {
            label: None,
            size: (row * size.y as usize) as u64,
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
        buffer
            .slice(..)
            .map_async(MapMode::Read, |result| result.unwrap());
        device.poll(PollType::wait_indefinitely()).unwrap();
        let bytes = buffer.slice(..).get_mapped_range();
        let texels = (0..size.y as usize)
            .flat_map(|y| bytes[y * row..y * row + size.x as usize * 8].chunks_exact(8))
            .map(|texel| {
                let channel = |c: usize| half::f16::from_le_bytes([texel[c * 2], texel[c * 2 + 1]]);
                [channel(0), channel(1), channel(2)]
            })
            .collect();
        Picture { size, texels }
    }
}

/// Linear RGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    pub size: UVec2,
    pub texels: Vec<[half::f16; 3]>,
}

/// How two pictures differ.
#[derive(Clone, Copy, Debug, Default)]
pub struct Difference {
    /// Channels that are not the same number.
    pub channels: usize,
    /// Largest difference over the larger value.
    pub relative: f32,
    /// Largest difference.
    pub absolute: f32,
    /// Largest difference in steps of the 16-bit format.
    pub steps: i32,
}

impl Picture {
    /// Compares with one of the same size.
    pub fn difference(&self, other: &Self) -> Difference {
        assert_eq!(self.size, other.size);
        let mut out = Difference::default();
        let pairs = self.texels.iter().flatten().zip(other.texels.iter().flatten());
        for (&a, &b) in pairs {
            assert!(a.is_finite() && b.is_finite(), "a picture is not finite");
            let (x, y) = (f32::from(a), f32::from(b));
            out.channels += usize::from(x != y);
            out.absolute = out.absolute.max((x - y).abs());
            if x != y {
                out.relative = out.relative.max((x - y).abs() / x.abs().max(y.abs()));
            }
            out.steps = out.steps.max((ordered(a) - ordered(b)).abs());
        }
        out
    }

    /// Mean of all channels.
    pub fn mean(&self) -> f32 {
        let sum: f32 = self.texels.iter().flatten().map(|&x| f32::from(x)).sum();
        sum / (self.texels.len() * 3) as f32
    }

    /// Writes it as a PNG below the directory of `ANTUMBRA_OUT`, if that is set.
    pub fn save(&self, name: &str) {
        let Ok(dir) = std::env::var("ANTUMBRA_OUT") else {
            return;
        };
        let encode = |x: half::f16| (f32::from(x).clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0).round() as u8;
        let bytes = self.texels.iter().flatten().map(|&x| encode(x)).collect();
        let image = image::RgbImage::from_raw(self.size.x, self.size.y, bytes).unwrap();
        image.save(format!("{dir}/{name}.png")).unwrap();
    }
}

/// Numbers of the format, counted from 0.
fn ordered(x: half::f16) -> i32 {
    let bits = i32::from(x.to_bits());
    if bits & 0x8000 == 0 {
        bits
    } else {
        -(bits & 0x7fff)
    }
}
