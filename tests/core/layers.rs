//! The folders of `src/` use each other in one direction only, and bevy_ecs and wgpu stay where they belong.
//!
//! Reads the sources as text: comments and string literals are blanked, then every path from the crate's root
//! (`crate::…`, or `super::…` as often as it takes to get there) must lead to an earlier layer.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Layers in order. A file may use its own layer and earlier ones.
const LAYERS: [&str; 14] = [
    "conventions",
    "geometry",
    "reports",
    "scene",
    "sets",
    "silhouettes",
    "debug_lines",
    "render",
    "techniques",
    "baking",
    "schedule",
    "bevy_adapter",
    "plugin",
    "guide",
];

/// What the judge may use: not what it judges.
const REFERENCE_MAY_USE: [&str; 4] = ["conventions", "geometry", "scene", "sets"];

#[test]
fn no_layer_uses_a_later_one() {
    let files = sources();
    let mut used = 0;
    let mut wrong = String::new();
    for (file, text) in &files {
        let paths = crate_paths(file, text);
        used += paths.len();
        for path in paths.iter().filter(|path| !may_use(file, path)) {
            let _ = writeln!(wrong, "src/{}: uses crate::{path}", file.display());
        }
    }
    assert!(used > 100, "only {used} paths found: the reader is broken");
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn geometry_imports_no_ecs() {
    for (file, text) in sources() {
        if file.starts_with("geometry") || file.starts_with("conventions.rs") {
            for word in ["bevy_ecs", "bevy_app", "bevy_transform"] {
                assert!(!has_word(&text, word), "src/{}: names {word}", file.display());
            }
        }
    }
}

#[test]
fn wgpu_stays_in_render_and_recorders() {
    let mut seen = 0;
    for (file, text) in sources() {
        if has_word(&text, "wgpu") {
            seen += 1;
            assert!(may_name_wgpu(&file), "src/{}: names wgpu", file.display());
        }
    }
    assert!(seen > 10, "only {seen} files name wgpu: the reader is broken");
}

#[test]
fn bevy_stays_in_the_adapter() {
    let mut seen = 0;
    for (file, text) in sources() {
        if text.contains("bevy::") && has_word(&text, "bevy") {
            seen += 1;
            assert!(
                file.starts_with("bevy_adapter"),
                "src/{}: names bevy",
                file.display()
            );
        }
    }
    assert!(seen > 10, "only {seen} files name bevy: the reader is broken");
}

#[test]
fn the_checker_finds_what_it_must() {
    let layer = |file: &str, text: &str| {
        let file = Path::new(file);
        let text = blank_comments_and_strings(text);
        crate_paths(file, &text)
            .into_iter()
            .filter(|path| !may_use(file, path))
            .collect::<Vec<_>>()
    };
    assert_eq!(layer("sets/a.rs", "use crate::render::Renderer;"), ["render"]);
    assert_eq!(
        layer("sets/a.rs", "use crate::{scene::Light, plugin};"),
        ["plugin"]
    );
    assert_eq!(
        layer(
            "sets/a.rs",
            "use crate::{scene::{Light, silhouettes}, techniques::{a, b}};"
        ),
        ["techniques"]
    );
    assert_eq!(
        layer("geometry/mesh/a.rs", "fn f() { super::super::super::sets::g() }"),
        ["sets"]
    );
    assert_eq!(
        layer("render/mod.rs", "use super::techniques::X;"),
        ["techniques"]
    );
    assert_eq!(
        layer("reference/a.rs", "use crate::silhouettes::X;"),
        ["silhouettes"]
    );
    assert_eq!(
        layer("scene/a.rs", "let x = \"\\\"\"; use crate::sets::X;"),
        ["sets"]
    );

    let none: [&str; 0] = [];
    assert_eq!(
        layer("sets/a.rs", "/// See [`x`](crate::render).\n/* crate::plugin */"),
        none
    );
    assert_eq!(
        layer("sets/a.rs", "let x = \"crate::render\"; use crate::scene::A;"),
        none
    );
    assert_eq!(layer("sets/a/b.rs", "use super::super::view::A;"), none);
    assert_eq!(layer("lib.rs", "pub use crate::plugin::A;"), none);

    assert!(has_word("use wgpu::Device;", "wgpu"));
    assert!(!has_word("let my_wgpu_like = 1;", "wgpu"));
    assert!(!may_name_wgpu(Path::new("techniques/stencil_volume/extrude.rs")));
    assert!(!may_name_wgpu(Path::new("techniques/stencil_volume/gpu.rs")));
    assert!(!may_name_wgpu(Path::new("sets/gpu/recorder.rs")));
    assert!(may_name_wgpu(Path::new(
        "techniques/stencil_volume/gpu/recorder.rs"
    )));
}

/// Above all layers beside `lib.rs`: what a game names, from wherever it is. Holds nothing but re-exports.
pub(super) const PRELUDE: &str = "bevy_adapter/prelude.rs";

#[test]
fn the_prelude_holds_re_exports_only() {
    let only_exports = |text: &str| {
        // An export may depend on a feature.
        let lines = text.lines().filter(|line| !line.starts_with("#[cfg(feature"));
        let text: String = lines.flat_map(|line| [line, "\n"]).collect();
        let mut statements = text.split(';').map(str::trim).filter(|text| !text.is_empty());
        statements.all(|statement| statement.starts_with("pub use "))
    };
    let text = sources().into_iter().find(|(file, _)| file == Path::new(PRELUDE));
    assert!(only_exports(&text.expect("the prelude is there").1));
    assert!(!only_exports("pub use crate::a::B;\nfn f() {}"));
}

/// The layer of a file: the first part of its path. `None` for `lib.rs` and [`PRELUDE`], which name all.
fn layer_of(file: &Path) -> Option<String> {
    if file == Path::new(PRELUDE) {
        return None;
    }
    let first = file.components().next()?.as_os_str().to_string_lossy();
    let first = first.strip_suffix(".rs").unwrap_or(&first);
    (first != "lib").then(|| first.to_owned())
}

fn may_use(file: &Path, used: &str) -> bool {
    let Some(own) = layer_of(file) else {
        return true;
    };
    if own == used {
        return true;
    }
    if (own.as_str(), used) == ("baking", "reference") {
        return true; // maps are made by the judge's rays
    }
    if own == "reference" {
        return REFERENCE_MAY_USE.contains(&used);
    }
    let rank = |layer: &str| LAYERS.iter().position(|known| *known == layer);
    match (rank(&own), rank(used)) {
        (Some(own), Some(used)) => used < own,
        // A folder that this list does not know is wrong until it is given a place.
        _ => false,
    }
}

/// A technique keeps wgpu in a folder `gpu` of its own.
fn may_name_wgpu(file: &Path) -> bool {
    let in_gpu = file
        .components()
        .rev()
        .skip(1)
        .any(|part| part.as_os_str() == "gpu");
    file.starts_with("render")
        || file.starts_with("bevy_adapter")
        || (file.starts_with("techniques") && in_gpu)
}

/// Every source file, path relative to `src/`, with comments and strings blanked.
pub(super) fn sources() -> Vec<(PathBuf, String)> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut open = vec![root.clone()];
    let mut found = Vec::new();
    while let Some(folder) = open.pop() {
        let entries =
            std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
        for entry in entries {
            let path = entry.expect("a folder entry").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|extension| extension == "rs") {
                let text = std::fs::read_to_string(&path).expect("a readable source");
                let file = path.strip_prefix(&root).expect("below src").to_owned();
                found.push((file, blank_comments_and_strings(&text)));
            }
        }
    }
    assert!(found.len() > 50, "only {} sources found", found.len());
    found.sort();
    found
}

