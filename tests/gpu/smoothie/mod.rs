//! Smoothies: the umbra of the plain map, the least of several penumbrae, and the penumbra of the formula.

mod bad_input;
mod eye;
mod flush_lights;
mod kept;
mod models;
mod parity;
mod scenes;

use antumbra::prelude::*;
use antumbra::techniques::SmoothieWidth;
use antumbra::techniques::maps::{MapResolution, Maps};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use crate::harness::strict_context;
use crate::maps::scenes::all;
use scenes::{FIXED, SPOT, ground, hits, lamp, plain, rendered, smoothie, spawn};

/// On the scenes that show what maps do wrong: with smoothies the same pixels are dark, and no pixel is lighter.
#[test]
fn umbra_is_that_of_the_plain_map() {
    let context = strict_context();
    for kind in [SPOT, LightKind::Directional, LightKind::Point] {
        let (mut dark, mut soft) = (0, 0);
        for scene in all().iter().take(5) {
            let (mut stage, _) = scene.stage(&context);
            let (light, place) = scene.light(kind);
            let entity = stage.spawn_light(light, place, None::<Smoothie>);
            plain(&mut stage.world.entity_mut(entity), kind);
            let hard = rendered(&mut stage);
            stage
                .world
                .entity_mut(entity)
                .remove::<(ShadowMap, OmniMap)>()
                .insert(smoothie(SmoothieWidth::Metres(0.08 * scene.scale)));
            let got = rendered(&mut stage);
            for (index, (&hard, &got)) in hard.iter().zip(&got).enumerate() {
                let name = scene.name;
                // A hundredth of a texel may be rounded away.
                let agrees = (hard == 0.0 && got == 0.0) || (hard > 0.0 && (got > 0.0 || hard < 0.01));
                assert!(agrees, "{name}, {kind:?}, pixel {index}: {hard} {got}");
                assert!(
                    got <= hard + 1e-3,
                    "{name}, {kind:?}, pixel {index}: {hard} {got}"
                );
                dark += usize::from(hard == 0.0);
                soft += usize::from(got < hard - 0.05);
            }
            // Without a width, nothing but the map is left.
            stage
                .world
                .entity_mut(entity)
                .insert(smoothie(SmoothieWidth::Metres(0.0)));
            let none = rendered(&mut stage);
            let differs = hard
                .iter()
                .zip(&none)
                .filter(|(hard, none)| (**none - **hard).abs() > 0.01);
            assert_eq!(differs.count(), 0, "{}, {kind:?}", scene.name);
        }
        println!("{kind:?}: {dark} dark pixels, {soft} softened");
        assert!(dark > 500 && soft > 60, "{kind:?}: {dark} dark, {soft} softened");
    }
}

#[test]
fn overlapping_blockers_leave_the_least_visibility() {
    let context = strict_context();
    for kind in [SPOT, LightKind::Directional, LightKind::Point] {
        // Two plates at different heights, whose penumbrae cross on the ground.
        let parts = [
            (Vec3::new(-0.35, 1.0, 0.1), 0.4),
            (Vec3::new(0.5, 1.9, -0.1), 0.35),
        ];
        let picture = |of: &[usize]| {
            let mut stage = ground(&context, Vec3::new(0.0, 4.0, 3.0), Vec3::ZERO);
            for &index in of {
                let (at, half) = parts[index];
                spawn(
                    &mut stage,
                    MeshData::cuboid(Vec3::new(half, 0.01, half)),
                    Transform::from_translation(at).with_rotation(Quat::from_rotation_y(0.4 + index as f32)),
                );
            }
            let (light, place) = lamp(kind, Vec3::new(0.1, 4.5, 0.2));
            stage.spawn_light(light, place, Some(smoothie(SmoothieWidth::Metres(0.3))));
            let values = rendered(&mut stage);
            (values, hits(&stage))
        };
        let ([a, b, both], hits) = {
            let (a, _) = picture(&[0]);
            let (b, _) = picture(&[1]);
            let (both, hits) = picture(&[0, 1]);
            ([a, b, both], hits)
        };
        let on_ground = |index: usize| {
            hits.hits[index]
                .as_ref()
                .is_some_and(|hit: &antumbra::reference::SurfaceHit| hit.position.y.abs() < 1e-3)
        };
        let (mut overlaps, mut off) = (0, 0.0);
        for index in (0..both.len()).filter(|&index| on_ground(index)) {
            let least = a[index].min(b[index]);
            overlaps += usize::from(a[index] < 0.95 && b[index] < 0.95 && least > 0.05);
            let got = both[index];
            // The mean of four least values may be less than the least of two means, by a texel's share of the ramp.
            assert!(
                got <= least + 0.005 && got >= least - 0.15,
                "{kind:?}, {index}: {got}, not {least}"
            );
            off += f64::from((got - least).abs());
        }
        println!("{kind:?}: {overlaps} pixels in both penumbrae, {off:.3} off in sum");
        assert!(off <= 0.02 * overlaps as f64, "{kind:?}: {off}");
        // Penumbrae of the sun are narrow, and hardly cross.
        let least = if kind == LightKind::Directional { 1 } else { 8 };
        assert!(overlaps > least, "{kind:?}: {overlaps}");
    }
}

