//! Nodes that are no forest, too deep, or nowhere.

use antumbra::scene::gltf_import::{MAX_NODE_DEPTH, SkipKind, spawn_scene};
use serde_json::json;

use super::{assert_names, error_after, exercise};
use crate::gltf_builder::*;

#[test]
fn node_graphs_must_be_forests() {
    let message = error_after(|b| b.json["nodes"][2]["children"] = json!([1]));
    assert!(
        message.contains("node 1") || message.contains("scene 0"),
        "{message}"
    );
    let message = error_after(|b| {
        b.json["nodes"][2]["children"] = json!([1]);
        b.json["scenes"][0]["nodes"] = json!([0, 3]);
    });
    assert_names(&message, &["node 1", "ancestor"]);
    assert_names(
        &error_after(|b| b.json["nodes"][1]["children"] = json!([2, 2])),
        &["node 2", "two parents"],
    );
    assert_names(
        &error_after(|b| b.json["nodes"][0]["children"] = json!([2])),
        &["node 2", "two parents"],
    );

    // a lattice of 2^60 paths
    let mut builder = Builder::new();
    for level in 0..60 {
        let children: Vec<usize> = if level < 59 {
            vec![level * 2 + 2, level * 2 + 3]
        } else {
            vec![]
        };
        builder.push("nodes", json!({"children": children}));
        builder.push("nodes", json!({"children": children}));
    }
    assert_names(&builder.error(), &["two parents"]);
}

#[test]
fn deep_chains_are_refused_and_shallower_ones_spawn() {
    let chain = |depth: usize| {
        let mut builder = Builder::new();
        for node in 0..depth {
            let children: Vec<usize> = if node + 1 < depth { vec![node + 1] } else { vec![] };
            builder.push("nodes", json!({"children": children}));
        }
        builder.json["scenes"][0]["nodes"] = json!([0]);
        builder
    };
    assert_names(
        &chain(MAX_NODE_DEPTH + 1).error(),
        &[&format!("node {MAX_NODE_DEPTH}"), "deep"],
    );
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &chain(MAX_NODE_DEPTH).load(), None).unwrap();
    schedule.run(&mut world);
    world.despawn(spawned.root);
    assert!(chain(100_000).glb().len() > 100_000);
    assert_names(&chain(100_000).error(), &["deep"]);
}

#[test]
fn unusable_node_transforms_are_loaded_and_counted() {
    for edit in [
        json!({"scale": [1, 0, 0]}),
        json!({"translation": [1e39, 0, 0]}),
        json!({"rotation": [0, 0, 0, 0]}),
    ] {
        let mut builder = quad();
        for (key, value) in edit.as_object().unwrap() {
            builder.json["nodes"][0][key] = value.clone();
        }
        let gltf = builder.load();
        assert_eq!(gltf.report.count(SkipKind::NodeTransform), 1, "{edit}");
        assert!(gltf.report.to_string().contains("node 0"), "{}", gltf.report);
        exercise(&gltf);
    }
}

#[test]
fn a_scale_of_0_is_counted_only_where_a_mesh_is_lost_for_good() {
    let flattened = |mut builder: Builder, node: usize| {
        builder.json["nodes"][node]["scale"] = json!([0, 0, 0]);
        builder
    };
    let count = |builder: Builder| builder.load().report.count(SkipKind::NodeTransform);
    // A parent of the mesh, and a node with nothing below it.
    let mut below = quad();
    below.json["scenes"][0]["nodes"] = json!([1]);
    below.push("nodes", json!({"children": [0]}));
    assert_eq!(count(flattened(below, 1)), 1);
    let mut beside = quad();
    beside.root_node(json!({}));
    assert_eq!(count(flattened(beside, 1)), 0);
    // The node of a skinned mesh, whose joints place it, and its joint, below which there is none.
    assert_eq!(count(flattened(animated(), 0)), 0);
    assert_eq!(count(flattened(animated(), 1)), 0);
    // A node that grows, and one that only moves.
    for (path, lost) in [("scale", 0), ("translation", 1)] {
        let mut animated = quad();
        let times = animated.floats(&[[0.0], [1.0]]);
        let values = animated.floats(&[[0.0; 3], [1.0; 3]]);
        animated.push(
            "animations",
            json!({
                "samplers": [{"input": times, "output": values}],
                "channels": [{"sampler": 0, "target": {"node": 0, "path": path}}],
            }),
        );
        assert_eq!(count(flattened(animated, 0)), lost, "{path}");
    }
}
