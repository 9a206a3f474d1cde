//! Cookies against direct evaluation of their file.

use std::f64::consts::PI;
use std::path::PathBuf;

use antumbra::scene::{Cookie, CookieImage, TextureWrap};
use glam::{DVec2, DVec3, Vec2, Vec3};

use super::scenes::{Scene, TOLERANCE, kinds, largest_error};

/// The pattern of the picture: share of light of a texel, linear.
fn pattern(x: u32, y: u32) -> Vec3 {
    let wave = |at: u32, speed: f32| 0.55 + 0.4 * (at as f32 * speed).sin();
    Vec3::new(
        wave(x + y, 0.9),
        wave(x, 1.3) * wave(y, 0.7),
        wave(2 * y + 5, 0.5),
    )
}

fn srgb_from_linear(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

/// A folder of this test program's own.
pub fn folder() -> PathBuf {
    let folder = std::env::temp_dir().join(format!("antumbra-cookies-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for pictures");
    folder
}

/// Writes the pattern as a picture with 16 bits, and reads it.
fn picture(width: u32, height: u32) -> std::sync::Arc<CookieImage> {
    let path = folder().join(format!("pattern-{width}x{height}.png"));
    let image: image::ImageBuffer<image::Rgb<u16>, Vec<u16>> =
        image::ImageBuffer::from_fn(width, height, |x, y| {
            image::Rgb(
                pattern(x, y)
                    .to_array()
                    .map(|c| (srgb_from_linear(c) * 65535.0).round() as u16),
            )
        });
    image.save(&path).expect("the picture is written");
    CookieImage::load(&path).expect("the picture is read")
}

/// The pattern at texture coordinates that repeat, linear between the centres of texels.
fn at(uv: DVec2, width: u32, height: u32) -> Vec3 {
    let place = uv * DVec2::new(f64::from(width), f64::from(height)) - 0.5;
    let low = place.floor();
    let part = (place - low).as_vec2();
    let texel = |dx: f64, dy: f64| {
        pattern(
            (low.x + dx).rem_euclid(f64::from(width)) as u32,
            (low.y + dy).rem_euclid(f64::from(height)) as u32,
        )
    };
    let upper = texel(0.0, 0.0).lerp(texel(1.0, 0.0), part.x);
    let lower = texel(0.0, 1.0).lerp(texel(1.0, 1.0), part.x);
    upper.lerp(lower, part.y)
}

/// Coordinates on the surface of the picture, seen from the light: to the right, upwards.
fn coordinates(name: &str, point: DVec3) -> DVec2 {
    match name {
        "spot" | "rect" => point.truncate() / point.z,
        "directional" => point.truncate(),
        _ => DVec2::new(
            point.x.atan2(point.z),
            PI / 2.0 - (point.y / point.length()).acos(),
        ),
    }
}

#[test]
fn every_kind_of_light_shines_through_its_picture() {
    for (name, kind) in kinds() {
        let mut scene = Scene::new(kind);
        let plain = scene.radiance();
        // No texel is smaller than a pixel: mip-mapping has a test of its own.
        let scale = if name == "directional" { 8.0 } else { 1.0 };
        for (width, height, size, offset, turn, density) in [
            (8u32, 8u32, 2.0f32, Vec2::ZERO, 0.0f32, 1.0f32),
            (7, 3, 3.1, Vec2::new(0.3, -0.7), 0.7, 0.6),
            (1, 1, 0.5, Vec2::ONE, 3.0, 0.9),
        ] {
            let size = size * scale;
            let cookie = Cookie {
                size,
                offset,
                turn,
                density,
                ..Cookie::new(picture(width, height))
            };
            let scaled = scene.radiance_with(cookie);
            let factor = |point: DVec3| {
                let centred = coordinates(name, point) - offset.as_dvec2();
                let (sin, cos) = f64::from(turn).sin_cos();
                let along = DVec2::new(
                    centred.x * cos + centred.y * sin,
                    centred.y * cos - centred.x * sin,
                );
                let high = f64::from(size) * f64::from(height) / f64::from(width);
                let uv = DVec2::new(0.5 + along.x / f64::from(size), 0.5 - along.y / high);
                Some(Vec3::ONE.lerp(at(uv, width, height), density))
            };
            let (error, lit) = largest_error(&scene, &plain, &scaled, factor);
            println!("{name} {width}x{height}: error {error:.5} on {lit} pixels");
            assert!(error <= TOLERANCE, "{name} {width}x{height}: {error}");
            assert!(lit > 1500, "{name}: {lit} pixels are lit");
            // The judge can fail: another turn is another picture.
            if width > 1 {
                let (wrong, _) = largest_error(&scene, &plain, &scaled, |point| {
                    factor(DVec3::new(-point.y, point.x, point.z))
                });
                assert!(wrong > 0.1, "{name}: {wrong}");
            }
        }
    }
}

#[test]
fn a_small_pattern_turns_grey_and_does_not_flicker() {
    let (_, spot) = kinds()[0];
    let mut scene = Scene::new(spot);
    let plain = scene.radiance();
    let texels = (0..64 * 64).map(|at| {
        if (at % 64 + at / 64) % 2 == 0 {
            Vec3::ONE
        } else {
            Vec3::ZERO
        }
    });
    let image = CookieImage::from_linear("checkers", 64, 64, texels.collect()).expect("a picture");
    for offset in [0.0, 0.013, 0.2] {
        let cookie = Cookie {
            size: 0.05,
            offset: Vec2::splat(offset),
            ..Cookie::new(image.clone())
        };
        let scaled = scene.radiance_with(cookie);
        let (error, lit) = largest_error(&scene, &plain, &scaled, |_| Some(Vec3::splat(0.5)));
        assert!(error < 0.02 && lit > 1500, "{error} on {lit} pixels");
    }
}

#[test]
fn a_picture_that_is_clamped_continues_its_border() {
    let (_, spot) = kinds()[0];
    let mut scene = Scene::new(spot);
    let plain = scene.radiance();
    let image = CookieImage::from_linear("two", 2, 1, vec![Vec3::X, Vec3::Y]).expect("a picture");
    let cookie = Cookie {
        size: 0.4,
        wrap: [TextureWrap::Clamp; 2],
        ..Cookie::new(image)
    };
    let scaled = scene.radiance_with(cookie);
    let (error, lit) = largest_error(&scene, &plain, &scaled, |point| {
        let across = point.x / point.z;
        (across.abs() > 0.12).then_some(if across < 0.0 { Vec3::X } else { Vec3::Y })
    });
    assert!(error < TOLERANCE && lit > 1500, "{error} on {lit} pixels");
}

#[test]
fn tiles_of_a_directional_light_hold_far_from_its_place() {
    let (name, kind) = kinds()[4];
    let mut scene = Scene::new(kind);
    let plain = scene.radiance();
    let cookie = Cookie {
        size: 2.0,
        ..Cookie::new(picture(8, 8))
    };
    let near = scene.radiance_with(cookie.clone());
    // A whole number of tiles away the pattern is the same.
    let light = scene.light;
    let place = super::scenes::light_place();
    let moved = place.translation + place.rotation * Vec3::new(2.0 * 16384.0, 4.0 * 16384.0, 0.0);
    let mut transform = scene
        .stage
        .world
        .get_mut::<bevy_transform::prelude::Transform>(light);
    transform.as_mut().expect("it stands somewhere").translation = moved;
    let far = scene.radiance_with(cookie);
    let mut largest = 0.0f32;
    for ((near, far), plain) in near.iter().zip(&far).zip(&plain) {
        largest = largest.max(((*near - *far).abs() / plain.max(Vec3::splat(1e-4))).max_element());
    }
    // The place itself has steps of 4 mm there.
    assert!(largest < 0.01, "{name}: {largest}");
}
