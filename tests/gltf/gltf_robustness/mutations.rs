//! Good files with bytes changed at random.

use std::path::Path;
use std::sync::OnceLock;

use antumbra::scene::gltf_import::load_gltf_slice;
use proptest::prelude::*;
use proptest::test_runner::TestRunner;

use super::exercise;
use crate::gltf_builder::*;

/// Files to break: small ones of our own, and two models where there are some.
fn seeds() -> &'static [Vec<u8>] {
    static SEEDS: OnceLock<Vec<Vec<u8>>> = OnceLock::new();
    SEEDS.get_or_init(|| {
        let mut seeds = vec![triangle().glb(), quad().glb(), animated().glb()];
        if let Ok(folder) = std::env::var("ANTUMBRA_MODELS") {
            for name in ["fox.glb", "morph_stress_test.glb"] {
                seeds.push(std::fs::read(Path::new(&folder).join("look/c-animated").join(name)).unwrap());
            }
        } else {
            eprintln!("ANTUMBRA_MODELS names no folder of models: small files only");
        }
        seeds
    })
}

fn json_range(glb: &[u8]) -> std::ops::Range<usize> {
    20..20 + u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize
}

#[test]
fn mutated_files_never_panic() {
    let edits = prop::collection::vec((any::<prop::sample::Index>(), 0u8..4, any::<u8>()), 1..12);
    let config = ProptestConfig {
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let loaded_count = std::cell::Cell::new(0);
    let case_count = config.cases;
    let mut runner = TestRunner::new(config);
    let outcome = runner.run(&(0usize..5, edits), |(seed, edits)| {
        let seeds = seeds();
        let mut bytes = seeds[seed % seeds.len()].clone();
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
    eprintln!("{loaded_count} of {case_count} mutated files load");
    assert!(
        loaded_count * 20 > case_count,
        "{loaded_count} of {case_count} load: nothing is tested"
    );
}

#[test]
fn seeds_themselves_load() {
    for seed in seeds() {
        exercise(&load_gltf_slice(seed, None, "seed.glb").unwrap());
    }
}
