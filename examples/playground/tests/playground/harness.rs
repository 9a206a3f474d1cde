//! Sessions, shots and pictures of the tests.

use std::path::{Path, PathBuf};

use antumbra::techniques::Techniques;
use antumbra_playground::session::{Session, headless_context};
use glam::UVec2;
use serde_json::{Value, json};

/// Size of the window: the panels take most of it, so that the pictures are small.
pub const WINDOW: UVec2 = UVec2::new(760, 300);

/// A window that is too narrow for panels, so that it is all picture.
pub const PICTURE: UVec2 = UVec2::new(128, 72);

pub fn models() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../assets/models")
}

pub fn out(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
        .join("playground")
        .join(name);
    std::fs::create_dir_all(&folder).unwrap();
    folder
}

pub fn session_with(techniques: Techniques, name: &str, size: UVec2) -> Session {
    Session::new(headless_context().unwrap(), techniques, size, &out(name)).unwrap()
}

pub fn session(name: &str, size: UVec2) -> Session {
    session_with(Techniques::default(), name, size)
}

/// A shot of a suzanne over nothing but itself, lit by a point and by a sphere.
pub fn shot(name: &str) -> PathBuf {
    let scene = models().join("suzanne.glb");
    let text = serde_json::json!({
        "scene": scene,
        "camera": {"eye": [1.2, 0.9, 3.4], "target": [0, 0, 0], "vfov_deg": 45},
        "lights": [
            {"kind": "point", "position": [1.6, 1.8, 1.6], "intensity": 20, "shadow": {"technique": "stencil_volume"}},
            {"kind": "sphere", "position": [-1.8, 1.2, 1.8], "radius": 0.3, "intensity": 12,
             "shadow": {"technique": "penumbra_wedge"}},
        ],
    });
    let path = out(name).join("shot.json");
    std::fs::write(&path, text.to_string()).unwrap();
    path
}

/// Writes a scene of a tetrahedron that moves by two metres in a second, there and back, with a change.
pub fn tetrahedron(name: &str, change: impl FnOnce(&mut Value)) -> PathBuf {
    let corners: [[f32; 3]; 4] = [
        [0.0, 1.0, 0.0],
        [-0.8, -0.5, 0.5],
        [0.8, -0.5, 0.5],
        [0.0, -0.5, -0.9],
    ];
    let triangles: [u16; 12] = [0, 1, 2, 0, 2, 3, 0, 3, 1, 1, 3, 2];
    let times: [f32; 3] = [0.0, 0.5, 1.0];
    let places: [[f32; 3]; 3] = [[-1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [-1.0, 0.0, 0.0]];
    let floats = |all: &[f32]| all.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let parts = [
        floats(corners.as_flattened()),
        triangles.iter().flat_map(|x| x.to_le_bytes()).collect(),
        floats(&times),
        floats(places.as_flattened()),
    ];
    let mut at = 0;
    let views = parts.each_ref().map(|part| {
        let view = json!({"buffer": 0, "byteOffset": at, "byteLength": part.len()});
        at += part.len();
        view
    });
    let accessor = |view: usize, component: u32, count: usize, kind: &str| json!({"bufferView": view, "componentType": component, "count": count, "type": kind});
    let mut positions = accessor(0, 5126, 4, "VEC3");
    positions["min"] = json!([-0.8, -0.5, -0.9]);
    positions["max"] = json!([0.8, 1.0, 0.5]);
    let mut seconds = accessor(2, 5126, 3, "SCALAR");
    seconds["min"] = json!([0.0]);
    seconds["max"] = json!([1.0]);
    let mut scene = json!({
        "asset": {"version": "2.0"},
        "buffers": [{"uri": "moving.bin", "byteLength": at}],
        "bufferViews": views,
        "accessors": [positions, accessor(1, 5123, 12, "SCALAR"), seconds, accessor(3, 5126, 3, "VEC3")],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "nodes": [{"mesh": 0, "name": "mover"}],
        "animations": [{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
            "samplers": [{"input": 2, "output": 3}]}],
        "scenes": [{"nodes": [0]}], "scene": 0,
    });
    change(&mut scene);
    let folder = out(name);
    std::fs::write(folder.join("moving.bin"), parts.concat()).unwrap();
    let path = folder.join("moving.gltf");
    std::fs::write(&path, scene.to_string()).unwrap();
    path
}

pub fn run(session: &mut Session, script: &str) {
    session.run_script(script).unwrap();
}

pub fn report(session: &Session) -> Value {
    session.report()
}

/// Number of pixels that differ between two pictures, by at least `least` in any channel.
pub fn different(a: &[u8], b: &[u8], least: u8) -> usize {
    assert_eq!(a.len(), b.len());
    let pixels = a.chunks_exact(4).zip(b.chunks_exact(4));
    pixels
        .filter(|(a, b)| a.iter().zip(*b).any(|(a, b)| a.abs_diff(*b) >= least))
        .count()
}

/// Mean difference of two pictures, steps of a channel.
pub fn apart(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: u64 = a.iter().zip(b).map(|(a, b)| u64::from(a.abs_diff(*b))).sum();
    sum as f64 / a.len() as f64
}

pub fn opened(name: &str, size: UVec2) -> Session {
    let mut session = session(name, size);
    assert!(session.app.open(&shot(name)), "{:?}", session.app.message);
    session.frame().unwrap();
    session
}
