//! Umbrae of thin casters, and the light that leaks into them.

use std::f32::consts::FRAC_PI_2;

use antumbra::prelude::*;
use antumbra::techniques::{OcclusionTexture, SliceCombination};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};

use super::scenes::{empty, lamp, rendered, rmse, spawn, square, staged, truth, wings};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Umbra pixels that are lighter than 0.1, and all of them. `close_leaks` is a mask of layers.
fn leaks(stage: &mut Stage, combine: SliceCombination, close_leaks: u32) -> (usize, usize) {
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(OcclusionTexture {
        slices: 16,
        combine,
        close_leaks,
        ..Default::default()
    });
    let got = rendered(stage);
    let truth = truth(stage, 144);
    let pixels = truth.values().iter().zip(&got);
    let umbra = pixels.filter(|(truth, _)| **truth == 0.0);
    let lit = umbra.clone().filter(|(_, got)| **got > 0.1);
    (lit.count(), umbra.count())
}

/// Light shines through thin surfaces that pass from slice to slice where slices count as independent, unless the next slice is
/// filled too. Nothing shines through where the pictures show the overlap.
#[test]
fn leaks_of_thin_wings_and_walls_are_closed() {
    let context = strict_context();
    let mut walls = wings();
    walls.parts.truncate(1);
    for side in [-1.0, 1.0] {
        let wall =
            Transform::from_xyz(0.6 * side, 0.8, 0.0).with_rotation(Quat::from_rotation_z(1.45 * side));
        walls.parts.push((MeshData::plane(0.5), wall));
    }
    for (scene, name) in [(wings(), "wings"), (walls, "walls")] {
        let mut stage = staged(&context, &scene);
        let (light, place) = lamp(square(0.3), Vec3::new(0.0, 3.0, 0.0));
        stage.spawn_light(light, place, Some(OcclusionTexture::default()));
        let product = SliceCombination::Product;
        let (open, all) = leaks(&mut stage, product, 0);
        let (closed, _) = leaks(&mut stage, product, u32::MAX);
        let overlap = [0, u32::MAX].map(|mask| leaks(&mut stage, SliceCombination::Overlap, mask).0);
        println!(
            "{name}: of {all} umbra pixels, {open} are lit, {closed} with leaks closed; by the overlap {overlap:?}"
        );
        assert!(
            all > 50 && open > 10 && closed * 1000 <= all,
            "{name}: {open}, {closed} of {all}"
        );
        assert!(overlap.iter().all(|lit| lit * 1000 <= all), "{name}: {overlap:?}");
        // The mask chooses casters: nothing is on layer 5.
        assert_eq!(leaks(&mut stage, product, 1 << 5).0, open);
    }
}

/// Two rooms with walls of 0.1 m, a tilted lamp in one of them and the eye in the other, which is wholly dark.
#[test]
fn thin_walls_between_rooms_hold_most_of_the_light() {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::ZERO);
    let view = Transform::from_xyz(2.0, 1.9, 1.2).looking_at(Vec3::new(3.5, 0.4, -0.6), Vec3::Y);
    stage.world.entity_mut(stage.camera).insert(view);
    spawn(&mut stage, MeshData::plane(6.0), Transform::IDENTITY);
    for x in [-1.5, 1.5, 4.5] {
        let wall = MeshData::cuboid(Vec3::new(0.05, 1.25, 1.5));
        spawn(&mut stage, wall, Transform::from_xyz(x, 1.25, 0.0));
    }
    for z in [-1.5, 1.5] {
        let wall = MeshData::cuboid(Vec3::new(3.0, 1.25, 0.05));
        spawn(&mut stage, wall, Transform::from_xyz(1.5, 1.25, z));
    }
    let light = Light {
        kind: square(0.3),
        ..Light::point(Vec3::ONE, 30.0, f32::INFINITY)
    };
    let from = Vec3::new(-0.2, 2.0, 0.5);
    let place = Transform::from_translation(from).looking_at(Vec3::new(3.1, 0.5, 0.0), Vec3::Y);
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let (product, all) = leaks(&mut stage, SliceCombination::Product, 0);
    let overlap = [0, u32::MAX].map(|mask| leaks(&mut stage, SliceCombination::Overlap, mask).0);
    println!("of {all} umbra pixels, {product} are lit by the product, {overlap:?} by the overlap");
    assert!(all > 2000 && product > all / 10, "{product} of {all}");
    assert!(
        3 * overlap[0] < product && 50 * overlap[1] < all,
        "{overlap:?} of {all}, {product}"
    );
}

