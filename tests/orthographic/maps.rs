//! Shadow maps in orthographic views.

use antumbra::prelude::*;
use glam::Vec3;

use crate::harness::maps::judge_map;
use crate::harness::{judge, strict_context};
use crate::scenes::{ground, light, rays};

#[test]
fn maps_differ_from_the_ray_caster_by_texels() {
    let context = strict_context(RequestedFeatures::default());
    let spot = LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.8,
    };
    let above = Vec3::new(0.6, 4.5, 0.8);
    let mut stage = ground(&context, 3.6, -2.0, 30.0);
    let scene = rays(&mut stage);
    for (name, kind, range) in [
        ("cube", LightKind::Point, 20.0),
        ("spot", spot, 20.0),
        ("cascades", LightKind::Directional, f32::INFINITY),
    ] {
        match name {
            "cube" => light(&mut stage, kind, above, range, OmniMap::default()),
            _ => light(&mut stage, kind, above, range, ShadowMap::default()),
        }
        let rendered = stage.render().expect("the frame renders");
        let by_texel = judge_map(&stage, &scene, 0, &rendered.visibility[0]);
        let hard = judge(&stage, &scene, 0, &rendered.visibility[0]);
        let dark = rendered.visibility[0].iter().filter(|v| **v < 0.5).count();
        println!("{name}: {by_texel:?}; off the edges {hard:?}; {dark} dark");
        assert!(by_texel.share() < 0.001, "{name}: {by_texel:?}");
        assert!(dark > 150, "{name}: {dark}");
    }
}
