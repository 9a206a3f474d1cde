//! Lights in, on and near surfaces: what they touch blocks nothing, all else blocks.

use std::collections::BTreeMap;

use antumbra::geometry::distance_to_triangle;
use antumbra::geometry::edge_mesh::{EdgeMesh, EdgeMeshInput};
use antumbra::prelude::*;
use antumbra::reference::RayScene;
use antumbra::silhouettes::{
    CapMode, Contour, FacingBits, FacingPlanes, GrazingLight, LightClearance, classify, compute_planes,
    extract_contour, find_grazed, take_out_of_contour,
};
use bevy_transform::prelude::Transform;
use glam::{DMat4, DVec3, Vec3};

use super::placements::{Random, on_triangle};
use super::scenes::{HARD, dark, draw, error_of, lamp, object, set_technique, stage};

/// Closed, open and tessellated surfaces.
fn meshes() -> Vec<MeshData> {
    vec![
        MeshData::cuboid(Vec3::new(2.0, 1.0, 1.5)),
        MeshData::plane(4.0),
        MeshData::icosphere(1.5, 2),
        MeshData::icosphere(1.5, 0),
    ]
}

/// Heights over a surface, and whether they are within the clearance, which is 0.16 to 0.64 mm here.
const HEIGHTS: [(f64, bool); 11] = [
    (0.0, true),
    (1e-7, true),
    (-1e-7, true),
    (2e-6, true),
    (-2e-6, true),
    (1e-5, true),
    (-1e-5, true),
    (2e-3, false),
    (-2e-3, false),
    (0.1, false),
    (-0.1, false),
];

/// The volume's boundary: what its caps leave, each directed edge with how often.
fn borders(contour: &Contour) -> BTreeMap<[u32; 2], i32> {
    let mut borders = BTreeMap::new();
    let mut add = |a: u32, b: u32| {
        let (edge, sign) = if a < b { ([a, b], 1) } else { ([b, a], -1) };
        *borders.entry(edge).or_insert(0) += sign;
    };
    for (at, corners) in contour.caps.chunks(3).enumerate() {
        let away = at * 3 >= contour.caps_away_start;
        let [a, b, c] = if away {
            [corners[0], corners[2], corners[1]]
        } else {
            [corners[0], corners[1], corners[2]]
        };
        [(a, b), (b, c), (c, a)].into_iter().for_each(|(a, b)| add(a, b));
    }
    for [a, b] in contour.all_edges() {
        add(b, a);
    }
    borders.retain(|_, count| *count != 0);
    borders
}

