//! Bevy examples run in a window, or without one if `--headless --out DIR` is given.

#[path = "bevy_windowless.rs"]
mod windowless;

use std::path::PathBuf;

use bevy::camera::RenderTarget;
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy::render::gpu_readback::{Readback, ReadbackComplete};
use clap::Parser;
use windowless::{picture, plugins};

#[derive(Parser)]
struct Arguments {
    /// Draws into a picture instead of a window, and ends.
    #[arg(long)]
    headless: bool,
    /// Folder for the picture.
    #[arg(long, default_value = "out")]
    out: PathBuf,
}

/// The picture and the file that it is written to.
#[derive(Resource)]
struct Picture {
    image: Handle<Image>,
    file: PathBuf,
    frames: usize,
}

/// Marks that assets of the scene are still being loaded. The picture waits until this resource is removed.
#[derive(Resource, Default)]
#[allow(dead_code, reason = "most examples load nothing")]
pub struct Loading;

const SIZE: UVec2 = UVec2::new(320, 180);

/// Returns an app with Bevy's plugins, with or without a window as the command line says.
pub fn app_of_arguments(name: &str) -> App {
    let arguments = Arguments::parse();
    if !arguments.headless {
        return windowed();
    }
    headless(arguments.out.join(format!("{name}.png")))
}

#[cfg(feature = "bevy-window")]
fn windowed() -> App {
    let mut app = App::new();
    app.add_plugins(DefaultPlugins);
    app
}

#[cfg(not(feature = "bevy-window"))]
fn windowed() -> App {
    eprintln!("without the feature bevy-window there is no window; --headless --out DIR draws a picture");
    std::process::exit(2);
}

/// Returns an app without a window whose cameras draw a picture that is written to a file.
pub fn headless(file: PathBuf) -> App {
    let mut app = App::new();
    app.add_plugins(plugins());
    let image = picture(app.world_mut(), SIZE);
    app.insert_resource(Picture {
        image,
        file,
        frames: 0,
    });
    let take_picture = take_picture.run_if(not(resource_exists::<Loading>));
    app.add_systems(PreUpdate, (aim_cameras, take_picture));
    app
}

/// Makes the cameras of the example draw into the picture.
fn aim_cameras(mut commands: Commands, picture: Res<Picture>, cameras: Query<Entity, Added<Camera3d>>) {
    for camera in &cameras {
        let target = RenderTarget::Image(picture.image.clone().into());
        // Bevy's default tonemapping needs a lookup table that is behind a cargo feature.
        commands.entity(camera).insert((target, Tonemapping::AcesFitted));
    }
}

/// Number of frames until pipelines are compiled and clusters have grown.
const FRAMES: usize = 12;

fn take_picture(mut commands: Commands, mut picture: ResMut<Picture>) {
    picture.frames += 1;
    if picture.frames == FRAMES {
        commands
            .spawn(Readback::texture(picture.image.clone()))
            .observe(save);
    }
}

fn save(read: On<ReadbackComplete>, picture: Res<Picture>, mut exit: MessageWriter<AppExit>) {
    let row = read.data.len() / SIZE.y as usize;
    let rows = read.data.chunks_exact(row);
    let pixels = rows.flat_map(|row| row[..SIZE.x as usize * 4].to_vec()).collect();
    let written = image::RgbaImage::from_raw(SIZE.x, SIZE.y, pixels)
        .ok_or_else(|| "the picture is cut short".to_owned())
        .and_then(|image| {
            if let Some(folder) = picture.file.parent() {
                std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
            }
            image.save(&picture.file).map_err(|error| error.to_string())
        });
    match written {
        Ok(()) => {
            println!("{}", picture.file.display());
            exit.write(AppExit::Success);
        }
        Err(error) => {
            eprintln!("{}: {error}", picture.file.display());
            exit.write(AppExit::error());
        }
    }
}

/// Runs an app until it ends.
pub fn run(mut app: App) {
    if app.world().get_resource::<Picture>().is_some() {
        app.add_plugins(bevy::app::ScheduleRunnerPlugin::default());
    }
    if app.run().is_error() {
        std::process::exit(1);
    }
}