/// Widths on the ground under the edge of a plate, at several heights, against w (r − b) / b.
#[test]
fn penumbra_widens_with_the_distance_from_the_caster() {
    let context = strict_context();
    let (height, width) = (6.0f32, 0.25);
    println!(
        "{:<28} {:>7} {:>9} {:>9} {:>7}",
        "light", "r - b", "formula", "measured", "ratio"
    );
    for kind in [SPOT, LightKind::Point, LightKind::Directional] {
        for plate in [1.0f32, 1.5, 2.0, 3.0] {
            let mut stage = ground(&context, Vec3::new(0.0, 0.8, 0.6), Vec3::new(0.0, 0.0, 0.15));
            // The light is straight above the edge, which runs along X.
            spawn(
                &mut stage,
                MeshData::cuboid(Vec3::new(3.0, 0.001, 1.0)),
                Transform::from_xyz(0.0, plate, -1.0).with_rotation(Quat::IDENTITY),
            );
            let (light, place) = lamp(kind, Vec3::new(0.0, height, 0.0));
            let mut settings = smoothie(SmoothieWidth::Metres(width));
            settings.spread = 0.1;
            settings.resolution = MapResolution::Fixed(1024);
            stage.spawn_light(light, place, Some(settings));
            let values = rendered(&mut stage);
            let (b, r) = (height - plate, height);
            let formula = if kind == LightKind::Directional {
                (0.1 * plate).min(width)
            } else {
                width * (r - b) / b
            };
            // The slope of the line through the pixels in between: the umbra may end anywhere in its last texel.
            let mut ramp = Vec::new();
            for (hit, value) in hits(&stage).hits.iter().zip(&values) {
                let Some(hit) = hit.as_ref().filter(|hit| hit.position.y.abs() < 1e-3) else {
                    continue;
                };
                if (0.2..0.8).contains(value) && hit.position.x.abs() < 1.0 && hit.position.z > 0.0 {
                    ramp.push((hit.position.z, f64::from(*value)));
                }
            }
            let count = ramp.len();
            let mean = |of: fn(&(f64, f64)) -> f64| ramp.iter().map(of).sum::<f64>() / count as f64;
            let (z, v) = (mean(|(z, _)| *z), mean(|(_, v)| *v));
            let spread = mean(|(_, v)| v * v) - v * v;
            let measured = (mean(|(z, v)| z * v) - z * v) / spread;
            let ratio = measured / f64::from(formula);
            println!(
                "{:<28} {plate:>7.2} {formula:>9.4} {measured:>9.4} {ratio:>7.3}",
                format!("{kind:?}").chars().take(28).collect::<String>()
            );
            assert!(count > 10, "{kind:?} {plate}: {count} pixels");
            assert!(
                (0.85..1.15).contains(&ratio),
                "{kind:?} {plate}: {measured}, not {formula}"
            );
        }
    }
}

