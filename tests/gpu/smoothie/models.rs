//! Models under a sphere of light: smoothies beside the plain map and the jittered filter, at 256². It prints errors
//! and times.
//!
//! A smoothie adds the outer half of the penumbra to the umbra of the plain map, and changes nothing inside it. So the
//! error inside the umbra, half of that of the plain map at a straight edge, stays, and no picture of smoothies can
//! come nearer to a sphere than 1/√2 of the plain map's error. The light that a smoothie imitates is the one whose
//! penumbra begins where the umbra ends: what half of the sphere on the blocker's side leaves, `max(0, 2 v − 1)`.
//! Both are printed.
//!
//! Where the receiver's horizon cuts the light, a round body hides the light from itself by degrees. No map shows that, and
//! the light pass weights what is above the horizon, so these pixels are left out. The table prints their share of the squared
//! error: up to 0.8, and nearly all of the penumbrae of `shape_collection`.

use std::path::Path;

use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, RayScene, SurfaceHit, hard_visibility, primary_hits, soft_visibility,
};
use antumbra::techniques::SmoothieWidth;
use antumbra::techniques::maps::{MapFilter, MapResolution};
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use super::scenes::rendered;
use crate::harness::support::stage::Stage;
use crate::harness::{ModelStage, file_name, model, own_context};

const SIZE: UVec2 = UVec2::new(128, 72);

/// Share of the plain map's error that smoothies may have. Measured: 0.46 for `suzanne`, 0.35 for `deer`, 0.43 for `spot`, 0.35
/// for `espresso_cup`.
const ALLOWED: f64 = 0.5;

/// The share allowed at 256² to `shape_collection` (0.61) and `knight` (0.53). Their penumbrae are narrower than two texels, at
/// all pixels of the first and at a quarter of those of the second. At 512² they have 0.30 and 0.36.
const ALLOWED_OF_TWO: f64 = 0.65;

/// Radius of the light, as a share of the model's.
const RADIUS: f32 = 0.12;

/// Errors and times of one kind of shadow.
#[derive(Clone, Copy, Debug, Default)]
struct Judged {
    /// RMSE along edges to the sphere.
    sphere: f64,
    /// RMSE along edges to the light that smoothies imitate.
    outer: f64,
    /// Share of the squares of the error to that light, over all penumbrae, where the receiver's horizon cuts the light.
    horizon: f64,
    /// Milliseconds of the lookup.
    lookup: f64,
    /// Milliseconds of everything that the light's shadow takes where all casters move.
    whole: f64,
}

fn times(stage: &mut Stage) -> (Vec<f32>, f64, f64) {
    let of = |stage: &mut Stage, names: &[&str]| {
        let rendered = stage.render().expect("the frame renders");
        let passes = rendered.pass_times.iter();
        let own = passes.filter(|pass| names.iter().any(|name| pass.label.ends_with(name)));
        (
            own.map(|pass| pass.milliseconds).sum::<f64>(),
            rendered.visibility,
        )
    };
    let mut least = |names: &[&str]| {
        let times = [0; 3].map(|_| of(stage, names).0);
        times.into_iter().fold(f64::INFINITY, f64::min)
    };
    // The map is not kept, so every frame draws all of it.
    let whole = least(&["/map", "/map lookup", "/smoothies"]);
    let lookup = least(&["/map lookup"]);
    (rendered(stage), lookup, whole)
}

/// Share of the squares of errors in the penumbra that lie where the receiver's horizon cuts the light.
fn share_at_horizon(truth: &[f32], got: &[f32], seen: &[f32], above: &[f32]) -> f64 {
    let mut sums = [0.0; 2];
    for index in (0..truth.len()).filter(|&index| (0.01..0.99).contains(&seen[index])) {
        sums[usize::from(above[index].is_nan())] += f64::from(truth[index] - got[index]).powi(2);
    }
    sums[1] / (sums[0] + sums[1])
}

/// RMSE where the penumbra of either light is.
fn rmse(truth: &[f32], got: &[f32], seen: &[f32]) -> f64 {
    let edges = truth
        .iter()
        .zip(got)
        .zip(seen)
        .filter(|(_, seen)| (0.01..0.99).contains(*seen));
    let (sum, count) = edges.fold((0.0, 0), |(sum, count), ((truth, got), _)| {
        (sum + f64::from(truth - got).powi(2), count + 1)
    });
    assert!(count > 15, "{count} pixels are in the penumbra");
    (sum / f64::from(count)).sqrt()
}