#[test]
fn a_thousand_lights_on_above_and_below_surfaces_are_blocked_by_the_rest() {
    let mut random = Random::new(7);
    let (mut grazing, mut blocked, mut open, mut missed) = (0, 0, 0, 0);
    let meshes = meshes();
    for round in 0..1000 {
        let mesh = &meshes[round % meshes.len()];
        let positions = &mesh.positions;
        let at = |i: u32| positions[i as usize].as_dvec3();
        let (height, is_within) = HEIGHTS[round % HEIGHTS.len()];
        let edges = EdgeMesh::build(EdgeMeshInput {
            positions,
            indices: &mesh.indices,
            pose_keys: None,
            weld_epsilon: None,
        })
        .unwrap();
        let triangles: Vec<[DVec3; 3]> = edges.corners().iter().map(|corners| corners.map(at)).collect();
        let chosen = triangles[(random.unit() * triangles.len() as f64) as usize];
        let light = on_triangle(&mut random, chosen, height);
        let whole = RayScene::from_triangles(triangles.iter().copied());
        let clearance = whole.clearance(light, 20.0, u32::MAX);
        assert!(clearance > 1.5e-4 && clearance < 7e-4, "{clearance}");
        let mut planes = FacingPlanes::default();
        compute_planes(&edges, positions, &mut planes);
        let (mut bits, mut contour, mut grazed) = (FacingBits::default(), Contour::default(), Vec::new());
        let light_local = light.as_vec3().extend(1.0);
        classify(&edges, &planes, light_local, &mut bits);
        extract_contour(&edges, &bits, CapMode::AllTriangles, &mut contour);
        let before = contour.clone();
        let grazing_light = GrazingLight {
            light_world: light.extend(1.0),
            light_local,
            world_from_local: &DMat4::IDENTITY,
            clearance,
        };
        find_grazed(&edges, &planes, positions, &grazing_light, &mut grazed);
        take_out_of_contour(&edges, &bits, CapMode::AllTriangles, &grazed, &mut contour);
        assert!(borders(&contour).is_empty(), "round {round}: the volume is open");
        let touches = |corners: &[DVec3; 3]| distance_to_triangle(light, *corners) <= clearance;
        // What is off one surface may be on another.
        assert!(!is_within || triangles.iter().any(touches), "round {round}");
        grazing += usize::from(!grazed.is_empty());
        let rest = triangles.iter().filter(|corners| !touches(corners)).copied();
        let truth = RayScene::from_triangles(rest);
        let caps_of = |contour: &Contour| -> Vec<[DVec3; 3]> {
            contour
                .caps
                .chunks(3)
                .map(|c| [at(c[0]), at(c[1]), at(c[2])])
                .collect()
        };
        let scene = RayScene::from_triangles(caps_of(&contour));
        let with_all = RayScene::from_triangles(caps_of(&before));
        for _ in 0..32 {
            let point = random.point(4.0);
            // Each triangle of these scenes blocks, however near.
            let blocks = |scene: &RayScene| {
                scene
                    .segment_blocker(point, light, 0.0, None, u32::MAX, None)
                    .is_some()
            };
            let expected = blocks(&truth);
            let got = blocks(&scene);
            assert_eq!(got, expected, "round {round}: height {height}, {point}");
            // The ray caster follows the same rule.
            let by_rule = whole.blocks_segment(point, light, None, u32::MAX);
            assert_eq!(by_rule, expected, "round {round}: height {height}, {point}");
            blocked += usize::from(expected);
            open += usize::from(!expected);
            missed += usize::from(blocks(&with_all) != expected);
        }
    }
    assert!(
        grazing > 500 && blocked > 3000 && open > 3000,
        "{grazing} {blocked} {open}"
    );
    // With the triangles that the light touches, or is just behind, rounding would decide.
    assert!(missed > 100, "{missed}");
}

/// A room seen from within, with a table and a board that stands free, all of which lamps are set upon.
fn room() -> (crate::harness::support::stage::Stage, bevy_ecs::entity::Entity) {
    let mut stage = stage(
        Vec3::new(-3.4, 2.2, 3.3),
        Vec3::new(0.4, 0.9, 0.0),
        Camera {
            vertical_fov: 1.1,
            near: 0.05,
            ..Camera::default()
        },
    );
    for (half, at) in [
        (Vec3::new(4.0, 1.5, 4.0), Vec3::new(0.0, 1.5, 0.0)),
        (Vec3::new(0.8, 0.04, 0.5), Vec3::new(0.0, 0.8, 0.0)),
        (Vec3::new(0.05, 0.4, 0.05), Vec3::new(0.6, 0.38, 0.3)),
    ] {
        let place = Transform::from_translation(at);
        stage.world.spawn(object(MeshData::cuboid(half), place));
    }
    let board = Transform::from_xyz(1.8, 1.0, -0.6).with_rotation(glam::Quat::from_rotation_z(1.2));
    stage.world.spawn(object(MeshData::plane(1.4), board));
    let light = lamp(&mut stage, LightKind::Point, Vec3::Y, 20.0);
    (stage, light)
}

