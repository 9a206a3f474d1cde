//! Submeshes that alpha hides, and inverted hulls that are submeshes, cast nothing while the rest of their mesh casts.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    HardError, LightSource, PrimaryCulling, RayScene, VisibilityImage, compare_hard, hard_visibility,
    primary_hits_culled,
};
use antumbra::scene::{MorphTarget, MorphWeights, Skin, Submesh};
use antumbra::sets::Objects;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Quat, UVec2, Vec3, Vec4};

use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;
use crate::harness::{judge, strict_context};

const SIZE: UVec2 = UVec2::new(128, 72);

/// A floor below a light.
fn stage(shadow: impl Bundle) -> Stage {
    let view = Transform::from_xyz(2.5, 3.5, 4.5).looking_at(Vec3::new(0.0, 0.3, 0.0), Vec3::Y);
    let camera = Camera {
        vertical_fov: 0.9,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    stage.world.spawn((
        SceneMesh(Arc::new(MeshData::plane(5.0))),
        SceneMaterials([matte()].into()),
        (ShadowCaster, ShadowReceiver),
    ));
    let place = Transform::from_xyz(0.6, 4.0, 0.8);
    stage.spawn_light(Light::point(Vec3::ONE, 60.0, f32::INFINITY), place, Some(shadow));
    stage
}

fn matte() -> Arc<Material> {
    Arc::new(Material::matte(Vec3::splat(0.7)))
}

/// One mesh of several, each as a submesh.
fn joined(parts: &[MeshData]) -> MeshData {
    let mut mesh = MeshData::default();
    for part in parts {
        let base = mesh.positions.len() as u32;
        mesh.submeshes.push(Submesh {
            first_index: mesh.indices.len() as u32,
            index_count: part.indices.len() as u32,
        });
        mesh.positions.extend(&part.positions);
        mesh.normals.extend(&part.normals);
        mesh.indices.extend(part.indices.iter().map(|index| base + index));
    }
    mesh
}

fn spawn(stage: &mut Stage, mesh: MeshData, materials: &[Arc<Material>]) -> Entity {
    let looks = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials(materials.iter().cloned().collect()),
    );
    let place = Transform::from_xyz(0.0, 0.9, 0.0);
    stage
        .world
        .spawn((looks, (ShadowCaster, ShadowReceiver), place))
        .id()
}

fn render(stage: &mut Stage) -> Rendered {
    let mut rendered = stage.render().expect("the frame renders");
    for _ in 0..2 {
        rendered = stage.render().expect("the frame renders"); // maps settle what is still
    }
    rendered
}

/// A box below a wide roof.
fn box_and_roof() -> MeshData {
    let mut roof = MeshData::cuboid(Vec3::new(1.1, 0.05, 1.1));
    roof.positions.iter_mut().for_each(|at| at.y += 0.8);
    joined(&[MeshData::cuboid(Vec3::splat(0.4)), roof])
}

/// Materials whose alpha hides a roof of vertex alpha `vertex_alpha`.
fn hiding() -> [(&'static str, f32, Arc<Material>); 3] {
    let of = |alpha: f32, alpha_mode| {
        Arc::new(Material {
            base_color: Vec4::new(0.7, 0.7, 0.7, alpha),
            alpha_mode,
            ..Material::matte(Vec3::ONE)
        })
    };
    [
        ("blended", 1.0, of(0.0, AlphaMode::Blend)),
        ("masked", 1.0, of(0.3, AlphaMode::Mask(0.5))),
        ("by its vertices", 0.0, of(1.0, AlphaMode::Blend)),
    ]
}

/// Judges the only light against the world's triangles as they are now.
fn judged(stage: &mut Stage, rendered: &Rendered) -> HardError {
    let scene = RayScene::from_world(&mut stage.world);
    judge(stage, &scene, 0, &rendered.visibility[0])
}

/// How the box and its roof stand.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Pose {
    Rest,
    Morphed,
    Skinned,
}

