//! Shadows of both techniques against rays.

use std::sync::Arc;

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, SurfaceHit};
use antumbra::scene::{PathPoint, ShadowSoftness};
use bevy_transform::prelude::Transform;
use glam::{DVec4, Vec3, Vec4};

use super::{Add, BOXES, SECONDS, SIZE, add, is_on_box, spawn_box, visibility, with_boxes};
use crate::harness::support::stage::Stage;
use crate::occlusion_interval::faults::said;
use crate::occlusion_interval::scenes::{
    TEXELS_PER_METRE, around, ladder, lit_ladder, maps, path, seen, towards,
};

/// The truth of one pixel. Pixels within a texel of the end of a hard shadow have none.
#[derive(Clone, Copy)]
struct Truth {
    is_lit: bool,
    is_on_box: bool,
}

/// Truth of a light at a homogeneous point: a position with `w = 1`, or the direction towards it with `w = 0`.
fn hard_truth(scene: &RayScene, hits: &HitImage, light: DVec4) -> Vec<Option<Truth>> {
    let step = 1.0 / f64::from(TEXELS_PER_METRE);
    let towards = |hit: &SurfaceHit| light.truncate() - hit.position * light.w;
    let is_lit = |hit: &SurfaceHit| {
        let (at, triangle) = (hit.position, Some(hit.triangle));
        let is_blocked = if light.w == 0.0 {
            scene.blocks_direction(at, light.truncate(), triangle, u32::MAX)
        } else {
            scene.blocks_segment(at, light.truncate(), triangle, u32::MAX)
        };
        hit.normal.dot(towards(hit)) > 0.0 && !is_blocked
    };
    let of_hit = |hit: &Option<SurfaceHit>| {
        let faces = |hit: &&SurfaceHit| hit.normal.dot(towards(hit).normalize()) > 0.05;
        let hit = hit.as_ref().filter(faces)?;
        let truth = is_lit(hit);
        let is_edge = around(hit, step).any(|other| is_lit(&other) != truth);
        let is_on_box = is_on_box(hit);
        (!is_edge).then_some(Truth {
            is_lit: truth,
            is_on_box,
        })
    };
    hits.hits.iter().map(of_hit).collect()
}

/// Pixels whose visibility is wrong: on surfaces in the maps, and on boxes.
fn wrong(truth: &[Option<Truth>], drawn: &[f32]) -> [usize; 2] {
    let mut wrong = [0; 2];
    for (truth, drawn) in truth.iter().zip(drawn) {
        if let Some(truth) = truth {
            let expected = f32::from(u8::from(truth.is_lit));
            wrong[usize::from(truth.is_on_box)] += usize::from((expected - drawn).abs() > 0.5);
        }
    }
    wrong
}

#[test]
fn hard_shadows_of_both_are_those_of_all_casters_on_all_receivers() {
    for time in [0.4, 0.55] {
        let mut stage = with_boxes(time, 0.0);
        let alone = visibility(&mut stage);
        let (scene, hits) = seen(&mut stage);
        let truth = hard_truth(&scene, &hits, towards(&path(), time).extend(0.0));
        let judged = truth.iter().flatten().count();
        let on_box = truth.iter().flatten().filter(|truth| truth.is_on_box);
        let [lit, dark] =
            [true, false].map(|is_lit| on_box.clone().filter(|truth| truth.is_lit == is_lit).count());
        let without = wrong(&truth, &alone);
        println!("{time}: {judged} judged, {lit} lit and {dark} dark on boxes, {without:?} wrong alone");
        assert!(judged > 2000 && lit > 50 && dark > 10, "{judged} {lit} {dark}");
        assert!(without[0] > 40 && without[1] > 10, "alone {without:?} are wrong");
        for (name, add) in SECONDS {
            let mut stage = with_boxes(time, 0.0);
            add(&mut stage);
            let wrong = wrong(&truth, &visibility(&mut stage));
            println!("{time} {name}: {wrong:?} wrong");
            assert!(
                wrong.iter().all(|wrong| wrong * 1000 <= judged),
                "{time} {name}: {wrong:?}"
            );
            // The sun has no size, which wedges say of the light once.
            let reports = said(&stage);
            let is_hard = |report: &String| report.starts_with("PenumbraWedge gives a hard shadow");
            let expected = usize::from(name == "penumbra_wedge");
            assert!(
                reports.len() == expected && reports.iter().all(is_hard),
                "{name}: {reports:?}"
            );
        }
    }
}

