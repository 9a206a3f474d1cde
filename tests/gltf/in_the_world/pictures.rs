//! Pictures in other formats than PNG and JPEG, and missing ones.

use antumbra::scene::gltf_import::SkipKind;
use serde_json::{Value, json};

use crate::gltf_builder::*;

/// A file whose material has one texture with one image of these bytes.
fn textured(bytes: &[u8], texture: Value, extension: &str) -> Builder {
    let mut builder = quad();
    let view = builder.view(bytes);
    builder.push("images", json!({"bufferView": view}));
    builder.push("textures", texture);
    builder.json["extensionsUsed"] = json!([extension]);
    builder.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
    builder
}

fn texels(builder: &Builder) -> (u32, u32, Vec<u8>) {
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let texture = &gltf.materials[0].base_color_texture.as_ref().unwrap().texture;
    (texture.width, texture.height, texture.rgba8.clone())
}

/// Lossless WebP of one colour. The bytes are those of a RIFF container with a VP8L chunk: size, and five prefix codes
/// of one symbol each. Source: RFC 9649.
#[cfg(feature = "gltf-webp")]
fn webp(width: u32, height: u32, [r, g, b, a]: [u8; 4]) -> Vec<u8> {
    let (mut bits, mut count) = (Vec::new(), 0u32);
    let mut put = |value: u32, width: u32| {
        for bit in 0..width {
            if count % 8 == 0 {
                bits.push(0u8);
            }
            *bits.last_mut().unwrap() |= ((value >> bit & 1) as u8) << (count % 8);
            count += 1;
        }
    };
    put(0x2f, 8);
    put(width - 1, 14);
    put(height - 1, 14);
    put(1, 1); // alpha is used
    put(0, 3); // version
    put(0, 1); // no transform
    put(0, 1); // no colour cache
    put(0, 1); // one group of prefix codes
    for symbol in [g, r, b, a, 0] {
        put(1, 1); // simple
        put(0, 1); // one symbol
        put(1, 1); // of 8 bits
        put(u32::from(symbol), 8);
    }
    let mut chunk = bits;
    let length = chunk.len() as u32;
    chunk.resize(chunk.len().next_multiple_of(2), 0);
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((chunk.len() as u32 + 12).to_le_bytes());
    bytes.extend(b"WEBPVP8L");
    bytes.extend(length.to_le_bytes());
    bytes.extend(chunk);
    bytes
}

#[cfg(feature = "gltf-webp")]
#[test]
fn webp_pictures_are_read() {
    let color = [200, 100, 50, 128];
    let texture = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    let mut builder = textured(&webp(3, 2, color), texture, "EXT_texture_webp");
    builder.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    assert_eq!(texels(&builder), (3, 2, color.repeat(6)));
    // Some exporters name it as an ordinary image.
    let plain = textured(&webp(1, 1, color), json!({"source": 0}), "KHR_texture_transform");
    assert_eq!(texels(&plain).2, color);
    // The extension counts more than the fallback beside it.
    let both = json!({"source": 7, "extensions": {"EXT_texture_webp": {"source": 0.0}}});
    assert_eq!(
        texels(&textured(&webp(1, 1, color), both, "EXT_texture_webp")).2,
        color
    );
    let cut = textured(
        &webp(3, 2, color)[..24],
        json!({"source": 0}),
        "KHR_texture_transform",
    )
    .load();
    assert_eq!(cut.report.count(SkipKind::Texture), 1);
    assert!(cut.materials[0].base_color_texture.is_none());
}

/// KTX2 with one block of UASTC of one colour, not supercompressed.
///
/// Source: KTX 2.0 specification, sections 3 and 3.12, and "UASTC Texture Data Specification", mode 8.
#[cfg(feature = "gltf-basisu")]
fn ktx2([r, g, b, a]: [u8; 4]) -> Vec<u8> {
    let mut bits = 0u128;
    let mut at = 0;
    let mut put = |value: u128, width: u32| {
        bits |= value << at;
        at += width;
    };
    put(0b10111, 5); // mode 8: one colour
    for channel in [r, g, b, a] {
        put(u128::from(channel), 8);
    }
    let block = bits.to_le_bytes();
    // Data format descriptor: one sample of 128 bits in the colour model of UASTC.
    let descriptor: [u32; 11] = [
        44,
        0,
        2 | (40 << 16),
        166 | (1 << 8) | (2 << 16),
        3 | (3 << 8),
        16,
        0,
        (127 << 16) | (3 << 24),
        0,
        0,
        u32::MAX,
    ];
    let (descriptor_at, block_at) = (104u32, 160u32);
    let mut bytes = b"\xABKTX 20\xBB\r\n\x1A\n".to_vec();
    for word in [0, 1, 4, 4, 0, 0, 1, 1, 0, descriptor_at, 44, 0, 0] {
        bytes.extend(word.to_le_bytes());
    }
    for word in [0u64, 0, u64::from(block_at), 16, 16] {
        bytes.extend(word.to_le_bytes());
    }
    assert_eq!(bytes.len(), descriptor_at as usize);
    bytes.extend(descriptor.iter().flat_map(|word| word.to_le_bytes()));
    bytes.resize(block_at as usize, 0);
    bytes.extend(block);
    bytes
}

