//! Skins and channels that do not fit.

use antumbra::scene::gltf_import::{SkipKind, spawn_scene};
use bevy_ecs::prelude::*;
use serde_json::json;

use super::{assert_names, error_after, exercise};
use crate::gltf_builder::*;

#[test]
fn skins_that_do_not_fit_are_named() {
    let message = error_after(|b| b.json["skins"][0]["joints"] = json!([1]));
    assert_names(&message, &["node 0", "joint 1", "skin 0 has 1"]);
    let message = error_after(|b| b.json["skins"][0]["joints"] = json!([1, 2, 1]));
    assert_names(&message, &["skin 0", "2 matrices", "3 joints"]);
    let mut builder = animated();
    builder.push("scenes", json!({"nodes": [0]}));
    let gltf = builder.load();
    let message = spawn_scene(&mut World::new(), &gltf, Some(1))
        .unwrap_err()
        .to_string();
    assert_names(&message, &["skin 0", "node 1", "scene 1"]);
}

#[test]
fn channels_that_do_not_fit_are_left_out() {
    type Edit = fn(&mut Builder);
    let edits: [Edit; 4] = [
        |b| b.json["animations"][0]["samplers"][0]["interpolation"] = json!("CUBICSPLINE"),
        |b| b.json["animations"][0]["samplers"][0]["input"] = json!(b.floats(&[[1.0], [1.0]])),
        |b| b.json["animations"][0]["samplers"][0]["output"] = json!(b.floats(&[[f32::NAN; 3]; 2])),
        |b| {
            b.json["animations"][0]["channels"][0]["target"] =
                json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/nodes/0"}}});
        },
    ];
    for edit in edits {
        let mut builder = animated();
        edit(&mut builder);
        let gltf = builder.load();
        assert_eq!(gltf.report.count(SkipKind::AnimationChannel), 1);
        assert_eq!(gltf.clips[0].channels.len(), 1);
        exercise(&gltf);
    }
}
