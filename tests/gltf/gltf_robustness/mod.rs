//! Bad glTF files are errors that name the element, or are loaded with a report; none panics, hangs or takes
//! all memory.

mod accessors;
mod animation;
mod files;
mod incomplete;
mod meshes;
mod mutations;
mod nodes;

use crate::gltf_builder::*;
use antumbra::scene::gltf_import::{LoadedGltf, load_gltf_slice, spawn_scene};
use antumbra::scene::{PosedMesh, SceneMesh, apply_animation};

#[track_caller]
fn assert_names(message: &str, parts: &[&str]) {
    for part in parts.iter().chain(&["test.gl"]) {
        assert!(message.contains(part), "{message:?} does not name {part:?}");
    }
}

#[test]
#[should_panic(expected = "does not name")]
fn assert_names_fails_without_the_element() {
    assert_names("test.glb: accessor 1: broken", &["accessor 2"]);
}

fn slice_error(bytes: &[u8]) -> String {
    load_gltf_slice(bytes, None, "test.glb").unwrap_err().to_string()
}

/// The error of a good file after an edit of its JSON.
fn error_after(edit: impl FnOnce(&mut Builder)) -> String {
    let mut builder = animated();
    builder.load();
    edit(&mut builder);
    builder.error()
}

/// Loads, poses at a few times, and checks that nothing that is drawn holds a number that is not finite.
fn exercise(gltf: &LoadedGltf) {
    for scene in 0..gltf.scenes.len().min(2) {
        let (mut world, mut schedule) = frame();
        let Ok(spawned) = spawn_scene(&mut world, gltf, Some(scene)) else {
            continue;
        };
        schedule.run(&mut world);
        for clip in gltf.clips.iter().take(2) {
            apply_animation(&mut world, &spawned, clip, clip.duration() * 0.4);
            schedule.run(&mut world);
        }
        for &entity in &spawned.meshes {
            let data = &world.get::<SceneMesh>(entity).unwrap().0;
            assert!(
                data.positions
                    .iter()
                    .chain(&data.normals)
                    .all(|vertex| vertex.is_finite())
            );
            assert!(
                data.indices
                    .iter()
                    .all(|&index| (index as usize) < data.positions.len())
            );
            assert_eq!(data.normals.len(), data.positions.len());
            if let Some(posed) = world.get::<PosedMesh>(entity) {
                assert!(
                    posed
                        .positions
                        .iter()
                        .chain(&posed.normals)
                        .all(|vertex| vertex.is_finite())
                );
                assert_eq!(posed.positions.len(), data.positions.len());
            }
        }
    }
}
