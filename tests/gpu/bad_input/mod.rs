//! Bad assets and settings are skipped and counted: never a panic, a wgpu error, a NaN on the GPU or a lost frame.
//!
//! Most claims have one form: a scene with something bad in it gives, to the last bit, the picture of the scene
//! without it. [`same`] compares; each file has a control that it can fail.

mod device;
mod exchange;
mod far_away;
mod lights;
mod materials;
mod meshes;
mod targets;
mod transforms;

use std::sync::Arc;

use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;
use crate::harness::{judge, own_context, strict_context};
use antumbra::prelude::*;
use antumbra::reference::{HardError, RayScene};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

/// Size of the pictures.
const SIZE: UVec2 = UVec2::new(96, 64);

/// Share of wrong pixels outside of the edge band that a picture may have: that of `reference_match`.
const ALLOWED: f64 = 0.001;

fn camera() -> Camera {
    Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    }
}

fn view() -> Transform {
    Transform::from_xyz(3.0, 4.0, 8.0).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
}

fn matte() -> Arc<Material> {
    Arc::new(Material::matte(Vec3::splat(0.8)))
}

/// What an object that casts and receives is spawned from.
fn object(mesh: MeshData, transform: Transform) -> impl Bundle {
    let materials = mesh.submeshes.iter().map(|_| matte()).collect();
    (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials(materials),
        (ShadowCaster, ShadowReceiver),
        transform,
    )
}

/// The usual light, without a shadow technique.
fn light() -> (Light, Transform) {
    let light = Light::point(Vec3::ONE, 60.0, 30.0);
    (light, Transform::from_xyz(2.0, 5.0, 1.5))
}

/// A camera over an empty world; surfaces are seen from both sides, as they block.
fn empty_stage(context: &RenderContext) -> Stage {
    let mut stage = Stage::empty(SIZE, camera(), view());
    stage.world.insert_resource(FaceCulling::None);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    stage
}

/// A box on a plane under one point light with stencil volumes.
fn box_on_plane(context: &RenderContext) -> Stage {
    let mut stage = empty_stage(context);
    stage
        .world
        .spawn(object(MeshData::plane(6.0), Transform::IDENTITY));
    stage.world.spawn(object(
        MeshData::cuboid(Vec3::splat(0.5)),
        Transform::from_xyz(0.0, 0.75, 0.0),
    ));
    let (light, at) = light();
    stage.spawn_light(light, at, Some(StencilVolume::default()));
    stage
}

/// Renders, and asserts that no texel is NaN or infinite.
#[track_caller]
fn render(stage: &mut Stage) -> Rendered {
    let rendered = stage.render().expect("the frame renders");
    let bad = rendered
        .radiance
        .iter()
        .filter(|value| !value.is_finite())
        .count();
    assert_eq!(bad, 0, "{bad} values of the radiance are not finite");
    rendered
}

/// Whether two frames are equal to the last bit in all that both have.
fn same(a: &Rendered, b: &Rendered) -> bool {
    a.picture == b.picture && a.radiance == b.radiance && a.visibility[0] == b.visibility[0]
}

/// Judges the first light against the ray caster.
#[track_caller]
fn assert_true(stage: &mut Stage, rendered: &Rendered) -> HardError {
    let scene = RayScene::from_world(&mut stage.world);
    let error = judge(stage, &scene, 0, &rendered.visibility[0]);
    assert!(error.share().unwrap_or(0.0) <= ALLOWED, "{error:?}");
    error
}

#[test]
fn the_usual_scene_is_right_and_comparison_finds_a_hair() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let first = render(&mut stage);
    assert!(assert_true(&mut stage, &first).inner > 1000, "enough is judged");
    assert!(first.visibility[0].contains(&0.0), "there is a shadow");
    assert!(same(&first, &render(&mut stage)), "and it is the same again");
    let light = stage.lights[0];
    let mut at = stage
        .world
        .get_mut::<Transform>(light)
        .expect("it stands somewhere");
    at.translation.x += 1.5;
    let moved = render(&mut stage);
    assert!(!same(&first, &moved));
    let scene = RayScene::from_world(&mut stage.world);
    let error = judge(&stage, &scene, 0, &first.visibility[0]);
    assert!(
        error.share().is_some_and(|share| share > ALLOWED),
        "the judge finds the old shadow wrong"
    );
}
