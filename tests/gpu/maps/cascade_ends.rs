//! Where cascades end: their filters find room at the corners of the view, and shadows fade out before the view depth at which
//! they are to end.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{RayScene, SurfaceHit, primary_hits};
use antumbra::scene::ShadowSoftness;
use antumbra::techniques::maps::{MapFilter, MapResolution};
use antumbra::techniques::shadow_map::Cascades;
use bevy_transform::prelude::{GlobalTransform, Transform};
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

#[test]
fn shadows_fade_out_before_the_depth_at_which_they_end() {
    let perspective = Camera {
        vertical_fov: 60_f32.to_radians(),
        ..Default::default()
    };
    let orthographic = Camera::orthographic(6.0, 0.1, 60.0, 1.0);
    for (camera, scale) in [(&perspective, 1.0), (&perspective, 2.0), (&orthographic, 1.0)] {
        let view = Transform::from_xyz(-12.0, 2.0, 0.0)
            .looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y)
            .with_scale(Vec3::splat(scale));
        let mut stage = hall(UVec2::new(100, 56), *camera, view);
        let (light, place) = sun(Vec3::new(0.1, -1.0, 0.05));
        let mut cascades = Vec::new();
        for distance in [6.0, 11.0] {
            for (count, blend) in [(1, 0.1), (4, 0.5), (4, 0.0)] {
                let of = Cascades {
                    count,
                    distance,
                    blend,
                    ..Default::default()
                };
                let map = ShadowMap {
                    cascades: of,
                    ..Default::default()
                };
                let smoothie = Smoothie {
                    cascades: of,
                    ..Default::default()
                };
                stage.spawn_light(light.clone(), place, Some(map));
                stage.spawn_light(light.clone(), place, Some(smoothie));
                cascades.extend([of, of]);
            }
        }
        let rendered = stage.render().expect("the frame renders");
        let rays = RayScene::from_world(&mut stage.world);
        let camera = stage
            .world
            .get::<Camera>(stage.camera)
            .expect("there is a camera");
        let at = stage
            .world
            .get::<GlobalTransform>(stage.camera)
            .expect("it stands somewhere");
        let hits = primary_hits(&rays, camera, at, UVec2::new(100, 56)).expect("the camera is usable");
        for (index, (of, seen)) in cascades.iter().zip(&rendered.visibility).enumerate() {
            let distance = f64::from(of.distance);
            let fade = f64::from(of.blend) * distance;
            let (mut dark, mut fading, mut lit) = (0, 0, 0);
            for (hit, seen) in hits.hits.iter().zip(seen) {
                // The top of the floor; the lowest lines of sight of the orthographic camera begin inside of it.
                let is_top = |hit: &SurfaceHit| hit.normal.y > 0.5 && hit.position.y.abs() < 0.1;
                let Some(hit) = hit.filter(|hit| is_top(hit) && hit.position.abs().max_element() < 18.0)
                else {
                    continue;
                };
                let depth = hit.view_depth * f64::from(scale);
                if (depth - distance).abs() < 1e-3 {
                    continue; // rounding decides
                }
                let expected = if fade > 0.0 {
                    (1.0 - (distance - depth) / fade).clamp(0.0, 1.0)
                } else {
                    f64::from(u8::from(depth > distance))
                };
                assert!(
                    (f64::from(*seen) - expected).abs() < 4e-3,
                    "light {index}, {of:?}, camera of scale {scale}: {seen} at {depth}, {}, not {expected}",
                    hit.position
                );
                match expected {
                    0.0 => dark += 1,
                    1.0 => lit += 1,
                    _ => fading += 1,
                }
            }
            assert!(dark > 50 && lit > 50, "{of:?}: {dark} dark, {lit} lit");
            assert!(fading > 20 || of.blend == 0.0, "{of:?}: {fading} pixels between");
        }
    }
}
