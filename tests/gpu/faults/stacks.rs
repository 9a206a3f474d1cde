//! Many casters one behind the other, casters that are inside out in part, and groups in any order.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{LightSource, RayScene, primary_hits, soft_visibility};
use antumbra::reports::Reports;
use antumbra::scene::Skin;
use antumbra::sets::FrameLights;
use antumbra::silhouettes::Silhouettes;
use antumbra::techniques::PenumbraWedge;
use antumbra::techniques::penumbra_wedge::{MOST_STACKED as MOST_UNDER_WEDGES, Overlap, VisibilityBuffer};
use antumbra::techniques::stencil_volume::{Counting, MOST_STACKED, StencilVolumes};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::{GlobalTransform, Transform};
use glam::{Mat4, Quat, Vec3, Vec4};

use super::scenes::{SIZE, dark, draw, error_of, ground, lamp, object, set_technique};
use crate::harness::support::stage::Stage;

/// Thin boxes, or cards, one above the other.
fn stack(stage: &mut Stage, count: usize, boxes: bool) -> Vec<Entity> {
    let mesh = if boxes {
        MeshData::cuboid(Vec3::new(0.5, 0.002, 0.4))
    } else {
        MeshData::plane(0.45)
    };
    let mesh = Arc::new(mesh);
    let place = |i: usize| Transform::from_xyz(0.0, 1.0 + 0.004 * i as f32, 0.0);
    (0..count)
        .map(|i| {
            let id = stage.world.spawn(object(MeshData::default(), place(i))).id();
            stage.world.entity_mut(id).insert(SceneMesh(mesh.clone()));
            id
        })
        .collect()
}

fn stacked(stage: &Stage, light: Entity) -> u32 {
    let silhouettes = stage.world.resource::<Silhouettes>();
    silhouettes.of_light(light).unwrap().stacked
}

#[test]
fn any_number_of_sheets_shadows_under_volumes() {
    for boxes in [false, true] {
        let mut stage = ground();
        let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.3, 5.0, 0.2), 30.0);
        for technique in ["stencil", "stencil to infinity"] {
            set_technique(&mut stage, light, technique);
            let mut last = 0;
            for count in [1, 127, 128, 129, 256] {
                let sheets = stack(&mut stage, count, boxes);
                let rendered = draw(&mut stage);
                let error = error_of(&mut stage, &rendered);
                assert_eq!(error.wrong_inner, 0, "{count} sheets, {technique}: {error:?}");
                assert!(dark(&rendered) > 150, "{count} sheets, {technique}");
                let now = stacked(&stage, light);
                assert!(
                    now >= count as u32 && now <= 2 * count as u32 + 1,
                    "{now} of {count}"
                );
                assert!(now > last);
                last = now;
                for sheet in sheets {
                    stage.world.despawn(sheet);
                }
            }
            assert!(last > MOST_STACKED);
        }
    }
}

/// Root mean square error in the first light's penumbra on the ground, and the pixels in it.
fn penumbra_error(stage: &mut Stage) -> (f64, usize) {
    let rendered = draw(stage);
    let scene = RayScene::from_world(&mut stage.world);
    let camera = stage.world.get::<Camera>(stage.camera).unwrap();
    let place = stage.world.get::<GlobalTransform>(stage.camera).unwrap();
    let hits = primary_hits(&scene, camera, place, SIZE).unwrap();
    let source = LightSource::of_entity(&stage.world, stage.lights[0]).unwrap();
    let truth = soft_visibility(&scene, &hits, &source, 256, 1);
    let (mut sum, mut count) = (0.0, 0);
    for ((truth, got), hit) in truth.values().iter().zip(&rendered.visibility[0]).zip(&hits.hits) {
        let is_ground = hit.is_some_and(|hit| hit.position.y < 1e-3);
        if is_ground && *truth > 0.02 && *truth < 0.98 {
            sum += f64::from(truth - got).powi(2);
            count += 1;
        }
    }
    ((sum / count as f64).sqrt(), count)
}

#[test]
fn penumbrae_of_stacks_are_those_of_rays() {
    let mut stage = ground();
    let kind = LightKind::Sphere { radius: 0.5 };
    let light = lamp(&mut stage, kind, Vec3::new(0.2, 4.0, 0.3), 30.0);
    set_technique(&mut stage, light, "wedges");
    let mut first = 0.0;
    let mut errors = Vec::new();
    for count in [1usize, 8, 30, 31, 32, 33, 48, 64, 96, 128, 200, 250] {
        let sheets = stack(&mut stage, count, false);
        let (error, pixels) = penumbra_error(&mut stage);
        println!("{count} sheets: {error:.4} over {pixels} pixels");
        assert!(pixels > 150, "{count}: {pixels}");
        errors.push((count, error));
        if count == 1 {
            first = error;
        }
        assert!(stacked(&stage, light) >= count as u32 && stacked(&stage, light) <= MOST_UNDER_WEDGES);
        for sheet in sheets {
            stage.world.despawn(sheet);
        }
    }
    assert!(first < 0.03, "{first}");
    assert!(errors.iter().all(|(_, error)| *error < 0.06), "{errors:?}");
    // More than there is room for is said.
    stack(&mut stage, 300, false);
    draw(&mut stage);
    assert!(stacked(&stage, light) > MOST_UNDER_WEDGES);
}

