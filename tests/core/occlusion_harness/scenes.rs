//! Random scenes of large things close together.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::schedule::init_resources;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{Vec2, Vec3, Vec4};

use super::{Random, VIEWPORT};

/// A mesh of any kind.
fn mesh(random: &mut Random) -> MeshData {
    match random.below(5) {
        0 => MeshData::cuboid(random.vec(1.0).abs() * Vec3::new(2.0, 2.0, 0.5) + 0.05),
        1 => MeshData::plane(random.range(0.5, 3.0)),
        2 => MeshData::icosphere(random.range(0.3, 1.5), 1 + random.below(2) as u32),
        3 => {
            // An open box: one face is missing.
            let mut open = MeshData::cuboid(random.vec(1.5).abs() + 0.2);
            open.indices.truncate(30);
            open.submeshes[0].index_count = 30;
            open
        }
        _ => {
            let corners = (0..24).map(|_| random.vec(1.5)).collect();
            let indices = (0..36).map(|_| random.below(24) as u32).collect();
            MeshData::from_triangles("soup", corners, indices)
        }
    }
}

fn material(random: &mut Random) -> Material {
    let alpha_mode = match random.below(10) {
        0 => AlphaMode::Blend,
        1 => AlphaMode::Mask(0.5),
        _ => AlphaMode::Opaque,
    };
    Material {
        base_color: Vec4::ONE,
        alpha_mode,
        double_sided: random.chance(0.2),
        ..Material::default()
    }
}

/// A light of any kind, most of them shadowed.
pub fn spawn_light(world: &mut World, random: &mut Random, at: Vec3) {
    let range = [f32::INFINITY, random.range(3.0, 15.0)][random.below(2)];
    let mut light = Light::point(Vec3::ONE, 10.0, range);
    light.kind = match random.below(8) {
        0 => LightKind::Directional,
        1 | 2 => LightKind::Spot {
            inner_angle: 0.1,
            outer_angle: random.range(0.2, 1.57),
        },
        3 => LightKind::Sphere { radius: 0.3 },
        4 => LightKind::Rect {
            width: 0.5,
            height: 0.3,
        },
        _ => LightKind::Point,
    };
    let selection = LightSelection {
        affects: [u32::MAX, 0b011][random.below(2)],
        casts_for: [u32::MAX, u32::MAX, 0b101][random.below(3)],
        ..LightSelection::default()
    };
    let place = Transform::from_translation(at).with_rotation(random.rotation());
    let mut entity = world.spawn((light, selection, place));
    if random.chance(0.85) {
        entity.insert(StencilVolume::default());
    }
}

/// Objects that take any part, before a camera that stands among them.
pub fn random_scene(seed: u64) -> World {
    let mut random = Random::new(seed);
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(VIEWPORT));
    world.insert_resource([FaceCulling::SingleSided, FaceCulling::None][random.below(2)]);
    let origin = [Vec3::ZERO, Vec3::ZERO, Vec3::new(2e3, -1e3, 5e2)][random.below(3)];
    let mirror = |random: &mut Random| if random.chance(0.2) { -1.0 } else { 1.0 };
    let camera = Camera {
        vertical_fov: random.range(0.4, 2.0),
        near: random.range(0.02, 0.4),
        aspect: 16.0 / 9.0,
        shift: Vec2::new(random.range(-0.5, 0.5), random.range(-0.5, 0.5))
            * f32::from(u8::from(seed.is_multiple_of(3))),
        ..Camera::default()
    };
    let view = Transform::from_translation(origin + random.vec(3.0))
        .with_rotation(random.rotation())
        .with_scale(Vec3::new(mirror(&mut random), 1.0, 1.0));
    world.spawn((camera, view));
    let meshes: Vec<Arc<MeshData>> = (0..8).map(|_| Arc::new(mesh(&mut random))).collect();
    for _ in 0..60 {
        let mut place =
            Transform::from_translation(origin + random.vec(8.0)).with_rotation(random.rotation());
        place.scale = Vec3::new(
            random.range(0.4, 2.5) * mirror(&mut random),
            random.range(0.4, 2.5),
            random.range(0.4, 2.5),
        );
        let mesh = meshes[random.below(meshes.len())].clone();
        let mut entity = world.spawn((SceneMesh(mesh), place, SelectionLayers(1 << random.below(3))));
        if random.chance(0.9) {
            entity.insert(SceneMaterials([Arc::new(material(&mut random))].into()));
        }
        if random.chance(0.85) {
            entity.insert(ShadowCaster);
        }
        if random.chance(0.85) {
            entity.insert(ShadowReceiver);
        }
    }
    for _ in 0..5 {
        let at = origin + random.vec(6.0);
        spawn_light(&mut world, &mut random, at);
    }
    world
}
