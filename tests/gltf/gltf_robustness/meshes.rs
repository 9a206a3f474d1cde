//! Triangles and textures that cannot be drawn.

use std::path::Path;

use antumbra::scene::WorldBounds;
use antumbra::scene::gltf_import::{SkipKind, load_gltf_slice, spawn_scene};
use serde_json::json;

use super::exercise;
use crate::gltf_builder::*;

#[test]
fn non_finite_positions_skip_their_triangles() {
    for bad in [f32::NAN, f32::INFINITY] {
        let mut builder = quad();
        builder.binary[3 * 12..3 * 12 + 4].copy_from_slice(&bad.to_le_bytes());
        let gltf = builder.load();
        assert_eq!(gltf.report.count(SkipKind::NonFiniteTriangle), 1);
        assert_eq!(gltf.meshes[0].data.indices, [0, 1, 2]);
        exercise(&gltf);
    }
    let mut builder = triangle();
    builder.binary[..4].copy_from_slice(&f32::NAN.to_le_bytes());
    let gltf = builder.load();
    assert_eq!(
        (gltf.triangle_count(), gltf.report.count(SkipKind::EmptyPrimitive)),
        (0, 1)
    );
    assert!(gltf.report.to_string().contains("mesh 0 primitive 0"));
    exercise(&gltf);
}

#[test]
fn zero_and_degenerate_triangles() {
    let mut builder = quad();
    let empty = builder.indices_u16(&[]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(empty);
    let gltf = builder.load();
    assert_eq!(gltf.report.count(SkipKind::EmptyPrimitive), 1);
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    schedule.run(&mut world);
    assert!(world.get::<WorldBounds>(spawned.meshes[0]).unwrap().0.is_empty());

    let mut builder = quad();
    let degenerate = builder.indices_u16(&[0, 0, 1, 1, 1, 1, 0, 1]);
    builder.json["meshes"][0]["primitives"][0]["indices"] = json!(degenerate);
    let gltf = builder.load();
    assert_eq!(
        (
            gltf.triangle_count(),
            gltf.report.count(SkipKind::IncompleteTriangle)
        ),
        (2, 2)
    );
    assert!(gltf.report.to_string().contains("no area"), "{}", gltf.report);
    exercise(&gltf);
}

#[test]
fn textures_that_cannot_be_had_are_reported() {
    let image = |image: serde_json::Value| {
        let mut builder = quad();
        builder.push("images", json!({"uri": "data:image/png;base64,"}));
        builder.push("images", image);
        builder.push("textures", json!({"source": 1}));
        builder.json["materials"] = json!([{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]);
        let gltf = load_gltf_slice(&builder.glb(), Some(Path::new("no/folder")), "test.glb").unwrap();
        assert!(gltf.materials[0].base_color_texture.is_none());
        assert_eq!(gltf.report.count(SkipKind::Texture), 1);
        gltf.report.to_string()
    };
    let missing = image(json!({"uri": "gone.png"}));
    assert!(
        missing.contains("image 1") && missing.contains("no/folder/gone.png"),
        "{missing}"
    );
    let undecodable = image(json!({"uri": "data:image/png;base64,AAAA"}));
    assert!(undecodable.contains("image 1"), "{undecodable}");
    assert!(image(json!({})).contains("image 1"));
}

#[test]
fn points_and_lines_are_left_out_and_named() {
    for (mode, name) in [(0, "Points"), (1, "Lines"), (2, "Line loops"), (3, "Line strips")] {
        let mut builder = quad();
        builder.json["meshes"][0]["primitives"][0]["mode"] = json!(mode);
        let report = builder.load().report;
        assert_eq!(report.count(SkipKind::DrawMode), 1);
        let text = format!("{name} have no surface");
        assert!(report.to_string().contains(&text), "{report}");
    }
}
