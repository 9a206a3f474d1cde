//! Shadows that an artist has moved or softened: they are those of a light at the other place, or of the other size.

use antumbra::prelude::*;
use antumbra::scene::{LightShape, ShadowOrigin, ShadowSoftness};
use antumbra::techniques::maps::MapFilter;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::{floor_and_ball, put, relight, render, stage};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

fn light(kind: LightKind) -> Light {
    Light {
        kind,
        ..Light::point(Vec3::ONE, 40.0, f32::INFINITY)
    }
}

/// Share of values that differ, and the largest difference.
fn differences(a: &[f32], b: &[f32]) -> (usize, f32) {
    let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
    (
        apart.clone().filter(|d| *d > 1e-3).count(),
        apart.fold(0.0, f32::max),
    )
}

/// The visibility of a light whose shadows are moved, and of a light that stands there.
fn moved_and_there(
    stage: &mut Stage,
    kind: LightKind,
    shadow: impl Bundle + Clone,
    origin: ShadowOrigin,
) -> [Vec<f32>; 3] {
    relight(stage, light(kind), shadow.clone());
    let own = render(stage).visibility.remove(0);
    relight(stage, light(kind), (shadow.clone(), origin));
    let moved = render(stage).visibility.remove(0);
    let entity = relight(stage, light(kind), shadow);
    let place = match origin {
        ShadowOrigin::Position(point) => Transform::from_translation(point),
        ShadowOrigin::Direction(falls) => Transform::default().looking_to(falls, Vec3::Y),
    };
    stage.world.entity_mut(entity).insert(place);
    [own, moved, render(stage).visibility.remove(0)]
}

#[test]
fn moved_shadows_are_those_of_a_light_at_the_other_place() {
    fn check(name: &str, kind: LightKind, shadow: impl Bundle + Clone, origin: ShadowOrigin) {
        let mut stage = stage(&strict_context());
        floor_and_ball(&mut stage);
        let [own, moved, there] = moved_and_there(&mut stage, kind, shadow, origin);
        let (wrong, _) = differences(&moved, &there);
        assert_eq!(wrong, 0, "{name}");
        let (apart, _) = differences(&own, &there);
        assert!(apart > 100, "{name}: {apart} pixels tell the places apart");
    }
    let there = ShadowOrigin::Position(Vec3::new(1.5, 2.5, -0.5));
    check("volume", LightKind::Point, StencilVolume::default(), there);
    check("map", LightKind::Point, OmniMap::default(), there);
    check(
        "wedge",
        LightKind::Sphere { radius: 0.2 },
        PenumbraWedge::default(),
        there,
    );
    let falls = ShadowOrigin::Direction(Vec3::new(-1.0, -2.0, 0.3));
    check(
        "directional",
        LightKind::Directional,
        StencilVolume::default(),
        falls,
    );
}

#[test]
fn a_light_with_moved_shadows_shines_from_its_own_place() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    relight(&mut stage, light(LightKind::Point), ());
    let whole = render(&mut stage);
    let origin = ShadowOrigin::Position(Vec3::new(1.5, 2.5, -0.5));
    relight(
        &mut stage,
        light(LightKind::Point),
        (StencilVolume::default(), origin),
    );
    let moved = render(&mut stage);
    let mut shadowed = 0;
    for (pixel, seen) in moved.visibility[0].iter().enumerate() {
        let (got, whole) = (moved.radiance[4 * pixel], whole.radiance[4 * pixel]);
        assert_eq!(got, whole * seen, "pixel {pixel}");
        shadowed += usize::from(*seen == 0.0 && whole > 0.0);
    }
    assert!(shadowed > 50, "{shadowed} pixels");
}

#[test]
fn a_spot_whose_shadows_are_moved_keeps_its_map() {
    let spot = LightKind::Spot {
        inner_angle: 0.3,
        outer_angle: 0.5,
    };
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let origin = ShadowOrigin::Position(Vec3::new(-0.5, 3.5, 1.5));
    let near = Light {
        range: 6.0,
        ..light(spot)
    };
    relight(&mut stage, near.clone(), (StencilVolume::default(), origin));
    let volume = render(&mut stage);
    relight(&mut stage, near, (ShadowMap::default(), origin));
    let map = render(&mut stage);
    // Only lit pixels count: beyond the cone nobody looks.
    let lit: Vec<usize> = (0..volume.visibility[0].len())
        .filter(|pixel| map.radiance[4 * pixel] > 0.0 || volume.radiance[4 * pixel] > 0.0)
        .collect();
    let wrong = lit
        .iter()
        .filter(|&&p| (map.visibility[0][p] - volume.visibility[0][p]).abs() > 0.5)
        .count();
    assert!(
        lit.len() > 150 && wrong * 20 < lit.len(),
        "{wrong} of {}",
        lit.len()
    );
}