/// The model under a sphere, shadowed in three ways: plain, jittered, smoothies.
fn judge(path: &Path, side: u32, context: &RenderContext) -> [Judged; 3] {
    let mut stage = ModelStage::new(path, context, SIZE).expect("it has triangles");
    let center = stage.bounds.center();
    let unit = stage.bounds.half_size().length();
    let at = |direction: Vec3, distance: f32| center + direction.normalize() * (distance * unit);
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.01 * unit,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_translation(at(Vec3::new(0.5, 0.6, 0.9), 2.6)).looking_at(center, Vec3::Y);
    let stage_camera = stage.stage.camera;
    stage.stage.world.entity_mut(stage_camera).insert((camera, view));
    let light = |kind| Light {
        kind,
        color: Vec3::ONE,
        intensity: 10.0,
        range: 20.0 * unit,
    };
    // The map has one face, so that its texels are not too few for either shadow.
    let spot = light(LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.5,
    });
    let place = Transform::from_translation(at(Vec3::new(0.5, 1.2, 0.35), 3.0)).looking_at(center, Vec3::Y);
    let entity = stage.stage.spawn_light(spot.clone(), place, None::<Smoothie>);
    stage.stage.schedule.run(&mut stage.stage.world);
    let scene = RayScene::from_world(&mut stage.stage.world);
    let world = &stage.stage.world;
    let camera = world.get::<Camera>(stage_camera).expect("a camera");
    let transform = world.get::<GlobalTransform>(stage_camera).expect("its place");
    let hits = primary_hits(&scene, camera, transform, SIZE).expect("a usable camera");
    let source = LightSource::of_entity(world, entity).expect("a usable light");
    let in_cone = hard_visibility(&scene, &hits, &source);
    let sphere = light(LightKind::Sphere {
        radius: RADIUS * unit,
    });
    stage.stage.world.entity_mut(entity).insert(sphere);
    let source = LightSource::of_entity(&stage.stage.world, entity).expect("a usable light");
    stage.stage.world.entity_mut(entity).insert(spot);
    let seen = soft_visibility(&scene, &hits, &source, 256, 7);
    let seen: Vec<f32> = (seen.values().iter().zip(in_cone.values()))
        .map(|(seen, hard)| if hard.is_nan() { f32::NAN } else { *seen })
        .collect();
    // Where the horizon cuts the light, a body hides the light from itself by degrees. No map shows that; the light pass
    // weights what is above the horizon.
    let center = place.translation.as_dvec3();
    let is_whole = |hit: &SurfaceHit| hit.normal.dot(center - hit.position) > f64::from(RADIUS * unit);
    let pairs = seen.iter().zip(&hits.hits);
    let above: Vec<f32> = pairs
        .map(|(seen, hit)| {
            if hit.as_ref().is_some_and(is_whole) {
                *seen
            } else {
                f32::NAN
            }
        })
        .collect();
    let outer: Vec<f32> = seen.iter().map(|seen| (2.0 * seen - 1.0).max(0.0)).collect();

    let jittered = MapFilter::Jittered {
        softness: RADIUS / 3.0,
        adaptive: true,
    };
    [Some(MapFilter::Bilinear), Some(jittered), None].map(|filter| {
        let mut light = stage.stage.world.entity_mut(entity);
        light.remove::<(ShadowMap, Smoothie)>();
        match filter {
            Some(filter) => light.insert(ShadowMap {
                resolution: MapResolution::Fixed(side),
                filter,
                cached: false,
                ..Default::default()
            }),
            None => light.insert(Smoothie {
                width: SmoothieWidth::Metres(0.855 * RADIUS * unit),
                resolution: MapResolution::Fixed(side),
                cached: false,
                ..Default::default()
            }),
        };
        let (got, lookup, whole) = times(&mut stage.stage);
        Judged {
            horizon: share_at_horizon(&outer, &got, &seen, &above),
            sphere: rmse(&seen, &got, &above),
            outer: rmse(&outer, &got, &above),
            lookup,
            whole,
        }
    })
}

fn table(side: u32, names: &[&str]) {
    let context = own_context(RequestedFeatures {
        timestamps: true,
        ..Default::default()
    });
    println!(
        "{:<26} {:>23} {:>23} {:>7} {:>17} {:>17}",
        format!("{side}²"),
        "to the sphere",
        "to its outer half",
        "horizon",
        "lookup ratio",
        "with all drawn"
    );
    println!(
        "{:<26} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8} {:>8}",
        "model",
        "plain",
        "jitter",
        "smooth",
        "plain",
        "jitter",
        "smooth",
        "share",
        "/plain",
        "/jitter",
        "/plain",
        "/jitter"
    );
    let mut failures = Vec::new();
    for name in names {
        let path = model(name);
        let [plain, jittered, smoothie] = judge(&path, side, &context);
        println!(
            "{:<26} {:>7.4} {:>7.4} {:>7.4} {:>7.4} {:>7.4} {:>7.4} {:>7.2} {:>8.2} {:>8.2} {:>8.2} {:>8.2}",
            file_name(&path),
            plain.sphere,
            jittered.sphere,
            smoothie.sphere,
            plain.outer,
            jittered.outer,
            smoothie.outer,
            smoothie.horizon,
            smoothie.lookup / plain.lookup,
            smoothie.lookup / jittered.lookup,
            smoothie.whole / plain.whole,
            smoothie.whole / jittered.whole,
        );
        let allowed = match *name {
            "shape_collection.glb" | "knight.glb" if side == 256 => ALLOWED_OF_TWO,
            _ => ALLOWED,
        };
        if smoothie.outer > allowed * plain.outer {
            failures.push(format!("{name}: {plain:?}, {smoothie:?}"));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn beside_the_umbra_smoothies_err_less_than_the_plain_map() {
    table(256, &["suzanne.glb", "deer.glb"]);
}

#[test]
#[ignore = "models that are not bundled"]
fn beside_the_umbra_smoothies_err_less_on_eight_models() {
    let names = [
        "suzanne.glb",
        "deer.glb",
        "spot.glb",
        "espresso_cup.glb",
        "shape_collection.glb",
        "coin.glb",
        "fox.glb",
        "knight.glb",
    ];
    table(256, &names);
    table(512, &names);
}
