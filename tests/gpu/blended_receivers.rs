//! The nearest blended surface of a pixel receives shadows, exactly; farther ones are lit without.

use std::sync::Arc;

use crate::harness::support::frames::Rendered;
use crate::harness::support::given::{GivenPicture, GivenVisibility, opaque_alone};
use crate::harness::support::stage::Stage;
use crate::harness::{judge, strict_context, truth};
use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::techniques::{Settings, Techniques};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3, Vec4};

const SIZE: UVec2 = UVec2::new(160, 90);

/// What the panes take part in.
#[derive(Clone, Copy)]
struct Panes {
    receive: bool,
    cast: bool,
}

const WHOLE: Panes = Panes {
    receive: true,
    cast: true,
};

/// A floor, panes of glass above it one over the other, and a ball over them all, seen from above.
fn stage(pane_heights: &[f32], panes: Panes) -> Stage {
    let view = Transform::from_xyz(2.0, 5.0, 4.0).looking_at(Vec3::ZERO, Vec3::Y);
    let camera = Camera {
        aspect: SIZE.x as f32 / SIZE.y as f32,
        ..Default::default()
    };
    let mut stage = Stage::empty(SIZE, camera, view);
    stage.world.insert_resource(FaceCulling::None);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let matte = Arc::new(Material::matte(Vec3::splat(0.7)));
    let glass = Arc::new(Material {
        base_color: Vec4::new(0.2, 0.9, 0.3, 0.4),
        alpha_mode: AlphaMode::Blend,
        ..Material::matte(Vec3::ONE)
    });
    let mut add = |mesh: MeshData, material: &Arc<Material>, parts: Panes, height: f32| {
        let mut object = stage.world.spawn((
            SceneMesh(Arc::new(mesh)),
            SceneMaterials([material.clone()].into()),
            Transform::from_xyz(0.0, height, 0.0),
        ));
        if parts.receive {
            object.insert(ShadowReceiver);
        }
        if parts.cast {
            object.insert(ShadowCaster);
        }
    };
    add(MeshData::plane(4.0), &matte, WHOLE, 0.0);
    add(MeshData::icosphere(0.4, 3), &matte, WHOLE, 1.9);
    for &height in pane_heights {
        add(MeshData::plane(1.2), &glass, panes, height);
    }
    stage
}

fn light(stage: &mut Stage, place: Vec3, shadow: bool) {
    let light = Light::point(Vec3::ONE, 60.0, 30.0);
    let shadow = shadow.then(StencilVolume::default);
    stage.spawn_light(light, Transform::from_translation(place), shadow);
}

fn render(stage: &mut Stage) -> Rendered {
    stage.render().expect("the frame renders")
}

#[test]
fn shadows_on_glass_are_those_of_the_ray_caster() {
    for heights in [&[1.0][..], &[0.5, 1.2], &[1.2, 0.5]] {
        let mut stage = stage(heights, WHOLE);
        light(&mut stage, Vec3::new(0.3, 4.0, 0.2), true);
        light(&mut stage, Vec3::new(-2.0, 3.0, 1.0), true);
        for frame in 0..2 {
            let rendered = render(&mut stage);
            let scene = RayScene::from_world(&mut stage.world);
            for light in 0..2 {
                let error = judge(&stage, &scene, light, &rendered.visibility[light]);
                assert!(error.inner > 5000, "{error:?}");
                assert_eq!(
                    error.wrong_inner, 0,
                    "{heights:?}, light {light}, frame {frame}: {error:?}"
                );
            }
        }
        // The floor's shadow is no answer for the glass before it.
        let rendered = render(&mut stage);
        let scene = RayScene::from_world(&mut stage.world);
        let error = judge(&stage, &scene, 0, &rendered.visibility[1]);
        assert!(error.wrong_inner > 100, "the judge can fail: {error:?}");
    }
}

/// Techniques with masks look at the depth, and maps at the plane, of the glass.
#[test]
fn every_technique_shadows_glass() {
    let place = Vec3::new(0.3, 4.0, 0.2);
    let shadowed = |light: Light, settings: &Settings| {
        let mut stage = stage(&[0.5, 1.2], WHOLE);
        let place = Transform::from_translation(place).looking_at(Vec3::ZERO, Vec3::Z);
        stage.spawn_shadowed(light, place, Some(settings));
        for _ in 0..3 {
            render(&mut stage); // maps settle what is still
        }
        let rendered = render(&mut stage);
        let scene = RayScene::from_world(&mut stage.world);
        (judge(&stage, &scene, 0, &rendered.visibility[0]), rendered)
    };
    let point = Light::point(Vec3::ONE, 60.0, 30.0);
    let spot = Light {
        kind: LightKind::Spot {
            inner_angle: 0.5,
            outer_angle: 0.8,
        },
        ..point.clone()
    };
    // Nearly a point, for techniques of lights with a size.
    let sphere = Light {
        kind: LightKind::Sphere { radius: 0.01 },
        ..point.clone()
    };
    let mut tried = 0;
    for row in Techniques::default().rows() {
        let settings = row.defaults();
        let mut lights = [&point, &spot, &sphere].into_iter();
        let Some(light) = lights.find(|light| settings.check(light).is_ok()) else {
            continue; // it needs more than its defaults
        };
        tried += 1;
        let (error, rendered) = shadowed(light.clone(), &settings);
        let dark = rendered.visibility[0].iter().filter(|&&v| v < 0.5).count();
        println!("{row:?}: {error:?}, {dark} dark");
        assert!(
            error.inner > 3000 && dark > 300,
            "{row:?}: {error:?}, {dark} dark"
        );
        // Maps, which compare with planes, may be off by a texel; other techniques are exact for a light without extent.
        let is_exact = !row.needs().receiver_planes;
        // Slices are not where their casters are.
        let is_sliced = matches!(light.kind, LightKind::Sphere { .. });
        let allowed = match (is_exact, is_sliced) {
            (true, _) => 0,
            (false, false) => error.inner / 200,
            (false, true) => error.inner / 20,
        };
        assert!(error.wrong_inner <= allowed, "{row:?}: {error:?}");
    }
    assert!(tried >= 6, "{tried} techniques");
}

