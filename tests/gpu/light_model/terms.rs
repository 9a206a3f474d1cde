//! Ambient, diffuse and specular light, and the colour of shadows: the terms of listing 10-2.

use antumbra::prelude::*;
use antumbra::scene::{LightWeights, ShadowTint, SurfaceWeights};
use antumbra::techniques::maps::MapFilter;
use bevy_ecs::prelude::*;
use glam::Vec3;

use super::{add_of, hits, inner_pixels, place, relight, render, rgb, stage};
use crate::harness::strict_context;
use crate::harness::support::frames::Rendered;
use crate::harness::support::stage::Stage;

const COLOR: Vec3 = Vec3::new(1.0, 0.5, 0.0);
const INTENSITY: f32 = 40.0;

fn light() -> Light {
    Light::point(COLOR, INTENSITY, f32::INFINITY)
}

/// A glossy floor and ball.
fn scene() -> (Stage, [Entity; 2]) {
    let mut stage = stage(&strict_context());
    let glossy = || Material {
        roughness: 0.4,
        ..Material::matte(Vec3::new(0.7, 0.6, 0.5))
    };
    let floor = add_of(&mut stage, MeshData::plane(12.0), Vec3::ZERO, glossy());
    let ball = add_of(
        &mut stage,
        MeshData::icosphere(0.7, 4),
        Vec3::new(0.0, 1.0, 0.0),
        glossy(),
    );
    (stage, [floor, ball])
}

fn weights(ambient: f32, diffuse: f32, specular: f32) -> LightWeights {
    LightWeights {
        ambient,
        diffuse,
        specular,
    }
}

fn lit_with(stage: &mut Stage, parts: impl Bundle) -> Rendered {
    relight(stage, light(), parts);
    render(stage)
}

/// Half floats, in which sums are rounded, and the mask.
fn near(got: f32, expected: f32, scale: f32) -> bool {
    (got - expected).abs() <= scale / 500.0 + 1e-6
}

#[test]
fn diffuse_and_specular_light_add_up_and_scale() {
    let (mut stage, [floor, _]) = scene();
    let whole = lit_with(&mut stage, StencilVolume::default());
    let diffuse = lit_with(&mut stage, (StencilVolume::default(), weights(0.0, 1.0, 0.0)));
    let specular = lit_with(&mut stage, (StencilVolume::default(), weights(0.0, 0.0, 1.0)));
    let both = lit_with(&mut stage, (StencilVolume::default(), weights(0.0, 0.5, 2.0)));
    stage.world.entity_mut(floor).insert(SurfaceWeights {
        diffuse: 0.25,
        specular: 3.0,
        ..SurfaceWeights::default()
    });
    let floor_weighted = lit_with(&mut stage, StencilVolume::default());
    let (scene, hits) = hits(&mut stage);
    let mut glossy = 0;
    for pixel in inner_pixels(&scene, &hits) {
        let hit = hits.hits[pixel].expect("an inner pixel shows something");
        let on_floor = scene.triangles()[hit.triangle as usize].entity == Some(floor);
        for i in 0..3 {
            let at = |rendered: &Rendered| rgb(rendered, pixel)[i];
            let (w, d, s) = (at(&whole), at(&diffuse), at(&specular));
            assert!(near(d + s, w, w), "{d} + {s} is not {w}");
            assert!(near(at(&both), 0.5 * d + 2.0 * s, w + s));
            let expected = if on_floor { 0.25 * d + 3.0 * s } else { w };
            assert!(near(at(&floor_weighted), expected, w + 3.0 * s), "{on_floor}");
            glossy += usize::from(s > 0.1 * w && w > 0.01);
        }
    }
    assert!(glossy > 50, "{glossy} values are glossy");
}

#[test]
fn ambient_light_has_no_shadow_and_no_sides() {
    let (mut stage, _) = scene();
    let ambient = lit_with(&mut stage, (StencilVolume::default(), weights(0.5, 0.0, 0.0)));
    let (scene, hits) = hits(&mut stage);
    let mut shadowed = 0;
    for pixel in inner_pixels(&scene, &hits) {
        let hit = hits.hits[pixel].expect("an inner pixel shows something");
        let distance_sq = hit.position.as_vec3().distance_squared(place().translation);
        for (i, got) in rgb(&ambient, pixel).into_iter().enumerate() {
            let albedo = [0.7, 0.6, 0.5][i] / std::f32::consts::PI;
            let expected = 0.5 * albedo * COLOR[i] * INTENSITY / distance_sq;
            assert!(
                near(got, expected, expected),
                "{got}, not {expected} at {}",
                hit.position
            );
        }
        shadowed += usize::from(ambient.visibility[0][pixel] == 0.0);
    }
    assert!(shadowed > 100, "{shadowed} pixels are in the shadow");
}

