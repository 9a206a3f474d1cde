//! A host adds a light through its cookie and by its profile.

use antumbra::prelude::*;
use bevy_ecs::prelude::*;
use glam::Vec3;

use super::comparison::both;
use super::scenes::{alone, camera, light_at, stage};
use crate::harness::strict_context;

/// The shares of one light that a host adds. The host of the tests reads red.
fn hosted(kind: LightKind, shadow: impl Bundle, textures: impl Bundle) -> Vec<f32> {
    let context = strict_context();
    let mut stage = stage(&context, camera());
    light_at(&mut stage, kind, shadow);
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(textures);
    let [_, hosted] = both(&context, &mut stage, alone(&camera()));
    hosted
}

#[test]
fn a_host_adds_the_share_that_passes_the_picture() {
    fn check(name: &str, shadow: impl Bundle + Clone) {
        let kind = LightKind::Point;
        let image =
            CookieImage::from_linear("red", 1, 1, vec![Vec3::new(0.25, 0.0, 0.0)]).expect("a picture");
        let plain = hosted(kind, shadow.clone(), ());
        let colored = hosted(kind, shadow, Cookie::around(image));
        let seen = plain.iter().filter(|value| **value > 0.0).count();
        assert!(
            (500..plain.len()).contains(&seen),
            "{name}: {seen} pixels are seen"
        );
        for (plain, colored) in plain.iter().zip(&colored) {
            assert_eq!(*colored, 0.25 * plain, "{name}");
        }
    }
    check("stencil", StencilVolume::default());
    check("map", OmniMap::default());
}

#[test]
fn a_host_adds_the_share_of_the_profile() {
    let text = "TILT=NONE\n1 -1 1 2 1 1 2 0 0 0\n1 1 1\n0 90\n0\n100 0\n";
    let profile = LightProfile::from_ies(text).expect("the file is read");
    let plain = hosted(LightKind::Point, StencilVolume::default(), ());
    let shaped = hosted(LightKind::Point, StencilVolume::default(), profile);
    let lit = |shares: &[f32], least: f32| shares.iter().filter(|share| **share > least).count();
    assert_eq!(lit(&plain, 0.0), lit(&plain, 0.99), "visibility is 0 or 1");
    assert!(lit(&shaped, 0.9) > 20, "below the light it is nearly whole");
    assert!(
        lit(&shaped, 0.9) < lit(&plain, 0.9) / 2,
        "and to the sides it falls off"
    );
    for (plain, shaped) in plain.iter().zip(&shaped) {
        assert!((0.0..=*plain).contains(shaped));
    }
}
