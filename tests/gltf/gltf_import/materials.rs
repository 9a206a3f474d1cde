//! Materials with their textures, and buffers that lie elsewhere.

use antumbra::scene::gltf_import::{load_gltf, load_gltf_slice};
use antumbra::scene::{AlphaMode, TextureWrap};
use base64::Engine;
use glam::{Vec2, Vec3, Vec4};
use serde_json::json;

use crate::gltf_builder::*;

fn png(width: u32, height: u32) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let pixels = image::RgbaImage::from_pixel(width, height, image::Rgba([10, 20, 30, 40]));
    pixels.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn data_uri(bytes: &[u8]) -> String {
    format!(
        "data:application/octet-stream;base64,{}",
        base64::engine::general_purpose::STANDARD.encode(bytes)
    )
}

#[test]
fn materials_with_every_texture() {
    let mut builder = quad();
    let view = builder.view(&png(2, 3));
    builder.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    builder.push("images", json!({"uri": data_uri(&png(1, 1))}));
    builder.push(
        "samplers",
        json!({"wrapS": 33071, "wrapT": 33648, "magFilter": 9728, "minFilter": 9984}),
    );
    builder.push("textures", json!({"source": 0, "sampler": 0}));
    builder.push("textures", json!({"source": 1}));
    let turned = json!({"KHR_texture_transform": {
        "offset": [0.5, 0.25], "rotation": std::f32::consts::FRAC_PI_2, "scale": [2.0, 3.0], "texCoord": 1}});
    builder.json["materials"] = json!([{
        "name": "all", "alphaMode": "MASK", "alphaCutoff": 0.25, "doubleSided": true,
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.1, 0.2, 0.3, 0.4], "metallicFactor": 0.5, "roughnessFactor": 0.75,
            "baseColorTexture": {"index": 0, "extensions": turned},
            "metallicRoughnessTexture": {"index": 1, "texCoord": 1}},
        "normalTexture": {"index": 1, "scale": 2.0, "extensions": turned},
        "occlusionTexture": {"index": 0, "strength": 0.5, "extensions": turned},
        "emissiveTexture": {"index": 1}, "emissiveFactor": [1.0, 0.5, 0.0],
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
    }, {"alphaMode": "BLEND", "emissiveFactor": [1.0, 0.5, 0.0], "emissiveTexture": {"index": 1},
        "extensions": {"KHR_materials_unlit": {}}}]);
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let material = &gltf.materials[0];
    assert_eq!(material.base_color, Vec4::new(0.1, 0.2, 0.3, 0.4));
    assert_eq!(
        (material.metallic, material.roughness, material.normal_scale),
        (0.5, 0.75, 2.0)
    );
    assert_eq!(
        (material.alpha_mode, material.double_sided, material.unlit),
        (AlphaMode::Mask(0.25), true, false)
    );
    assert_eq!(
        (material.emissive, material.occlusion_strength),
        (Vec3::new(4.0, 2.0, 0.0), 0.5)
    );
    let base = material.base_color_texture.as_ref().unwrap();
    assert_eq!((base.texture.width, base.texture.height, base.uv_set), (2, 3, 1));
    assert_eq!(base.texture.rgba8[..4], [10, 20, 30, 40]);
    assert_eq!(base.texture.wrap, [TextureWrap::Clamp, TextureWrap::Mirror]);
    assert!(!base.texture.linear_magnify && !base.texture.linear_minify);
    // scale gives (2, 0), a quarter turn counter-clockwise with v pointing down (0, −2), the offset (0.5, −1.75)
    for slot in [
        &material.base_color_texture,
        &material.normal_texture,
        &material.occlusion_texture,
    ] {
        let moved = slot.as_ref().unwrap().uv_transform.transform_point2(Vec2::X);
        assert!(moved.distance(Vec2::new(0.5, -1.75)) < 1e-6, "{moved}");
    }
    assert_eq!(material.metallic_roughness_texture.as_ref().unwrap().uv_set, 1);
    let normal = &material.normal_texture.as_ref().unwrap().texture;
    assert!(normal.linear_magnify && normal.linear_minify && normal.wrap == [TextureWrap::Repeat; 2]);
    let unlit = &gltf.materials[1];
    assert_eq!((unlit.alpha_mode, unlit.unlit), (AlphaMode::Blend, true));
    // Emission is meant for readers that do not know the extension.
    assert_eq!(
        (unlit.emissive, unlit.emissive_texture.is_none()),
        (Vec3::ZERO, true)
    );
}

#[test]
fn buffers_come_from_data_uris_and_encoded_file_names() {
    let builder = quad();
    let expected = builder.load().meshes[0].data.clone();
    let text = |uri: String| serde_json::to_vec(&builder.document(Some(uri))).unwrap();

    let inline = load_gltf_slice(&text(data_uri(&builder.binary)), None, "inline.gltf").unwrap();
    assert_eq!(inline.meshes[0].data, expected);
    // Neither the scheme nor the encoding has a case.
    let loud = data_uri(&builder.binary)
        .replace("data:", "DATA:")
        .replace(";base64", ";BASE64");
    let loud = load_gltf_slice(&text(loud), None, "loud.gltf").unwrap();
    assert_eq!(loud.meshes[0].data, expected);

    let folder = std::env::temp_dir().join(format!("antumbra gltf {}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("two words.bin"), &builder.binary).unwrap();
    std::fs::write(folder.join("scene.gltf"), text("two%20words.bin".to_owned())).unwrap();
    let external = load_gltf(folder.join("scene.gltf")).unwrap();
    std::fs::remove_dir_all(&folder).unwrap();
    assert_eq!(external.meshes[0].data, expected);
}
