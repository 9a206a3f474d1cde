//! Far from the origin, where an `f32` counts sixteenths of a metre or whole metres.

use antumbra::techniques::maps::MapResolution;
use antumbra::techniques::{Settings, SmoothieWidth};
use glam::Quat;

use super::*;
use crate::harness::maps::Judge;

/// The far origin, metres: `f32` has no fractions there.
const FAR: Vec3 = Vec3::new(1e7, -1e7, 1e7);

/// A scene on whole metres, so that it can stand there as it stands at the origin. It has no light.
fn unlit_stage_at(context: &RenderContext, origin: Vec3) -> Stage {
    let mut stage = empty_stage(context);
    let at = |x: f32, y: f32, z: f32| Transform::from_translation(origin + Vec3::new(x, y, z));
    stage.world.spawn(object(MeshData::plane(6.0), at(0.0, 0.0, 0.0)));
    stage.world.spawn(object(
        MeshData::cuboid(Vec3::new(0.6, 0.5, 0.7)),
        at(0.0, 1.0, 0.0),
    ));
    let rotation = view().rotation;
    let camera = stage.camera;
    stage
        .world
        .entity_mut(camera)
        .insert(at(3.0, 4.0, 8.0).with_rotation(rotation));
    stage
}

/// The scene at an origin, with a light that casts volumes.
fn stage_at(context: &RenderContext, origin: Vec3) -> Stage {
    let mut stage = unlit_stage_at(context, origin);
    let (light, _) = light();
    let place = Transform::from_translation(origin + Vec3::new(2.0, 5.0, 1.0));
    stage.spawn_light(light, place, Some(StencilVolume::default()));
    stage
}

/// Texels whose radiance differs by more than 1 % of the brightest.
fn differing(a: &Rendered, b: &Rendered) -> usize {
    let brightest = a.radiance.iter().copied().fold(0.0, f32::max);
    a.radiance
        .chunks(4)
        .zip(b.radiance.chunks(4))
        .filter(|(a, b)| (0..3).any(|channel| (a[channel] - b[channel]).abs() > 0.01 * brightest))
        .count()
}

#[test]
fn a_scene_far_from_the_origin_is_that_at_the_origin() {
    let context = strict_context();
    let mut near = stage_at(&context, Vec3::ZERO);
    let mut far = stage_at(&context, FAR);
    let (at_origin, far_away) = (render(&mut near), render(&mut far));
    assert!(assert_true(&mut near, &at_origin).inner > 1000);
    assert!(assert_true(&mut far, &far_away).inner > 1000);
    assert!(far_away.visibility[0].contains(&0.0), "there is a shadow");
    // Matrices are made in f64, whose rounding at 1e7 m is 2e-9 m: only pixels whose edge passes within that of the
    // centre may change sides.
    let count = differing(&at_origin, &far_away);
    assert!(count <= 2, "{count} texels differ");
    assert_eq!(differing(&at_origin, &at_origin), 0);
    let mut moved = stage_at(&context, Vec3::ZERO);
    let light = moved.lights[0];
    moved
        .world
        .entity_mut(light)
        .insert(Transform::from_xyz(2.2, 5.0, 1.0));
    assert!(
        differing(&at_origin, &render(&mut moved)) > 2,
        "the comparison finds a light moved by 0.2 m"
    );
}

/// Visibility of the scene under one light, and how many pixels are wrong off a band of a texel and how many are dark.
fn lit_at(origin: Vec3, kind: LightKind, technique: &Settings) -> (Vec<f32>, usize, usize) {
    let mut stage = unlit_stage_at(&strict_context(), origin);
    let light = Light { kind, ..light().0 };
    let turn = Quat::from_rotation_arc(Vec3::NEG_Z, Vec3::new(-0.4, -1.0, -0.2).normalize());
    let place = Transform::from_translation(origin + Vec3::new(2.0, 5.0, 1.0)).with_rotation(turn);
    stage.spawn_shadowed(light, place, Some(technique));
    let visibility = render(&mut stage).visibility.remove(0);
    let rays = RayScene::from_world(&mut stage.world);
    let judge = Judge::new(&stage, &rays, 0).expect("something casts");
    let error = judge.compare(&visibility);
    (visibility, error.wrong, error.dark)
}

const KINDS: [LightKind; 3] = [
    LightKind::Spot {
        inner_angle: 0.5,
        outer_angle: 0.9,
    },
    LightKind::Point,
    LightKind::Directional,
];

#[test]
fn perspective_maps_far_from_the_origin_are_exact() {
    let map = Settings::of(PerspectiveMap {
        resolution: MapResolution::Fixed(512),
        ..Default::default()
    });
    for kind in KINDS {
        for far in [0.0, 1e5, 1e6] {
            let (_, wrong, dark) = lit_at(Vec3::new(far, -far, far), kind, &map);
            println!("{kind:?}, {far} m: {wrong} wrong, {dark} dark");
            assert!(
                wrong == 0 && dark > 40,
                "{kind:?}, {far} m: {wrong} wrong, {dark} dark"
            );
        }
    }
}

#[test]
fn smoothies_far_from_the_origin_are_those_at_the_origin() {
    let smoothie = Settings::of(Smoothie {
        width: SmoothieWidth::Metres(1.0),
        spread: 0.5,
        resolution: MapResolution::Fixed(512),
        ..Default::default()
    });
    for kind in KINDS {
        let (at_origin, ..) = lit_at(Vec3::ZERO, kind, &smoothie);
        let soft = at_origin
            .iter()
            .filter(|value| (0.1..0.9).contains(*value))
            .count();
        assert!(soft > 30, "{kind:?}: {soft} soft");
        for far in [1e5, 1e6] {
            let (far_away, ..) = lit_at(Vec3::new(far, -far, far), kind, &smoothie);
            let pairs = at_origin.iter().zip(&far_away);
            let off = pairs.filter(|(a, b)| (*a - *b).abs() > 0.1).count();
            println!("{kind:?}, {far} m: {off} pixels differ, {soft} are soft");
            assert!(off <= 4, "{kind:?}, {far} m: {off} pixels differ");
        }
    }
}
