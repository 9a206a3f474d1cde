//! The light model holds on blended surfaces, one behind the other.

use antumbra::prelude::*;
use antumbra::scene::LightShape;
use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{add_of, hits, place, relight, render, rgb, stage};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Two thin panes, one over the other.
fn panes(stage: &mut Stage) -> [Entity; 2] {
    let mut pane = Material::matte(Vec3::new(0.7, 0.6, 0.5));
    pane.alpha_mode = AlphaMode::Blend;
    pane.base_color.w = 0.5;
    pane.double_sided = false;
    [0.0, 0.5].map(|height| {
        add_of(
            stage,
            MeshData::plane(6.0),
            Vec3::new(0.0, height, 0.0),
            pane.clone(),
        )
    })
}

#[test]
fn panes_outside_of_the_shape_stay_dark() {
    fn check(name: &str, shadow: impl Bundle + Clone) {
        let mut stage = stage(&strict_context());
        panes(&mut stage);
        let shape = LightShape {
            width: 0.35,
            height: 0.35,
            ..LightShape::default()
        };
        let light = Light::point(Vec3::ONE, 60.0, f32::INFINITY);
        relight(&mut stage, light.clone(), shadow.clone());
        let whole = render(&mut stage);
        relight(&mut stage, light, (shadow, shape));
        let shaped = render(&mut stage);
        let (_, hits) = hits(&mut stage);
        // The same ray meets both planes: above one point of the floor, the light reaches another point.
        let eye = stage
            .world
            .get::<bevy_transform::prelude::GlobalTransform>(stage.camera)
            .expect("there is a camera")
            .translation();
        let (mut dark, mut lit) = (0, 0);
        for (pixel, hit) in hits.hits.iter().enumerate() {
            let Some(hit) = hit else { continue };
            let ray = hit.position.as_vec3() - eye;
            let factors = [0.0, 0.5].map(|height| {
                let point = eye + ray * ((height - eye.y) / ray.y);
                let local = place().rotation.inverse() * (point - place().translation);
                let near = |by: f32| {
                    let grown = LightShape {
                        width: 0.35 + by,
                        height: 0.35 + by,
                        ..shape
                    };
                    grown.factor(Vec3::new(local.x, local.y, -local.z))
                };
                (near(0.02), near(-0.02))
            });
            let (got, whole) = (rgb(&shaped, pixel)[0], rgb(&whole, pixel)[0]);
            if factors.iter().all(|(grown, _)| *grown == 0.0) {
                assert_eq!(got, 0.0, "{name}: of {whole} at {}", hit.position);
                dark += usize::from(whole > 0.0);
            } else if factors.iter().all(|(_, shrunk)| *shrunk == 1.0) {
                assert!((got - whole).abs() <= 2e-3 * whole, "{name}: {got} of {whole}");
                lit += 1;
            }
        }
        assert!(dark > 200 && lit > 30, "{name}: {dark} dark, {lit} lit");
    }
    check("none", ());
    check("stencil", StencilVolume::default());
    check("map", OmniMap::default());
}

#[test]
fn a_pane_that_a_light_does_not_affect_shows_nothing_of_it() {
    let mut stage = stage(&strict_context());
    let [lower, upper] = panes(&mut stage);
    let light = Light::point(Vec3::ONE, 60.0, f32::INFINITY);
    let only = |bit: u32| LightSelection {
        affects: bit,
        ..LightSelection::default()
    };
    for (pane, bit) in [(lower, 2), (upper, 4)] {
        stage
            .world
            .entity_mut(pane)
            .insert(antumbra::scene::SelectionLayers(bit));
    }
    let mut sum = |bit| {
        relight(&mut stage, light.clone(), (OmniMap::default(), only(bit)));
        render(&mut stage).radiance.iter().sum::<f32>()
    };
    let (neither, below, above, both) = (sum(8), sum(2), sum(4), sum(6));
    let alpha = neither; // what is left is the alpha of the background
    let (below, above, both) = (below - alpha, above - alpha, both - alpha);
    assert!(below > 1.0 && above > 1.0, "{below}, {above}");
    assert!(
        (below + above - both).abs() < 0.01 * both,
        "{below} + {above} is not {both}"
    );
}