/// Soft techniques beside it, too: the light is a lamp that moves along a line.
#[test]
fn lamps_on_a_line_have_second_techniques() {
    let line = LightPath::Positions(vec![Vec3::new(1.4, 2.8, 1.6), Vec3::new(-1.4, 2.8, 1.6)]);
    let bake = BakeSettings {
        texels_per_metre: TEXELS_PER_METRE,
        ..Default::default()
    };
    let bake = bake_intervals(&mut ladder().world, &line, &bake, |_| ()).expect("it is baked");
    let maps = Arc::new(bake.maps);
    let time = 0.3;
    let lamp = |second: Add| {
        let mut stage = lit_ladder(maps.clone(), time, 0.0);
        stage.world.insert_resource(ViewportSize(SIZE));
        for place in BOXES {
            spawn_box(&mut stage, place);
        }
        let light = stage.lights[0];
        let bulb = Light::point(Vec3::ONE, 30.0, 30.0);
        stage.world.entity_mut(light).insert(bulb);
        second(&mut stage);
        let drawn = visibility(&mut stage);
        (stage, drawn)
    };
    let (mut stage, alone) = lamp(|_| ());
    let (scene, hits) = seen(&mut stage);
    let PathPoint::Position(position) = line.at(time) else {
        panic!("a line has positions");
    };
    let truth = hard_truth(&scene, &hits, position.as_dvec3().extend(1.0));
    let judged = truth.iter().flatten().count();
    let without = wrong(&truth, &alone);
    println!("{judged} judged, {without:?} wrong alone");
    assert!(judged > 2000 && without[0] > 40, "alone {without:?} are wrong");
    let seconds: [(&str, Add); 3] = [
        ("omni_map", |stage| add(stage, OmniMap::default())),
        ("stencil_volume", |stage| add(stage, StencilVolume::default())),
        ("penumbra_wedge", |stage| {
            add(stage, (PenumbraWedge::default(), ShadowSoftness(0.02)));
        }),
    ];
    for (name, second) in seconds {
        let (stage, drawn) = lamp(second);
        let wrong = wrong(&truth, &drawn);
        println!("{name}: {wrong:?} wrong");
        assert!(
            wrong.iter().all(|wrong| wrong * 500 <= judged),
            "{name}: {wrong:?}"
        );
        assert_eq!(said(&stage), [] as [String; 0], "{name}");
    }
}

#[test]
fn surfaces_in_the_maps_are_never_brighter_and_the_same_where_nothing_moves_in_reach() {
    let mut stage = with_boxes(0.4, 0.2);
    let alone = visibility(&mut stage);
    let (_, hits) = seen(&mut stage);
    add(&mut stage, ShadowMap::default());
    let both = visibility(&mut stage);
    let on_maps = |at: &usize| hits.hits[*at].as_ref().is_some_and(|hit| !is_on_box(hit));
    let (mut darker, mut same_soft) = (0, 0);
    for at in (0..alone.len()).filter(on_maps) {
        assert!(
            both[at] <= alone[at] || alone[at] == 1.0,
            "{at}: {} {}",
            both[at],
            alone[at]
        );
        darker += usize::from(both[at] < alone[at]);
        same_soft += usize::from(both[at] == alone[at] && (0.05..0.95).contains(&both[at]));
    }
    println!("{darker} darker, {same_soft} soft ones are the same");
    assert!(darker > 40 && same_soft > 40, "{darker} {same_soft}");
    // Without anything that is not in the maps, the second technique has nothing to do.
    let mut still = lit_ladder(maps(), 0.4, 0.2);
    still.render().expect("the frame renders");
    let bytes = |stage: &Stage| stage.radiance_bytes().expect("the radiance is read");
    let before = bytes(&still);
    for (name, add) in SECONDS {
        let mut stage = lit_ladder(maps(), 0.4, 0.2);
        add(&mut stage);
        let far = spawn_box(&mut stage, Vec3::new(0.0, 0.5, 60.0));
        stage.render().expect("the frame renders");
        assert!(bytes(&stage) == before, "{name}: nothing moves in reach");
        stage
            .world
            .entity_mut(far)
            .insert(Transform::from_translation(BOXES[0]));
        stage.render().expect("the frame renders");
        assert!(bytes(&stage) != before, "{name}: the comparison can fail");
    }
}

#[test]
fn panes_show_the_shadows_of_both() {
    let pane = |stage: &mut Stage| {
        stage.world.spawn((
            SceneMesh(Arc::new(MeshData::cuboid(Vec3::new(0.5, 0.01, 0.5)))),
            SceneMaterials(
                [Arc::new(Material {
                    base_color: Vec4::new(0.3, 0.8, 0.4, 0.5),
                    alpha_mode: AlphaMode::Blend,
                    ..Material::matte(Vec3::ONE)
                })]
                .into(),
            ),
            ShadowReceiver,
            Transform::from_xyz(0.5, 0.35, 0.4),
        ));
    };
    let dark = |add: Add| {
        let mut stage = with_boxes(0.4, 0.0);
        pane(&mut stage);
        add(&mut stage);
        let drawn = visibility(&mut stage);
        let (_, hits) = seen(&mut stage);
        let is_pane = |hit: &SurfaceHit| (hit.position.y - 0.36).abs() < 1e-3 && hit.normal.y > 0.9;
        let on_pane = hits.hits.iter().zip(&drawn);
        on_pane
            .filter(|(hit, drawn)| hit.as_ref().is_some_and(is_pane) && **drawn < 0.5)
            .count()
    };
    let without = dark(|_| ());
    let with = SECONDS.map(|(_, add)| dark(add));
    println!("{without} dark pixels on the pane alone, {with:?} with another technique");
    assert_eq!(without, 0);
    assert!(with.iter().all(|with| *with > 20), "{with:?}");
    assert!(with[0].abs_diff(with[1]) < 15, "{with:?}");
}
