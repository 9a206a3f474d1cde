//! Finds the built program of an example: `cargo test` builds it; with `--test NAME` alone, build it before with
//! `cargo build --example NAME` and the same features.

use std::path::{Path, PathBuf};

/// The built example, not older than what it was built from.
pub fn example(name: &str) -> PathBuf {
    let test = std::env::current_exe().expect("a test knows where it is");
    let profile = test.ancestors().nth(2).expect("target/<profile>/deps/<test>");
    let path = profile
        .join("examples")
        .join(format!("{name}{}", std::env::consts::EXE_SUFFIX));
    let built = modified(&path).unwrap_or_else(|| {
        panic!(
            "{} is missing: cargo build --example {name}, with the features of the tests",
            path.display()
        )
    });
    // Cargo lists beside it what it was built from, with spaces escaped.
    let list = std::fs::read_to_string(path.with_extension("d")).expect("cargo writes a list of inputs");
    let inputs = list
        .split_once(": ")
        .map_or("", |(_, inputs)| inputs)
        .replace("\\ ", "\u{0}");
    for input in inputs.split_whitespace().map(|input| input.replace('\u{0}', " ")) {
        let stale = modified(Path::new(&input)).is_none_or(|time| time > built);
        assert!(
            !stale,
            "{} is older than {input}: cargo build --example {name}",
            path.display()
        );
    }
    path
}

fn modified(path: &Path) -> Option<std::time::SystemTime> {
    path.metadata().and_then(|metadata| metadata.modified()).ok()
}
