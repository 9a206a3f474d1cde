//! The three masks of a light mean the same under every technique, per pixel: on whom it shines, who casts, and who shows
//! the shadow.

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::scene::SelectionLayers;
use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{add, hits, inner_pixels, relight, render, rgb, stage};
use crate::harness::{judge, strict_context};

/// Floor, ball, cube and post, each on a layer of its own.
const LAYERS: [u32; 4] = [2, 4, 8, 16];

fn masks() -> Vec<(&'static str, LightSelection)> {
    let all = LightSelection::default();
    let mut masks = vec![("all", all)];
    for (object, layer) in ["floor", "ball", "cube", "post"].into_iter().zip(LAYERS) {
        let others = !layer;
        masks.push((
            object,
            LightSelection {
                affects: others,
                ..all
            },
        ));
        masks.push((
            object,
            LightSelection {
                casts_for: others,
                ..all
            },
        ));
        masks.push((
            object,
            LightSelection {
                shows_on: others,
                ..all
            },
        ));
    }
    let mixed = LightSelection {
        affects: 2 | 4,
        casts_for: 8 | 16,
        shows_on: 2 | 8,
    };
    masks.push(("mixed", mixed));
    masks
}

#[test]
fn each_pixel_is_as_the_masks_say_under_every_technique() {
    fn check(name: &str, shadow: impl Bundle + Clone, is_shadowed: bool) {
        let mut stage = stage(&strict_context());
        let objects = [
            add(&mut stage, MeshData::plane(12.0), Vec3::ZERO),
            add(&mut stage, MeshData::icosphere(0.5, 3), Vec3::new(0.3, 0.9, 0.2)),
            add(
                &mut stage,
                MeshData::cuboid(Vec3::splat(0.4)),
                Vec3::new(1.5, 0.6, 0.0),
            ),
            add(
                &mut stage,
                MeshData::cuboid(Vec3::new(0.1, 0.8, 0.1)),
                Vec3::new(-0.7, 0.9, 0.6),
            ),
        ];
        for (object, layer) in objects.into_iter().zip(LAYERS) {
            stage.world.entity_mut(object).insert(SelectionLayers(layer));
        }
        let light = Light::point(Vec3::ONE, 40.0, f32::INFINITY);
        relight(&mut stage, light.clone(), ());
        let whole = render(&mut stage);
        for (object, selection) in masks() {
            relight(&mut stage, light.clone(), (shadow.clone(), selection));
            let rendered = render(&mut stage);
            let scene = RayScene::from_world(&mut stage.world);
            if is_shadowed {
                let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
                assert!(
                    error.share().is_none_or(|share| share < 0.02),
                    "{name}, {object} {selection:?}: {error:?}"
                );
            }
            let (scene, hits) = hits(&mut stage);
            for pixel in inner_pixels(&scene, &hits) {
                let hit = hits.hits[pixel].expect("an inner pixel shows something");
                let layers = scene.triangles()[hit.triangle as usize].layers;
                let (got, whole) = (rgb(&rendered, pixel)[0], rgb(&whole, pixel)[0]);
                if layers & selection.affects == 0 {
                    assert_eq!(
                        got, 0.0,
                        "{name}, {object}: a light adds to what it does not affect"
                    );
                } else if !is_shadowed || layers & selection.shows_on == 0 {
                    assert!(
                        (got - whole).abs() <= 1e-3 * whole,
                        "{name}, {object}: {got} of {whole}"
                    );
                } else {
                    let seen = rendered.visibility[0][pixel];
                    assert!(
                        (got - whole * seen).abs() <= 2e-3 * whole,
                        "{name}, {object}: {got} of {whole}"
                    );
                }
            }
        }
    }
    check("none", (), false);
    check("volume", StencilVolume::default(), true);
    check("wedge", PenumbraWedge::default(), true);
    check("map", OmniMap::default(), true);
}
