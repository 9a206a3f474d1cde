//! Where cascades end: their filters find room at the corners of the view.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::scene::ShadowSoftness;
use antumbra::techniques::maps::{MapFilter, MapResolution};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// The view of a floor that lies wholly in the shadow of a roof.
fn hall(size: UVec2, camera: Camera, view: Transform) -> Stage {
    let camera = Camera {
        aspect: size.x as f32 / size.y as f32,
        ..camera
    };
    let mut stage = Stage::empty(size, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    for height in [-0.25, 6.0] {
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::cuboid(Vec3::new(20.0, 0.25, 20.0)))),
            SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(0.0, height, 0.0),
        ));
    }
    stage
}

fn sun(direction: Vec3) -> (Light, Transform) {
    let place = Transform::default().looking_to(direction, Vec3::X);
    (Light::directional(Vec3::ONE, 1.0), place)
}

#[test]
fn filters_find_room_at_the_corners_of_the_view() {
    let cameras = [
        Camera::orthographic(6.0, 0.1, 5.5, 1.0),
        Camera {
            vertical_fov: 60_f32.to_radians(),
            ..Default::default()
        },
    ];
    for camera in cameras {
        let up = Vec3::new(1.0, 0.0, 1.0);
        let view = Transform::from_xyz(0.0, 5.0, 0.0).looking_at(Vec3::new(0.0, 0.0, 0.001), up);
        let mut stage = hall(UVec2::splat(100), camera, view);
        let mut names = Vec::new();
        for direction in [Vec3::NEG_Y, Vec3::new(-1.0, -2.0, -1.0)] {
            let (light, place) = sun(direction);
            let with = |filter, resolution| ShadowMap {
                filter,
                resolution: MapResolution::Fixed(resolution),
                ..Default::default()
            };
            let jittered = |softness| MapFilter::Jittered {
                softness,
                adaptive: true,
            };
            for (filter, resolution) in [
                (MapFilter::Bilinear, 1024),
                (MapFilter::Brute4x4, 64),
                (MapFilter::Bilinear, 12),
                (MapFilter::Soft4 { softness: 0.5 }, 512),
                (jittered(0.5), 512),
                (jittered(1.0), 512),
            ] {
                stage.spawn_light(light.clone(), place, Some(with(filter, resolution)));
                names.push(format!("{filter:?} at {resolution}"));
            }
            let softened = stage.spawn_light(light.clone(), place, Some(with(MapFilter::Bilinear, 512)));
            stage.world.entity_mut(softened).insert(ShadowSoftness(0.5));
            names.push("softness of the light".to_owned());
            let smoothie = Smoothie {
                resolution: MapResolution::Fixed(64),
                ..Default::default()
            };
            stage.spawn_light(light, place, Some(smoothie));
            names.push("smoothie".to_owned());
        }
        let rendered = stage.render().expect("the frame renders");
        for (name, seen) in names.iter().zip(&rendered.visibility) {
            let lit = seen.iter().filter(|seen| **seen > 0.0).count();
            assert_eq!(lit, 0, "{name}, orthographic: {}", camera.orthographic.is_some());
        }
    }
}
