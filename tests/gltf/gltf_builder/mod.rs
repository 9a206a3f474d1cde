//! Small glTF files made by hand, and a world that poses what is loaded from them.
#![allow(dead_code, reason = "each test file uses its part")]

use antumbra::scene::gltf_import::{LoadedGltf, load_gltf_slice};
use antumbra::scene::pose_meshes;
use antumbra::scene::{update_local_bounds, update_world_bounds};
use bevy_ecs::prelude::*;
use bevy_transform::systems::{
    StaticTransformOptimizations, mark_dirty_trees, propagate_parent_transforms, sync_simple_transforms,
};
use serde_json::{Value, json};

pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;
pub const F32: u32 = 5126;

/// A document under construction: JSON that tests may edit, and one binary buffer.
pub struct Builder {
    pub json: Value,
    pub binary: Vec<u8>,
}

impl Builder {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "materials": [],
        });
        Self {
            json,
            binary: Vec::new(),
        }
    }

    pub fn push(&mut self, list: &str, item: Value) -> usize {
        let items = &mut self.json[list];
        if items.is_null() {
            *items = json!([]);
        }
        let items = items.as_array_mut().unwrap();
        items.push(item);
        items.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let offset = self.binary.len();
        self.binary.extend_from_slice(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    pub fn accessor(&mut self, bytes: &[u8], component: u32, kind: &str, count: usize) -> usize {
        let view = self.view(bytes);
        let accessor = json!({"bufferView": view, "componentType": component, "type": kind, "count": count});
        self.push("accessors", accessor)
    }

    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let kind = match N {
            1 => "SCALAR",
            2 => "VEC2",
            3 => "VEC3",
            4 => "VEC4",
            _ => "MAT4",
        };
        let bytes: Vec<u8> = values.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, F32, kind, values.len())
    }

    pub fn indices_u16(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|x| x.to_le_bytes()).collect();
        self.accessor(&bytes, U16, "SCALAR", indices.len())
    }

    /// A node at the top of scene 0.
    pub fn root_node(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        self.json["scenes"][0]["nodes"]
            .as_array_mut()
            .unwrap()
            .push(json!(index));
        index
    }

    /// A mesh of one primitive, on a node.
    pub fn mesh(&mut self, primitive: Value) -> usize {
        let mesh = self.push("meshes", json!({"primitives": [primitive]}));
        self.root_node(json!({"mesh": mesh}));
        mesh
    }

    pub fn document(&self, uri: Option<String>) -> Value {
        let mut json = self.json.clone();
        for list in [
            "scenes",
            "nodes",
            "meshes",
            "accessors",
            "bufferViews",
            "materials",
        ] {
            if json[list].as_array().is_some_and(Vec::is_empty) {
                json.as_object_mut().unwrap().remove(list);
            }
        }
        if json.get("buffers").is_none() && !self.binary.is_empty() {
            json["buffers"] = json!([{"byteLength": self.binary.len()}]);
            if let Some(uri) = uri {
                json["buffers"][0]["uri"] = json!(uri);
            }
        }
        json
    }

    pub fn glb(&self) -> Vec<u8> {
        glb(&serde_json::to_vec(&self.document(None)).unwrap(), &self.binary)
    }

    pub fn load(&self) -> LoadedGltf {
        load_gltf_slice(&self.glb(), None, "test.glb").unwrap()
    }

    /// The error's text; panics if it loads.
    pub fn error(&self) -> String {
        load_gltf_slice(&self.glb(), None, "test.glb")
            .unwrap_err()
            .to_string()
    }
}

pub fn glb(json: &[u8], binary: &[u8]) -> Vec<u8> {
    let mut json = json.to_vec();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut binary = binary.to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let mut bytes = b"glTF".to_vec();
    for word in [
        2,
        (12 + 8 + json.len() + 8 + binary.len()) as u32,
        json.len() as u32,
    ] {
        bytes.extend(word.to_le_bytes());
    }
    bytes.extend(b"JSON");
    bytes.extend(json);
    bytes.extend((binary.len() as u32).to_le_bytes());
    bytes.extend(b"BIN\0");
    bytes.extend(binary);
    bytes
}

pub const TRIANGLE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
pub const QUAD: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]];

/// A triangle without indices and normals.
pub fn triangle() -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&TRIANGLE);
    builder.mesh(json!({"attributes": {"POSITION": positions}}));
    builder
}

/// A quad of two indexed triangles with normals.
pub fn quad() -> Builder {
    let mut builder = Builder::new();
    let positions = builder.floats(&QUAD);
    let normals = builder.floats(&[[0.0, 0.0, 1.0]; 4]);
    let indices = builder.indices_u16(&[0, 1, 2, 2, 1, 3]);
    builder.mesh(json!({"attributes": {"POSITION": positions, "NORMAL": normals}, "indices": indices}));
    builder
}

/// A quad bound to two joints, with a morph target and clips: something of every kind.
/// Nodes: 0 mesh, 1 joint, 2 joint at (0, 2, 0) below it, 3 lights and a camera.
pub fn animated() -> Builder {
    let mut builder = quad();
    let joints = builder.accessor(&[0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0], U8, "VEC4", 4);
    let weights = builder.floats(&[
        [1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.5, 0.5, 0.0, 0.0],
        [0.25, 0.75, 0.0, 0.0],
    ]);
    let target = builder.floats(&[[0.0, 0.0, 1.0]; 4]);
    let primitive = &mut builder.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["JOINTS_0"] = json!(joints);
    primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    primitive["targets"] = json!([{"POSITION": target}]);
    let identity = glam::Mat4::IDENTITY.to_cols_array();
    let second = glam::Mat4::from_translation(glam::Vec3::new(0.0, -2.0, 0.0)).to_cols_array();
    let inverse_bind = builder.floats(&[identity, second]);
    builder.push(
        "skins",
        json!({"joints": [1, 2], "inverseBindMatrices": inverse_bind}),
    );
    builder.json["nodes"][0]["skin"] = json!(0);
    builder.json["nodes"][0]["translation"] = json!([100.0, 0.0, 0.0]);
    builder.root_node(json!({"children": [2], "name": "hip"}));
    builder.push("nodes", json!({"translation": [0.0, 2.0, 0.0]}));
    builder.root_node(json!({"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    builder.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 0.8, "znear": 0.1}}),
    );
    builder.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    builder.json["extensions"] =
        json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": 12.5}]}});
    let times = builder.floats(&[[0.0], [2.0]]);
    let moves = builder.floats(&[[0.0, 2.0, 0.0], [4.0, 2.0, 0.0]]);
    let morphs = builder.floats(&[[0.0], [1.0]]);
    let samplers = json!([{"input": times, "output": moves}, {"input": times, "output": morphs}]);
    let channels = json!([
        {"sampler": 0, "target": {"node": 2, "path": "translation"}},
        {"sampler": 1, "target": {"node": 0, "path": "weights"}},
    ]);
    builder.push("animations", json!({"samplers": samplers, "channels": channels}));
    builder
}

/// Transform propagation, posing and bounds, in the order of a frame.
pub fn frame() -> (World, Schedule) {
    let mut world = World::new();
    world.init_resource::<StaticTransformOptimizations>();
    let mut schedule = Schedule::default();
    schedule.add_systems(
        (
            mark_dirty_trees,
            propagate_parent_transforms,
            sync_simple_transforms,
            pose_meshes,
            update_local_bounds,
            update_world_bounds,
        )
            .chain(),
    );
    (world, schedule)
}
