//! No setting makes a picture NaN or negative.

use std::cell::RefCell;

use antumbra::prelude::*;
use antumbra::scene::{
    LightDistance, LightShape, LightWeights, ShadowOrigin, ShadowSoftness, ShadowTint, SurfaceWeights,
};
use glam::{UVec2, Vec3};
use proptest::prelude::*;

use super::{floor_and_ball, relight, render, stage};
use crate::harness::strict_context;

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

thread_local! {
    /// One stage for all cases: a device takes longer to make than a picture.
    static STAGE: RefCell<Option<crate::harness::support::stage::Stage>> = const { RefCell::new(None) };
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..Default::default() })]

    #[test]
    fn no_setting_gives_nan_or_negative_light(
        size in (number(), number(), number(), number(), share()),
        depth in (number(), number(), number(), number()),
        weights in (weight(), weight(), weight(), weight()),
        (color, darkness) in ((share(), weight(), weight()), share()),
        (origin, softness) in (vector(), share()),
        (kind, technique, moved, softened) in (0..5usize, 0..4usize, any::<bool>(), any::<bool>()),
    ) {
        STAGE.with_borrow_mut(|kept| -> Result<(), TestCaseError> {
            let stage = kept.get_or_insert_with(|| {
                let mut stage = stage(&strict_context());
                stage.world.insert_resource(ViewportSize(UVec2::new(24, 14)));
                let [floor, _] = floor_and_ball(&mut stage);
                stage.world.entity_mut(floor).insert(SurfaceWeights { ambient: 0.5, diffuse: 2.0, specular: 0.0 });
                stage
            });
            let (kind, is_directional) = match kind {
                0 => (LightKind::Point, false),
                1 => (LightKind::Spot { inner_angle: 0.4, outer_angle: 0.8 }, false),
                2 => (LightKind::Rect { width: 0.5, height: 0.0 }, false),
                3 => (LightKind::Sphere { radius: 0.1 }, false),
                _ => (LightKind::Directional, true),
            };
            let near = depth.0.min(1e30);
            let shape = LightShape { width: size.0, height: size.1, width_edge: size.2, height_edge: size.3, round: size.4 };
            let distance = LightDistance { near, far: near.max(depth.1), near_edge: depth.2, far_edge: depth.3 };
            let light = Light { kind, ..Light::point(Vec3::new(1.0, 0.5, 0.0), 40.0, 30.0) };
            let parts = (
                shape,
                distance,
                LightWeights { ambient: weights.0, diffuse: weights.1, specular: weights.2 },
                ShadowTint { color: color.into(), darkness },
            );
            let entity = relight(stage, light, parts);
            let mut entity = stage.world.entity_mut(entity);
            match technique {
                0 => {}
                1 => { entity.insert(StencilVolume::default()); }
                2 => { entity.insert(PenumbraWedge::default()); }
                _ if is_directional => { entity.insert(ShadowMap::default()); }
                _ => { entity.insert(OmniMap::default()); }
            }
            if moved {
                entity.insert(if is_directional { ShadowOrigin::Direction(origin) } else { ShadowOrigin::Position(origin) });
            }
            if softened {
                entity.insert(ShadowSoftness(softness));
            }
            let rendered = render(stage);
            let wrong = rendered.radiance.iter().filter(|value| !(**value >= 0.0)).count();
            prop_assert_eq!(wrong, 0, "values are NaN or negative");
            Ok(())
        })?;
    }
}
