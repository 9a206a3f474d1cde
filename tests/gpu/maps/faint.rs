//! Not even a fifth of a wide filter's taps is dark without cause: what a threshold of one half would not see.

use antumbra::prelude::*;
use antumbra::techniques::maps::{MapFilter, MapFormat, MapSurface};
use glam::UVec2;

use super::contacts::Kind;
use super::scenes;
use crate::harness::maps::Judge;
use crate::harness::strict_context;

/// Pixels of a picture that may be darkened; what is left stands where the ground is seen edge-on from the light.
const ALLOWED: usize = 2;

#[test]
fn lit_even_surfaces_are_not_even_faintly_dark() {
    let context = strict_context();
    let names = [
        "cube on floor",
        "cube, light at 8°",
        "cube, far light",
        "light 5 cm over the floor",
    ];
    for kind in [Kind::Spot, Kind::Sun, Kind::Omni(MapFormat::Depth)] {
        for scene in scenes::all().iter().filter(|scene| names.contains(&scene.name)) {
            let (mut stage, rays) = scene.stage(&context);
            stage.world.insert_resource(ViewportSize(UVec2::new(240, 135)));
            let (light, place) = scene.light(kind.light());
            let entity = stage.spawn_light(light, place, None::<StencilVolume>);
            kind.insert(
                &mut stage.world.entity_mut(entity),
                MapFilter::Brute4x4,
                MapSurface::Nearest,
            );
            let rendered = stage.render().expect("the frame renders");
            let mut judge = Judge::new(&stage, &rays, 0).expect("something casts");
            judge.band = 3.5;
            let faint = |got: &[f32]| {
                let pairs = got.iter().zip(judge.truth.values()).zip(&judge.hits.hits);
                pairs
                    .filter(|((got, truth), _)| **got < 0.9 && **truth == 1.0)
                    .filter(|(_, hit)| hit.as_ref().is_some_and(|hit| judge.is_even_from_light(hit)))
                    .count()
            };
            let count = faint(&rendered.visibility[0]);
            assert!(count <= ALLOWED, "{} {kind:?}: {count}", scene.name);
            assert!(faint(&vec![0.8; 240 * 135]) > 1000, "the count can fail");
        }
    }
}
