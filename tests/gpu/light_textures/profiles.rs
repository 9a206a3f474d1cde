//! Profiles against direct evaluation of their file.

use antumbra::prelude::*;
use antumbra::scene::LightProfile;
use glam::{DVec3, Vec3};

use super::files::{PlaneSymmetry, eulumdat, ies, intensity};
use super::scenes::{Scene, TOLERANCE, kinds, largest_error};

/// Intensity between the measured angles, linear in both, by the knots' formula.
fn between(symmetry: PlaneSymmetry, c_step: f64, g_step: f64, c: f64, g: f64) -> f64 {
    let (c_low, g_low) = ((c / c_step).floor() * c_step, (g / g_step).floor() * g_step);
    let (c_part, g_part) = ((c - c_low) / c_step, (g - g_low) / g_step);
    let knot = |dc: f64, dg: f64| intensity(symmetry, c_low + dc * c_step, (g_low + dg * g_step).min(180.0));
    let low = knot(0.0, 0.0) * (1.0 - g_part) + knot(0.0, 1.0) * g_part;
    let high = knot(1.0, 0.0) * (1.0 - g_part) + knot(1.0, 1.0) * g_part;
    low * (1.0 - c_part) + high * c_part
}

fn angles(point: DVec3) -> [f64; 2] {
    let gamma = (point.z / point.length()).acos().to_degrees();
    [point.y.atan2(point.x).to_degrees().rem_euclid(360.0), gamma]
}

fn check(
    name: &str,
    kind: LightKind,
    profile: &LightProfile,
    symmetry: PlaneSymmetry,
    c_step: f64,
    g_step: f64,
) {
    let mut scene = Scene::new(kind);
    let plain = scene.radiance();
    let scaled = scene.radiance_with(profile.clone());
    let brightest = f64::from(profile.brightest());
    let factor = |point: DVec3| {
        let [c, g] = angles(point);
        Some(Vec3::splat(
            (between(symmetry, c_step, g_step, c, g) / brightest) as f32,
        ))
    };
    let (error, lit) = largest_error(&scene, &plain, &scaled, factor);
    println!("{name} {symmetry:?}: error {error:.5} on {lit} pixels");
    assert!(error <= TOLERANCE, "{name} {symmetry:?}: {error}");
    assert!(lit > 1500, "{name} {symmetry:?}: {lit} pixels are lit");
    let (wrong, _) = largest_error(&scene, &plain, &scaled, |point| {
        factor(DVec3::new(point.x, point.y, 0.7 * point.z))
    });
    assert!(wrong > 0.02, "the judge can fail: {wrong}");
}

#[test]
fn lights_shine_by_direction_as_their_ies_file_says() {
    use PlaneSymmetry::{Axis, C0, C90, Four, None};
    let steps = |symmetry| if symmetry == Axis { 360.0 } else { 22.5 };
    for symmetry in [None, Axis, C0, C90, Four] {
        let profile = LightProfile::from_ies(&ies(symmetry, 22.5, 5.0)).expect("the file is read");
        check(
            "point",
            LightKind::Point,
            &profile,
            symmetry,
            steps(symmetry),
            5.0,
        );
    }
    let profile = LightProfile::from_ies(&ies(None, 30.0, 2.5)).expect("the file is read");
    for (name, kind) in kinds() {
        if kind != LightKind::Directional {
            check(name, kind, &profile, None, 30.0, 2.5);
        }
    }
}

#[test]
fn lights_shine_by_direction_as_their_eulumdat_file_says() {
    use PlaneSymmetry::{Axis, C0, C90, Four, None};
    for symmetry in [None, Axis, C0, C90, Four] {
        let profile = LightProfile::from_eulumdat(&eulumdat(symmetry, 15.0, 7.5)).expect("the file is read");
        let c_step = if symmetry == Axis { 360.0 } else { 15.0 };
        check("point", LightKind::Point, &profile, symmetry, c_step, 7.5);
    }
}

