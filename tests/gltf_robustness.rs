//! Bad glTF files are errors that name the element, or are loaded with a report; none panics, hangs or takes
//! all memory.

mod gltf_builder;

use std::path::Path;
use std::sync::OnceLock;

use antumbra::scene::gltf_import::{
    GltfError, LoadedGltf, MAX_NODE_DEPTH, SkipKind, load_gltf, load_gltf_slice, spawn_scene,
};
use antumbra::scene::{PosedMesh, SceneMesh, WorldBounds, apply_animation};
use bevy_ecs::prelude::*;
use gltf_builder::*;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;
use serde_json::json;

#[track_caller]
fn assert_names(message: &str, parts: &[&str]) {
    for part in parts.iter().chain(&["test.gl"]) {
        assert!(message.contains(part), "{message:?} does not name {part:?}");
    }
}

#[test]
#[should_panic(expected = "does not name")]
fn assert_names_fails_without_the_element() {
    assert_names("test.glb: accessor 1: broken", &["accessor 2"]);
}

fn slice_error(bytes: &[u8]) -> String {
    load_gltf_slice(bytes, None, "test.glb").unwrap_err().to_string()
}

/// The error of a good file after an edit of its JSON.
fn error_after(edit: impl FnOnce(&mut Builder)) -> String {
    let mut builder = animated();
    builder.load();
    edit(&mut builder);
    builder.error()
}

