//! Every technique leaves in a host what it leaves in a frame of our own.

use antumbra::prelude::*;
use antumbra::techniques::{NeededSilhouettes, Techniques};
use bevy_ecs::prelude::*;
use glam::Vec3;

use super::comparison::{both, differing};
use super::scenes::{alone, camera, light_at, parallel, stage};
use crate::harness::strict_context;

/// In perspective, and in an orthographic view.
fn compare(name: &str, kind: LightKind, shadow: impl Fn(&mut EntityWorldMut), tolerance: f32) {
    let context = strict_context();
    for camera in [camera(), parallel()] {
        let mut stage = stage(&context, camera);
        light_at(&mut stage, kind, ());
        let light = stage.lights[0];
        shadow(&mut stage.world.entity_mut(light));
        let [own, hosted] = both(&context, &mut stage, alone(&camera));
        let (wrong, judged) = differing(&mut stage, &own, &hosted, tolerance);
        println!("{name}, {camera:?}: {wrong} of {judged} pixels differ off the edges");
        // Light below the horizon of a sphere's receivers is cut by their planes, which a host's depth leaves unknown at a few
        // pixels of outlines.
        let allowed = match kind {
            LightKind::Sphere { .. } => judged / 500,
            _ => 0,
        };
        assert!(wrong <= allowed, "{name}: {wrong}");
        let dark = hosted.iter().filter(|value| **value < 0.5).count();
        assert!((500..judged).contains(&dark), "{name}: {dark} pixels are dark");
    }
}

#[test]
fn another_light_differs() {
    let context = strict_context();
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
fn every_technique_leaves_in_a_host_what_it_leaves_in_a_frame_of_our_own() {
    let rect = LightKind::Rect {
        width: 0.6,
        height: 0.4,
    };
    let spot = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    let light = |kind| Light {
        kind,
        ..Light::point(Vec3::ONE, 1.0, 100.0)
    };
    let mut tried = 0;
    for row in Techniques::default().rows() {
        let settings = row.defaults();
        // Soft shadows of an area, and else the first kind of light that fits.
        let kinds = if row.needs().emitter_texture {
            vec![rect]
        } else {
            vec![LightKind::Point, spot, LightKind::Sphere { radius: 0.2 }]
        };
        let kind = kinds
            .into_iter()
            .find(|kind| settings.check(&light(*kind)).is_ok());
        // Stencils are exact, coverage is rounded, and maps have texels.
        let tolerance = match (row.needs().receiver_planes, row.needs().silhouettes) {
            (false, _) => 0.0,
            (true, NeededSilhouettes::Shadowing) => 0.04,
            (true, _) => 0.1,
        };
        let Some(kind) = kind else {
            continue; // it needs more than its defaults
        };
        tried += 1;
        compare(row.name(), kind, |light| settings.insert(light), tolerance);
    }
    assert!(tried >= 6, "{tried} techniques");
}
