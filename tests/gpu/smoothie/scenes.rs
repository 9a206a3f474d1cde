//! What the tests of smoothies share.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, primary_hits};
use antumbra::techniques::SmoothieWidth;
use antumbra::techniques::maps::MapResolution;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{UVec2, Vec3};

use crate::harness::support::stage::Stage;

/// Pixels of the pictures.
pub const SIZE: UVec2 = UVec2::new(128, 72);

/// A wide spot light.
pub const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.5,
    outer_angle: 0.8,
};

/// Texels along a side of the maps.
pub const FIXED: MapResolution = MapResolution::Fixed(512);

/// Smoothies of a width.
pub fn smoothie(width: SmoothieWidth) -> Smoothie {
    Smoothie {
        width,
        spread: 0.05,
        resolution: FIXED,
        ..Default::default()
    }
}

/// Gives a light the plain map of its kind.
pub fn plain(light: &mut EntityWorldMut, kind: LightKind) {
    if matches!(kind, LightKind::Spot { .. } | LightKind::Directional) {
        light.insert(ShadowMap {
            resolution: FIXED,
            ..Default::default()
        });
    } else {
        light.insert(OmniMap {
            resolution: FIXED,
            ..Default::default()
        });
    }
}

/// A stage with a camera alone.
pub fn empty(context: &RenderContext, view: Transform) -> Stage {
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    stage
}

/// A stage with a camera and a ground.
pub fn ground(context: &RenderContext, eye: Vec3, target: Vec3) -> Stage {
    let mut stage = empty(
        context,
        Transform::from_translation(eye).looking_at(target, Vec3::Y),
    );
    spawn(&mut stage, MeshData::plane(8.0), Transform::IDENTITY);
    stage
}

/// Adds a caster that receives.
pub fn spawn(stage: &mut Stage, mesh: MeshData, place: Transform) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
        (ShadowCaster, ShadowReceiver),
        place,
    );
    stage.world.spawn(parts).id()
}

/// A light at a place that shines straight down.
pub fn lamp(kind: LightKind, from: Vec3) -> (Light, Transform) {
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 40.0, 30.0)
    };
    (
        light,
        Transform::from_translation(from).looking_at(from - Vec3::Y, Vec3::Z),
    )
}

/// Visibility of the first light.
pub fn rendered(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("the frame renders").visibility.remove(0)
}

/// The surface of every pixel in the frame that ran last.
pub fn hits(stage: &Stage) -> HitImage {
    let world = &stage.world;
    let mut triangles = Vec::new();
    for entity in world
        .archetypes()
        .iter()
        .flat_map(|archetype| archetype.entities())
    {
        let entity = entity.id();
        let (Some(mesh), Some(place)) = (
            world.get::<SceneMesh>(entity),
            world.get::<GlobalTransform>(entity),
        ) else {
            continue;
        };
        let at = |index: u32| place.transform_point(mesh.0.positions[index as usize]).as_dvec3();
        triangles.extend(
            mesh.0
                .indices
                .chunks_exact(3)
                .map(|corners| [at(corners[0]), at(corners[1]), at(corners[2])]),
        );
    }
    let scene = RayScene::from_triangles(triangles);
    let camera = world.get::<Camera>(stage.camera).expect("a camera");
    let transform = world.get::<GlobalTransform>(stage.camera).expect("its place");
    primary_hits(&scene, camera, transform, world.resource::<ViewportSize>().0).expect("a usable camera")
}