/// Spawns the box and its roof in a pose.
fn spawn_posed(stage: &mut Stage, mut mesh: MeshData, materials: &[Arc<Material>], pose: Pose) -> Entity {
    let vertex_count = mesh.positions.len();
    let moved = Vec3::new(-0.4, 0.2, 0.0);
    match pose {
        Pose::Rest => spawn(stage, mesh, materials),
        Pose::Morphed => {
            mesh.morph_targets.push(MorphTarget {
                positions: vec![moved; vertex_count],
                ..MorphTarget::default()
            });
            let object = spawn(stage, mesh, materials);
            stage.world.entity_mut(object).insert(MorphWeights(vec![1.0]));
            object
        }
        Pose::Skinned => {
            mesh.joints = vec![[0; 4]; vertex_count];
            mesh.joint_weights = vec![Vec4::X; vertex_count];
            let place = Transform::from_translation(Vec3::Y * 0.9 + moved);
            let joint = stage
                .world
                .spawn(place.with_rotation(Quat::from_rotation_y(0.3)))
                .id();
            let object = spawn(stage, mesh, materials);
            stage.world.entity_mut(object).insert(Skin {
                joints: vec![joint],
                inverse_bind: Arc::new([]),
            });
            object
        }
    }
}

#[test]
fn hidden_submeshes_cast_nothing() {
    for (what, vertex_alpha, material) in hiding() {
        let poses = [Pose::Rest, Pose::Morphed, Pose::Skinned];
        let few = if what == "blended" { 3 } else { 1 };
        for pose in poses.into_iter().take(few) {
            let mut mesh = box_and_roof();
            let roof = mesh.positions.len() - 24;
            mesh.colors = vec![Vec4::ONE; mesh.positions.len()];
            let colors = &mut mesh.colors[roof..];
            colors.iter_mut().for_each(|color| color.w = vertex_alpha);
            let mut stage = stage(StencilVolume::default());
            let object = spawn_posed(&mut stage, mesh, &[matte(), material.clone()], pose);
            let rendered = render(&mut stage);
            let error = judged(&mut stage, &rendered);
            assert!(
                error.inner > 5000 && error.wrong_inner == 0,
                "{what}, {pose:?}: {error:?}"
            );
            let dark = rendered.visibility[0].iter().filter(|seen| **seen == 0.0).count();
            assert!(
                (50..1500).contains(&dark),
                "{what}, {pose:?}: {dark} pixels are dark"
            );
            // A roof that shows casts, and the truth without it is another.
            let hidden = RayScene::from_world(&mut stage.world);
            let mut dress = |roof: Arc<Material>| {
                let materials = SceneMaterials(vec![matte(), roof].into());
                stage.world.entity_mut(object).insert(materials);
                let rendered = render(&mut stage);
                assert_eq!(judged(&mut stage, &rendered).wrong_inner, 0, "{what}, {pose:?}");
                judge(&stage, &hidden, 0, &rendered.visibility[0])
            };
            let error = dress(matte());
            assert!(
                error.wrong_inner > 300,
                "{what}, {pose:?}: the judge can fail: {error:?}"
            );
            assert_eq!(
                dress(material.clone()).wrong_inner,
                0,
                "{what}, {pose:?}: and hidden again"
            );
        }
    }
}

#[test]
fn maps_leave_out_what_is_hidden() {
    let (what, _, material) = &hiding()[0];
    let mut stage = stage(OmniMap::default());
    let object = spawn(&mut stage, box_and_roof(), &[matte(), material.clone()]);
    for hidden in [true, false, true] {
        let roof = if hidden { material.clone() } else { matte() };
        stage
            .world
            .entity_mut(object)
            .insert(SceneMaterials(vec![matte(), roof].into()));
        let rendered = render(&mut stage);
        let error = judged(&mut stage, &rendered);
        assert!(
            error.share().expect("pixels count") < 0.005,
            "{what}, {hidden}: {error:?}"
        );
    }
}

/// A box, and a hull around it that is turned inside out.
fn box_and_hull() -> [MeshData; 2] {
    let mut hull = MeshData::cuboid(Vec3::splat(0.46));
    let triangles = hull.indices.as_chunks_mut::<3>().0;
    triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    [MeshData::cuboid(Vec3::splat(0.4)), hull]
}

/// The truth without a hull, at the pixels that show no hull. `bare` is the world without it.
fn truth_without(stage: &mut Stage, bare: &mut Stage) -> VisibilityImage {
    let hits = |stage: &mut Stage| {
        let scene = RayScene::from_world(&mut stage.world);
        let camera = stage.world.get::<Camera>(stage.camera).expect("there is one");
        let place = stage
            .world
            .get::<GlobalTransform>(stage.camera)
            .expect("it stands");
        let hits = primary_hits_culled(&scene, camera, place, SIZE, PrimaryCulling::SingleSided);
        (scene, hits.expect("the camera is usable"))
    };
    let (_, seen) = hits(stage);
    let (scene, surfaces) = hits(bare);
    let source = LightSource::of_entity(&bare.world, bare.lights[0]).expect("the light is usable");
    let truth = hard_visibility(&scene, &surfaces, &source);
    let pixels = truth
        .values()
        .iter()
        .zip(seen.hits.iter().zip(&surfaces.hits))
        .map(|(value, (seen, bare))| match (seen, bare) {
            (Some(seen), Some(bare)) if seen.position.distance(bare.position) < 1e-6 => *value,
            _ => f32::NAN,
        });
    VisibilityImage::new(SIZE, pixels.collect()).expect("a whole picture")
}

