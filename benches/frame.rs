//! Cost of shadowed lights. Whole frames are timed, from the schedule to the last pixel, as ratios to the same frame
//! without shadows. Variants show what each optimisation of the stencil volumes is worth.
//!
//! ```sh
//! cargo bench --bench frame -- [--short] [--size 640x360] [--models FOLDER]
//! ```
//!
//! A time is wall clock from the start of the frame to the end of the GPU's work, and the median of the repetitions.
//! The variants of a scene take turns, so that drift affects all of them equally. The picture is asserted once before
//! anything is timed.

use antumbra_stage as support;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::scene::gltf_import::{load_gltf, spawn_scene};
use antumbra::techniques::stencil_volume::{Counting, Extent};
use bevy_transform::prelude::Transform;
use clap::Parser;
use glam::{UVec2, Vec3};
use support::stage::Stage;

/// Measures frames.
#[derive(Parser)]
struct Arguments {
    /// Runs few repetitions on small pictures.
    #[arg(long)]
    short: bool,
    /// Width and height of the pictures, pixels.
    #[arg(long, default_value = "640x360")]
    size: String,
    /// Folder that has `interior.glb`.
    #[arg(long, default_value = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/models"))]
    models: PathBuf,
    /// Cargo passes this to every bench; it has no effect.
    #[arg(long, hide = true)]
    bench: bool,
}

/// One way to draw the frame.
struct Variant {
    name: &'static str,
    shadow: Option<StencilVolume>,
    settings: RenderSettings,
    /// Moves the light every frame, so that silhouettes are extracted again.
    moving: bool,
}

fn variants() -> Vec<Variant> {
    let settings = RenderSettings::default();
    let shadow = StencilVolume::default();
    let variant = |name, shadow, settings, moving| Variant {
        name,
        shadow,
        settings,
        moving,
    };
    vec![
        variant("unshadowed (baseline)", None, settings, false),
        variant("shadowed", Some(shadow), settings, false),
        variant("shadowed, light moves", Some(shadow), settings, true),
        variant(
            "depth-fail forced",
            Some(StencilVolume {
                counting: Counting::DepthFail,
                ..shadow
            }),
            settings,
            false,
        ),
        variant(
            "infinite volumes",
            Some(StencilVolume {
                extent: Extent::Infinite,
                ..shadow
            }),
            settings,
            false,
        ),
        variant(
            "no depth bounds",
            Some(shadow),
            RenderSettings {
                depth_bounds: false,
                ..settings
            },
            false,
        ),
        variant(
            "no scissor",
            Some(shadow),
            RenderSettings {
                scissor: false,
                ..settings
            },
            false,
        ),
        variant(
            "plain chapter 9.3",
            Some(StencilVolume {
                counting: Counting::DepthFail,
                extent: Extent::Infinite,
            }),
            RenderSettings {
                depth_bounds: false,
                scissor: false,
                ..settings
            },
            true,
        ),
    ]
}

/// A scene with lights of its own.
struct Bench {
    name: String,
    stage: Stage,
}

fn main() {
    let arguments = Arguments::parse();
    let size = if arguments.short {
        "160x90"
    } else {
        &arguments.size
    };
    let (width, height) = size.split_once('x').expect("--size is WIDTHxHEIGHT");
    let size = UVec2::new(
        width.parse().expect("width in pixels"),
        height.parse().expect("height in pixels"),
    );
    let repetitions = if arguments.short { 1 } else { 15 };
    let context = pollster::block_on(RenderContext::headless(RequestedFeatures::default()))
        .expect("a GPU adapter is needed");
    println!("{}, {size}, median of {repetitions}", context.adapter);
    let mut benches = vec![field(size)];
    let interior = arguments.models.join("interior.glb");
    if interior.is_file() {
        benches.push(flat(&interior, size));
    } else {
        println!("{}: not there, left out", interior.display());
    }
    for bench in &mut benches {
        bench
            .stage
            .add_renderer(context.clone(), RenderSettings::default())
            .expect("shaders compose");
        measure(bench, repetitions);
    }
}

fn spawn(stage: &mut Stage, mesh: Arc<MeshData>, material: &Arc<Material>, transform: Transform) {
    stage.world.spawn((
        SceneMesh(mesh),
        SceneMaterials([material.clone()].into()),
        (ShadowCaster, ShadowReceiver),
        transform,
    ));
}

