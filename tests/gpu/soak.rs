//! A scene that changes in every frame leaves nothing behind.

use glam::UVec2;

use crate::harness::support::soak::Soak;
use crate::harness::{own_context, strict_context};
use antumbra::prelude::*;
use antumbra::silhouettes::Silhouettes;

const SIZE: UVec2 = UVec2::new(64, 36);

/// More frames than anything is kept after its last use.
const FORGOTTEN: u64 = antumbra::silhouettes::KEPT_FRAMES + 10;

fn soak(seed: u64) -> Soak {
    Soak::new(SIZE, seed, strict_context).expect("the device draws")
}

#[test]
fn what_came_and_went_changes_no_picture() {
    let mut soak = soak(1);
    soak.clear(1).expect("the frame renders");
    let before = soak.stage.radiance_bytes().expect("it is read back");
    let mut different = false;
    for _ in 0..200 {
        soak.step().expect("the frame renders");
        let now = soak.stage.radiance_bytes().expect("it is read back");
        different |= now.len() == before.len() && now != before;
    }
    assert!(different && soak.drawn > 100, "something was to be seen");
    soak.clear(FORGOTTEN).expect("the frame renders");
    assert!(before == soak.stage.radiance_bytes().expect("it is read back"));
    assert!(soak.stage.world.resource::<Silhouettes>().lights().is_empty());
    assert_eq!(soak.stage.object_count(), 1, "the ground");
    let frames = soak.stage.world.resource::<FrameLights>();
    assert!(frames.lights.is_empty() && frames.skipped.is_empty());
}

#[test]
fn a_lost_device_is_replaced() {
    let device = || own_context(RequestedFeatures::default());
    let mut soak = Soak::new(SIZE, 2, device).expect("the device draws");
    for _ in 0..30 {
        soak.step().expect("the frame renders");
    }
    soak.lose_the_device().expect("another device draws");
    for _ in 0..30 {
        soak.step().expect("the frame renders");
    }
    assert_eq!(soak.lost, 1);
}
