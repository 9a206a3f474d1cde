//! Light-space pictures are a stage of the frame: each changed face is drawn once, whoever looks it up, and a picture that
//! was recorded into an encoder that nobody submitted is drawn again.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::maps::MapResolution;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3, Vec4};

use crate::harness::own_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(96, 54);

/// A floor, a ball above it, and a pane of glass between them if there is to be one.
fn stage(with_glass: bool) -> (Stage, Entity) {
    let view = Transform::from_xyz(2.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    let requested = RequestedFeatures {
        timestamps: true,
        ..Default::default()
    };
    let settings = RenderSettings::default();
    stage
        .add_renderer(own_context(requested), settings)
        .expect("shaders compose");
    let glass = Material {
        base_color: Vec4::new(0.2, 0.9, 0.3, 0.4),
        alpha_mode: AlphaMode::Blend,
        ..Material::matte(Vec3::ONE)
    };
    let mut add = |mesh: MeshData, material: Material, height: f32| {
        let parts = (
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(material)].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(0.0, height, 0.0),
        );
        stage.world.spawn(parts).id()
    };
    add(MeshData::plane(4.0), Material::matte(Vec3::ONE), 0.0);
    let ball = add(MeshData::icosphere(0.4, 3), Material::matte(Vec3::ONE), 1.9);
    if with_glass {
        add(MeshData::plane(1.2), glass, 1.0);
    }
    (stage, ball)
}

fn spawn_light(stage: &mut Stage, x: f32, kind: LightKind, shadow: impl Bundle) {
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 60.0, 30.0)
    };
    let place = Transform::from_xyz(x, 4.0, 0.2).looking_at(Vec3::ZERO, Vec3::Z);
    stage.spawn_light(light, place, Some(shadow));
}

const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.5,
    outer_angle: 0.8,
};

/// How often faces of the lights' maps are drawn in the next frame, and how often the maps are looked up.
fn passes(stage: &mut Stage) -> (usize, usize) {
    let times = stage.time_passes().expect("the frame renders");
    assert!(!times.is_empty(), "the device has timers");
    let count = |name: &str| times.iter().filter(|time| time.label.ends_with(name)).count();
    (count("/map"), count("/map lookup"))
}

fn shift(stage: &mut Stage, object: Entity) {
    stage
        .world
        .get_mut::<Transform>(object)
        .expect("it stands somewhere")
        .translation
        .x += 0.1;
}

#[test]
fn with_glass_in_the_light_no_face_is_drawn_twice() {
    let fixed = MapResolution::Fixed(128);
    for cached in [true, false] {
        let mut faces = [0, 0];
        for (with_glass, faces) in [false, true].into_iter().zip(&mut faces) {
            let (mut stage, ball) = stage(with_glass);
            let (resolution, cached) = (fixed, cached);
            spawn_light(
                &mut stage,
                0.3,
                SPOT,
                ShadowMap {
                    resolution,
                    cached,
                    ..Default::default()
                },
            );
            spawn_light(
                &mut stage,
                0.5,
                LightKind::Point,
                OmniMap {
                    resolution,
                    cached,
                    ..Default::default()
                },
            );
            for frame in 0..3 {
                let (drawn, lookups) = passes(&mut stage);
                *faces += drawn;
                assert_eq!(
                    lookups,
                    if with_glass { 4 } else { 2 },
                    "glass is looked up as well"
                );
                assert!(drawn > 0 || (cached && frame > 0), "a change is drawn");
                shift(&mut stage, ball);
            }
        }
        assert_eq!(faces[0], faces[1], "cached: {cached}");
    }
}

#[test]
fn lights_that_use_one_texture_in_turn_draw_it_before_each_lookup() {
    let (mut stage, _) = stage(true);
    for x in [0.3, 0.5] {
        let (resolution, cached) = (MapResolution::Fixed(128), false);
        spawn_light(
            &mut stage,
            x,
            SPOT,
            ShadowMap {
                resolution,
                cached,
                ..Default::default()
            },
        );
    }
    assert_eq!(passes(&mut stage), (4, 4));
}

#[test]
fn what_a_dropped_encoder_recorded_is_drawn_again() {
    let lit = |drops: bool| {
        let (mut stage, ball) = stage(true);
        spawn_light(&mut stage, 0.5, LightKind::Point, OmniMap::default());
        for _ in 0..3 {
            stage.render().expect("the frame renders");
        }
        shift(&mut stage, ball);
        if drops {
            stage.schedule.run(&mut stage.world);
            let renderer = stage.world.resource::<Renderer>();
            let mut encoder = renderer
                .context()
                .device
                .create_command_encoder(&Default::default());
            renderer.record(&mut encoder, &FrameOutputs::default());
            drop(encoder.finish());
        }
        let (drawn, _) = passes(&mut stage);
        assert!(drawn > 0, "the ball moved");
        let rendered = stage.render().expect("the frame renders");
        let (again, _) = passes(&mut stage);
        assert!(again <= drawn);
        rendered.visibility[0].clone()
    };
    let kept = lit(false);
    assert!(
        kept.iter().filter(|&&v| v < 0.5).count() > 50,
        "there is a shadow"
    );
    assert_eq!(kept, lit(true));
}
