//! Triangles that would write what the mask is cleared to are not drawn, and no pixel tells.

use std::sync::Arc;

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::scene::ShadowTint;
use antumbra::techniques::IntervalMaps;
use antumbra::techniques::occlusion_interval::Corner;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::drawn::{at, plane};
use super::scenes::{SIZE, add_light, path, settings, spawn};
use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};

/// Number of draws of the first light's shadow in the last frame.
fn draws(stage: &Stage) -> usize {
    let renderer = stage.world.resource::<Renderer>();
    let lights = renderer.frame().lights.iter();
    lights.map(|light| renderer.shadow_batch_count(light)).sum()
}

/// Adds a receiver that is in no maps.
fn add_stranger(stage: &mut Stage, half_size: f32, at: Vec3) -> Entity {
    let mut mesh = MeshData::cuboid(Vec3::splat(half_size));
    mesh.name = "stranger".to_owned();
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        ShadowReceiver,
        Transform::from_translation(at),
    );
    stage.world.spawn(parts).id()
}

#[test]
fn surfaces_that_are_wholly_lit_or_dark_take_no_draw() {
    let (mut stage, maps) = plane(|step| step < 128, path());
    add_light(&mut stage, maps, 0.25, 0.1);
    assert!(at(&mut stage, 0.25, 0.1) > 0.998);
    assert_eq!(draws(&stage), 0, "lit");
    assert_eq!(at(&mut stage, 0.75, 0.1), 0.0);
    assert_eq!(draws(&stage), 0, "dark");
    assert!((at(&mut stage, 0.5, 0.1) - 0.5).abs() < 2e-3);
    assert_eq!(draws(&stage), 1, "it sees a part of the window");
}

#[test]
fn what_is_not_in_the_maps_is_lit_where_all_else_is_dark() {
    let (mut stage, maps) = plane(|step| step < 128, path());
    add_light(&mut stage, maps, 0.75, 0.1);
    assert_eq!((at(&mut stage, 0.75, 0.1), draws(&stage)), (0.0, 0));
    let stranger = add_stranger(&mut stage, 0.3, Vec3::ZERO);
    let both = |stage: &mut Stage| {
        let rendered = stage.render().expect("the frame renders");
        let row = SIZE.y / 2 * SIZE.x;
        [SIZE.x / 2, SIZE.x / 2 + SIZE.y / 3].map(|x| rendered.visibility[0][(row + x) as usize])
    };
    assert_eq!(both(&mut stage), [1.0, 0.0]);
    assert_eq!(draws(&stage), 1, "the plane is drawn dark");
    // A light that the stranger shows no shadows of needs no more than before.
    stage.world.entity_mut(stranger).remove::<ShadowReceiver>();
    assert_eq!(both(&mut stage)[1], 0.0);
    assert_eq!(draws(&stage), 0);
}

#[test]
fn a_triangle_on_no_page_is_lit_beside_a_dark_one() {
    let (mut stage, maps) = plane(|_| false, path());
    let mut half = (*maps).clone();
    half.corners[3..].fill(Corner::NOWHERE);
    add_light(&mut stage, Arc::new(half), 0.5, 0.0);
    let rendered = stage.render().expect("the frame renders");
    let count = |value: f32| {
        rendered.visibility[0]
            .iter()
            .filter(|drawn| **drawn == value)
            .count()
    };
    let (dark, lit) = (count(0.0), count(1.0));
    assert_eq!(dark + lit, SIZE.element_product() as usize);
    assert!(dark > 100 && lit > 100, "{dark} dark, {lit} lit");
}

