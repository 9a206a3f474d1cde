//! What holds of wedges whatever they are compared with.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::VisibilityImage;
use antumbra::techniques::penumbra_wedge::{
    CoverageMaths, EmitterTexture, LightTexture, Overlap, VisibilityBuffer, WedgeCulling, WedgeOverflow,
};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec2, Vec3};

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;
use crate::scenes::{Lit, SAMPLES, ground, judge, light, rect, rendered, spawn, sphere, truth};

const EYE: Vec3 = Vec3::new(2.5, 3.0, 4.5);

fn lit(kind: LightKind, wedge: PenumbraWedge) -> Lit {
    Lit {
        kind,
        from: Vec3::new(0.6, 4.5, 0.8),
        to: Vec3::ZERO,
        wedge,
    }
}

/// Spheres and boxes that overlap as seen from the light, in an order.
fn crowd(context: &RenderContext, reversed: bool) -> Stage {
    let mut stage = ground(context, EYE, Vec3::ZERO);
    let mut casters: Vec<(MeshData, Transform)> = (0..6)
        .map(|i| {
            let angle = i as f32 * 1.1;
            let place = Transform::from_xyz(0.5 * angle.cos(), 0.5 + 0.25 * i as f32, 0.5 * angle.sin());
            let mesh = if i % 2 == 0 {
                MeshData::cuboid(Vec3::splat(0.25))
            } else {
                MeshData::icosphere(0.3, 2)
            };
            (mesh, place.with_rotation(Quat::from_rotation_x(angle)))
        })
        .collect();
    if reversed {
        casters.reverse();
    }
    for (mesh, place) in casters {
        spawn(&mut stage, mesh, place);
    }
    stage
}

