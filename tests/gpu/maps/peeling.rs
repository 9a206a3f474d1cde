//! The second surface of a parallel map is found at the far end of its box too, where depth is a small difference of large
//! terms; and of a perspective one at any distance.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::maps::{FaceProjection, MapResolution, MapSurface, Maps};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// A floor, and a sheet some centimetres above it.
fn stage(gap: f32) -> Stage {
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Camera::default()
    };
    let view = Transform::from_xyz(2.2, 0.7, 1.5).looking_at(Vec3::new(0.2, 0.0, 0.0), Vec3::Y);
    let mut stage = Stage::empty(UVec2::new(96, 54), camera, view);
    stage.world.insert_resource(FaceCulling::None);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    add(&mut stage, MeshData::plane(3.0), Transform::default());
    add(
        &mut stage,
        MeshData::plane(0.5),
        Transform::from_xyz(0.0, gap, 0.0),
    );
    stage
}

fn add(stage: &mut Stage, mesh: MeshData, at: Transform) {
    stage.world.spawn((
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        at,
    ));
}

fn dark(stage: &mut Stage, kind: LightKind, at: Transform, surface: MapSurface) -> usize {
    for light in stage.lights.drain(..) {
        stage.world.despawn(light);
    }
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 20.0, 20.0)
    };
    let map = ShadowMap {
        resolution: MapResolution::Fixed(512),
        surface,
        ..Default::default()
    };
    stage.spawn_light(light, at, Some(map));
    let rendered = stage.render().expect("the frame renders");
    rendered.visibility[0].iter().filter(|v| **v < 0.9).count()
}

#[test]
fn the_second_surface_is_found_at_the_far_end() {
    for height in [10.0, 1000.0, 8000.0] {
        let mut stage = stage(0.2);
        // Something high up makes the box long. Its shadow falls behind the camera's back.
        let towards = Vec3::new(-0.8, 2.0, 0.1).normalize();
        let at = Vec3::new(2.7, 0.0, 2.7) + towards * height;
        add(
            &mut stage,
            MeshData::cuboid(Vec3::splat(0.1)),
            Transform::from_translation(at),
        );
        let sun = Transform::default().looking_to(-towards, Vec3::Y);
        let nearest = dark(&mut stage, LightKind::Directional, sun, MapSurface::Nearest);
        assert!(nearest > 60, "the sheet's shadow is seen: {nearest}");
        let map = stage.world.resource::<Maps>().of_light(0).expect("it has a map");
        let longest = map.faces.iter().map(|face| match face.face.projection {
            FaceProjection::Parallel { length, .. } => length,
            _ => 0.0,
        });
        assert!(longest.fold(0.0, f64::max) > f64::from(height), "the box is long");
        // The floor is the second surface under the sheet, so nothing shadows it.
        let second = dark(&mut stage, LightKind::Directional, sun, MapSurface::Second);
        assert_eq!(second, 0, "height {height}");
    }
}

#[test]
fn a_spot_light_a_metre_above_the_floor_finds_it() {
    let mut stage = stage(0.01);
    let spot = Transform::from_xyz(0.6, 1.0, 0.0).looking_to(Vec3::NEG_Y, Vec3::X);
    let kind = LightKind::Spot {
        inner_angle: 0.7,
        outer_angle: 0.9,
    };
    let second = dark(&mut stage, kind, spot, MapSurface::Second);
    assert_eq!(second, 0);
}