/// 400 balls and boxes on a ground, under eight point lights.
fn field(size: UVec2) -> Bench {
    let aspect = size.x as f32 / size.y as f32;
    let camera = Camera {
        aspect,
        ..Default::default()
    };
    let view = Transform::from_xyz(0.0, 6.0, 16.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(size, camera, view);
    let material = Arc::new(Material::matte(Vec3::splat(0.5)));
    let ball = Arc::new(MeshData::icosphere(0.3, 3));
    let cube = Arc::new(MeshData::cuboid(Vec3::splat(0.25)));
    for i in 0..400 {
        let (x, z) = ((i % 20) as f32 - 9.5, (i / 20) as f32 - 9.5);
        let mesh = if i % 2 == 0 { &ball } else { &cube };
        spawn(
            &mut stage,
            mesh.clone(),
            &material,
            Transform::from_xyz(x, 0.4, z),
        );
    }
    spawn(
        &mut stage,
        Arc::new(MeshData::plane(20.0)),
        &material,
        Transform::default(),
    );
    for i in 0..8 {
        let place = Transform::from_xyz((i % 4) as f32 * 5.0 - 7.5, 2.0, (i / 4) as f32 * 8.0 - 4.0);
        stage.spawn_light(Light::point(Vec3::ONE, 20.0, 7.0), place, None::<StencilVolume>);
    }
    Bench {
        name: "field: 401 objects, 8 point lights of range 7".to_owned(),
        stage,
    }
}

/// The furnished flat with its own seven lights.
fn flat(path: &Path, size: UVec2) -> Bench {
    let camera = Camera {
        vertical_fov: 1.1,
        near: 0.05,
        aspect: size.x as f32 / size.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(5.4, 1.6, 4.6).looking_at(Vec3::new(1.0, 0.9, 1.0), Vec3::Y);
    let mut stage = Stage::empty(size, camera, view);
    let loaded = load_gltf(path).expect("the flat loads");
    let spawned = spawn_scene(&mut stage.world, &loaded, None).expect("the flat spawns");
    stage.lights = spawned.lights;
    Bench {
        name: "interior.glb: 511k triangles, its own 7 lights".to_owned(),
        stage,
    }
}

fn measure(bench: &mut Bench, repetitions: usize) {
    let variants = variants();
    let stage = &mut bench.stage;
    let mut times = vec![Vec::new(); variants.len()];
    let mut first_picture = None;
    let mut lights = 0;
    for repetition in 0..repetitions + 1 {
        for (variant, times) in variants.iter().zip(&mut times) {
            apply(stage, variant);
            frame(stage); // uploads and new pipelines are not measured
            if repetition == 0 && !variant.moving && variant.shadow.is_some() {
                let picture = stage.render().expect("the frame renders").picture;
                let first = first_picture.get_or_insert_with(|| picture.clone());
                let wrong = picture
                    .iter()
                    .zip(first.iter())
                    .filter(|(a, b)| a.abs_diff(**b) > 8)
                    .count();
                assert!(wrong * 1000 < picture.len(), "{}: {wrong} differ", variant.name);
                lights = stage.world.resource::<Renderer>().frame().lights.len();
            }
            // The light stands still while pictures are compared.
            if variant.moving && repetition > 0 {
                shift(stage, repetition);
            }
            let start = Instant::now();
            frame(stage);
            if repetition > 0 {
                times.push(start.elapsed().as_secs_f64() * 1e3);
            }
        }
    }
    println!("\n{}\n{lights} lights light something", bench.name);
    println!(
        "{:<24} {:>9} {:>12} {:>8}",
        "variant", "ms", "ms a light", "ratio"
    );
    let medians: Vec<f64> = times.iter_mut().map(|times| median(times)).collect();
    for (variant, median) in variants.iter().zip(&medians) {
        println!(
            "{:<24} {median:>9.2} {:>12.2} {:>8.2}",
            variant.name,
            median / lights.max(1) as f64,
            median / medians[0]
        );
    }
}

fn apply(stage: &mut Stage, variant: &Variant) {
    stage.world.resource_mut::<Renderer>().settings = variant.settings;
    for light in stage.lights.clone() {
        let mut entity = stage.world.entity_mut(light);
        match variant.shadow {
            Some(shadow) => entity.insert(shadow),
            None => entity.remove::<StencilVolume>(),
        };
    }
}

/// Moves every light a little to and fro.
fn shift(stage: &mut Stage, repetition: usize) {
    let step = if repetition.is_multiple_of(2) { 0.01 } else { -0.01 };
    for &light in &stage.lights {
        if let Some(mut transform) = stage.world.get_mut::<Transform>(light) {
            transform.translation.x += step;
        }
    }
}

/// Draws one frame without reading anything back.
fn frame(stage: &mut Stage) {
    stage.schedule.run(&mut stage.world);
    let renderer = stage.world.resource::<Renderer>();
    let context = renderer.context();
    let mut encoder = context.device.create_command_encoder(&Default::default());
    renderer.record(&mut encoder, &FrameOutputs::default());
    context.queue.submit([encoder.finish()]);
    context
        .device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device answers");
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
