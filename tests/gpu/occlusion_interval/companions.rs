//! A second technique on the light: what is not in the maps casts on what is, and shows shadows itself.

use std::sync::Arc;

use antumbra::baking::{BakeSettings, bake_intervals};
use antumbra::prelude::*;
use antumbra::reference::{HitImage, RayScene, SurfaceHit};
use antumbra::reports::Reports;
use antumbra::scene::{PathPoint, ShadowSoftness};
use antumbra::sets::{CompanionOf, SetWork};
use antumbra::techniques::{IntervalLibrary, TextureMemory};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{DVec4, UVec2, Vec3, Vec4};

use super::faults::said;
use super::scenes::{TEXELS_PER_METRE, ladder, lit_ladder, maps, path, seen, settings, towards};
use crate::harness::own_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(128, 72);

/// One box hangs in the open, the other half below the roof.
const BOXES: [Vec3; 2] = [Vec3::new(0.95, 0.9, 0.9), Vec3::new(-0.8, 0.9, -0.25)];

const HALF: f32 = 0.3;

pub fn spawn_box(stage: &mut Stage, place: Vec3) -> Entity {
    let parts = (
        SceneMesh(Arc::new(MeshData::cuboid(Vec3::splat(HALF)))),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_translation(place),
    );
    stage.world.spawn(parts).id()
}

/// The ladder in the light of maps, with two boxes that are not in them.
pub fn with_boxes(time: f32, width: f32) -> Stage {
    let mut stage = lit_ladder(maps(), time, width);
    stage.world.insert_resource(ViewportSize(SIZE));
    for place in BOXES {
        spawn_box(&mut stage, place);
    }
    stage
}

/// Gives the only light of a stage a second technique.
pub fn add(stage: &mut Stage, second: impl Bundle) {
    let light = stage.lights[0];
    stage.world.entity_mut(light).insert(second);
}

pub fn visibility(stage: &mut Stage) -> Vec<f32> {
    stage.render().expect("the frame renders").visibility.remove(0)
}

/// Whether a point of the scene is on one of the boxes.
fn is_on_box(hit: &SurfaceHit) -> bool {
    BOXES.iter().any(|place| {
        let offset = (hit.position - place.as_dvec3()).abs();
        offset.max_element() < f64::from(HALF) + 1e-4
    })
}

/// What a pixel shows, where a hard shadow does not end within a texel of the maps.
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
        let (right, up) = hit.normal.any_orthonormal_pair();
        let mut around = [0.5, 1.0]
            .into_iter()
            .flat_map(|share| (0..9).map(move |i| (share, i)));
        let is_edge = around.any(|(share, i)| {
            let offset = right * f64::from(i % 3 - 1) + up * f64::from(i / 3 - 1);
            let position = hit.position + offset * (step * share);
            is_lit(&SurfaceHit { position, ..*hit }) != truth
        });
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

/// Adds the second technique of a light.
type Add = fn(&mut Stage);

const SECONDS: [(&str, Add); 4] = [
    ("shadow_map", |stage| add(stage, ShadowMap::default())),
    ("stencil_volume", |stage| add(stage, StencilVolume::default())),
    ("penumbra_wedge", |stage| add(stage, PenumbraWedge::default())),
    ("occlusion_texture", |stage| {
        let hard = OcclusionTexture {
            angle_deg: 0.1,
            resolution: 256,
            ..Default::default()
        };
        add(stage, hard);
    }),
];

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
        assert!(judged > 2000 && lit > 50 && dark > 20, "{judged} {lit} {dark}");
        assert!(without[0] > 40 && without[1] > 20, "alone {without:?} are wrong");
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
        BOXES.map(|place| spawn_box(&mut stage, place));
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

fn companions(stage: &mut Stage) -> usize {
    stage.world.query::<&CompanionOf>().iter(&stage.world).count()
}

