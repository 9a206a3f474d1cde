//! Scenes and files that do not fit are refused, said, and lose no frame.

use std::sync::Arc;

use antumbra::baking::{BakeError, BakeNote, BakeSettings, bake_intervals, bake_into};
use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::scene::ShadowOrigin;
use antumbra::techniques::occlusion_interval::IntervalScenes;
use antumbra::techniques::{IntervalLibrary, TextureMemory};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::scenes::{SIZE, add_light, ladder, lit_ladder, maps, settings, spawn};
use crate::harness::support::stage::Stage;

pub fn said(stage: &Stage) -> Vec<String> {
    let reports = stage.world.resource::<Reports>();
    let own = reports.iter().filter(|report| report.topic != "renderer");
    own.map(|report| report.message.clone()).collect()
}

pub fn dark(stage: &mut Stage) -> usize {
    let rendered = stage.render().expect("the frame renders");
    rendered.visibility[0].iter().filter(|&&v| v < 0.5).count()
}

#[test]
fn maps_of_another_scene_are_refused_until_it_is_back() {
    let mut stage = lit_ladder(maps(), 0.3, 0.02);
    let shadowed = dark(&mut stage);
    assert!(shadowed > 50, "{shadowed}");
    assert_eq!(said(&stage), [] as [String; 0]);
    let mut query = stage
        .world
        .query_filtered::<(Entity, &Transform), With<SceneMesh>>();
    let (moved, place) = query
        .iter(&stage.world)
        .map(|(entity, place)| (entity, *place))
        .max_by(|a, b| a.1.translation.y.total_cmp(&b.1.translation.y))
        .expect("the roof");
    stage
        .world
        .entity_mut(moved)
        .insert(Transform::from_xyz(0.0, 0.01, 0.0) * place);
    assert_eq!(dark(&mut stage), 0, "the light shines unshadowed");
    let reports = said(&stage);
    assert!(
        reports.len() == 1 && reports[0].contains("1 of the 9 surfaces"),
        "{reports:?}"
    );
    assert!(reports[0].contains("bake the maps again"));
    stage.world.entity_mut(moved).insert(place);
    assert_eq!(dark(&mut stage), shadowed, "and back");
    assert_eq!(said(&stage), [] as [String; 0]);
    stage.world.despawn(moved);
    assert_eq!(dark(&mut stage), 0);
}

#[test]
fn maps_are_refused_while_others_block_the_light_than_when_they_were_baked() {
    let mut stage = lit_ladder(maps(), 0.3, 0.02);
    let shadowed = dark(&mut stage);
    let mut casters = stage
        .world
        .query_filtered::<Entity, (With<SceneMesh>, With<ShadowCaster>)>();
    let caster = casters.iter(&stage.world).next().expect("a caster");
    let mut lights = stage.world.query_filtered::<Entity, With<Light>>();
    let light = lights.iter(&stage.world).next().expect("the light");
    let refused = |stage: &mut Stage, why: &str| {
        assert_eq!(dark(stage), 0, "{why}: the light shines unshadowed");
        let reports = said(stage);
        assert!(
            reports.len() == 1 && reports[0].contains("whether they block the light"),
            "{why}: {reports:?}"
        );
    };
    stage.world.entity_mut(caster).remove::<ShadowCaster>();
    refused(&mut stage, "one casts no longer");
    stage
        .world
        .entity_mut(caster)
        .insert((ShadowCaster, SelectionLayers(2)));
    assert_eq!(dark(&mut stage), shadowed, "it casts again, on another layer");
    let casts_for = |casts_for: u32| LightSelection {
        casts_for,
        ..LightSelection::default()
    };
    stage.world.entity_mut(light).insert(casts_for(!2));
    refused(&mut stage, "the light leaves it out");
    stage.world.entity_mut(light).insert(casts_for(3));
    assert_eq!(dark(&mut stage), shadowed, "the mask differs, the casters do not");
    assert_eq!(said(&stage), [] as [String; 0]);
    stage
        .world
        .entity_mut(light)
        .insert(ShadowOrigin::Direction(Vec3::NEG_Y));
    assert_eq!(dark(&mut stage), shadowed, "shadows stay where they were baked");
    let reports = said(&stage);
    assert!(reports.len() == 1 && reports[0].contains("origin"), "{reports:?}");
}

#[test]
fn what_came_later_shows_no_shadow_and_is_counted() {
    let mut stage = lit_ladder(maps(), 0.3, 0.02);
    let before = dark(&mut stage);
    stage.world.spawn((
        SceneMesh(Arc::new(MeshData::icosphere(0.3, 2))),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_xyz(0.0, 0.5, 1.0),
    ));
    let after = dark(&mut stage);
    assert!(after > 0 && after < before, "it hides some of {before}: {after}");
    let reports = said(&stage);
    assert!(
        reports.len() == 1 && reports[0].starts_with("1 receivers are not in"),
        "{reports:?}"
    );
}

