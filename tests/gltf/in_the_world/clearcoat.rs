//! `KHR_materials_clearcoat`: what is read, and what is left out of it.

use antumbra::scene::Material;
use antumbra::scene::gltf_import::{Element, Report, SUPPORTED_EXTENSIONS, SkipKind};
use serde_json::{Value, json};

use super::materials::texture;
use crate::gltf_builder::*;

/// The material of a quad with this extension, and what was left out.
fn material(extension: Value) -> (Material, Report) {
    let mut builder = quad();
    for texel in [[10, 0, 0, 255], [0, 20, 0, 255]] {
        texture(&mut builder, 1, &[texel]);
    }
    builder.json["extensionsUsed"] = json!(["KHR_materials_clearcoat"]);
    builder.json["materials"] = json!([{"extensions": {"KHR_materials_clearcoat": extension}}]);
    let gltf = builder.load();
    ((*gltf.materials[0]).clone(), gltf.report)
}

#[test]
fn a_coat_has_its_numbers_and_textures() {
    assert!(SUPPORTED_EXTENSIONS.contains(&"KHR_materials_clearcoat"));
    let turned = json!({"KHR_texture_transform": {"offset": [0.5, 0.25], "texCoord": 0}});
    let (coated, report) = material(json!({
        "clearcoatFactor": 0.75, "clearcoatRoughnessFactor": 0.25,
        "clearcoatTexture": {"index": 0, "texCoord": 1},
        "clearcoatRoughnessTexture": {"index": 1, "texCoord": 1, "extensions": turned},
    }));
    assert!(report.is_empty(), "{report}");
    assert_eq!((coated.clearcoat, coated.clearcoat_roughness), (0.75, 0.25));
    let share = coated.clearcoat_texture.expect("its texture");
    assert_eq!((share.texture.rgba8[0], share.uv_set), (10, 1));
    let roughness = coated.clearcoat_roughness_texture.expect("its other texture");
    assert_eq!((roughness.texture.rgba8[1], roughness.uv_set), (20, 0));
    assert_eq!(roughness.uv_transform.translation.to_array(), [0.5, 0.25]);
    // An extension without a factor is no coat, and loads no textures.
    for extension in [json!({}), json!({"clearcoatTexture": {"index": 0}})] {
        let (bare, report) = material(extension);
        assert!(report.is_empty(), "{report}");
        assert_eq!(
            bare,
            Material {
                name: bare.name.clone(),
                ..Material::default()
            }
        );
    }
}

#[test]
fn what_a_coat_loses_is_reported() {
    let (coated, report) = material(json!({
        "clearcoatFactor": 2.5, "clearcoatRoughnessFactor": -1,
        "clearcoatNormalTexture": {"index": 0},
    }));
    assert_eq!((coated.clearcoat, coated.clearcoat_roughness), (1.0, 0.0));
    assert!(
        report
            .skips
            .iter()
            .all(|skip| skip.element == Element::Material(0))
    );
    assert_eq!(report.count(SkipKind::MaterialValue), 2, "{report}");
    assert_eq!(report.count(SkipKind::Texture), 1, "{report}");
    let text = report.to_string();
    assert!(text.contains("clearcoat factor 2.5 becomes 1"), "{text}");
    assert!(text.contains("clearcoatNormalTexture is not read"), "{text}");
}

#[test]
fn a_broken_coat_is_ignored_part_by_part() {
    for broken in [json!(null), json!(3), json!("thick"), json!([1])] {
        let (bare, report) = material(broken);
        assert_eq!(bare.clearcoat, 0.0);
        assert_eq!(report.count(SkipKind::MaterialValue), 1, "{report}");
    }
    let (coated, report) = material(json!({
        "clearcoatFactor": 1e300, "clearcoatRoughnessFactor": "smooth",
        "clearcoatTexture": {"index": "first"}, "clearcoatRoughnessTexture": 1,
    }));
    assert_eq!((coated.clearcoat, coated.clearcoat_roughness), (1.0, 0.0));
    assert_eq!(
        (coated.clearcoat_texture, coated.clearcoat_roughness_texture),
        (None, None)
    );
    assert_eq!(report.count(SkipKind::MaterialValue), 2, "{report}");
    assert_eq!(report.count(SkipKind::Texture), 2, "{report}");
    // An index out of range is an error that names the material, as everywhere.
    let mut builder = quad();
    let coat = json!({"clearcoatFactor": 1.0, "clearcoatTexture": {"index": 7}});
    builder.json["materials"] = json!([{"extensions": {"KHR_materials_clearcoat": coat}}]);
    let error = builder.error();
    assert!(
        error.contains("material 0") && error.contains("texture 7"),
        "{error}"
    );
}
