//! Errors against the ray caster.

use antumbra::prelude::*;
use antumbra::techniques::{OcclusionTexture, SliceCombination, SliceFilter};
use glam::Vec3;

use super::scenes::{
    SUN_TANGENT, Scene, boxes, hills, lamp, plate, rendered, rmse, square, staged, tree, truth, wings,
};
use crate::harness::strict_context;

const COMBINATIONS: [SliceCombination; 3] = [
    SliceCombination::Product,
    SliceCombination::Maximum,
    SliceCombination::Sum,
];

/// The angle that the judge's directional light covers.
fn sun_angle() -> f32 {
    (2.0 * SUN_TANGENT.atan()).to_degrees() as f32
}

/// Errors of several settings on one scene and light, and the error without a shadow.
fn errors(
    context: &RenderContext,
    scene: &Scene,
    kind: LightKind,
    samples: u32,
    settings: &[OcclusionTexture],
) -> (Vec<f64>, f64) {
    let mut stage = staged(context, scene);
    let (light, place) = lamp(kind, Vec3::new(0.3, 3.0, 0.2));
    let entity = stage.spawn_light(light, place, Some(settings[0]));
    let lit = vec![1.0; rendered(&mut stage).len()];
    let truth = truth(&mut stage, samples);
    let mut error = |settings: &OcclusionTexture| {
        stage.world.entity_mut(entity).insert(*settings);
        rmse(&truth, &rendered(&mut stage))
    };
    (settings.iter().map(&mut error).collect(), rmse(&truth, &lit))
}

#[test]
fn shadows_of_all_kinds_of_light_are_near_the_truth() {
    let context = strict_context();
    let kinds = [
        square(1.0),
        LightKind::Sphere { radius: 0.4 },
        LightKind::Directional,
    ];
    for kind in kinds {
        let settings = OcclusionTexture {
            slices: 12,
            angle_deg: sun_angle(),
            ..Default::default()
        };
        let (errors, lit) = errors(&context, &plate(), kind, 144, &[settings]);
        println!("{kind:?}: {:.4}, without a shadow {lit:.4}", errors[0]);
        assert!(errors[0] < 0.03 && lit > 0.1, "{kind:?}: {}, {lit}", errors[0]);
    }
}

#[test]
fn the_product_is_best_where_several_slices_cast() {
    let context = strict_context();
    for scene in [boxes(), tree()] {
        let settings = COMBINATIONS.map(|combine| OcclusionTexture {
            combine,
            ..Default::default()
        });
        let (errors, lit) = errors(&context, &scene, square(1.0), 144, &settings);
        println!("{}: {errors:.4?}, without a shadow {lit:.4}", scene.name);
        assert!(
            errors[0] < errors[1] && errors[0] < errors[2],
            "{}: {errors:?}",
            scene.name
        );
    }
}

/// Front and back of a box hide the same rays. Boxes that are open count both.
#[test]
fn closed_casters_hide_once() {
    let context = strict_context();
    let settings = OcclusionTexture {
        slices: 16,
        ..Default::default()
    };
    let closed = boxes();
    let mut open = boxes();
    for (mesh, _) in &mut open.parts {
        if mesh.indices.len() > 6 {
            // Without half of a narrow side.
            mesh.indices.drain(..3);
            mesh.submeshes[0].index_count -= 3;
        }
    }
    let error = |scene| errors(&context, scene, square(1.0), 144, &[settings]).0[0];
    let (closed, open) = (error(&closed), error(&open));
    println!("closed boxes {closed:.4}, open boxes {open:.4}");
    assert!(closed < 0.045 && open > 1.5 * closed, "{closed}, {open}");
}

#[test]
#[ignore = "a table for people"]
fn errors_by_hand() {
    let context = strict_context();
    for scene in [plate(), boxes(), tree(), wings(), hills()] {
        let mut settings = Vec::new();
        for slices in [4, 8, 16] {
            for filter in [
                SliceFilter::NBuffers,
                SliceFilter::Mipmaps,
                SliceFilter::SummedAreas,
            ] {
                for combine in COMBINATIONS {
                    for close_leaks in [0, u32::MAX] {
                        settings.push(OcclusionTexture {
                            slices,
                            filter,
                            combine,
                            close_leaks,
                            ..Default::default()
                        });
                    }
                }
            }
        }
        let (errors, lit) = errors(&context, &scene, square(1.0), 256, &settings);
        println!(
            "{}: without a shadow {lit:.4}; product, maximum, sum, each without and with leaks closed",
            scene.name
        );
        for (settings, errors) in settings.chunks(6).zip(errors.chunks(6)) {
            println!(
                "  {:>2} {:<12} {errors:.4?}",
                settings[0].slices,
                format!("{:?}", settings[0].filter)
            );
        }
    }
}
