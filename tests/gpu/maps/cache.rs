//! A map that is kept shows what one that is drawn every frame shows, whatever happens; memory and updates keep to
//! their limits, and nothing loses its shadow unsaid.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reports::Reports;
use antumbra::techniques::maps::{MapFilter, MapFormat, MapResolution, MapSettings, MapSurface, Maps};
use antumbra::techniques::{Shortage, TextureMemory};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::contacts::SPOT;
use crate::harness::strict_context;
use crate::harness::support::stage::Stage;

const SIZE: UVec2 = UVec2::new(96, 54);

fn stage() -> Stage {
    let camera = Camera {
        aspect: 16.0 / 9.0,
        ..Default::default()
    };
    let view = Transform::from_xyz(2.0, 3.0, 6.0).looking_at(Vec3::ZERO, Vec3::Y);
    let mut stage = Stage::empty(SIZE, camera, view);
    stage
        .add_renderer(strict_context(), RenderSettings::default())
        .expect("shaders compose");
    spawn(&mut stage, MeshData::plane(5.0), Vec3::ZERO);
    for i in 0..5 {
        spawn(
            &mut stage,
            MeshData::cuboid(Vec3::splat(0.3)),
            Vec3::new(i as f32 - 2.0, 0.5, 0.3),
        );
    }
    stage
}

fn spawn(stage: &mut Stage, mesh: MeshData, at: Vec3) -> Entity {
    let parts = (
        SceneMesh(Arc::new(mesh)),
        SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
        (ShadowCaster, ShadowReceiver),
        Transform::from_translation(at),
    );
    stage.world.spawn(parts).id()
}

fn light_at(x: f32, kind: LightKind) -> (Light, Transform) {
    let light = Light {
        kind,
        ..Light::point(Vec3::ONE, 20.0, 20.0)
    };
    (
        light,
        Transform::from_xyz(x, 3.5, 1.5).looking_at(Vec3::ZERO, Vec3::Z),
    )
}

/// A kept map and one that is not, at one place.
fn twins(stage: &mut Stage, kind: LightKind, filter: MapFilter, format: MapFormat, surface: MapSurface) {
    for cached in [true, false] {
        let (light, place) = light_at(0.5, kind);
        let entity = stage.spawn_light(light, place, None::<OmniMap>);
        let mut entity = stage.world.entity_mut(entity);
        let resolution = MapResolution::Fixed(256);
        if kind == LightKind::Point {
            entity.insert(OmniMap {
                resolution,
                filter,
                format,
                surface,
                cached,
                ..Default::default()
            });
        } else {
            entity.insert(ShadowMap {
                resolution,
                filter,
                surface,
                cached,
                ..Default::default()
            });
        }
    }
}

fn change_transform(stage: &mut Stage, entity: Entity, by: Vec3) {
    let mut transform = stage
        .world
        .get_mut::<Transform>(entity)
        .expect("it stands somewhere");
    transform.translation += by;
}

/// Both maps show the same in each of some frames; gives the visibility of the last.
#[track_caller]
fn same(stage: &mut Stage, frames: usize, what: &str) -> Vec<f32> {
    let mut last = Vec::new();
    for frame in 0..frames {
        let mut rendered = stage.render().expect("the frame renders");
        assert!(
            rendered.visibility[0] == rendered.visibility[1],
            "{what}, frame {frame}: {} pixels differ",
            rendered.visibility[0]
                .iter()
                .zip(&rendered.visibility[1])
                .filter(|(a, b)| a != b)
                .count()
        );
        last = rendered.visibility.swap_remove(0);
    }
    last
}

