//! Cells, portals and occluders come from the extras of glTF nodes; what cannot be read is reported and hides nothing.

use crate::gltf_builder::Builder;
use antumbra::prelude::*;
use antumbra::scene::gltf_import::{LoadedGltf, SkipKind, load_gltf_slice, spawn_scene};
use antumbra::scene::{Cell, InCells, Occluder, Portal};
use antumbra::schedule::{init_resources, standalone_schedule};
use antumbra::sets::{CellIssue, Cells, Objects, OcclusionSettings, VisibleSet};
use bevy_ecs::prelude::*;
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};
use serde_json::{Value, json};

/// Two rooms side by side along x, a thing in each, and a door between them; a mesh of a flat square, 0..=1.
fn two_rooms(door: Value) -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]);
    let indices = builder.indices_u16(&[0, 1, 2, 0, 2, 3]);
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
    let mesh = builder.push("meshes", json!({"primitives": [primitive]}));
    for (x, name) in [(0.0, "left"), (4.0, "right")] {
        let cell = json!({"antumbra": {"cell": name, "half_size": [2.0, 1.5, 2.0]}, "another tool": 1});
        builder.root_node(json!({"translation": [x, 0.0, 0.0], "extras": cell}));
        builder.root_node(json!({"translation": [x + 1.0, 0.0, 0.0], "mesh": mesh}));
    }
    builder.root_node(door);
    builder
}

fn door(open: bool) -> Value {
    let portal = json!({"joins": ["left", "right"], "open": open});
    json!({
        "translation": [2.0, 0.0, 0.0],
        "rotation": [0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2],
        "extras": {"antumbra": {"portal": portal, "half_size": [1.0, 1.0]}},
    })
}

fn load(builder: &Builder) -> LoadedGltf {
    load_gltf_slice(&builder.glb(), None, "rooms.glb").expect("the file loads")
}

/// Objects of V, seen from the left room towards the right one.
fn seen(loaded: &LoadedGltf) -> (World, usize) {
    let mut world = World::new();
    init_resources(&mut world);
    world.insert_resource(ViewportSize(UVec2::new(64, 36)));
    world.insert_resource(OcclusionSettings {
        auto: None,
        ..OcclusionSettings::default()
    });
    let view = Transform::from_xyz(-1.0, 0.3, 0.4).looking_to(Vec3::X, Vec3::Y);
    world.spawn((Camera::default(), view));
    spawn_scene(&mut world, loaded, None).expect("the scene spawns");
    standalone_schedule().run(&mut world);
    let count = world.resource::<VisibleSet>().set.count_ones(..);
    (world, count)
}

#[test]
fn a_door_of_a_file_opens_and_closes() {
    let (world, open) = seen(&load(&two_rooms(door(true))));
    assert!(world.resource::<Cells>().issues.is_empty());
    assert_eq!(world.resource::<Objects>().len(), 2);
    let (_, closed) = seen(&load(&two_rooms(door(false))));
    assert_eq!((open, closed), (2, 1));
}

#[test]
fn a_mesh_may_say_what_a_cell_or_portal_is() {
    let mut builder = two_rooms(door(false));
    let portal = json!({"antumbra": {"portal": {"joins": ["left", "right"]}}});
    let turn = [
        0.0,
        std::f32::consts::FRAC_1_SQRT_2,
        0.0,
        std::f32::consts::FRAC_1_SQRT_2,
    ];
    builder.root_node(json!({"translation": [2.0, 0.0, 0.5], "rotation": turn, "mesh": 0, "extras": portal}));
    let loaded = load(&builder);
    assert!(loaded.report.is_empty(), "{}", loaded.report);
    let (mut world, seen) = seen(&loaded);
    assert_eq!(seen, 2);
    let outlines: Vec<usize> = world
        .query::<&Portal>()
        .iter(&world)
        .map(|portal| portal.outline.len())
        .collect();
    assert_eq!(outlines, [4, 4]);
    assert_eq!(
        world.resource::<Objects>().len(),
        2,
        "the portal's mesh is not drawn"
    );
}

