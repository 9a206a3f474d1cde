//! Scenes whose visibility has a closed form.

use antumbra::reference::{
    LightShape, LightSource, RayScene, SurfaceHit, hard_visibility, soft_visibility, soft_visibility_at,
};
use antumbra::scene::{LightKind, LightSelection, MeshData};
use bevy_transform::prelude::Transform;
use glam::{DVec3, Quat, Vec3};

use super::harness::*;

const SPOT: LightKind = LightKind::Spot {
    inner_angle: 0.3,
    outer_angle: 0.4,
};

/// Where the ray to the light ends, and the direction to it, for lights without extent.
fn towards(light: &LightSource, point: DVec3) -> (DVec3, f64) {
    match light.shape {
        LightShape::Directional { towards } => (towards, f64::INFINITY),
        LightShape::Point { position } | LightShape::Spot { position, .. } => (position - point, 1.0),
        _ => unreachable!("no closed form here"),
    }
}

/// Whether the segment or half-line passes within `radius` of `center`.
fn meets_ball(point: DVec3, (direction, end): (DVec3, f64), center: DVec3, radius: f64) -> bool {
    let t = ((center - point).dot(direction) / direction.length_squared()).clamp(0.0, end);
    (point + direction * t).distance(center) < radius
}

/// Whether the segment or half-line meets the box around the origin, for `point` outside of it.
fn meets_box(point: DVec3, (direction, end): (DVec3, f64), half: DVec3) -> bool {
    let (a, b) = ((-half - point) / direction, (half - point) / direction);
    a.min(b).max_element().max(0.0) < a.max(b).min_element().min(end)
}

#[test]
fn shadow_of_a_sphere_lies_between_those_of_its_inner_and_outer_ball() {
    let center = Vec3::new(0.0, 1.5, 0.0);
    let ball = MeshData::icosphere(1.0, 4);
    let scene = scene_of([
        (MeshData::plane(20.0), Transform::IDENTITY),
        (ball, Transform::from_translation(center)),
    ]);
    let inner_radius = scene
        .triangles()
        .iter()
        .filter(|triangle| triangle.corners[0].y > 0.0)
        .map(|triangle| {
            let [a, b, c] = triangle.corners;
            (b - a).cross(c - a).normalize().dot(a - center.as_dvec3())
        })
        .fold(f64::INFINITY, f64::min);
    assert!(inner_radius > 0.99);

    let hits = view(&scene, Vec3::new(1.0, 3.0, 5.0), Vec3::ZERO);
    let eye = Vec3::new(2.0, 7.0, 1.0);
    for kind in [LightKind::Point, SPOT, LightKind::Directional] {
        let light = light(kind, eye, Vec3::ZERO);
        let image = hard_visibility(&scene, &hits, &light);
        let (mut lit, mut dark, mut undecided) = (0, 0, 0);
        for (value, hit) in image.values().iter().zip(&hits.hits) {
            let Some(hit) = hit else { continue };
            if value.is_nan() || hit.position.y > 1e-9 {
                continue;
            }
            let path = towards(&light, hit.position);
            if meets_ball(hit.position, path, center.as_dvec3(), inner_radius - 1e-9) {
                assert_eq!(*value, 0.0, "{kind:?}: shadowed at {}", hit.position);
                dark += 1;
            } else if meets_ball(hit.position, path, center.as_dvec3(), 1.0 + 1e-6) {
                undecided += 1;
            } else {
                assert_eq!(*value, 1.0, "{kind:?}: lit at {}", hit.position);
                lit += 1;
            }
        }
        assert!(
            dark > 100 && lit > 100 && undecided < 20,
            "{kind:?}: {dark} {lit} {undecided}"
        );
    }
}

