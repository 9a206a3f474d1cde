//! Whatever the settings are, no pixel is NaN or negative.

use std::cell::RefCell;

use antumbra::scene::{Cookie, CookieImage, LightProfile, TextureWrap};
use bevy_transform::prelude::Transform;
use glam::{Vec2, Vec3};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

use super::files::{PlaneSymmetry, ies};
use super::scenes::{Scene, kinds};

/// Numbers with their limits, and beyond them.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -4.0f32..4.0,
        1 => prop::sample::select(vec![0.0, 1.0, -1.0, 1e-30, 1e-6, 1e9, 1e30, f32::MAX, f32::INFINITY, f32::NAN]),
    ]
}

#[test]
fn nothing_is_nan_or_negative() {
    let profile = LightProfile::from_ies(&ies(PlaneSymmetry::None, 45.0, 30.0)).expect("the file is read");
    let bright = CookieImage::from_linear("bright", 2, 1, vec![Vec3::splat(65504.0), Vec3::ZERO]);
    let bright = bright.expect("a picture");
    let scenes = kinds().map(|(_, kind)| RefCell::new(Scene::new(kind)));
    let config = Config {
        cases: 200,
        failure_persistence: None,
        ..Config::default()
    };
    let wraps = prop::sample::select(vec![TextureWrap::Repeat, TextureWrap::Mirror, TextureWrap::Clamp]);
    let settings = (
        0..5usize,
        (number(), number(), number(), number(), number()),
        (wraps.clone(), wraps),
        any::<bool>(),
        prop::option::of((number(), number(), number())),
    );
    let result = TestRunner::new_with_rng(
        config,
        proptest::test_runner::TestRng::deterministic_rng(proptest::test_runner::RngAlgorithm::ChaCha),
    )
    .run(&settings, |(kind, numbers, wrap, has_profile, place)| {
        let scene = &mut *scenes[kind].borrow_mut();
        let (density, size, x, y, turn) = numbers;
        let cookie = Cookie {
            density,
            size,
            offset: Vec2::new(x, y),
            turn,
            wrap: [wrap.0, wrap.1],
            ..Cookie::new(bright.clone())
        };
        let mut light = scene.stage.world.entity_mut(scene.light);
        light.insert(cookie);
        if has_profile {
            light.insert(profile.clone());
        } else {
            light.remove::<LightProfile>();
        }
        if let Some((x, y, z)) = place {
            light.insert(Transform::from_xyz(x, y, z).looking_at(Vec3::ZERO, Vec3::Y));
        }
        scene.stage.schedule.run(&mut scene.stage.world);
        let wrong = scene
            .radiance()
            .iter()
            .filter(|pixel| !(pixel.min_element() >= 0.0 && pixel.is_finite()))
            .count();
        prop_assert_eq!(wrong, 0);
        Ok(())
    });
    result.unwrap_or_else(|error| panic!("{error}"));
}