#[test]
fn a_second_technique_comes_and_goes_with_its_light() {
    let mut stage = with_boxes(0.4, 0.02);
    let light = stage.lights[0];
    let alone = visibility(&mut stage);
    assert_eq!(companions(&mut stage), 0);
    let strangers = said(&stage);
    assert!(
        strangers.len() == 1 && strangers[0].starts_with("2 receivers are not in"),
        "{strangers:?}"
    );
    add(&mut stage, StencilVolume::default());
    let with_stencil = visibility(&mut stage);
    assert_eq!(companions(&mut stage), 2);
    assert_eq!(said(&stage), [] as [String; 0]);
    assert!(with_stencil != alone);
    stage
        .world
        .entity_mut(light)
        .remove::<StencilVolume>()
        .insert(ShadowMap::default());
    let with_map = visibility(&mut stage);
    assert!(with_map != alone);
    assert!(with_map != with_stencil);
    // Settings are followed.
    let coarse = ShadowMap {
        resolution: antumbra::techniques::MapResolution::Fixed(64),
        ..Default::default()
    };
    stage.world.entity_mut(light).insert(coarse);
    assert!(visibility(&mut stage) != with_map);
    stage.world.entity_mut(light).insert(ShadowMap::default());
    assert!(visibility(&mut stage) == with_map);
    // A third one has no effect.
    stage.world.entity_mut(light).insert(StencilVolume::default());
    assert_eq!(
        visibility(&mut stage),
        with_stencil,
        "the first of the list is used"
    );
    let reports = said(&stage);
    assert!(
        reports.len() == 1
            && reports[0].contains("3 shadow techniques")
            && reports[0].contains("OcclusionInterval and StencilVolume are used"),
        "{reports:?}"
    );
    stage
        .world
        .entity_mut(light)
        .remove::<(StencilVolume, ShadowMap)>();
    assert!(visibility(&mut stage) == alone);
    assert_eq!((companions(&mut stage), said(&stage)), (0, strangers));
    // Without maps the other technique is the technique of the light.
    add(&mut stage, StencilVolume::default());
    let kept = stage
        .world
        .entity_mut(light)
        .take::<OcclusionInterval>()
        .expect("it has maps");
    let of_volumes = visibility(&mut stage);
    assert_eq!(companions(&mut stage), 0);
    stage.world.entity_mut(light).insert(kept);
    assert!(visibility(&mut stage) == with_stencil);
    assert!(of_volumes != with_stencil);
    assert_eq!(companions(&mut stage), 2);
    stage.world.despawn(light);
    stage.lights.clear();
    stage.render().expect("the frame renders");
    assert_eq!(companions(&mut stage), 0, "they go with the light");
}

#[test]
fn without_usable_maps_the_second_technique_shadows_everything() {
    let mut plain = with_boxes(0.4, 0.0);
    let light = plain.lights[0];
    add(&mut plain, StencilVolume::default());
    visibility(&mut plain); // the maps' technique puts the light on its path
    plain.world.entity_mut(light).remove::<OcclusionInterval>();
    let all = visibility(&mut plain);
    let mut stage = with_boxes(0.4, 0.0);
    add(&mut stage, StencilVolume::default());
    let both = visibility(&mut stage);
    assert!(both != all, "shadows of maps have texels");
    let kept = maps();
    stage.world.resource_mut::<IntervalLibrary>().forget("ladder");
    assert!(visibility(&mut stage) == all, "the maps cannot be read");
    let reports = said(&stage);
    assert!(
        reports.len() == 1 && reports[0].starts_with("The light's other technique alone shadows it"),
        "{reports:?}"
    );
    let of_light = stage
        .world
        .resource::<Reports>()
        .of_entity(stage.lights[0])
        .count();
    assert_eq!(of_light, 1, "the report is about the light of the scene");
    stage
        .world
        .resource_mut::<IntervalLibrary>()
        .insert("ladder", kept);
    assert!(visibility(&mut stage) == both);
    // Memory is known to be short from the second frame on.
    stage.world.resource_mut::<TextureMemory>().limit = 1000;
    visibility(&mut stage);
    assert!(visibility(&mut stage) == all, "there is no memory for the maps");
    assert!(visibility(&mut stage) == all, "and it stays so");
    stage.world.resource_mut::<TextureMemory>().limit = 1 << 30;
    visibility(&mut stage);
    assert!(visibility(&mut stage) == both);
    // A light that maps cannot shadow.
    let broken = OcclusionInterval {
        maps: String::new(),
        ..settings(0.4, 0.0)
    };
    stage.world.entity_mut(stage.lights[0]).insert(broken);
    assert!(visibility(&mut stage) == all, "the maps are not named");
    visibility(&mut stage);
    let mended = settings(0.4, 0.0);
    stage.world.entity_mut(stage.lights[0]).insert(mended);
    assert!(visibility(&mut stage) == both, "they are named again");
}

