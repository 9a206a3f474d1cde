//! A frame in which nothing moves computes no silhouette, makes no pipeline and draws the same picture; one in which
//! something moves pays for that alone.

use std::sync::Arc;

use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};
use antumbra::prelude::*;
use antumbra::silhouettes::Silhouettes;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

fn scene() -> Stage {
    let view = Transform::from_xyz(3.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: 2.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(128, 64), camera, view);
    let context = strict_context();
    stage
        .add_renderer(context, RenderSettings::default())
        .expect("shaders compose");
    let ball = Arc::new(MeshData::icosphere(0.3, 2));
    let material = Arc::new(Material::matte(Vec3::ONE));
    for i in 0..6 {
        stage.world.spawn((
            SceneMesh(ball.clone()),
            SceneMaterials([material.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(i as f32 * 0.7 - 2.0, 0.5, 0.0),
        ));
    }
    stage.world.spawn((
        SceneMesh(Arc::new(MeshData::plane(5.0))),
        SceneMaterials([material].into()),
        ShadowReceiver,
        Transform::default(),
    ));
    for x in [-2.0, 2.0] {
        let place = Transform::from_xyz(x, 3.0, 1.0);
        stage.spawn_light(
            Light::point(Vec3::ONE, 20.0, 20.0),
            place,
            Some(StencilVolume::default()),
        );
    }
    stage
}

fn render(stage: &mut Stage) -> (Rendered, usize, usize) {
    let rendered = stage.render().expect("the frame renders");
    let extracted = stage.world.resource::<Silhouettes>().extracted;
    let pipelines = stage.world.resource::<Renderer>().pipelines_created();
    (rendered, extracted, pipelines)
}

#[test]
fn nothing_is_computed_again_until_it_moves() {
    let mut stage = scene();
    // Tests that share a device share its pipelines, and these are counted.
    stage
        .add_renderer(
            own_context(RequestedFeatures::default()),
            RenderSettings::default(),
        )
        .expect("shaders compose");
    let (first, extracted, pipelines) = render(&mut stage);
    assert_eq!(extracted, 12, "six casters in two lights");
    assert!(pipelines > 0);
    let (second, extracted, pipelines_after) = render(&mut stage);
    assert_eq!((extracted, pipelines_after), (0, pipelines));
    assert_eq!(first.picture, second.picture);

    let light = stage.lights[0];
    stage
        .world
        .get_mut::<Transform>(light)
        .expect("lights have a transform")
        .translation
        .x += 0.5;
    let (third, extracted, _) = render(&mut stage);
    assert_eq!(extracted, 6, "one light of two moved");
    assert_ne!(third.picture, second.picture, "and it shows");
    assert_eq!(
        third.visibility[1], second.visibility[1],
        "in its own shadows only"
    );

    let caster = stage
        .world
        .query_filtered::<bevy_ecs::prelude::Entity, bevy_ecs::prelude::With<ShadowCaster>>()
        .iter(&stage.world)
        .next()
        .expect("there are six");
    stage
        .world
        .get_mut::<Transform>(caster)
        .expect("casters have a transform")
        .translation
        .y += 0.3;
    let (_, extracted, _) = render(&mut stage);
    assert_eq!(extracted, 2, "one caster of six moved, in two lights");
    let (_, extracted, _) = render(&mut stage);
    assert_eq!(extracted, 0);
}

#[test]
fn equal_objects_are_one_batch() {
    let mut stage = scene();
    render(&mut stage);
    let frame = stage.world.resource::<Renderer>().frame();
    assert_eq!(frame.ambient.len(), 2, "six balls of one mesh, and the ground");
    for light in &frame.lights {
        assert_eq!(light.batches.len(), 2);
    }
}

#[test]
fn a_light_that_nothing_receives_costs_nothing() {
    let mut stage = scene();
    render(&mut stage);
    let with = stage.world.resource::<Renderer>().frame().lights.len();
    let place = Transform::from_xyz(300.0, 3.0, 1.0);
    stage.spawn_light(
        Light::point(Vec3::ONE, 20.0, 20.0),
        place,
        Some(StencilVolume::default()),
    );
    let (rendered, extracted, _) = render(&mut stage);
    assert_eq!(extracted, 0);
    assert_eq!(stage.world.resource::<Renderer>().frame().lights.len(), with);
    assert!(rendered.visibility[2].iter().all(|v| *v == 1.0));
}

#[test]
fn the_debug_view_colours_volumes_by_how_they_are_counted() {
    let mut stage = scene();
    let (plain, ..) = render(&mut stage);
    stage.world.resource_mut::<Renderer>().settings.debug_volumes = true;
    let (volumes, ..) = render(&mut stage);
    let added = |channel: usize| -> f32 {
        let channels = volumes
            .radiance
            .iter()
            .zip(&plain.radiance)
            .skip(channel)
            .step_by(4);
        channels.map(|(a, b)| a - b).sum()
    };
    let (red, blue) = (added(0), added(2));
    assert!(blue > 10.0, "depth-pass volumes are blue and green: {red} {blue}");
    assert!(red.abs() < 1e-3, "and none is counted by depth-fail here: {red}");
    for light in stage.lights.clone() {
        stage.world.entity_mut(light).insert(StencilVolume {
            counting: antumbra::techniques::stencil_volume::Counting::DepthFail,
            ..Default::default()
        });
    }
    let (forced, ..) = render(&mut stage);
    let red: f32 = forced
        .radiance
        .iter()
        .zip(&plain.radiance)
        .step_by(4)
        .map(|(a, b)| a - b)
        .sum();
    assert!(red > 10.0, "depth-fail volumes are orange and magenta: {red}");
    assert_eq!(forced.visibility, plain.visibility, "the view changes no shadow");
}

#[test]
fn one_pass_for_all_lights_draws_what_a_pass_each_draws() {
    let mut stage = scene();
    let context = own_context(RequestedFeatures {
        timestamps: false,
        ..Default::default()
    });
    stage
        .add_renderer(context, RenderSettings::default())
        .expect("shaders compose");
    let (each, ..) = render(&mut stage); // asks for visibilities, which takes a pass a light
    stage.schedule.run(&mut stage.world);
    let renderer = stage.world.resource::<Renderer>();
    let context = renderer.context();
    let mut encoder = context.device.create_command_encoder(&Default::default());
    renderer.record(&mut encoder, &FrameOutputs::default());
    context.queue.submit([encoder.finish()]);
    let radiance = renderer.radiance().expect("a frame was drawn");
    let all = wgpu::TextureAspect::All;
    let rows = antumbra::render::readback::read_texture(context, &radiance.texture, all, "radiance")
        .expect("radiance can be read");
    let one: Vec<f32> = rows
        .bytes
        .chunks_exact(2)
        .map(|bytes| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32())
        .collect();
    assert!(one.iter().any(|channel| *channel > 0.1), "something is lit");
    assert_eq!(one, each.radiance);
}