#[test]
fn shadow_of_a_box_standing_on_the_floor_equals_the_slab_test_at_every_pixel() {
    let half = Vec3::new(0.5, 1.0, 0.75);
    let scene = scene_of([
        (MeshData::plane(20.0), Transform::from_xyz(0.0, -1.0, 0.0)),
        (MeshData::cuboid(half), Transform::IDENTITY),
    ]);
    let hits = view(&scene, Vec3::new(2.0, 2.0, -3.0), -Vec3::Y);
    for kind in [LightKind::Point, SPOT, LightKind::Directional] {
        let light = light(kind, Vec3::new(-2.0, 5.0, 1.5), Vec3::ZERO);
        let image = hard_visibility(&scene, &hits, &light);
        let mut counts = [0; 2];
        for (value, hit) in image.values().iter().zip(&hits.hits) {
            let Some(hit) = hit else { continue };
            if value.is_nan() {
                continue;
            }
            // Convex: what faces the light on the box itself is lit.
            let on_floor = hit.position.y < -1.0 + 1e-9;
            let path = towards(&light, hit.position);
            let shadowed = on_floor && meets_box(hit.position, path, half.as_dvec3());
            assert_eq!(
                *value,
                f32::from(u8::from(!shadowed)),
                "{kind:?} at {}",
                hit.position
            );
            counts[usize::from(shadowed)] += 1;
        }
        assert!(counts.iter().all(|count| *count > 100), "{kind:?}: {counts:?}");
    }
}

#[test]
fn cone_range_and_facing_say_which_pixels_count() {
    let scene = scene_of([(MeshData::plane(20.0), Transform::IDENTITY)]);
    let hits = view(&scene, Vec3::new(0.0, 8.0, 6.0), Vec3::ZERO);
    let position = Vec3::new(0.0, 4.0, 0.0);
    let mut spot = light(SPOT, position, Vec3::ZERO);
    spot.range = 4.2;
    let image = hard_visibility(&scene, &hits, &spot);
    for (value, hit) in image.values().iter().zip(&hits.hits) {
        let Some(hit) = hit else { continue };
        let radius = hit.position.length();
        let expected = radius / 4.0 < (0.4f64 * 0.99).tan() && radius.hypot(4.0) < 4.2 * 0.999;
        assert_eq!(!value.is_nan(), expected, "at {}", hit.position);
    }
    assert_all(&image, 1.0);
    for below in [LightKind::Point, LightKind::Directional] {
        let image = hard_visibility(&scene, &hits, &light(below, -position, Vec3::ZERO));
        assert_eq!(image.counted(), 0, "{below:?} from below");
    }
    let upward = LightKind::Rect {
        width: 1.0,
        height: 1.0,
    };
    let image = hard_visibility(&scene, &hits, &light(upward, position, position * 2.0));
    assert_eq!(image.counted(), 0, "behind the rectangle");
}

/// A floor, and a half-plane at height 1 over x > 0.
fn floor_and_half_plane() -> RayScene {
    let quad = |min: DVec3, max: DVec3| {
        let [b, d] = [DVec3::new(min.x, min.y, max.z), DVec3::new(max.x, min.y, min.z)];
        [[min, b, max], [min, max, d]]
    };
    let floor = quad(DVec3::new(-9.0, 0.0, -9.0), DVec3::new(9.0, 0.0, 9.0));
    let blocker = quad(DVec3::new(0.0, 1.0, -50.0), DVec3::new(50.0, 1.0, 50.0));
    RayScene::from_triangles(floor.into_iter().chain(blocker))
}

#[test]
fn penumbra_of_a_rectangle_over_a_half_plane_is_its_area_fraction() {
    let scene = floor_and_half_plane();
    let hits = view(&scene, Vec3::new(-3.0, 0.9, 0.0), Vec3::ZERO);
    let (width, height) = (1.0, 3.0);
    let kind = LightKind::Rect {
        width: 1.0,
        height: 2.0,
    };
    let mut light = light(kind, Vec3::new(0.0, height as f32, 0.0), Vec3::ZERO);
    light.shape = LightShape::Rect {
        center: DVec3::Y * height,
        half_right: DVec3::X * 0.5,
        half_up: DVec3::Z,
        direction: -DVec3::Y,
    };
    let image = soft_visibility(&scene, &hits, &light, 256, 7);
    let (mut penumbra, mut sum_sq) = (0, 0.0);
    for (value, hit) in image.values().iter().zip(&hits.hits) {
        let Some(hit) = hit else { continue };
        if value.is_nan() || hit.position.y > 0.5 {
            continue;
        }
        let visible = ((hit.position.x * (1.0 - height) + width * 0.5) / width).clamp(0.0, 1.0);
        let error = (f64::from(*value) - visible).abs();
        assert!(error <= 1.0 / 16.0, "at {}: {value} for {visible}", hit.position);
        if visible > 0.0 && visible < 1.0 {
            penumbra += 1;
            sum_sq += error * error;
        }
    }
    // One stratum a row is cut: the deviation is at most ½ · 16^(−3/2) = 0.0078.
    let rmse = (sum_sq / f64::from(penumbra)).sqrt();
    assert!(penumbra > 100 && rmse < 0.0078, "{penumbra} pixels, rmse {rmse}");
}

