//! Textured rectangles against rays.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::techniques::penumbra_wedge::{EmitterTexture, LightTexture, Overlap};
use bevy_transform::prelude::Transform;
use glam::{Vec2, Vec3};

use super::scenes::{EYE, Lit, ground, light, lit, rect, spawn};
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

#[test]
fn a_textured_rectangle_is_covered_by_colour() {
    let context = strict_context();
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    spawn(
        &mut stage,
        MeshData::cuboid(Vec3::new(0.6, 0.1, 0.6)),
        Transform::from_xyz(0.0, 1.5, 0.0),
    );
    let side = 16;
    // Red to the light's right, blue to its left with a bright corner.
    let texels: Vec<Vec3> = (0..side * side)
        .map(|i| match (i % side, i / side) {
            (x, _) if x >= side / 2 => Vec3::new(1.0, 0.1, 0.0),
            (_, y) if y < side / 4 => Vec3::new(0.0, 1.0, 1.0),
            _ => Vec3::new(0.1, 0.1, 0.5),
        })
        .collect();
    let texture =
        Arc::new(LightTexture::new(side, side, vec![texels, vec![Vec3::ONE; side * side]]).unwrap());
    let above = Lit {
        from: Vec3::new(0.1, 4.5, 0.2),
        to: Vec3::new(0.1, 0.0, 0.2),
        // Textures have no other overlap.
        ..lit(
            rect(0.9, 0.9),
            PenumbraWedge {
                overlap: Overlap::Additive,
                ..Default::default()
            },
        )
    };
    let entity = light(&mut stage, &above);
    let white = stage.render().expect("a frame");
    for frame in [1, 0] {
        stage.world.entity_mut(entity).insert(EmitterTexture {
            texture: texture.clone(),
            frame,
        });
        for split in [[1, 1], [2, 3]] {
            stage.world.entity_mut(entity).insert(PenumbraWedge {
                split,
                ..Default::default()
            });
            let got = stage.render().expect("a frame");
            let area = got.visibility[0].iter().zip(&white.visibility[0]);
            let apart = area.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
            assert!(
                apart < 2e-3,
                "the texture does not change what of the area is seen: {apart}"
            );
            let expected = colored_truth(&mut stage, &texture, frame);
            // What arrives is the light's colour times visibility by colour: compare with the unshadowed white light.
            let (mut sum, mut count) = (0.0f64, 0);
            for (pixel, expected) in expected.iter().enumerate() {
                let Some(expected) = expected else { continue };
                for channel in 0..3 {
                    let at = 4 * pixel + channel;
                    let ambient = 0.02 * 0.8;
                    let full = (white.radiance[at] - ambient) / white.visibility[0][pixel];
                    if white.visibility[0][pixel] > 0.2 {
                        let colored = (got.radiance[at] - ambient) / full;
                        sum += f64::from(colored - expected[channel]).powi(2);
                        count += 1;
                    }
                }
            }
            let rmse = (sum / f64::from(count)).sqrt();
            println!("texture frame {frame}, split {split:?}: rmse {rmse:.4} of {count}");
            assert!(count > 500 && rmse < 0.015, "{rmse} of {count}");
        }
    }
}

/// Seen colour of the light at penumbra pixels: the mean of texture times visibility over the light, by rays.
fn colored_truth(stage: &mut Stage, texture: &LightTexture, frame: usize) -> Vec<Option<Vec3>> {
    use antumbra::reference::{RayScene, primary_hits};
    use bevy_transform::prelude::GlobalTransform;
    stage.schedule.run(&mut stage.world);
    let scene = RayScene::from_world(&mut stage.world);
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).unwrap();
    let view = world.get::<GlobalTransform>(stage.camera).unwrap();
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(&scene, camera, view, size).unwrap();
    let place = *world.get::<GlobalTransform>(stage.lights[0]).unwrap();
    let clearance = scene.clearance(place.translation().as_dvec3(), f64::INFINITY, u32::MAX);
    let side = 24;
    hits.hits
        .iter()
        .map(|hit| {
            let hit = hit.as_ref().filter(|hit| hit.position.y < 0.01)?;
            let mut seen = Vec3::ZERO;
            let mut count = 0;
            let mut blocker = None;
            for i in 0..side * side {
                let at =
                    Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) * (2.0 / side as f32) - 1.0;
                let point = place.transform_point((at * 0.45).extend(0.0)).as_dvec3();
                let receiver = Some(hit.triangle);
                blocker = scene.segment_blocker(hit.position, point, clearance, receiver, u32::MAX, blocker);
                if blocker.is_none() {
                    seen += texture.texel(frame, at);
                    count += 1;
                }
            }
            let whole = side * side;
            (count > whole / 20 && count < whole).then(|| seen / whole as f32)
        })
        .collect()
}