#[test]
fn pictures_of_lights_on_surfaces_are_those_of_rays() {
    let (mut stage, light) = room();
    let board = Vec3::new(1.8, 1.0, -0.6);
    let (mut shadowed, mut wrong) = (0, Vec::new());
    for at in [
        Vec3::new(0.3, 3.0, 0.4),
        Vec3::new(0.3, 2.999_999, 0.4),
        Vec3::new(0.3, 3.000_000_2, 0.4),
        Vec3::new(4.0, 1.7, 0.5),
        Vec3::new(4.0, 3.0, 0.5),
        Vec3::new(0.2, 0.84, 0.1),
        Vec3::new(0.8, 0.84, 0.1),
        Vec3::new(-2.0, 0.0, 0.7),
        board,
        Vec3::new(0.3, 2.99, 0.4),
    ] {
        stage
            .world
            .entity_mut(light)
            .insert(Transform::from_translation(at));
        for technique in HARD {
            set_technique(&mut stage, light, technique);
            let rendered = draw(&mut stage);
            let error = error_of(&mut stage, &rendered);
            if error.wrong_inner != 0 {
                wrong.push(format!(
                    "{technique} at {at}: {error:?}, {} dark",
                    dark(&rendered)
                ));
            }
            assert!(error.inner > 3000, "{technique} at {at}: {error:?}");
            shadowed += dark(&rendered);
        }
        set_technique(&mut stage, light, "map");
        let rendered = draw(&mut stage);
        let error = error_of(&mut stage, &rendered);
        if error.wrong_inner * 50 >= error.inner {
            wrong.push(format!("map at {at}: {error:?}"));
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
    assert!(shadowed > 10_000, "{shadowed}");
}

/// A lamp a hundredth of a millimetre behind a surface is free, whatever the size of the surface; a millimetre behind it, it
/// is not.
#[test]
fn lamps_ten_micrometres_behind_surfaces_shine_under_every_technique() {
    let (mut stage, light) = room();
    let places = |behind: f32| {
        [
            ("post", Vec3::new(0.65 - behind, 0.5, 0.3)),
            ("table", Vec3::new(-0.2, 0.84 - behind, 0.1)),
            ("ceiling", Vec3::new(0.3, 3.0 + behind, 0.4)),
        ]
    };
    let mut wrong = Vec::new();
    for (behind, seen) in [(1e-5, true), (1e-3, false)] {
        for (surface, at) in places(behind) {
            let place = Transform::from_translation(at);
            stage.world.entity_mut(light).insert(place);
            for technique in ["stencil", "wedges", "map", "perspective", "smoothie"] {
                set_technique(&mut stage, light, technique);
                let rendered = draw(&mut stage);
                let error = error_of(&mut stage, &rendered);
                let lit = rendered.visibility[0].iter().filter(|v| **v > 0.5).count();
                // Maps leave dark what is seen at less than two degrees past the surface.
                let is_map = !["stencil", "wedges"].contains(&technique);
                let allowed = if is_map { error.inner / 40 } else { 0 };
                let is_right = error.wrong_inner <= allowed && (lit > error.inner / 8) == seen;
                if !is_right {
                    let case = format!("{technique}, {behind} m behind the {surface}");
                    wrong.push(format!("{case}: {error:?}, {lit} lit"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_clearance_can_be_set() {
    let (mut stage, light) = room();
    set_technique(&mut stage, light, "stencil");
    // Five millimetres before the board.
    stage
        .world
        .entity_mut(light)
        .insert(Transform::from_xyz(1.8 - 0.00466, 1.00181, -0.6));
    let rendered = draw(&mut stage);
    assert_eq!(error_of(&mut stage, &rendered).wrong_inner, 0);
    stage.world.insert_resource(LightClearance(0.01));
    let generous = draw(&mut stage);
    assert!(error_of(&mut stage, &generous).wrong_inner > 300);
    assert!(dark(&generous) < dark(&rendered));
    stage.world.insert_resource(LightClearance::default());
    assert_eq!(draw(&mut stage).visibility, rendered.visibility);
}
