//! Pictures that are kept while nothing moves, and shadows of what moves.

use antumbra::prelude::*;
use antumbra::reference::SurfaceHit;
use antumbra::techniques::{OcclusionTexture, OcclusionTextures, SliceFilter, TextureMemory};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{Scene, boxes, hits, lamp, plate, rendered, spawn, square, staged, truth};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Lights without casters draw no pictures and take no memory. Their shadows are right as soon as casters come.
#[test]
fn lights_without_casters_have_no_pictures() {
    let context = strict_context();
    let box_above = || {
        let place = Transform::from_xyz(-0.2, 0.5, 0.1);
        (MeshData::cuboid(Vec3::splat(0.2)), place)
    };
    let lit = |stage: &mut Stage| {
        let (light, place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
        stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    };
    let parts = |parts| Scene {
        name: "a ground",
        parts,
        eye: Vec3::new(1.5, 3.5, 3.0),
    };
    // A ground of its own casts, but shadows nothing.
    let ground = (MeshData::plane(4.0), Transform::IDENTITY);
    let mut fresh = staged(&context, &parts(vec![ground.clone(), box_above()]));
    lit(&mut fresh);
    let shadowed = rendered(&mut fresh);
    assert!(shadowed.iter().filter(|v| **v < 0.5).count() > 50);

    let mut stage = staged(&context, &parts(vec![ground]));
    lit(&mut stage);
    for _ in 0..2 {
        assert!(rendered(&mut stage).iter().all(|v| *v == 1.0));
        assert!(stage.world.resource::<OcclusionTextures>().of_light(0).is_none());
        assert_eq!(stage.world.resource::<TextureMemory>().bytes(), 0);
        let (mesh, place) = box_above();
        let caster = spawn(&mut stage, mesh, place);
        assert!(rendered(&mut stage) == shadowed, "the caster comes");
        assert!(stage.world.resource::<OcclusionTextures>().of_light(0).is_some());
        assert!(stage.world.resource::<TextureMemory>().bytes() > 0);
        stage.world.despawn(caster);
    }
}

#[test]
fn pictures_are_drawn_again_only_when_something_changes() {
    let context = strict_context();
    let mut stage = staged(&context, &plate());
    let (light, place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
    let entity = stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let frame = |stage: &mut Stage| {
        let picture = rendered(stage);
        (
            picture,
            stage.world.resource::<OcclusionTextures>().lights[0].revision,
        )
    };
    let (first, revision) = frame(&mut stage);
    let (second, same) = frame(&mut stage);
    assert_eq!((&first, revision), (&second, same));
    // The view does not matter.
    let camera = stage.camera;
    stage
        .world
        .get_mut::<Transform>(camera)
        .expect("a place")
        .translation
        .x += 0.2;
    assert_eq!(frame(&mut stage).1, revision);
    stage
        .world
        .get_mut::<Transform>(camera)
        .expect("a place")
        .translation
        .x -= 0.2;
    let caster = spawn(
        &mut stage,
        MeshData::cuboid(Vec3::splat(0.2)),
        Transform::from_xyz(-0.8, 0.5, 0.3),
    );
    let (with_caster, after) = frame(&mut stage);
    assert!(after > revision && with_caster != first);
    stage
        .world
        .get_mut::<Transform>(caster)
        .expect("a place")
        .translation
        .x += 0.4;
    let (moved, moved_at) = frame(&mut stage);
    assert!(moved_at > after && moved != with_caster);
    stage.world.entity_mut(entity).insert(OcclusionTexture {
        slices: 4,
        ..Default::default()
    });
    assert!(frame(&mut stage).1 > moved_at);
    stage.world.despawn(caster);
    stage.world.entity_mut(entity).insert(OcclusionTexture::default());
    assert_eq!(frame(&mut stage).0, first);
}

/// Every filter overwrites all that its textures held: pictures that are drawn again are those of a new light, bit for bit.
#[test]
fn pictures_that_are_drawn_again_hold_nothing_of_the_last_ones() {
    let context = strict_context();
    for filter in [
        SliceFilter::NBuffers,
        SliceFilter::Mipmaps,
        SliceFilter::SummedAreas,
    ] {
        let last_of = |places: &[f32]| {
            let mut stage = staged(&context, &plate());
            let cuboid = MeshData::cuboid(Vec3::splat(0.2));
            let caster = spawn(&mut stage, cuboid, Transform::IDENTITY);
            let (light, place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
            let settings = OcclusionTexture {
                filter,
                ..Default::default()
            };
            stage.spawn_light(light, place, Some(settings));
            let mut picture = Vec::new();
            for x in places {
                *stage.world.get_mut::<Transform>(caster).expect("a place") =
                    Transform::from_xyz(*x, 0.5, 0.3);
                picture = rendered(&mut stage);
            }
            picture
        };
        let (again, new) = (last_of(&[-0.8, -0.4]), last_of(&[-0.4]));
        assert!(again == new, "{filter:?}");
        assert!(last_of(&[-0.8]) != new, "{filter:?}: the caster shows nowhere");
    }
}

/// Slices of the lights under which casters rise.
const COUNTS: [u32; 2] = [8, 16];

/// The ground of one frame: what the light shows of it by each number of slices, the truth, and which pixels show it.
struct Ground {
    got: [Vec<f32>; 2],
    truth: Vec<f32>,
    is_ground: Vec<bool>,
}

impl Ground {
    fn new(stage: &mut Stage) -> Self {
        let light = stage.lights[0];
        let got = COUNTS.map(|slices| {
            stage.world.entity_mut(light).insert(OcclusionTexture {
                slices,
                ..Default::default()
            });
            rendered(stage)
        });
        let (_, hits) = hits(stage);
        let is_ground =
            |hit: &Option<SurfaceHit>| hit.as_ref().is_some_and(|hit| hit.position.y.abs() < 1e-3);
        Self {
            got,
            truth: truth(stage, 324).values().to_vec(),
            is_ground: hits.hits.iter().map(is_ground).collect(),
        }
    }
}

/// Casters cast from their own depth, so nothing jumps where one passes from slice to slice. Under a plate that rises 5 cm a frame
/// through the slices of other casters, visibility changes by less than 0.1 more than it should.
#[test]
fn shadows_of_rising_casters_change_steadily() {
    let context = strict_context();
    let mut stage = staged(&context, &boxes());
    let caster = spawn(&mut stage, MeshData::plane(0.4), Transform::IDENTITY);
    let (light, place) = lamp(square(1.0), Vec3::new(0.3, 3.0, 0.2));
    stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let frames: Vec<Ground> = (0..8)
        .map(|frame| {
            let place = Transform::from_xyz(-0.9, 0.6 + 0.05 * frame as f32, 0.5);
            stage.world.entity_mut(caster).insert(place);
            Ground::new(&mut stage)
        })
        .collect();
    let (mut worst, mut most, mut count) = ([f32::NEG_INFINITY; 2], 0.0f32, 0);
    for pair in frames.windows(2) {
        let (before, after) = (&pair[0], &pair[1]);
        let pixels = 0..after.truth.len();
        for pixel in pixels.filter(|pixel| before.is_ground[*pixel] && after.is_ground[*pixel]) {
            let truth = (after.truth[pixel] - before.truth[pixel]).abs();
            for (worst, (after, before)) in worst.iter_mut().zip(after.got.iter().zip(&before.got)) {
                let change = (after[pixel] - before[pixel]).abs();
                *worst = worst.max(change - truth);
                most = most.max(change);
            }
            count += 1;
        }
    }
    println!("{COUNTS:?} slices: changes of at most {most:.3} a frame, {worst:.3?} more than in truth");
    assert!(count > 5000 && most > 0.05, "{count}, {most}");
    assert!(worst.iter().all(|worst| *worst < 0.1), "{worst:?}");
}
