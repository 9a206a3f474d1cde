//! Loads mutants of GLB files, spawns every scene, and runs two frames of the CPU schedule. No mutant may panic, hang,
//! take all memory, or bring a number that is not finite into the world.
//!
//! ```sh
//! cargo install cargo-fuzz && make fuzz RUNS=1000000
//! ```

#![no_main]

mod mutate;

use antumbra::scene::SceneMesh;
use antumbra::scene::gltf_import::{load_gltf_slice, spawn_scene};
use antumbra::schedule::{init_resources, standalone_schedule};
use bevy_ecs::world::World;
use libfuzzer_sys::{fuzz_mutator, fuzz_target};

fuzz_target!(|bytes: &[u8]| {
    let Ok(loaded) = load_gltf_slice(bytes, None, "mutant.glb") else {
        return; // an error is an answer
    };
    for scene in 0..loaded.scenes.len().min(2) {
        let mut world = World::new();
        init_resources(&mut world);
        let mut schedule = standalone_schedule();
        let Ok(spawned) = spawn_scene(&mut world, &loaded, Some(scene)) else {
            continue;
        };
        for _ in 0..2 {
            schedule.run(&mut world);
        }
        for entity in spawned.meshes {
            let mesh = &world.get::<SceneMesh>(entity).expect("it was spawned with a mesh").0;
            assert!(mesh.positions.iter().chain(&mesh.normals).all(|vertex| vertex.is_finite()));
            assert!(mesh.indices.iter().all(|index| (*index as usize) < mesh.positions.len()));
        }
    }
});

fuzz_mutator!(|data: &mut [u8], size: usize, max_size: usize, seed: u32| {
    mutate::mutate(data, size, max_size, seed)
});
