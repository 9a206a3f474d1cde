//! Numbers that cannot be used are reported with the light's entity, and the light still shines.

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::scene::{
    BarnMap, LightDistance, LightShape, LightWeights, ShadowOrigin, ShadowSoftness, ShadowTint,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::{floor_and_ball, relight, render, stage};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// The messages about the light's model, after a frame in which it must shine as without the bad part.
fn reported(stage: &mut Stage, light: Light, parts: impl Bundle) -> Vec<String> {
    relight(stage, light.clone(), StencilVolume::default());
    let without = render(stage);
    let entity = relight(stage, light, (StencilVolume::default(), parts));
    let with = render(stage);
    assert!(without.radiance == with.radiance, "the light shines as without");
    assert!(with.radiance.iter().any(|value| *value > 0.1), "it shines");
    let reports = stage.world.resource::<Reports>();
    let about = reports
        .of_entity(entity)
        .filter(|report| report.topic == "light_model");
    about.map(|report| report.message.clone()).collect()
}

#[test]
fn bad_numbers_are_reported_and_the_light_shines() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let point = || Light::point(Vec3::ONE, 40.0, f32::INFINITY);
    let shape = LightShape {
        width: 0.3,
        height: 0.3,
        ..LightShape::default()
    };
    let mut check = |parts: &dyn Fn(&mut Stage) -> Vec<String>, expected: &str| {
        let messages = parts(&mut stage);
        assert!(
            messages.len() == 1 && messages[0].contains(expected),
            "{expected}: {messages:?}"
        );
    };
    macro_rules! check {
        ($light:expr, $part:expr, $expected:literal) => {
            check(&|stage| reported(stage, $light, $part), $expected)
        };
    }
    check!(
        point(),
        LightShape {
            width_edge: -0.1,
            ..shape
        },
        "width_edge"
    );
    check!(
        point(),
        LightShape {
            height: f32::NAN,
            ..shape
        },
        "height"
    );
    check!(point(), LightShape { round: 2.0, ..shape }, "round");
    check!(
        point(),
        LightShape {
            round: f32::NAN,
            ..shape
        },
        "round"
    );
    let distance = LightDistance {
        near: 3.0,
        far: 1.0,
        ..LightDistance::default()
    };
    check!(point(), distance, "near must be at most far");
    check!(
        point(),
        LightDistance {
            far_edge: -1.0,
            ..LightDistance::default()
        },
        "far_edge"
    );
    check!(
        point(),
        LightWeights {
            diffuse: f32::INFINITY,
            ..LightWeights::default()
        },
        "diffuse"
    );
    check!(
        point(),
        ShadowTint {
            darkness: 1.5,
            ..ShadowTint::default()
        },
        "darkness"
    );
    check!(
        point(),
        ShadowTint {
            color: Vec3::NEG_ONE,
            ..ShadowTint::default()
        },
        "color"
    );
    check!(point(), ShadowOrigin::Position(Vec3::INFINITY), "must be finite");
    check!(point(), ShadowOrigin::Direction(Vec3::X), "needs a position");
    check!(point(), ShadowSoftness(-1.0), "ShadowSoftness");
    check!(point(), BarnMap { resolution: 0 }, "resolution of BarnMap is 0");
    let sun = || Light::directional(Vec3::ONE, 3.0);
    check!(sun(), shape, "LightShape does not fit a directional light");
    check!(sun(), ShadowOrigin::Position(Vec3::ONE), "needs a direction");
    check!(sun(), ShadowOrigin::Direction(Vec3::ZERO), "must have a length");
}

#[test]
fn a_shadow_from_behind_the_light_is_used_and_reported() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let spot = Light {
        kind: LightKind::Spot {
            inner_angle: 0.4,
            outer_angle: 0.6,
        },
        ..Light::point(Vec3::ONE, 40.0, 20.0)
    };
    let behind = ShadowOrigin::Position(super::place().translation * 1.5);
    let entity = relight(&mut stage, spot, (StencilVolume::default(), behind));
    let rendered = render(&mut stage);
    assert!(rendered.radiance.iter().any(|value| *value > 0.1));
    let reports = stage.world.resource::<Reports>();
    let messages: Vec<&str> = reports
        .of_entity(entity)
        .map(|report| report.message.as_str())
        .collect();
    assert!(
        messages.len() == 1 && messages[0].contains("behind the light"),
        "{messages:?}"
    );
}

/// The reports about shadow origins, after a frame.
fn buried(stage: &mut Stage, entity: Entity) -> Vec<String> {
    render(stage);
    let reports = stage.world.resource::<Reports>();
    let about = reports.of_entity(entity);
    let about = about.filter(|report| report.topic == "shadow_origin");
    about.map(|report| report.message.clone()).collect()
}

#[test]
fn a_shadow_from_inside_of_a_caster_is_used_and_reported() {
    let mut stage = stage(&strict_context());
    let [_, ball] = floor_and_ball(&mut stage);
    let point = || Light::point(Vec3::ONE, 40.0, 20.0);
    let inside = ShadowOrigin::Position(Vec3::new(0.1, 1.2, 0.0));
    let entity = relight(&mut stage, point(), (StencilVolume::default(), inside));
    let messages = buried(&mut stage, entity);
    assert!(
        messages.len() == 1 && messages[0].contains("inside of a caster"),
        "{messages:?}"
    );
    assert_eq!(buried(&mut stage, entity), messages, "it stands");
    // The ball moves away and comes back.
    let move_ball = |stage: &mut Stage, x: f32| {
        let mut at = stage
            .world
            .get_mut::<Transform>(ball)
            .expect("it stands somewhere");
        at.translation.x = x;
        buried(stage, entity).len()
    };
    assert_eq!([5.0, 0.3, 1.0].map(|x| move_ball(&mut stage, x)), [0, 1, 0]);
    move_ball(&mut stage, 0.0);
    // Inside of its bounds but not of the ball, without a shadow, and with a ball that does not cast for the light.
    let nobody = LightSelection {
        casts_for: 0,
        ..LightSelection::default()
    };
    let outside = ShadowOrigin::Position(Vec3::new(0.6, 1.6, 0.6));
    let entity = relight(&mut stage, point(), (StencilVolume::default(), outside));
    assert_eq!(buried(&mut stage, entity).len(), 0);
    let entity = relight(&mut stage, point(), inside);
    assert_eq!(buried(&mut stage, entity).len(), 0);
    let entity = relight(&mut stage, point(), (StencilVolume::default(), inside, nobody));
    assert_eq!(buried(&mut stage, entity).len(), 0);
    // A light whose lamp is in the ball too: the ball is its shade.
    let entity = relight(&mut stage, point(), (OmniMap::default(), inside));
    assert_eq!(buried(&mut stage, entity).len(), 1);
    let at = Transform::from_xyz(0.0, 1.0, 0.0);
    stage.world.entity_mut(entity).insert(at);
    assert_eq!(buried(&mut stage, entity).len(), 0);
}

#[test]
fn numbers_at_their_limits_are_no_faults() {
    let mut stage = stage(&strict_context());
    floor_and_ball(&mut stage);
    let sharp = LightShape {
        width: 0.3,
        height: 0.3,
        width_edge: 0.0,
        height_edge: 0.0,
        round: 0.0,
    };
    let entity = relight(&mut stage, Light::point(Vec3::ONE, 40.0, 20.0), sharp);
    let rendered = render(&mut stage);
    assert_eq!(stage.world.resource::<Reports>().of_entity(entity).count(), 0);
    assert!(rendered.radiance.iter().any(|value| *value > 0.1));
}
