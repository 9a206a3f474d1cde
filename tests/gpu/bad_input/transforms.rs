//! Objects whose transform cannot be drawn with.

use antumbra::sets::Objects;
use glam::Quat;

use super::*;

/// Transforms that are not finite or leave no area.
fn bad_transforms() -> Vec<(&'static str, Transform)> {
    let at = Transform::from_xyz(-1.5, 1.0, 0.5);
    let nan = f32::NAN;
    vec![
        ("NaN place", at.with_translation(Vec3::new(nan, 0.0, 0.0))),
        (
            "infinite place",
            at.with_translation(Vec3::new(0.0, f32::INFINITY, 0.0)),
        ),
        ("NaN turn", at.with_rotation(Quat::from_xyzw(nan, 0.0, 0.0, 1.0))),
        ("NaN scale", at.with_scale(Vec3::new(1.0, nan, 1.0))),
        ("scale zero", at.with_scale(Vec3::ZERO)),
        ("a line", at.with_scale(Vec3::new(1.0, 0.0, 0.0))),
        ("scale beyond f32", at.with_scale(Vec3::splat(1e30))),
        ("scale below f32", at.with_scale(Vec3::splat(1e-30))),
    ]
}

fn left_out(stage: &Stage) -> usize {
    stage.world.resource::<Objects>().left_out
}

#[test]
fn unusable_transforms_are_left_out_and_counted() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let without = render(&mut stage);
    assert_eq!(left_out(&stage), 0);
    let good = Transform::from_xyz(-1.5, 1.0, 0.5);
    for (what, bad) in bad_transforms() {
        let extra = stage
            .world
            .spawn(object(MeshData::cuboid(Vec3::splat(0.4)), bad))
            .id();
        assert!(same(&without, &render(&mut stage)), "{what} changes the picture");
        assert_eq!(left_out(&stage), 1, "{what} is counted");
        // It comes back when its transform does, and goes again.
        stage.world.entity_mut(extra).insert(good);
        assert!(!same(&without, &render(&mut stage)), "{what}, repaired, is seen");
        assert_eq!(left_out(&stage), 0);
        stage.world.entity_mut(extra).insert(bad);
        assert!(
            same(&without, &render(&mut stage)),
            "{what}, broken again, is not"
        );
        stage.world.despawn(extra);
    }
}

#[test]
fn children_of_an_unusable_parent_are_left_out() {
    let context = strict_context();
    let mut stage = box_on_plane(&context);
    let without = render(&mut stage);
    let parent = stage.world.spawn(Transform::from_scale(Vec3::ZERO)).id();
    let child = object(
        MeshData::cuboid(Vec3::splat(0.4)),
        Transform::from_xyz(-1.5, 1.0, 0.5),
    );
    stage.world.spawn((child, ChildOf(parent)));
    assert!(same(&without, &render(&mut stage)));
    assert_eq!(left_out(&stage), 1);
}

#[test]
fn tiny_and_huge_objects_are_drawn_and_cast() {
    let context = strict_context();
    for exponent in [-6, 6] {
        let unit = 10f32.powi(exponent);
        let mut stage = empty_stage(&context);
        stage
            .world
            .spawn(object(MeshData::plane(6.0), Transform::IDENTITY));
        stage.world.spawn(object(
            MeshData::cuboid(Vec3::splat(0.5 * unit)),
            Transform::from_xyz(0.0, 0.75, 0.0).with_scale(Vec3::splat(1.0 / unit)),
        ));
        let (light, at) = light();
        stage.spawn_light(light, at, Some(StencilVolume::default()));
        let rendered = render(&mut stage);
        assert!(assert_true(&mut stage, &rendered).inner > 1000);
        assert!(rendered.visibility[0].contains(&0.0), "there is a shadow");
        // The box itself is lit: its normals survive the scale.
        let mut usual = box_on_plane(&context);
        let usual = render(&mut usual);
        let difference = rendered
            .radiance
            .iter()
            .zip(&usual.radiance)
            .filter(|(a, b)| (*a - *b).abs() > 0.01 * b.abs().max(0.01))
            .count();
        assert!(
            difference < 40,
            "10^{exponent}: {difference} values differ from the box of scale 1"
        );
    }
}