/// Radiance of the picture at pixels where light 0 is seen or not.
fn brightness(rendered: &Rendered, lit: bool, at: impl Fn(usize) -> bool) -> f32 {
    let wanted = f32::from(u8::from(lit));
    let pixels =
        (0..SIZE.element_product() as usize).filter(|&p| at(p) && rendered.visibility[0][p] == wanted);
    let (count, sum) = pixels.fold((0, 0.0), |(count, sum), p| {
        (count + 1, sum + rendered.radiance[4 * p + 1])
    });
    assert!(count > 20, "{count}");
    sum / count as f32
}

#[test]
fn glass_in_shadow_reflects_no_light_and_still_shows_what_is_behind() {
    let place = Vec3::new(0.3, 4.0, 0.2);
    // Panes that cast no shadow on what is seen through them.
    let clear = Panes { cast: false, ..WHOLE };
    let [mut with, mut without, mut bare] = [&[1.0][..], &[1.0], &[]].map(|panes| stage(panes, clear));
    light(&mut with, place, true);
    light(&mut without, place, false);
    light(&mut bare, place, true);
    let (with, without, bare) = (render(&mut with), render(&mut without), render(&mut bare));
    // Pixels that the glass covers: it changes the picture there.
    let glass = |p: usize| (0..3).any(|c| (bare.radiance[4 * p + c] - with.radiance[4 * p + c]).abs() > 1e-3);
    assert!(brightness(&with, true, glass) > 2.0 * brightness(&with, false, glass));
    let changed = |p: usize| with.radiance[4 * p..4 * p + 3] != without.radiance[4 * p..4 * p + 3];
    let lit_changed = (0..SIZE.element_product() as usize)
        .filter(|&p| with.visibility[0][p] == 1.0 && glass(p) && bare.visibility[0][p] == 1.0 && changed(p))
        .count();
    let dark_changed = (0..SIZE.element_product() as usize)
        .filter(|&p| with.visibility[0][p] == 0.0 && glass(p) && changed(p))
        .count();
    assert!(dark_changed > 20, "{dark_changed}");
    // One pixel's rounding order may differ; a whole surface may not.
    assert!(
        lit_changed * 50 < dark_changed + 50,
        "{lit_changed} of lit glass, {dark_changed} of dark"
    );
}

#[test]
fn glass_that_is_no_receiver_stays_lit() {
    let mut stage = stage(
        &[1.0],
        Panes {
            receive: false,
            ..WHOLE
        },
    );
    light(&mut stage, Vec3::new(0.3, 4.0, 0.2), true);
    let rendered = render(&mut stage);
    let scene = RayScene::from_world(&mut stage.world);
    let error = judge(&stage, &scene, 0, &rendered.visibility[0]);
    assert_eq!(error.wrong_inner, 0, "{error:?}");
}

/// Draws the frame of shadow volumes, and the frame with ray-cast visibility. Returns the number of pixels whose green differs
/// clearly. With `one`, surfaces behind glass get the visibility of the glass.
fn differs_from_truth(panes: &[f32], one: bool) -> usize {
    let mut stage = stage(panes, Panes { cast: false, ..WHOLE });
    for place in [Vec3::new(0.3, 4.0, 0.2), Vec3::new(-2.0, 3.0, 1.0)] {
        light(&mut stage, place, true);
    }
    let frame = render(&mut stage);
    let scene = RayScene::from_world(&mut stage.world);
    let opaque = opaque_alone(&stage.world, &scene);
    assert_eq!(opaque.is_some(), !panes.is_empty());
    for (index, light) in stage.lights.clone().into_iter().enumerate() {
        let given = |scene: &RayScene| Some(Arc::new(GivenPicture::of(&truth(&stage, scene, index))));
        let given = GivenVisibility {
            nearest: given(&scene),
            opaque: opaque.as_ref().filter(|_| !one).and_then(given),
        };
        stage.world.entity_mut(light).remove::<StencilVolume>();
        stage.shadow(light, &Settings::of(given));
    }
    let given = render(&mut stage);
    let pixels = frame.radiance.chunks_exact(4).zip(given.radiance.chunks_exact(4));
    pixels
        .filter(|(a, b)| (a[1] - b[1]).abs() > 0.02 * (a[1] + b[1]))
        .count()
}

/// The ray-cast truth as a picture keeps to the rules of the frame: opaque surfaces have their own shadows behind glass, the
/// nearest glass has its own, and glass behind it has none.
#[test]
fn pictures_with_given_visibility_shade_glass_as_shadow_volumes_do() {
    // A pane above the lamps turns its dark side to the view, or hides nothing.
    for panes in [
        &[][..],
        &[1.0],
        &[0.5, 1.2],
        &[0.3, 0.6, 1.2],
        &[4.4],
        &[4.4, 0.5],
    ] {
        let wrong = differs_from_truth(panes, false);
        println!("{panes:?}: {wrong} pixels");
        assert!(wrong < 8, "{panes:?}: {wrong} pixels");
    }
    let wrong = differs_from_truth(&[1.0], true);
    assert!(
        wrong > 100,
        "the floor has the shadows of the glass: {wrong} pixels"
    );
}
