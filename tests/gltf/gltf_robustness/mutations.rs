//! Good files with bytes changed at random.

use std::path::Path;

use antumbra::scene::gltf_import::load_gltf_slice;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::exercise;
use crate::gltf_builder::*;

/// Files to break: small ones of our own, and a skinned model.
fn small() -> Vec<Vec<u8>> {
    let hand = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/models/generic_hand_left.glb");
    vec![
        triangle().glb(),
        quad().glb(),
        animated().glb(),
        std::fs::read(hand).unwrap(),
    ]
}

/// Two animated models, one of them with morph targets.
fn animals() -> Vec<Vec<u8>> {
    let folder = std::env::var("ANTUMBRA_MODELS").expect("ANTUMBRA_MODELS names the folder of all models");
    let folder = Path::new(&folder).join("look/c-animated");
    let names = ["fox.glb", "morph_stress_test.glb"];
    names.map(|name| std::fs::read(folder.join(name)).unwrap()).into()
}

fn json_range(glb: &[u8]) -> std::ops::Range<usize> {
    20..20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize
}

#[test]
fn mutated_files_never_panic() {
    never_panic(&small(), 150);
}

#[test]
#[ignore = "needs all models: ANTUMBRA_MODELS"]
fn mutated_models_never_panic() {
    never_panic(&animals(), 106);
}

fn never_panic(seeds: &[Vec<u8>], cases: u32) {
    let edits = prop::collection::vec((any::<prop::sample::Index>(), 0u8..4, any::<u8>()), 1..12);
    let config = ProptestConfig {
        failure_persistence: None,
        cases,
        ..ProptestConfig::default()
    };
    let loaded_count = std::cell::Cell::new(0);
    let mut runner = TestRunner::new(config);
    let outcome = runner.run(&(0..seeds.len(), edits), |(seed, edits)| {
        let mut bytes = seeds[seed].clone();
        let json = json_range(&bytes);
        let digits: Vec<usize> = json.clone().filter(|&i| bytes[i].is_ascii_digit()).collect();
        for (place, kind, value) in edits {
            let binary = json.end..bytes.len();
            match kind {
                // digits keep the JSON whole, so that numbers change
                0 | 1 => bytes[digits[place.index(digits.len())]] = b'0' + value % 10,
                2 => bytes[binary.start + place.index(binary.len())] = value,
                // one in sixteen: most of these only break the JSON
                _ if value < 16 => bytes[place.index(json.end)] = value.wrapping_mul(17),
                _ => {}
            }
        }
        if let Ok(gltf) = load_gltf_slice(&bytes, None, "mutated.glb") {
            exercise(&gltf);
            loaded_count.set(loaded_count.get() + 1);
        }
        Ok(())
    });
    outcome.unwrap();
    let loaded_count: u32 = loaded_count.get();
    eprintln!("{loaded_count} of {cases} mutated files load");
    assert!(
        loaded_count * 20 > cases,
        "{loaded_count} of {cases} load: nothing is tested"
    );
}

#[test]
fn seeds_themselves_load() {
    for seed in small() {
        exercise(&load_gltf_slice(&seed, None, "seed.glb").unwrap());
    }
}