fn largest_difference(a: &VisibilityImage, b: &VisibilityImage) -> f32 {
    let pairs = a.values().iter().zip(b.values());
    pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

fn with(stage: &mut Stage, wedge: PenumbraWedge) -> VisibilityImage {
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(wedge);
    rendered(stage, 0)
}

#[test]
fn both_orders_of_casters_give_one_picture() {
    let context = strict_context(RequestedFeatures::default());
    for buffer in [VisibilityBuffer::Float, VisibilityBuffer::Split8] {
        let wedge = PenumbraWedge {
            buffer,
            ..Default::default()
        };
        let [one, other] = [false, true].map(|reversed| {
            let mut stage = crowd(&context, reversed);
            light(&mut stage, &lit(rect(0.8, 0.5), wedge));
            rendered(&mut stage, 0)
        });
        assert_eq!(largest_difference(&one, &other), 0.0, "{buffer:?}");
    }
}

#[test]
fn buffers_and_cullings_agree() {
    let context = strict_context(RequestedFeatures::default());
    let additive = PenumbraWedge {
        overlap: Overlap::Additive,
        ..Default::default()
    };
    for kind in [rect(0.8, 0.5), sphere(0.35)] {
        let mut stage = crowd(&context, false);
        light(&mut stage, &lit(kind, additive));
        let first = with(&mut stage, additive);
        // No more than a dozen edges cover the light at any pixel of this scene.
        let split = with(
            &mut stage,
            PenumbraWedge {
                buffer: VisibilityBuffer::Split8,
                ..additive
            },
        );
        let difference = largest_difference(&first, &split);
        println!("float and split8 differ by {difference}");
        assert!(difference <= 12.0 / 4096.0, "{difference}");
        let tables = with(
            &mut stage,
            PenumbraWedge {
                maths: CoverageMaths::Tables,
                ..additive
            },
        );
        let difference = largest_difference(&first, &tables);
        println!("tables differ by {difference}");
        assert!(difference > 0.0 && difference <= 0.01, "{difference}");
        for overlap in [Overlap::Additive, Overlap::Sampled] {
            let wedge = PenumbraWedge { overlap, ..additive };
            let first = with(&mut stage, wedge);
            for culling in [WedgeCulling::Stencil, WedgeCulling::None] {
                let other = with(&mut stage, PenumbraWedge { culling, ..wedge });
                let pairs = first.values().iter().zip(other.values());
                let apart = pairs.filter(|(a, b)| (**a - **b).abs() > 1e-3).count();
                assert!(apart <= 3, "{overlap:?} {culling:?}: {apart} pixels");
            }
        }
    }
}

#[test]
fn overlaps_cover_less_than_their_sum() {
    let context = strict_context(RequestedFeatures::default());
    for kind in [rect(0.8, 0.5), sphere(0.35)] {
        let mut stage = crowd(&context, false);
        light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let truth = truth(&mut stage, 0, SAMPLES);
        let mut judged = |overlap| {
            let wedge = PenumbraWedge {
                overlap,
                ..Default::default()
            };
            let light = stage.lights[0];
            stage.world.entity_mut(light).insert(wedge);
            let error = judge(&mut stage, &truth, &format!("crowd_{overlap:?}"));
            (with(&mut stage, wedge), error.rmse_penumbra)
        };
        let [
            (additive, additive_error),
            (paper, paper_error),
            (_, sampled_error),
        ] = [Overlap::Additive, Overlap::Paper, Overlap::Sampled].map(&mut judged);
        let pairs = || paper.values().iter().zip(additive.values());
        assert!(
            pairs().all(|(paper, additive)| *paper >= additive - 2e-3),
            "less is covered where casters overlap"
        );
        assert!(
            pairs().any(|(paper, additive)| *paper > additive + 0.1),
            "and they do"
        );
        assert!(
            paper_error < additive_error && sampled_error < 0.5 * paper_error,
            "{additive_error} {paper_error} {sampled_error}"
        );
    }
}

#[test]
fn one_edge_differs_by_a_step_of_twelve_bits() {
    // A huge square whose one edge crosses the picture.
    let context = strict_context(RequestedFeatures::default());
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    spawn(
        &mut stage,
        MeshData::plane(30.0),
        Transform::from_xyz(-30.0, 2.0, 0.0),
    );
    light(&mut stage, &lit(rect(0.8, 0.5), PenumbraWedge::default()));
    let float = with(&mut stage, PenumbraWedge::default());
    let split = with(
        &mut stage,
        PenumbraWedge {
            buffer: VisibilityBuffer::Split8,
            ..Default::default()
        },
    );
    assert!(float.values().iter().any(|v| *v > 0.3 && *v < 0.7));
    // Half floats of the mask round by 1/4096 beside it.
    let difference = largest_difference(&float, &split);
    assert!(difference <= 1.0 / 4096.0 + 1.0 / 2048.0, "{difference}");
}

#[test]
fn without_extent_the_shadow_is_that_of_stencil_volumes() {
    let context = strict_context(RequestedFeatures::default());
    for kind in [
        rect(0.0, 0.0),
        sphere(0.0),
        LightKind::Point,
        LightKind::Directional,
    ] {
        let mut stage = crowd(&context, false);
        let entity = light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let wedges = rendered(&mut stage, 0);
        assert!(wedges.values().contains(&0.0));
        stage
            .world
            .entity_mut(entity)
            .remove::<PenumbraWedge>()
            .insert(StencilVolume::default());
        let volumes = rendered(&mut stage, 0);
        assert_eq!(largest_difference(&wedges, &volumes), 0.0, "{kind:?}");
    }
}

#[test]
fn the_camera_may_stand_in_shadow_and_wedge() {
    let context = strict_context(RequestedFeatures::default());
    for (name, eye) in [
        ("umbra", Vec3::new(0.0, 0.25, 0.1)),
        ("wedge", Vec3::new(0.95, 0.5, 0.2)),
    ] {
        let mut stage = ground(&context, eye, Vec3::new(-2.0, 0.0, -2.5));
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(0.9, 0.1, 0.9)),
            Transform::from_xyz(0.0, 1.2, 0.0),
        );
        let above = Lit {
            from: Vec3::new(0.0, 4.5, 0.0),
            ..lit(rect(0.6, 0.6), PenumbraWedge::default())
        };
        light(&mut stage, &above);
        let truth = truth(&mut stage, 0, SAMPLES);
        for culling in [WedgeCulling::Depth, WedgeCulling::Stencil] {
            let light = stage.lights[0];
            stage.world.entity_mut(light).insert(PenumbraWedge {
                culling,
                ..Default::default()
            });
            let error = judge(&mut stage, &truth, &format!("inside_{name}_{culling:?}"));
            assert!(
                error.penumbra > 100 && error.rmse_penumbra <= 0.01,
                "{name} {culling:?}: {error:?}"
            );
        }
    }
}

#[test]
fn contact_leaks_nothing() {
    let context = strict_context(RequestedFeatures::default());
    for kind in [rect(0.5, 0.5), sphere(0.25)] {
        let mut stage = ground(&context, EYE, Vec3::new(0.0, 0.2, 0.0));
        // A sliver into the ground.
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::new(0.5, 0.6, 0.5)),
            Transform::from_xyz(0.0, 0.55, 0.0).with_rotation(Quat::from_rotation_y(0.5)),
        );
        light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let truth = truth(&mut stage, 0, SAMPLES);
        let error = judge(&mut stage, &truth, "contact");
        let got = rendered(&mut stage, 0);
        let (width, height) = (truth.size().x as i32, truth.size().y as i32);
        // Off a band of one pixel: where all neighbours agree.
        let (mut lit, mut dark) = (0, 0);
        for (x, y) in (1..height - 1).flat_map(|y| (1..width - 1).map(move |x| (x, y))) {
            let near = (-1..=1).flat_map(|dy| (-1..=1).map(move |dx| (dx, dy)));
            let values: Vec<f32> = near
                .filter_map(|(dx, dy)| truth.get((x + dx) as u32, (y + dy) as u32))
                .collect();
            let value = got.get(x as u32, y as u32).unwrap();
            lit += usize::from(values.iter().all(|v| *v == 0.0) && value > 0.1);
            dark += usize::from(values.iter().all(|v| *v == 1.0) && value < 0.9);
        }
        assert_eq!((lit, dark), (0, 0), "{kind:?} {error:?}");
    }
}

