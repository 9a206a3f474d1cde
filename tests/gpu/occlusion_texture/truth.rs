//! Errors against the ray caster.

use antumbra::prelude::*;
use antumbra::techniques::{OcclusionTexture, SliceCombination, SliceFilter};
use glam::Vec3;

use super::scenes::{
    SUN_TANGENT, Scene, boxes, hills, lamp, low, plate, rendered, rmse, square, staged, tree, truth, wings,
};
use crate::harness::strict_context;

const COMBINATIONS: [SliceCombination; 4] = [
    SliceCombination::Overlap,
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

/// A lamp beside low casters has one picture that looks down on them. In a picture that looks sideways, their plates are cut
/// edge-on and lose most of their shadows: errors are above 0.1.
#[test]
fn lamps_beside_low_casters_see_them_from_above() {
    let context = strict_context();
    let mut stage = staged(&context, &low());
    for place in [Vec3::new(2.0, 1.4, 0.2), Vec3::new(-1.9, 1.3, -0.8)] {
        let (light, place) = lamp(LightKind::Sphere { radius: 0.15 }, place);
        let entity = stage.spawn_light(light, place, Some(OcclusionTexture::default()));
        let got = rendered(&mut stage);
        let truth = truth(&mut stage, 64);
        let (error, lit) = (rmse(&truth, &got), rmse(&truth, &vec![1.0; got.len()]));
        println!("{error:.4}, without a shadow {lit:.4}");
        assert!(error < 0.045 && lit > 0.25, "{error}, {lit}");
        stage.world.despawn(entity);
        stage.lights.clear();
    }
}

/// Among the paper's combinations the product is the best where many casters overlap, and the sum where one surface passes through
/// several slices. What the pictures show of the overlap is as good as the better one everywhere.
#[test]
fn the_overlap_is_as_good_as_the_best_combination_of_each_scene() {
    let context = strict_context();
    for scene in [boxes(), tree(), wings(), hills()] {
        let settings = COMBINATIONS.map(|combine| OcclusionTexture {
            combine,
            ..Default::default()
        });
        let (errors, lit) = errors(&context, &scene, square(1.0), 144, &settings);
        let [overlap, product, maximum, sum] = [errors[0], errors[1], errors[2], errors[3]];
        println!("{}: {errors:.4?}, without a shadow {lit:.4}", scene.name);
        assert!(
            overlap < 1.05 * product.min(maximum).min(sum),
            "{}: {errors:?}",
            scene.name
        );
        if ["boxes", "a tree"].contains(&scene.name) {
            assert!(product < maximum && product < sum, "{}: {errors:?}", scene.name);
        }
        if scene.name == "wings" {
            assert!(overlap < 0.3 * product, "{errors:?}");
        }
    }
}

/// Front and back of a box hide the same rays. Boxes that are open count both, unless the pictures show the overlap.
#[test]
fn closed_casters_hide_once() {
    let context = strict_context();
    let settings = [SliceCombination::Product, SliceCombination::Overlap].map(|combine| OcclusionTexture {
        slices: 16,
        combine,
        ..Default::default()
    });
    let closed = boxes();
    let mut open = boxes();
    for (mesh, _) in &mut open.parts {
        if mesh.indices.len() > 6 {
            // Without half of a narrow side.
            mesh.indices.drain(..3);
            mesh.submeshes[0].index_count -= 3;
        }
    }
    let error = |scene| errors(&context, scene, square(1.0), 144, &settings).0;
    let (closed, open) = (error(&closed), error(&open));
    println!("product, overlap: closed boxes {closed:.4?}, open boxes {open:.4?}");
    assert!(
        closed[0] < 0.045 && open[0] > 1.5 * closed[0],
        "{closed:?}, {open:?}"
    );
    assert!(
        closed[1] < 0.04 && open[1] < 0.7 * open[0],
        "{closed:?}, {open:?}"
    );
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
            "{}: without a shadow {lit:.4}; overlap, product, maximum, sum, each without and with leaks closed",
            scene.name
        );
        for (settings, errors) in settings.chunks(8).zip(errors.chunks(8)) {
            println!(
                "  {:>2} {:<12} {errors:.4?}",
                settings[0].slices,
                format!("{:?}", settings[0].filter)
            );
        }
    }
}
