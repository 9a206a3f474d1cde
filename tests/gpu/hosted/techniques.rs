//! Every technique leaves in a host what it leaves in a frame of our own.

use antumbra::prelude::*;
use bevy_ecs::prelude::*;

use super::comparison::{both, differing};
use super::scenes::{alone, camera, light_at, parallel, stage};
use crate::harness::strict_context;

/// In perspective, and in an orthographic view.
fn compare(name: &str, kind: LightKind, shadow: impl Bundle + Clone, tolerance: f32) {
    let context = strict_context(RequestedFeatures::default());
    for camera in [camera(), parallel()] {
        let mut stage = stage(&context, camera);
        light_at(&mut stage, kind, shadow.clone());
        let [own, hosted] = both(&context, &mut stage, alone(&camera));
        let (wrong, judged) = differing(&mut stage, &own, &hosted, tolerance);
        println!("{name}, {camera:?}: {wrong} of {judged} pixels differ off the edges");
        assert_eq!(wrong, 0, "{name}");
        let dark = hosted.iter().filter(|value| **value < 0.5).count();
        assert!((500..judged).contains(&dark), "{name}: {dark} pixels are dark");
    }
}

#[test]
fn another_light_differs() {
    let context = strict_context(RequestedFeatures::default());
    let mut pictures = [LightKind::Point, LightKind::Directional].map(|kind| {
        let mut stage = stage(&context, camera());
        light_at(&mut stage, kind, StencilVolume::default());
        let [own, hosted] = both(&context, &mut stage, alone(&camera()));
        (stage, own, hosted)
    });
    let other = pictures[1].2.clone();
    let (stage, own, _) = &mut pictures[0];
    let (wrong, _) = differing(stage, own, &other, 0.0);
    assert!(wrong > 100, "{wrong} pixels differ");
}

#[test]
fn stencil_volumes_are_as_in_a_frame_of_our_own() {
    compare("stencil", LightKind::Point, StencilVolume::default(), 0.0);
}

#[test]
fn wedges_are_as_in_a_frame_of_our_own() {
    let kind = LightKind::Rect {
        width: 0.6,
        height: 0.4,
    };
    compare("wedges", kind, PenumbraWedge::default(), 0.04);
}

#[test]
fn maps_are_as_in_a_frame_of_our_own() {
    compare("omni map", LightKind::Point, OmniMap::default(), 0.1);
    let spot = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    compare("spot map", spot, ShadowMap::default(), 0.1);
}