#[test]
fn missing_and_truncated_files() {
    let missing = load_gltf("no/such/test.glb").unwrap_err();
    assert!(matches!(missing, GltfError::Io { .. }));
    assert_names(&missing.to_string(), &["no/such/test.glb"]);
    assert!(load_gltf(Path::new("src")).is_err(), "a folder is not a file");

    let good = quad().glb();
    assert_names(&slice_error(&good[..8]), &["GLB", "12 bytes"]);
    assert_names(&slice_error(&good[..good.len() - 4]), &["GLB", "the file has"]);
    for length in 0..good.len() {
        assert!(
            load_gltf_slice(&good[..length], None, "test.glb").is_err(),
            "{length}"
        );
    }
    let mut chunk = good.clone();
    chunk[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    assert_names(&slice_error(&chunk), &["chunk 0", "4294967295"]);
    let mut version = good;
    version[4] = 1;
    assert_names(&slice_error(&version), &["version 1"]);
}

#[test]
fn malformed_json_names_the_line() {
    assert_names(
        &slice_error(b"{\"asset\": {\n\"version\": }}"),
        &["JSON", "line 2"],
    );
    assert_names(&slice_error(b""), &["JSON"]);
    assert_names(
        &slice_error(b"{\"asset\": {\"version\": \"1.0\"}}"),
        &["version \"1.0\""],
    );
    assert_names(&slice_error("[".repeat(100_000).as_bytes()), &["JSON"]);
}

#[test]
fn required_extensions_are_named() {
    let message = error_after(|b| b.json["extensionsRequired"] = json!(["KHR_draco_mesh_compression"]));
    assert_names(&message, &["KHR_draco_mesh_compression"]);
    let mut builder = quad();
    builder.json["extensionsUsed"] = json!(["KHR_materials_transmission"]);
    assert_eq!(builder.load().report.count(SkipKind::Extension), 1);
}

#[test]
fn indices_out_of_range_name_both_ends() {
    type Edit = fn(&mut Builder);
    let cases: [(Edit, &[&str]); 17] = [
        (
            |b| b.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(99),
            &["accessor 99"],
        ),
        (
            |b| b.json["meshes"][0]["primitives"][0]["indices"] = json!(98),
            &["accessor 98"],
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
    assert_names(
        &error_after(|b| b.json["scenes"][0]["nodes"] = json!([0, 2])),
        &["scene 0", "node 2"],
    );
    assert_names(
        &error_after(|b| b.json["scenes"][0]["nodes"] = json!([0, 0])),
        &["scene 0", "node 0 twice"],
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

/// Loads, poses at a few times, and checks that nothing that is drawn holds a number that is not finite.
fn exercise(gltf: &LoadedGltf) {
    for scene in 0..gltf.scenes.len().min(2) {
        let (mut world, mut schedule) = frame();
        let Ok(spawned) = spawn_scene(&mut world, gltf, Some(scene)) else {
            continue;
        };
        schedule.run(&mut world);
        for clip in gltf.clips.iter().take(2) {
            apply_animation(&mut world, &spawned, clip, clip.duration() * 0.4);
            schedule.run(&mut world);
        }
        for &entity in &spawned.meshes {
            let data = &world.get::<SceneMesh>(entity).unwrap().0;
            assert!(
                data.positions
                    .iter()
                    .chain(&data.normals)
                    .all(|vertex| vertex.is_finite())
            );
            assert!(
                data.indices
                    .iter()
                    .all(|&index| (index as usize) < data.positions.len())
            );
            assert_eq!(data.normals.len(), data.positions.len());
            if let Some(posed) = world.get::<PosedMesh>(entity) {
                assert!(
                    posed
                        .positions
                        .iter()
                        .chain(&posed.normals)
                        .all(|vertex| vertex.is_finite())
                );
                assert_eq!(posed.positions.len(), data.positions.len());
            }
        }
    }
}

#[test]
fn non_finite_positions_skip_their_triangles() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut builder = quad();
        builder.binary[3 * 12..3 * 12 + 4].copy_from_slice(&bad.to_le_bytes());
        let gltf = builder.load();
        assert_eq!(gltf.report.count(SkipKind::NonFiniteTriangle), 1);
        assert_eq!(gltf.meshes[0].data.indices, [0, 1, 2]);
        exercise(&gltf);
    }
    let mut builder = triangle();
    builder.binary[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let gltf = builder.load();
    assert_eq!(
        (gltf.triangle_count(), gltf.report.count(SkipKind::EmptyPrimitive)),
        (0, 1)
    );
    assert!(gltf.report.to_string().contains("mesh 0 primitive 0"));
    exercise(&gltf);
}

#[test]
fn zero_and_degenerate_triangles() {
    let mut builder = quad();
    let empty = builder.indices_u16(&[]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(empty);
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::EmptyPrimitive), 1);
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    schedule.run(&mut world);
    assert!(world.get::<WorldBounds>(spawned.meshes[0]).unwrap().0.is_empty());

    let mut builder = quad();
    let degenerate = builder.indices_u16(&[0, 0, 1, 1, 1, 1, 0, 1]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(degenerate);
    let gltf = builder.load();
    assert_eq!(
        (
            gltf.triangle_count(),
            gltf.report.count(SkipKind::IncompleteTriangle)
        ),
        (2, 2)
    );
    exercise(&gltf);
}

#[test]
fn unusable_node_transforms_are_loaded_and_counted() {
    for edit in [
        json!({"scale": [1, 0, 1]}),
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
fn textures_that_cannot_be_had_are_reported() {
    let image = |image: serde_json::Value| {
        let mut builder = quad();
        builder.push("images", json!({"uri": "data:image/png;base64,"}));
        builder.push("images", image);
        builder.push("textures", json!({"source": 1}));
        builder.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        let gltf = load_gltf_slice(&builder.glb(), Some(Path::new("no/folder")), "test.glb").unwrap();
        assert!(gltf.materials[0].base_color_texture.is_none());
        assert_eq!(gltf.report.count(SkipKind::Texture), 1);
        gltf.report.to_string()
    };
    let missing = image(json!({"uri": "gone.png"}));
    assert!(
        missing.contains("image 1") && missing.contains("no/folder/gone.png"),
        "{missing}"
    );
    let undecodable = image(json!({"uri": "data:image/png;base64,AAAA"}));
    assert!(undecodable.contains("image 1"), "{undecodable}");
    assert!(image(json!({})).contains("image 1"));
}

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

/// Files to break: small ones of our own, and two models where there are some.
fn seeds() -> &'static [Vec<u8>] {
    static SEEDS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    SEEDS.get_or_init(|| {
        let mut seeds = vec![triangle().glb(), quad().glb(), animated().glb()];
        if let Ok(folder) = std::env::var("ANTUMBRA_MODELS") {
            for name in ["fox.glb", "morph_stress_test.glb"] {
                seeds.push(std::fs::read(Path::new(&folder).join("look/c-animated").join(name)).unwrap());
            }
        } else {
            eprintln!("ANTUMBRA_MODELS names no folder of models: small files only");
        }
        seeds
    })
}

fn json_range(glb: &[u8]) -> std::ops::Range<usize> {
    20..20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize
}

#[test]
fn mutated_files_never_panic() {
    let edits = prop::collection::vec((any::<prop::sample::Index>(), 0u8..4, any::<u8>()), 1..12);
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let loaded_count = std::cell::Cell::new(0);
    let case_count = config.cases;
    let mut runner = TestRunner::new(config);
    let outcome = runner.run(&(0usize..5, edits), |(seed, edits)| {
        let seeds = seeds();
        let mut bytes = seeds[seed % seeds.len()].clone();
        let json = json_range(&bytes);
        let digits: Vec<usize> = json.clone().filter(|&i| bytes[i].is_ascii_digit()).collect();
        for (place, kind, value) in edits {
            let binary = json.end..bytes.len();
            match kind {
                // digits keep the JSON whole, so that numbers change
                0 | 1 => bytes[digits[place.index(digits.len())]] = b'0' + value % 10,
                2 => bytes[binary.start + place.index(binary.len())] = value,
                // one in sixteen: most of these only break the JSON
                _ if value < 16 => bytes[place.index(json.end)] = value.wrapping_mul(17),
                _ => {}
            }
        }
        if let Ok(gltf) = load_gltf_slice(&bytes, None, "mutated.glb") {
            exercise(&gltf);
            loaded_count.set(loaded_count.get() + 1);
        }
        Ok(())
    });
    outcome.unwrap();
    let loaded_count: u32 = loaded_count.get();
    eprintln!("{loaded_count} of {case_count} mutated files load");
    assert!(
        loaded_count * 20 > case_count,
        "{loaded_count} of {case_count} load: nothing is tested"
    );
}

#[test]
fn seeds_themselves_load() {
    for seed in seeds() {
        exercise(&load_gltf_slice(seed, None, "seed.glb").unwrap());
    }
}
