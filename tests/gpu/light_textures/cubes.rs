//! Cookies that are cubes around a light, against direct evaluation of their faces.

use antumbra::prelude::*;
use antumbra::scene::CookieImage;
use glam::{DVec3, Vec2, Vec3};

use super::cookies::folder;
use super::scenes::{Scene, TOLERANCE, kinds, largest_error};

/// Texels along a side of a face.
const SIDE: u32 = 8;

/// Share of light of a texel of a face.
fn pattern(face: u32, x: u32, y: u32) -> Vec3 {
    let wave = |at: u32, speed: f32| 0.55 + 0.4 * (at as f32 * speed).sin();
    Vec3::new(
        wave(x + y + face, 0.9),
        wave(3 * face + x, 1.3),
        wave(2 * y + face, 0.5),
    )
}

/// A file with the faces in a cross, as artists have them: left, ahead, right, behind in a row.
fn load_cross() -> std::sync::Arc<CookieImage> {
    let linear_to_srgb = |c: f32| {
        if c <= 0.003_130_8 {
            c * 12.92
        } else {
            1.055 * c.powf(1.0 / 2.4) - 0.055
        }
    };
    // Right, left, up, down, ahead, behind.
    let places = [(2, 1), (0, 1), (1, 0), (1, 2), (1, 1), (3, 1)];
    let mut image = image::ImageBuffer::<image::Rgb<u16>, Vec<u16>>::new(4 * SIDE, 3 * SIDE);
    for (face, (column, row)) in (0..6).zip(places) {
        for (x, y) in (0..SIDE).flat_map(|y| (0..SIDE).map(move |x| (x, y))) {
            let color = pattern(face, x, y).to_array();
            let texel = color.map(|c| (linear_to_srgb(c) * 65535.0).round() as u16);
            image.put_pixel(column * SIDE + x, row * SIDE + y, image::Rgb(texel));
        }
    }
    let path = folder().join("cross.png");
    image.save(&path).expect("the picture is written");
    CookieImage::load_cube(&path).expect("the picture is read")
}

/// The pattern in a direction that points to the right, upwards and ahead, seen from the light. `None` near the edges of
/// faces, where neighbouring faces blend.
fn at(direction: DVec3) -> Option<Vec3> {
    let DVec3 { x, y, z } = direction;
    let along = direction.abs().max_element();
    // To the right and downwards on the face, as somebody at the light sees it who has turned towards the face; for the
    // upper and the lower face, who looked ahead before.
    let (face, right, down) = if along == x.abs() {
        if x > 0.0 { (0, -z, -y) } else { (1, z, -y) }
    } else if along == y.abs() {
        if y > 0.0 { (2, x, z) } else { (3, x, -z) }
    } else if z > 0.0 {
        (4, x, -y)
    } else {
        (5, -x, -y)
    };
    let texel = |at: f64| (at / along * 0.5 + 0.5) * f64::from(SIDE) - 0.5;
    let (column, row) = (texel(right), texel(down));
    let inside = |at: f64| at >= 0.0 && at <= f64::from(SIDE - 1);
    if !inside(column) || !inside(row) {
        return None;
    }
    let (left, upper) = (column.floor(), row.floor());
    let value = |dx: u32, dy: u32| {
        let x = (left as u32 + dx).min(SIDE - 1);
        pattern(face, x, (upper as u32 + dy).min(SIDE - 1))
    };
    let (across, along) = ((column - left) as f32, (row - upper) as f32);
    let above = value(0, 0).lerp(value(1, 0), across);
    let below = value(0, 1).lerp(value(1, 1), across);
    Some(above.lerp(below, along))
}

#[test]
fn lights_shine_through_the_faces_of_a_cube() {
    let image = load_cross();
    for (name, kind) in kinds() {
        if kind == LightKind::Directional {
            continue;
        }
        let mut scene = Scene::new(kind);
        let plain = scene.radiance();
        for (turn, yaw, density) in [(0.0f64, 0.0f64, 1.0f32), (0.4, 0.9, 0.7)] {
            let cookie = Cookie {
                turn: turn as f32,
                offset: Vec2::new(yaw as f32, 0.0),
                density,
                ..Cookie::new(image.clone())
            };
            let scaled = scene.radiance_with(cookie);
            let factor = |point: DVec3, turn: f64| {
                // Back from the turn to the right, and then from the one counterclockwise.
                let (sin, cos) = yaw.sin_cos();
                let point = DVec3::new(
                    point.x * cos - point.z * sin,
                    point.y,
                    point.x * sin + point.z * cos,
                );
                let (sin, cos) = turn.sin_cos();
                let point = DVec3::new(
                    point.x * cos + point.y * sin,
                    point.y * cos - point.x * sin,
                    point.z,
                );
                at(point).map(|picture| Vec3::ONE.lerp(picture, density))
            };
            let (error, lit) = largest_error(&scene, &plain, &scaled, |point| factor(point, turn));
            println!("{name}, turned by {turn}: error {error:.5} on {lit} pixels");
            assert!(error <= TOLERANCE && lit > 700, "{name}: {error} on {lit} pixels");
            // The judge can fail: another turn is another picture.
            let (wrong, _) = largest_error(&scene, &plain, &scaled, |point| factor(point, turn + 0.3));
            assert!(wrong > 0.1, "{name}: {wrong}");
        }
    }
}

#[test]
fn a_cube_does_not_fit_parallel_light_and_changes_places_with_flat_pictures() {
    let image = load_cross();
    let mut scene = Scene::new(LightKind::Directional);
    let plain = scene.radiance();
    scene
        .stage
        .world
        .entity_mut(scene.light)
        .insert(Cookie::new(image.clone()));
    assert_eq!(scene.radiance(), plain);
    let reports = scene.stage.world.resource::<antumbra::reports::Reports>();
    let said: Vec<_> = reports
        .of_entity(scene.light)
        .map(|report| &report.message)
        .collect();
    assert!(said.len() == 1 && said[0].contains("cube"), "{said:?}");

    let mut scene = Scene::new(LightKind::Point);
    let red = CookieImage::from_linear("red", 1, 1, vec![Vec3::X]).expect("a picture");
    let cube = scene.radiance_with(Cookie::new(image.clone()));
    let flat = scene.radiance_with(Cookie::new(red));
    assert!(flat.iter().all(|pixel| pixel.y == 0.0) && cube.iter().any(|pixel| pixel.y > 0.01));
    assert_eq!(scene.radiance_with(Cookie::new(image)), cube);
}
