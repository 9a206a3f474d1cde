//! Nothing that a ray sees is missing: random scenes of boxes, plates, balls and soups, with every kind of culling, mask,
//! blending and mirroring, and random rooms joined by random portals, against the ray caster.
//!
//! A ray from the camera, beyond its near plane, must meet objects of V up to the first surface that is drawn opaque; a
//! ray from a shadowed light must meet objects of L up to the first triangle that casts for it; and a point that the
//! camera sees and the light lights must be of an object of I, with its blockers in S.

use crate::occlusion_harness::rooms::{Rooms, random_rooms};
use crate::occlusion_harness::scenes::random_scene;
use crate::occlusion_harness::{Counts, judge};
use antumbra::prelude::*;
use antumbra::sets::{CellIssue, Cells, FrustumSet, Objects, OcclusionSettings, SetWork, VisibleSet};
use bevy_ecs::prelude::*;
use glam::Vec3;

#[test]
fn no_object_seen_by_a_ray_is_missing() {
    let mut counts = Counts::default();
    for seed in 0..160 {
        let mut scene = random_scene(seed);
        let verdict = judge(&mut scene, seed);
        assert!(
            verdict.wrong.is_empty(),
            "seed {seed}: {:#?}",
            &verdict.wrong[..1]
        );
        counts += verdict.counts;
    }
    println!("{counts:?}");
    assert!(counts.camera_rays > 50_000 && counts.light_rays > 50_000 && counts.lit_points > 10_000);
    assert!(
        counts.hidden_from_camera > 200,
        "something is hidden from cameras"
    );
    assert!(counts.hidden_from_lights > 500, "and from lights");
}

#[test]
fn no_object_seen_through_portals_is_missing() {
    let mut counts = Counts::default();
    for seed in 0..160 {
        let Rooms { mut world, .. } = random_rooms(seed);
        // What walls hide, portals must hide without the depth buffer.
        world.insert_resource(OcclusionSettings {
            auto: None,
            ..OcclusionSettings::default()
        });
        let verdict = judge(&mut world, seed);
        assert!(
            verdict.wrong.is_empty(),
            "seed {seed}: {:#?}",
            &verdict.wrong[..1]
        );
        counts += verdict.counts;
    }
    println!("{counts:?}");
    assert!(
        counts.hidden_from_camera > 1000 && counts.hidden_from_lights > 1000,
        "{counts:?}"
    );
}

#[test]
fn a_lying_occluder_is_found() {
    let mut found = 0;
    for seed in 0..24 {
        let mut scene = random_scene(seed);
        let entities: Vec<Entity> = scene
            .query_filtered::<Entity, With<SceneMesh>>()
            .iter(&scene)
            .collect();
        for entity in entities {
            let giant = std::sync::Arc::new(MeshData::icosphere(6.0, 2));
            scene
                .entity_mut(entity)
                .insert(antumbra::scene::Occluder::Proxy(giant));
        }
        found += usize::from(!judge(&mut scene, seed).wrong.is_empty());
    }
    assert!(found > 6, "{found} of 24 lies were found");
}

#[test]
fn a_portal_that_is_not_there_is_missed() {
    let mut found = 0;
    for seed in 0..40 {
        let Rooms { mut world, portals } = random_rooms(seed);
        for portal in portals {
            world.get_mut::<antumbra::scene::Portal>(portal).unwrap().open = false;
        }
        found += usize::from(!judge(&mut world, seed).wrong.is_empty());
    }
    assert!(found > 20, "{found} of 40 were found");
}

#[test]
fn a_frame_at_rest_draws_and_tests_nothing() {
    for mut world in [random_scene(5), random_rooms(5).world] {
        let mut schedule = antumbra::schedule::standalone_schedule();
        schedule.run(&mut world);
        let first = *world.resource::<SetWork>();
        assert!(first.depth_buffers > 0 && first.occlusion_tests > 0);
        schedule.run(&mut world);
        assert_eq!(*world.resource::<SetWork>(), first);
    }
}

