//! Small worlds, cameras and lights for the judge's tests.

use std::sync::Arc;

use antumbra::reference::{HitImage, LightSource, RayScene, VisibilityImage, hard_visibility, primary_hits};
use antumbra::scene::{
    Camera, Light, LightKind, LightSelection, Material, MeshData, SceneMaterials, SceneMesh, ShadowCaster,
    ShadowReceiver,
};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};
use smallvec::smallvec;

pub const SIZE: UVec2 = UVec2::new(96, 64);

/// Spawns a mesh that is seen, blocks and receives.
pub fn spawn(world: &mut World, mesh: MeshData, transform: Transform) -> Entity {
    world
        .spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials(smallvec![Arc::new(Material::matte(Vec3::ONE))]),
            ShadowCaster,
            ShadowReceiver,
            transform,
            GlobalTransform::from(transform),
        ))
        .id()
}

pub fn scene_of(meshes: impl IntoIterator<Item = (MeshData, Transform)>) -> RayScene {
    let mut world = World::new();
    for (mesh, transform) in meshes {
        spawn(&mut world, mesh, transform);
    }
    RayScene::from_world(&mut world)
}

pub fn looking_at(eye: Vec3, target: Vec3) -> GlobalTransform {
    let up = if (target - eye).normalize().y.abs() > 0.99 {
        Vec3::Z
    } else {
        Vec3::Y
    };
    Transform::from_translation(eye).looking_at(target, up).into()
}

pub fn camera() -> Camera {
    Camera {
        vertical_fov: 0.9,
        near: 0.05,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    }
}

pub fn view(scene: &RayScene, eye: Vec3, target: Vec3) -> HitImage {
    primary_hits(scene, &camera(), &looking_at(eye, target), SIZE).unwrap()
}

pub fn light(kind: LightKind, eye: Vec3, target: Vec3) -> LightSource {
    let light = Light {
        kind,
        color: Vec3::ONE,
        intensity: 1.0,
        range: f32::INFINITY,
    };
    LightSource::new(&light, &looking_at(eye, target), LightSelection::default()).unwrap()
}

pub fn point_light(position: Vec3) -> LightSource {
    light(LightKind::Point, position, position - Vec3::Z)
}

pub fn hard(scene: &RayScene, hits: &HitImage, light: &LightSource) -> VisibilityImage {
    hard_visibility(scene, hits, light)
}

/// Asserts that all pixels that count have this value, and that there are some.
pub fn assert_all(image: &VisibilityImage, expected: f32) {
    assert!(image.counted() > 100, "only {} pixels count", image.counted());
    let wrong = image
        .values()
        .iter()
        .filter(|v| !v.is_nan() && **v != expected)
        .count();
    assert_eq!(
        wrong,
        0,
        "{wrong} of {} pixels are not {expected}",
        image.counted()
    );
}
