//! Files of `src/` import each other in few circles: who reads one file of a circle must read all of them.
//!
//! Reads the sources as text, as `layers` does. A path leads to the file of the longest module that it names, through
//! re-exports; what `mod.rs` re-exports is not used there, and unit tests at a file's end may use what they want.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use super::layers::{PRELUDE, identifier, sources, word_starts};

/// Circles that there may be.
const ALLOWED: usize = 4;

#[test]
fn imports_run_in_few_circles() {
    let graph = Graph::new(&sources());
    let edges: usize = graph.uses.values().map(BTreeSet::len).sum();
    assert!(edges > 500, "only {edges} imports found: the reader is broken");
    let circles = graph.circles();
    let told: Vec<String> = circles.iter().map(|circle| graph.tell(circle)).collect();
    println!("{}", told.join("\n"));
    assert!(
        circles.len() <= ALLOWED,
        "{} circles, {ALLOWED} are allowed\n{}",
        circles.len(),
        told.join("\n")
    );
}

#[test]
fn the_reader_finds_circles_through_groups_re_exports_and_children() {
    let circles = |files: &[(&str, &str)]| {
        let files: Vec<_> = files
            .iter()
            .map(|(file, text)| (PathBuf::from(file), (*text).to_owned()))
            .collect();
        let circles = Graph::new(&files).circles();
        let name = |file: &PathBuf| file.display().to_string();
        circles
            .iter()
            .map(|circle| circle.iter().map(name).collect::<Vec<_>>().join(" "))
            .collect::<Vec<_>>()
    };
    let a_uses_b = ("a.rs", "use crate::b::{C, D};\nfn f() {}");
    let none: [&str; 0] = [];
    assert_eq!(circles(&[a_uses_b, ("b.rs", "struct C;")]), none);
    assert_eq!(circles(&[a_uses_b, ("b.rs", "use super::a::f;")]), ["a.rs b.rs"]);
    assert_eq!(
        circles(&[a_uses_b, ("b.rs", "fn g() { crate::a::f() }")]),
        ["a.rs b.rs"]
    );
    // By way of a folder's mod.rs, which is no part of the circle.
    assert_eq!(
        circles(&[
            (
                "a/mod.rs",
                "mod x;\nmod y;\npub use x::{X, g as h};\npub use self::y::Y;"
            ),
            ("a/x.rs", "use super::Y;"),
            ("a/y.rs", "fn f() { crate::a::h() }"),
        ]),
        ["a/x.rs a/y.rs"]
    );
    // A longer one, and one apart from it.
    assert_eq!(
        circles(&[
            ("a.rs", "use crate::{b::B, d};"),
            ("b.rs", "use crate::c as other;"),
            ("c.rs", "use crate::a::A;"),
            ("d.rs", "use crate::e::*;"),
            ("e.rs", "pub(crate) use super::d::D;"),
        ]),
        ["a.rs b.rs c.rs", "d.rs e.rs"]
    );
    // Unit tests are no circle.
    let tests = ("b.rs", "struct C;\n#[cfg(test)]\nmod tests { use crate::a::f; }");
    assert_eq!(circles(&[a_uses_b, tests]), none);
}

/// A module's path from the crate's root.
type Module = Vec<String>;

struct Graph {
    /// By file, the files that it uses.
    uses: BTreeMap<PathBuf, BTreeSet<PathBuf>>,
}

impl Graph {
    fn new(sources: &[(PathBuf, String)]) -> Self {
        let files: BTreeMap<Module, PathBuf> = sources
            .iter()
            .map(|(file, _)| (module_of(file), file.clone()))
            .collect();
        let mut exports: BTreeMap<(Module, String), Module> = BTreeMap::new();
        let mut paths = Vec::new();
        for (file, text) in sources {
            let module = module_of(file);
            let names_all = file == Path::new("lib.rs") || file == Path::new(PRELUDE);
            let end = text.find("#[cfg(test)]\nmod ").unwrap_or(text.len());
            for path in paths_of(&text[..end]) {
                let Some(absolute) = absolute(&module, &path.segments, &files) else {
                    continue;
                };
                if path.is_export {
                    exports.insert((module.clone(), path.name), absolute.clone());
                }
                let passes_on = path.is_export && file.ends_with("mod.rs");
                if !(names_all || passes_on) {
                    paths.push((file.clone(), absolute));
                }
            }
        }
        let mut uses: BTreeMap<PathBuf, BTreeSet<PathBuf>> = BTreeMap::new();
        for (file, path) in paths {
            if let Some(used) = file_of(&path, &files, &exports, 8)
                && used != file
                && used != Path::new("lib.rs")
            {
                uses.entry(file).or_default().insert(used);
            }
        }
        Self { uses }
    }

    /// Files that use each other, directly or by way of others.
    fn circles(&self) -> Vec<Vec<PathBuf>> {
        let reached: BTreeMap<&PathBuf, BTreeSet<&PathBuf>> =
            self.uses.keys().map(|file| (file, self.reached(file))).collect();
        let is_tied = |a: &PathBuf, b: &PathBuf| reached.get(a).is_some_and(|files| files.contains(b));
        let mut found: Vec<Vec<PathBuf>> = Vec::new();
        for file in self.uses.keys().filter(|file| is_tied(file, file)) {
            if found.iter().flatten().any(|known| known == file) {
                continue;
            }
            let tied = reached[file].iter().filter(|other| is_tied(other, file));
            found.push(tied.map(|&other| other.clone()).collect());
        }
        found
    }

