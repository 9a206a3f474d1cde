//! Techniques come, go and are exchanged while lights shine; what is left is as if the light had always been so.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::scene::{MorphTarget, MorphWeights};
use antumbra::techniques::{Row, Techniques};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// A floor, a ball above it, and a light.
fn stage(context: &RenderContext) -> (Stage, Entity) {
    let view = Transform::from_xyz(2.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let mut stage = Stage::empty(UVec2::new(96, 54), camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    let matte = Arc::new(Material::matte(Vec3::splat(0.7)));
    for (mesh, height) in [(MeshData::plane(4.0), 0.0), (MeshData::icosphere(0.6, 3), 1.5)] {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([matte.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(0.0, height, 0.0),
        ));
    }
    let place = Transform::from_xyz(0.5, 4.0, 0.4).looking_at(Vec3::ZERO, Vec3::Z);
    let light = stage.spawn_light(Light::point(Vec3::ONE, 60.0, 30.0), place, None::<()>);
    (stage, light)
}

fn visibility(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("the frame renders").visibility.remove(0)
}

fn dark(picture: &[f32]) -> usize {
    picture.iter().filter(|&&v| v < 0.5).count()
}

/// The crate's techniques that fit a point light.
fn rows() -> Vec<Row> {
    let point = Light::point(Vec3::ONE, 1.0, 1.0);
    let techniques = Techniques::default();
    let rows = techniques.rows().iter().copied();
    rows.filter(|row| row.defaults().check(&point).is_ok()).collect()
}

/// What a light shows that never had another technique.
fn fresh(context: &RenderContext, row: Row) -> Vec<f32> {
    let (mut stage, light) = stage(context);
    stage.shadow(light, &row.defaults());
    visibility(&mut stage)
}

#[test]
fn a_technique_that_takes_the_place_of_another_leaves_nothing_of_it() {
    let context = strict_context();
    let rows = rows();
    assert!(rows.len() >= 3, "{rows:?}");
    let expected: Vec<Vec<f32>> = rows.iter().map(|row| fresh(&context, *row)).collect();
    assert_ne!(expected[0], expected[1], "the comparison can fail");
    let (mut stage, light) = stage(&context);
    let lit = visibility(&mut stage);
    assert!(lit.iter().all(|&v| v == 1.0));
    let techniques = Techniques::default();
    for (from, to) in (0..rows.len()).flat_map(|from| (0..rows.len()).map(move |to| (from, to))) {
        for (at, row) in [(from, rows[from]), (to, rows[to])] {
            techniques.take(&mut stage.world.entity_mut(light));
            row.defaults().insert(&mut stage.world.entity_mut(light));
            let shown = visibility(&mut stage);
            assert!(dark(&shown) > 100, "{row:?}: {} dark", dark(&shown));
            assert!(shown == expected[at], "from {:?} to {:?}", rows[from], rows[to]);
        }
        techniques.take(&mut stage.world.entity_mut(light));
        assert!(visibility(&mut stage) == lit, "{:?} is gone", rows[to]);
    }
}

#[test]
fn of_two_techniques_the_first_of_the_list_shadows_and_it_is_said() {
    let context = strict_context();
    let rows = rows();
    let (first, second) = (rows[0], rows[1]);
    let (mut stage, light) = stage(&context);
    // Whichever came first.
    second.defaults().insert(&mut stage.world.entity_mut(light));
    first.defaults().insert(&mut stage.world.entity_mut(light));
    assert!(visibility(&mut stage) == fresh(&context, first));
    let reports = stage.world.resource::<Reports>();
    let said: Vec<&str> = reports
        .of_entity(light)
        .map(|report| report.message.as_str())
        .collect();
    let names = |line: &&str| line.contains(first.component_name()) && line.contains(second.component_name());
    assert!(said.iter().any(names), "{said:?}");
    first.remove(&mut stage.world.entity_mut(light));
    assert!(visibility(&mut stage) == fresh(&context, second));
    let reports = stage.world.resource::<Reports>();
    let two = reports.iter().filter(|report| report.topic == "technique");
    assert_eq!(two.count(), 0, "it is withdrawn");
}

#[test]
fn techniques_with_one_type_of_recorder_share_it() {
    let context = strict_context();
    let (mut stage, light) = stage(&context);
    stage.shadow_by_default(light);
    visibility(&mut stage);
    let recorders = stage.world.resource::<Renderer>().recorders();
    assert_eq!(recorders.row_count(), Techniques::default().rows().len());
    assert!(
        recorders.count() < recorders.row_count(),
        "both kinds of map share one"
    );
}

#[test]
fn a_pose_that_comes_late_moves_its_object_alone() {
    let (mut stage, light) = stage(&strict_context());
    stage.world.entity_mut(light).insert(StencilVolume::default());
    let mut mesh = MeshData::icosphere(0.4, 3);
    let offsets = vec![Vec3::new(0.0, 0.8, 0.0); mesh.positions.len()];
    mesh.morph_targets.push(MorphTarget {
        positions: offsets,
        ..Default::default()
    });
    let mesh = Arc::new(mesh);
    let matte = Arc::new(Material::matte(Vec3::splat(0.7)));
    let [moved, still] = [-1.5, 1.5].map(|x| {
        let parts = (
            SceneMesh(mesh.clone()),
            SceneMaterials([matte.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(x, 0.5, 0.0),
        );
        stage.world.spawn(parts).id()
    });
    let together = stage.render().expect("the frame renders").picture;
    stage.world.entity_mut(moved).insert(MorphWeights(vec![1.0]));
    let late = stage.render().expect("the frame renders").picture;
    assert!(late != together, "the pose shows");
    // As if the pose had been there from the beginning.
    for object in [moved, still] {
        stage.world.despawn(object);
    }
    for (x, weight) in [(-1.5, Some(1.0)), (1.5, None)] {
        let mut object = stage.world.spawn((
            SceneMesh(mesh.clone()),
            SceneMaterials([matte.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(x, 0.5, 0.0),
        ));
        if let Some(weight) = weight {
            object.insert(MorphWeights(vec![weight]));
        }
    }
    let early = stage.render().expect("the frame renders").picture;
    let differ = late.iter().zip(&early).filter(|(a, b)| a != b).count();
    // A pixel on the edge of a volume may show its other side; a mesh in another pose changes hundreds of pixels.
    assert!(differ <= 12, "{differ} bytes");
    let moves = late.iter().zip(&together).filter(|(a, b)| a != b).count();
    assert!(moves > 300, "{moves} bytes");
}