#[test]
fn kept_maps_show_what_maps_drawn_every_frame_show() {
    let jittered = MapFilter::Jittered {
        softness: 0.02,
        adaptive: true,
    };
    for (kind, filter, format, surface) in [
        (SPOT, MapFilter::Bilinear, MapFormat::Depth, MapSurface::Nearest),
        (
            LightKind::Directional,
            MapFilter::Brute4x4,
            MapFormat::Depth,
            MapSurface::Nearest,
        ),
        (
            LightKind::Point,
            MapFilter::Bilinear,
            MapFormat::Depth,
            MapSurface::Nearest,
        ),
        (
            LightKind::Point,
            jittered,
            MapFormat::Rgba8FourBytes,
            MapSurface::Midpoint,
        ),
    ] {
        let mut stage = stage();
        stage.world.resource_mut::<MapSettings>().still_after = 3;
        twins(&mut stage, kind, filter, format, surface);
        let first = same(&mut stage, 3, "at rest");
        let caster = spawn(&mut stage, MeshData::icosphere(0.3, 3), Vec3::new(0.0, 1.2, 1.0));
        let second = same(&mut stage, 2, "spawned");
        assert_ne!(first, second, "the new caster shows");
        for _ in 0..3 {
            change_transform(&mut stage, caster, Vec3::new(0.2, 0.0, 0.1));
            let moved = same(&mut stage, 1, "moves");
            assert_ne!(moved, second);
        }
        let rests = same(&mut stage, 6, "rests");
        let camera = stage.camera;
        change_transform(&mut stage, camera, Vec3::new(0.4, 0.1, -0.5));
        same(&mut stage, 2, "the view moves");
        change_transform(&mut stage, camera, Vec3::new(-0.4, -0.1, 0.5));
        stage
            .world
            .entity_mut(caster)
            .insert(SceneMesh(Arc::new(MeshData::cuboid(Vec3::splat(0.4)))));
        assert_ne!(rests, same(&mut stage, 2, "another mesh"));
        stage.world.entity_mut(caster).remove::<ShadowCaster>();
        assert_ne!(rests, same(&mut stage, 2, "no caster"));
        stage.world.despawn(caster);
        let gone = same(&mut stage, 2, "despawned");
        assert_eq!(first, gone, "all is as it was");
        for light in stage.lights.clone() {
            change_transform(&mut stage, light, Vec3::new(0.3, 0.0, 0.0));
            let mut transform = stage
                .world
                .get_mut::<Transform>(light)
                .expect("it stands somewhere");
            transform.rotate_z(0.2);
        }
        assert_ne!(first, same(&mut stage, 2, "the light moves"));
        for light in stage.lights.clone() {
            stage.world.entity_mut(light).insert(LightSelection {
                casts_for: 0,
                ..LightSelection::default()
            });
        }
        let nothing = same(&mut stage, 2, "nothing casts");
        assert!(nothing.iter().all(|v| *v == 1.0));
    }
}

#[test]
fn a_map_out_of_view_takes_in_what_happened_meanwhile() {
    let mut stage = stage();
    twins(
        &mut stage,
        SPOT,
        MapFilter::Bilinear,
        MapFormat::Depth,
        MapSurface::Nearest,
    );
    let caster = spawn(&mut stage, MeshData::icosphere(0.3, 3), Vec3::new(0.0, 1.2, 1.0));
    let before = same(&mut stage, 12, "at rest");
    let camera = stage.camera;
    let seen = *stage.world.get::<Transform>(camera).expect("it stands somewhere");
    let away = seen.looking_to(Vec3::Y, Vec3::X);
    stage.world.entity_mut(camera).insert(away);
    same(&mut stage, 2, "away");
    change_transform(&mut stage, caster, Vec3::new(0.5, 0.0, 0.0));
    same(&mut stage, 12, "away, moved, and at rest again");
    stage.world.entity_mut(camera).insert(seen);
    assert_ne!(before, same(&mut stage, 2, "back"));
}

/// Point lights in a row with kept maps.
fn row(stage: &mut Stage, count: usize, resolution: MapResolution) {
    for i in 0..count {
        let (light, place) = light_at(i as f32 * 4.0 / count as f32 - 2.0, LightKind::Point);
        let map = OmniMap {
            resolution,
            ..Default::default()
        };
        stage.spawn_light(light, place, Some(map));
    }
}

#[test]
fn updates_keep_to_their_budget_and_end() {
    let mut stage = stage();
    row(&mut stage, 8, MapResolution::Fixed(64));
    stage.world.resource_mut::<MapSettings>().face_updates = 12;
    stage.schedule.run(&mut stage.world);
    let maps = stage.world.resource::<Maps>();
    assert_eq!(
        (maps.updated_faces, maps.waiting_faces),
        (48, 0),
        "what shows nothing yet is drawn"
    );
    let shown = stage.render().expect("the frame renders");
    for light in stage.lights.clone() {
        change_transform(&mut stage, light, Vec3::new(0.4, 0.0, 0.0));
    }
    let mut updated = Vec::new();
    for _ in 0..6 {
        let now = stage.render().expect("the frame renders");
        let maps = stage.world.resource::<Maps>();
        updated.push((maps.updated_faces, maps.waiting_faces));
        if updated.len() == 1 {
            let changed = now
                .visibility
                .iter()
                .zip(&shown.visibility)
                .filter(|(a, b)| a != b)
                .count();
            // Two were taken in; the others keep their shadow.
            assert!(changed >= 2, "{changed}");
            assert!(now.visibility.iter().all(|v| v.iter().any(|v| *v < 0.5)));
        }
    }
    assert_eq!(updated, [(12, 36), (12, 24), (12, 12), (12, 0), (0, 0), (0, 0)]);
    let settled = stage.render().expect("the frame renders");
    assert!(
        settled
            .visibility
            .iter()
            .zip(&shown.visibility)
            .all(|(a, b)| a != b)
    );
}