#[test]
fn penumbra_of_a_sphere_over_a_half_plane_is_the_circular_segment() {
    let scene = floor_and_half_plane();
    let receiver = scene
        .triangles()
        .iter()
        .position(|t| t.corners[0].y == 0.0)
        .unwrap() as u32;
    let (height, radius) = (3.0, 0.5);
    for i in -7..=7 {
        let x = f64::from(i) * 0.04;
        let hit = SurfaceHit {
            position: DVec3::new(x, 0.0, 0.0),
            normal: DVec3::Y,
            triangle: receiver,
            distance: 1.0,
            view_depth: 1.0,
        };
        // Straight over the receiver, so that the disc is horizontal.
        let light = LightSource {
            shape: LightShape::Sphere {
                center: DVec3::new(x, height, 0.0),
                radius,
            },
            range: f64::INFINITY,
            selection: LightSelection::default(),
        };
        // The half-plane's edge seen from the point crosses the disc at this share of the radius.
        let edge = (-x * height / radius).clamp(-1.0, 1.0);
        let visible = 1.0 - (edge.acos() - edge * (1.0 - edge * edge).sqrt()) / std::f64::consts::PI;
        let got = soft_visibility_at(&scene, &hit, &light, 4096, 3, i as u64);
        assert!(
            (f64::from(got) - visible).abs() < 0.01,
            "at {x}: {got} for {visible}"
        );
    }
}

#[test]
fn half_of_a_sphere_on_the_horizon_is_seen() {
    let scene = RayScene::from_triangles([[DVec3::ZERO, DVec3::Z, DVec3::X]]);
    let hit = SurfaceHit {
        position: DVec3::new(0.2, 0.0, 0.2),
        normal: DVec3::Y,
        triangle: 0,
        distance: 1.0,
        view_depth: 1.0,
    };
    let light = LightSource {
        shape: LightShape::Sphere {
            center: DVec3::new(5.0, 0.0, 0.2),
            radius: 1.0,
        },
        range: f64::INFINITY,
        selection: LightSelection::default(),
    };
    let got = soft_visibility_at(&scene, &hit, &light, 1024, 1, 0);
    assert!((got - 0.5).abs() < 0.01, "{got}");
}

#[test]
fn a_closed_box_keeps_light_in_and_out() {
    let turned = Transform::from_rotation(Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.5, 0.7));
    let scene = scene_of([(MeshData::cuboid(Vec3::splat(2.0)), turned)]);
    let hits = view(&scene, Vec3::new(0.3, 0.2, 0.1), Vec3::X);
    assert!(hits.hits.iter().all(Option::is_some), "the box is closed");
    assert_all(&hard(&scene, &hits, &point_light(Vec3::splat(-0.5))), 1.0);
    let outside = hits.hits.iter().flatten().map(|hit| {
        let away = hit.position - hit.normal * 5.0;
        let receiver = Some(hit.triangle);
        assert!(
            !scene.blocks_segment(hit.position, away, receiver, u32::MAX),
            "straight out"
        );
        let through = hit.position + hit.normal * 50.0;
        scene.blocks_segment(hit.position, through, receiver, u32::MAX)
    });
    assert!(
        outside.into_iter().all(|blocked| blocked),
        "light from outside never enters"
    );
}

#[test]
fn a_light_in_a_sphere_lights_its_inside_alone() {
    let center = Vec3::new(0.0, 3.0, 0.0);
    let scene = scene_of([
        (MeshData::plane(9.0), Transform::IDENTITY),
        (MeshData::icosphere(1.0, 3), Transform::from_translation(center)),
    ]);
    let lamp = point_light(center + Vec3::splat(0.1));
    let inside = view(&scene, center, center + Vec3::X);
    assert_all(&hard(&scene, &inside, &lamp), 1.0);
    let floor = view(&scene, Vec3::new(0.0, 2.0, 6.0), Vec3::ZERO);
    assert_all(&hard(&scene, &floor, &lamp), 0.0);
}
