//! A light function scales what a light gives, whatever its technique, in a frame of our own and in a host's.

use antumbra::prelude::*;
use bevy_ecs::prelude::*;

use super::comparison::both;
use super::scenes::{alone, camera, light_at, stage};
use crate::harness::half::Half;
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

fn halve(stage: &mut Stage) {
    let mut renderer = stage.world.resource_mut::<Renderer>();
    let half = Half::new(renderer.gpu());
    renderer
        .add_light_function(Box::new(half))
        .expect("shaders compose");
}

/// Radiance without a light function and with one, of a light that is there or dark.
fn radiance(
    context: &RenderContext,
    shadow: impl Bundle,
    halved: bool,
    dark: bool,
    receives: bool,
) -> Vec<f32> {
    let mut stage = stage(context, camera());
    light_at(&mut stage, LightKind::Point, shadow);
    if !receives {
        let mut receivers = stage.world.query_filtered::<Entity, With<ShadowReceiver>>();
        for receiver in receivers.iter(&stage.world).collect::<Vec<_>>() {
            stage.world.entity_mut(receiver).remove::<ShadowReceiver>();
        }
    }
    if dark {
        let light = stage.lights[0];
        stage.world.get_mut::<Light>(light).expect("it shines").intensity = 0.0;
    }
    if halved {
        halve(&mut stage);
    }
    stage.render().expect("the frame renders").radiance
}

#[test]
fn half_of_each_light_is_added_in_a_frame_of_our_own() {
    fn check(name: &str, shadow: impl Bundle + Clone) {
        let context = strict_context();
        for receives in [true, false] {
            let render = |halved, dark| radiance(&context, shadow.clone(), halved, dark, receives);
            let (whole, half, ambient) = (render(false, false), render(true, false), render(false, true));
            let mut lit = 0;
            for at in (0..whole.len()).filter(|at| at % 4 != 3) {
                let (whole, half) = (whole[at] - ambient[at], half[at] - ambient[at]);
                // Half floats, in which the sums are rounded.
                let rounding = 2e-3 * (whole.abs() + ambient[at]);
                assert!(
                    (half - 0.5 * whole).abs() <= rounding,
                    "{name}: {half} of {whole}"
                );
                lit += usize::from(whole > 0.05);
            }
            assert!(lit > 1000, "{name}: {lit} values are lit");
        }
    }
    check("none", ());
    check("stencil", StencilVolume::default());
    check("map", OmniMap::default());
}

#[test]
fn half_of_each_light_is_added_by_a_host() {
    fn check(name: &str, shadow: impl Bundle + Clone) {
        let context = strict_context();
        let view = alone(&camera());
        let pictures = [false, true].map(|halved| {
            let mut stage = stage(&context, camera());
            light_at(&mut stage, LightKind::Point, shadow.clone());
            if halved {
                halve(&mut stage);
            }
            let [_, hosted] = both(&context, &mut stage, view);
            hosted
        });
        let [whole, half] = pictures;
        let seen = whole.iter().filter(|value| **value > 0.0).count();
        assert!(
            (500..whole.len()).contains(&seen),
            "{name}: {seen} pixels are seen"
        );
        for (whole, half) in whole.iter().zip(&half) {
            assert_eq!(*half, 0.5 * whole, "{name}");
        }
    }
    check("stencil", StencilVolume::default());
    check("map", OmniMap::default());
}
