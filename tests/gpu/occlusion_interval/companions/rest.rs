//! Companions are kept from frame to frame, and are no lights of the scene.

use antumbra::prelude::*;
use antumbra::sets::{CompanionOf, SetWork};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::{BOXES, SECONDS, add, visibility, with_boxes};
use crate::harness::own_context;
use crate::harness::support::stage::Stage;

#[test]
fn a_frame_at_rest_writes_and_computes_nothing() {
    for (name, add) in SECONDS {
        let mut stage = with_boxes(0.4, 0.0);
        stage
            .add_renderer(
                own_context(RequestedFeatures::default()),
                RenderSettings::default(),
            )
            .expect("shaders compose");
        add(&mut stage);
        for _ in 0..3 {
            visibility(&mut stage);
        }
        let state = |stage: &mut Stage| {
            let pipelines = stage.world.resource::<Renderer>().pipelines_created();
            let work = *stage.world.resource::<SetWork>();
            let generation = stage.world.resource::<FrameLights>().generation;
            let mut companions = stage.world.query::<(Entity, Ref<CompanionOf>)>();
            let mut ticks: Vec<_> = companions
                .iter(&stage.world)
                .map(|(entity, of)| (entity, *of, of.last_changed().get()))
                .collect();
            ticks.sort_unstable_by_key(|(entity, ..)| *entity);
            (pipelines, work, generation, ticks)
        };
        let before = state(&mut stage);
        let first = visibility(&mut stage);
        let second = visibility(&mut stage);
        assert_eq!(state(&mut stage), before, "{name}");
        assert!(first == second, "{name}");
        let lights = stage.world.resource::<FrameLights>();
        let recomputed = lights
            .lights
            .iter()
            .any(|light| light.moved || light.is_recomputed());
        assert!(!recomputed, "{name}: nothing moved");
        let moving = stage
            .world
            .query_filtered::<Entity, With<SceneMesh>>()
            .iter(&stage.world)
            .last();
        let place = Transform::from_translation(BOXES[1] + Vec3::X * 0.1);
        stage.world.entity_mut(moving.expect("a box")).insert(place);
        assert!(visibility(&mut stage) != first, "{name}");
        assert_ne!(state(&mut stage).1, before.1, "{name}: a box moved");
    }
}

#[test]
fn companions_are_no_lights_of_the_scene() {
    let mut stage = with_boxes(0.4, 0.0);
    let mut of_frame = |second: bool| {
        if second {
            add(&mut stage, ShadowMap::default());
        }
        stage.render().expect("the frame renders");
        let lights = stage.world.resource::<FrameLights>();
        let companions = lights.companions_of(stage.lights[0]).count();
        let drawn = stage.world.resource::<Renderer>().frame().lights.len();
        (lights.of_scene().len(), drawn, companions)
    };
    assert_eq!(of_frame(false), (1, 1, 0));
    assert_eq!(of_frame(true), (1, 1, 2));
    let lights = stage.world.query::<&Light>().iter(&stage.world).count();
    assert_eq!(lights, 1);
}