/// Umbra pixels of a cupboard in a room that are lit, by the product and by the overlap, and all of them. The cupboard is given
/// by its middle and half of its sides.
fn lit_umbra_of_a_cupboard(light: LightKind, place: Transform, cupboard: [Vec3; 2]) -> ([usize; 2], usize) {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::ZERO);
    let view = Transform::from_xyz(2.2, 1.9, 2.2).looking_at(Vec3::new(-0.6, 0.6, -0.8), Vec3::Y);
    stage.world.entity_mut(stage.camera).insert(view);
    spawn(&mut stage, MeshData::plane(2.5), Transform::IDENTITY);
    let wall = Transform::from_xyz(0.0, 1.25, -2.5)
        .with_rotation(Quat::from_rotation_x(FRAC_PI_2))
        .with_scale(Vec3::new(2.0, 1.0, 1.0));
    spawn(&mut stage, MeshData::plane(1.25), wall);
    let [middle, half] = cupboard;
    spawn(
        &mut stage,
        MeshData::cuboid(half),
        Transform::from_translation(middle),
    );
    let light = Light {
        kind: light,
        ..Light::point(Vec3::ONE, 30.0, f32::INFINITY)
    };
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let (product, all) = leaks(&mut stage, SliceCombination::Product, 0);
    let (overlap, _) = leaks(&mut stage, SliceCombination::Overlap, 0);
    println!("of {all} umbra pixels, {product} are lit by the product, {overlap} by the overlap");
    ([product, overlap], all)
}

/// A cupboard beside a window and far from its axis. In the window's slices, its steep side is strips that are thinner than the
/// kernels. Its back, which the paper's combinations leave out, hides what passes beside them.
#[test]
fn a_cupboard_beside_a_window_holds_the_light() {
    let window = LightKind::Rect {
        width: 1.2,
        height: 1.0,
    };
    let place = Transform::from_xyz(2.49, 1.3, 0.0).looking_to(Vec3::NEG_X, Vec3::Y);
    let cupboard = [Vec3::new(1.9, 0.9, -1.5), Vec3::new(0.3, 0.9, 0.5)];
    let ([product, overlap], all) = lit_umbra_of_a_cupboard(window, place, cupboard);
    assert!(all > 50 && 2 * product > all, "{product} of {all}");
    assert!(20 * overlap < all, "{overlap} of {all}");
}

/// A cupboard beside a ceiling lamp. Rays enter it by one steep side and leave it by another, both of which are strips in the
/// lamp's slices. The slices between are filled.
#[test]
fn a_cupboard_beside_a_ceiling_lamp_holds_the_light() {
    let lamp = square(0.6);
    let place = Transform::from_xyz(-0.7, 2.4, -0.1).looking_to(Vec3::NEG_Y, Vec3::Z);
    let cupboard = [Vec3::new(0.5, 1.1, 0.0), Vec3::new(0.2, 1.1, 0.4)];
    let ([product, overlap], all) = lit_umbra_of_a_cupboard(lamp, place, cupboard);
    assert!(all > 50 && 2 * product > all, "{product} of {all}");
    assert!(20 * overlap < all, "{overlap} of {all}");
}

/// Things on a slab beside a wall, under a tilted lamp: shadows reach their casters, and the floor at the wall's foot stays lit.
#[test]
fn shadows_reach_their_casters_and_lit_floors_stay_lit() {
    let context = strict_context();
    let mut stage = empty(&context, Vec3::ZERO);
    let view = Transform::from_xyz(1.5, 2.2, 3.2).looking_at(Vec3::new(-0.1, 0.5, 0.0), Vec3::Y);
    stage.world.entity_mut(stage.camera).insert(view);
    spawn(&mut stage, MeshData::plane(3.0), Transform::IDENTITY);
    let ball = Transform::from_xyz(-0.5, 0.8, 0.1);
    spawn(&mut stage, MeshData::icosphere(0.3, 2), ball);
    for (middle, half) in [
        ([0.0, 0.25, 0.0], [1.2, 0.25, 0.9]),
        ([0.5, 0.7, -0.2], [0.15, 0.2, 0.15]),
        ([0.55, 0.95, -0.2], [0.35, 0.03, 0.35]),
        ([0.1, 0.75, 0.55], [0.05, 0.25, 0.05]),
        ([-1.9, 0.6, 0.3], [0.04, 0.6, 0.7]),
    ] {
        let at = Transform::from_translation(middle.into());
        spawn(&mut stage, MeshData::cuboid(half.into()), at);
    }
    let light = Light {
        kind: square(0.8),
        ..Light::point(Vec3::ONE, 30.0, f32::INFINITY)
    };
    let place = Transform::from_xyz(0.9, 3.0, 0.8).looking_to(Vec3::new(-0.3, -1.0, -0.25), Vec3::Z);
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let errors = [SliceCombination::Product, SliceCombination::Overlap].map(|combine| {
        let light = stage.lights[0];
        stage.world.entity_mut(light).insert(OcclusionTexture {
            combine,
            ..Default::default()
        });
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 144);
        let pixels = truth.values().iter().zip(&got);
        let dark = pixels.filter(|(truth, got)| **truth == 1.0 && **got < 0.9);
        (rmse(&truth, &got), dark.count())
    });
    println!("errors and lit pixels that are dark, product and overlap: {errors:?}");
    let (error, dark) = errors[1];
    assert!(error < 0.6 * errors[0].0 && dark < 5, "{errors:?}");
}