#[test]
fn split_lights_err_less() {
    let context = strict_context(RequestedFeatures::default());
    for (kind, overlap) in [
        (rect(1.0, 1.0), Overlap::Sampled),
        (rect(1.0, 1.0), Overlap::Additive),
        (sphere(0.55), Overlap::Additive),
    ] {
        let mut stage = crowd(&context, false);
        light(&mut stage, &lit(kind, PenumbraWedge::default()));
        let truth = truth(&mut stage, 0, SAMPLES);
        let errors = [1, 2, 3].map(|parts| {
            let light = stage.lights[0];
            stage.world.entity_mut(light).insert(PenumbraWedge {
                split: [parts; 2],
                overlap,
                ..Default::default()
            });
            judge(&mut stage, &truth, &format!("split{parts}")).rmse
        });
        assert!(
            errors[1] < 0.6 * errors[0] && errors[2] < errors[1],
            "{kind:?} {overlap:?} {errors:?}"
        );
    }
}

#[test]
fn a_slowly_moving_light_does_not_flicker() {
    let context = strict_context(RequestedFeatures::default());
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    spawn(
        &mut stage,
        MeshData::icosphere(0.5, 3),
        Transform::from_xyz(0.0, 1.2, 0.0),
    );
    light(&mut stage, &lit(rect(0.5, 0.5), PenumbraWedge::default()));
    let entity = stage.lights[0];
    stage
        .world
        .insert_resource(ViewportSize(glam::UVec2::new(80, 45)));
    let mut last: Option<(VisibilityImage, VisibilityImage)> = None;
    let (mut worst, mut moved) = (0.0f32, 0.0f32);
    for frame in 0..60 {
        let from = Vec3::new(0.6 + 0.01 * frame as f32, 4.5, 0.8);
        let place = Transform::from_translation(from).looking_at(Vec3::ZERO, Vec3::Y);
        stage.world.entity_mut(entity).insert(place);
        let got = rendered(&mut stage, 0);
        let now = truth(&mut stage, 0, 256);
        if let Some((last_got, last_truth)) = &last {
            for i in 0..now.values().len() {
                let change = (now.values()[i] - last_truth.values()[i]).abs();
                if change.is_nan() {
                    continue;
                }
                moved = moved.max(change);
                worst = worst.max((got.values()[i] - last_got.values()[i]).abs() - change);
            }
        }
        last = Some((got, now));
    }
    println!("truth changes by up to {moved:.3} a frame, the wedges by up to {worst:.3} more");
    assert!(moved > 0.02, "the light moves");
    assert!(worst <= 0.05, "{worst}");
}

#[test]
fn a_textured_rectangle_is_covered_by_colour() {
    let context = strict_context(RequestedFeatures::default());
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
        ..lit(rect(0.9, 0.9), PenumbraWedge::default())
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
    let side = 24;
    hits.hits
        .iter()
        .map(|hit| {
            let hit = hit.as_ref().filter(|hit| hit.position.y < 0.01)?;
            let mut seen = Vec3::ZERO;
            let mut count = 0;
            for i in 0..side * side {
                let at =
                    Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) * (2.0 / side as f32) - 1.0;
                let point = place.transform_point((at * 0.45).extend(0.0)).as_dvec3();
                if !scene.blocks_segment(hit.position, point, Some(hit.triangle), u32::MAX) {
                    seen += texture.texel(frame, at);
                    count += 1;
                }
            }
            let whole = side * side;
            (count > whole / 20 && count < whole).then(|| seen / whole as f32)
        })
        .collect()
}

#[test]
fn overflow_of_bytes_is_reported() {
    let context = strict_context(RequestedFeatures::default());
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    let wedge = PenumbraWedge {
        buffer: VisibilityBuffer::Split8,
        ..Default::default()
    };
    light(&mut stage, &lit(rect(0.5, 0.5), wedge));
    let frames = |stage: &mut Stage| {
        for _ in 0..4 {
            stage.render().expect("a frame");
        }
        stage.world.resource::<WedgeOverflow>().pixels()
    };
    assert_eq!(frames(&mut stage), 0);
    for i in 0..60 {
        let place = Transform::from_xyz(0.0, 1.0 + 0.02 * i as f32, 0.0);
        spawn(&mut stage, MeshData::cuboid(Vec3::new(0.5, 0.005, 0.5)), place);
    }
    assert!(frames(&mut stage) > 0, "sixty boxes cover one another");
}
