//! The draws and records of shadow volumes are kept while the volumes are, and show what a new recorder shows.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::stencil_volume::{Counting, Extent, StencilVolumes};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Casters of two meshes over a floor, and two lights; the casters and the floor.
fn stage() -> (Stage, [Entity; 4]) {
    let view = Transform::from_xyz(2.0, 4.0, 5.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: 2.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(128, 64), camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let ball = Arc::new(MeshData::icosphere(0.4, 2));
    let slanted = vec![
        Vec3::new(-0.5, 0.0, -0.3),
        Vec3::new(0.5, 0.2, -0.3),
        Vec3::new(0.5, 0.0, 0.6),
    ];
    let slanted = Arc::new(MeshData::from_triangles("slanted", slanted, vec![0, 2, 1]));
    let floor = Arc::new(MeshData::plane(4.0));
    let places = [(-1.0, 1.0), (0.2, 1.2), (1.3, 1.0), (0.0, 0.0)];
    let meshes = [&ball, &ball, &slanted, &floor];
    let things = std::array::from_fn(|at| {
        let material = Arc::new(Material::matte(Vec3::splat(0.7)));
        let (x, y) = places[at];
        let parts = (
            SceneMesh(meshes[at].clone()),
            SceneMaterials([material].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(x, y, 0.0),
        );
        stage.world.spawn(parts).id()
    });
    for x in [-1.0, 1.5] {
        let place = Transform::from_xyz(x, 4.0, 0.5);
        let light = Light::point(Vec3::ONE, 20.0, 20.0);
        stage.spawn_light(light, place, Some(StencilVolume::default()));
    }
    (stage, things)
}

/// Visibility of both lights and the radiance, in a frame after some change and in the next one, which must be alike.
fn shown(stage: &mut Stage, what: &str) -> (Vec<Vec<f32>>, Vec<f32>) {
    let changed = stage.render().expect("the frame renders");
    let revision = stage.world.resource::<StencilVolumes>().revision;
    let kept = stage.render().expect("the frame renders");
    assert_eq!(
        stage.world.resource::<StencilVolumes>().revision,
        revision,
        "{what}"
    );
    assert!(
        changed.visibility == kept.visibility && changed.radiance == kept.radiance,
        "{what}"
    );
    (kept.visibility, kept.radiance)
}

#[test]
fn kept_draws_show_what_a_new_recorder_shows() {
    type Change = fn(&mut Stage, [Entity; 4]);
    let changes: [(&str, bool, Change); 10] = [
        ("nothing", false, |_, _| ()),
        ("a caster moves", true, |stage, [ball, ..]| {
            stage
                .world
                .get_mut::<Transform>(ball)
                .expect("a place")
                .translation
                .z += 0.4;
        }),
        ("a caster is mirrored", true, |stage, [_, _, slanted, _]| {
            stage
                .world
                .get_mut::<Transform>(slanted)
                .expect("a place")
                .scale
                .x = -1.0;
        }),
        ("a caster gets another mesh", true, |stage, [_, ball, ..]| {
            let mesh = SceneMesh(Arc::new(MeshData::cuboid(Vec3::splat(0.3))));
            stage.world.entity_mut(ball).insert(mesh);
        }),
        ("a caster comes", true, |stage, [_, ball, ..]| {
            let mesh = stage.world.get::<SceneMesh>(ball).expect("a mesh").clone();
            let materials = stage
                .world
                .get::<SceneMaterials>(ball)
                .expect("materials")
                .clone();
            let place = Transform::from_xyz(0.8, 0.8, 1.0);
            stage
                .world
                .spawn((mesh, materials, ShadowCaster, ShadowReceiver, place));
        }),
        ("a caster goes", true, |stage, [ball, ..]| {
            stage.world.despawn(ball);
        }),
        ("other settings", false, |stage, _| {
            let settings = StencilVolume {
                counting: Counting::DepthFail,
                extent: Extent::Infinite,
            };
            stage.world.entity_mut(stage.lights[0]).insert(settings);
        }),
        ("the view is mirrored", true, |stage, _| {
            let camera = stage.camera;
            stage.world.get_mut::<Transform>(camera).expect("a place").scale.x = -1.0;
        }),
        ("a light goes out", true, |stage, _| {
            stage
                .world
                .get_mut::<Light>(stage.lights[1])
                .expect("a light")
                .intensity = 0.0;
        }),
        ("it shines again", true, |stage, _| {
            stage
                .world
                .get_mut::<Light>(stage.lights[1])
                .expect("a light")
                .intensity = 20.0;
        }),
    ];
    let (mut stage, things) = stage();
    let mut before = shown(&mut stage, "at first");
    let dark = |visibility: &[f32]| visibility.iter().filter(|v| **v == 0.0).count();
    assert!(before.0.iter().all(|light| dark(light) > 50));
    for (what, is_seen, change) in changes {
        change(&mut stage, things);
        let after = shown(&mut stage, what);
        assert_eq!(before != after, is_seen, "{what}");
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        assert!(shown(&mut stage, what) == after, "{what}");
        before = after;
    }
}
