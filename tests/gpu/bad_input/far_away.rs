//! Ten thousand kilometres from the origin, where an `f32` counts whole metres.

use super::*;

/// The far origin, metres: `f32` has no fractions there.
const FAR: Vec3 = Vec3::new(1e7, -1e7, 1e7);

/// A scene on whole metres, so that it can stand there as it stands at the origin.
fn stage_at(context: &RenderContext, origin: Vec3) -> Stage {
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
    let (light, _) = light();
    stage.spawn_light(light, at(2.0, 5.0, 1.0), Some(StencilVolume::default()));
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