/// A surface that casts nothing gets the penumbra of its own distance, not that of the caster behind it.
#[test]
fn surfaces_that_only_receive_get_their_own_penumbra() {
    let context = strict_context();
    let mut pictures = Vec::new();
    for casts in [true, false] {
        let mut stage = ground(&context, Vec3::new(1.5, 3.0, 3.0), Vec3::new(0.0, 0.5, 0.0));
        let table = spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(1.2, 0.01, 1.2)),
            Transform::from_xyz(0.0, 0.8, 0.0),
        );
        if !casts {
            stage.world.entity_mut(table).remove::<ShadowCaster>();
        }
        let plate = MeshData::cuboid(Vec3::new(0.4, 0.01, 0.4));
        spawn(&mut stage, plate, Transform::from_xyz(0.1, 1.6, 0.0));
        let (light, place) = lamp(SPOT, Vec3::new(0.1, 4.5, 0.2));
        stage.spawn_light(light, place, Some(smoothie(SmoothieWidth::Metres(0.3))));
        let values = rendered(&mut stage);
        let hits = hits(&stage);
        let on_table = |(value, hit): (&f32, &Option<antumbra::reference::SurfaceHit>)| {
            hit.as_ref()
                .filter(|hit| hit.position.y > 0.8 && hit.position.y < 0.9)
                .map(|_| *value)
        };
        pictures.push(
            values
                .iter()
                .zip(&hits.hits)
                .filter_map(on_table)
                .collect::<Vec<f32>>(),
        );
    }
    let soft = pictures[0]
        .iter()
        .filter(|value| (0.1..0.9).contains(*value))
        .count();
    let differs = pictures[0]
        .iter()
        .zip(&pictures[1])
        .filter(|(a, b)| (*a - *b).abs() > 0.03);
    assert_eq!((differs.count(), pictures[0].len()), (0, pictures[1].len()));
    assert!(soft > 50, "{soft} pixels are in the penumbra");
}

/// An edge that runs through several faces of a cube looks as it does inside one face.
#[test]
fn edges_cross_the_faces_of_a_cube_unseen() {
    let context = strict_context();
    let picture = |turn: Quat| {
        // Everything but the faces, which have the axes of the world, turns about the light.
        let about = |at: Vec3| turn * at;
        let view = Transform::from_translation(about(Vec3::new(0.4, 1.4, 1.0)))
            .looking_at(about(Vec3::new(0.0, -2.0, -0.6)), turn * Vec3::Y);
        let mut stage = scenes::empty(&context, view);
        let at = |x, y, z| Transform::from_translation(about(Vec3::new(x, y, z))).with_rotation(turn);
        spawn(&mut stage, MeshData::plane(6.0), at(0.0, -3.0, 0.0));
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(0.5, 0.01, 0.3)),
            at(0.1, -1.5, -0.1),
        );
        let light = Light::point(Vec3::ONE, 10.0, 20.0);
        let mut settings = smoothie(SmoothieWidth::Metres(0.3));
        settings.resolution = FIXED;
        stage.spawn_light(light, Transform::IDENTITY, Some(settings));
        let values = rendered(&mut stage);
        let shadowed = stage.world.resource::<Maps>().lights[0]
            .faces
            .iter()
            .filter(|face| !(face.still.is_clear() && face.moving.is_clear()))
            .count();
        (values, shadowed)
    };
    let (straight, _) = picture(Quat::IDENTITY);
    let soft = straight
        .iter()
        .filter(|value| (0.1..0.9).contains(*value))
        .count();
    assert!(soft > 200, "{soft} pixels are in the penumbra");
    for turn in [
        Quat::from_rotation_x(0.785),
        Quat::from_rotation_x(0.785) * Quat::from_rotation_z(0.61),
    ] {
        let (turned, faces) = picture(turn);
        assert!(faces >= 3, "{faces} faces show casters");
        let off = straight
            .iter()
            .zip(&turned)
            .filter(|(a, b)| (*a - *b).abs() > 0.12)
            .count();
        let sum: f64 = straight
            .iter()
            .zip(&turned)
            .map(|(a, b)| f64::from(a - b).powi(2))
            .sum();
        let rmse = (sum / straight.len() as f64).sqrt();
        println!("turned by {turn:?}: RMSE {rmse:.4}, {off} pixels differ by more than 0.12");
        assert!(
            rmse < 0.02 && off < straight.len() / 100,
            "{turn:?}: {rmse}, {off}"
        );
    }
}