fn reports_of(stage: &Stage, entity: Entity) -> Vec<String> {
    let reports = stage.world.resource::<Reports>().of_entity(entity);
    reports.map(|report| report.message.clone()).collect()
}

#[test]
fn stacks_that_cannot_be_counted_are_reported() {
    let mut stage = ground();
    let kind = LightKind::Sphere { radius: 0.5 };
    let light = lamp(&mut stage, kind, Vec3::new(0.2, 4.0, 0.3), 30.0);
    set_technique(&mut stage, light, "wedges");
    for (count, is_reported) in [(250, false), (255, true), (300, true)] {
        let sheets = stack(&mut stage, count, true);
        stage.schedule.run(&mut stage.world);
        let reported = reports_of(&stage, light);
        let is_said = reported
            .iter()
            .any(|message| message.contains("one behind the other"));
        assert_eq!(is_said, is_reported, "{count}: {reported:?}");
        for sheet in sheets {
            stage.world.despawn(sheet);
        }
    }
    // Sums of half floats count nothing.
    let sheets = stack(&mut stage, 300, true);
    stage.world.entity_mut(light).insert(PenumbraWedge {
        buffer: VisibilityBuffer::Half,
        ..PenumbraWedge::default()
    });
    stage.schedule.run(&mut stage.world);
    let reported = reports_of(&stage, light);
    assert!(reported.is_empty(), "{reported:?}");
    for sheet in sheets {
        stage.world.despawn(sheet);
    }
    // One mesh of many sheets, which no round of counting can divide.
    set_technique(&mut stage, light, "stencil");
    for (count, is_reported) in [(127u32, false), (128, true)] {
        let sheet = MeshData::cuboid(Vec3::new(0.5, 0.002, 0.4));
        let (mut positions, mut indices) = (Vec::new(), Vec::new());
        for i in 0..count {
            indices.extend(sheet.indices.iter().map(|index| index + positions.len() as u32));
            let raised = sheet
                .positions
                .iter()
                .map(|at| *at + Vec3::Y * (1.0 + 0.005 * i as f32));
            positions.extend(raised);
        }
        let mesh = MeshData::from_triangles("sheets", positions, indices);
        let caster = stage.world.spawn(object(mesh, Transform::IDENTITY)).id();
        stage.schedule.run(&mut stage.world);
        let reported = reports_of(&stage, caster);
        assert_eq!(!reported.is_empty(), is_reported, "{count}: {reported:?}");
        stage.world.despawn(caster);
    }
}

#[test]
fn stacked_casters_are_counted_again_when_others_take_their_place_or_they_move() {
    let mut stage = ground();
    let light = Light {
        kind: LightKind::Directional,
        color: Vec3::ONE,
        intensity: 3.0,
        range: f32::INFINITY,
    };
    let down = Transform::default().looking_to(Vec3::NEG_Y, Vec3::X);
    let light = stage.spawn_light(light, down, Some(StencilVolume::default()));
    let mesh = Arc::new(MeshData::cuboid(Vec3::new(0.2, 0.01, 0.2)));
    let sheet = |stage: &mut Stage, at: Vec3| {
        let id = stage
            .world
            .spawn(object(MeshData::default(), Transform::from_translation(at)))
            .id();
        stage.world.entity_mut(id).insert(SceneMesh(mesh.clone()));
        id
    };
    let piled: Vec<Entity> = (0..8)
        .map(|i| sheet(&mut stage, Vec3::new(-30.0, 0.5 + 0.1 * i as f32, 0.0)))
        .collect();
    for i in 0..8 {
        sheet(&mut stage, Vec3::new(30.0 + 0.5 * i as f32, 0.5, 0.0));
    }
    let camera = stage.camera;
    let counted = |stage: &mut Stage, x: f32| {
        let above = Transform::from_xyz(x, 12.0, 0.0).looking_to(Vec3::NEG_Y, Vec3::X);
        stage.world.entity_mut(camera).insert(above);
        stage.schedule.run(&mut stage.world);
        let lights = &stage.world.resource::<FrameLights>().lights;
        (lights[0].sets.s.count_ones(..), stacked(stage, light))
    };
    // Both sets S have as many members, and their silhouettes are known from the second frame on.
    let over_pile = counted(&mut stage, -30.0);
    let over_row = counted(&mut stage, 31.75);
    assert!(
        over_pile.0 == over_row.0 && over_pile.0 >= 8,
        "{over_pile:?} {over_row:?}"
    );
    assert!(over_pile.1 >= 8 && over_row.1 <= 3, "{over_pile:?} {over_row:?}");
    assert_eq!(counted(&mut stage, -30.0), over_pile);
    // Under a directional light, the silhouette of a caster that moves stays.
    for (i, &sheet) in piled.iter().enumerate() {
        let beside = Transform::from_xyz(-30.0 + 0.5 * i as f32, 0.5, 0.0);
        stage.world.entity_mut(sheet).insert(beside);
    }
    assert!(counted(&mut stage, -28.25).1 <= 3);
}