#[test]
fn occluders_that_move_hide_and_show_again() {
    let mut world = World::new();
    antumbra::schedule::init_resources(&mut world);
    world.insert_resource(ViewportSize(crate::occlusion_harness::VIEWPORT));
    let material = std::sync::Arc::new(Material::matte(Vec3::ONE));
    let mut spawn = |mesh: MeshData, at: Vec3| {
        let place = bevy_transform::prelude::Transform::from_translation(at);
        let looks = SceneMaterials([material.clone()].into());
        let parts = (ShadowCaster, ShadowReceiver);
        world
            .spawn((SceneMesh(std::sync::Arc::new(mesh)), looks, parts, place))
            .id()
    };
    let wall = spawn(
        MeshData::cuboid(Vec3::new(4.0, 4.0, 0.1)),
        Vec3::new(0.0, 0.0, -4.0),
    );
    let thing = spawn(MeshData::cuboid(Vec3::splat(0.3)), Vec3::new(0.0, 0.0, -8.0));
    world.spawn((Camera::default(), bevy_transform::prelude::Transform::IDENTITY));
    let at = bevy_transform::prelude::Transform::from_xyz(0.0, 1.0, 0.0);
    world.spawn((Light::point(Vec3::ONE, 10.0, 30.0), StencilVolume::default(), at));
    let mut schedule = antumbra::schedule::standalone_schedule();
    let mut sets = |world: &mut World| {
        schedule.run(world);
        let index = world.resource::<Objects>().index_of(thing).unwrap();
        let light = &world.resource::<FrameLights>().lights[0];
        let in_v = world.resource::<VisibleSet>().set.contains(index);
        [
            in_v,
            light.sets.l.contains(index),
            light.sets.i.contains(index),
            light.sets.s.contains(index),
        ]
    };
    assert_eq!(sets(&mut world), [false; 4], "behind the wall");
    // Through the camera, and away.
    for (x, z, seen) in [(0.0, -0.05, true), (20.0, -4.0, true), (0.0, -4.0, false)] {
        let mut place = world.get_mut::<bevy_transform::prelude::Transform>(wall).unwrap();
        place.translation = Vec3::new(x, 0.0, z);
        let got = sets(&mut world);
        assert_eq!(got[0], seen, "wall at {x} {z}");
        assert!(z == -0.05 || got == [seen; 4], "wall at {x} {z}: {got:?}");
    }
    world
        .get_mut::<bevy_transform::prelude::Transform>(thing)
        .unwrap()
        .translation
        .z = -2.0;
    assert_eq!(sets(&mut world), [true; 4], "before the wall");
}

/// A lamp 2 cm over a sheet: the sheet hides what is beneath, unless it is within the lamp's clearance and blocks nothing.
#[test]
fn an_occluder_in_the_clearance_of_a_light_hides_nothing_from_it() {
    use antumbra::sets::LightClearance;
    use bevy_transform::prelude::Transform;
    let mut world = World::new();
    antumbra::schedule::init_resources(&mut world);
    world.insert_resource(ViewportSize(crate::occlusion_harness::VIEWPORT));
    let material = std::sync::Arc::new(Material::matte(Vec3::ONE));
    let mut spawn = |mesh: MeshData, at: Vec3| {
        let looks = SceneMaterials([material.clone()].into());
        let place = Transform::from_translation(at);
        let mesh = SceneMesh(std::sync::Arc::new(mesh));
        world
            .spawn((mesh, looks, ShadowCaster, ShadowReceiver, place))
            .id()
    };
    spawn(MeshData::plane(4.0), Vec3::ZERO);
    let beneath = spawn(MeshData::cuboid(Vec3::splat(0.3)), Vec3::new(0.3, -2.0, 0.2));
    let view = Transform::from_xyz(0.0, -1.0, 6.0).looking_at(Vec3::NEG_Y, Vec3::Y);
    world.spawn((Camera::default(), view));
    let lamp = Light::point(Vec3::ONE, 10.0, 30.0);
    world.spawn((
        lamp,
        StencilVolume::default(),
        Transform::from_xyz(0.0, 0.02, 0.0),
    ));
    let mut schedule = antumbra::schedule::standalone_schedule();
    for (share, seen) in [(1e-5, false), (0.01, true), (0.0, false)] {
        world.insert_resource(LightClearance(share));
        schedule.run(&mut world);
        let index = world.resource::<Objects>().index_of(beneath).unwrap();
        let light = &world.resource::<FrameLights>().lights[0];
        assert_eq!(light.sets.l.contains(index), seen, "a clearance of {share}");
        assert_eq!(light.sets.i.contains(index), seen, "a clearance of {share}");
    }
}