/// A flood light of type B: longitude about the horizontal axis, latitude off it.
#[test]
fn a_flood_light_of_type_b_is_read_about_its_own_axis() {
    let steps: Vec<f64> = (0..=18).map(|step| -90.0 + 10.0 * f64::from(step)).collect();
    let candela = |h: f64, v: f64| 300.0 + h + 0.5 * v + 0.01 * h * v;
    let list = |values: Vec<f64>| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    let mut text = "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 19 19 2 2 0 0 0\n1 1 100\n".to_owned();
    text += &format!("{}\n{}\n", list(steps.clone()), list(steps.clone()));
    for &h in &steps {
        text += &format!("{}\n", list(steps.iter().map(|&v| candela(h, v)).collect()));
    }
    let profile = LightProfile::from_ies(&text).expect("the file is read");
    let mut scene = Scene::new(LightKind::Point);
    let plain = scene.radiance();
    let scaled = scene.radiance_with(profile.clone());
    let brightest = f64::from(profile.brightest());
    let factor = |point: DVec3| {
        let h = (point.x / point.length()).asin().to_degrees();
        let v = point.y.atan2(point.z).to_degrees();
        // The formula is linear in each angle, so between the knots it is itself. Behind it the light is dark.
        let share = if v.abs() < 90.0 {
            candela(h, v) / brightest
        } else {
            0.0
        };
        ((v.abs() - 90.0).abs() > 0.01).then_some(Vec3::splat(share as f32))
    };
    let (error, lit) = largest_error(&scene, &plain, &scaled, factor);
    assert!(error <= TOLERANCE && lit > 1500, "{error} on {lit} pixels");
}

/// A headlamp of type A: longitude about the vertical axis, latitude off it. The file has one side and the upper half, as
/// files of symmetric lamps do, and in another test all of them.
#[test]
fn a_headlamp_of_type_a_is_read_about_its_own_axis() {
    let steps = |from: f64| -> Vec<f64> {
        let count = ((90.0 - from) / 10.0).round() as i32;
        (0..=count).map(|step| from + 10.0 * f64::from(step)).collect()
    };
    let list = |values: Vec<f64>| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ");
    for is_symmetric in [false, true] {
        let candela = |h: f64, v: f64| match is_symmetric {
            false => 300.0 + h + 0.5 * v + 0.01 * h * v,
            true => 300.0 - 2.0 * h.abs() - 1.5 * v.abs() + 0.01 * (h * v).abs(),
        };
        let angles = steps(if is_symmetric { 0.0 } else { -90.0 });
        let count = angles.len();
        let mut text = format!("IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 {count} {count} 3 2 0 0 0\n1 1 100\n");
        text += &format!("{}\n{}\n", list(angles.clone()), list(angles.clone()));
        for &h in &angles {
            text += &format!("{}\n", list(angles.iter().map(|&v| candela(h, v)).collect()));
        }
        let profile = LightProfile::from_ies(&text).expect("the file is read");
        let mut scene = Scene::new(LightKind::Point);
        let plain = scene.radiance();
        let scaled = scene.radiance_with(profile.clone());
        let brightest = f64::from(profile.brightest());
        let factor = |point: DVec3, turned: bool| {
            let point = if turned {
                DVec3::new(point.y, point.x, point.z)
            } else {
                point
            };
            let h = point.x.atan2(point.z).to_degrees();
            let v = (point.y / point.length()).asin().to_degrees();
            // The formula is linear in each angle, so between the knots it is itself. Behind it the light is dark.
            let share = if h.abs() < 90.0 {
                candela(h, v) / brightest
            } else {
                0.0
            };
            ((h.abs() - 90.0).abs() > 0.01).then_some(Vec3::splat(share as f32))
        };
        let (error, lit) = largest_error(&scene, &plain, &scaled, |point| factor(point, false));
        assert!(error <= TOLERANCE && lit > 1500, "{error} on {lit} pixels");
        // The axis of type B would be another profile.
        let (wrong, _) = largest_error(&scene, &plain, &scaled, |point| factor(point, true));
        assert!(wrong > 0.02, "the judge can fail: {wrong}");
    }
}
