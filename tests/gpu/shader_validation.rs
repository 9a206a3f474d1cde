//! Every shader composes, is valid WGSL of WebGPU's baseline, is listed, and has the entry points that Rust names.
//! Without a GPU.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use antumbra::insides::{COMMON, PASSES};
use wgpu::naga;
use wgpu::naga::valid::{Capabilities, ValidationFlags, Validator};

use crate::harness::shaders;

/// Checks a composed module with nothing beyond the baseline.
fn validate(module: &naga::Module) -> Result<(), String> {
    Validator::new(ValidationFlags::all(), Capabilities::empty())
        .validate(module)
        .map(|_| ())
        .map_err(|error| format!("{:?}", error.into_inner()))
}

fn compose(path: &str, source: &str) -> Result<naga::Module, String> {
    shaders().compose(path, source).map_err(|error| error.to_string())
}

#[test]
fn every_pass_composes_and_validates() {
    for &(path, source) in PASSES.iter() {
        let module = compose(path, source).unwrap_or_else(|error| panic!("{error}"));
        assert!(!module.entry_points.is_empty(), "{path} has no entry points");
        validate(&module).unwrap_or_else(|error| panic!("{path}: {error}"));
    }
}

#[test]
fn validation_finds_bad_shaders() {
    let unknown = compose(
        "bad.wgsl",
        "#import antumbra::view::no_such\nfn f() { no_such(); }",
    );
    assert!(unknown.is_err(), "an unknown import is found");
    let error = compose("bad.wgsl", "fn f() -> f32 { return 1u; }").and_then(|module| validate(&module));
    assert!(error.is_err(), "a wrong type is found");
    // Valid WGSL, but of a feature that not every device has.
    let error = compose(
        "bad.wgsl",
        "@fragment fn f(@builtin(primitive_index) i: u32) -> @location(0) vec4f { return vec4f(f32(i)); }",
    )
    .and_then(|module| validate(&module));
    assert!(error.is_err(), "an optional feature is found");
    // The composer names the file.
    let Err(error) = compose("folder/bad.wgsl", "fn f() { let x = ; }") else {
        panic!("a syntax error is found");
    };
    assert!(error.contains("folder/bad.wgsl"), "{error}");
}

#[test]
fn common_files_have_no_entry_points() {
    for &(path, source) in COMMON.iter() {
        for stage in ["@vertex", "@fragment", "@compute"] {
            assert!(!source.contains(stage), "{path} has {stage}");
        }
        assert!(
            source.contains("#define_import_path"),
            "{path} cannot be imported"
        );
    }
}

#[test]
fn every_file_is_listed_once_and_every_listed_file_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders");
    let there: BTreeSet<String> = files_below(&root, "wgsl")
        .into_iter()
        .map(|path| {
            let path = path.strip_prefix(&root).expect("below shaders");
            path.to_string_lossy().replace('\\', "/")
        })
        // They call Bevy's shaders and are composed by Bevy: `tests/bevy/shading.rs` draws with them.
        .filter(|path| !path.starts_with("bevy/"))
        .collect();
    let listed: Vec<String> = COMMON
        .iter()
        .chain(PASSES.iter())
        .map(|(path, _)| (*path).to_owned())
        .collect();
    let set: BTreeSet<String> = listed.iter().cloned().collect();
    assert_eq!(set.len(), listed.len(), "a file is listed twice");
    assert_eq!(there, set);
    for (path, source) in COMMON.iter().chain(PASSES.iter()) {
        let now = std::fs::read_to_string(root.join(path)).expect("a listed file is there");
        assert_eq!(now, *source, "{path} is not what was compiled in");
    }
}

/// Entry points in `Stage::new(file, "…")`, and the shader files that a Rust source names.
fn named_by(source: &str) -> (Vec<String>, Vec<String>) {
    let is_file = |text: &&str| text.ends_with(".wgsl") && !text.contains(char::is_whitespace);
    let quoted = |text| str::split(text, '"').skip(1).step_by(2).collect::<Vec<_>>();
    let stage = "Stage::new(";
    let entries = source
        .match_indices(stage)
        .filter_map(|(at, _)| source[at + stage.len()..].split(')').next())
        .flat_map(quoted)
        .filter(|text| !is_file(text))
        .map(str::to_owned)
        .collect();
    let files = source.split('"').filter(is_file).map(str::to_owned).collect();
    (entries, files)
}

fn entry_points(path: &str) -> Option<Vec<String>> {
    let (_, source) = PASSES.iter().find(|(name, _)| *name == path)?;
    let module = compose(path, source).ok()?;
    Some(module.entry_points.into_iter().map(|entry| entry.name).collect())
}

#[test]
fn rust_names_entry_points_that_exist_and_none_is_unused() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut named = 0;
    let mut sources = String::new();
    for path in files_below(&root, "rs") {
        let source = std::fs::read_to_string(&path).expect("a readable source");
        let (entries, mut files) = named_by(&source);
        if path.ends_with("render/shaders.rs") || path.starts_with(root.join("bevy_adapter")) {
            continue; // the list itself, and what Bevy composes
        }
        for file in &files {
            let is_imported = COMMON.iter().any(|(path, _)| path == file);
            assert!(
                is_imported || entry_points(file).is_some(),
                "{}: names {file}",
                path.display()
            );
        }
        if files.is_empty() {
            files = PASSES.iter().map(|(file, _)| (*file).to_owned()).collect();
        }
        for entry in entries {
            named += 1;
            let found = files
                .iter()
                .any(|file| entry_points(file).is_some_and(|all| all.contains(&entry)));
            assert!(
                found,
                "{}: entry point {entry} is in none of {files:?}",
                path.display()
            );
        }
        sources.push_str(&source);
    }
    assert!(
        named >= 6,
        "only {named} entry points are named: the reader is broken"
    );
    for &(path, _) in PASSES.iter() {
        for entry in entry_points(path).unwrap_or_default() {
            assert!(
                sources.contains(&format!("\"{entry}\"")),
                "{path}: nobody uses {entry}"
            );
        }
    }
}

#[test]
fn the_reader_of_names_finds_them() {
    let source = r#"x = shaders.module(d, "passes/a.wgsl")?; y(Stage::new("passes/a.wgsl", "vertex"), Stage::new(FILE, entry)) // `b.wgsl`"#;
    assert_eq!(
        named_by(source),
        (vec!["vertex".to_owned()], vec!["passes/a.wgsl".to_owned(); 2])
    );
    assert_eq!(entry_points("passes/none.wgsl"), None);
    assert_eq!(
        entry_points("passes/tonemap.wgsl"),
        Some(vec!["fragment".to_owned()])
    );
}

fn files_below(folder: &Path, extension: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let entries =
            std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for entry in entries {
            let path = entry.expect("a folder entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|known| known == extension) {
                found.push(path);
            }
        }
    }
    assert!(!found.is_empty(), "no {extension} files in {}", folder.display());
    found.sort();
    found
}
