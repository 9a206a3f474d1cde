//! What maps cost: whole frames, from the schedule to the last pixel, as ratios to the same frame with its lights
//! unshadowed: by kind of map, filter and cache, at rest and with a caster that moves.
//!
//! ```sh
//! cargo bench --all-features --bench maps -- [--short]
//! ```
//!
//! Times are wall clock, median of the repetitions; every variant is measured in turn, so that drift meets all alike.
//! That the shadows are there is asserted once, then timed.

use antumbra_stage as support;

use std::sync::Arc;
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::techniques::maps::{MapFilter, MapFormat, MapResolution};
use bevy_ecs::prelude::Entity;
use bevy_transform::prelude::Transform;
use clap::Parser;
use glam::{UVec2, Vec3};
use support::stage::Stage;

/// Measures frames.
#[derive(Parser)]
struct Arguments {
    /// Few repetitions, small pictures.
    #[arg(long)]
    short: bool,
    /// What cargo passes to every bench.
    #[arg(long, hide = true)]
    bench: bool,
}

/// What shadows the lights.
#[derive(Clone, Copy, PartialEq)]
enum Shadow {
    None,
    Spot(ShadowMap),
    Sun(ShadowMap),
    Omni(OmniMap),
}

struct Variant {
    name: &'static str,
    shadow: Shadow,
    moving: bool,
}

fn variants() -> Vec<Variant> {
    let resolution = MapResolution::Fixed(512);
    let map = ShadowMap {
        resolution,
        ..Default::default()
    };
    let omni = OmniMap {
        resolution,
        ..Default::default()
    };
    let jittered = |adaptive| MapFilter::Jittered {
        softness: 0.01,
        adaptive,
    };
    let filtered = |filter| Shadow::Omni(OmniMap { filter, ..omni });
    let variant = |name, shadow, moving| Variant { name, shadow, moving };
    let uncached = OmniMap {
        cached: false,
        ..omni
    };
    let float = OmniMap {
        format: MapFormat::R32Float,
        ..omni
    };
    vec![
        variant("unshadowed", Shadow::None, false),
        variant("spot, at rest", Shadow::Spot(map), false),
        variant("sun, at rest", Shadow::Sun(map), false),
        variant("omni, at rest", Shadow::Omni(omni), false),
        variant("omni, at rest, squared distance", Shadow::Omni(float), false),
        variant("omni, at rest, 4×4", filtered(MapFilter::Brute4x4), false),
        variant("omni, at rest, dithered", filtered(MapFilter::Dithered4), false),
        variant("omni, at rest, jittered", filtered(jittered(true)), false),
        variant("omni, at rest, all 64", filtered(jittered(false)), false),
        variant("unshadowed, one moves", Shadow::None, true),
        variant("omni, one moves", Shadow::Omni(omni), true),
        variant("omni, one moves, not kept", Shadow::Omni(uncached), true),
    ]
}

/// A hall of 200 boxes under four lights, and one ball that may move.
fn stage(size: UVec2, context: &RenderContext, shadow: Shadow) -> (Stage, Entity) {
    let camera = Camera {
        aspect: size.x as f32 / size.y as f32,
        ..Default::default()
    };
    let view = Transform::from_xyz(0.0, 6.0, 12.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(size, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    let material = Arc::new(Material::matte(Vec3::splat(0.7)));
    let mut add = |mesh: &Arc<MeshData>, at: Transform| {
        let parts = (ShadowCaster, ShadowReceiver);
        let materials = SceneMaterials([material.clone()].into());
        stage
            .world
            .spawn((SceneMesh(mesh.clone()), materials, parts, at))
            .id()
    };
    add(&Arc::new(MeshData::plane(12.0)), Transform::default());
    let cube = Arc::new(MeshData::cuboid(Vec3::splat(0.25)));
    for i in 0..200 {
        let (x, z) = ((i % 20) as f32 - 9.5, (i / 20) as f32 * 2.0 - 9.0);
        add(&cube, Transform::from_xyz(x, 0.3, z));
    }
    let ball = add(
        &Arc::new(MeshData::icosphere(0.3, 3)),
        Transform::from_xyz(0.0, 1.0, 0.0),
    );
    for i in 0..4 {
        let place = Transform::from_xyz(i as f32 * 5.0 - 7.5, 3.0, 1.0).looking_at(Vec3::ZERO, Vec3::Z);
        let kind = match shadow {
            Shadow::Spot(_) => LightKind::Spot {
                inner_angle: 0.5,
                outer_angle: 0.9,
            },
            Shadow::Sun(_) => LightKind::Directional,
            Shadow::Omni(_) | Shadow::None => LightKind::Point,
        };
        let light = Light {
            kind,
            ..Light::point(Vec3::ONE, 10.0, 8.0)
        };
        let entity = stage.spawn_light(light, place, None::<ShadowMap>);
        let mut entity = stage.world.entity_mut(entity);
        match shadow {
            Shadow::None => {}
            Shadow::Spot(map) | Shadow::Sun(map) => drop(entity.insert(map).id()),
            Shadow::Omni(map) => drop(entity.insert(map).id()),
        }
    }
    (stage, ball)
}

/// One frame, waited for; milliseconds.
fn frame(stage: &mut Stage, ball: Entity, moving: bool, time: f32) -> f64 {
    if moving {
        let place = Transform::from_xyz(time.sin(), 1.0, time.cos());
        stage.world.entity_mut(ball).insert(place);
    }
    let start = Instant::now();
    stage.time_passes().expect("the frame renders");
    let context = stage.world.resource::<Renderer>().context();
    context
        .device
        .poll(wgpu::PollType::wait_indefinitely())
        .expect("the device answers");
    start.elapsed().as_secs_f64() * 1e3
}

fn main() {
    let arguments = Arguments::parse();
    let (size, runs) = if arguments.short {
        (UVec2::new(160, 90), 9)
    } else {
        (UVec2::new(640, 360), 31)
    };
    let context = pollster::block_on(RenderContext::headless(RequestedFeatures {
        timestamps: false,
        ..Default::default()
    }))
    .expect("a GPU adapter is needed");
    println!("{}, {}×{}, median of {runs}", context.adapter, size.x, size.y);
    let variants = variants();
    let mut stages: Vec<_> = variants
        .iter()
        .map(|variant| stage(size, &context, variant.shadow))
        .collect();
    for ((stage, ball), variant) in stages.iter_mut().zip(&variants) {
        let rendered = stage.render().expect("the frame renders");
        let dark = rendered.visibility.iter().flatten().filter(|v| **v < 0.5).count();
        assert_eq!(dark > 20, variant.shadow != Shadow::None, "{}", variant.name);
        for i in 0..12 {
            frame(stage, *ball, variant.moving, i as f32 * 0.1); // what stands still has joined the others
        }
    }
    let mut times = vec![Vec::new(); variants.len()];
    for run in 0..runs {
        for (((stage, ball), variant), times) in stages.iter_mut().zip(&variants).zip(&mut times) {
            times.push(frame(stage, *ball, variant.moving, run as f32 * 0.1));
        }
    }
    let medians: Vec<f64> = times
        .iter_mut()
        .map(|times| {
            times.sort_by(f64::total_cmp);
            times[times.len() / 2]
        })
        .collect();
    let mut base = medians[0];
    for (variant, median) in variants.iter().zip(&medians) {
        if variant.shadow == Shadow::None {
            base = *median;
        }
        println!("{:<34} {median:>9.3} ms {:>7.2} ×", variant.name, median / base);
    }
}