#[test]
fn lights_paths_and_memory_that_do_not_fit_are_said() {
    let mut stage = lit_ladder(maps(), 0.3, 0.02);
    let light = stage.lights[0];
    let expect = |stage: &mut Stage, part: &str| {
        assert_eq!(dark(stage), 0, "{part}");
        let reports = said(stage);
        assert!(
            reports.len() == 1 && reports[0].contains(part),
            "{part}: {reports:?}"
        );
    };
    let other = LightPath::Arc {
        direction: Vec3::new(-1.0, -0.2, -0.5),
        axis: Vec3::Z,
        degrees: 149.0,
    };
    let right = maps().path.clone();
    stage.world.entity_mut(light).insert(other);
    expect(&mut stage, "another path");
    let broken = LightPath::Positions(vec![]);
    stage.world.entity_mut(light).insert(broken);
    expect(&mut stage, "positions");
    stage.world.entity_mut(light).insert(right);
    stage
        .world
        .entity_mut(light)
        .insert(Light::point(Vec3::ONE, 10.0, 50.0));
    expect(&mut stage, "that of a directional light");
    stage
        .world
        .entity_mut(light)
        .insert(Light::directional(Vec3::ONE, 3.0));
    stage.world.entity_mut(light).insert(OcclusionInterval {
        maps: "no/such/folder".to_owned(),
        ..settings(0.3, 0.02)
    });
    expect(&mut stage, "no/such/folder/maps.json");
    stage.world.entity_mut(light).insert(OcclusionInterval {
        maps: String::new(),
        ..settings(0.3, 0.02)
    });
    expect(&mut stage, "maps is not given");
    stage.world.entity_mut(light).insert(settings(0.3, 2.0));
    expect(&mut stage, "width is 2");
    stage.world.entity_mut(light).insert(settings(0.3, 0.02));
    stage.world.resource_mut::<TextureMemory>().limit = 1000;
    expect(&mut stage, "memory for textures is short");
    stage.world.resource_mut::<TextureMemory>().limit = 1 << 20;
    assert!(dark(&mut stage) > 50);
    assert_eq!(said(&stage), [] as [String; 0]);
    stage.world.resource_mut::<IntervalLibrary>().forget("ladder");
    expect(&mut stage, "ladder/maps.json");
}

#[test]
fn two_lights_share_maps_and_each_has_its_time() {
    let mut stage = lit_ladder(maps(), 0.2, 0.02);
    add_light(&mut stage, maps(), 0.8, 0.02);
    let rendered = stage.render().expect("the frame renders");
    assert_ne!(rendered.visibility[0], rendered.visibility[1]);
    assert_eq!(stage.world.resource::<IntervalScenes>().scenes.len(), 1);
    let mut alone = lit_ladder(maps(), 0.8, 0.02);
    let alone = alone.render().expect("the frame renders");
    assert_eq!(alone.visibility[0], rendered.visibility[1]);
}

#[test]
fn shared_maps_take_their_memory_once() {
    let mut stage = lit_ladder(maps(), 0.2, 0.02);
    add_light(&mut stage, maps(), 0.8, 0.02);
    let bytes = maps().bytes();
    stage.world.resource_mut::<TextureMemory>().limit = bytes;
    let rendered = stage.render().expect("the frame renders");
    let dark = |light: usize| rendered.visibility[light].iter().filter(|&&v| v < 0.5).count();
    assert!(dark(0) > 50 && dark(1) > 50, "{} {}", dark(0), dark(1));
    assert_eq!(stage.world.resource::<TextureMemory>().bytes(), bytes);
    assert_eq!(said(&stage), [] as [String; 0]);
    stage.world.resource_mut::<TextureMemory>().limit = bytes - 1;
    let rendered = stage.render().expect("the frame renders");
    assert!(rendered.visibility.iter().flatten().all(|&v| v == 1.0));
    let reports = said(&stage);
    assert_eq!(reports.len(), 2, "both lights are named: {reports:?}");
    assert!(
        reports.iter().all(|report| report.contains("memory")),
        "{reports:?}"
    );
}

#[test]
fn what_comes_and_goes_elsewhere_builds_nothing_again() {
    let mut stage = lit_ladder(maps(), 0.3, 0.02);
    let shadowed = dark(&mut stage);
    let generation = |stage: &Stage| stage.world.resource::<IntervalScenes>().scenes[0].generation;
    let before = generation(&stage);
    // Behind the wall, out of view.
    spawn(
        &mut stage.world,
        MeshData::icosphere(0.1, 1),
        Transform::from_xyz(0.0, 0.5, -1.5),
    );
    assert_eq!((dark(&mut stage), generation(&stage)), (shadowed, before));
    let mut query = stage
        .world
        .query_filtered::<(Entity, &Transform), With<SceneMesh>>();
    let (roof, _) = query
        .iter(&stage.world)
        .max_by(|a, b| a.1.translation.y.total_cmp(&b.1.translation.y))
        .expect("the roof");
    stage.world.despawn(roof);
    let _refused = dark(&mut stage);
    assert!(generation(&stage) > before, "one of the maps' own is gone");
}

