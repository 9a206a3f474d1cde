//! Shot files name the light model with the keys of a light.

use antumbra::prelude::*;
use antumbra::scene::{
    LayerNames, LightDistance, LightShape, LightWeights, SelectionLayers, ShadowOrigin, ShadowSoftness,
    ShadowTint,
};
use antumbra::techniques::Techniques;
use glam::Vec3;
use serde_json::{Value, json};

use crate::harness::support::shot::Shot;
use crate::harness::support::stage::Stage;

fn shot(light: Value) -> Result<Shot, String> {
    let scene = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/assets/models/bonsai_alpha_leaves.glb"
    );
    let text = json!({"scene": scene, "size": [64, 36], "lights": [light]}).to_string();
    Shot::parse(&text, Techniques::default())
}

fn light(keys: Value) -> Value {
    let mut light = json!({"kind": "spot", "position": [2, 4, 2], "direction": [-1, -2, -1], "inner_deg": 20, "outer_deg": 40});
    for (key, value) in keys.as_object().expect("keys and values") {
        light[key] = value.clone();
    }
    light
}

#[test]
fn each_key_becomes_its_component() {
    let shot = shot(light(json!({
        "shape": {"width": 0.4, "height": 0.3, "width_edge": 0.1, "height_edge": 0.1, "round": 0.5},
        "distance": {"near": 1, "far": 6, "near_edge": 0.5, "far_edge": 2},
        "weights": {"ambient": 0, "diffuse": 1, "specular": 0.5},
        "shadow_color": [0, 0, 0.2], "shadow_darkness": 0.8, "shadow_origin": [1, 3, 0], "shadow_softness": 0.2,
    })))
    .expect("the shot is whole");
    let stage = Stage::of_shot(&shot).expect("the scene is there");
    let entity = stage.world.entity(stage.lights[0]);
    let shape = LightShape {
        width: 0.4,
        height: 0.3,
        width_edge: 0.1,
        height_edge: 0.1,
        round: 0.5,
    };
    assert_eq!(entity.get(), Some(&shape));
    let distance = LightDistance {
        near: 1.0,
        far: 6.0,
        near_edge: 0.5,
        far_edge: 2.0,
    };
    assert_eq!(entity.get(), Some(&distance));
    assert_eq!(
        entity.get::<LightWeights>().map(|weights| weights.specular),
        Some(0.5)
    );
    let tint = ShadowTint {
        color: Vec3::new(0.0, 0.0, 0.2),
        darkness: 0.8,
    };
    assert_eq!(entity.get(), Some(&tint));
    assert_eq!(
        entity.get(),
        Some(&ShadowOrigin::Position(Vec3::new(1.0, 3.0, 0.0)))
    );
    assert_eq!(entity.get(), Some(&ShadowSoftness(0.2)));
}

#[test]
fn names_of_nodes_select_their_meshes() {
    let first = shot(light(json!({}))).expect("the shot is whole");
    let mut stage = Stage::of_shot(&first).expect("the scene is there");
    let mut named = stage
        .world
        .query_filtered::<&bevy_ecs::name::Name, bevy_ecs::prelude::With<SceneMesh>>();
    let name = named
        .iter(&stage.world)
        .next()
        .expect("a node has a mesh")
        .to_string();
    let selected = shot(light(
        json!({"affects": [name], "casts_for": [name], "shows_on": []}),
    ))
    .expect("whole");
    let mut stage = Stage::of_shot(&selected).expect("the scene is there");
    let bit = stage
        .world
        .resource::<LayerNames>()
        .bit(&name)
        .expect("the name has a layer");
    let expected = LightSelection {
        affects: bit,
        casts_for: bit,
        shows_on: 0,
    };
    assert_eq!(stage.world.get(stage.lights[0]), Some(&expected));
    let mut layers = stage.world.query::<&SelectionLayers>();
    let on = layers
        .iter(&stage.world)
        .filter(|layers| layers.0 & bit != 0)
        .count();
    assert!(on > 0, "a mesh is on the layer");
}

#[test]
fn what_is_wrong_is_named() {
    for (keys, parts) in [
        (json!({"shape": {"widht": 1}}), ["lights[0]", "shape", "widht"]),
        (json!({"shape": {"round": 2}}), ["lights[0]", "round", "0 to 1"]),
        (
            json!({"distance": {"near": "far"}}),
            ["lights[0]", "distance.near", "far"],
        ),
        (json!({"shadow_darkness": 2}), ["lights[0]", "darkness", "0 to 1"]),
        (
            json!({"shadow_direction": [0, -1, 0]}),
            ["lights[0]", "ShadowOrigin", "position"],
        ),
        (
            json!({"shadow_origin": [1, 3, 0], "shadow_direction": [0, -1, 0]}),
            ["lights[0]", "shadow_direction: ", "`shadow_origin`"],
        ),
        (
            json!({"shadow_colour": [0, 0, 0]}),
            ["lights[0]", "unknown field `shadow_colour`", "`shadow_color`"],
        ),
        (
            json!({"intensity": "bright"}),
            ["lights[0]: intensity: invalid type", "bright", "f32"],
        ),
        (
            json!({"position": null}),
            ["lights[0]: position: invalid type", "null", "array of length 3"],
        ),
    ] {
        let line = shot(light(keys)).expect_err("it is wrong");
        assert!(parts.iter().all(|part| line.contains(part)), "{line}");
    }
    let nobody = shot(light(json!({"affects": ["nobody"]}))).expect("names are looked up in the scene");
    let line = Stage::of_shot(&nobody).err().expect("nobody has the name");
    assert!(
        line.contains("lights[0].affects") && line.contains("nobody"),
        "{line}"
    );
}

#[test]
fn no_key_of_a_light_stands_twice() {
    let light = light(json!({"shadow": {"technique": "stencil_volume"}}));
    let text = json!({"scene": "no.glb", "size": [64, 36], "lights": [light]}).to_string();
    for (key, entry) in [
        ("inner_deg", "\"inner_deg\":20"),
        ("technique", "\"technique\":\"stencil_volume\""),
    ] {
        let twice = text.replace(entry, &format!("{entry},{entry}"));
        assert_ne!(twice, text);
        let line = Shot::parse(&twice, Techniques::default()).expect_err("a key stands twice");
        assert!(
            line.contains("lights[0]") && line.contains(&format!("duplicate field `{key}`")),
            "{line}"
        );
    }
}
