//! Sixty-four point lights in a dungeon: while nothing moves no map is drawn, and casters that move cost draws in the
//! lights that they touch alone.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::sets::Objects;
use antumbra::techniques::TextureMemory;
use antumbra::techniques::maps::{MapSettings, Maps};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::support::stage::Stage;
use crate::harness::{ModelStage, model, strict_context};

const SIZE: UVec2 = UVec2::new(128, 72);

fn dungeon() -> ModelStage {
    let mut model =
        ModelStage::new(&model("dungeon_A.glb"), &strict_context(), SIZE).expect("it has triangles");
    let bounds = model.bounds;
    let size = bounds.half_size() * 2.0;
    // An 8×8 grid over the ground plan, each light reaching some rooms.
    let range = 0.16 * size.x.max(size.z);
    for i in 0..64 {
        let share = |k: usize| (k as f32 + 0.5) / 8.0;
        let at = bounds.min + size * Vec3::new(share(i % 8), 0.45, share(i / 8));
        let light = Light::point(Vec3::ONE, 10.0, range);
        model
            .stage
            .spawn_light(light, Transform::from_translation(at), Some(OmniMap::default()));
    }
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let eye = bounds.center() + Vec3::new(0.0, 1.1 * size.y + 0.5 * size.x, 0.55 * size.z);
    let view = Transform::from_translation(eye).looking_at(bounds.center(), Vec3::Y);
    let entity = model.stage.camera;
    model.stage.world.entity_mut(entity).insert((camera, view));
    model
}

/// Runs and records a frame; draws of casters by light of the frame.
fn frame(stage: &mut Stage) -> Vec<usize> {
    stage.time_passes().expect("the frame renders");
    let renderer = stage.world.resource::<Renderer>();
    let mut draws = vec![0; stage.world.resource::<FrameLights>().lights.len()];
    for light in &renderer.frame().lights {
        draws[light.light] = renderer.shadow_batch_count(light);
    }
    draws
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn still_lights_draw_nothing_and_movers_cost_what_they_touch() {
    let mut model = dungeon();
    let stage = &mut model.stage;
    let mut settings = stage.world.resource_mut::<MapSettings>();
    (settings.face_updates, settings.still_after) = (128, 2);
    let mut warm_up = Vec::new();
    // The ground came after the model: it counts as moving for two frames, then the layers take it in, 128 faces a frame.
    for _ in 0..9 {
        warm_up.push(frame(stage).iter().sum::<usize>());
    }
    let maps = stage.world.resource::<Maps>();
    let looked_up = maps.lights.iter().filter(|map| map.active).count();
    println!(
        "64 lights, {looked_up} with a shadow in view; {} objects; maps: {:.1} MiB of {} MiB; draws by frame {warm_up:?}",
        stage.world.resource::<Objects>().len(),
        maps.bytes as f64 / f64::from(1 << 20),
        stage.world.resource::<TextureMemory>().limit >> 20,
    );
    assert!(looked_up >= 48, "{looked_up}");
    assert!(warm_up[0] > 0);
    assert_eq!(warm_up[7..], [0; 2], "nothing moves");
    let still = stage.render().expect("the frame renders");
    assert_eq!(frame(stage).iter().sum::<usize>(), 0);

    // Ten casters that wander.
    let bounds = model.bounds;
    let size = bounds.half_size() * 2.0;
    let ball = Arc::new(MeshData::icosphere(0.02 * size.x, 2));
    let material = Arc::new(Material::matte(Vec3::ONE));
    let place = |i: usize, time: f32| {
        let angle = time + i as f32;
        let at = Vec3::new(
            0.1 + 0.08 * i as f32 + 0.01 * angle.cos(),
            0.3,
            0.15 + 0.01 * angle.sin(),
        );
        Transform::from_translation(bounds.min + size * at)
    };
    let movers: Vec<Entity> = (0..10)
        .map(|i| {
            let mesh = SceneMesh(ball.clone());
            let materials = SceneMaterials([material.clone()].into());
            let parts = (ShadowCaster, ShadowReceiver);
            stage.world.spawn((mesh, materials, parts, place(i, 0.0))).id()
        })
        .collect();
    frame(stage);
    for step in 1..4 {
        for (i, &mover) in movers.iter().enumerate() {
            stage.world.entity_mut(mover).insert(place(i, step as f32));
        }
        let draws = frame(stage);
        let objects = stage.world.resource::<Objects>();
        let lights = &stage.world.resource::<FrameLights>().lights;
        let (mut touched, mut drawn) = (0, 0);
        for (light, draws) in lights.iter().zip(&draws) {
            let touches = movers.iter().any(|mover| {
                objects
                    .index_of(*mover)
                    .is_some_and(|index| light.sets.l.contains(index))
            });
            touched += usize::from(touches);
            drawn += usize::from(*draws > 0);
            assert!(touches || *draws == 0, "a light without a mover drew {draws}");
        }
        println!(
            "10 casters move: {} draws in {drawn} lights, {touched} of 64 touched; {} faces",
            draws.iter().sum::<usize>(),
            stage.world.resource::<Maps>().updated_faces,
        );
        assert!(drawn > 0 && touched < 48, "{drawn} {touched}");
    }
    // They stand still again: they join the others, and then nothing is drawn.
    let mut rest = Vec::new();
    for _ in 0..8 {
        rest.push(frame(stage).iter().sum::<usize>());
    }
    println!("they stand still: draws by frame {rest:?}");
    assert_eq!(rest[rest.len() - 2..], [0; 2]);
    for mover in movers {
        stage.world.despawn(mover);
    }
    for _ in 0..3 {
        frame(stage);
    }
    let after = stage.render().expect("the frame renders");
    assert_eq!(still.visibility, after.visibility, "all is as it was");
}