#[test]
fn a_second_technique_that_does_not_fit_is_reported_about_the_light() {
    let mut stage = with_boxes(0.4, 0.0);
    let alone = visibility(&mut stage);
    add(&mut stage, OmniMap::default());
    assert!(visibility(&mut stage) == alone);
    let light = stage.lights[0];
    let reports: Vec<String> = {
        let reports = stage.world.resource::<Reports>();
        reports
            .of_entity(light)
            .map(|report| report.message.clone())
            .collect()
    };
    let about = |what: &str| reports.iter().filter(|report| report.contains(what)).count();
    assert_eq!(
        (about("OmniMap does not fit"), reports.len()),
        (1, 2),
        "{reports:?}"
    );
    assert_eq!(
        about("are not in the light's maps"),
        1,
        "nothing shadows them: {reports:?}"
    );
}

#[test]
fn a_frame_at_rest_writes_and_computes_nothing() {
    for (name, add) in SECONDS {
        let mut stage = with_boxes(0.4, 0.0);
        stage
            .add_renderer(
                own_context(RequestedFeatures::default()),
                RenderSettings::default(),
            )
            .expect("shaders compose");
        add(&mut stage);
        for _ in 0..3 {
            visibility(&mut stage);
        }
        let state = |stage: &mut Stage| {
            let pipelines = stage.world.resource::<Renderer>().pipelines_created();
            let work = *stage.world.resource::<SetWork>();
            let generation = stage.world.resource::<FrameLights>().generation;
            let mut companions = stage.world.query::<(Entity, Ref<CompanionOf>)>();
            let mut ticks: Vec<_> = companions
                .iter(&stage.world)
                .map(|(entity, of)| (entity, *of, of.last_changed().get()))
                .collect();
            ticks.sort_unstable_by_key(|(entity, ..)| *entity);
            (pipelines, work, generation, ticks)
        };
        let before = state(&mut stage);
        let first = visibility(&mut stage);
        let second = visibility(&mut stage);
        assert_eq!(state(&mut stage), before, "{name}");
        assert!(first == second, "{name}");
        let lights = stage.world.resource::<FrameLights>();
        let recomputed = lights
            .lights
            .iter()
            .any(|light| light.moved || light.is_recomputed());
        assert!(!recomputed, "{name}: nothing moved");
        let moving = stage
            .world
            .query_filtered::<Entity, With<SceneMesh>>()
            .iter(&stage.world)
            .last();
        let place = Transform::from_translation(BOXES[1] + Vec3::X * 0.1);
        stage.world.entity_mut(moving.expect("a box")).insert(place);
        assert!(visibility(&mut stage) != first, "{name}");
        assert_ne!(state(&mut stage).1, before.1, "{name}: a box moved");
    }
}

#[test]
fn companions_are_no_lights_of_the_scene() {
    let mut stage = with_boxes(0.4, 0.0);
    let mut of_frame = |second: bool| {
        if second {
            add(&mut stage, ShadowMap::default());
        }
        stage.render().expect("the frame renders");
        let lights = stage.world.resource::<FrameLights>();
        let companions = lights.companions_of(stage.lights[0]).count();
        let drawn = stage.world.resource::<Renderer>().frame().lights.len();
        (lights.of_scene().len(), drawn, companions)
    };
    assert_eq!(of_frame(false), (1, 1, 0));
    assert_eq!(of_frame(true), (1, 1, 2));
    let lights = stage.world.query::<&Light>().iter(&stage.world).count();
    assert_eq!(lights, 1);
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
