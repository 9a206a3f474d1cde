//! No acne, no leaks, and shadows that meet their casters within a texel, without a setting for any scene.

use antumbra::insides::matrix_faces;
use antumbra::prelude::*;
use antumbra::reference::Ray;
use antumbra::techniques::maps::{MapFilter, Maps};

use super::{KINDS, SPOT, variants};
use crate::harness::maps::{Judge, MapError};
use crate::harness::strict_context;
use crate::maps::scenes::{self, TestScene};

/// How far off an edge a filter may be wrong, texels.
fn reach_texels(filter: MapFilter) -> f64 {
    if filter == MapFilter::Bilinear { 1.0 } else { 3.5 }
}

fn judge(scene: &TestScene, kind: LightKind, map: PerspectiveMap) -> Option<MapError> {
    let (mut stage, rays) = scene.stage(&strict_context());
    let (light, place) = scene.light(kind);
    stage.spawn_light(light, place, Some(map));
    let rendered = stage.render().expect("the frame renders");
    let mut judge = Judge::new(&stage, &rays, 0)?;
    judge.band = reach_texels(map.filter);
    Some(judge.compare(&rendered.visibility[0]))
}

/// The scene in which a pixel of 120,000, at the rim of a bowl, is known to be lit.
const KNOWN: &str = "bowl";

/// Judges pictures of scenes, and names those that are wrong.
fn judge_all(cases: impl Iterator<Item = (usize, LightKind, PerspectiveMap)>) {
    let scenes = scenes::all();
    let (mut all, mut bad, mut count) = (MapError::default(), Vec::new(), 0);
    for (scene, kind, map) in cases {
        let scene = &scenes[scene];
        let Some(error) = judge(scene, kind, map) else {
            continue;
        };
        all.add(error);
        count += 1;
        let known = usize::from(scene.name == KNOWN);
        if error.acne > 0 || error.wrong > known {
            bad.push(format!(
                "{} / {kind:?} / {map:?}: {:.5} {error:?}",
                scene.name,
                error.share()
            ));
        }
    }
    println!("{count} pictures, {all:?}");
    assert!(all.dark > 300 * count, "too little is dark");
    assert!(bad.is_empty(), "{} of {count}:\n{}", bad.len(), bad.join("\n"));
}

#[test]
fn no_acne_no_leak_and_contacts_within_a_texel() {
    let count = scenes::all().len();
    judge_all((0..count).step_by(2).map(|i| {
        let filter = [MapFilter::Bilinear, MapFilter::Brute4x4, MapFilter::Dithered4][i / 5 % 3];
        let map = PerspectiveMap {
            filter,
            ..variants(1024)[i * 2 % 5]
        };
        (i, KINDS[i % 3], map)
    }));
}

#[test]
#[ignore = "minutes: every scene with every kind of light and every setting"]
fn no_acne_no_leak_and_contacts_by_hand() {
    let count = scenes::all().len();
    let cases = (0..count).flat_map(|scene| {
        KINDS
            .into_iter()
            .flat_map(move |kind| variants(1024).into_iter().map(move |map| (scene, kind, map)))
    });
    judge_all(cases);
}

