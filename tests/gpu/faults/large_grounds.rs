//! Lamps low over a ground that is far larger than its distance from them.

use antumbra::prelude::*;
use antumbra::techniques::stencil_volume::Extent;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::placements::Random;
use super::scenes::{SIZE, draw, lamp, object, stage};

/// Half of the side of each ground, metres, and the heights of lamps over it.
const GROUNDS: [(f32, [f32; 2]); 4] = [
    (500.0, [0.003, 0.1]),
    (5e3, [0.003, 0.5]),
    (5e4, [0.03, 2.0]),
    (1.5e5, [1.9, 6.0]),
];

/// Number of lamps over a ground.
const LAMPS: usize = 8;

/// Columns at the right of the picture that are not judged. The software driver clips triangles at the picture's border, and
/// leaves out up to four columns of a cap that reaches over 50 km.
const BORDER: u32 = 8;

/// Depths of two triangles of kilometres are rounded by more than a thousandth of a low lamp's height, by which the far cap of
/// a volume would lie below its caster.
#[test]
fn a_large_ground_does_not_shadow_itself_under_a_low_lamp() {
    let mut random = Random::new(3);
    for (half, [low, high]) in GROUNDS {
        let mut stage = stage(
            Vec3::new(1.0, 0.8, 1.6),
            Vec3::new(0.0, 0.0, 0.2),
            Camera::default(),
        );
        stage
            .world
            .spawn(object(MeshData::plane(half), Transform::IDENTITY));
        // It shows that shadows are drawn.
        stage
            .world
            .spawn(object(MeshData::plane(0.05), Transform::from_xyz(0.0, 8.0, 0.0)));
        for _ in 0..LAMPS {
            let mut within = |from: f32, to: f32| from + (to - from) * random.unit() as f32;
            let height = low * (high / low).powf(within(0.0, 1.0));
            let at = Vec3::new(within(-0.6, 0.6), height, within(-0.6, 0.6));
            let lamp = lamp(&mut stage, LightKind::Point, at, f32::INFINITY);
            stage.world.entity_mut(lamp).insert(StencilVolume::default());
        }
        let above = lamp(&mut stage, LightKind::Point, Vec3::Y * 9.0, f32::INFINITY);
        let volumes = StencilVolume {
            extent: Extent::Finite,
            ..StencilVolume::default()
        };
        stage.world.entity_mut(above).insert(volumes);
        let rendered = draw(&mut stage);
        for (light, visibility) in rendered.visibility[..LAMPS].iter().enumerate() {
            let is_inner = |at: usize| at as u32 % SIZE.x < SIZE.x - BORDER;
            let is_dark = |at: &usize| visibility[*at] < 0.5 && is_inner(*at);
            let dark: Vec<usize> = (0..visibility.len()).filter(is_dark).collect();
            assert!(
                dark.is_empty(),
                "lamp {light} over a ground of {half} m: pixels {dark:?}"
            );
        }
        let control = rendered.visibility[LAMPS].iter().filter(|seen| **seen < 0.5);
        assert!(control.count() > 100, "the plate over {half} m casts");
    }
}
