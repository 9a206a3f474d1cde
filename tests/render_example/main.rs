//! `examples/render` does what its shot files say (DESIGN.md §6), or says in one line why not.
//!
//! Runs the built example.

#[path = "../built_example/mod.rs"]
mod built_example;
#[path = "../gltf/gltf_builder/mod.rs"]
mod gltf_builder;
#[path = "../veil/mod.rs"]
mod veil;

mod bake;
mod errors;
mod outputs;
mod reports;
mod schema;
mod shot_text;

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use built_example::example;
use gltf_builder::Builder;
use serde_json::{Value, json};

/// An empty folder of one test.
fn folder(test: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("render_example")
        .join(test);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("the folder of the last run goes");
    }
    std::fs::create_dir_all(&folder).expect("a folder for the test");
    folder
}

/// Runs the example on a shot file.
fn run(folder: &Path, shot: &str, out: &str, environment: &[(&str, &str)]) -> Output {
    Command::new(example("render"))
        .arg(folder.join(shot))
        .arg("--out")
        .arg(folder.join(out))
        // Without it some drivers print a line of their own.
        .env("XDG_RUNTIME_DIR", folder)
        .envs(environment.iter().copied())
        .output()
        .expect("the example starts")
}

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    std::fs::create_dir_all(path.parent().expect("below the folder")).expect("a folder");
    std::fs::write(&path, text).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
}

/// A box on a plane, with a clip that lifts the box, a camera and a light: `models/house.glb`.
fn write_scene(folder: &Path) {
    write_house(folder, "house", 0.7);
}

/// The same scene under a name, with the box at a height where no clip plays.
fn write_house(folder: &Path, name: &str, height: f32) {
    let mut glb = Builder::new();
    let add_mesh = |glb: &mut Builder, positions: &[[f32; 3]], indices: &[u16]| {
        let position = glb.floats(positions);
        let indices = glb.indices_u16(indices);
        let primitive = json!({"attributes": {"POSITION": position}, "indices": indices, "material": 0});
        glb.push("meshes", json!({"primitives": [primitive]}))
    };
    let plane: Vec<[f32; 3]> = [[-4., 0., -4.], [-4., 0., 4.], [4., 0., 4.], [4., 0., -4.]].into();
    let corners: Vec<[f32; 3]> = (0..8)
        .map(|corner| [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -0.5 } else { 0.5 }))
        .collect();
    let faces = [
        [0, 2, 3, 1],
        [4, 5, 7, 6],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [0, 4, 6, 2],
        [1, 3, 7, 5],
    ];
    let triangles: Vec<u16> = faces
        .iter()
        .flat_map(|[a, b, c, d]| [*a, *b, *c, *a, *c, *d])
        .collect();
    let plane = add_mesh(&mut glb, &plane, &[0, 1, 2, 0, 2, 3]);
    let cuboid = add_mesh(&mut glb, &corners, &triangles);
    glb.push(
        "materials",
        json!({"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0.5, 0.5, 1.0], "metallicFactor": 0.0}}),
    );
    glb.push("nodes", json!({"mesh": plane}));
    glb.push(
        "nodes",
        json!({"mesh": cuboid, "translation": [0.0, height, 0.0]}),
    );
    glb.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}),
    );
    glb.push("nodes", json!({"camera": 0, "translation": [0.0, 1.0, 6.0]}));
    glb.push(
        "nodes",
        json!({"translation": [2.0, 4.0, 1.0], "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    );
    glb.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    glb.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 50.0}]}});
    let times = glb.floats(&[[0.0], [2.0]]);
    glb.json["accessors"][times]["min"] = json!([0.0]);
    glb.json["accessors"][times]["max"] = json!([2.0]);
    let places = glb.floats(&[[0.0, 0.7, 0.0], [0.0, 1.7, 0.0]]);
    glb.push(
        "animations",
        json!({
            "samplers": [{"input": times, "output": places}],
            "channels": [{"sampler": 0, "target": {"node": 1, "path": "translation"}}],
        }),
    );
    glb.json["scenes"][0]["nodes"] = json!([0, 1, 2, 3]);
    let path = folder.join(format!("models/{name}.glb"));
    std::fs::create_dir_all(path.parent().expect("models")).expect("a folder");
    std::fs::write(path, glb.glb()).expect("the scene is written");
}

/// The shot file of DESIGN.md §6, but for the rectangle's technique, which has a test of its own.
fn design_shot() -> Value {
    json!({ "scene": "models/house.glb",
      "camera": {"eye": [3,3,5], "target": [0,0,0], "up": [0,1,0], "vfov_deg": 45, "near": 0.1},
      "size": [640, 360],
      "ambient": [0.02, 0.02, 0.02],
      "animation": {"clip": 0, "time": 1.25},
      "lights": [
        {"kind": "point",  "position": [2,4,1], "range": 20, "color": [1,1,1], "intensity": 60,
         "shadow": {"technique": "stencil_volume"}},
        {"kind": "spot", "position": [0,5,0], "direction": [0,-1,0], "inner_deg": 20, "outer_deg": 30},
        {"kind": "directional", "direction": [-1,-2,-1]},
        {"kind": "rect",   "position": [2,4,1], "direction": [-2,-4,-1], "up": [0,0,1], "width": 1, "height": 1,
         "shadow": {"technique": "stencil_volume", "counting": "depth_fail", "extent": "infinite"}},
        {"kind": "sphere", "position": [2,4,1], "radius": 0.5} ] })
}

/// A small shot of the scene; errors are made from it.
fn small_shot() -> Value {
    let mut shot = design_shot();
    shot["size"] = json!([64, 36]);
    shot
}
