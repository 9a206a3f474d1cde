//! Clearcoats shine as their formula says, and dim all that is below them.
//!
//! Each claim compares two frames of a floor, one with a coat and one without: `coated = base · (1 − share) + share · layer`,
//! with `share` and `layer` from the twin. The base has emission, and ambient light falls on it.

mod twin;

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{RayScene, SurfaceHit, primary_hits};
use antumbra::scene::{LightWeights, Texture, TextureSlot, TextureWrap};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Affine2, DVec3, UVec2, Vec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;
use twin::{Coat, layer, share};

/// Pixels of the pictures.
const SIZE: UVec2 = UVec2::new(48, 27);

const AMBIENT: f64 = 0.2;
const INTENSITY: f64 = 12.0;
const LIGHT_AT: Vec3 = Vec3::new(0.4, 2.0, -1.0);

/// Eyes above the floor, steep and grazing. All look at the light's highlight.
const EYES: [Vec3; 3] = [
    Vec3::new(0.3, 3.0, 0.2),
    Vec3::new(0.0, 1.6, 2.0),
    Vec3::new(-0.5, 0.25, 2.5),
];

/// Share by which a value of half floats may differ from the formula. Two sums are rounded to 11 bits each.
const TOLERANCE: f64 = 0.004;

struct Scene {
    stage: Stage,
    floor: Entity,
}

/// A floor with texture coordinates, under a light with these further components.
fn scene(kind: LightKind, parts: impl Bundle) -> Scene {
    let camera = Camera {
        vertical_fov: 0.9,
        near: 0.05,
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Camera::default()
    };
    let mut stage = Stage::empty(SIZE, camera, Transform::IDENTITY);
    let settings = RenderSettings {
        ambient: Vec3::splat(AMBIENT as f32),
        background: Vec3::ZERO,
        ..RenderSettings::default()
    };
    stage
        .add_renderer(strict_context(), settings)
        .expect("shaders compose");
    let mut mesh = MeshData::plane(4.0);
    mesh.uv0 = mesh.positions.iter().map(|at| Vec2::new(at.x, at.z)).collect();
    let floor = stage
        .world
        .spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([Arc::new(base())].into()),
            (ShadowCaster, ShadowReceiver),
        ))
        .id();
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, INTENSITY as f32, f32::INFINITY)
    };
    stage.spawn_light(light, Transform::from_translation(LIGHT_AT), Some(parts));
    Scene { stage, floor }
}

/// What lies below the coats.
fn base() -> Material {
    Material {
        metallic: 0.3,
        roughness: 0.6,
        emissive: Vec3::new(0.1, 0.05, 0.0),
        ..Material::matte(Vec3::new(0.6, 0.3, 0.1))
    }
}

/// A texture of one colour.
fn texture(rgba: [u8; 4]) -> Option<TextureSlot> {
    Some(TextureSlot {
        texture: Arc::new(Texture {
            name: "plain".to_owned(),
            width: 2,
            height: 2,
            rgba8: rgba.repeat(4),
            wrap: [TextureWrap::Repeat; 2],
            linear_magnify: true,
            linear_minify: true,
        }),
        uv_set: 0,
        uv_transform: Affine2::IDENTITY,
    })
}

impl Scene {
    fn look_from(&mut self, eye: Vec3) {
        let camera = self.stage.camera;
        // The mirrored light, seen from the eye through the floor.
        let mirrored = LIGHT_AT * Vec3::new(1.0, -1.0, 1.0);
        let target = eye + (mirrored - eye) * (eye.y / (eye.y - mirrored.y));
        let view = Transform::from_translation(eye).looking_at(target, Vec3::Y);
        self.stage.world.entity_mut(camera).insert(view);
    }

    /// The radiance of the floor with this material.
    fn render(&mut self, material: Material) -> Vec<f32> {
        let materials = SceneMaterials([Arc::new(material)].into());
        self.stage.world.entity_mut(self.floor).insert(materials);
        self.stage.render().expect("the frame renders").radiance
    }

