//! All models that there are: they hold what their manifest says, and pose.

use antumbra::scene::gltf_import::{SkipKind, load_gltf, spawn_scene};
use antumbra::scene::{PosedMesh, SceneMaterials, SceneMesh, WorldBounds, apply_animation};
use bevy_ecs::prelude::*;
use serde_json::Value;

use crate::gltf_builder::*;

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn every_model_loads_spawns_and_poses() {
    let folder = std::env::var("ANTUMBRA_MODELS").expect("ANTUMBRA_MODELS names the folder of all models");
    let folder = std::path::Path::new(&folder);
    let manifest = std::fs::read_to_string(folder.join("MANIFEST.json")).unwrap();
    let manifest: Vec<Value> = serde_json::from_str(&manifest).unwrap();
    let mut model_count = 0;
    for entry in &manifest {
        let name = entry["file"].as_str().unwrap();
        if !name.ends_with(".glb") && !name.ends_with(".gltf") {
            continue;
        }
        let says = |key: &str| entry[key].as_u64().map(|count| count as usize);
        let gltf = load_gltf(folder.join(name)).unwrap_or_else(|error| panic!("{error}"));
        let skips: Vec<_> = gltf
            .report
            .skips
            .iter()
            .filter(|skip| skip.kind != SkipKind::Extension)
            .collect();
        if !skips.is_empty() {
            eprintln!("{name}\n{}", gltf.report);
        }
        let morph_targets: usize = gltf.meshes.iter().map(|mesh| mesh.data.morph_targets.len()).sum();
        for (key, count) in [
            ("triangles", gltf.triangle_count()),
            ("meshes", gltf.meshes.len()),
            ("nodes", gltf.nodes.len()),
            ("materials", gltf.materials.len()),
            ("skins", gltf.skins.len()),
            ("joints", gltf.skins.iter().map(|skin| skin.joints.len()).sum()),
            ("animations", gltf.clips.len()),
            ("morph_targets", morph_targets),
        ] {
            if let Some(expected) = says(key) {
                assert_eq!(count, expected, "{name}: {key}");
            }
        }
        let (mut world, mut schedule) = frame();
        let spawned = spawn_scene(&mut world, &gltf, None).unwrap();
        let times = [0.0, 0.3]
            .into_iter()
            .chain(gltf.clips.iter().map(|clip| clip.duration()));
        let clips = gltf.clips.iter().cycle();
        for (clip, seconds) in clips.zip(times) {
            apply_animation(&mut world, &spawned, clip, seconds);
            schedule.run(&mut world);
        }
        schedule.run(&mut world);
        if let Some(expected) = says("instances") {
            assert_eq!(spawned.meshes.len(), expected, "{name}: instances");
        }
        for &mesh in &spawned.meshes {
            let data = &world.get::<SceneMesh>(mesh).unwrap().0;
            assert_eq!(
                world.get::<SceneMaterials>(mesh).unwrap().0.len(),
                data.submeshes.len()
            );
            assert_eq!(
                world.get::<WorldBounds>(mesh).unwrap().0.is_empty(),
                data.indices.is_empty(),
                "{name}: {}",
                data.name
            );
            if let Some(posed) = world.get::<PosedMesh>(mesh) {
                assert_eq!(posed.positions.len(), data.positions.len());
                let finite = posed
                    .positions
                    .iter()
                    .chain(&posed.normals)
                    .all(|vertex| vertex.is_finite());
                assert!(finite, "{name}: {}", data.name);
            }
        }
        if let Some(expected) = says("lights") {
            assert_eq!(
                gltf.lights.len().max(spawned.lights.len()),
                expected,
                "{name}: lights"
            );
        }
        // 0 where the tool that counted draws nothing of a mesh without indices
        if let Some(expected) = says("scene_triangles").filter(|&count| count > 0) {
            let spawned_triangles = |&mesh: &Entity| world.get::<SceneMesh>(mesh).unwrap().0.triangle_count();
            assert_eq!(
                spawned.meshes.iter().map(spawned_triangles).sum::<usize>(),
                expected,
                "{name}"
            );
        }
        model_count += 1;
    }
    assert!(model_count > 0, "no model in {}", folder.display());
}