#[test]
fn short_memory_costs_resolution_then_the_cache_and_is_reported() {
    let mut stage = stage();
    let least = 64_u32; // of a fixed resolution
    row(&mut stage, 6, MapResolution::Fixed(256));
    let dark = |stage: &mut Stage| -> Vec<usize> {
        let rendered = stage.render().expect("the frame renders");
        let of = |v: &Vec<f32>| v.iter().filter(|v| **v < 0.5).count();
        rendered.visibility.iter().map(of).collect()
    };
    let all = dark(&mut stage);
    let wanted = stage.world.resource::<Maps>().bytes;
    assert!(stage.world.resource::<TextureMemory>().shortages().is_empty());
    let face = u64::from(least) * u64::from(least) * 24;
    for limit in [wanted - 1, 6 * face, 3 * face, 0] {
        stage.world.resource_mut::<TextureMemory>().limit = limit;
        let now = dark(&mut stage);
        let maps = stage.world.resource::<Maps>();
        let memory = stage.world.resource::<TextureMemory>();
        assert_eq!(maps.bytes, memory.bytes());
        assert!(maps.bytes <= limit);
        let [mut coarser, mut uncached] = [0, 0];
        for short in memory.shortages() {
            match short.shortage {
                Shortage::Coarser { .. } => coarser += 1,
                Shortage::Shared { .. } => uncached += 1,
                Shortage::Nothing => panic!("every map has a picture"),
            }
        }
        println!(
            "limit {limit:>7}: {:>7} bytes, {coarser} coarser, {uncached} not kept, dark {now:?}",
            maps.bytes
        );
        assert_eq!(uncached, maps.lights.iter().filter(|map| !map.cached).count());
        for (now, all) in now.iter().zip(&all) {
            assert!(now.abs_diff(*all) * 4 < *all, "a shadow is gone: {now} of {all}");
        }
        let newly = |stage: &mut Stage| stage.world.resource_mut::<Reports>().drain_new().count();
        assert!(newly(&mut stage) > 0, "limit {limit} is said");
        stage.schedule.run(&mut stage.world);
        assert_eq!(newly(&mut stage), 0, "it is said once");
    }
    assert_eq!(stage.world.resource::<TextureMemory>().shortages().len(), 6);
}

/// A change of the light's cone alone: what it reaches stays the same objects.
#[test]
fn a_cone_that_widens_widens_its_kept_map() {
    let mut stage = stage();
    let mut casters = stage.world.query_filtered::<Entity, With<SceneMesh>>();
    for mesh in casters.iter(&stage.world).skip(1).collect::<Vec<_>>() {
        stage.world.despawn(mesh);
    }
    let rail = MeshData::cuboid(Vec3::new(4.0, 0.1, 0.1));
    spawn(&mut stage, rail, Vec3::new(0.0, 0.6, 0.3));
    let narrow = LightKind::Spot {
        inner_angle: 0.2,
        outer_angle: 0.25,
    };
    twins(
        &mut stage,
        narrow,
        MapFilter::Bilinear,
        MapFormat::Depth,
        MapSurface::Nearest,
    );
    let first = same(&mut stage, 3, "narrow");
    for light in stage.lights.clone() {
        let mut light = stage.world.get_mut::<Light>(light).expect("a light");
        light.kind = SPOT;
    }
    let wide = same(&mut stage, 2, "wide");
    let dark = |picture: &[f32]| picture.iter().filter(|v| **v < 0.5).count();
    assert!(
        dark(&wide) > dark(&first) + 50,
        "{} {}",
        dark(&wide),
        dark(&first)
    );
    for light in stage.lights.clone() {
        let mut light = stage.world.get_mut::<Light>(light).expect("a light");
        light.range = 3.9;
    }
    same(&mut stage, 2, "near");
}

#[test]
fn a_map_is_as_large_after_another_technique_as_without_one() {
    let cascades = ShadowMap {
        resolution: MapResolution::Auto { least: 64, most: 512 },
        ..Default::default()
    };
    let resolutions = |first: Option<ShadowMap>| {
        [140, 180, 220, 260, 300].map(|width| {
            let mut stage = stage();
            stage
                .world
                .insert_resource(ViewportSize(UVec2::new(width, width / 2)));
            let (light, place) = light_at(0.5, LightKind::Directional);
            let entity = stage.spawn_light(light, place, first);
            stage.run();
            let mut entity = stage.world.entity_mut(entity);
            entity.remove::<ShadowMap>().insert(PerspectiveMap::default());
            stage.run();
            let maps = stage.world.resource::<Maps>();
            maps.of_light(0).expect("it has a map").resolution
        })
    };
    let alone = resolutions(None);
    assert_eq!(resolutions(Some(cascades)), alone);
    assert_ne!(alone[0], alone[4], "pictures of other sizes need others");
}