/// Wrong pixels of a map without a filter, by the comparison with the receiver's plane, and by the bias in world space of
/// the source with each of some factors on the texel.
fn wrong_by_bias(scene: &TestScene, kind: LightKind, factors: &[f64]) -> (usize, Vec<usize>) {
    let (mut stage, rays) = scene.stage(&strict_context());
    let (light, place) = scene.light(kind);
    stage.spawn_light(light, place, Some(variants(64)[0]));
    stage.schedule.run(&mut stage.world);
    let judge = Judge::new(&stage, &rays, 0).expect("something casts");
    let map = stage
        .world
        .resource::<Maps>()
        .of_light(0)
        .expect("it has a map")
        .clone();
    let faces = || map.faces.iter().map(|state| &state.face);
    let resolution = f64::from(map.resolution);
    let (mut by_plane, mut by_texel) = (0, vec![0; factors.len()]);
    for (hit, &truth) in judge.hits.hits.iter().zip(judge.truth.values()) {
        let Some((hit, shown)) = hit
            .as_ref()
            .filter(|_| !truth.is_nan())
            .and_then(|hit| Some((hit, matrix_faces::showing(faces(), hit.position)?)))
        else {
            continue;
        };
        let face = &map.faces[shown.face].face;
        let texel = ((shown.ndc * 0.5 + 0.5) * resolution).floor() + 0.5;
        let (start, direction) = matrix_faces::ray(face, texel / resolution * 2.0 - 1.0);
        let line = Ray {
            origin: start,
            direction,
        };
        let blocker = rays.closest_hit(&line, 1e-9, f64::INFINITY, |triangle| triangle.blocks);
        let blocker = blocker.map_or(f64::INFINITY, |blocker| blocker.t) + 1e-6;
        let sides = matrix_faces::texel_at(face, hit.position, map.resolution).map(|side| side.length());
        let side = sides[0].max(sides[1]);
        let raised = hit.position + hit.normal * (0.15 * side);
        let on_plane = hit.normal.dot(raised - start) / hit.normal.dot(direction);
        by_plane += usize::from((blocker >= on_plane) != (truth > 0.5));
        let own = (hit.position - start).dot(direction);
        for (wrong, factor) in by_texel.iter_mut().zip(factors) {
            *wrong += usize::from((blocker >= own - factor * side) != (truth > 0.5));
        }
    }
    (by_plane, by_texel)
}

#[test]
fn the_plane_errs_no_more_than_the_best_bias_in_world_space() {
    let scenes = scenes::all();
    let factors = [0.0, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];
    let (mut by_plane, mut by_texel) = (0, vec![0; factors.len()]);
    for (name, kind) in [
        ("cube on floor", SPOT),
        ("cube, light at 8°", LightKind::Directional),
        ("sphere, grazing", LightKind::Point),
    ] {
        let scene = scenes
            .iter()
            .find(|known| known.name == name)
            .expect("it is known");
        let (plane, texel) = wrong_by_bias(scene, kind, &factors);
        by_plane += plane;
        by_texel
            .iter_mut()
            .zip(texel)
            .for_each(|(sum, wrong)| *sum += wrong);
    }
    println!("wrong pixels by the plane {by_plane}, by {factors:?} texels {by_texel:?}");
    let best = by_texel.iter().min().expect("factors were tried");
    // Which factor is best is known afterwards only.
    assert!(10 * by_plane <= 11 * *best, "{by_plane} {by_texel:?}");
}

/// Soft filters reach as far in metres as those of a plain map: the two agree up to the plain map's noise.
#[test]
fn soft_filters_are_as_wide_as_those_of_plain_maps() {
    // The cube floats, because plain maps are not dark in creases.
    let mut scene = scenes::all().swap_remove(0);
    scene.objects[1].1.translation.y += 0.4;
    for (kind, softness) in [(SPOT, 0.02), (LightKind::Directional, 0.06)] {
        for filter in [
            MapFilter::Soft4 { softness },
            MapFilter::Jittered {
                softness,
                adaptive: true,
            },
        ] {
            let mut pictures = Vec::new();
            for plain in [true, false] {
                let (mut stage, _) = scene.stage(&strict_context());
                let (light, place) = scene.light(kind);
                let entity = stage.spawn_light(light, place, None::<StencilVolume>);
                let mut entity = stage.world.entity_mut(entity);
                let map = PerspectiveMap {
                    filter,
                    ..variants(1024)[0]
                };
                if plain {
                    entity.insert(ShadowMap {
                        filter,
                        resolution: map.resolution,
                        ..Default::default()
                    });
                } else {
                    entity.insert(map);
                }
                pictures.push(stage.render().expect("the frame renders").visibility[0].clone());
            }
            let between = |v: &&f32| **v > 0.1 && **v < 0.9;
            let soft = [0, 1].map(|i: usize| pictures[i].iter().filter(between).count() as f64);
            let mean = [0, 1].map(|i: usize| {
                pictures[i].iter().map(|v| f64::from(*v)).sum::<f64>() / pictures[i].len() as f64
            });
            println!("{kind:?} {filter:?}: soft pixels {soft:?}, means {mean:?}");
            assert!(
                soft[0] > 40.0 && (soft[1] / soft[0] - 1.0).abs() < 0.3,
                "{kind:?} {filter:?}: {soft:?}"
            );
            assert!((mean[0] - mean[1]).abs() < 0.005, "{kind:?} {filter:?}: {mean:?}");
        }
    }
}