    fn reached(&self, file: &PathBuf) -> BTreeSet<&PathBuf> {
        let mut reached = BTreeSet::new();
        let mut open: Vec<&PathBuf> = self.uses.get(file).into_iter().flatten().collect();
        while let Some(file) = open.pop() {
            if reached.insert(file) {
                open.extend(self.uses.get(file).into_iter().flatten());
            }
        }
        reached
    }

    /// The imports within a circle, for who wants to cut it.
    fn tell(&self, circle: &[PathBuf]) -> String {
        let lines = circle.iter().map(|file| {
            let used = self.uses[file].iter().filter(|used| circle.contains(used));
            let used: Vec<String> = used.map(|used| used.display().to_string()).collect();
            format!("  {} uses {}", file.display(), used.join(", "))
        });
        let lines: Vec<String> = lines.collect();
        format!("{} files:\n{}", circle.len(), lines.join("\n"))
    }
}

fn module_of(file: &Path) -> Module {
    let mut module: Module = file
        .with_extension("")
        .components()
        .map(|part| part.as_os_str().to_string_lossy().into_owned())
        .collect();
    if matches!(module.last().map(String::as_str), Some("mod" | "lib")) {
        module.pop();
    }
    module
}

/// A path as it is written.
struct Written {
    segments: Vec<String>,
    /// What it is called here.
    name: String,
    is_export: bool,
}

/// All paths in a text: those of `use`, and those that begin with `crate`, `super` or `self`.
fn paths_of(text: &str) -> Vec<Written> {
    let mut found = Vec::new();
    let mut rest = text.to_owned();
    for at in word_starts(text, "use") {
        let Some(length) = text[at..].find(';') else {
            continue;
        };
        let before = text[..at].trim_end();
        let is_export =
            before.ends_with("pub") || before.ends_with("pub(crate)") || before.ends_with("pub(super)");
        let tree = &text[at + "use".len()..at + length];
        for path in expanded(tree) {
            let (path, name) = path.split_once(" as ").unwrap_or((&path, ""));
            let segments: Vec<String> = path.split("::").map(|part| part.trim().to_owned()).collect();
            let last = segments.last().cloned().unwrap_or_default();
            let name = if name.is_empty() {
                last
            } else {
                name.trim().to_owned()
            };
            found.push(Written {
                segments,
                name,
                is_export,
            });
        }
        rest.replace_range(at..at + length, &" ".repeat(length));
    }
    for root in ["crate", "super", "self"] {
        for at in word_starts(&rest, root) {
            if rest[..at].ends_with("::") {
                continue; // in the middle of a path
            }
            let mut segments = Vec::new();
            let mut tail = &rest[at..];
            while let Some(name) = identifier(tail) {
                tail = &tail[name.len()..];
                segments.push(name);
                match tail.strip_prefix("::") {
                    Some(after) => tail = after,
                    None => break,
                }
            }
            if segments.len() > 1 {
                found.push(Written {
                    segments,
                    name: String::new(),
                    is_export: false,
                });
            }
        }
    }
    found
}

/// The paths of a tree of `use`: `a::{b, c::{d, e}}` is three.
fn expanded(tree: &str) -> Vec<String> {
    let tree = tree.trim();
    let Some((prefix, group)) = tree.split_once('{') else {
        return vec![tree.to_owned()];
    };
    let group = group.strip_suffix('}').unwrap_or(group);
    let mut depth = 0;
    let parts = group.split(|c: char| {
        depth += i32::from(c == '{') - i32::from(c == '}');
        c == ',' && depth == 0
    });
    parts
        .filter(|part| !part.trim().is_empty())
        .flat_map(expanded)
        .map(|path| format!("{prefix}{path}"))
        .collect()
}

/// A path from the crate's root; `None` if it leads out of the crate.
fn absolute(module: &Module, segments: &[String], files: &BTreeMap<Module, PathBuf>) -> Option<Module> {
    let first = segments.first()?;
    let mut base = module.clone();
    let mut rest = segments;
    match first.as_str() {
        "crate" => {
            base.clear();
            rest = &segments[1..];
        }
        "self" | "super" => {
            while let Some((first, after)) = rest
                .split_first()
                .filter(|(first, _)| *first == "self" || *first == "super")
            {
                if first == "super" {
                    base.pop()?;
                }
                rest = after;
            }
        }
        child => {
            let mut path = module.clone();
            path.push(child.to_owned());
            files.get(&path)?;
        }
    }
    base.extend(rest.iter().cloned());
    Some(base)
}

/// The file that a path leads to.
fn file_of(
    path: &Module,
    files: &BTreeMap<Module, PathBuf>,
    exports: &BTreeMap<(Module, String), Module>,
    steps: usize,
) -> Option<PathBuf> {
    let length = (0..=path.len()).rev().find(|&n| files.contains_key(&path[..n]))?;
    let (module, rest) = path.split_at(length);
    if let (Some(name), true) = (rest.first(), steps > 0)
        && let Some(exported) = exports.get(&(module.to_owned(), name.clone()))
    {
        let mut further = exported.clone();
        further.extend_from_slice(&rest[1..]);
        return file_of(&further, files, exports, steps - 1);
    }
    files.get(module).cloned()
}
