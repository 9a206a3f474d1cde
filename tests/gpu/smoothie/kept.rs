//! Smoothies that are kept show what those show that are drawn every frame, and those of still casters are drawn once.

use antumbra::prelude::*;
use antumbra::techniques::SmoothieWidth;
use antumbra::techniques::maps::Maps;
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{SPOT, ground, lamp, smoothie, spawn};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

/// Two lights at one place, of which one keeps its smoothies; three blocks that stand, and one that moves.
fn stage(kind: LightKind) -> (Stage, Entity) {
    let mut stage = ground(&strict_context(), Vec3::new(1.0, 4.0, 3.5), Vec3::ZERO);
    for x in [-0.9, 0.0, 0.9] {
        let block = MeshData::cuboid(Vec3::new(0.15, 0.3, 0.15));
        spawn(&mut stage, block, Transform::from_xyz(x, 0.9, 0.0));
    }
    let mover = spawn(
        &mut stage,
        MeshData::cuboid(Vec3::new(0.3, 0.02, 0.2)),
        Transform::from_xyz(-1.4, 1.7, 0.2),
    );
    for cached in [true, false] {
        let (light, place) = lamp(kind, Vec3::new(0.2, 4.5, 0.6));
        let settings = Smoothie {
            cached,
            ..smoothie(SmoothieWidth::Metres(0.25))
        };
        stage.spawn_light(light, place, Some(settings));
    }
    (stage, mover)
}

#[test]
fn kept_smoothies_equal_those_drawn_every_frame() {
    for kind in [SPOT, LightKind::Directional, LightKind::Point] {
        let (mut stage, mover) = stage(kind);
        let mut soft = 0;
        for frame in 0..20 {
            if (2..6).contains(&frame) {
                let mut place = stage
                    .world
                    .get_mut::<Transform>(mover)
                    .expect("it stands somewhere");
                place.translation.x += 0.6;
            }
            let rendered = stage.render().expect("the frame renders");
            let (kept, fresh) = (&rendered.visibility[0], &rendered.visibility[1]);
            let pairs = kept.iter().zip(fresh);
            // Where a moving caster is over the penumbra of a still one, what is kept refers to what is behind.
            let differs = pairs.filter(|(a, b)| (*a - *b).abs() > 0.02).count();
            assert!(
                differs <= kept.len() / 250,
                "{kind:?}, frame {frame}: {differs} pixels differ"
            );
            if !(2..16).contains(&frame) {
                assert_eq!(differs, 0, "{kind:?}, frame {frame}");
            }
            soft += kept.iter().filter(|value| (0.1..0.9).contains(*value)).count();
            let maps = &stage.world.resource::<Maps>().lights;
            assert_eq!(maps.iter().filter(|map| map.cached).count(), 1);
        }
        assert!(soft > 20 * 40, "{kind:?}: {soft}");
    }
}

#[test]
fn what_stands_still_is_drawn_once() {
    let (mut stage, mover) = stage(SPOT);
    let shown = |stage: &Stage| {
        let maps = &stage.world.resource::<Maps>().lights;
        let map = maps.iter().find(|map| map.cached).expect("one is kept");
        let face = &map.faces[0];
        (face.still_revision, face.revision)
    };
    stage.render().expect("the frame renders");
    let first = shown(&stage);
    stage.render().expect("the frame renders");
    assert_eq!(shown(&stage), first, "nothing moves");
    // The first move takes the caster out of the still layer. From then on only the moving layer changes.
    let mut layers = Vec::new();
    for _ in 0..3 {
        let mut place = stage
            .world
            .get_mut::<Transform>(mover)
            .expect("it stands somewhere");
        place.translation.x += 0.1;
        stage.render().expect("the frame renders");
        layers.push(shown(&stage));
    }
    assert!(layers[0].0 != first.0 && layers[0].0 == layers[1].0 && layers[1].0 == layers[2].0);
    assert!(layers[1].1 != layers[0].1 && layers[2].1 != layers[1].1);
}
