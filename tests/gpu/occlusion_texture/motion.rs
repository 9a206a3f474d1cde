//! Pictures that are kept while nothing moves, and shadows of what moves.

use antumbra::prelude::*;
use antumbra::reference::SurfaceHit;
use antumbra::techniques::{OcclusionTexture, OcclusionTextures};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{boxes, hits, lamp, plate, rendered, spawn, square, staged, truth};
use crate::harness::strict_context;

#[test]
fn pictures_are_drawn_again_only_when_something_changes() {
    let context = strict_context();
    let mut stage = staged(&context, &plate());
    let (light, place) = lamp(square(0.5), Vec3::new(0.0, 3.0, 0.0));
    let entity = stage.spawn_light(light, place, Some(OcclusionTexture::default()));
    let frame = |stage: &mut crate::harness::support::stage::Stage| {
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

/// How much more visibility on the ground changes in one frame than it should, at most, under a plate that rises 5 cm a
/// frame through the slices of other casters; and the largest change.
fn changes(context: &RenderContext, slices: u32) -> (f32, f32) {
    let mut stage = staged(context, &boxes());
    let caster = spawn(&mut stage, MeshData::plane(0.4), Transform::IDENTITY);
    let (light, place) = lamp(square(1.0), Vec3::new(0.3, 3.0, 0.2));
    let settings = OcclusionTexture {
        slices,
        ..Default::default()
    };
    stage.spawn_light(light, place, Some(settings));
    let mut before: Option<(Vec<f32>, Vec<f32>, Vec<bool>)> = None;
    let (mut worst, mut most, mut count) = (f32::NEG_INFINITY, 0.0f32, 0);
    for frame in 0..8 {
        let height = 0.6 + 0.05 * frame as f32;
        let place = Transform::from_xyz(-0.9, height, 0.5);
        stage.world.entity_mut(caster).insert(place);
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 100).values().to_vec();
        let (_, hits) = hits(&mut stage);
        let is_ground =
            |hit: &Option<SurfaceHit>| hit.as_ref().is_some_and(|hit| hit.position.y.abs() < 1e-3);
        let ground: Vec<bool> = hits.hits.iter().map(is_ground).collect();
        if let Some((got_before, truth_before, ground_before)) = &before {
            for pixel in (0..got.len()).filter(|pixel| ground[*pixel] && ground_before[*pixel]) {
                let change = (got[pixel] - got_before[pixel]).abs();
                worst = worst.max(change - (truth[pixel] - truth_before[pixel]).abs());
                most = most.max(change);
                count += 1;
            }
        }
        before = Some((got, truth, ground));
    }
    println!("{slices} slices: changes of at most {most:.3} a frame, {worst:.3} more than in truth");
    assert!(count > 5000, "{count}");
    (worst, most)
}

/// Where a caster passes from slice to slice, its shadow moves by the thickness of a slice at once. Sixteen slices keep that
/// below 0.1 in each frame.
#[test]
fn shadows_of_rising_casters_change_steadily() {
    let context = strict_context();
    let (coarse, _) = changes(&context, 8);
    let (fine, most) = changes(&context, 16);
    assert!(
        fine < 0.1 && most > 0.05 && coarse < 0.2,
        "{fine}, {most}, {coarse}"
    );
}
