//! Indices and accessors that point to nothing.

use std::path::Path;

use antumbra::scene::gltf_import::load_gltf_slice;
use serde_json::{Value, json};

use super::{assert_names, error_after};
use crate::gltf_builder::*;

#[test]
fn indices_out_of_range_name_both_ends() {
    type Edit = fn(&mut Builder);
    let cases: [(Edit, &[&str]); 17] = [
        (
            |b| b.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99),
            &["mesh 0 primitive 0", "accessor 99"],
        ),
        (
            |b| b.json["meshes"][0]["primitives"][0]["indices"] = json!(98),
            &["mesh 0 primitive 0", "accessor 98"],
        ),
        (
            |b| b.json["meshes"][0]["primitives"][0]["material"] = json!(3),
            &["mesh 0 primitive 0", "material 3"],
        ),
        (
            |b| b.json["accessors"][1]["bufferView"] = json!(77),
            &["accessor 1", "buffer view 77"],
        ),
        (
            |b| b.json["bufferViews"][0]["buffer"] = json!(5),
            &["buffer view 0", "buffer 5"],
        ),
        (
            |b| b.json["nodes"][1]["children"] = json!([42]),
            &["node 1", "node 42"],
        ),
        (|b| b.json["nodes"][0]["mesh"] = json!(4), &["node 0", "mesh 4"]),
        (|b| b.json["nodes"][0]["skin"] = json!(4), &["node 0", "skin 4"]),
        (
            |b| b.json["nodes"][3]["camera"] = json!(4),
            &["node 3", "camera 4"],
        ),
        (
            |b| b.json["nodes"][3]["extensions"]["KHR_lights_punctual"]["light"] = json!(4),
            &["node 3", "light 4"],
        ),
        (
            |b| b.json["skins"][0]["joints"] = json!([1, 40]),
            &["skin 0", "node 40"],
        ),
        (
            |b| b.json["skins"][0]["inverseBindMatrices"] = json!(40),
            &["skin 0", "accessor 40"],
        ),
        (
            |b| b.json["scenes"][0]["nodes"] = json!([0, 9]),
            &["scene 0", "node 9"],
        ),
        (|b| b.json["scene"] = json!(9), &["scene 9"]),
        (
            |b| b.json["animations"][0]["channels"][1]["sampler"] = json!(7),
            &["animation 0 channel 1", "sampler 7"],
        ),
        (
            |b| b.json["animations"][0]["channels"][1]["target"]["node"] = json!(7),
            &["channel 1", "node 7"],
        ),
        (
            |b| b.json["animations"][0]["samplers"][0]["input"] = json!(70),
            &["channel 0", "accessor 70"],
        ),
    ];
    for (edit, parts) in cases {
        assert_names(&error_after(edit), parts);
    }
    let message = error_after(|b| {
        b.json["materials"] = json!([{"normalTexture": {"index": 6}}]);
    });
    assert_names(&message, &["material 0", "texture 6"]);
    let message = error_after(|b| {
        b.json["textures"] = json!([{"source": 6}]);
        b.json["materials"] = json!([{"normalTexture": {"index": 0}}]);
    });
    assert_names(&message, &["texture 0", "image 6"]);
}

/// The second of two primitives refers to a missing accessor, through each of its attributes, its indices and its morph
/// targets; so do a skin, both ends of an animation's sampler and a node's instances.
#[test]
fn a_missing_accessor_names_the_element_that_refers_to_it() {
    let missing = json!(90);
    let primitive = |edit: &dyn Fn(&mut Value)| {
        error_after(|b| {
            let mut second = b.json["meshes"][0]["primitives"][0].clone();
            edit(&mut second);
            b.json["meshes"][0]["primitives"]
                .as_array_mut()
                .expect("a mesh has primitives")
                .push(second);
        })
    };
    let mut messages = Vec::new();
    for name in [
        "POSITION",
        "NORMAL",
        "TANGENT",
        "TEXCOORD_0",
        "TEXCOORD_1",
        "COLOR_0",
        "JOINTS_0",
        "WEIGHTS_0",
    ] {
        let message = primitive(&|second| second["attributes"][name] = missing.clone());
        messages.push((name, message));
    }
    messages.push((
        "indices",
        primitive(&|second| second["indices"] = missing.clone()),
    ));
    for name in ["POSITION", "NORMAL", "TANGENT"] {
        let message = primitive(&|second| second["targets"][0][name] = missing.clone());
        messages.push((name, message));
    }
    for (name, message) in messages {
        println!("{name}: {message}");
        assert_names(&message, &["mesh 0 primitive 1", "accessor 90"]);
    }

    let message = error_after(|b| b.json["skins"][0]["inverseBindMatrices"] = json!(90));
    assert_names(&message, &["skin 0", "accessor 90"]);
    for end in ["input", "output"] {
        let message = error_after(|b| {
            let sampler = b.json["animations"][0]["channels"][1]["sampler"]
                .as_u64()
                .expect("a channel has a sampler");
            b.json["animations"][0]["samplers"][sampler as usize][end] = json!(90);
        });
        assert_names(&message, &["animation 0 channel", "accessor 90"]);
    }
    for name in ["TRANSLATION", "ROTATION", "SCALE"] {
        let message = error_after(|b| {
            b.json["nodes"][0]["extensions"] = json!({"EXT_mesh_gpu_instancing": {"attributes": {name: 90}}});
        });
        assert_names(&message, &["node 0", name, "90"]);
    }
}

#[test]
fn a_vertex_index_out_of_range_names_mesh_primitive_and_index() {
    let message = error_after(|b| {
        let indices = b.indices_u16(&[0, 1, 9]);
        b.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    });
    assert_names(&message, &["mesh 0 primitive 0", "index 9", "4 vertices"]);
}

