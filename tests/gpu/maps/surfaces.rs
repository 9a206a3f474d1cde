//! Second-depth and midpoint maps are as right as nearest ones on closed casters, whatever the format.

use antumbra::prelude::*;
use antumbra::techniques::maps::{MapFilter, MapFormat, MapSurface};

use super::contacts::Kind;
use super::scenes;
use crate::harness::maps::{Judge, MapError};
use crate::harness::strict_context;

#[test]
fn other_surfaces_shadow_the_same_pixels() {
    let context = strict_context();
    let closed = ["cube on floor", "sphere contact", "row of pillars"];
    for kind in [Kind::Spot, Kind::Sun, Kind::Omni(MapFormat::R32Float)] {
        for surface in [MapSurface::Second, MapSurface::Midpoint] {
            let mut all = MapError::default();
            for scene in scenes::all().iter().filter(|scene| closed.contains(&scene.name)) {
                let (mut stage, rays) = scene.stage(&context);
                let (light, place) = scene.light(kind.light());
                let entity = stage.spawn_light(light, place, None::<StencilVolume>);
                kind.insert(&mut stage.world.entity_mut(entity), MapFilter::Bilinear, surface);
                let rendered = stage.render().expect("the frame renders");
                let judge = Judge::new(&stage, &rays, 0).expect("something casts");
                let error = judge.compare(&rendered.visibility[0]);
                assert!(
                    error.share() <= 0.005,
                    "{} {kind:?} {surface:?}: {error:?}",
                    scene.name
                );
                all.add(error);
            }
            println!("{kind:?} {surface:?}: {all:?}");
            assert_eq!(all.acne, 0);
            assert!(all.dark > 100);
        }
    }
}
