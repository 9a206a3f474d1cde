//! The light model in frames of our own: its formulas, its terms, and whom it selects.

mod bad_input;
mod barn_maps;
mod blended;
mod cost;
mod defaults;
mod formulas;
mod moved_spots;
mod selection;
mod settings;
mod shadows;
mod shots;
mod sizes;
mod terms;

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, primary_hits};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;

/// Pixels of the pictures.
const SIZE: UVec2 = UVec2::new(96, 54);

/// A stage without ambient light, seen from above at a slant.
fn stage(context: &RenderContext) -> Stage {
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.05,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(1.5, 3.0, 5.0).looking_at(Vec3::new(0.0, 0.4, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    let settings = RenderSettings {
        ambient: Vec3::ZERO,
        background: Vec3::ZERO,
        ..RenderSettings::default()
    };
    stage
        .add_renderer(context.clone(), settings)
        .expect("shaders compose");
    stage
}

/// Adds an object that casts and receives.
fn add(stage: &mut Stage, mesh: MeshData, at: Vec3) -> Entity {
    add_of(stage, mesh, at, Material::matte(Vec3::new(0.7, 0.6, 0.5)))
}

fn add_of(stage: &mut Stage, mesh: MeshData, at: Vec3, material: Material) -> Entity {
    stage
        .world
        .spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(material)].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at),
        ))
        .id()
}

/// A floor and a ball that hangs over it.
fn floor_and_ball(stage: &mut Stage) -> [Entity; 2] {
    let floor = add(stage, MeshData::plane(12.0), Vec3::ZERO);
    let ball = add(stage, MeshData::icosphere(0.7, 4), Vec3::new(0.0, 1.0, 0.0));
    [floor, ball]
}

/// Places a light before the ball.
fn place() -> Transform {
    Transform::from_xyz(-1.5, 3.0, 1.0).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
}

/// A light with another light model and technique than the one that the stage had.
fn relight(stage: &mut Stage, light: Light, parts: impl Bundle) -> Entity {
    for old in stage.lights.drain(..) {
        stage.world.despawn(old);
    }
    stage.spawn_light(light, place(), Some(parts))
}

/// Inserts a part of a light's model, if there is one.
fn put(stage: &mut Stage, light: Entity, part: Option<impl Bundle>) {
    if let Some(part) = part {
        stage.world.entity_mut(light).insert(part);
    }
}

fn render(stage: &mut Stage) -> Rendered {
    stage.render().expect("the frame renders")
}

/// Red, green and blue of a pixel.
fn rgb(rendered: &Rendered, pixel: usize) -> [f32; 3] {
    std::array::from_fn(|i| rendered.radiance[4 * pixel + i])
}

/// The surface at each pixel's centre.
fn hits(stage: &mut Stage) -> (RayScene, HitImage) {
    let scene = RayScene::from_world(&mut stage.world);
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("there is a camera");
    let place = world
        .get::<GlobalTransform>(stage.camera)
        .expect("it is somewhere");
    let hits = primary_hits(&scene, camera, place, SIZE).expect("the camera is usable");
    (scene, hits)
}

/// The pixels whose neighbours all show the same object, with the surface at their centre.
fn inner_pixels(scene: &RayScene, hits: &HitImage) -> Vec<usize> {
    let entity = |x: i32, y: i32| {
        let at = (y * SIZE.x as i32 + x) as usize;
        let hit = hits.hits.get(at)?.as_ref()?;
        scene.triangles()[hit.triangle as usize].entity
    };
    let (width, height) = (SIZE.x as i32, SIZE.y as i32);
    let mut inner = Vec::new();
    for y in 1..height - 1 {
        for x in 1..width - 1 {
            let own = entity(x, y);
            let around = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            if own.is_some() && around.into_iter().all(|(dx, dy)| entity(x + dx, y + dy) == own) {
                inner.push((y * width + x) as usize);
            }
        }
    }
    inner
}
