//! Forms of the visibility buffer, ways to cull and to compute agree with one another.

use antumbra::prelude::*;
use antumbra::render::RenderError;
use antumbra::techniques::PenumbraWedges;
use antumbra::techniques::penumbra_wedge::{
    CoverageMaths, Overlap, VisibilityBuffer, WedgeCulling, WedgeOverflow,
};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::scenes::{EYE, Lit, crowd, ground, largest_difference, light, lit, rect, spawn, sphere, with};
use crate::harness::support::stage::Stage;
use crate::harness::{own_context, strict_context};

#[test]
fn buffers_and_cullings_agree() {
    let context = strict_context();
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
        let half = with(
            &mut stage,
            PenumbraWedge {
                buffer: VisibilityBuffer::Half,
                ..additive
            },
        );
        let difference = largest_difference(&first, &half);
        println!("float and half differ by {difference}");
        assert!(difference > 0.0 && difference <= 0.005, "{difference}");
        let tables = with(
            &mut stage,
            PenumbraWedge {
                maths: CoverageMaths::Tables,
                ..additive
            },
        );
        let difference = largest_difference(&first, &tables);
        println!("tables differ by {difference}");
        // Those of discs are so fine that half floats hide it.
        let is_seen = difference > 0.0 || matches!(kind, LightKind::Sphere { .. });
        assert!(is_seen && difference <= 0.01, "{difference}");
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
fn one_edge_differs_by_a_step_of_twelve_bits() {
    // A huge square whose one edge crosses the picture.
    let context = strict_context();
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
fn overflow_of_bytes_is_reported() {
    let context = strict_context();
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
    let entity = stage.lights[0];
    stage.world.entity_mut(entity).insert(PenumbraWedge::default());
    assert_eq!(frames(&mut stage), 0, "floats do not overflow");
}

/// Sixty boxes above one another, whose edges overflow bytes.
fn overflowing(context: &RenderContext) -> Stage {
    let mut stage = ground(context, EYE, Vec3::ZERO);
    stage.world.insert_resource(ViewportSize(SMALL));
    let wedge = PenumbraWedge {
        buffer: VisibilityBuffer::Split8,
        ..Default::default()
    };
    light(&mut stage, &lit(rect(0.5, 0.5), wedge));
    for i in 0..60 {
        let place = Transform::from_xyz(0.0, 1.0 + 0.02 * i as f32, 0.0);
        spawn(&mut stage, MeshData::cuboid(Vec3::new(0.5, 0.005, 0.5)), place);
    }
    stage
}

const SMALL: UVec2 = UVec2::new(80, 45);

fn record(stage: &Stage) -> wgpu::CommandEncoder {
    let renderer = stage.world.resource::<Renderer>();
    let device = &renderer.context().device;
    let mut encoder = device.create_command_encoder(&Default::default());
    renderer.record(&mut encoder, &Default::default());
    encoder
}

#[test]
fn overflow_is_reported_of_frames_that_are_submitted_after_the_next_is_prepared() {
    let context = strict_context();
    let mut stage = overflowing(&context);
    stage.run();
    drop(record(&stage)); // a frame that is never submitted does not end the report
    let mut waiting: Option<wgpu::CommandEncoder> = None;
    for _ in 0..5 {
        stage.run();
        if let Some(earlier) = waiting.take() {
            context.queue.submit([earlier.finish()]);
            let waited = context.device.poll(wgpu::PollType::wait_indefinitely());
            waited.expect("the frame ends");
        }
        waiting = Some(record(&stage));
    }
    assert!(stage.world.resource::<WedgeOverflow>().pixels() > 0);
}

/// The loss comes while a copy of the count is on its way, or has just been read.
#[test]
fn a_host_that_tells_late_of_a_loss_has_frames_that_draw_nothing() {
    for frames in [2, 3] {
        let own = own_context(RequestedFeatures::default());
        let mut context = RenderContext::hosted(own.device.clone(), own.queue.clone(), "host".to_owned());
        context.anisotropy = 1;
        let mut stage = overflowing(&context);
        let frame = |stage: &mut Stage| {
            stage.run();
            context.queue.submit([record(stage).finish()]);
            // On a lost device, waiting may be refused.
            let _ = context.device.poll(wgpu::PollType::wait_indefinitely());
        };
        for _ in 0..frames {
            frame(&mut stage);
        }
        context.device.destroy();
        for _ in 0..4 {
            frame(&mut stage);
        }
        context.set_lost();
        stage.run();
        let failure = stage.world.resource_mut::<Renderer>().take_failure();
        assert!(matches!(failure, Some(RenderError::DeviceLost)), "{failure:?}");
    }
}

#[test]
fn counting_towards_the_viewer_and_away_agree() {
    let context = strict_context();
    for kind in [rect(0.9, 0.9), rect(2.4, 0.3), sphere(0.4)] {
        let mut stage = ground(&context, EYE, Vec3::ZERO);
        stage.world.insert_resource(ViewportSize(UVec2::new(320, 180)));
        for i in 0..7 {
            let x = 0.22 * (i as f32 - 3.0);
            for at in [Vec3::new(x, 0.75, 0.0), Vec3::new(x + 0.08, 0.75, -0.5)] {
                spawn(
                    &mut stage,
                    MeshData::cuboid(Vec3::new(0.05, 0.6, 0.05)),
                    Transform::from_translation(at),
                );
            }
        }
        let shone = Lit {
            from: Vec3::new(1.9, 4.2, 1.2),
            to: Vec3::new(0.0, 0.4, 0.0),
            ..lit(kind, PenumbraWedge::default())
        };
        light(&mut stage, &shone);
        let towards = with(&mut stage, PenumbraWedge::default());
        let groups = &stage.world.resource::<PenumbraWedges>().groups;
        assert!(groups.iter().any(|group| !group.towards.is_empty()));
        let away = with(
            &mut stage,
            PenumbraWedge {
                culling: WedgeCulling::None,
                ..Default::default()
            },
        );
        let groups = &stage.world.resource::<PenumbraWedges>().groups;
        assert!(groups.iter().all(|group| group.towards.is_empty()));
        // Where a face passes within the device's rounding of a pixel's centre, neither is right.
        let pairs = towards.values().iter().zip(away.values());
        let apart = pairs.filter(|(a, b)| (**a - **b).abs() > 2e-3).count();
        println!("{kind:?}: {apart} of {} pixels differ", towards.values().len());
        assert!(apart <= 2, "{kind:?}: {apart}");
    }
}
