//! Casters behind the camera, in front of its near plane and around the light cast exactly; lights ahead, behind, in the
//! plane of the eye and at the eye.

use antumbra::prelude::*;
use antumbra::techniques::maps::Maps;
use antumbra::techniques::{PerspectiveFaces, PerspectiveProjection};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::{SPOT, variants};
use crate::harness::maps::{Judge, MapError};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;
use antumbra::reference::RayScene;

const SIZE: UVec2 = UVec2::new(96, 54);

/// A street of boxes along −z, with the eye at height 1.7 in its middle; boxes stand before, behind and beside the eye.
fn street(boxes: &[([f32; 3], [f32; 3])], near: f32) -> Stage {
    let camera = Camera {
        vertical_fov: 1.0,
        near,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(0.0, 1.7, 0.0).looking_at(Vec3::new(0.0, 1.0, -5.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let mut add = |mesh: MeshData, at: Transform| {
        stage.world.spawn((
            SceneMesh(std::sync::Arc::new(mesh)),
            SceneMaterials([std::sync::Arc::new(Material::matte(Vec3::splat(0.7)))].into()),
            (ShadowCaster, ShadowReceiver),
            at,
        ));
    };
    add(MeshData::plane(40.0), Transform::default());
    for (at, half) in boxes {
        add(
            MeshData::cuboid((*half).into()),
            Transform::from_translation((*at).into()),
        );
    }
    stage
}

fn judge(stage: &mut Stage, light: Light, place: Transform, map: PerspectiveMap) -> MapError {
    for old in stage.lights.drain(..) {
        stage.world.despawn(old);
    }
    stage.spawn_light(light, place, Some(map));
    let rendered = stage.render().expect("the frame renders");
    let rays = RayScene::from_world(&mut stage.world);
    let judge = Judge::new(stage, &rays, 0).expect("something casts");
    judge.compare(&rendered.visibility[0])
}

fn sun(direction: Vec3) -> (Light, Transform) {
    let up = if direction.normalize().y.abs() > 0.95 {
        Vec3::X
    } else {
        Vec3::Y
    };
    (
        Light::directional(Vec3::ONE, 3.0),
        Transform::default().looking_to(direction, up),
    )
}

fn lamp(kind: LightKind, at: Vec3, to: Vec3) -> (Light, Transform) {
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 50.0, 60.0)
    };
    let up = if (to - at).normalize().y.abs() > 0.95 {
        Vec3::X
    } else {
        Vec3::Y
    };
    (light, Transform::from_translation(at).looking_at(to, up))
}

/// A tower behind the viewer, a slab over its head, and a box that the near plane cuts away.
const AROUND: [([f32; 3], [f32; 3]); 5] = [
    ([0.5, 3.0, 4.0], [0.5, 3.0, 0.5]),
    ([-1.5, 4.0, 0.2], [0.7, 0.1, 1.5]),
    ([0.1, 2.2, -0.45], [0.15, 0.1, 0.1]),
    ([1.5, 0.7, -4.0], [0.5, 0.7, 0.5]),
    ([-2.0, 0.5, -9.0], [0.6, 0.5, 0.6]),
];

#[test]
fn casters_behind_the_viewer_and_before_the_near_plane_cast_exactly() {
    let mut stage = street(&AROUND, 0.8);
    let mut dark = 0;
    let lights = [
        sun(Vec3::new(-0.1, -0.5, -1.0)), // from behind
        sun(Vec3::new(0.2, -1.0, -0.05)), // from above
        sun(Vec3::new(-0.7, -0.6, 0.6)),  // from ahead
        lamp(LightKind::Point, Vec3::new(0.8, 7.5, 7.0), Vec3::ZERO),
        lamp(SPOT, Vec3::new(0.3, 5.0, 1.5), Vec3::new(0.0, 0.0, -2.5)),
    ];
    for (index, (light, place)) in lights.into_iter().enumerate() {
        for map in &variants(1024)[..4] {
            let error = judge(&mut stage, light.clone(), place, *map);
            assert!(error.wrong == 0, "light {index}, {map:?}: {error:?}");
            dark += error.dark;
        }
    }
    assert!(dark > 3000, "{dark}");
}

/// The eye is next to a plate that lies a hundredth of its size above the ground: between two texels the depth of the map
/// changes by more than from the plate to the ground.
#[test]
fn nothing_shines_through_a_plate_close_above_the_ground() {
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.004,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let view = Transform::from_xyz(0.7, 0.012, 0.7).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    for (half, height) in [(6.0, -0.01), (0.7, 0.0)] {
        stage.world.spawn((
            SceneMesh(std::sync::Arc::new(MeshData::plane(half))),
            SceneMaterials([std::sync::Arc::new(Material::matte(Vec3::ONE))].into()),
            (ShadowCaster, ShadowReceiver),
            Transform::from_xyz(0.0, height, 0.0),
        ));
    }
    let below = Transform::from_xyz(0.68, -0.005, 0.68).looking_at(Vec3::new(0.0, -0.006, 0.0), Vec3::Y);
    for view in [view, below] {
        let camera = stage.camera;
        stage.world.entity_mut(camera).insert(view);
        for (light, place) in [
            lamp(SPOT, Vec3::new(0.9, 1.6, 0.6), Vec3::ZERO),
            lamp(LightKind::Point, Vec3::new(0.9, 1.6, 0.6), Vec3::ZERO),
            sun(Vec3::new(-0.5, -1.0, -0.4)),
        ] {
            let error = judge(&mut stage, light.clone(), place, variants(1024)[0]);
            println!("{:?}: {error:?}", light.kind);
            assert!(error.wrong == 0, "{:?}: {error:?}", light.kind);
        }
    }
}

#[test]
fn lights_ahead_behind_in_the_plane_of_the_eye_and_at_the_eye_are_exact() {
    let mut stage = street(&AROUND, 0.1);
    let (mut dark, mut counted) = (0, 0);
    let forward = Vec3::new(0.0, -0.7, -5.0).normalize();
    let eye = Vec3::new(0.0, 1.7, 0.0);
    let lights = [
        sun(forward),                                                       // along the view
        sun(Vec3::new(0.0, -5.0, 0.7)),                                     // in the plane of the eye
        sun(-(forward * Vec3::new(1.0, -1.0, 1.0))),                        // towards the viewer
        lamp(LightKind::Point, eye + Vec3::new(1.0, 0.8, 0.0), Vec3::ZERO), // beside the eye
        lamp(LightKind::Point, eye, Vec3::new(0.0, 0.0, -5.0)),             // at the eye
        lamp(LightKind::Point, Vec3::new(-0.4, 2.0, -5.0), Vec3::ZERO),     // ahead, between receivers
        lamp(SPOT, eye + Vec3::new(0.02, 0.03, 0.0), Vec3::new(0.0, 0.5, -5.0)),
        lamp(SPOT, Vec3::new(0.0, 1.5, -14.0), Vec3::new(0.0, 0.3, 0.0)), // towards the viewer
    ];
    for (index, (light, place)) in lights.into_iter().enumerate() {
        for map in [variants(1024)[0], variants(1024)[2 + index % 3]] {
            let error = judge(&mut stage, light.clone(), place, map);
            assert!(error.wrong == 0, "light {index}, {map:?}: {error:?}");
            dark += error.dark;
            counted += error.counted;
        }
    }
    assert!(dark > 3000 && counted > 20_000, "{dark} of {counted}");
}

/// Four bars around a lamp: their shadows go in all directions, and the lamp's camera can see no two of them in one picture.
#[test]
fn casters_around_a_lamp_cast_exactly() {
    let bars = [
        ([0.6, 3.0, -3.0], [0.04, 0.8, 0.04]),
        ([-0.6, 3.0, -3.0], [0.04, 0.8, 0.04]),
        ([0.0, 3.0, -2.4], [0.04, 0.8, 0.04]),
        ([0.0, 3.0, -3.6], [0.04, 0.8, 0.04]),
        ([-4.0, 2.0, -5.0], [0.1, 2.0, 4.0]),
        ([4.0, 2.0, -5.0], [0.1, 2.0, 4.0]),
    ];
    let picture = |bars: &[([f32; 3], [f32; 3])], map| {
        let mut stage = street(bars, 0.1);
        let (light, place) = lamp(LightKind::Point, Vec3::new(0.0, 3.0, -3.0), Vec3::ZERO);
        let error = judge(&mut stage, light, place, map);
        assert!(error.wrong == 0, "{map:?}: {error:?}");
        error.dark
    };
    for map in &variants(1024)[..4] {
        let (all, walls) = (picture(&bars, *map), picture(&bars[4..], *map));
        assert!(all > walls + 60, "{map:?}: {all} {walls}");
    }
}

/// What a light with a cone of no or of every angle darkens, and a light in a view without receivers.
#[test]
fn degenerate_cones_and_views_without_receivers_draw_without_a_fault() {
    let mut stage = street(&AROUND, 0.1);
    for outer_angle in [0.0, 1e-6, 0.01, 1.57, std::f32::consts::FRAC_PI_2, 3.0] {
        let kind = LightKind::Spot {
            inner_angle: 0.0,
            outer_angle,
        };
        let (light, place) = lamp(kind, Vec3::new(0.3, 5.0, 1.5), Vec3::new(0.0, 0.0, -2.5));
        for old in stage.lights.drain(..) {
            stage.world.despawn(old);
        }
        stage.spawn_light(light, place, Some(variants(256)[0]));
        let rendered = stage.render().expect("the frame renders");
        assert!(
            rendered.visibility[0].iter().all(|v| (0.0..=1.0).contains(v)),
            "{outer_angle}"
        );
    }
    let mut receivers = stage
        .world
        .query_filtered::<bevy_ecs::prelude::Entity, bevy_ecs::prelude::With<ShadowReceiver>>();
    for receiver in receivers.iter(&stage.world).collect::<Vec<_>>() {
        stage.world.entity_mut(receiver).remove::<ShadowReceiver>();
    }
    let rendered = stage.render().expect("the frame renders");
    assert!(rendered.visibility[0].iter().all(|v| *v == 1.0));
}

#[test]
fn without_the_caster_behind_the_viewer_the_judge_objects() {
    let mut stage = street(&AROUND, 0.1);
    let (light, place) = sun(Vec3::new(-0.1, -0.5, -1.0));
    stage.spawn_light(light, place, Some(variants(512)[0]));
    let rendered = stage.render().expect("the frame renders");
    let rays = RayScene::from_world(&mut stage.world);
    let right = Judge::new(&stage, &rays, 0)
        .expect("something casts")
        .compare(&rendered.visibility[0]);
    let mut others = street(&AROUND[3..], 0.1);
    let (light, place) = sun(Vec3::new(-0.1, -0.5, -1.0));
    others.spawn_light(light, place, Some(variants(512)[0]));
    let rendered = others.render().expect("the frame renders");
    let judge = Judge::new(&stage, &rays, 0).expect("something casts");
    let without = judge.compare(&rendered.visibility[0]);
    assert!(right.wrong == 0 && without.leaks > 100, "{right:?} {without:?}");
}

/// The virtual viewer stands behind a slab of two kilometres, so the cube's faces are nearly uniform. Automatic resolution makes up for
/// it.
#[test]
fn maps_that_fit_badly_get_more_texels() {
    let boxes = [
        ([0.5, 0.5, -5.0], [0.5; 3]),
        ([0.0, -0.49, 0.0], [1000.0, 0.5, 1000.0]),
    ];
    let mut stage = street(&boxes, 0.05);
    let mut fitted = |projection| {
        let map = PerspectiveMap {
            projection,
            faces: PerspectiveFaces::Cube,
            cached: true,
            ..PerspectiveMap::default()
        };
        let light = Light::point(Vec3::ONE, 40.0, f32::INFINITY);
        let place = Transform::from_xyz(2.0, 4.0, -4.0);
        let error = judge(&mut stage, light, place, map);
        let maps = stage.world.resource::<Maps>();
        (maps.of_light(0).expect("it has a map").resolution, error)
    };
    let (usual, _) = fitted(PerspectiveProjection::Inverse);
    let (stretched, error) = fitted(PerspectiveProjection::SlideBack);
    println!("{usual} texels, slid back {stretched}: {error:?}");
    assert!(stretched >= 4 * usual, "{stretched} {usual}");
    assert!(error.dark > 20 && error.share() < 0.005, "{error:?}");
}
