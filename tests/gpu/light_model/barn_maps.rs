//! The barn map gives what the formula gives, within its stated error, and is made when the shape changes alone.

use antumbra::prelude::*;
use antumbra::scene::{BarnMap, LightDistance, LightShape};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::{floor_and_ball, hits, inner_pixels, place, put, relight, render, rgb, stage};
use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};

/// Rounding of half floats, and of filters whose weights have 8 bits.
const ROUNDING: f32 = 1.0 / 500.0;

fn light() -> Light {
    Light::point(Vec3::new(1.0, 0.8, 0.6), 60.0, f32::INFINITY)
}

fn soft(round: f32) -> LightShape {
    LightShape {
        width: 0.3,
        height: 0.15,
        width_edge: 0.2,
        height_edge: 0.25,
        round,
    }
}

fn maps_made(stage: &Stage) -> usize {
    stage.world.resource::<Renderer>().barn_maps_made()
}

/// Compares a mapped shape with its twins at every pixel. Returns the largest difference to the formula.
fn compare(
    stage: &mut Stage,
    shadow: impl Bundle + Clone,
    shape: LightShape,
    distance: Option<LightDistance>,
) -> f32 {
    let map = BarnMap::default();
    assert!(map.holds(&shape), "{shape:?}");
    relight(stage, light(), shadow.clone());
    let whole = render(stage);
    let entity = relight(stage, light(), (shadow, shape, map));
    put(stage, entity, distance);
    let mapped = render(stage);
    let (scene, hits) = hits(stage);
    let (mut largest, mut edges) = (0.0f32, 0);
    for pixel in inner_pixels(&scene, &hits) {
        let hit = hits.hits[pixel].expect("an inner pixel shows something");
        let local = place().rotation.inverse() * (hit.position.as_vec3() - place().translation);
        let local = Vec3::new(local.x, local.y, -local.z);
        let depth = distance.map_or(1.0, |distance| distance.factor(local.z));
        let (twin, formula) = (map.sample(&shape, local) * depth, shape.factor(local) * depth);
        for (got, whole) in rgb(&mapped, pixel).into_iter().zip(rgb(&whole, pixel)) {
            let error = (got - whole * twin).abs();
            assert!(
                error <= ROUNDING * whole + 1e-6,
                "{shape:?} at {}: {got}, not {}",
                hit.position,
                whole * twin
            );
            if whole > 0.01 {
                largest = largest.max((got - whole * formula).abs() / whole);
            }
        }
        edges += usize::from((0.05..0.95).contains(&formula));
    }
    assert!(edges > 100, "{edges} pixels are on an edge");
    largest
}

#[test]
fn a_map_gives_the_factor_of_the_formula_within_its_error() {
    let mut stage = stage(&strict_context());
    let [_, ball] = floor_and_ball(&mut stage);
    stage.world.entity_mut(ball).remove::<ShadowCaster>();
    let distance = LightDistance {
        near: 2.4,
        far: 3.0,
        near_edge: 0.6,
        far_edge: 1.2,
    };
    let before = maps_made(&stage);
    for (round, distance) in [(0.0, None), (0.4, Some(distance)), (1.0, None)] {
        let error = compare(&mut stage, (), soft(round), distance);
        println!("round {round}: the map differs from the formula by at most {error:.5}");
        assert!(error <= BarnMap::ERROR + ROUNDING, "{error}");
    }
    let error = compare(&mut stage, StencilVolume::default(), soft(0.4), Some(distance));
    assert!(error <= BarnMap::ERROR + ROUNDING, "{error}");
    assert!(maps_made(&stage) >= before + 3, "each shape got a map");
}

#[test]
fn sharp_edges_are_those_of_the_formula_bit_for_bit() {
    // Tests that share a device share its maps, and these are counted.
    let mut stage = stage(&own_context(RequestedFeatures::default()));
    floor_and_ball(&mut stage);
    let sharp = LightShape {
        width_edge: 0.01,
        height_edge: 0.0,
        ..soft(0.4)
    };
    let before = maps_made(&stage);
    relight(&mut stage, light(), sharp);
    let formula = render(&mut stage).radiance;
    relight(&mut stage, light(), (sharp, BarnMap::default()));
    assert!(formula == render(&mut stage).radiance);
    assert_eq!(maps_made(&stage), before, "no map holds it");
    // The same comparison sees a map.
    relight(&mut stage, light(), soft(0.4));
    let formula = render(&mut stage).radiance;
    relight(&mut stage, light(), (soft(0.4), BarnMap { resolution: 200 }));
    assert!(formula != render(&mut stage).radiance);
}

#[test]
fn a_map_is_kept_until_the_shape_changes() {
    // Tests that share a device share its maps, and these are counted.
    let mut stage = stage(&own_context(RequestedFeatures::default()));
    floor_and_ball(&mut stage);
    let mapped = (OmniMap::default(), soft(0.7), BarnMap { resolution: 300 });
    let entity = relight(&mut stage, light(), mapped);
    let twin = stage.spawn_light(light(), Transform::from_xyz(1.0, 3.0, 1.0), Some(mapped));
    let before = maps_made(&stage);
    let first = render(&mut stage);
    assert_eq!(maps_made(&stage), before + 1, "lights of one shape share a map");
    assert!(render(&mut stage).radiance == first.radiance);
    for _ in 0..2 {
        let mut at = stage
            .world
            .get_mut::<Transform>(twin)
            .expect("it stands somewhere");
        at.translation.x += 0.2;
        stage
            .world
            .get_mut::<Light>(entity)
            .expect("it is a light")
            .intensity *= 0.9;
        render(&mut stage);
    }
    assert_eq!(
        maps_made(&stage),
        before + 1,
        "places and intensities need no map"
    );
    // A shape that changes in each frame is right in each frame.
    for step in 1..4 {
        let wider = LightShape {
            width: 0.3 + 0.02 * step as f32,
            ..soft(0.7)
        };
        stage.world.entity_mut(entity).insert(wider);
        let kept = render(&mut stage);
        assert_eq!(maps_made(&stage), before + 1 + step);
        stage.world.entity_mut(entity).remove::<BarnMap>();
        let formula = render(&mut stage);
        stage.world.entity_mut(entity).insert(BarnMap { resolution: 300 });
        let apart = kept
            .radiance
            .iter()
            .zip(&formula.radiance)
            .map(|(a, b)| (a - b).abs());
        let brightest = formula.radiance.iter().copied().fold(0.0, f32::max);
        let error = apart.fold(0.0, f32::max) / brightest;
        assert!(error <= BarnMap::ERROR + ROUNDING, "step {step}: {error}");
    }
}