#[test]
fn shadows_have_the_mixed_colour_and_no_highlights() {
    fn check(name: &str, shadow: impl Bundle + Clone, soft: bool) {
        let (mut stage, [floor, _]) = scene();
        let tint = ShadowTint {
            color: Vec3::new(0.1, 0.0, 0.4),
            darkness: 0.8,
        };
        // White light tells what the surface answers to each colour, also to those that the light lacks.
        let white = |stage: &mut Stage, parts: LightWeights| {
            relight(stage, Light::point(Vec3::ONE, INTENSITY, f32::INFINITY), parts);
            render(stage)
        };
        let diffuse = white(&mut stage, weights(0.0, 1.0, 0.0));
        let specular = white(&mut stage, weights(0.0, 0.0, 1.0));
        let tinted = lit_with(&mut stage, (shadow.clone(), tint));
        let (scene, hits) = hits(&mut stage);
        let (mut dark, mut between) = (0, 0);
        for pixel in inner_pixels(&scene, &hits) {
            let seen = tinted.visibility[0][pixel];
            let on_floor = {
                let hit = hits.hits[pixel].expect("an inner pixel shows something");
                scene.triangles()[hit.triangle as usize].entity == Some(floor)
            };
            // On the ball, part of a soft light lies below the horizon, and colours are masked apart from area.
            if soft && !on_floor {
                continue;
            }
            for i in 0..3 {
                let passing = 1.0 - 0.8 * (1.0 - seen);
                let mixed = tint.color[i] + (COLOR[i] - tint.color[i]) * passing;
                let (d, s) = (rgb(&diffuse, pixel)[i], rgb(&specular, pixel)[i]);
                let expected = d * mixed + s * COLOR[i] * seen;
                let got = rgb(&tinted, pixel)[i];
                assert!(
                    near(got, expected, d + s),
                    "{name}: {got}, not {expected}, seen {seen}"
                );
            }
            let bright = rgb(&diffuse, pixel)[0] > 0.01;
            dark += usize::from(bright && seen == 0.0);
            between += usize::from(bright && seen > 0.1 && seen < 0.9);
        }
        assert!(dark > 20, "{name}: {dark} pixels are dark");
        assert!(!soft || between > 20, "{name}: {between} pixels are between");
    }
    check("volume", StencilVolume::default(), false);
    let filter = MapFilter::Soft4 { softness: 0.05 };
    check(
        "map",
        OmniMap {
            filter,
            ..OmniMap::default()
        },
        true,
    );
}

#[test]
fn a_tinted_light_is_shaped_too() {
    let (mut stage, _) = scene();
    let shape = antumbra::scene::LightShape {
        width: 0.3,
        height: 0.3,
        ..Default::default()
    };
    let tint = ShadowTint {
        color: Vec3::splat(0.3),
        darkness: 1.0,
    };
    let whole = lit_with(&mut stage, (StencilVolume::default(), tint));
    let shaped = lit_with(&mut stage, (StencilVolume::default(), tint, shape));
    let (scene, hits) = hits(&mut stage);
    let (mut inside, mut outside) = (0, 0);
    for pixel in inner_pixels(&scene, &hits) {
        let hit = hits.hits[pixel].expect("an inner pixel shows something");
        let local = place().rotation.inverse() * (hit.position.as_vec3() - place().translation);
        let factor = shape.factor(Vec3::new(local.x, local.y, -local.z));
        let (got, whole) = (rgb(&shaped, pixel)[0], rgb(&whole, pixel)[0]);
        assert!(near(got, whole * factor, whole), "{got} of {whole} at {factor}");
        inside += usize::from(factor == 1.0);
        outside += usize::from(factor == 0.0 && whole > 0.0);
    }
    assert!(
        inside > 100 && outside > 100,
        "{inside} inside, {outside} outside"
    );
}
