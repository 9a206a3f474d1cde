//! Casters and loops that hide the same part of a light, and lights in parts.

use antumbra::prelude::*;
use antumbra::reference::VisibilityImage;
use antumbra::techniques::PenumbraWedges;
use antumbra::techniques::penumbra_wedge::{Overlap, VisibilityBuffer, WedgeSilhouette};
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{
    EYE, Lit, SAMPLES, crowd, ground, judge, largest_difference, light, lit, rect, rendered, spawn, sphere,
    truth, with,
};
use crate::harness::strict_context;

#[test]
fn both_orders_of_casters_give_one_picture() {
    let context = strict_context();
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

/// Slabs one above the other, their middles and half sizes.
const SLABS: [(Vec3, Vec3); 2] = [
    (Vec3::new(0.0, 1.3, 0.0), Vec3::new(0.7, 0.04, 0.5)),
    (Vec3::new(0.25, 0.9, 0.1), Vec3::new(0.5, 0.04, 0.6)),
];

/// One mesh of several boxes.
fn boxes(parts: &[(Vec3, Vec3)]) -> MeshData {
    let (mut positions, mut indices) = (Vec::new(), Vec::new());
    for &(middle, half) in parts {
        let part = MeshData::cuboid(half);
        indices.extend(part.indices.iter().map(|index| index + positions.len() as u32));
        positions.extend(part.positions.iter().map(|position| *position + middle));
    }
    MeshData::from_triangles("boxes", positions, indices)
}

/// One closed piece: two round plates on a neck that widens downwards, so that all of it faces a light above.
fn spool(inside_out: bool) -> MeshData {
    const SIDES: usize = 16;
    let profile = [(0.0, 1.5), (0.7, 1.4), (0.1, 1.36), (0.75, 0.9), (0.0, 0.85)];
    let corner = |ring: usize, side: usize| {
        let (radius, height): (f32, f32) = profile[ring];
        let (sin, cos) = ((side % SIDES) as f32 / SIDES as f32 * std::f32::consts::TAU).sin_cos();
        Vec3::new(radius * cos, height, -radius * sin)
    };
    let mut positions = Vec::new();
    for (ring, side) in (0..profile.len() - 1).flat_map(|ring| (0..SIDES).map(move |side| (ring, side))) {
        let [a, b] = [corner(ring, side), corner(ring, side + 1)];
        let [c, d] = [corner(ring + 1, side), corner(ring + 1, side + 1)];
        positions.extend([a, c, d]);
        positions.extend([a, d, b]);
    }
    let mut indices: Vec<u32> = (0..positions.len() as u32).collect();
    if inside_out {
        indices.chunks_exact_mut(3).for_each(|corners| corners.swap(1, 2));
    }
    MeshData::from_triangles("spool", positions, indices)
}

fn above(overlap: Overlap) -> Lit {
    Lit {
        from: Vec3::new(0.1, 5.0, 0.2),
        to: Vec3::new(0.1, 0.0, 0.2),
        ..lit(
            rect(1.0, 1.0),
            PenumbraWedge {
                overlap,
                ..Default::default()
            },
        )
    }
}

/// The silhouette that equation 1 is about.
fn from_center(lit: Lit) -> Lit {
    Lit {
        wedge: PenumbraWedge {
            silhouette: WedgeSilhouette::Center,
            ..lit.wedge
        },
        ..lit
    }
}

/// The first mesh alone over a ground, and where the ground shows.
fn shadow_of(context: &RenderContext, mesh: MeshData, overlap: Overlap) -> (VisibilityImage, Vec<f32>) {
    let mut stage = ground(context, EYE, Vec3::ZERO);
    spawn(&mut stage, mesh, Transform::IDENTITY);
    light(&mut stage, &from_center(above(overlap)));
    let got = rendered(&mut stage, 0);
    let height = heights(&mut stage);
    (got, height)
}

/// Of the surface that each pixel shows; NaN where there is none.
fn heights(stage: &mut crate::harness::support::stage::Stage) -> Vec<f32> {
    use antumbra::reference::{RayScene, primary_hits};
    use bevy_transform::prelude::GlobalTransform;
    let scene = RayScene::from_world(&mut stage.world);
    let world = &stage.world;
    let camera = world.get::<Camera>(stage.camera).expect("a camera");
    let view = world.get::<GlobalTransform>(stage.camera).expect("its place");
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(&scene, camera, view, size).expect("a usable camera");
    let height =
        |hit: &Option<antumbra::reference::SurfaceHit>| hit.map_or(f32::NAN, |hit| hit.position.y as f32);
    hits.hits.iter().map(height).collect()
}

#[test]
fn equation_1_combines_the_loops_of_one_caster() {
    let context = strict_context();
    let [first, second] = [0, 1].map(|i| shadow_of(&context, boxes(&SLABS[i..=i]), Overlap::Additive).0);
    let (paper, height) = shadow_of(&context, boxes(&SLABS), Overlap::Paper);
    let (additive, _) = shadow_of(&context, boxes(&SLABS), Overlap::Additive);
    let (mut worst, mut worst_of_sum, mut both) = (0.0f32, 0.0f32, 0);
    for pixel in (0..height.len()).filter(|&pixel| height[pixel].abs() < 1e-3) {
        let [a, b] = [&first, &second].map(|image| 1.0 - image.values()[pixel]);
        let combined = (a.max(b) + 0.5 * a.min(b)).min(1.0);
        both += usize::from(a.min(b) > 0.05 && a.max(b) < 0.95);
        worst = worst.max((1.0 - paper.values()[pixel] - combined).abs());
        worst_of_sum = worst_of_sum.max((1.0 - additive.values()[pixel] - combined).abs());
    }
    println!(
        "eq. 1 per loop: {worst} off over {both} pixels of two penumbras; the sum is {worst_of_sum} off"
    );
    assert!(both > 50 && worst < 2e-3 && worst_of_sum > 0.1);
}

#[test]
fn loops_of_one_piece_are_told_apart() {
    let context = strict_context();
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    spawn(&mut stage, spool(false), Transform::IDENTITY);
    light(&mut stage, &above(Overlap::Paper));
    let truth = truth(&mut stage, 0, SAMPLES);
    let paper = judge(&mut stage, &truth, "spool_paper").rmse_penumbra;
    // The ground's, and those of the two plates: their undersides, of which the upper has a hole.
    let groups = stage.world.resource::<PenumbraWedges>().groups.len();
    assert_eq!(groups, 3, "sums");
    let entity = stage.lights[0];
    let [additive, sampled] = [Overlap::Additive, Overlap::Sampled].map(|overlap| {
        let wedge = above(overlap).wedge;
        stage.world.entity_mut(entity).insert(wedge);
        judge(&mut stage, &truth, &format!("spool_{overlap:?}")).rmse_penumbra
    });
    assert_eq!(stage.world.resource::<PenumbraWedges>().groups.len(), 1);
    assert!(
        sampled < paper && paper < additive,
        "{sampled} {paper} {additive}"
    );
}

#[test]
fn inside_out_pieces_cast_as_open_ones() {
    let context = strict_context();
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    spawn(&mut stage, spool(true), Transform::IDENTITY);
    let entity = light(&mut stage, &above(Overlap::Additive));
    stage.world.insert_resource(FaceCulling::None);
    let truth = truth(&mut stage, 0, SAMPLES);
    for overlap in [Overlap::Additive, Overlap::Paper, Overlap::Sampled] {
        stage.world.entity_mut(entity).insert(above(overlap).wedge);
        let error = judge(&mut stage, &truth, &format!("inside_out_{overlap:?}"));
        assert!(
            error.rmse_penumbra < 0.17 && error.lit_dark == 0.0,
            "{overlap:?} {error:?}"
        );
    }
}

#[test]
fn sampled_overlaps_err_least() {
    let context = strict_context();
    for kind in [rect(1.0, 1.0), sphere(0.5)] {
        let mut stage = ground(&context, EYE, Vec3::ZERO);
        spawn(&mut stage, boxes(&SLABS), Transform::IDENTITY);
        let entity = light(
            &mut stage,
            &Lit {
                kind,
                ..above(Overlap::Paper)
            },
        );
        let truth = truth(&mut stage, 0, SAMPLES);
        let [additive, paper, sampled] =
            [Overlap::Additive, Overlap::Paper, Overlap::Sampled].map(|overlap| {
                let wedge = above(overlap).wedge;
                stage.world.entity_mut(entity).insert(wedge);
                judge(&mut stage, &truth, &format!("slabs_{overlap:?}")).rmse_penumbra
            });
        assert!(
            paper < 0.7 * additive && sampled < 0.3 * paper,
            "{kind:?}: {additive} {paper} {sampled}"
        );
    }
}

/// Thin posts on a ground, as one mesh.
fn posts(x: &[f32], z: &[f32]) -> Vec<(Vec3, Vec3)> {
    let all = x.iter().flat_map(|&x| z.iter().map(move |&z| (x, z)));
    all.map(|(x, z)| (Vec3::new(x, 1.02, z), Vec3::new(0.025, 1.0, 0.025)))
        .collect()
}

#[test]
fn posts_that_overlap_hide_as_rays_do() {
    let context = strict_context();
    let mut failed = Vec::new();
    let pair = posts(&[-0.06, 0.06], &[0.0]);
    let six = posts(&[-0.09, 0.0, 0.09], &[-0.045, 0.045]);
    for (name, boxes_once, bound) in [("two", pair, 0.01), ("six", six, 0.03)] {
        let doubled = boxes_once.repeat(2);
        let mut truths = None;
        // Alone, in one mesh with a copy of itself, and with a second object in the same place.
        for (way, list, objects, bound) in [
            ("once", &boxes_once, 1, bound),
            ("doubled", &doubled, 1, 0.03),
            ("spawned twice", &boxes_once, 2, 0.03),
        ] {
            let mut stage = ground(&context, Vec3::new(3.1, 2.4, 4.3), Vec3::Y * 0.7);
            let camera = stage.camera;
            let mut camera = stage.world.get_mut::<Camera>(camera).expect("a camera");
            camera.vertical_fov = 34f32.to_radians();
            for _ in 0..objects {
                spawn(&mut stage, boxes(list), Transform::IDENTITY);
            }
            light(
                &mut stage,
                &Lit {
                    from: Vec3::new(1.7, 3.9, 1.3),
                    to: Vec3::Y * 0.9,
                    ..lit(rect(0.5, 0.5), PenumbraWedge::default())
                },
            );
            // Copies change nothing that a ray meets.
            let truth = truths.get_or_insert_with(|| truth(&mut stage, 0, SAMPLES));
            let error = judge(&mut stage, truth, &format!("{name}_posts_{way}"));
            assert!(error.penumbra > 200, "{name} {way}: {error:?}");
            if error.rmse_penumbra > bound {
                failed.push((name, way, error.rmse_penumbra));
            }
        }
    }
    assert!(failed.is_empty(), "{failed:#?}");
}

#[test]
fn places_change_little_where_nothing_overlaps() {
    let context = strict_context();
    for kind in [rect(1.0, 1.0), sphere(0.5)] {
        let mut stage = ground(&context, EYE, Vec3::ZERO);
        spawn(&mut stage, boxes(&SLABS[..1]), Transform::IDENTITY);
        light(
            &mut stage,
            &Lit {
                kind,
                ..above(Overlap::Sampled)
            },
        );
        let [sampled, additive] = [Overlap::Sampled, Overlap::Additive].map(|overlap| {
            with(
                &mut stage,
                PenumbraWedge {
                    overlap,
                    ..Default::default()
                },
            )
        });
        // Places near the corner of a loop come out a little more or less than once hidden.
        let most = largest_difference(&sampled, &additive);
        println!("{kind:?}: places change what one caster hides by up to {most:.4}");
        assert!(most <= 0.04, "{most}");
    }
}

#[test]
fn a_split_sphere_is_nearly_the_sphere() {
    let context = strict_context();
    let mut stage = ground(&context, EYE, Vec3::ZERO);
    spawn(&mut stage, boxes(&SLABS[..1]), Transform::IDENTITY);
    let kind = sphere(0.5);
    let entity = light(
        &mut stage,
        &Lit {
            kind,
            ..above(Overlap::Sampled)
        },
    );
    let truth = truth(&mut stage, 0, SAMPLES);
    let errors = [1, 2, 3, 4].map(|parts| {
        let wedge = PenumbraWedge {
            split: [parts; 2],
            ..Default::default()
        };
        stage.world.entity_mut(entity).insert(wedge);
        judge(&mut stage, &truth, &format!("split_sphere_{parts}")).rmse_penumbra
    });
    // What discs in place of a disc cost; see the parts.
    assert!(
        errors[0] < 0.01 && errors[1] < 0.06 && errors[2] < 0.035 && errors[3] < 0.035,
        "{errors:?}"
    );
    assert_eq!(stage.world.resource::<PenumbraWedges>().parts.len(), 16);
}

#[test]
fn split_lights_err_less() {
    let context = strict_context();
    for overlap in [Overlap::Sampled, Overlap::Additive] {
        let mut stage = crowd(&context, false);
        light(&mut stage, &lit(rect(1.0, 1.0), PenumbraWedge::default()));
        let truth = truth(&mut stage, 0, SAMPLES);
        let mut errors = |silhouette| {
            [1, 2, 3].map(|parts| {
                let light = stage.lights[0];
                stage.world.entity_mut(light).insert(PenumbraWedge {
                    split: [parts; 2],
                    silhouette,
                    overlap,
                    ..Default::default()
                });
                judge(
                    &mut stage,
                    &truth,
                    &format!("split{parts}_{overlap:?}_{silhouette:?}"),
                )
                .rmse
            })
        };
        let from_center = errors(WedgeSilhouette::Center);
        let from_receivers = errors(WedgeSilhouette::Receiver);
        assert!(
            from_center[1] < 0.6 * from_center[0] && from_center[2] < from_center[1],
            "{overlap:?} {from_center:?}"
        );
        // Splitting tells overlaps; the silhouette is right without.
        assert!(
            from_receivers[2] < 0.8 * from_receivers[0] && from_receivers[2] <= from_receivers[1],
            "{overlap:?} {from_receivers:?}"
        );
        assert!(from_receivers[0] < 0.9 * from_center[0], "{overlap:?}");
    }
}
