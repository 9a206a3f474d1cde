//! Lights whose numbers cannot shine, and lights in awkward places.

use antumbra::reports::Reports;
use antumbra::scene::LightError;
use antumbra::sets::SkippedLight;

use super::*;

type Spoil = fn(&mut Light, &mut Transform);
type Expected = fn(&LightError) -> bool;

/// What is spoilt, and the reason that must be given.
const SPOILT: [(&str, Spoil, Expected); 15] = [
    (
        "NaN range",
        |l, _| l.range = f32::NAN,
        |e| matches!(e, LightError::Range(_)),
    ),
    (
        "negative range",
        |l, _| l.range = -1.0,
        |e| matches!(e, LightError::Range(_)),
    ),
    (
        "range 0",
        |l, _| l.range = 0.0,
        |e| matches!(e, LightError::Range(_)),
    ),
    (
        "NaN intensity",
        |l, _| l.intensity = f32::NAN,
        |e| matches!(e, LightError::Intensity(_)),
    ),
    (
        "negative intensity",
        |l, _| l.intensity = -2.0,
        |e| matches!(e, LightError::Intensity(_)),
    ),
    (
        "infinite intensity",
        |l, _| l.intensity = f32::INFINITY,
        |e| matches!(e, LightError::Intensity(_)),
    ),
    (
        "NaN colour",
        |l, _| l.color.y = f32::NAN,
        |e| matches!(e, LightError::Color(_)),
    ),
    (
        "negative colour",
        |l, _| l.color.z = -0.1,
        |e| matches!(e, LightError::Color(_)),
    ),
    (
        "crossed cones",
        |l, _| {
            l.kind = LightKind::Spot {
                inner_angle: 0.5,
                outer_angle: 0.2,
            }
        },
        |e| matches!(e, LightError::Angles { .. }),
    ),
    (
        "NaN cone",
        |l, _| {
            l.kind = LightKind::Spot {
                inner_angle: 0.1,
                outer_angle: f32::NAN,
            }
        },
        |e| matches!(e, LightError::Angles { .. }),
    ),
    (
        "negative width",
        |l, _| {
            l.kind = LightKind::Rect {
                width: -1.0,
                height: 1.0,
            }
        },
        |e| matches!(e, LightError::Size(_)),
    ),
    (
        "NaN radius",
        |l, _| l.kind = LightKind::Sphere { radius: f32::NAN },
        |e| matches!(e, LightError::Size(_)),
    ),
    (
        "NaN place",
        |_, t| t.translation.x = f32::NAN,
        |e| matches!(e, LightError::Transform),
    ),
    (
        "flattened directional light",
        |l, t| {
            l.kind = LightKind::Directional;
            t.scale = Vec3::X;
        },
        |e| matches!(e, LightError::Transform),
    ),
    (
        "flattened rectangle",
        |l, t| {
            l.kind = LightKind::Rect {
                width: 1.0,
                height: 1.0,
            };
            t.scale = Vec3::ZERO;
        },
        |e| matches!(e, LightError::Transform),
    ),
];

fn skipped(stage: &Stage) -> Vec<SkippedLight> {
    stage.world.resource::<FrameLights>().skipped.clone()
}

#[test]
fn lights_that_cannot_shine_are_skipped_with_a_reason() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let without = render(&mut stage);
    assert!(skipped(&stage).is_empty());
    for (what, spoil, expected) in SPOILT {
        let (mut bad, mut at) = light();
        at.translation.x = -3.0;
        let good = (bad.clone(), at);
        spoil(&mut bad, &mut at);
        let entity = stage.spawn_light(bad, at, Some(StencilVolume::default()));
        assert!(same(&without, &render(&mut stage)), "{what} changes the picture");
        let [one] = skipped(&stage)[..] else {
            panic!("{what}: skipped are {:?}", skipped(&stage));
        };
        assert_eq!(one.entity, entity);
        assert!(expected(&one.error), "{what} gives {:?}", one.error);
        let newly = |stage: &mut Stage| stage.world.resource_mut::<Reports>().drain_new().count();
        assert_eq!(newly(&mut stage), 1, "{what} is reported");
        render(&mut stage);
        assert_eq!(newly(&mut stage), 0, "{what} is reported once");
        stage.world.entity_mut(entity).insert(good);
        assert!(!same(&without, &render(&mut stage)), "{what}, repaired, shines");
        assert!(skipped(&stage).is_empty());
        stage.world.despawn(entity);
        stage.lights.pop();
    }
}

#[test]
fn without_lights_there_is_ambient_light_only() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let lit = render(&mut stage);
    let light = stage.lights.remove(0);
    stage.world.despawn(light);
    let dark = render(&mut stage);
    assert!(dark.visibility.is_empty());
    let brightest = dark.radiance.chunks(4).map(|texel| texel[0]).fold(0.0, f32::max);
    assert!(
        (0.01..0.02).contains(&brightest),
        "{brightest} is the ambient radiance of matte 0.8"
    );
    assert!(dark.radiance != lit.radiance);
}

/// Moves light and camera of the usual scene, judges, and gives the number of judged and of dark pixels.
#[track_caller]
fn judge_at(context: &RenderContext, light_at: Vec3, eye: Vec3, range: f32) -> (usize, usize) {
    let mut stage = box_on_plane(context);
    let light = stage.lights[0];
    stage.world.get_mut::<Light>(light).expect("it is a light").range = range;
    stage
        .world
        .entity_mut(light)
        .insert(Transform::from_translation(light_at));
    let target = Vec3::new(0.2, 0.4, 0.1);
    stage.world.entity_mut(stage.camera).insert((
        Camera {
            near: 0.01,
            ..camera()
        },
        Transform::from_translation(eye).looking_at(target, Vec3::Y),
    ));
    let rendered = render(&mut stage);
    let error = assert_true(&mut stage, &rendered);
    let dark = rendered.visibility[0]
        .iter()
        .filter(|value| **value == 0.0)
        .count();
    (error.inner, dark)
}