    fn hits(&mut self) -> Vec<Option<SurfaceHit>> {
        let scene = RayScene::from_world(&mut self.stage.world);
        let world = &self.stage.world;
        let camera = world.get::<Camera>(self.stage.camera).expect("there is a camera");
        let place = world
            .get::<GlobalTransform>(self.stage.camera)
            .expect("it is somewhere");
        primary_hits(&scene, camera, place, SIZE)
            .expect("the camera is usable")
            .hits
    }
}

/// How the pixels of two frames agree with the formula.
#[derive(Clone, Copy, Debug, Default)]
struct Agreement {
    judged: usize,
    /// Pixels that do not agree with the formula.
    wrong: usize,
    /// Pixels that the coat changes by a fifth at least.
    changed: usize,
}

impl std::ops::AddAssign for Agreement {
    fn add_assign(&mut self, other: Self) {
        self.judged += other.judged;
        self.wrong += other.wrong;
        self.changed += other.changed;
    }
}

/// Renders `below` without a coat, and `above`, the same with one, and compares them with the twin's `coat`.
fn compare(scene: &mut Scene, below: &Material, above: &Material, coat: &Coat, radius: f64) -> Agreement {
    let mut found = Agreement::default();
    for eye in EYES {
        scene.look_from(eye);
        let before = scene.render(below.clone());
        let after = scene.render(above.clone());
        let alpha = match below.alpha_mode {
            AlphaMode::Blend => f64::from(below.base_color.w),
            _ => 1.0,
        };
        for (pixel, hit) in scene.hits().iter().enumerate() {
            let Some(hit) = hit else { continue };
            let to_eye = (eye.as_dvec3() - hit.position).normalize();
            let share = share(coat, to_eye);
            let shine = INTENSITY * layer(coat, to_eye, LIGHT_AT.as_dvec3() - hit.position, radius);
            let of = |radiance: &[f32], channel: usize| f64::from(radiance[4 * pixel + channel]);
            let is_wrong = |channel: usize| {
                let expected = of(&before, channel) * (1.0 - share) + alpha * share * (shine + AMBIENT);
                (of(&after, channel) - expected).abs() > TOLERANCE * expected
            };
            found.judged += 1;
            found.wrong += usize::from((0..3).any(is_wrong));
            found.changed += usize::from((of(&after, 0) / of(&before, 0) - 1.0).abs() > 0.2);
        }
    }
    found
}

fn coat_of(clearcoat: f32, roughness: f32) -> Coat {
    Coat {
        clearcoat: f64::from(clearcoat),
        roughness: f64::from(roughness),
        normal: DVec3::Y,
    }
}

fn coated(below: &Material, clearcoat: f32, roughness: f32) -> Material {
    Material {
        clearcoat,
        clearcoat_roughness: roughness,
        ..below.clone()
    }
}

/// Compares all coats of this list on the usual base.
fn check(what: &str, kind: LightKind, parts: impl Bundle, radius: f64, coats: &[(f32, f32)]) {
    let mut scene = scene(kind, parts);
    let mut sum = Agreement::default();
    for &(clearcoat, roughness) in coats {
        let above = coated(&base(), clearcoat, roughness);
        let found = compare(
            &mut scene,
            &base(),
            &above,
            &coat_of(clearcoat, roughness),
            radius,
        );
        assert_eq!(found.wrong, 0, "{what} {clearcoat} {roughness}: {found:?}");
        sum += found;
    }
    println!("{what}: {sum:?}");
    assert!(
        sum.judged > 500 * coats.len() && sum.changed > 100,
        "{what}: {sum:?}"
    );
    // The comparison finds a coat that is a little rougher, and one that is not there.
    let (clearcoat, roughness) = coats[0];
    let above = coated(&base(), clearcoat, roughness);
    for other in [coat_of(clearcoat, 1.1 * roughness), coat_of(0.0, roughness)] {
        let found = compare(&mut scene, &base(), &above, &other, radius);
        assert!(
            found.wrong > found.judged / 10,
            "{what}: another coat is {found:?}"
        );
    }
}

#[test]
fn a_coat_shines_as_its_twin_under_a_point() {
    check(
        "point",
        LightKind::Point,
        (),
        0.0,
        &[(1.0, 0.25), (1.0, 0.5), (0.4, 0.5), (0.7, 1.0)],
    );
}