#[test]
fn bakes_that_cannot_fit_are_refused_before_rays_are_cast() {
    let mut stage = Stage::empty(SIZE, Camera::default(), Transform::IDENTITY);
    for i in 0..50 {
        let place = Transform::from_xyz(3.0 * i as f32, 0.0, 0.0);
        spawn(&mut stage.world, MeshData::cuboid(Vec3::ONE), place);
    }
    stage.schedule.run(&mut stage.world);
    // Each of the 300 sides fills a page.
    let dense = BakeSettings {
        texels_per_metre: 400.0,
        page_size: 64,
        ..Default::default()
    };
    let mut calls = 0;
    let refused = bake_intervals(&mut stage.world, &maps().path, &dense, |_| calls += 1);
    assert!(matches!(refused, Err(BakeError::TooLarge { .. })), "{refused:?}");
    assert_eq!(calls, 0);
}

#[test]
fn what_cannot_be_baked_is_said() {
    let mut world = ladder().world;
    let sun = |latitude_degrees: f32| LightPath::Sun {
        latitude_degrees,
        day: 355.0,
        hours: [0.0, 24.0],
    };
    let coarse = BakeSettings {
        texels_per_metre: 0.5,
        ..Default::default()
    };
    let never = bake_intervals(&mut world, &sun(85.0), &coarse, |_| ()).expect("it is baked");
    assert!(never.notes.contains(&BakeNote::NeverSeen), "{:?}", never.notes);
    assert_eq!((never.maps.statistics.rays, never.maps.pair_count()), (0, 1));
    let day = bake_intervals(&mut world, &sun(40.0), &coarse, |_| ()).expect("it is baked");
    assert!(!day.notes.contains(&BakeNote::NeverSeen));
    let mut box_alone = Stage::empty(SIZE, Camera::default(), Transform::IDENTITY);
    spawn(
        &mut box_alone.world,
        MeshData::cuboid(Vec3::ONE),
        Transform::IDENTITY,
    );
    box_alone.schedule.run(&mut box_alone.world);
    let inside = LightPath::Positions(vec![Vec3::ZERO, Vec3::splat(0.5)]);
    let buried = bake_intervals(&mut box_alone.world, &inside, &coarse, |_| ()).expect("it is baked");
    assert_eq!(
        buried.notes,
        [BakeNote::NeverSeen],
        "the path lies inside of the box"
    );
    let refused = |path: &LightPath, settings: &BakeSettings, world: &mut World| {
        let refused = bake_intervals(world, path, settings, |_| ());
        refused.expect_err("it cannot be baked").to_string()
    };
    assert!(refused(&sun(95.0), &coarse, &mut world).contains("latitude_deg is 95"));
    for texels_per_metre in [0.0, 1e-9, 1e9, f32::NAN] {
        let absurd = BakeSettings {
            texels_per_metre,
            ..coarse.clone()
        };
        assert!(refused(&sun(0.0), &absurd, &mut world).contains("texels_per_metre is"));
    }
    let mut nothing = World::new();
    let nothing = bake_intervals(&mut nothing, &sun(0.0), &coarse, |_| ());
    assert!(matches!(nothing, Err(BakeError::Nothing)));
}

#[test]
fn baked_folders_are_used_as_they_are_while_scene_and_path_are_theirs() {
    let folder = std::env::temp_dir().join(format!("antumbra-{}-baked", std::process::id()));
    let settings = BakeSettings {
        texels_per_metre: 1.0,
        ..Default::default()
    };
    let mut stage = ladder();
    let path = maps().path.clone();
    let mut bake = |path: &LightPath| {
        let mut calls = 0;
        let bake =
            bake_into(&folder, &mut stage.world, path, &settings, |_| calls += 1).expect("it is baked");
        let mut maps = bake.maps;
        maps.statistics.seconds = 0.0;
        (maps, calls)
    };
    let (first, calls) = bake(&path);
    assert!(calls > 1);
    let (again, calls) = bake(&path);
    assert_eq!((&again, calls), (&first, 0), "nothing is cast again");
    let other = LightPath::Arc {
        direction: Vec3::new(-1.0, -0.2, -0.5),
        axis: Vec3::Z,
        degrees: 90.0,
    };
    let (changed, calls) = bake(&other);
    assert!(calls > 1 && changed.key != first.key);
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .expect("the folder")
        .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
        .collect();
    names.sort();
    assert!(!names.iter().any(|name| name.contains("partial")), "{names:?}");
    std::fs::remove_dir_all(&folder).expect("it is removed");
}
