//! Faces with a 4×4 matrix: however their pictures are warped, the shadows are those of the ray caster.

use antumbra::insides::matrix_faces::{parallel_face, point_face};
use antumbra::insides::{LightRequest, MapRequests, MapShape, MapSystems};
use antumbra::prelude::*;
use antumbra::techniques::maps::{MapFilter, MapResolution};
use antumbra::techniques::{TechniqueSystems, TextureMemorySystems};
use bevy_ecs::prelude::*;
use glam::{DMat3, DVec3, Vec3};

use super::scenes;
use super::scenes::TestScene;
use crate::harness::maps::{Judge, MapError};
use crate::harness::strict_context;

/// The warp of the pictures.
#[derive(Resource, Clone, Copy)]
struct Warp {
    homography: DMat3,
    layers: u32,
    /// The negative control: the face is drawn from a place beside the light.
    beside: DVec3,
}

/// Exchanges every request of a plain map by faces with a matrix, which look where the light looks.
fn warp_requests(mut requests: ResMut<MapRequests>, lights: Res<FrameLights>, warp: Res<Warp>) {
    let asked: Vec<LightRequest> = requests.drain().collect();
    for mut asked in asked {
        let light = &lights.lights[asked.light];
        let z = light.direction.as_dvec3().normalize();
        let (x, y) = z.any_orthonormal_pair();
        let origin = light.world_from_light.translation().as_dvec3() + warp.beside;
        asked.request.shape = MapShape::Matrices;
        asked.request.layers = warp.layers;
        // Each layer shows a strip of the picture, and all overlap.
        asked.faces = (0..warp.layers)
            .map(|layer| {
                let layers = f64::from(warp.layers);
                let middle = 2.0 * (f64::from(layer) + 0.5) / layers - 1.0;
                let strip = DMat3::from_cols(
                    DVec3::X * layers * 0.9,
                    DVec3::Y,
                    DVec3::new(-middle * layers * 0.9, 0.0, 1.0),
                );
                let homography = strip * warp.homography;
                if light.light.kind == LightKind::Directional {
                    parallel_face(origin - z * 10.0, [x, y, z], &homography, 30.0)
                } else {
                    point_face(origin, [x, y, z], &homography, 1e-3)
                }
            })
            .collect();
        requests.push(asked);
    }
}

const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.5,
    outer_angle: 0.8,
};

fn judge(scene: &TestScene, kind: LightKind, filter: MapFilter, warp: Warp) -> MapError {
    let (mut stage, rays) = scene.stage(&strict_context());
    let (light, place) = scene.light(kind);
    let map = ShadowMap {
        resolution: MapResolution::Fixed(1024),
        filter,
        ..Default::default()
    };
    stage.world.insert_resource(warp);
    stage.schedule.add_systems(
        warp_requests
            .in_set(TechniqueSystems)
            .after(MapSystems::Request)
            .before(TextureMemorySystems::Ask),
    );
    stage.spawn_light(light, place, Some(map));
    let rendered = stage.render().expect("the frame renders");
    let mut judge = Judge::new(&stage, &rays, 0).expect("something casts");
    judge.band = if filter == MapFilter::Bilinear { 1.0 } else { 3.5 };
    judge.compare(&rendered.visibility[0])
}

/// A homography that shows the middle 1.2 (a spot's directions) or 5 m (a box) and is warped towards one side.
fn warped(kind: LightKind, x: f64, y: f64) -> DMat3 {
    let half = if kind == LightKind::Directional { 6.0 } else { 1.3 };
    let warp = DMat3::from_cols(DVec3::new(1.0, 0.1, x), DVec3::new(-0.2, 1.0, y), DVec3::Z);
    let shrink = DMat3::from_diagonal(DVec3::new(0.5, 0.5, 1.0));
    shrink * warp * DMat3::from_diagonal(DVec3::new(1.0 / half, 1.0 / half, 1.0))
}

#[test]
fn warped_faces_equal_ray_cast_up_to_a_texel() {
    let scenes = scenes::all();
    let mut all = MapError::default();
    for (index, (x, y)) in [(0.0, 0.0), (0.5, 0.0), (-0.3, 0.35)].into_iter().enumerate() {
        for kind in [SPOT, LightKind::Directional] {
            let each = [
                (MapFilter::Bilinear, 1),
                (MapFilter::Bilinear, 3),
                (MapFilter::Brute4x4, 3),
            ];
            let (filter, layers) = each[index];
            let scene = &scenes[index * 3];
            let warp = Warp {
                homography: warped(kind, x, y),
                layers,
                beside: DVec3::ZERO,
            };
            let error = judge(scene, kind, filter, warp);
            assert!(
                error.wrong == 0 && error.acne == 0,
                "{} {kind:?} {filter:?} {layers}: {error:?}",
                scene.name
            );
            all.add(error);
        }
    }
    assert!(all.dark > 1000, "{all:?}");
}

#[test]
fn a_face_from_beside_the_light_is_found_out() {
    let scenes = scenes::all();
    let warp = Warp {
        homography: warped(SPOT, 0.3, 0.0),
        layers: 1,
        beside: Vec3::new(0.0, 0.0, 0.2).as_dvec3(),
    };
    let error = judge(&scenes[0], SPOT, MapFilter::Bilinear, warp);
    assert!(error.wrong > 50, "{error:?}");
}
