//! What the host draws: scenes, their cameras and lights.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::HostView;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{EulerRot, Quat, UVec2, Vec3};

use crate::harness::support::stage::Stage;

/// Pixels of the views.
pub const SIZE: UVec2 = UVec2::new(160, 90);

/// A camera in perspective.
pub fn camera() -> Camera {
    Camera {
        vertical_fov: 0.9,
        near: 0.05,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    }
}

/// An orthographic camera, its near plane behind it.
pub fn parallel() -> Camera {
    Camera::orthographic(4.9, -1.0, 60.0, SIZE.x as f32 / SIZE.y as f32)
}

/// Boxes and spheres on a ground, at a place of the world where f32 has steps of 8 µm.
pub fn stage(context: &RenderContext, camera: Camera) -> Stage {
    let middle = Vec3::new(70.0, 3.0, -110.0);
    let view = Transform::from_translation(middle + Vec3::new(2.5, 3.0, 5.0)).looking_at(middle, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    let turned = Quat::from_euler(EulerRot::XYZ, 0.4, 0.7, 0.2);
    let at = |x, y, z| Transform::from_translation(middle + Vec3::new(x, y, z));
    let mut add = |mesh: MeshData, transform: Transform| {
        stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            transform,
        ));
    };
    add(
        MeshData::plane(20.0),
        at(0.0, 0.0, 0.0).with_rotation(Quat::from_rotation_x(0.05)),
    );
    add(
        MeshData::cuboid(Vec3::splat(0.5)),
        at(0.0, 0.6, 0.0).with_rotation(turned),
    );
    add(
        MeshData::cuboid(Vec3::splat(0.5)),
        at(-1.5, 0.8, 0.6)
            .with_scale(Vec3::new(-0.5, 1.6, 0.8))
            .with_rotation(turned),
    );
    add(MeshData::icosphere(0.6, 4), at(1.3, 0.7, -0.4));
    add(MeshData::icosphere(0.4, 3), at(-0.2, 1.7, 0.1));
    stage.world.insert_resource(FaceCulling::None);
    stage
}

/// Adds a light beside and above the scene of [`stage`], turned to it.
pub fn light_at(stage: &mut Stage, kind: LightKind, shadow: impl Bundle) {
    let eye = Vec3::new(72.0, 8.0, -108.0);
    let place = Transform::from_translation(eye).looking_at(Vec3::new(70.0, 3.0, -110.0), Vec3::Z);
    let range = f32::INFINITY;
    stage.spawn_light(
        Light {
            kind,
            range,
            ..Light::point(Vec3::ONE, 20.0, range)
        },
        place,
        Some(shadow),
    );
}

/// Tiles behind a wall, all dark, and a pole among them that the light sees over the wall: the light pass of a frame of our
/// own need not draw the tiles, and nothing need shadow them; a host lights whatever is there.
pub fn dark_tiles(context: &RenderContext) -> Stage {
    let view = Transform::from_xyz(13.0, 5.0, 3.0).looking_at(Vec3::new(3.0, 1.0, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera(), view);
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .expect("shaders compose");
    let mut add = |half: Vec3, at: Vec3| {
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::cuboid(half))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_translation(at),
        ));
    };
    add(Vec3::new(0.1, 1.5, 9.0), Vec3::new(0.0, 1.5, 0.0));
    add(Vec3::new(0.1, 4.0, 0.1), Vec3::new(3.0, 4.0, 0.5));
    for tile in 0..24 {
        let (row, column) = ((tile / 6) as f32, (tile % 6) as f32);
        let at = Vec3::new(1.5 + 2.0 * row, 0.0, 2.0 * column - 5.0);
        add(Vec3::new(0.95, 0.05, 0.95), at);
    }
    let place = Transform::from_xyz(-2.0, 2.0, 0.0);
    let light = Light::point(Vec3::ONE, 20.0, 14.0);
    stage.spawn_light(light, place, Some(StencilVolume::default()));
    stage
}

/// A host whose targets are as large as the view, and whose projection is ours.
pub fn alone(camera: &Camera) -> HostView {
    HostView {
        target_size: SIZE,
        viewport_origin: UVec2::ZERO,
        clip_from_view: camera.clip_from_view(),
    }
}
