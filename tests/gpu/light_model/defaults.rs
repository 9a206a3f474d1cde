//! Components at their defaults change no bit and no pass.

use antumbra::prelude::*;
use antumbra::scene::{LightDistance, LightShape, LightWeights, ShadowTint, SurfaceWeights};
use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{add_of, floor_and_ball, relight, stage};
use crate::harness::own_context;

#[test]
fn components_at_their_defaults_change_nothing() {
    fn check(context: &RenderContext, name: &str, shadow: impl Bundle + Clone) {
        let mut stage = stage(context);
        let objects = floor_and_ball(&mut stage);
        let mut pane = Material::matte(Vec3::new(0.2, 0.5, 0.9));
        pane.alpha_mode = AlphaMode::Blend;
        pane.base_color.w = 0.4;
        add_of(
            &mut stage,
            MeshData::cuboid(Vec3::splat(0.4)),
            Vec3::new(1.0, 0.6, 1.5),
            pane,
        );
        let light = relight(&mut stage, Light::point(Vec3::ONE, 40.0, 20.0), shadow);
        stage.draw().expect("the frame renders");
        let without = stage.radiance_bytes().expect("radiance is read");
        let pipelines = stage.world.resource::<Renderer>().pipelines_created();
        stage.world.entity_mut(light).insert((
            LightShape::default(),
            LightDistance::default(),
            LightWeights::default(),
            ShadowTint::default(),
            LightSelection::default(),
        ));
        for object in objects {
            stage.world.entity_mut(object).insert(SurfaceWeights::default());
        }
        stage.draw().expect("the frame renders");
        let with = stage.radiance_bytes().expect("radiance is read");
        assert!(without == with, "{name}: the picture changed");
        let renderer = stage.world.resource::<Renderer>();
        assert_eq!(
            renderer.pipelines_created(),
            pipelines,
            "{name}: no pass was added"
        );
        assert!(
            !renderer.has_light_functions(),
            "{name}: nothing scales the light"
        );
        // The same comparison sees a shape.
        stage.world.entity_mut(light).insert(LightShape {
            width: 0.2,
            ..LightShape::default()
        });
        stage.draw().expect("the frame renders");
        assert!(
            stage.radiance_bytes().expect("radiance is read") != with,
            "{name}"
        );
    }
    // Tests that share a device share its pipelines, and these are counted.
    let context = own_context(RequestedFeatures::default());
    check(&context, "none", ());
    check(&context, "stencil", StencilVolume::default());
    check(&context, "map", OmniMap::default());
    check(&context, "wedge", PenumbraWedge::default());
}