/// One closed piece of which the far end is turned inside out: its volume is that of the near end.
fn twisted() -> MeshData {
    let ring = |z: f32, x: f32| {
        [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
            .map(|(a, b): (f32, f32)| Vec3::new(0.4 * a * x, 0.4 * b, z))
    };
    let positions = ring(-0.8, 1.0).into_iter().chain(ring(0.6, -0.8)).collect();
    let mut indices = vec![0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7];
    for i in 0..4 {
        let j = (i + 1) % 4;
        indices.extend([i, j, j + 4, i, j + 4, i + 4]);
    }
    MeshData::from_triangles("twisted", positions, indices)
}

fn depth_passes(stage: &Stage) -> usize {
    let volumes = stage.world.resource::<StencilVolumes>();
    volumes
        .lights
        .iter()
        .flat_map(|light| &light.casters)
        .filter(|volume| volume.depth_pass)
        .count()
}

#[test]
fn caps_that_are_seen_are_drawn() {
    let mut stage = ground();
    stage.world.insert_resource(FaceCulling::SingleSided);
    let light = lamp(&mut stage, LightKind::Point, Vec3::new(0.4, 4.0, -1.5), 30.0);
    let both = |stage: &mut Stage| {
        let mut entity = stage.world.entity_mut(light);
        entity.insert(StencilVolume::default());
        let auto = draw(stage);
        let passes = depth_passes(stage);
        stage.world.entity_mut(light).insert(StencilVolume {
            counting: Counting::DepthFail,
            ..StencilVolume::default()
        });
        let fail = draw(stage);
        assert_eq!(depth_passes(stage), 0);
        assert!(dark(&fail) > 200);
        let pairs = auto.visibility[0].iter().zip(&fail.visibility[0]);
        (passes, pairs.filter(|(a, b)| a != b).count())
    };
    // A healthy box is counted towards the viewer, which is right.
    let place = Transform::from_xyz(0.0, 1.0, 0.5);
    let healthy = stage
        .world
        .spawn(object(MeshData::cuboid(Vec3::splat(0.5)), place))
        .id();
    assert_eq!(both(&mut stage), (1, 0));
    stage.world.despawn(healthy);
    for turn in 0..4 {
        let rotation = Quat::from_rotation_y(turn as f32 * 0.7);
        let one = stage
            .world
            .spawn(object(twisted(), place.with_rotation(rotation)))
            .id();
        assert_eq!(both(&mut stage).1, 0, "turned by {turn}");
        stage.world.despawn(one);
    }
    // Two boxes of one mesh, of which a joint mirrors one.
    let mut mesh = MeshData::cuboid(Vec3::splat(0.4));
    mesh.joints = vec![[0; 4]; mesh.positions.len()];
    mesh.joint_weights = vec![Vec4::X; mesh.positions.len()];
    for scale in [Vec3::ONE, Vec3::new(-1.0, 1.0, 1.0)] {
        let joint = stage.world.spawn(place.with_scale(scale)).id();
        let skin = Skin {
            joints: vec![joint],
            inverse_bind: [Mat4::IDENTITY].into(),
        };
        let one = stage
            .world
            .spawn((object(mesh.clone(), Transform::IDENTITY), skin))
            .id();
        assert_eq!(both(&mut stage).1, 0, "a joint of scale {scale}");
        stage.world.despawn(one);
    }
}

#[test]
fn groups_of_the_paper_are_combined_in_any_order() {
    let picture = |order: [usize; 4]| {
        let mut stage = ground();
        let kind = LightKind::Sphere { radius: 0.5 };
        let light = lamp(&mut stage, kind, Vec3::new(0.2, 4.0, 0.3), 30.0);
        stage.world.entity_mut(light).insert(PenumbraWedge {
            overlap: Overlap::Paper,
            ..PenumbraWedge::default()
        });
        for i in order {
            let at = Vec3::new(-0.3 + 0.25 * i as f32, 0.8 + 0.25 * i as f32, 0.15 * i as f32);
            let mesh = MeshData::cuboid(Vec3::new(0.3 + 0.05 * i as f32, 0.02, 0.4));
            stage.world.spawn(object(mesh, Transform::from_translation(at)));
        }
        draw(&mut stage).visibility.remove(0)
    };
    let first = picture([0, 1, 2, 3]);
    let soft = first.iter().filter(|value| **value > 0.1 && **value < 0.9);
    assert!(soft.count() > 500);
    for order in [[3, 2, 1, 0], [1, 3, 0, 2], [2, 0, 3, 1]] {
        let other = picture(order);
        let largest = first
            .iter()
            .zip(&other)
            .map(|(a, b)| (a - b).abs())
            .fold(0.0, f32::max);
        assert!(largest < 0.005, "{order:?}: {largest}");
    }
}
