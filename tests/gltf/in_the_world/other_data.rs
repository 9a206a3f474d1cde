//! Compressed data that is broken, beside the same data uncompressed.

use antumbra::scene::gltf_import::SkipKind;
use serde_json::json;

use crate::gltf_builder::*;

/// The file loads like the plain one, and says in one line which element's compressed data is not used.
fn loads_uncompressed(builder: &Builder, element: &str, part: &str) {
    let gltf = builder.load();
    assert_eq!(gltf.meshes[0].data, quad().load().meshes[0].data, "{part}");
    assert_eq!(gltf.report.count(SkipKind::Extension), 1, "{}", gltf.report);
    let text = gltf.report.to_string();
    assert!(text.contains(element) && text.contains(part), "{text}");
    assert_eq!(text.matches("_compression").count(), 1, "{text}");
}

#[cfg(feature = "gltf-draco")]
#[test]
fn broken_draco_streams_leave_the_uncompressed_data() {
    let name = "KHR_draco_mesh_compression";
    for (extension, part) in [
        (
            json!({"bufferView": 0, "attributes": {"POSITION": 0}}),
            "cannot be decoded",
        ),
        (json!({}), "bufferView is not an index"),
        (json!({"bufferView": 99}), "buffer view 99 does not exist"),
    ] {
        let mut builder = quad();
        builder.json["extensionsUsed"] = json!([name]);
        builder.json["meshes"][0]["primitives"][0]["extensions"] = json!({name: extension});
        loads_uncompressed(&builder, "mesh 0 primitive 0: ", part);

        let mut required = quad();
        required.json = builder.json.clone();
        required.json["extensionsRequired"] = json!([name]);
        let error = required.error();
        assert!(
            error.contains("mesh 0 primitive 0: ") && error.contains(part),
            "{error}"
        );

        // Without data of its own an accessor would read as zeros.
        for accessor in 0..3 {
            let mut without = quad();
            without.json = builder.json.clone();
            let accessor = &mut without.json["accessors"][accessor];
            accessor.as_object_mut().unwrap().remove("bufferView");
            let error = without.error();
            assert!(
                error.contains("mesh 0 primitive 0: ") && error.contains(part),
                "{error}"
            );
        }
    }
}

#[cfg(feature = "gltf-meshopt")]
#[test]
fn broken_meshopt_bytes_leave_the_uncompressed_ones() {
    for name in ["EXT_meshopt_compression", "KHR_meshopt_compression"] {
        for (key, value, part) in [
            ("mode", json!("ATTRIBUTES"), "broken"),
            ("count", json!("many"), "count is not a whole number"),
            ("buffer", json!(1), "buffer 1: it has no URI"),
            ("buffer", json!(9), "buffer 9 does not exist"),
        ] {
            let mut builder = quad();
            builder.json["buffers"] = json!([{"byteLength": builder.binary.len()}, {"byteLength": 64}]);
            builder.json["extensionsUsed"] = json!([name]);
            let mut object = json!({
                "buffer": 0, "byteLength": 8, "count": 4, "byteStride": 12, "mode": "ATTRIBUTES",
            });
            object[key] = value;
            builder.json["bufferViews"][0]["extensions"] = json!({name: object});
            // A second mesh reads the view again.
            builder.mesh(json!({"attributes": {"POSITION": 0}, "indices": 2}));
            loads_uncompressed(&builder, "buffer view 0: ", part);

            builder.json["extensionsRequired"] = json!([name]);
            let error = builder.error();
            assert!(
                error.contains("buffer view 0: ") && error.contains(part),
                "{error}"
            );
        }
    }
}
