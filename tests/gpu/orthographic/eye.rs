//! The place of the eye of an orthographic view along its direction, which changes nothing but near and far.

use antumbra::prelude::*;
use antumbra::techniques::{Settings, Techniques};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::ground;
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Metres by which the eye is moved. It comes to lie under the ground, which it still sees from above.
const FORWARD: f32 = 12.0;

/// Visibility with the eye before all surfaces, and behind all of them.
fn visibilities(context: &RenderContext, light: &Light, settings: &Settings) -> [Vec<f32>; 2] {
    [0.0, FORWARD].map(|forward| {
        let mut stage: Stage = ground(context, 3.6, -forward, 30.0 - forward);
        let camera = stage.camera;
        let mut view = stage.world.get_mut::<Transform>(camera).expect("a place");
        let along = *view.forward();
        view.translation += forward * along;
        let place = Transform::from_xyz(2.2, 2.7, 1.3).looking_at(Vec3::ZERO, Vec3::X);
        stage.spawn_shadowed(light.clone(), place, Some(settings));
        stage.render().expect("the frame renders").visibility.remove(0)
    })
}

#[test]
fn surfaces_may_lie_behind_the_eye_under_every_technique() {
    let context = strict_context();
    let of = |kind| Light {
        kind,
        ..Light::point(Vec3::ONE, 40.0, 20.0)
    };
    let spot = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    let lights = [LightKind::Sphere { radius: 0.2 }, LightKind::Point, spot].map(of);
    let mut tried = 0;
    for row in Techniques::default().rows() {
        let settings = row.defaults();
        for light in lights.iter().filter(|light| settings.check(light).is_ok()) {
            tried += 1;
            let [before, behind] = visibilities(&context, light, &settings);
            let dark = before.iter().filter(|&&v| v < 0.5).count();
            let different = before.iter().zip(&behind).filter(|(a, b)| (*a - *b).abs() > 0.1);
            let different = different.count();
            println!(
                "{row:?}, {:?}: {different} pixels differ, {dark} dark",
                light.kind
            );
            assert!((150..6000).contains(&dark), "{row:?}: {dark}");
            assert!(different <= before.len() / 200, "{row:?}: {different} differ");
        }
    }
    assert!(tried >= 8, "{tried} lights");
}