#[cfg(feature = "gltf-basisu")]
#[test]
fn ktx2_pictures_are_read() {
    let color = [200, 100, 50, 128];
    let texture = json!({"extensions": {"KHR_texture_basisu": {"source": 0}}});
    let mut builder = textured(&ktx2(color), texture, "KHR_texture_basisu");
    builder.json["extensionsRequired"] = json!(["KHR_texture_basisu"]);
    assert_eq!(texels(&builder), (4, 4, color.repeat(16)));
    let broken = textured(&ktx2(color)[..150], json!({"source": 0}), "KHR_texture_transform").load();
    assert_eq!(broken.report.count(SkipKind::Texture), 1);
}

#[cfg(not(feature = "gltf-webp"))]
#[test]
fn without_its_feature_a_picture_is_left_out_and_the_feature_named() {
    let texture = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    let mut builder = textured(b"RIFF\0\0\0\0WEBP", texture, "EXT_texture_webp");
    assert!(builder.load().report.to_string().contains("gltf-webp"));
    builder.json["extensionsRequired"] = json!(["EXT_texture_webp"]);
    assert!(builder.error().contains("gltf-webp"));
}

#[test]
fn pictures_that_are_not_there_are_reported() {
    for image in [
        json!({"uri": "not_there.png"}),
        json!({}),
        json!({"uri": "data:image/png;base64,AAAA"}),
    ] {
        let mut builder = textured(&[], json!({"source": 0}), "KHR_texture_transform");
        builder.json["images"][0] = image;
        let gltf = builder.load();
        assert_eq!(gltf.report.count(SkipKind::Texture), 1);
        assert!(gltf.report.to_string().contains("image 0"), "{}", gltf.report);
    }
    let nothing = textured(&[], json!({}), "KHR_texture_transform").load();
    assert!(
        nothing.report.to_string().contains("texture 0"),
        "{}",
        nothing.report
    );
}

#[test]
fn pictures_in_buffers_that_are_missing_or_short_are_reported() {
    for (view, part) in [
        (json!({"buffer": 1, "byteLength": 99}), "buffer 1: it has no URI"),
        (json!({"buffer": 0, "byteLength": 1 << 20}), "runs past the end"),
    ] {
        let mut builder = textured(b"", json!({"source": 0}), "KHR_texture_transform");
        builder.json["buffers"] = json!([{"byteLength": builder.binary.len()}, {"byteLength": 999}]);
        let index = builder.push("bufferViews", view);
        builder.json["images"][0] = json!({"bufferView": index});
        let gltf = builder.load();
        assert_eq!(
            (gltf.triangle_count(), gltf.report.count(SkipKind::Texture)),
            (2, 1)
        );
        assert!(gltf.materials[0].base_color_texture.is_none());
        let text = gltf.report.to_string();
        assert!(text.contains("image 0: ") && text.contains(part), "{text}");
        // What refers to nothing is an error all the same.
        builder.json["images"][0]["bufferView"] = json!(99);
        let error = builder.error();
        assert!(error.contains("image 0: buffer view 99"), "{error}");
    }
}

/// A picture that an extension names is broken, and the texture names another one.
#[cfg(any(feature = "gltf-webp", feature = "gltf-basisu"))]
#[test]
fn a_broken_picture_leaves_the_one_beside_it() {
    let name = if cfg!(feature = "gltf-webp") {
        "EXT_texture_webp"
    } else {
        "KHR_texture_basisu"
    };
    let mut png = std::io::Cursor::new(Vec::new());
    let color = image::Rgba([10, 20, 30, 255]);
    image::RgbaImage::from_pixel(2, 1, color)
        .write_to(&mut png, image::ImageFormat::Png)
        .unwrap();
    let texture = json!({"source": 1, "extensions": {name: {"source": 0}}});
    let mut builder = textured(b"no picture", texture, name);
    let view = builder.view(&png.into_inner());
    builder.push("images", json!({"bufferView": view}));
    let gltf = builder.load();
    let texture = &gltf.materials[0].base_color_texture.as_ref().unwrap().texture;
    assert_eq!(texture.rgba8, color.0.repeat(2));
    assert_eq!(gltf.report.count(SkipKind::Texture), 1);
    assert!(gltf.report.to_string().contains("image 0: "), "{}", gltf.report);
    // Where the other one does not exist, the texture is left out as without it.
    builder.json["textures"][0]["source"] = json!(7);
    let gltf = builder.load();
    assert!(gltf.materials[0].base_color_texture.is_none());
    assert_eq!(gltf.report.count(SkipKind::Texture), 1);
}
