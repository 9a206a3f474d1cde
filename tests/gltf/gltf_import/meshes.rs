//! Triangles, vertices and submeshes.

use antumbra::scene::gltf_import::SkipKind;
use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

use super::assert_near;
use crate::gltf_builder::*;

fn indices_of_mode(mode: u32, indices: &[u16]) -> Vec<u32> {
    let mut builder = quad();
    let accessor = builder.indices_u16(indices);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
    builder.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
    builder.load().meshes[0].data.indices.clone()
}

#[test]
fn triangles_strips_and_fans_become_triangle_lists() {
    assert_eq!(indices_of_mode(4, &[0, 1, 2, 2, 1, 3]), [0, 1, 2, 2, 1, 3]);
    assert_eq!(indices_of_mode(5, &[0, 1, 2, 3]), [0, 1, 2, 1, 3, 2]);
    assert_eq!(indices_of_mode(6, &[0, 1, 3, 2]), [1, 3, 0, 3, 2, 0]);
}

#[test]
fn points_and_lines_are_counted_and_not_drawn() {
    for mode in 0..=3 {
        let mut builder = quad();
        builder.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let gltf = builder.load();
        assert_eq!(gltf.triangle_count(), 0);
        assert_eq!(gltf.report.count(SkipKind::DrawMode), 1);
        assert!(
            gltf.report
                .to_string()
                .starts_with("mesh 0 primitive 0: skipped 1 points or lines")
        );
        assert_eq!(gltf.report.to_string().lines().count(), 1);
    }
}

#[test]
fn indices_of_every_width_and_none() {
    let wide: Vec<u8> = [2u32, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect();
    let middle: Vec<u8> = [2u16, 1, 0].iter().flat_map(|i| i.to_le_bytes()).collect();
    for (bytes, component) in [(vec![2u8, 1, 0], U8), (middle, U16), (wide, U32)] {
        let mut builder = quad();
        let accessor = builder.accessor(&bytes, component, "SCALAR", 3);
        builder.json["meshes"][0]["primitives"][0]["indices"] = json!(accessor);
        assert_eq!(builder.load().meshes[0].data.indices, [2, 1, 0]);
    }
    assert_eq!(triangle().load().meshes[0].data.indices, [0, 1, 2]);
}

#[test]
fn absent_normals_are_flat_and_split_vertices() {
    let mut builder = quad();
    builder.binary[3 * 12 + 8..3 * 12 + 12].copy_from_slice(&1.0f32.to_le_bytes()); // bends the fourth corner up
    let attributes = builder.json["meshes"][0]["primitives"][0]["attributes"]
        .as_object_mut()
        .unwrap();
    attributes.remove("NORMAL");
    let gltf = builder.load();
    let mesh = &gltf.meshes[0].data;
    assert_eq!((mesh.positions.len(), mesh.indices.len()), (6, 6));
    assert_eq!(mesh.normals[..3], [Vec3::Z; 3]);
    let bent = Vec3::new(-1.0, -1.0, 1.0).normalize();
    for &normal in &mesh.normals[3..] {
        assert_near(normal, bent);
    }
}

#[test]
fn sparse_values_replace_dense_ones_and_zeros() {
    let mut builder = triangle();
    let places = builder.view(&[1, 2]);
    let values: Vec<u8> = [5.0f32, 6.0, 7.0, 8.0, 9.0, 10.0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let values = builder.view(&values);
    let sparse = json!({
        "count": 2, "indices": {"bufferView": places, "componentType": U8}, "values": {"bufferView": values}
    });
    builder.json["accessors"][0]["sparse"] = sparse.clone();
    let expected = [Vec3::ZERO, Vec3::new(5.0, 6.0, 7.0), Vec3::new(8.0, 9.0, 10.0)];
    assert_eq!(builder.load().meshes[0].data.positions, expected);

    builder.json["accessors"][0]
        .as_object_mut()
        .unwrap()
        .remove("bufferView");
    assert_eq!(builder.load().meshes[0].data.positions, expected);
}

#[test]
fn normalized_integers_and_strides() {
    let mut builder = quad();
    // 16-bit positions in a stride of 8, normalised: −32768 is clamped to −1
    let shorts: [i16; 16] = [0, 0, 0, 9, 32767, 0, 0, 9, 0, -32768, 0, 9, 0, 0, -32767, 9];
    let bytes: Vec<u8> = shorts.iter().flat_map(|x| x.to_le_bytes()).collect();
    let positions = builder.accessor(&bytes[..30], 5122, "VEC3", 4);
    let view = builder.json["accessors"][positions]["bufferView"]
        .as_u64()
        .unwrap() as usize;
    builder.json["bufferViews"][view]["byteStride"] = json!(8);
    builder.json["accessors"][positions]["normalized"] = json!(true);
    let uv = builder.accessor(&[0, 255, 51, 0, 0, 0, 0, 0], U8, "VEC2", 4);
    builder.json["accessors"][uv]["normalized"] = json!(true);
    let colors = builder.accessor(&[255, 0, 51, 0, 0, 0, 0, 0, 0, 255, 255, 255], U8, "VEC3", 4);
    builder.json["accessors"][colors]["normalized"] = json!(true);
    let attributes = &mut builder.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["POSITION"] = json!(positions);
    attributes["TEXCOORD_1"] = json!(uv);
    attributes["COLOR_0"] = json!(colors);
    builder.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
    let gltf = builder.load();
    let mesh = &gltf.meshes[0].data;
    assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, -Vec3::Y, -Vec3::Z]);
    assert_eq!(mesh.uv1[..2], [Vec2::new(0.0, 1.0), Vec2::new(0.2, 0.0)]);
    assert!(mesh.uv0.is_empty());
    assert_eq!(mesh.colors[0], Vec4::new(1.0, 0.0, 0.2, 1.0));
}

#[test]
fn primitives_become_submeshes_and_missing_streams_are_filled() {
    let mut builder = quad();
    let (positions, uv) = (builder.floats(&TRIANGLE), builder.floats(&[[0.5, 0.25]; 3]));
    let shared = builder.indices_u16(&[1, 3, 2]);
    builder.push(
        "materials",
        json!({"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]}}),
    );
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    let mut third = primitives[0].clone();
    third["indices"] = json!(shared);
    primitives.push(json!({"attributes": {"POSITION": positions, "TEXCOORD_0": uv}, "material": 0}));
    primitives.push(third);
    let gltf = builder.load();
    let mesh = &gltf.meshes[0];
    let ranges: Vec<_> = mesh
        .data
        .submeshes
        .iter()
        .map(|s| (s.first_index, s.index_count))
        .collect();
    assert_eq!(ranges, [(0, 6), (6, 3), (9, 3)]);
    assert_eq!(
        mesh.data.positions.len(),
        7,
        "the third primitive shares the vertices of the first"
    );
    assert_eq!(mesh.data.indices[6..], [4, 5, 6, 1, 3, 2]);
    assert_eq!(
        mesh.data.uv0,
        [[Vec2::ZERO; 4].as_slice(), &[Vec2::new(0.5, 0.25); 3]].concat()
    );
    let names: Vec<_> = mesh
        .materials
        .iter()
        .map(|material| material.name.as_str())
        .collect();
    assert_eq!(names, ["default", "red", "default"]);
}