#[test]
fn a_coat_shines_as_its_twin_under_a_sphere() {
    let sphere = LightKind::Sphere { radius: 0.3 };
    check(
        "sphere",
        sphere,
        (),
        f64::from(0.3f32),
        &[(1.0, 0.25), (0.5, 0.6)],
    );
}

#[test]
fn a_coat_shines_in_every_pass_that_adds_light() {
    let coats = [(1.0, 0.3)];
    check("masked", LightKind::Point, OmniMap::default(), 0.0, &coats);
    check("stencil", LightKind::Point, StencilVolume::default(), 0.0, &coats);
    let weights = LightWeights {
        ambient: 0.5,
        ..LightWeights::default()
    };
    check("weighted", LightKind::Point, weights, 0.0, &coats);
}

#[test]
fn a_coat_of_a_blended_surface_is_scaled_by_its_alpha() {
    let mut scene = scene(LightKind::Point, ());
    let below = Material {
        alpha_mode: AlphaMode::Blend,
        base_color: base().base_color.truncate().extend(0.5),
        ..base()
    };
    let found = compare(
        &mut scene,
        &below,
        &coated(&below, 1.0, 0.4),
        &coat_of(1.0, 0.4),
        0.0,
    );
    assert!(found.wrong == 0 && found.changed > 100, "{found:?}");
}

#[test]
fn textures_scale_the_coat_and_its_roughness() {
    let mut scene = scene(LightKind::Point, ());
    let mut above = coated(&base(), 0.8, 0.9);
    above.clearcoat_texture = texture([204, 0, 0, 0]);
    above.clearcoat_roughness_texture = texture([0, 102, 0, 0]);
    let coat = coat_of(0.8 * 0.8, 0.9 * 0.4);
    let found = compare(&mut scene, &base(), &above, &coat, 0.0);
    assert!(found.wrong == 0 && found.changed > 100, "{found:?}");
    // The other way round it is another coat.
    std::mem::swap(
        &mut above.clearcoat_texture,
        &mut above.clearcoat_roughness_texture,
    );
    let found = compare(&mut scene, &base(), &above, &coat, 0.0);
    assert!(found.wrong > found.judged / 2, "{found:?}");
}

#[test]
fn a_normal_texture_bends_the_base_and_not_the_coat() {
    let mut scene = scene(LightKind::Point, ());
    let bumpy = Material {
        normal_texture: texture([190, 100, 225, 255]),
        ..base()
    };
    let found = compare(
        &mut scene,
        &bumpy,
        &coated(&bumpy, 1.0, 0.3),
        &coat_of(1.0, 0.3),
        0.0,
    );
    assert!(found.wrong == 0 && found.changed > 100, "{found:?}");
    // The base is bent indeed: below a coat it is not the smooth one.
    let found = compare(
        &mut scene,
        &base(),
        &coated(&bumpy, 1.0, 0.3),
        &coat_of(1.0, 0.3),
        0.0,
    );
    assert!(found.wrong > found.judged / 2, "{found:?}");
}

#[test]
fn without_a_coat_or_light_every_bit_stays() {
    let mut scene = scene(LightKind::Point, ());
    scene.look_from(EYES[1]);
    let plain = scene.render(base());
    let mut none = coated(&base(), 0.0, 0.7);
    none.clearcoat_texture = texture([9; 4]);
    none.clearcoat_roughness_texture = texture([99; 4]);
    assert_eq!(plain, scene.render(none.clone()));
    none.clearcoat = 0.1;
    assert_ne!(plain, scene.render(none.clone()));
    // A surface that takes no light has no coat.
    none.unlit = true;
    let unlit = scene.render(none.clone());
    none.clearcoat = 0.0;
    assert_eq!(unlit, scene.render(none));
    // A share so small that it changes nothing in half floats goes through the coat's pipelines.
    let tiny = scene.render(coated(&base(), 1e-9, 0.5));
    let worst = plain
        .iter()
        .zip(&tiny)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f32::max);
    assert!(worst < 1e-3, "{worst}");
}