/// A ball on a ground, both of so many triangles that they are several runs, below a roof. In the shade of the roof most of
/// them are dark. A low sun shines below it.
fn dense() -> Stage {
    let view = Transform::from_xyz(0.5, 1.2, 3.4).looking_at(Vec3::new(0.0, 0.5, 0.0), Vec3::Y);
    let mut stage = Stage::empty(SIZE, Camera::default(), view);
    let side = 33u32;
    let place = |i: u32| (i as f32 / (side - 1) as f32 - 0.5) * 4.0;
    let positions = (0..side * side).map(|i| Vec3::new(place(i % side), 0.0, place(i / side)));
    let quads = (0..side - 1).flat_map(|z| (0..side - 1).map(move |x| z * side + x));
    let indices = quads.flat_map(|a| [a, a + side, a + side + 1, a, a + side + 1, a + 1]);
    let ground = MeshData::from_triangles("ground", positions.collect(), indices.collect());
    spawn(&mut stage.world, ground, Transform::IDENTITY);
    let ball = MeshData::icosphere(0.6, 3);
    spawn(&mut stage.world, ball, Transform::from_xyz(0.0, 0.8, 0.0));
    let roof = MeshData::cuboid(Vec3::new(2.4, 0.05, 1.6));
    spawn(&mut stage.world, roof, Transform::from_xyz(0.0, 1.8, 0.0));
    stage.schedule.run(&mut stage.world);
    stage
}

fn dense_maps() -> Arc<IntervalMaps> {
    let settings = BakeSettings {
        texels_per_metre: 6.0,
        ..Default::default()
    };
    let bake = bake_intervals(&mut dense().world, &path(), &settings, |_| ()).expect("it is baked");
    Arc::new(bake.maps)
}

#[test]
fn leaving_out_what_is_lit_and_what_is_dark_gives_the_same_mask_bit_for_bit() {
    let maps = dense_maps();
    let mut stage = dense();
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    let light = add_light(&mut stage, maps, 0.0, 0.0);
    // Nothing dark may be left out while this shows the light's shadows, of which it has none.
    let stranger = add_stranger(&mut stage, 0.1, Vec3::new(1.0, 0.1, 1.4));
    let (mut fewer, mut soft) = (0, 0);
    for time in [0.03, 0.1, 0.2, 0.35, 0.5, 0.7, 0.9, 0.99] {
        for width in [0.0, 0.02, 0.3] {
            stage.world.entity_mut(light).insert(settings(time, width));
            stage.world.entity_mut(stranger).remove::<ShadowReceiver>();
            let alone = stage.render().expect("the frame renders");
            let alone_draws = draws(&stage);
            stage.world.entity_mut(stranger).insert(ShadowReceiver);
            let beside = stage.render().expect("the frame renders");
            fewer += usize::from(draws(&stage) != alone_draws);
            assert_eq!(alone.visibility, beside.visibility, "{time} {width}");
            soft += alone.visibility[0]
                .iter()
                .filter(|drawn| (0.05..0.95).contains(*drawn))
                .count();
        }
    }
    println!("{fewer} windows draw others, {soft} pixels are soft");
    assert!(fewer > 4 && soft > 400, "{fewer} {soft}");
}

#[test]
fn depth_is_copied_only_for_lights_whose_mask_is_made_from_it() {
    let (mut stage, maps) = plane(|step| step < 128, path());
    let timed = RequestedFeatures {
        timestamps: true,
        ..Default::default()
    };
    stage
        .add_renderer(own_context(timed), RenderSettings::default())
        .expect("shaders compose");
    let light = add_light(&mut stage, maps, 0.5, 0.1);
    let mut copies = || {
        let passes = stage.time_passes().expect("the frame renders");
        let count = |part: &str| passes.iter().filter(|pass| pass.label.ends_with(part)).count();
        assert_eq!(count("interval lookup"), 1, "{passes:?}");
        let copies = count("depth copy");
        // The colour of a shadow depends on the place of the surface, which the light pass finds from the depth.
        let tint = ShadowTint {
            color: Vec3::X,
            ..Default::default()
        };
        stage.world.entity_mut(light).insert(tint);
        copies
    };
    assert_eq!([copies(), copies()], [0, 1]);
}
