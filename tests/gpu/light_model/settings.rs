//! No setting makes a picture NaN or negative.

use std::cell::RefCell;

use antumbra::prelude::*;
use antumbra::scene::{
    LightDistance, LightShape, LightWeights, ShadowOrigin, ShadowSoftness, ShadowTint, SurfaceWeights,
};
use glam::{UVec2, Vec3};
use proptest::option;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::{floor_and_ball, put, relight, render, stage};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Numbers of all sizes, the limits among them.
fn number() -> impl Strategy<Value = f32> {
    prop_oneof![
        Just(0.0f32),
        Just(1e-30),
        Just(1e-3),
        Just(1.0),
        Just(1e6),
        Just(1e30),
        Just(f32::INFINITY),
        0.0f32..3.0,
    ]
}

fn share() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0f32), Just(1e-20), Just(1.0), 0.0f32..1.0]
}

fn weight() -> impl Strategy<Value = f32> {
    prop_oneof![Just(0.0f32), Just(1.0), Just(1e20), 0.0f32..3.0]
}

fn vector() -> impl Strategy<Value = Vec3> {
    (-4.0f32..4.0, -4.0f32..4.0, -4.0f32..4.0).prop_map(Vec3::from)
}

type Numbers = (f32, f32, f32, f32);

/// Settings of everything at once.
#[derive(Clone, Debug)]
struct Case {
    size: Numbers,
    round: f32,
    depth: Numbers,
    weights: Numbers,
    color: Vec3,
    darkness: f32,
    origin: Option<Vec3>,
    softness: Option<f32>,
    kind: usize,
    technique: usize,
}

fn cases() -> impl Strategy<Value = Case> {
    let numbers = || (number(), number(), number(), number());
    let weights = (weight(), weight(), weight(), share());
    let shadow = (
        option::of(vector()),
        option::of(share()),
        (share(), weight(), weight()),
    );
    (
        numbers(),
        share(),
        numbers(),
        weights,
        shadow,
        0..5usize,
        0..4usize,
    )
        .prop_map(
            |(size, round, depth, weights, (origin, softness, color), kind, technique)| Case {
                size,
                round,
                depth,
                weights,
                color: color.into(),
                darkness: weights.3,
                origin,
                softness,
                kind,
                technique,
            },
        )
}

impl Case {
    fn kind(&self) -> LightKind {
        match self.kind {
            0 => LightKind::Point,
            1 => LightKind::Spot {
                inner_angle: 0.4,
                outer_angle: 0.8,
            },
            2 => LightKind::Rect {
                width: 0.5,
                height: 0.0,
            },
            3 => LightKind::Sphere { radius: 0.1 },
            _ => LightKind::Directional,
        }
    }

    /// Replaces the light of the stage.
    fn relight(&self, stage: &mut Stage) {
        let kind = self.kind();
        let is_directional = kind == LightKind::Directional;
        let near = self.depth.0.min(1e30);
        let shape = LightShape {
            width: self.size.0,
            height: self.size.1,
            width_edge: self.size.2,
            height_edge: self.size.3,
            round: self.round,
        };
        let distance = LightDistance {
            near,
            far: near.max(self.depth.1),
            near_edge: self.depth.2,
            far_edge: self.depth.3,
        };
        let weights = LightWeights {
            ambient: self.weights.0,
            diffuse: self.weights.1,
            specular: self.weights.2,
        };
        let tint = ShadowTint {
            color: self.color,
            darkness: self.darkness,
        };
        let light = Light {
            kind,
            ..Light::point(Vec3::new(1.0, 0.5, 0.0), 40.0, 30.0)
        };
        let entity = relight(stage, light, (shape, distance, weights, tint));
        put(stage, entity, (self.technique == 1).then(StencilVolume::default));
        put(stage, entity, (self.technique == 2).then(PenumbraWedge::default));
        put(
            stage,
            entity,
            (self.technique == 3 && is_directional).then(ShadowMap::default),
        );
        put(
            stage,
            entity,
            (self.technique == 3 && !is_directional).then(OmniMap::default),
        );
        let origin = |at| match is_directional {
            true => ShadowOrigin::Direction(at),
            false => ShadowOrigin::Position(at),
        };
        put(stage, entity, self.origin.map(origin));
        put(stage, entity, self.softness.map(ShadowSoftness));
    }
}

#[test]
fn no_setting_gives_nan_or_negative_light() {
    let mut stage = stage(&strict_context());
    stage.world.insert_resource(ViewportSize(UVec2::new(24, 14)));
    let [floor, _] = floor_and_ball(&mut stage);
    stage.world.entity_mut(floor).insert(SurfaceWeights {
        ambient: 0.5,
        diffuse: 2.0,
        specular: 0.0,
    });
    let stage = RefCell::new(stage);
    let mut runner = TestRunner::new(ProptestConfig {
        cases: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    });
    let result = runner.run(&cases(), |case| {
        let stage = &mut *stage.borrow_mut();
        case.relight(stage);
        let rendered = render(stage);
        let wrong = rendered.radiance.iter().filter(|value| !(**value >= 0.0)).count();
        prop_assert_eq!(wrong, 0, "values are NaN or negative");
        Ok(())
    });
    if let Err(error) = result {
        panic!("{error}");
    }
}