/// A portal whose mesh is a grid of `side` by `side` vertices, each of them twice.
fn grid_door(side: usize, bulge: f32) -> Builder {
    let mut builder = two_rooms(door(false));
    let place = |at: usize| at as f32 / (side - 1) as f32;
    let positions: Vec<[f32; 3]> = (0..2 * side * side)
        .map(|at| (at / 2 / side, at / 2 % side))
        .map(|(x, y)| [place(x), place(y), bulge * place(x) * place(y)])
        .collect();
    let positions = builder.floats(&positions);
    let vertex = |x: usize, y: usize| 2 * (x * side + y) as u16;
    let cells = (0..side - 1).flat_map(|x| (0..side - 1).map(move |y| (x, y)));
    let square = |(x, y)| {
        [
            vertex(x, y),
            vertex(x + 1, y),
            vertex(x + 1, y + 1),
            vertex(x, y + 1),
        ]
    };
    let triangles: Vec<u16> = cells
        .map(square)
        .flat_map(|[a, b, c, d]| [a, b, c, a, c, d])
        .collect();
    let indices = builder.indices_u16(&triangles);
    let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
    let mesh = builder.push("meshes", json!({"primitives": [primitive]}));
    let extras = json!({"antumbra": {"portal": {"joins": ["left", "right"]}}});
    builder.root_node(json!({"translation": [2.0, 0.0, 0.0], "mesh": mesh, "extras": extras}));
    builder
}

#[test]
fn a_finely_divided_portal_has_the_corners_of_its_hull_and_no_issue() {
    for (bulge, corners, issues) in [(0.0, 4, vec![]), (0.5, 30 * 30, vec![CellIssue::NotFlat])] {
        let (mut world, _) = seen(&load(&grid_door(30, bulge)));
        let mut portals = world.query::<&Portal>();
        let most = portals.iter(&world).map(|portal| portal.outline.len()).max();
        assert_eq!(most, Some(corners));
        let found = world.resource::<Cells>().issues.iter().map(|(_, issue)| *issue);
        assert_eq!(found.collect::<Vec<_>>(), issues);
    }
}

#[test]
fn lists_and_occluders_are_components() {
    let mut builder = two_rooms(door(false));
    let extras = json!({"antumbra": {"in_cells": ["left"], "occluder": false}});
    builder.root_node(json!({"translation": [5.0, 0.0, 0.0], "mesh": 0, "extras": extras}));
    let (mut world, seen) = seen(&load(&builder));
    assert_eq!(seen, 2, "it is in the left room, wherever it stands");
    assert_eq!(world.query::<&InCells>().iter(&world).count(), 1);
    assert!(matches!(
        world.query::<&Occluder>().single(&world),
        Ok(Occluder::Never)
    ));
}

#[test]
fn what_cannot_be_read_is_reported_and_hides_nothing() {
    let bad = [
        json!({"portal": {"joins": ["left"]}, "half_size": [1, 1]}),
        json!({"portal": {"joins": ["left", 3]}, "half_size": [1, 1]}),
        json!({"portal": {"joins": ["left", "right"], "open": "no"}, "half_size": [1, 1]}),
        json!({"portal": {"joins": ["left", "right"]}}),
        json!({"cell": "left", "half_size": [1, 1, 1]}),
        json!({"cell": "third", "half_size": [1, -1, 1]}),
        json!({"cell": "third", "half_size": [1]}),
        json!({"in_cells": "left"}),
        json!({"occluder": 1}),
        json!({"portals": []}),
        json!([]),
    ];
    for extras in bad {
        let mut builder = two_rooms(door(false));
        builder.root_node(json!({"extras": {"antumbra": extras}}));
        let loaded = load(&builder);
        assert_eq!(
            loaded.report.count(SkipKind::Visibility),
            1,
            "{extras}: {}",
            loaded.report
        );
        let (mut world, seen) = seen(&loaded);
        assert_eq!(seen, 2, "{extras}");
        assert_eq!(world.query::<&Cell>().iter(&world).count(), 0);
    }
}

#[test]
fn a_portal_into_nowhere_shows_everything() {
    let portal = json!({"joins": ["left", "attic"]});
    let node = json!({
        "translation": [1.9, 0.0, 0.0],
        "rotation": [0.0, std::f32::consts::FRAC_1_SQRT_2, 0.0, std::f32::consts::FRAC_1_SQRT_2],
        "extras": {"antumbra": {"portal": portal, "half_size": [1.0, 1.0]}},
    });
    let (world, seen) = seen(&load(&two_rooms(node)));
    assert_eq!((world.resource::<Cells>().issues.len(), seen), (1, 2));
}
