//! Files that are no glTF, or need what there is not.

use std::path::Path;

use antumbra::scene::gltf_import::{GltfError, SkipKind, load_gltf, load_gltf_slice};
use serde_json::json;

use super::{assert_names, error_after, slice_error};
use crate::gltf_builder::*;

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
    let message = error_after(|b| b.json["extensionsRequired"] = json!(["KHR_materials_iridescence"]));
    assert_names(&message, &["KHR_materials_iridescence"]);
    let mut builder = quad();
    builder.json["extensionsUsed"] = json!(["KHR_materials_sheen"]);
    assert_eq!(builder.load().report.count(SkipKind::Extension), 1);
}