#[test]
fn accessors_past_their_buffer_are_named() {
    type Edit = fn(&mut Builder);
    let cases: [(Edit, &[&str]); 12] = [
        (
            |b| b.json["accessors"][0]["count"] = json!(5),
            &["accessor 0", "buffer view 0"],
        ),
        (
            |b| b.json["accessors"][0]["count"] = json!(u64::MAX),
            &["accessor 0"],
        ),
        (
            |b| b.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
            &["accessor 0"],
        ),
        (
            |b| b.json["accessors"][0]["byteOffset"] = json!(1),
            &["accessor 0"],
        ),
        (
            |b| b.json["bufferViews"][0]["byteLength"] = json!(1u64 << 40),
            &["accessor 0", "buffer view 0", "buffer 0"],
        ),
        (
            |b| b.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
            &["accessor 0", "buffer view 0"],
        ),
        (
            |b| b.json["bufferViews"][0]["byteStride"] = json!(4),
            &["accessor 0", "byteStride 4"],
        ),
        (
            |b| b.json["bufferViews"][0]["byteStride"] = json!(u64::MAX),
            &["accessor 0"],
        ),
        (
            |b| b.json["accessors"][0]["type"] = json!("VEC2"),
            &["accessor 0", "Vec2"],
        ),
        (
            |b| b.json["accessors"][0]["componentType"] = json!(1),
            &["accessor 0"],
        ),
        (
            |b| b.json["accessors"][2]["componentType"] = json!(F32),
            &["accessor 2"],
        ),
        (
            |b| b.json["accessors"][1]["count"] = json!(3),
            &["accessor 1", "NORMAL"],
        ),
    ];
    for (edit, parts) in cases {
        assert_names(&error_after(edit), parts);
    }
    let message = error_after(|b| b.json["buffers"] = json!([{"byteLength": 1 << 30}]));
    assert_names(&message, &["buffer 0", "1073741824"]);
    let message = error_after(|b| b.json["buffers"] = json!([{"byteLength": 4, "uri": "data:;base64,A*"}]));
    assert_names(&message, &["buffer 0", "base64"]);
    let message =
        error_after(|b| b.json["buffers"] = json!([{"byteLength": 4, "uri": "https://example.org/a"}]));
    assert_names(&message, &["buffer 0", "https"]);
    let bytes = error_after(|b| b.json["buffers"] = json!([{"byteLength": 4, "uri": "gone.bin"}]));
    assert_names(&bytes, &["buffer 0", "gone.bin"]);
    let file = {
        let mut builder = quad();
        builder.json["buffers"] = json!([{"byteLength": 4, "uri": "gone.bin"}]);
        load_gltf_slice(&builder.glb(), Some(Path::new("no/folder")), "test.glb")
            .unwrap_err()
            .to_string()
    };
    assert_names(&file, &["buffer 0", "no/folder/gone.bin"]);
}

#[test]
fn sparse_accessors_out_of_range_are_named() {
    let sparse = |count: u64, place: u8| {
        error_after(|b| {
            let places = b.view(&[place]);
            let values = b.view(&[0; 12]);
            b.json["accessors"][0]["sparse"] = json!({"count": count,
                "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": values}});
        })
    };
    assert_names(&sparse(1, 4), &["accessor 0", "sparse index 4"]);
    assert_names(&sparse(2, 0), &["accessor 0"]);
    assert_names(&sparse(u64::MAX, 0), &["accessor 0", "sparse"]);
}

#[test]
fn huge_counts_are_refused_before_memory_is_taken() {
    // no view: all zeros, as many as one likes
    let message = error_after(|b| {
        let accessor = json!({"componentType": F32, "type": "VEC3", "count": 1u64 << 50});
        let accessor = b.push("accessors", accessor);
        b.json["meshes"][0]["primitives"][0] = json!({"attributes": {"POSITION": accessor}});
        b.json["nodes"][0].as_object_mut().unwrap().remove("skin");
    });
    assert_names(&message, &["accessor", "limit"]);
}

/// A buffer without bytes is no placeholder any more when a mesh or an animation reads it.
#[test]
fn a_missing_buffer_names_the_element_that_reads_it() {
    type Edit = fn(&mut Builder, Value);
    let edits: [(Edit, &str); 4] = [
        (
            |b, accessor| b.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = accessor,
            "mesh 0 primitive 0",
        ),
        (
            |b, accessor| b.json["meshes"][0]["primitives"][0]["targets"][0]["NORMAL"] = accessor,
            "mesh 0 primitive 0",
        ),
        (
            |b, accessor| b.json["animations"][0]["samplers"][1]["output"] = accessor,
            "animation 0 channel 1",
        ),
        (
            |b, accessor| b.json["skins"][0]["inverseBindMatrices"] = accessor,
            "skin 0",
        ),
    ];
    for (edit, user) in edits {
        let mut index = 0;
        let message = error_after(|b| {
            b.json["buffers"] = json!([{"byteLength": b.binary.len()}, {"byteLength": 999}]);
            let view = b.push("bufferViews", json!({"buffer": 1, "byteLength": 512}));
            let kind = match user {
                "skin 0" => "MAT4",
                "animation 0 channel 1" => "SCALAR",
                _ => "VEC3",
            };
            let count = if kind == "VEC3" { 4 } else { 2 };
            index = b.push(
                "accessors",
                json!({"bufferView": view, "componentType": F32, "type": kind, "count": count}),
            );
            edit(b, json!(index));
        });
        let accessor = format!("accessor {index}");
        assert_names(&message, &[user, &accessor, "buffer 1: it has no URI"]);
    }
}
