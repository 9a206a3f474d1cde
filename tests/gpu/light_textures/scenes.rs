//! A matte plane and a sphere under one light, and the factor by which its textures scale it at each pixel.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{RayScene, primary_hits};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{DVec3, UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Pixels of the pictures.
pub const SIZE: UVec2 = UVec2::new(96, 64);

/// Largest relative error of radiance.
pub const TOLERANCE: f32 = 1.0 / 500.0;

/// All kinds of lights, each with a name.
pub fn kinds() -> [(&'static str, LightKind); 5] {
    let spot = LightKind::Spot {
        inner_angle: 0.6,
        outer_angle: 1.1,
    };
    let rect = LightKind::Rect {
        width: 0.2,
        height: 0.1,
    };
    [
        ("spot", spot),
        ("rect", rect),
        ("point", LightKind::Point),
        ("sphere", LightKind::Sphere { radius: 0.05 }),
        ("directional", LightKind::Directional),
    ]
}

/// Place of the light: beside the sphere, above the plane, turned about all axes.
pub fn light_place() -> Transform {
    Transform::from_xyz(-1.2, 2.2, 1.4).looking_at(Vec3::new(0.2, 0.2, 0.0), Vec3::new(0.3, 1.0, 0.1))
}

/// The stage, without shadows: visibility is 1 everywhere.
pub struct Scene {
    /// World, schedule and renderer.
    pub stage: Stage,
    /// The light.
    pub light: Entity,
    /// The point of each pixel in light space: x to the right, y upwards, z the depth before the light.
    pub points: Vec<Option<DVec3>>,
}

impl Scene {
    /// A scene that a light of this kind lights.
    pub fn new(kind: LightKind) -> Self {
        Self::shadowed(kind, ())
    }

    /// A scene that a light of this kind lights, with a technique.
    pub fn shadowed(kind: LightKind, shadow: impl Bundle) -> Self {
        let camera = Camera {
            vertical_fov: 0.8,
            aspect: SIZE.x as f32 / SIZE.y as f32,
            ..Camera::default()
        };
        let view = Transform::from_xyz(0.6, 2.4, 4.2).looking_at(Vec3::new(0.0, 0.2, 0.0), Vec3::Y);
        let mut stage = Stage::empty(SIZE, camera, view);
        let settings = RenderSettings {
            ambient: Vec3::ZERO,
            background: Vec3::ZERO,
            ..Default::default()
        };
        stage
            .add_renderer(strict_context(), settings)
            .expect("shaders compose");
        let mut add = |mesh: MeshData, transform: Transform| {
            stage.world.spawn((
                SceneMesh(Arc::new(mesh)),
                SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
                (ShadowCaster, ShadowReceiver),
                transform,
            ));
        };
        add(MeshData::plane(6.0), Transform::IDENTITY);
        add(MeshData::icosphere(0.6, 5), Transform::from_xyz(0.3, 0.6, 0.0));
        stage.world.insert_resource(FaceCulling::None);
        let light = Light {
            kind,
            ..Light::point(Vec3::new(1.0, 0.8, 0.6), 8.0, f32::INFINITY)
        };
        let place = light_place();
        let light = stage.spawn_light(light, place, Some(shadow));
        stage.schedule.run(&mut stage.world);
        let points = points(&mut stage, place);
        Self { stage, light, points }
    }

    /// Linear radiance of each pixel.
    pub fn radiance(&mut self) -> Vec<Vec3> {
        let rendered = self.stage.render().expect("the frame renders");
        let rgba = rendered.radiance.chunks_exact(4);
        rgba.map(|rgba| Vec3::new(rgba[0], rgba[1], rgba[2])).collect()
    }

    /// Radiance with components on the light that are taken away again.
    pub fn radiance_with(&mut self, components: impl Bundle) -> Vec<Vec3> {
        let mut light = self.stage.world.entity_mut(self.light);
        light.insert(components);
        let radiance = self.radiance();
        let mut light = self.stage.world.entity_mut(self.light);
        light.remove::<(Cookie, LightProfile)>();
        radiance
    }
}

fn points(stage: &mut Stage, light: Transform) -> Vec<Option<DVec3>> {
    let scene = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).expect("it has a camera");
    let place = stage
        .world
        .get::<GlobalTransform>(stage.camera)
        .expect("it stands");
    let hits = primary_hits(&scene, camera, place, SIZE).expect("the camera is usable");
    let local_from_world = light.rotation.inverse().as_dquat();
    let local = |at: DVec3| local_from_world * (at - light.translation.as_dvec3());
    let points = hits.hits.iter();
    points
        .map(|hit| hit.map(|hit| local(hit.position) * DVec3::new(1.0, 1.0, -1.0)))
        .collect()
}

/// The largest relative error of a picture against another one times a factor, and how many pixels are lit.
pub fn largest_error(
    scene: &Scene,
    plain: &[Vec3],
    scaled: &[Vec3],
    factor: impl Fn(DVec3) -> Option<Vec3>,
) -> (f32, usize) {
    let (mut largest, mut lit) = (0.0f32, 0);
    for ((plain, scaled), point) in plain.iter().zip(scaled).zip(&scene.points) {
        let Some(factor) = point.and_then(&factor) else {
            continue;
        };
        let expected = *plain * factor;
        // Halves below this have fewer digits.
        let error = (*scaled - expected).abs() / expected.max(Vec3::splat(1e-4));
        largest = largest.max(error.max_element());
        lit += usize::from(scaled.max_element() > 0.01);
    }
    (largest, lit)
}
