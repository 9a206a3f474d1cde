//! A ground with boxes and balls, as an orthographic camera sees it.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::RayScene;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Quat, UVec2, Vec3};

use crate::harness::support::stage::Stage;

/// Pixels of the test pictures.
pub const SIZE: UVec2 = UVec2::new(160, 90);

/// Adds a caster that receives.
pub fn spawn(stage: &mut Stage, mesh: MeshData, place: Transform) -> Entity {
    let mesh = SceneMesh(Arc::new(mesh));
    let materials = SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into());
    let object = stage
        .world
        .spawn((mesh, materials, (ShadowCaster, ShadowReceiver), place));
    object.id()
}

/// The scene under a camera of a height, near and far, looking down aslant.
pub fn ground(context: &RenderContext, height: f32, near: f32, far: f32) -> Stage {
    let view = Transform::from_xyz(2.5, 3.0, 4.5).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
    let mut stage = empty(context, view, [height, near, far]);
    spawn(&mut stage, MeshData::plane(20.0), Transform::IDENTITY);
    let turned = Quat::from_rotation_y(0.6);
    spawn(
        &mut stage,
        MeshData::cuboid(Vec3::splat(0.4)),
        Transform::from_xyz(0.0, 0.5, 0.0).with_rotation(turned),
    );
    spawn(
        &mut stage,
        MeshData::icosphere(0.35, 3),
        Transform::from_xyz(1.1, 0.9, -0.5),
    );
    spawn(
        &mut stage,
        MeshData::cuboid(Vec3::new(0.1, 0.6, 0.1)),
        Transform::from_xyz(-1.2, 0.6, 0.4),
    );
    stage
}

/// A plate that stands upright at the origin before a wall, seen aslant. A lamp on the +Z axis faces both.
pub fn plate_before_wall(context: &RenderContext) -> Stage {
    let view = Transform::from_xyz(2.5, 1.5, 1.0).looking_at(Vec3::new(0.0, 0.0, -3.0), Vec3::Y);
    let mut stage = empty(context, view, [6.0, 0.1, 30.0]);
    let upright = Quat::from_rotation_x(std::f32::consts::FRAC_PI_2);
    for (half_size, z) in [(0.35, 0.0), (4.0, -4.0)] {
        let place = Transform::from_xyz(0.0, 0.0, z).with_rotation(upright);
        spawn(&mut stage, MeshData::plane(half_size), place);
    }
    stage
}

fn empty(context: &RenderContext, view: Transform, [height, near, far]: [f32; 3]) -> Stage {
    let camera = Camera::orthographic(height, near, far, SIZE.x as f32 / SIZE.y as f32);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    stage
}

/// Puts a light above it.
pub fn light(stage: &mut Stage, kind: LightKind, from: Vec3, range: f32, shadow: impl Bundle) {
    for light in stage.lights.drain(..) {
        stage.world.despawn(light);
    }
    let light = Light {
        kind,
        color: Vec3::ONE,
        intensity: 40.0,
        range,
    };
    let place = Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::X);
    stage.spawn_light(light, place, Some(shadow));
}

/// The same triangles for the judge.
pub fn rays(stage: &mut Stage) -> RayScene {
    stage.schedule.run(&mut stage.world);
    RayScene::from_world(&mut stage.world)
}