/// First identifiers after the crate's root of every path in a text.
fn crate_paths(file: &Path, text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for at in word_starts(text, "crate") {
        if let Some(rest) = text[at + "crate".len()..].strip_prefix("::") {
            first_names(rest, &mut found);
        }
    }
    // `super` from a file's module reaches the root after as many steps as the module is deep.
    let name = file.file_stem().unwrap_or_default();
    let depth = file.components().count() - usize::from(name == "mod" || name == "lib");
    for at in word_starts(text, "super") {
        if text[..at].ends_with("super::") {
            continue; // in the middle of a chain
        }
        let mut rest = &text[at..];
        let mut steps = 0;
        while let Some(after) = rest.strip_prefix("super::") {
            rest = after;
            steps += 1;
        }
        if steps == depth && steps > 0 {
            first_names(rest, &mut found);
        }
    }
    found
}

/// The identifier that a path begins with, or those that each path of a `{…}` group begins with.
fn first_names(rest: &str, found: &mut Vec<String>) {
    let Some(group) = rest.strip_prefix('{') else {
        found.extend(identifier(rest));
        return;
    };
    let mut depth = 0;
    let mut at_start = true;
    for (at, c) in group.char_indices() {
        match c {
            '}' if depth == 0 => return,
            '{' => depth += 1,
            '}' => depth -= 1,
            ',' if depth == 0 => at_start = true,
            c if at_start && !c.is_whitespace() => {
                found.extend(identifier(&group[at..]));
                at_start = false;
            }
            _ => {}
        }
    }
}

pub(super) fn identifier(text: &str) -> Option<String> {
    let end = text.find(|c: char| !is_word(c)).unwrap_or(text.len());
    (end > 0).then(|| text[..end].to_owned())
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn has_word(text: &str, word: &str) -> bool {
    !word_starts(text, word).is_empty()
}

pub(super) fn word_starts(text: &str, word: &str) -> Vec<usize> {
    text.match_indices(word)
        .map(|(at, _)| at)
        .filter(|&at| {
            let before = text[..at].chars().next_back();
            let after = text[at + word.len()..].chars().next();
            !before.is_some_and(is_word) && !after.is_some_and(is_word)
        })
        .collect()
}

/// Puts spaces for comments and for the insides of string literals.
fn blank_comments_and_strings(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("'\"'") {
            3 // the one character literal that would open a string
        } else if c == '"' {
            string_length(rest)
        } else {
            out.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        out.push(' ');
        rest = &rest[skipped..];
    }
    out
}

fn string_length(text: &str) -> usize {
    let mut escaped = false;
    for (at, c) in text.char_indices().skip(1) {
        match c {
            _ if escaped => escaped = false,
            '\\' => escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}
