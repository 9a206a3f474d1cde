//! Shapes and distances scale what a light gives at each pixel as their twins on the CPU say.

use antumbra::prelude::*;
use antumbra::scene::{LightDistance, LightShape};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::{floor_and_ball, hits, inner_pixels, place, put, relight, render, rgb, stage};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Largest error of a pixel, as a share of what the light gives there. The mask and two radiances are half floats, and
/// each is rounded by at most 1/4096.
const SHARE: f32 = 1.0 / 500.0;

/// Where the factor is smaller than this, its error is measured in this unit: near the end of an edge, the position of a
/// surface moves the factor by more than its own size.
const FLOOR: f32 = 0.01;

/// The factor of a light's model at a point of the world.
fn twin(place: &Transform, shape: Option<LightShape>, distance: Option<LightDistance>, point: Vec3) -> f32 {
    let local = place.rotation.inverse() * (point - place.translation);
    let local = Vec3::new(local.x, local.y, -local.z);
    let depth = LightDistance::depth_of(local, shape.is_some());
    shape.map_or(1.0, |shape| shape.factor(local)) * distance.map_or(1.0, |distance| distance.factor(depth))
}

/// Compares a light with a model to the same light without, at every pixel. Returns how many pixels were on an edge.
fn compare(
    stage: &mut Stage,
    light: Light,
    shadow: impl Bundle + Clone,
    shape: Option<LightShape>,
    distance: Option<LightDistance>,
) -> usize {
    relight(stage, light.clone(), shadow.clone());
    let whole = render(stage);
    let entity = relight(stage, light.clone(), shadow);
    put(stage, entity, shape);
    put(stage, entity, distance);
    let shaped = render(stage);
    let (scene, hits) = hits(stage);
    let mut edges = 0;
    for pixel in inner_pixels(&scene, &hits) {
        let hit = hits.hits[pixel].expect("an inner pixel shows something");
        let factor = twin(&place(), shape, distance, hit.position.as_vec3());
        for (got, whole) in rgb(&shaped, pixel).into_iter().zip(rgb(&whole, pixel)) {
            let expected = whole * factor;
            let allowed = SHARE * whole * factor.max(FLOOR) + 1e-6;
            assert!(
                (got - expected).abs() <= allowed,
                "{:?} {shape:?} {distance:?} at {}: {got}, not {expected} of {whole}",
                light.kind,
                hit.position
            );
        }
        edges += usize::from((0.05..0.95).contains(&factor) && rgb(&whole, pixel)[0] > 0.01);
    }
    edges
}

#[test]
fn every_pixel_has_the_factor_of_the_twin() {
    let mut stage = stage(&strict_context());
    let [_, ball] = floor_and_ball(&mut stage);
    stage.world.entity_mut(ball).remove::<ShadowCaster>();
    let light = |kind| Light {
        kind,
        ..Light::point(Vec3::new(1.0, 0.8, 0.6), 60.0, f32::INFINITY)
    };
    let kinds = [
        LightKind::Point,
        LightKind::Spot {
            inner_angle: 0.5,
            outer_angle: 0.9,
        },
        LightKind::Rect {
            width: 0.4,
            height: 0.2,
        },
        LightKind::Sphere { radius: 0.2 },
    ];
    let shapes = [0.0, 0.4, 1.0].map(|round| LightShape {
        width: 0.3,
        height: 0.15,
        width_edge: 0.2,
        height_edge: 0.25,
        round,
    });
    let distance = LightDistance {
        near: 2.4,
        far: 3.0,
        near_edge: 0.6,
        far_edge: 1.2,
    };
    let mut edges = 0;
    for (kind, shape) in kinds.into_iter().zip(shapes.into_iter().cycle()) {
        edges += compare(&mut stage, light(kind), (), Some(shape), None);
        edges += compare(&mut stage, light(kind), (), None, Some(distance));
        edges += compare(
            &mut stage,
            light(kind),
            StencilVolume::default(),
            Some(shape),
            Some(distance),
        );
    }
    for shape in shapes {
        edges += compare(
            &mut stage,
            light(LightKind::Point),
            OmniMap::default(),
            Some(shape),
            Some(distance),
        );
    }
    assert!(edges > 2000, "{edges} pixels are on an edge");
}

#[test]
#[should_panic(expected = "not")]
fn another_shape_would_be_found() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let shape = LightShape {
        width: 0.3,
        height: 0.15,
        width_edge: 0.2,
        height_edge: 0.25,
        round: 0.4,
    };
    let light = Light::point(Vec3::ONE, 60.0, f32::INFINITY);
    relight(&mut stage, light.clone(), ());
    let whole = render(&mut stage);
    relight(&mut stage, light, LightShape { width: 0.31, ..shape });
    let shaped = render(&mut stage);
    let (scene, hits) = hits(&mut stage);
    for pixel in inner_pixels(&scene, &hits) {
        let hit = hits.hits[pixel].expect("an inner pixel shows something");
        let factor = twin(&place(), Some(shape), None, hit.position.as_vec3());
        let (got, whole) = (rgb(&shaped, pixel)[0], rgb(&whole, pixel)[0]);
        assert!(
            (got - whole * factor).abs() <= SHARE * whole * factor.max(FLOOR) + 1e-6,
            "{got}, not {}",
            whole * factor
        );
    }
}

#[test]
fn a_light_fades_towards_its_own_range_when_that_changes_beyond_its_distance() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let light = |range| Light::point(Vec3::ONE, 40.0, range);
    let distance = LightDistance {
        far: 5.0,
        far_edge: 1.0,
        ..LightDistance::default()
    };
    let mut of = |range| {
        relight(&mut stage, light(range), distance);
        render(&mut stage).radiance
    };
    let (far, near) = (of(100.0), of(6.5));
    let apart = far.iter().zip(&near).filter(|(far, near)| far > near).count();
    assert!(apart > 1000, "{apart} values tell the ranges apart");
    let entity = relight(&mut stage, light(100.0), distance);
    assert_eq!(render(&mut stage).radiance, far);
    *stage.world.get_mut::<Light>(entity).expect("it is a light") = light(6.5);
    assert_eq!(render(&mut stage).radiance, near);
}
