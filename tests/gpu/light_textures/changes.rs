//! Cookies and profiles change at any frame, and a frame in which nothing changes makes nothing.

use antumbra::prelude::*;
use antumbra::scene::{Cookie, CookieImage, LightProfile, ShadowTint};
use bevy_ecs::prelude::*;
use glam::{Vec2, Vec3};

use super::files::{PlaneSymmetry, ies};
use super::scenes::{Scene, TOLERANCE, kinds, largest_error};

fn plain_color(name: &str, color: Vec3) -> std::sync::Arc<CookieImage> {
    CookieImage::from_linear(name, 1, 1, vec![color]).expect("a picture")
}

#[test]
fn another_picture_shows_in_the_next_frame() {
    let (_, spot) = kinds()[0];
    let mut scene = Scene::new(spot);
    let plain = scene.radiance();
    let images = [
        plain_color("red", Vec3::X),
        plain_color("green", Vec3::new(0.0, 0.5, 0.25)),
    ];
    for frame in 0..5 {
        let image = &images[frame % 2];
        scene
            .stage
            .world
            .entity_mut(scene.light)
            .insert(Cookie::new(image.clone()));
        let scaled = scene.radiance();
        let (error, lit) = largest_error(&scene, &plain, &scaled, |_| Some(image.texels()[0]));
        assert!(
            error < TOLERANCE && lit > 1500,
            "frame {frame}: {error} on {lit} pixels"
        );
    }
    scene.stage.world.entity_mut(scene.light).remove::<Cookie>();
    assert_eq!(scene.radiance(), plain, "and without it everything is as before");
}

#[test]
fn offset_and_turn_move_at_any_frame() {
    let (_, spot) = kinds()[0];
    let mut scene = Scene::new(spot);
    let texels = vec![Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE];
    let image = CookieImage::from_linear("four", 2, 2, texels).expect("a picture");
    scene
        .stage
        .world
        .entity_mut(scene.light)
        .insert(Cookie::new(image));
    let mut last = scene.radiance();
    let changes: [fn(&mut Cookie); 4] = [
        |cookie| cookie.offset = Vec2::new(0.3, 0.0),
        |cookie| cookie.turn = 0.5,
        |cookie| cookie.size = 1.0,
        |cookie| cookie.density = 0.5,
    ];
    for change in changes {
        let mut cookie = scene
            .stage
            .world
            .get_mut::<Cookie>(scene.light)
            .expect("it has one");
        change(&mut cookie);
        let now = scene.radiance();
        assert_ne!(now, last);
        last = now;
    }
    assert_eq!(scene.radiance(), last);
}

#[test]
fn defaults_change_nothing_bit_for_bit() {
    for (name, kind) in kinds() {
        let mut scene = Scene::new(kind);
        let plain = scene.radiance();
        let nothing = Cookie {
            density: 0.0,
            ..Cookie::new(plain_color("black", Vec3::ZERO))
        };
        assert_eq!(scene.radiance_with(nothing), plain, "{name}");
        let frame = scene.stage.world.resource::<Renderer>();
        assert!(!frame.has_light_functions(), "{name}: no pass is added for it");
    }
}

#[test]
fn it_scales_light_under_every_technique_and_keeps_its_shadows() {
    fn check(name: &str, kind: LightKind, shadow: impl Bundle) {
        let mut scene = Scene::shadowed(kind, shadow);
        let plain = scene.radiance();
        let color = Vec3::new(0.25, 0.5, 1.0);
        let profile = LightProfile::from_ies(&ies(PlaneSymmetry::Axis, 1.0, 5.0)).expect("the file is read");
        let table = profile.table().clone();
        let scaled = scene.radiance_with((Cookie::new(plain_color("blue", color)), profile));
        let (error, lit) = largest_error(&scene, &plain, &scaled, |point| {
            Some(color * table.relative(point.as_vec3() * Vec3::new(1.0, 1.0, -1.0)))
        });
        let dark = plain.iter().filter(|plain| **plain == Vec3::ZERO).count();
        assert!(
            error <= TOLERANCE && lit > 1000,
            "{name}: {error} on {lit} pixels"
        );
        assert!(
            name == "none" || dark > 100,
            "{name}: {dark} pixels are in shadow"
        );
    }
    let point = LightKind::Point;
    check("none", point, ());
    check("stencil_volume", point, StencilVolume::default());
    check(
        "penumbra_wedge",
        LightKind::Sphere { radius: 0.1 },
        PenumbraWedge::default(),
    );
    check("omni_map", point, OmniMap::default());
    check("shadow_map", kinds()[0].1, ShadowMap::default());
}

#[test]
fn a_picture_scales_a_tinted_light_in_its_shadow_too() {
    let tint = ShadowTint {
        color: Vec3::new(0.1, 0.2, 0.6),
        darkness: 0.9,
    };
    let color = Vec3::new(0.25, 0.5, 1.0);
    let mut scene = Scene::shadowed(LightKind::Point, StencilVolume::default());
    let hard = scene.radiance();
    scene.stage.world.entity_mut(scene.light).insert(tint);
    let tinted = scene.radiance();
    let scaled = scene.radiance_with(Cookie::new(plain_color("blue", color)));
    let (error, lit) = largest_error(&scene, &tinted, &scaled, |_| Some(color));
    assert!(error <= TOLERANCE && lit > 1500, "{error} on {lit} pixels");
    let in_shadow = hard
        .iter()
        .zip(&scaled)
        .filter(|(hard, scaled)| **hard == Vec3::ZERO && scaled.z > 0.003)
        .count();
    assert!(in_shadow > 100, "{in_shadow} pixels show the shadow's colour");
}

#[test]
fn unusable_numbers_are_reported_and_the_light_shines() {
    let (_, spot) = kinds()[0];
    let mut scene = Scene::new(spot);
    let plain = scene.radiance();
    let cookie = Cookie::new(plain_color("red", Vec3::X));
    let wrong: [fn(&mut Cookie); 8] = [
        |cookie| cookie.density = f32::NAN,
        |cookie| cookie.density = -0.1,
        |cookie| cookie.density = 2.0,
        |cookie| cookie.size = 0.0,
        |cookie| cookie.size = f32::INFINITY,
        |cookie| cookie.size = -3.0,
        |cookie| cookie.offset.y = f32::NAN,
        |cookie| cookie.turn = f32::INFINITY,
    ];
    for (index, make_wrong) in wrong.iter().enumerate() {
        let mut cookie = cookie.clone();
        make_wrong(&mut cookie);
        scene.stage.world.entity_mut(scene.light).insert(cookie);
        assert_eq!(scene.radiance(), plain, "case {index}");
        let reports = scene.stage.world.resource::<antumbra::reports::Reports>();
        let said: Vec<_> = reports
            .of_entity(scene.light)
            .map(|report| &report.message)
            .collect();
        assert!(
            said.len() == 1 && said[0].contains("Cookie"),
            "case {index}: {said:?}"
        );
    }
    let mut scene = Scene::new(LightKind::Directional);
    let plain = scene.radiance();
    let profile = LightProfile::from_ies(&ies(PlaneSymmetry::Axis, 1.0, 5.0)).expect("the file is read");
    scene.stage.world.entity_mut(scene.light).insert(profile);
    assert_eq!(scene.radiance(), plain);
    let reports = scene.stage.world.resource::<antumbra::reports::Reports>();
    let said: Vec<_> = reports
        .of_entity(scene.light)
        .map(|report| &report.message)
        .collect();
    assert!(said.len() == 1 && said[0].contains("LightProfile"), "{said:?}");
}