#[test]
fn an_inverted_hull_that_is_a_submesh_casts_nothing() {
    let parts = box_and_hull();
    let mut bare = stage(StencilVolume::default());
    spawn(&mut bare, parts[0].clone(), &[matte()]);
    render(&mut bare);
    // As an object of its own a hull is left out, and so it is as a submesh.
    let mut apart = stage(StencilVolume::default());
    for part in &parts {
        spawn(&mut apart, part.clone(), &[matte()]);
    }
    let expected = render(&mut apart);
    let mut one = stage(StencilVolume::default());
    spawn(&mut one, joined(&parts), &[matte(), matte()]);
    let rendered = render(&mut one);
    assert_eq!(rendered.visibility, expected.visibility);
    let truth = truth_without(&mut one, &mut bare);
    let compare = |rendered: &Rendered| {
        let got = VisibilityImage::new(SIZE, rendered.visibility[0].clone()).expect("a whole picture");
        compare_hard(&truth, &got).expect("pictures of one size")
    };
    let error = compare(&rendered);
    assert!(error.inner > 5000 && error.wrong_inner == 0, "{error:?}");
    // The box itself is lit, which the hull would prevent.
    one.world.insert_resource(CulledCasters::Cast);
    let error = compare(&render(&mut one));
    assert!(error.wrong_inner > 100, "the comparison can fail: {error:?}");
    one.world.insert_resource(CulledCasters::LeaveOut);
    assert_eq!(render(&mut one).visibility, expected.visibility, "and back");
}

#[test]
fn maps_leave_out_hulls() {
    let mut stage = stage(OmniMap::default());
    let [body, hull] = box_and_hull();
    let object = spawn(&mut stage, joined(&[body.clone(), hull]), &[matte(), matte()]);
    let lit = |stage: &mut Stage| {
        let rendered = render(stage);
        rendered.visibility[0].iter().filter(|seen| **seen > 0.5).count()
    };
    let with_hull = lit(&mut stage);
    stage.world.insert_resource(CulledCasters::Cast);
    let dark = lit(&mut stage);
    stage
        .world
        .entity_mut(object)
        .insert((SceneMesh(Arc::new(body)), SceneMaterials([matte()].into())));
    let without = lit(&mut stage);
    println!("lit pixels: {with_hull} with the hull, {without} without, {dark} if it casts");
    assert!(dark + 100 < with_hull && with_hull.abs_diff(without) < (with_hull - dark) / 2);
}

/// A hull may be as large as an occluder, and what is in it is lit.
#[test]
fn a_left_out_hull_hides_nothing_from_the_light() {
    let [mut body, mut hull] = box_and_hull();
    body.positions.iter_mut().for_each(|at| *at *= 0.5);
    hull.positions.iter_mut().for_each(|at| *at *= 1.5);
    let mut stage = stage(StencilVolume::default());
    let object = spawn(&mut stage, joined(&[body, hull]), &[matte(), matte()]);
    let ball = MeshData::icosphere(0.15, 2);
    let ball = spawn(&mut stage, ball, &[matte()]);
    stage
        .world
        .entity_mut(ball)
        .insert(Transform::from_xyz(0.4, 1.2, 0.4));
    let is_reached = |stage: &mut Stage| {
        render(stage);
        let index = stage.world.resource::<Objects>().index_of(ball);
        let lights = stage.world.resource::<FrameLights>();
        lights.lights[0]
            .sets
            .l
            .contains(index.expect("the ball is an object"))
    };
    assert!(is_reached(&mut stage));
    stage.world.insert_resource(CulledCasters::Cast);
    assert!(!is_reached(&mut stage), "a hull that casts does hide it");
    stage.world.insert_resource(CulledCasters::LeaveOut);
    assert!(is_reached(&mut stage));
    // To a camera within its bounds the hull is there again.
    let camera = stage.camera;
    let within = Transform::from_xyz(0.3, 1.2, 0.2).looking_at(Vec3::ZERO, Vec3::Y);
    stage.world.entity_mut(camera).insert(within);
    assert!(!is_reached(&mut stage));
    stage.world.despawn(object);
    assert!(is_reached(&mut stage));
}
