//! Penumbra wedges against ray-cast truth.

mod bad_input;
mod buffers;
mod counting;
mod culling;
mod flicker;
mod models;
mod overlap;
mod properties;
mod scenes;
mod tables;
mod texture;
mod twice;
mod unshadowed;

use crate::harness::strict_context;
use crate::harness::support::stage::Stage;
use antumbra::prelude::*;
use antumbra::techniques::penumbra_wedge::{
    Overlap, VisibilityBuffer, WedgeBounds, WedgeCulling, WedgeSilhouette,
};
use bevy_transform::prelude::Transform;
use glam::{Quat, Vec3};
use scenes::{Lit, SAMPLES, ground, judge, light, lit, spawn, truth};

/// A light above a box that stands clear of the ground: from all of the light, the silhouette is that of the top.
fn box_stage(context: &RenderContext, kind: LightKind, wedge: PenumbraWedge) -> Stage {
    let mut stage = ground(context, Vec3::new(2.5, 3.0, 4.5), Vec3::new(-0.3, 0.2, 0.0));
    spawn(
        &mut stage,
        MeshData::cuboid(Vec3::new(0.9, 0.2, 0.9)),
        Transform::from_xyz(0.0, 1.2, 0.0).with_rotation(Quat::from_rotation_y(0.1)),
    );
    light(
        &mut stage,
        &Lit {
            kind,
            from: Vec3::new(0.05, 5.0, 0.03),
            to: Vec3::new(0.05, 0.0, 0.03),
            wedge,
        },
    );
    stage
}

const SHAPES: [(&str, LightKind); 3] = [
    (
        "square",
        LightKind::Rect {
            width: 0.5,
            height: 0.5,
        },
    ),
    (
        "wide",
        LightKind::Rect {
            width: 1.5,
            height: 0.3,
        },
    ),
    ("sphere", LightKind::Sphere { radius: 0.4 }),
];

fn all_settings() -> Vec<(String, PenumbraWedge)> {
    let mut all = Vec::new();
    for buffer in [VisibilityBuffer::Float, VisibilityBuffer::Split8] {
        for culling in [WedgeCulling::Depth, WedgeCulling::Stencil, WedgeCulling::None] {
            for bounds in [WedgeBounds::Tight, WedgeBounds::Sphere] {
                all.push((
                    format!("{buffer:?}_{culling:?}_{bounds:?}"),
                    PenumbraWedge {
                        buffer,
                        culling,
                        bounds,
                        ..Default::default()
                    },
                ));
            }
        }
    }
    all
}

#[test]
fn a_box_throws_the_shadow_of_truth() {
    let context = strict_context();
    for (name, kind) in SHAPES {
        let mut stage = box_stage(&context, kind, PenumbraWedge::default());
        let truth = truth(&mut stage, 0, SAMPLES);
        for (settings, wedge) in all_settings() {
            let light = stage.lights[0];
            stage.world.entity_mut(light).insert(wedge);
            let error = judge(&mut stage, &truth, &format!("box_{name}_{settings}"));
            assert!(error.rmse_penumbra <= 0.01, "{name} {settings}: {error:?}");
            assert_eq!((error.umbra_lit, error.lit_dark), (0.0, 0.0), "{name} {settings}");
        }
    }
}

#[test]
fn balls_throw_the_shadow_of_truth() {
    let context = strict_context();
    // From no two places of the light is the silhouette the same, least of all that of the coarse ball.
    let squeezed = Vec3::new(-1.0, 0.5, 1.2);
    // Turned so that no pixel's centre lies on an edge, where rays and rasterizer may see different surfaces.
    for (ball, subdivisions, scale) in [
        ("coarse", 1, Vec3::ONE),
        ("mirrored", 1, squeezed),
        ("fine", 4, Vec3::ONE),
    ] {
        for (name, kind) in SHAPES {
            let mut stage = ground(&context, Vec3::new(2.5, 3.0, 4.5), Vec3::new(-0.3, 0.2, 0.0));
            let place = Transform::from_xyz(0.0, 1.2, 0.0).with_rotation(Quat::from_rotation_z(0.3));
            let place = place.with_scale(scale);
            spawn(&mut stage, MeshData::icosphere(0.7, subdivisions), place);
            light(&mut stage, &lit(kind, PenumbraWedge::default()));
            let truth = truth(&mut stage, 0, SAMPLES);
            let mut judged = |silhouette, overlap, culling| {
                let light = stage.lights[0];
                stage.world.entity_mut(light).insert(PenumbraWedge {
                    silhouette,
                    overlap,
                    culling,
                    ..Default::default()
                });
                let name = format!("{ball}_ball_{name}_{silhouette:?}_{overlap:?}_{culling:?}");
                judge(&mut stage, &truth, &name)
            };
            let from_center = judged(WedgeSilhouette::Center, Overlap::Sampled, WedgeCulling::Depth);
            for (overlap, culling) in [
                (Overlap::Sampled, WedgeCulling::Depth),
                (Overlap::Additive, WedgeCulling::Stencil),
            ] {
                let error = judged(WedgeSilhouette::Receiver, overlap, culling);
                assert!(
                    error.rmse_penumbra <= 0.005 && error.rmse_penumbra < from_center.rmse_penumbra,
                    "{ball} {name} {overlap:?}: {error:?}, from the centre {from_center:?}"
                );
            }
        }
    }
}