#[test]
fn closed_doors_hide_what_is_behind_them() {
    let seen = |world: &World| world.resource::<VisibleSet>().set.count_ones(..);
    let (mut open, mut closed) = (0, 0);
    for seed in 0..8 {
        let Rooms { mut world, portals } = random_rooms(seed);
        let mut schedule = antumbra::schedule::standalone_schedule();
        let mut seen_with = |is_open: bool| {
            for &portal in &portals {
                world.get_mut::<antumbra::scene::Portal>(portal).unwrap().open = is_open;
            }
            schedule.run(&mut world);
            seen(&world)
        };
        let [before, behind_doors, after] = [true, false, true].map(&mut seen_with);
        assert_eq!(before, after, "seed {seed}");
        assert!(behind_doors <= before, "seed {seed}");
        open += before;
        closed += behind_doors;
    }
    assert!(closed < open, "{closed} of {open}");
}

#[test]
fn bad_cells_and_portals_hide_nothing_that_shows() {
    let mut reported = std::collections::BTreeSet::new();
    for seed in 0..80u64 {
        let Rooms { mut world, portals } = random_rooms(seed);
        world.insert_resource(OcclusionSettings {
            auto: None,
            ..OcclusionSettings::default()
        });
        for (at, &entity) in portals.iter().enumerate() {
            let mut portal = world.get_mut::<antumbra::scene::Portal>(entity).unwrap();
            match (seed as usize + at) % 5 {
                0 => {
                    let corner = portal.outline[1] + Vec3::Z * 0.3;
                    portal.outline.push(corner);
                }
                1 => {
                    // A dent within the hull.
                    portal.outline.insert(1, Vec3::new(0.0, -0.1, 0.0));
                }
                2 => portal.outline[0] = Vec3::NAN,
                3 => portal.outline.truncate(2),
                _ => portal.joins[1] = Entity::PLACEHOLDER,
            }
        }
        let cells: Vec<Entity> = world
            .query_filtered::<Entity, With<antumbra::scene::Cell>>()
            .iter(&world)
            .collect();
        if seed % 4 == 0 {
            world
                .get_mut::<antumbra::scene::Cell>(cells[0])
                .unwrap()
                .half_size
                .y = f32::NAN;
        }
        let verdict = judge(&mut world, seed);
        assert!(
            verdict.wrong.is_empty(),
            "seed {seed}: {:#?}",
            &verdict.wrong[..1]
        );
        for (_, issue) in &world.resource::<Cells>().issues {
            reported.insert(format!("{issue:?}"));
        }
    }
    let all = [
        CellIssue::Dangling,
        CellIssue::NotConvex,
        CellIssue::NotFlat,
        CellIssue::Outline,
        CellIssue::Volume,
    ];
    assert_eq!(
        reported.into_iter().collect::<Vec<_>>(),
        all.map(|issue| format!("{issue:?}"))
    );
}

#[test]
fn empty_worlds_and_objects_at_one_point_are_seen() {
    let mut world = World::new();
    antumbra::schedule::init_resources(&mut world);
    world.insert_resource(ViewportSize(crate::occlusion_harness::VIEWPORT));
    let mut schedule = antumbra::schedule::standalone_schedule();
    schedule.run(&mut world);
    world.spawn((Camera::default(), bevy_transform::prelude::Transform::IDENTITY));
    let cube = std::sync::Arc::new(MeshData::cuboid(Vec3::splat(0.5)));
    let material = std::sync::Arc::new(Material::matte(Vec3::ONE));
    for _ in 0..2000 {
        world.spawn((
            SceneMesh(cube.clone()),
            SceneMaterials([material.clone()].into()),
            (ShadowCaster, ShadowReceiver),
            bevy_transform::prelude::Transform::from_xyz(0.0, 0.0, -4.0),
        ));
    }
    schedule.run(&mut world);
    // None is nearer than another, so none hides another.
    let frustum_set = world.resource::<FrustumSet>().set.clone();
    assert_eq!(frustum_set.count_ones(..), 2000);
    assert_eq!(world.resource::<VisibleSet>().set, frustum_set);
    assert_eq!(world.resource::<Objects>().len(), 2000);
}
