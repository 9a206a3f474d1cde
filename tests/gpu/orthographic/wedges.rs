//! Penumbra wedges in orthographic views.

use antumbra::prelude::*;
use antumbra::reference::{
    LightSource, SoftError, VisibilityImage, compare_soft, primary_hits, soft_visibility,
};
use antumbra::techniques::penumbra_wedge::WedgeCulling;
use bevy_transform::prelude::GlobalTransform;
use glam::Vec3;

use super::scenes::{ground, light, plate_before_wall, rays};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Largest error in penumbrae, and over all: as of the same scenes in perspective.
const ALLOWED: (f64, f64) = (0.06, 0.02);

fn truth(stage: &mut Stage) -> VisibilityImage {
    let scene = rays(stage);
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("a camera");
    let transform = world.get::<GlobalTransform>(stage.camera).expect("its place");
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(&scene, camera, transform, size).expect("a usable camera");
    let source = LightSource::of_entity(world, stage.lights[0]).expect("a usable light");
    soft_visibility(&scene, &hits, &source, 256, 7)
}

fn error(stage: &mut Stage, truth: &VisibilityImage) -> SoftError {
    let rendered = stage.render().expect("the frame renders");
    let got = VisibilityImage::new(rendered.size, rendered.visibility[0].clone()).expect("whole");
    compare_soft(truth, &got)
        .expect("one size")
        .expect("pixels count")
}

#[test]
fn area_lights_cast_the_penumbrae_of_truth() {
    let context = strict_context();
    let rect = LightKind::Rect {
        width: 0.8,
        height: 0.5,
    };
    let ball = LightKind::Sphere { radius: 0.3 };
    let above = Vec3::new(0.6, 4.5, 0.8);
    // Beside the picture, and low, so that edges are long and wedges wide.
    let low = Vec3::new(-3.4, 1.3, 0.7);
    for (name, kind, from, range) in [
        ("rectangle", rect, above, f32::INFINITY),
        ("rectangle with a range", rect, above, 9.0),
        ("ball", ball, above, f32::INFINITY),
        ("low ball", ball, low, 20.0),
        ("low rectangle", rect, low, f32::INFINITY),
    ] {
        let mut stage = ground(&context, 3.6, -2.0, 30.0);
        light(&mut stage, kind, from, range, PenumbraWedge::default());
        let truth = truth(&mut stage);
        for culling in [WedgeCulling::Depth, WedgeCulling::Stencil, WedgeCulling::None] {
            let wedge = PenumbraWedge {
                culling,
                ..PenumbraWedge::default()
            };
            let entity = stage.lights[0];
            stage.world.entity_mut(entity).insert(wedge);
            let error = error(&mut stage, &truth);
            println!(
                "{name} {culling:?}: rmse {:.4}, penumbra {:.4} ({} px), umbra lit {:.4}",
                error.rmse, error.rmse_penumbra, error.penumbra, error.umbra_lit
            );
            assert!(error.penumbra > 200, "{name}: too little is in penumbrae");
            assert!(error.rmse_penumbra < ALLOWED.0, "{name} {culling:?}: {error:?}");
            assert!(error.rmse < ALLOWED.1, "{name} {culling:?}: {error:?}");
        }
    }
}

/// Wedges of a plate that is as near to the lamp as the lamp is wide: they open by nearly half a turn.
#[test]
fn however_pixels_are_found_a_near_caster_casts_the_same() {
    let context = strict_context();
    let rect = LightKind::Rect {
        width: 0.6,
        height: 0.6,
    };
    for kind in [rect, LightKind::Sphere { radius: 0.3 }] {
        let mut stage = plate_before_wall(&context);
        let wedge = |culling| PenumbraWedge {
            culling,
            ..PenumbraWedge::default()
        };
        let stencil = wedge(WedgeCulling::Stencil);
        light(&mut stage, kind, Vec3::Z * 0.6, f32::INFINITY, stencil);
        let truth = truth(&mut stage);
        let expected = stage.render().expect("the frame renders").visibility.remove(0);
        for culling in [WedgeCulling::Stencil, WedgeCulling::Depth, WedgeCulling::None] {
            let entity = stage.lights[0];
            stage.world.entity_mut(entity).insert(wedge(culling));
            let error = error(&mut stage, &truth);
            let got = stage.render().expect("the frame renders").visibility.remove(0);
            let pairs = got.iter().zip(&expected);
            let worst = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            println!(
                "{kind:?} {culling:?}: rmse in penumbrae {:.4} ({} px), {worst:.4} from stencil",
                error.rmse_penumbra, error.penumbra
            );
            assert!(error.penumbra > 2000, "{kind:?}: too little is in penumbrae");
            assert!(error.rmse_penumbra < 0.02, "{kind:?} {culling:?}: {error:?}");
            assert!(worst < 0.01, "{kind:?} {culling:?}: {worst}");
        }
    }
}

#[test]
fn a_light_that_moved_is_found_wrong() {
    let context = strict_context();
    let ball = LightKind::Sphere { radius: 0.3 };
    let mut stage = ground(&context, 3.6, -2.0, 30.0);
    let above = Vec3::new(0.6, 4.5, 0.8);
    light(&mut stage, ball, above, 20.0, PenumbraWedge::default());
    let truth = truth(&mut stage);
    light(
        &mut stage,
        ball,
        above + Vec3::X * 0.5,
        20.0,
        PenumbraWedge::default(),
    );
    let error = error(&mut stage, &truth);
    assert!(error.rmse_penumbra > ALLOWED.0, "{error:?}");
}

#[test]
fn a_sun_with_wedges_has_hard_shadows() {
    let context = strict_context();
    let mut stage = ground(&context, 3.6, 0.0, 30.0);
    let from = Vec3::new(1.0, 2.0, 0.7);
    light(
        &mut stage,
        LightKind::Directional,
        from,
        f32::INFINITY,
        PenumbraWedge::default(),
    );
    let wedges = stage.render().expect("the frame renders").visibility.remove(0);
    let entity = stage.lights[0];
    stage
        .world
        .entity_mut(entity)
        .remove::<PenumbraWedge>()
        .insert(StencilVolume::default());
    let volumes = stage.render().expect("the frame renders").visibility.remove(0);
    let differing = wedges
        .iter()
        .zip(&volumes)
        .filter(|(a, b)| (**a - **b).abs() > 0.01);
    let (differing, dark) = (differing.count(), volumes.iter().filter(|v| **v == 0.0).count());
    println!("{differing} pixels differ, {dark} are dark");
    assert!(differing <= 8 && dark > 300);
}
