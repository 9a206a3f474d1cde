//! Walls that a light grazes, close behind what shadows them: the inside of a closed ball is dark under a light outside of it.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::maps::{MapFormat, MapResolution};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(160, 90);

/// Radius of the ball, metres.
const RADIUS: f32 = 0.6;

/// Distance of the light from the middle of the ball, metres.
const DISTANCE: f32 = 2.6;

/// Directions from the ball to the light.
const DIRECTIONS: [Vec3; 3] = [
    Vec3::new(-0.28, 0.94, 0.24),
    Vec3::new(0.7, 0.2, -0.6),
    Vec3::new(0.1, -0.5, 0.8),
];

/// The number of pixels that show the inside of the ball, and of those that a map lights.
fn lit(map: OmniMap) -> (usize, usize) {
    let (mut seen, mut lit) = (0, 0);
    for direction in DIRECTIONS {
        let camera = Camera {
            vertical_fov: 80_f32.to_radians(),
            near: 0.01,
            aspect: SIZE.x as f32 / SIZE.y as f32,
            ..Camera::default()
        };
        let side = direction.any_orthonormal_vector();
        let view = Transform::from_translation(side * -0.2).looking_at(side, direction);
        let mut stage = Stage::empty(SIZE, camera, view);
        stage
            .add_renderer(strict_context(), RenderSettings::default())
            .expect("shaders compose");
        stage.world.insert_resource(FaceCulling::None);
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::icosphere(RADIUS, 1))),
            SceneMaterials([Arc::new(Material::matte(Vec3::splat(0.8)))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::IDENTITY,
        ));
        stage.spawn_light(
            Light::point(Vec3::ONE, 20.0, 9.0),
            Transform::from_translation(direction.normalize() * DISTANCE),
            Some(map),
        );
        let rendered = stage.render().expect("the frame renders");
        seen += rendered.visibility[0].len();
        lit += rendered.visibility[0]
            .iter()
            .filter(|visibility| **visibility > 0.5)
            .count();
    }
    (seen, lit)
}

#[test]
fn the_inside_of_a_closed_ball_is_dark() {
    let of = |format, resolution| {
        let (seen, lit) = lit(OmniMap {
            format,
            resolution,
            ..OmniMap::default()
        });
        println!("{format:?} {resolution:?}: {lit} of {seen} lit");
        (seen, lit)
    };
    let (seen, depth) = of(MapFormat::Depth, MapResolution::default());
    let (_, distances) = of(MapFormat::R32Float, MapResolution::default());
    let (_, coarse) = of(MapFormat::Depth, MapResolution::Fixed(64));
    assert!(depth * 50 < seen, "{depth} of {seen}");
    assert!(depth < 2 * distances, "{depth}; by distances {distances}");
    assert!(coarse > 3 * depth, "coarse maps pass too: {coarse}");
}
