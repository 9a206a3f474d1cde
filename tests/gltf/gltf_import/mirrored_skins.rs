//! Skins whose joints mirror their mesh: fronts stay fronts.

use antumbra::scene::gltf_import::spawn_scene;
use antumbra::scene::{PosedMesh, SceneMesh};
use bevy_transform::prelude::GlobalTransform;
use glam::{Mat4, Vec3};
use serde_json::json;

use super::assert_near;
use crate::gltf_builder::*;

/// Poses the first mesh. Checks that its triangles face where its normals point, once the sign of its transform is taken
/// into account as for every mesh, and returns its first three corners in the world.
fn corners(builder: &Builder) -> [Vec3; 3] {
    let gltf = builder.load();
    assert!(gltf.report.is_empty(), "{}", gltf.report);
    let (mut world, mut schedule) = frame();
    let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
    schedule.run(&mut world);
    let mesh = world.entity(spawned.meshes[0]);
    let place = mesh.get::<GlobalTransform>().unwrap().affine();
    let posed = mesh.get::<PosedMesh>().unwrap();
    let world_of = |corner: u32| place.transform_point3(posed.positions[corner as usize]);
    let hand = place.matrix3.determinant().signum();
    for triangle in mesh.get::<SceneMesh>().unwrap().0.indices.as_chunks::<3>().0 {
        let [a, b, c] = triangle.map(world_of);
        let wound = (b - a).cross(c - a).normalize() * hand;
        let normal = (place.matrix3.inverse().transpose() * posed.normals[triangle[0] as usize]).normalize();
        assert!(wound.dot(normal) > 0.99, "wound {wound}, normal {normal}");
    }
    [0, 1, 2].map(world_of)
}

/// The quad on its two joints, all below a node with these keys.
fn armature(keys: serde_json::Value) -> Builder {
    let mut builder = animated();
    builder.json["nodes"][0]
        .as_object_mut()
        .unwrap()
        .remove("translation");
    let above = builder.push("nodes", keys);
    builder.json["nodes"][above]["children"] = json!([0, 1]);
    builder.json["scenes"][0]["nodes"] = json!([above, 3]);
    builder
}

#[test]
fn fronts_of_mirrored_skins_stay_fronts() {
    let [.., turned] = corners(&armature(json!({})));
    assert_near(turned, Vec3::Y);
    let mirror = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0)).to_cols_array();
    for keys in [
        json!({"scale": [-1, 1, 1]}),
        json!({"matrix": mirror}),
        json!({"scale": [-1, -1, -1]}),
    ] {
        let [_, right, _] = corners(&armature(keys.clone()));
        assert!((right.x + 1.0).abs() < 1e-5, "{keys}: {right}");
    }
    // One that is mirrored twice is not.
    let mut twice = armature(json!({"scale": [-1, 1, 1]}));
    twice.json["nodes"][1]["scale"] = json!([1, 1, -1]);
    assert_near(corners(&twice)[1], -Vec3::X);
    // A joint alone, with the mesh's node beside it.
    let mut joint = animated();
    joint.json["nodes"][1]["scale"] = json!([-1, 1, 1]);
    assert_near(corners(&joint)[1], -Vec3::X);
    // Inverse bind matrices that mirror as well cancel the mirroring.
    let back = Mat4::from_scale(Vec3::new(-1.0, 1.0, 1.0));
    let second = back * Mat4::from_translation(Vec3::new(0.0, -2.0, 0.0));
    let binds = joint.floats(&[back.to_cols_array(), second.to_cols_array()]);
    joint.json["skins"][0]["inverseBindMatrices"] = json!(binds);
    assert_near(corners(&joint)[1], Vec3::X);
}
