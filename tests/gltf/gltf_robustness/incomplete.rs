//! Reports of surfaces that are drawn otherwise than their author meant.

use antumbra::scene::AlphaMode;
use antumbra::scene::gltf_import::SkipKind;
use serde_json::json;

use super::exercise;
use crate::gltf_builder::*;
use crate::in_the_world::materials::texture;

#[test]
fn textures_without_their_coordinates_are_reported() {
    let mut builder = quad();
    let image = texture(&mut builder, 1, &[[255, 255, 255, 0]]);
    builder.json["materials"] = json!([{
        "alphaMode": "MASK",
        "pbrMetallicRoughness": {"baseColorTexture": {"index": image, "texCoord": 1}},
        "emissiveTexture": {"index": image},
    }]);
    builder.json["meshes"][0]["primitives"][0]["material"] = json!(0);
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::Texture), 2, "{}", gltf.report);
    assert!(
        gltf.report.to_string().contains("mesh 0 primitive 0"),
        "{}",
        gltf.report
    );
    exercise(&gltf);

    let coordinates = builder.floats(&[[0.5, 0.5]; 4]);
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(coordinates);
    let told = builder.load().report.to_string();
    assert!(
        told.contains("TEXCOORD_0") && !told.contains("TEXCOORD_1"),
        "{told}"
    );
}

#[test]
fn primitives_without_area_are_reported() {
    for accessor in ["POSITION", "indices"] {
        let mut builder = quad();
        let primitive = &builder.json["meshes"][0]["primitives"][0];
        let index = match accessor {
            "indices" => &primitive["indices"],
            name => &primitive["attributes"][name],
        };
        let index = index.as_u64().unwrap() as usize;
        builder.json["accessors"][index]
            .as_object_mut()
            .unwrap()
            .remove("bufferView");
        let gltf = builder.load();
        assert_eq!(gltf.report.count(SkipKind::EmptyPrimitive), 1, "{accessor}");
        exercise(&gltf);
        // A target may give it one.
        let target = builder.floats(&QUAD);
        builder.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": target}]);
        assert_eq!(builder.load().report.count(SkipKind::EmptyPrimitive), 0);
    }
    assert!(quad().load().report.is_empty());
}

#[test]
fn an_unknown_alpha_mode_is_reported() {
    let mut builder = quad();
    builder.json["materials"] = json!([{"alphaMode": "FOO"}]);
    let gltf = builder.load();
    assert_eq!(gltf.materials[0].alpha_mode, AlphaMode::Opaque);
    assert_eq!(gltf.report.count(SkipKind::MaterialValue), 1);
}

#[test]
fn primitives_without_the_joints_of_their_mesh_are_reported() {
    let mut builder = animated();
    let mut without = builder.json["meshes"][0]["primitives"][0].clone();
    for name in ["JOINTS_0", "WEIGHTS_0"] {
        without["attributes"].as_object_mut().unwrap().remove(name);
    }
    let primitives = builder.json["meshes"][0]["primitives"].as_array_mut().unwrap();
    primitives.push(without);
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::VertexData), 4, "{}", gltf.report);
    assert!(
        gltf.report.to_string().contains("mesh 0 primitive 1"),
        "{}",
        gltf.report
    );
    exercise(&gltf);
    assert!(animated().load().report.is_empty());
}
