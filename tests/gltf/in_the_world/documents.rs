//! JSON that strays from the schema, other versions, placeholders of buffers.

use antumbra::scene::gltf_import::{GltfError, SkipKind, load_gltf_slice};
use serde_json::{Value, json};

use crate::gltf_builder::*;

fn load_text(text: &str) -> Result<antumbra::scene::gltf_import::LoadedGltf, GltfError> {
    load_gltf_slice(text.as_bytes(), None, "test.gltf")
}

/// Every whole number of a document, written with a fraction of zero.
fn with_fractions(value: &Value) -> String {
    match value {
        Value::Number(number) if number.is_u64() => format!("{number}.0"),
        Value::Array(items) => {
            let items: Vec<String> = items.iter().map(with_fractions).collect();
            format!("[{}]", items.join(","))
        }
        Value::Object(fields) => {
            let fields: Vec<String> = fields
                .iter()
                .map(|(key, value)| format!("{key:?}:{}", with_fractions(value)))
                .collect();
            format!("{{{}}}", fields.join(","))
        }
        other => other.to_string(),
    }
}

#[test]
fn whole_numbers_may_have_a_fraction_of_zero() {
    for builder in [quad(), animated()] {
        let plain = builder.load();
        let text = with_fractions(&builder.document(None));
        assert!(text.contains("\"bufferView\":0.0"), "{text}");
        let loaded = load_gltf_slice(&glb(text.as_bytes(), &builder.binary), None, "test.glb").unwrap();
        assert_eq!(loaded.meshes[0].data, plain.meshes[0].data);
        assert_eq!(
            (loaded.nodes, loaded.skins, loaded.clips),
            (plain.nodes, plain.skins, plain.clips)
        );
        assert_eq!(loaded.report, plain.report);
    }
    // Zero may have a sign.
    for zero in ["-0.0", "-0"] {
        let builder = quad();
        let text = builder.document(None).to_string();
        let signed = text.replace("\"buffer\":0", &format!("\"buffer\":{zero}"));
        assert_ne!(signed, text);
        let loaded = load_gltf_slice(&glb(signed.as_bytes(), &builder.binary), None, "test.glb").unwrap();
        assert_eq!(loaded.meshes[0].data, builder.load().meshes[0].data);
    }
    // A fraction that is not zero is no whole number.
    let mut builder = quad();
    builder.json["accessors"][1]["count"] = json!(4.5);
    let error = builder.error();
    assert!(
        error.contains("accessors[1].count") && error.contains("4.5"),
        "{error}"
    );
}

#[test]
fn errors_of_json_name_the_element() {
    let cases: [(&str, &[&str], Value); 6] = [
        (
            "/meshes/0/primitives/0/attributes/POSITION",
            &["meshes[0].primitives[0]"],
            json!("first"),
        ),
        (
            "/nodes/2/translation",
            &["nodes[2].translation"],
            json!([1.0, 2.0]),
        ),
        (
            "/bufferViews/1/byteLength",
            &["bufferViews[1].byteLength"],
            json!(-3),
        ),
        ("/accessors/0/bufferView", &["accessors[0].bufferView"], json!({})),
        ("/skins/0/joints", &["skins[0].joints"], json!(7)),
        ("/scenes/0/nodes/1", &["scenes[0].nodes[1]"], json!(null)),
    ];
    for (pointer, parts, value) in cases {
        let mut builder = animated();
        *builder.json.pointer_mut(pointer).unwrap() = value;
        let error = builder.error();
        assert!(matches!(
            load_gltf_slice(&builder.glb(), None, "test.glb"),
            Err(GltfError::Json { .. })
        ));
        for part in parts.iter().chain(&["test.glb: JSON: "]) {
            assert!(error.contains(part), "{pointer}: {error}");
        }
    }
    // Text that breaks off is named by the element that was begun, and by its place.
    let text = serde_json::to_string(&quad().document(None)).unwrap();
    let cut = text.find("\"byteLength\":").unwrap() + "\"byteLength\":".len();
    let error = load_text(&format!("{}}}", &text[..cut])).unwrap_err().to_string();
    assert!(
        error.contains("bufferViews[0]") && error.contains("column"),
        "{error}"
    );
}

#[test]
fn other_versions_are_named() {
    for (text, version) in [
        (
            r#"{"asset": {"version": "1.0"}, "accessors": {}, "scenes": {"s": {"nodes": []}}, "scene": "s"}"#,
            "1",
        ),
        (r#"{"asset": {"version": 1.0}, "meshes": {}}"#, "1"),
        (r#"{"asset": {}, "nodes": {"n": {}}}"#, "1"),
        (r#"{"meshes": {"m": {}}}"#, "1"),
        (r#"{"asset": {"version": "3.0"}, "meshes": {}}"#, "3"),
        (r#"{"asset": {"version": "1.0"}}"#, "1"),
        (r#"{"asset": {"version": "2.9", "minVersion": "2.9"}}"#, "2.9"),
    ] {
        let error = load_text(text).unwrap_err();
        assert!(matches!(error, GltfError::Version { .. }), "{text}: {error}");
        assert!(
            error
                .to_string()
                .contains(&format!("version {version} is not supported")),
            "{error}"
        );
    }
    // Version 2 as a number is meant well.
    load_text(r#"{"asset": {"version": 2.0}}"#).unwrap();
    load_text(r#"{"asset": {"version": 2}}"#).unwrap();
    // A later minor version that 2.0 can read.
    load_text(r#"{"asset": {"version": "2.9", "minVersion": "2.0"}}"#).unwrap();
    load_text(r#"{"asset": {"version": "2.9"}}"#).unwrap();
}

#[test]
fn buffers_that_nothing_reads_may_be_missing() {
    for placeholder in [
        json!({"byteLength": 1024}),
        json!({"byteLength": 1024, "uri": "not_there.bin"}),
        json!({"byteLength": 1024, "uri": "data:application/octet-stream;base64,AAAA"}),
    ] {
        let mut builder = quad();
        let own = json!({"byteLength": builder.binary.len()});
        builder.json["buffers"] = json!([own, placeholder]);
        let gltf = builder.load();
        assert_eq!((gltf.triangle_count(), gltf.report.is_empty()), (2, true));
        // As soon as something reads it, it is an error that names it.
        builder.json["bufferViews"][1]["buffer"] = json!(1);
        let error = builder.error();
        assert!(error.contains("buffer 1: "), "{error}");
    }
}

#[test]
fn extensions_are_reported_whether_they_are_declared_or_not() {
    let mut builder = quad();
    builder.json["extensionsUsed"] = json!(["KHR_materials_sheen", "KHR_materials_ior"]);
    builder.json["nodes"][0]["extensions"] = json!({"VENDOR_physics": {}});
    builder.json["materials"] =
        json!([{"extensions": {"KHR_materials_sheen": {"sheenRoughnessFactor": 1.0}}}]);
    let report = builder.load().report;
    assert_eq!(report.count(SkipKind::Extension), 2);
    let text = report.to_string();
    assert!(
        text.contains("KHR_materials_sheen is ignored (1 element"),
        "{text}"
    );
    assert!(text.contains("VENDOR_physics is ignored"), "{text}");
    assert!(!text.contains("KHR_materials_ior"), "{text}");
}
