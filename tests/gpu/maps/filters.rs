//! What each filter is worth: its error against the share of the hard shadow in its footprint, its taps, its time.

use antumbra::prelude::*;
use antumbra::render::readback::read_texture;
use antumbra::techniques::maps::{MapFilter, MapFormat, MapSettings, MapSurface};
use glam::DVec2;

use super::contacts::{Kind, filters};
use super::scenes;
use crate::harness::maps::Judge;
use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};

/// Samples along a side of the footprint.
const SIDE: i32 = 6;

/// Share of the hard shadow in a filter's footprint, for every pixel that counts.
fn footprint_truth(judge: &Judge, filter: MapFilter, radius: impl Fn(&Judge, usize) -> f64) -> Vec<f32> {
    let truth = judge.truth.values();
    truth
        .iter()
        .enumerate()
        .map(|(index, truth)| {
            let Some(hit) = judge.hits.hits[index].as_ref().filter(|_| !truth.is_nan()) else {
                return f32::NAN;
            };
            let half = match filter {
                MapFilter::Bilinear => 0.5,
                MapFilter::Brute4x4 | MapFilter::Dithered4 => 2.0,
                MapFilter::Jittered { .. } | MapFilter::Soft4 { .. } => radius(judge, index),
            };
            let round = filter.softness().is_some();
            let at = |i: i32| (f64::from(i) + 0.5) / f64::from(SIDE) * 2.0 - 1.0;
            let (mut seen, mut count) = (0, 0);
            for place in (0..SIDE * SIDE).map(|i| DVec2::new(at(i % SIDE), at(i / SIDE))) {
                if round && place.length() > 1.0 {
                    continue;
                }
                count += 1;
                let beside = judge.beside(hit, place * half);
                seen += u32::from(beside.is_some_and(|point| judge.sees(point, hit)));
            }
            seen as f32 / count as f32
        })
        .collect()
}

fn rmse(a: &[f32], b: &[f32]) -> f64 {
    let pairs = a.iter().zip(b).filter(|(a, b)| !a.is_nan() && !b.is_nan());
    let (sum, count) = pairs.fold((0.0, 0), |(sum, count), (a, b)| {
        (sum + f64::from(a - b).powi(2), count + 1)
    });
    (sum / f64::from(count.max(1))).sqrt()
}

/// Mean taps of the pixels that count.
fn taps(stage: &Stage, judge: &Judge) -> f64 {
    let renderer = stage.world.resource::<Renderer>();
    let mask = &renderer.mask_targets().expect("a map was looked up").mask;
    let rows =
        read_texture(renderer.context(), mask, wgpu::TextureAspect::All, "mask").expect("it can be read");
    let reds = rows.bytes.chunks_exact(8);
    let reds = reds.map(|texel| half::f16::from_le_bytes([texel[0], texel[1]]).to_f64() * 64.0);
    let counted = reds
        .zip(judge.truth.values())
        .filter(|(_, truth)| !truth.is_nan());
    let (sum, count) = counted.fold((0.0, 0), |(sum, count), (taps, _)| (sum + taps, count + 1));
    sum / f64::from(count)
}

