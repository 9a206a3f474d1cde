//! Occlusion changes what a frame costs and not what it shows. Along a walk of 200 views through each scene the batches of
//! all lights are counted, and pictures with and without occlusion compared bit for bit. They are drawn small and with
//! some of the lights, for the software driver's sake.

use std::sync::Arc;

use crate::harness::support::stats::Batches;
use crate::harness::support::table::{Row, Walked, rows};
use crate::harness::{model, strict_context};
use antumbra::prelude::*;
use antumbra::scene::Occluder;
use bevy_ecs::prelude::*;
use glam::UVec2;

const FRAMES: usize = 200;
/// One of so many views is drawn.
const EVERY: usize = 3;
const SIZE: UVec2 = UVec2::new(64, 36);

/// Bytes of a pixel of the radiance.
const PIXEL: usize = 8;

fn pictures(walked: &mut Walked, row: &Row, frames: impl Iterator<Item = usize>) -> Vec<Vec<u8>> {
    walked.set_row(row);
    frames
        .map(|frame| {
            walked.draw(frame).expect("the frame draws");
            walked.stage.radiance_bytes().expect("the picture is read")
        })
        .collect()
}

/// Frames and pixels that differ.
fn differing(a: &[Vec<u8>], b: &[Vec<u8>]) -> Vec<(usize, usize)> {
    let pixels = |frame: usize| {
        let pairs = a[frame].chunks(PIXEL).zip(b[frame].chunks(PIXEL)).enumerate();
        pairs
            .filter(|(_, (a, b))| a != b)
            .map(move |(pixel, _)| (frame, pixel))
    };
    (0..a.len()).flat_map(pixels).collect()
}

fn walked(file: &str, shines: fn(usize) -> bool) -> Walked {
    Walked::new(&model(file), &strict_context(), SIZE, FRAMES, shines).expect("the scene loads")
}

fn count_batches(file: &str) {
    let mut walked = walked(file, |_| true);
    let totals = rows().map(|row| {
        walked.set_row(&row);
        let mut sum = Batches::default();
        for frame in 0..FRAMES {
            sum += walked.count(frame).expect("the frame is prepared");
        }
        println!("{file}: {:<26} {:>7} {sum:?}", row.name, sum.total());
        sum.total()
    });
    let [before, .., after] = totals;
    println!(
        "{file}: {:.1} % fewer batches than by the frustum alone",
        100.0 * (1.0 - after as f64 / before as f64)
    );
    assert!(
        totals.is_sorted_by(|a, b| a >= b),
        "each step leaves fewer: {totals:?}"
    );
    assert!(after * 10 <= before * 4, "{after} of {before} batches are left");
}

fn compare_pictures(file: &str, shines: fn(usize) -> bool) {
    let mut walked = walked(file, shines);
    let [frustum, .., all] = rows();
    let frames = || (0..FRAMES).step_by(EVERY);
    let without = pictures(&mut walked, &frustum, frames());
    let with = pictures(&mut walked, &all, frames());
    assert!(with.iter().any(|picture| picture != &with[0]), "the walk moves");
    let differing = differing(&without, &with);
    let pixels = without.len() * SIZE.element_product() as usize;
    println!(
        "{file}: {} of {pixels} pixels differ: {differing:?}",
        differing.len()
    );
    assert!(differing.is_empty(), "{file}: frames and pixels {differing:?}");
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn dungeon_has_fewer_batches() {
    count_batches("dungeon_A.glb");
}

#[test]
fn interior_has_fewer_batches() {
    count_batches("interior.glb");
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn dungeon_pictures_are_equal() {
    compare_pictures("dungeon_A.glb", |light| light % 6 == 0);
}

#[test]
fn interior_pictures_are_equal() {
    compare_pictures("interior.glb", |light| light % 4 == 0);
}

#[test]
fn a_lying_occluder_shows() {
    let mut walked = walked("interior.glb", |light| light == 0);
    let [frustum, .., all] = rows();
    let frames = || (0..FRAMES).step_by(20);
    let without = pictures(&mut walked, &frustum, frames());
    let world = &mut walked.stage.world;
    let things: Vec<(Entity, SceneMesh)> = world
        .query::<(Entity, &SceneMesh)>()
        .iter(world)
        .map(|(entity, mesh)| (entity, mesh.clone()))
        .collect();
    for (entity, mesh) in things {
        let mut bigger = (*mesh.0).clone();
        bigger.positions.iter_mut().for_each(|position| *position *= 1.5);
        world.entity_mut(entity).insert(Occluder::Proxy(Arc::new(bigger)));
    }
    let with = pictures(&mut walked, &all, frames());
    assert!(differing(&without, &with).len() > 10, "lies show");
}