const OUTSIDE: Vec3 = Vec3::new(3.0, 4.0, 8.0);
const ABOVE: Vec3 = Vec3::new(2.0, 5.0, 1.5);
const INSIDE_BOX: Vec3 = Vec3::new(0.1, 0.8, -0.1);

#[test]
fn a_light_inside_a_caster_lights_nothing_outside() {
    let context = strict_context();
    let (judged, dark) = judge_at(&context, INSIDE_BOX, OUTSIDE, 30.0);
    assert!(judged > 1000 && dark > 1000, "{judged} judged, {dark} dark");
}

#[test]
fn a_camera_inside_a_caster_sees_its_dark_inside() {
    let context = strict_context();
    let (_, dark) = judge_at(&context, ABOVE, INSIDE_BOX, 30.0);
    assert_eq!(dark, SIZE.element_product() as usize);
}

#[test]
fn light_and_camera_inside_the_same_caster_see_each_other() {
    let context = strict_context();
    let (_, dark) = judge_at(&context, Vec3::new(-0.2, 1.0, 0.2), INSIDE_BOX, 30.0);
    assert_eq!(dark, 0);
}

#[test]
fn a_light_in_the_plane_of_a_caster_face_casts() {
    let context = strict_context();
    // The planes of the box's top, of a side, and of both.
    for light_at in [
        Vec3::new(3.0, 1.25, 0.3),
        Vec3::new(0.5, 4.0, 0.2),
        Vec3::new(0.5, 1.25, 3.0),
    ] {
        let (judged, dark) = judge_at(&context, light_at, OUTSIDE, 30.0);
        assert!(
            judged > 1000 && dark > 20,
            "{light_at}: {judged} judged, {dark} dark"
        );
    }
}

#[test]
fn a_light_at_the_eye_shows_no_shadow() {
    let context = strict_context();
    // What the eye sees, the light reaches.
    let (judged, dark) = judge_at(&context, OUTSIDE, OUTSIDE, 30.0);
    assert!(judged > 1000, "{judged} judged");
    assert_eq!(dark, 0);
}

#[test]
fn ranges_from_a_micrometre_to_a_million_kilometres_work() {
    let context = strict_context();
    for range in [1e-6, 1e-3, 1e3, 1e9, 1e30, f32::MAX, f32::INFINITY] {
        judge_at_range(&context, range);
    }
}

/// As [`judge_at`]; beyond the range no shadow is drawn, so that only what the light reaches is compared.
fn judge_at_range(context: &RenderContext, range: f32) {
    let mut stage = box_on_plane(context);
    let usual = render(&mut stage);
    assert!(usual.visibility[0].contains(&0.0), "there is a shadow");
    // Brighter than by ambient light alone.
    let lit = |rendered: &Rendered| -> Vec<bool> {
        let texels = rendered.radiance.chunks(4);
        texels.map(|texel| texel[0] > 0.017).collect()
    };
    let light = stage.lights[0];
    stage.world.get_mut::<Light>(light).expect("it is a light").range = range;
    let rendered = render(&mut stage);
    if range < 1.0 {
        stage.world.despawn(light);
        stage.lights.clear();
        let none = render(&mut stage);
        assert!(
            rendered.radiance == none.radiance,
            "range {range} reaches nothing"
        );
    } else {
        assert!(
            rendered.visibility == usual.visibility,
            "range {range} changes the shadow"
        );
        assert!(lit(&usual).contains(&true));
        assert!(lit(&rendered) == lit(&usual), "range {range} changes what is lit");
    }
}

#[test]
fn thousands_of_lights_render() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let without = render(&mut stage);
    for index in 0..2000 {
        let angle = index as f32 * 2.399_963_2;
        let radius = 0.11 * (index as f32).sqrt();
        let at = Transform::from_xyz(radius * angle.cos(), 0.1, radius * angle.sin());
        let light = Light::point(Vec3::new(1.0, 0.2, 0.1), 0.1, 0.3);
        stage.world.spawn((light, StencilVolume::default(), at));
    }
    stage.schedule.run(&mut stage.world);
    assert_eq!(stage.world.resource::<FrameLights>().lights.len(), 2001);
    let shining = stage.world.resource::<Renderer>().frame().lights.len();
    assert!(shining > 1000, "{shining} lights shine");
    // Without a picture of each light's visibility: one pass for all.
    let mut renderer = stage.world.resource_mut::<Renderer>();
    assert!(renderer.take_failure().is_none());
    let mut encoder = context.device.create_command_encoder(&Default::default());
    renderer.record(&mut encoder, &Default::default());
    context.queue.submit([encoder.finish()]);
    let radiance = renderer.radiance().expect("there is a picture");
    let all = wgpu::TextureAspect::All;
    let rows = antumbra::render::readback::read_texture(&context, &radiance.texture, all, "radiance");
    let radiance: Vec<f32> = rows
        .expect("it is read")
        .bytes
        .chunks_exact(2)
        .map(|bytes| half::f16::from_le_bytes([bytes[0], bytes[1]]).to_f32())
        .collect();
    assert!(radiance.iter().all(|value| value.is_finite()));
    let brighter = radiance
        .iter()
        .zip(&without.radiance)
        .filter(|(a, b)| a > b)
        .count();
    assert!(brighter > 2000, "only {brighter} values are brighter");
}
