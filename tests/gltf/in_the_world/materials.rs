//! Materials of other models: see-through ones, and specular-glossiness.

use std::io::Cursor;

use antumbra::scene::gltf_import::SkipKind;
use antumbra::scene::{AlphaMode, Material};
use glam::{Vec3, Vec4};
use serde_json::{Value, json};

use crate::gltf_builder::*;

fn material(json: Value) -> Material {
    let mut builder = quad();
    builder.json["materials"] = json!([json]);
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    (*gltf.materials[0]).clone()
}

/// Adds a texture of these texels, `width` in a row. Returns its index.
pub fn texture(builder: &mut Builder, width: u32, texels: &[[u8; 4]]) -> usize {
    let height = texels.len() as u32 / width;
    let pixels = image::RgbaImage::from_raw(width, height, texels.as_flattened().to_vec()).unwrap();
    let mut bytes = Cursor::new(Vec::new());
    pixels.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    let view = builder.view(&bytes.into_inner());
    let image = builder.push("images", json!({"bufferView": view, "mimeType": "image/png"}));
    builder.push("textures", json!({"source": image}))
}

pub fn glass(transmission: Value, others: Value) -> Value {
    let mut extensions = json!({"KHR_materials_transmission": transmission});
    for (name, value) in others.as_object().unwrap() {
        extensions[name] = value.clone();
    }
    json!({"pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.0}, "extensions": extensions})
}

#[test]
fn what_transmits_is_seen_through() {
    let clear = material(glass(json!({"transmissionFactor": 1.0}), json!({})));
    assert_eq!(clear.alpha_mode, AlphaMode::Blend);
    assert!(
        (clear.base_color.w - 0.04).abs() < 1e-6,
        "what glass reflects: {}",
        clear.base_color.w
    );
    let half = material(glass(json!({"transmissionFactor": 0.5}), json!({})));
    assert!((half.base_color.w - 0.52).abs() < 1e-6);
    // A denser medium reflects more; one of no density nothing.
    let diamond = material(glass(
        json!({"transmissionFactor": 1.0}),
        json!({"KHR_materials_ior": {"ior": 2.42}}),
    ));
    assert!(
        (diamond.base_color.w - 0.1724).abs() < 1e-3,
        "{}",
        diamond.base_color.w
    );
    let air = material(glass(
        json!({"transmissionFactor": 1.0}),
        json!({"KHR_materials_ior": {"ior": 1.0}}),
    ));
    assert_eq!(air.base_color.w, 0.0);
    // A volume absorbs by its thickness.
    let volume = |thickness: f32| {
        let volume = json!({"thicknessFactor": thickness, "attenuationDistance": 2.0, "attenuationColor": [0.25, 0.25, 0.25]});
        material(glass(
            json!({"transmissionFactor": 1.0}),
            json!({"KHR_materials_volume": volume}),
        ))
        .base_color
        .w
    };
    for (thickness, passing) in [(0.0, 1.0), (1.0, 0.5), (2.0, 0.25)] {
        assert!(
            (volume(thickness) - (1.0 - 0.96 * passing)).abs() < 1e-5,
            "{thickness}: {}",
            volume(thickness)
        );
    }
    // Without the factor, and for a metal, the surface stays as it is.
    for factor in [json!({}), json!({"transmissionFactor": 0.0})] {
        let solid = material(glass(factor, json!({})));
        assert_eq!((solid.alpha_mode, solid.base_color.w), (AlphaMode::Opaque, 1.0));
    }
    let mut metal = glass(json!({"transmissionFactor": 1.0}), json!({}));
    metal["pbrMetallicRoughness"]["metallicFactor"] = json!(1.0);
    assert_eq!(material(metal).base_color.w, 1.0);
}

#[test]
fn textures_say_where_it_is_seen_through() {
    let mut builder = quad();
    let base = texture(
        &mut builder,
        2,
        &[
            [255, 255, 255, 255],
            [255, 255, 255, 0],
            [0, 0, 0, 255],
            [0, 0, 0, 0],
        ],
    );
    let share = texture(&mut builder, 1, &[[255, 0, 0, 255], [0, 255, 0, 255]]);
    let extension = json!({"transmissionFactor": 1.0, "transmissionTexture": {"index": share}});
    let mut json = glass(extension, json!({}));
    json["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": base});
    builder.json["materials"] = json!([json, json, json]);
    builder.json["materials"][1]["alphaMode"] = json!("MASK");
    builder.json["materials"][2]["extensions"]["KHR_materials_transmission"]["transmissionTexture"]["texCoord"] =
        json!(1);
    let gltf = builder.load();
    let alphas = |index: usize| {
        let slot = gltf.materials[index].base_color_texture.clone().unwrap();
        assert_eq!(gltf.materials[index].base_color, Vec4::ONE);
        let texels: Vec<[u8; 4]> = slot.texture.rgba8.as_chunks::<4>().0.to_vec();
        assert_eq!(texels[0][..3], [255; 3], "colours stay");
        texels.iter().map(|texel| texel[3]).collect::<Vec<_>>()
    };
    // Opaque: the alpha of the texture has no meaning. White transmits all but the reflection where the share is 1.
    assert_eq!(alphas(0), [10, 10, 255, 255]);
    // What the mask cuts away is not there at all.
    assert_eq!(alphas(1), [10, 0, 255, 0]);
    // Another set of coordinates: the mean of the shares.
    assert_eq!(gltf.report.count(SkipKind::Texture), 1);
    assert_eq!(alphas(2), [133, 133, 255, 255]);
}

#[test]
fn specular_glossiness_becomes_metallic_roughness() {
    let of = |extension: Value| {
        material(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": extension}}))
    };
    let plastic = of(
        json!({"diffuseFactor": [0.5, 0.25, 0.1, 0.5], "specularFactor": [0.04, 0.04, 0.04], "glossinessFactor": 0.75}),
    );
    assert_eq!(
        (plastic.metallic, plastic.roughness, plastic.base_color.w),
        (0.0, 0.25, 0.5)
    );
    assert!(plastic.base_color.truncate().distance(Vec3::new(0.5, 0.25, 0.1)) < 1e-6);
    let gold = of(json!({"diffuseFactor": [0.0, 0.0, 0.0, 1.0], "specularFactor": [1.0, 0.71, 0.29]}));
    assert!(gold.metallic > 0.99 && gold.roughness == 0.0, "{gold:?}");
    assert!(gold.base_color.truncate().distance(Vec3::new(1.0, 0.71, 0.29)) < 0.01);
    // It counts more than metallic-roughness beside it.
    let both = material(json!({
        "pbrMetallicRoughness": {"baseColorFactor": [1.0, 0.0, 0.0, 1.0]},
        "extensions": {"KHR_materials_pbrSpecularGlossiness": {"specularFactor": [0.0, 0.0, 0.0]}},
    }));
    assert_eq!(
        both.base_color.y, 1.0,
        "white has more than 0.96 of itself and is clamped"
    );
}

#[test]
fn specular_and_diffuse_textures_are_converted_together() {
    let mut builder = quad();
    // Left plastic, right gold.
    let diffuse = texture(&mut builder, 2, &[[188, 0, 0, 255], [0, 0, 0, 128]]);
    let specular = texture(&mut builder, 2, &[[56, 56, 56, 0], [255, 219, 148, 255]]);
    let extension =
        json!({"diffuseTexture": {"index": diffuse}, "specularGlossinessTexture": {"index": specular}});
    let of = |extension: &Value| json!({"extensions": {"KHR_materials_pbrSpecularGlossiness": extension}});
    let mut split = extension.clone();
    split["diffuseTexture"]["texCoord"] = json!(1);
    let dielectric = json!({"diffuseTexture": {"index": diffuse}, "specularFactor": [0.0, 0.0, 0.0]});
    builder.json["materials"] = json!([of(&extension), of(&split), of(&dielectric)]);
    let gltf = builder.load();
    let texels = |slot: &Option<antumbra::scene::TextureSlot>| -> Vec<[u8; 4]> {
        slot.as_ref().unwrap().texture.rgba8.as_chunks::<4>().0.to_vec()
    };
    let converted = &gltf.materials[0];
    assert_eq!(
        (converted.metallic, converted.roughness, converted.base_color),
        (1.0, 1.0, Vec4::ONE)
    );
    let base = texels(&converted.base_color_texture);
    assert!(
        (186..=190).contains(&base[0][0]) && base[0][1] < 3 && base[0][3] == 255,
        "{base:?}"
    );
    assert!(
        base[1]
            .iter()
            .zip([255, 219, 148, 128])
            .all(|(&a, b)| a.abs_diff(b) <= 3),
        "{base:?}"
    );
    let surface = texels(&converted.metallic_roughness_texture);
    assert_eq!(
        (surface[0][1], surface[1][1]),
        (255, 0),
        "glossiness turned around"
    );
    assert!(surface[0][2] < 5 && surface[1][2] > 250, "{surface:?}");
    // Two sets of coordinates cannot become one texture.
    assert_eq!(gltf.report.count(SkipKind::Texture), 1);
    assert_eq!(gltf.materials[1].base_color_texture.as_ref().unwrap().uv_set, 1);
    // Without metal the diffuse texture is used as it is.
    let plain = &gltf.materials[2];
    assert_eq!(
        (plain.metallic, texels(&plain.base_color_texture)[0]),
        (0.0, [188, 0, 0, 255])
    );
}