#[test]
fn width_may_follow_the_distance_or_the_light() {
    let context = strict_context();
    let picture = |kind: LightKind, width| {
        let mut stage = ground(&context, Vec3::new(1.5, 3.0, 3.0), Vec3::ZERO);
        let plate = MeshData::cuboid(Vec3::new(0.5, 0.01, 0.5));
        spawn(&mut stage, plate, Transform::from_xyz(0.0, 1.5, 0.0));
        let (light, place) = lamp(kind, Vec3::new(0.0, 4.5, 0.0));
        stage.spawn_light(light, place, Some(smoothie(width)));
        rendered(&mut stage)
    };
    let differ = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 0.06).count();
    let metres = picture(LightKind::Point, SmoothieWidth::Metres(0.3));
    // Edges of the plate are 3 m from the light, its corners 3.08 m.
    let share = picture(LightKind::Point, SmoothieWidth::Share(0.1));
    assert!(differ(&metres, &share) < 20, "{}", differ(&metres, &share));
    // The penumbra of a disc is steeper than a ramp as wide as its radius.
    let radius = 0.3 / 0.855;
    let sphere = picture(LightKind::Sphere { radius }, SmoothieWidth::Light);
    assert_eq!(differ(&metres, &sphere), 0);
    let side = radius * std::f32::consts::PI.sqrt();
    let rect = LightKind::Rect {
        width: side,
        height: side,
    };
    assert_eq!(differ(&metres, &picture(rect, SmoothieWidth::Light)), 0);
    let narrow = picture(LightKind::Sphere { radius: 0.1 }, SmoothieWidth::Light);
    assert!(differ(&metres, &narrow) > 100);
}

/// A skinned caster has the smoothies of its pose: those of a mesh that was made in that pose, also after it moved.
#[test]
fn skinned_casters_have_the_smoothies_of_their_pose() {
    let context = strict_context();
    let pose = [
        Transform::from_xyz(-0.3, 1.2, 0.1).with_rotation(Quat::from_rotation_y(0.4)),
        Transform::from_xyz(0.5, 1.7, -0.2).with_rotation(Quat::from_rotation_z(0.5)),
    ];
    // The left half of the box follows the first joint, the right half the second.
    let plate = MeshData::cuboid(Vec3::new(0.6, 0.03, 0.4));
    let joint_of = |p: &Vec3| usize::from(p.x > 0.0);
    let mut posed = plate.clone();
    for p in &mut posed.positions {
        *p = pose[joint_of(p)].transform_point(*p);
    }
    let mut skinned = plate;
    skinned.joints = skinned
        .positions
        .iter()
        .map(|p| [joint_of(p) as u16; 4])
        .collect();
    skinned.joint_weights = vec![glam::Vec4::X; skinned.positions.len()];
    for kind in [SPOT, LightKind::Point, LightKind::Directional] {
        let mut lit = ground(&context, Vec3::new(1.5, 3.0, 3.0), Vec3::ZERO);
        let mut moved = ground(&context, Vec3::new(1.5, 3.0, 3.0), Vec3::ZERO);
        spawn(&mut lit, posed.clone(), Transform::IDENTITY);
        let caster = spawn(&mut moved, skinned.clone(), Transform::IDENTITY);
        let joints: Vec<_> = (0..2)
            .map(|_| moved.world.spawn(Transform::from_xyz(0.0, 1.0, 0.0)).id())
            .collect();
        moved.world.entity_mut(caster).insert(antumbra::scene::Skin {
            joints: joints.clone(),
            inverse_bind: [glam::Mat4::IDENTITY; 2].into(),
        });
        for stage in [&mut lit, &mut moved] {
            let (light, place) = lamp(kind, Vec3::new(0.1, 4.5, 0.2));
            stage.spawn_light(light, place, Some(smoothie(SmoothieWidth::Metres(0.3))));
        }
        let before = rendered(&mut moved);
        for (joint, place) in joints.iter().zip(pose) {
            moved.world.entity_mut(*joint).insert(place);
        }
        let (expected, got) = (rendered(&mut lit), rendered(&mut moved));
        let differ = |a: &[f32], b: &[f32]| a.iter().zip(b).filter(|(a, b)| (*a - *b).abs() > 0.02).count();
        let soft = expected
            .iter()
            .filter(|value| (0.1..0.9).contains(*value))
            .count();
        // Skinning rounds.
        assert!(differ(&expected, &got) < 3, "{kind:?}");
        assert!(soft > 40 && differ(&before, &got) > 100, "{kind:?}: {soft}");
    }
}