#[test]
fn softness_is_the_size_of_the_light_that_wedges_cast_with() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let visibility = |stage: &mut Stage, kind, parts: Option<ShadowSoftness>| {
        let entity = relight(stage, light(kind), PenumbraWedge::default());
        put(stage, entity, parts);
        render(stage).visibility.remove(0)
    };
    let soft = visibility(&mut stage, LightKind::Point, Some(ShadowSoftness(0.3)));
    let sphere = visibility(&mut stage, LightKind::Sphere { radius: 0.3 }, None);
    let hard = visibility(&mut stage, LightKind::Point, None);
    assert_eq!(differences(&soft, &sphere).0, 0);
    assert!(differences(&soft, &hard).0 > 50);
    let rect = |size: f32| LightKind::Rect {
        width: size,
        height: 0.5 * size,
    };
    let half = 0.5 * (1.0f32 + 0.25).sqrt() * 0.6;
    let soft = visibility(&mut stage, rect(0.2), Some(ShadowSoftness(half)));
    let large = visibility(&mut stage, rect(0.6), None);
    let (_, apart) = differences(&soft, &large);
    assert!(apart < 2e-3, "{apart}");
}

#[test]
fn softness_is_the_radius_of_a_maps_filter() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let mut visibility = |filter, softness: Option<ShadowSoftness>| {
        let map = OmniMap {
            filter,
            ..OmniMap::default()
        };
        let entity = relight(&mut stage, light(LightKind::Point), map);
        put(&mut stage, entity, softness);
        render(&mut stage).visibility.remove(0)
    };
    let jittered = |softness| MapFilter::Jittered {
        softness,
        adaptive: true,
    };
    let expected = visibility(jittered(0.05), None);
    assert_eq!(
        visibility(MapFilter::Bilinear, Some(ShadowSoftness(0.05))),
        expected
    );
    assert_eq!(visibility(jittered(0.2), Some(ShadowSoftness(0.05))), expected);
    assert!(differences(&visibility(MapFilter::Bilinear, None), &expected).0 > 50);
}

/// Visibility under a technique, with the softness of the light's model or without.
fn softened(stage: &mut Stage, kind: LightKind, technique: impl Bundle, softness: Option<f32>) -> Vec<f32> {
    let entity = relight(stage, light(kind), technique);
    put(stage, entity, softness.map(ShadowSoftness));
    render(stage).visibility.remove(0)
}

#[test]
fn softness_reaches_perspective_maps_and_smoothies() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let spot = LightKind::Spot {
        inner_angle: 0.4,
        outer_angle: 0.6,
    };
    let map = |filter| PerspectiveMap {
        filter,
        ..PerspectiveMap::default()
    };
    let jittered = MapFilter::Jittered {
        softness: 0.05,
        adaptive: true,
    };
    let expected = softened(&mut stage, spot, map(jittered), None);
    let soft = softened(&mut stage, spot, map(MapFilter::Bilinear), Some(0.05));
    assert_eq!(soft, expected);
    let hard = softened(&mut stage, spot, map(MapFilter::Bilinear), None);
    assert!(differences(&hard, &expected).0 > 50);

    // A smoothie is as wide as that of a sphere of this radius; without a size it is a share of the distance.
    let of_sphere = softened(
        &mut stage,
        LightKind::Sphere { radius: 0.2 },
        Smoothie::default(),
        None,
    );
    let soft = softened(&mut stage, LightKind::Point, Smoothie::default(), Some(0.2));
    assert_eq!(soft, of_sphere);
    let own = softened(&mut stage, LightKind::Point, Smoothie::default(), None);
    assert!(differences(&own, &of_sphere).0 > 50);
    let sun =
        |stage: &mut Stage, softness| softened(stage, LightKind::Directional, Smoothie::default(), softness);
    let (narrow, wide) = (sun(&mut stage, None), sun(&mut stage, Some(5.0)));
    assert!(differences(&narrow, &wide).0 > 20);
}

#[test]
fn maps_shrink_with_the_doors() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let shape = LightShape {
        width: 0.2,
        height: 0.2,
        ..LightShape::default()
    };
    let spot = LightKind::Spot {
        inner_angle: 0.7,
        outer_angle: 1.0,
    };
    let mut angle = |shape: Option<LightShape>| {
        let entity = relight(&mut stage, light(spot), ShadowMap::default());
        put(&mut stage, entity, shape);
        render(&mut stage);
        let (_, angle) = stage.world.resource::<FrameLights>().lights[0]
            .shadow_cone()
            .expect("it is a spot light");
        angle
    };
    assert!((angle(None) - 1.0).abs() < 1e-6);
    assert!((angle(Some(shape)) - 0.2f64.atan()).abs() < 1e-3);
}
