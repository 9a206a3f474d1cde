//! The alpha of vertex colours under materials that transmit light.

use antumbra::scene::AlphaMode;
use antumbra::scene::gltf_import::{LoadedGltf, SkipKind};
use serde_json::{Value, json};

use super::materials::{glass, texture};
use crate::gltf_builder::*;

/// Vertex alphas of the quad.
const ALPHAS: [f32; 4] = [0.0, 0.3, 0.6, 1.0];

/// The quad with coloured vertices, once for each material.
fn coloured(materials: &[Value]) -> Builder {
    let mut builder = quad();
    let colors = builder.floats(&ALPHAS.map(|alpha| [0.5, 0.5, 0.5, alpha]));
    let mut primitive = builder.json["meshes"][0]["primitives"][0].take();
    primitive["attributes"]["COLOR_0"] = json!(colors);
    let primitives = (0..materials.len()).map(|material| {
        primitive["material"] = json!(material);
        primitive.clone()
    });
    builder.json["meshes"][0]["primitives"] = primitives.collect();
    builder.json["materials"] = json!(materials);
    builder
}

/// The vertex alphas of a submesh, in the order of its vertices.
fn alphas(gltf: &LoadedGltf, submesh: usize) -> Vec<f32> {
    let data = &gltf.meshes[0].data;
    let part = data.submeshes[submesh];
    let corners = &data.indices[part.first_index as usize..][..part.index_count as usize];
    let base = *corners.iter().min().unwrap() as usize;
    data.colors[base..base + ALPHAS.len()]
        .iter()
        .map(|color| color.w)
        .collect()
}

#[test]
fn glass_keeps_the_meaning_that_its_mode_gives_to_vertex_alpha() {
    let of = |mode: &str| {
        let mut material = glass(json!({"transmissionFactor": 1.0}), json!({}));
        material["alphaMode"] = json!(mode);
        material
    };
    let mut plain = of("OPAQUE");
    plain.as_object_mut().unwrap().remove("extensions");
    let gltf = coloured(&[plain, of("OPAQUE"), of("BLEND"), of("MASK")]).load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    assert!(
        gltf.materials[1..]
            .iter()
            .all(|material| material.alpha_mode == AlphaMode::Blend)
    );
    // All primitives have the same accessors, and only those whose alpha stays the file's share vertices.
    assert_eq!(gltf.meshes[0].data.positions.len(), 3 * ALPHAS.len());
    assert_eq!(alphas(&gltf, 0), ALPHAS);
    assert_eq!(alphas(&gltf, 1), [1.0; 4]);
    assert_eq!(alphas(&gltf, 2), ALPHAS);
    assert_eq!(alphas(&gltf, 3), [0.0, 0.0, 1.0, 1.0]);
}

#[test]
fn a_masks_texture_decides_alone_and_the_rest_is_reported() {
    let mut material = glass(json!({"transmissionFactor": 1.0}), json!({}));
    material["alphaMode"] = json!("MASK");
    let mut builder = coloured(&[material]);
    let image = texture(&mut builder, 1, &[[255; 4]]);
    let coordinates = builder.floats(&[[0.5, 0.5]; 4]);
    builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = json!({"index": image});
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let gltf = builder.load();
    assert_eq!(alphas(&gltf, 0), [1.0; 4]);
    assert_eq!(gltf.report.count(SkipKind::VertexData), 3, "{}", gltf.report);
}