#[test]
fn table_of_filters() {
    let context = own_context(RequestedFeatures {
        timestamps: true,
        ..Default::default()
    });
    let scenes = scenes::all();
    let scene = scenes
        .iter()
        .find(|scene| scene.name == "row of pillars")
        .expect("it is there");
    println!(
        "{:<24} {:<14} {:>8} {:>8} {:>8}",
        "map", "filter", "RMSE", "taps", "ms"
    );
    // What is unpacked is looked up like a float.
    for kind in Kind::UNPACKED {
        let (mut stage, rays) = scene.stage(&context);
        let (light, place) = scene.light(kind.light());
        let entity = stage.spawn_light(light, place, None::<StencilVolume>);
        let mut full = None;
        let mut judge = None;
        for filter in filters(kind.light(), 1.0) {
            stage.world.resource_mut::<MapSettings>().show_taps = true;
            kind.insert(&mut stage.world.entity_mut(entity), filter, MapSurface::Nearest);
            stage.render().expect("the frame renders");
            let rendered = stage.render().expect("the frame renders");
            let judge = judge.get_or_insert_with(|| Judge::new(&stage, &rays, 0).expect("something casts"));
            // Softness is a share of the distance along the face's axis, or metres.
            let radius = |judge: &Judge, index: usize| {
                let point = judge.hits.hits[index].expect("it counts").position;
                // Beyond the last shadow there is no face and nothing to filter.
                let Some((_, _, z)) = judge.face_of(point) else {
                    return 0.0;
                };
                let distance = if kind == Kind::Sun { 1.0 } else { z };
                f64::from(filter.softness().unwrap_or(0.0)) * distance / judge.texel_metres(point)
            };
            let got = &rendered.visibility[0];
            let error = rmse(&footprint_truth(judge, filter, radius), got);
            let taps = taps(&stage, judge);
            let lookup = rendered
                .pass_times
                .iter()
                .filter(|pass| pass.label.ends_with("map lookup"));
            let ms: f64 = lookup.map(|pass| pass.milliseconds).sum();
            let name = format!("{filter:?}");
            let name = match filter {
                MapFilter::Jittered { adaptive: true, .. } => "Jittered",
                MapFilter::Jittered { adaptive: false, .. } => "Jittered, full",
                _ => name.split(' ').next().unwrap_or_default(),
            };
            println!(
                "{:<24} {name:<14} {error:>8.4} {taps:>8.2} {ms:>8.3}",
                format!("{kind:?}")
            );
            assert!(error < 0.1, "{kind:?} {filter:?}: {error}");
            assert!(
                taps <= f64::from(filter.most_taps()) * 2.0,
                "two cascades at most"
            );
            match filter {
                MapFilter::Jittered { adaptive: false, .. } => full = Some((taps, got.clone())),
                MapFilter::Jittered { adaptive: true, .. } => {
                    let (full_taps, full) = full.as_ref().expect("the full one comes first");
                    let counted: Vec<f32> = judge
                        .truth
                        .values()
                        .iter()
                        .zip(full)
                        .map(|(truth, full)| if truth.is_nan() { f32::NAN } else { *full })
                        .collect();
                    let to_full = rmse(&counted, got);
                    println!(
                        "{:<24} {:<14} {to_full:>8.4} to the full filter, {:.1} times fewer taps",
                        "",
                        "",
                        full_taps / taps
                    );
                    assert!(full_taps / taps >= 4.0, "{full_taps} / {taps}");
                    assert!(to_full <= 0.01, "{to_full}");
                }
                _ => {}
            }
        }
    }
}

#[test]
fn packed_maps_agree_with_floats() {
    let context = strict_context();
    let all = scenes::all();
    let usual = all.iter().take(8).map(|scene| (scene, None));
    // Bytes hold shares of a range that is far beyond all casters.
    let far = all.iter().take(1).map(|scene| (scene, Some(1e4)));
    for (scene, range) in usual.chain(far) {
        let mut pictures = Vec::new();
        for format in [
            MapFormat::R32Float,
            MapFormat::Rgba8FourBytes,
            MapFormat::Rgba8TwoBytes,
        ] {
            let (mut stage, _) = scene.stage(&context);
            let (mut light, place) = scene.light(LightKind::Point);
            light.range = range.unwrap_or(light.range);
            let entity = stage.spawn_light(light, place, None::<StencilVolume>);
            let kind = Kind::Omni(format);
            kind.insert(
                &mut stage.world.entity_mut(entity),
                MapFilter::Bilinear,
                MapSurface::Nearest,
            );
            pictures.push(stage.render().expect("the frame renders").visibility.remove(0));
        }
        let (four, two) = (rmse(&pictures[0], &pictures[1]), rmse(&pictures[0], &pictures[2]));
        println!(
            "{:<28} RMSE to floats: four bytes {four:.5}, two bytes {two:.5}",
            scene.name
        );
        assert!(four < 0.002 && two < 0.02, "{}: {four} {two}", scene.name);
        assert!(pictures[0].iter().any(|v| *v < 0.5), "something is dark");
    }
}
