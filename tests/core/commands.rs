//! Every command that users read can be run: its targets, packages, features, filters, options and files are there, and the
//! features suffice for what it runs.
//!
//! Commands are read from shell blocks and from inline code that begins with `cargo` or `make`, in the README, in the
//! guide, and in the documentation comments of the crate and of the examples.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::readme::{PAGES, read, root};

/// Targets and features of `Cargo.toml`, and the `Makefile`.
struct Manifest {
    features: BTreeMap<String, Vec<String>>,
    /// Features that a target needs, by its kind and name.
    required: BTreeMap<(String, String), Vec<String>>,
    makefile: String,
}

/// Returns the texts in quotes.
fn quoted(text: &str) -> Vec<String> {
    text.split('"').skip(1).step_by(2).map(str::to_owned).collect()
}

impl Manifest {
    fn new() -> Self {
        let mut manifest = Self {
            features: BTreeMap::new(),
            required: BTreeMap::new(),
            makefile: read("Makefile"),
        };
        let (mut section, mut name) = (String::new(), String::new());
        for line in read("Cargo.toml").lines() {
            if line.starts_with('[') {
                section = line.trim_matches(['[', ']']).to_owned();
            }
            let Some((key, value)) = line.split_once(" = ") else {
                continue;
            };
            match (section.as_str(), key) {
                ("features", feature) => {
                    manifest.features.insert(feature.to_owned(), quoted(value));
                }
                ("example" | "test" | "bench", "name") => name = quoted(value).concat(),
                ("example" | "test" | "bench", "required-features") => {
                    let target = (section.clone(), name.clone());
                    manifest.required.insert(target, quoted(value));
                }
                _ => {}
            }
        }
        manifest
    }

    /// Returns the features that a list turns on, with those that they turn on in turn.
    fn with_all<'a>(&'a self, given: impl IntoIterator<Item = &'a str>) -> BTreeSet<&'a str> {
        let mut on = BTreeSet::new();
        let mut open: Vec<&str> = given.into_iter().collect();
        while let Some(feature) = open.pop() {
            if on.insert(feature) {
                let next = self.features.get(feature).into_iter().flatten();
                open.extend(
                    next.map(String::as_str)
                        .filter(|next| self.features.contains_key(*next)),
                );
            }
        }
        on
    }
}

/// Returns the files below a folder that end in `.rs`, and the file itself if it is one.
fn sources(path: &Path) -> Vec<PathBuf> {
    if path.is_file() {
        return vec![path.to_owned()];
    }
    let entries = path.read_dir().into_iter().flatten().flatten();
    let mut files: Vec<PathBuf> = entries.flat_map(|entry| sources(&entry.path())).collect();
    files.retain(|file| file.extension().is_some_and(|ending| ending == "rs"));
    files.sort();
    files
}

/// Returns the sources of a target of this package.
fn target(kind: &str, name: &str) -> Vec<PathBuf> {
    let folder = root().join(match kind {
        "bench" => "benches".to_owned(),
        kind => format!("{kind}s"),
    });
    let file = folder.join(format!("{name}.rs"));
    if file.is_file() {
        return vec![file];
    }
    let main = folder.join(name).join("main.rs");
    if main.is_file() {
        sources(&folder.join(name))
    } else {
        Vec::new()
    }
}

/// Returns the folder of a package below `examples`.
fn package(name: &str) -> Option<PathBuf> {
    let line = format!("name = \"{name}\"");
    let folders = root()
        .join("examples")
        .read_dir()
        .expect("the examples are there")
        .flatten();
    let mut folders = folders.map(|entry| entry.path());
    folders.find(|folder| {
        std::fs::read_to_string(folder.join("Cargo.toml")).is_ok_and(|text| text.contains(&line))
    })
}

/// Whether a word stands for something that the user fills in.
fn is_placeholder(word: &str) -> bool {
    let letters = |c: char| c.is_ascii_uppercase() || "[]|.…<>".contains(c);
    word.starts_with('[')
        || word.ends_with(']')
        || word
            .split('.')
            .next()
            .is_some_and(|stem| stem.chars().all(letters))
}

/// Says what of a `make` command is not there.
fn missing_of_make(words: &[&str], makefile: &str) -> Option<String> {
    words.iter().find_map(|word| match word.split_once('=') {
        Some((variable, file)) => {
            let is_known = makefile.contains(&format!("\n{variable} ?= "));
            let is_there = is_placeholder(file) || root().join(file).exists();
            (!is_known || !is_there).then(|| (*word).to_owned())
        }
        None => (!makefile.contains(&format!("\n{word}:"))).then(|| format!("target {word}")),
    })
}

/// The targets, features and options that a `cargo` command names.
#[derive(Default)]
struct Named<'a> {
    targets: Vec<(&'a str, &'a str)>,
    package: Option<&'a str>,
    features: Vec<&'a str>,
    has_all: bool,
    has_no_default: bool,
    filters: Vec<&'a str>,
    arguments: Vec<&'a str>,
}

/// Options of cargo that commands may have without a value.
const FLAGS: [&str; 6] = [
    "--release",
    "--open",
    "--no-deps",
    "--lib",
    "--workspace",
    "--no-run",
];

fn parse<'a>(words: &[&'a str]) -> Result<Named<'a>, String> {
    let mut named = Named::default();
    let mut words = words.iter().copied();
    while let Some(word) = words.next() {
        let mut value = || words.next().ok_or_else(|| format!("{word} without a value"));
        match word {
            "--" => named.arguments.extend(words.by_ref()),
            "--example" | "--test" | "--bench" => named.targets.push((&word[2..], value()?)),
            "--package" => named.package = Some(value()?),
            "--features" => named.features.extend(value()?.split(',')),
            "--all-features" => named.has_all = true,
            "--no-default-features" => named.has_no_default = true,
            flag if FLAGS.contains(&flag) => {}
            option if option.starts_with('-') => return Err(format!("option {option}")),
            filter => named.filters.push(filter),
        }
    }
    Ok(named)
}

/// Says what of a `cargo` command is not there.
fn missing_of_cargo(command: &str, words: &[&str], manifest: &Manifest) -> Option<String> {
    if !["run", "test", "bench", "doc", "build"].contains(&command) {
        return Some(format!("cargo {command}"));
    }
    let named = match parse(words) {
        Ok(named) => named,
        Err(missing) => return Some(missing),
    };
    if let Some(feature) = named
        .features
        .iter()
        .find(|feature| !manifest.features.contains_key(**feature))
    {
        return Some(format!("feature {feature}"));
    }
    let default = (!named.has_no_default).then_some("default");
    let on = manifest.with_all(named.features.iter().copied().chain(default));
    let mut files = Vec::new();
    for &(kind, name) in &named.targets {
        let sources = target(kind, name);
        if sources.is_empty() {
            return Some(format!("{kind} {name}"));
        }
        files.extend(sources);
        let needed = manifest.required.get(&(kind.to_owned(), name.to_owned()));
        let lacking = needed
            .into_iter()
            .flatten()
            .find(|feature| !on.contains(feature.as_str()));
        if let (Some(feature), false) = (lacking, named.has_all) {
            return Some(format!("feature {feature}, which {kind} {name} needs"));
        }
    }
    if let Some(name) = named.package {
        let Some(folder) = package(name) else {
            return Some(format!("package {name}"));
        };
        files.extend(sources(&folder));
    }
    if command == "run" && files.is_empty() {
        return Some("an example or a package".to_owned());
    }
    missing_words(command, &named, files)
}

/// Says which option, file or filter of a `cargo` command the sources of what it runs do not have.
fn missing_words(command: &str, named: &Named, mut files: Vec<PathBuf>) -> Option<String> {
    files.extend(sources(&root().join("examples/support"))); // options that examples share
    let texts: Vec<String> = files
        .iter()
        .map(|file| {
            let text = std::fs::read_to_string(file).unwrap_or_default();
            format!("{}\n{text}", file.display())
        })
        .collect();
    let is_said = |word: &str| texts.iter().any(|text| text.contains(word));
    // Files below `out/` are written by the command.
    let is_file =
        |word: &str| word.contains(['/', '.']) && !word.starts_with("out/") && !is_placeholder(word);
    let is_missing = |word: &&str| match word.strip_prefix("--") {
        // The harness of tests has options of its own.
        Some(_) if command == "test" => !["--nocapture", "--ignored", "--include-ignored"].contains(word),
        Some(option) => !is_said(&option.replace('-', "_")) && !is_said(&format!("\"{word}\"")),
        None => is_file(word) && !root().join(word).exists(),
    };
    let words = named.arguments.iter().map(|word| word.trim_matches(['[', ']']));
    let argument = words.filter(|word| *word != "...").find(is_missing);
    let mut filters = named.filters.iter().flat_map(|filter| filter.split("::"));
    argument.map(str::to_owned).or_else(|| {
        let missing = filters.find(|word| !is_said(word))?;
        Some(format!("test {missing}"))
    })
}

/// Says what of a command is not there.
fn missing(command: &str, manifest: &Manifest) -> Option<String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    match words[..] {
        ["make", ref words @ ..] => missing_of_make(words, &manifest.makefile),
        ["cargo", command, ref words @ ..] => missing_of_cargo(command, words, manifest),
        _ => Some("a command of another program".to_owned()),
    }
}

/// Returns the lines of shell blocks, without comments, and inline code that begins with `cargo` or `make`.
fn commands(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (index, part) in text.split("```").enumerate() {
        if index % 2 == 1 {
            let lines = part.strip_prefix("sh\n").into_iter().flat_map(str::lines);
            let lines = lines.map(|line| line.split(" #").next().unwrap_or_default().trim());
            found.extend(lines.filter(|line| !line.is_empty()).map(str::to_owned));
        } else {
            let code = part.split('`').skip(1).step_by(2);
            let own = code.filter(|code| code.starts_with("cargo ") || code.starts_with("make "));
            found.extend(own.map(|code| code.split_whitespace().collect::<Vec<_>>().join(" ")));
        }
    }
    found
}

/// Returns the blocks of documentation comments, without their marks.
fn documentation(source: &str) -> Vec<String> {
    let mut blocks = vec![String::new()];
    for line in source.lines() {
        let line = line.trim_start();
        let text = line.strip_prefix("//!").or_else(|| line.strip_prefix("///"));
        match (text, blocks.last_mut()) {
            (Some(text), Some(block)) => {
                block.push_str(text.strip_prefix(' ').unwrap_or(text));
                block.push('\n');
            }
            _ => blocks.push(String::new()),
        }
    }
    blocks.retain(|block| !block.is_empty());
    blocks
}

#[test]
fn every_command_that_users_read_can_be_run() {
    let manifest = Manifest::new();
    let pages = PAGES.iter().map(|page| ((*page).to_owned(), read(page)));
    let files = ["src", "examples"]
        .into_iter()
        .flat_map(|folder| sources(&root().join(folder)));
    let documented = files.flat_map(|file| {
        let source = std::fs::read_to_string(&file).expect("a source");
        let blocks = documentation(&source).into_iter();
        blocks.map(move |block| (file.display().to_string(), block))
    });
    let (mut faults, mut count) = (Vec::new(), BTreeMap::<String, usize>::new());
    for (page, text) in pages.chain(documented) {
        for command in commands(&text) {
            *count.entry(page.clone()).or_default() += 1;
            if let Some(missing) = missing(&command, &manifest) {
                faults.push(format!("{page}: `{command}`: {missing} is not there"));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    assert!(count["README.md"] >= 10 && count.len() >= 12, "{count:?}");
}

#[test]
fn what_a_command_lacks_is_named() {
    let manifest = Manifest::new();
    for (command, lacking) in [
        ("make tea", "target tea"),
        ("make demo SCENE=assets/none.glb", "SCENE=assets/none.glb"),
        ("make playground CUP=assets", "CUP=assets"),
        ("cargo brew", "cargo brew"),
        ("cargo run", "an example or a package"),
        ("cargo run --package none", "package none"),
        ("cargo run --example none", "example none"),
        ("cargo run --example render --hot", "option --hot"),
        ("cargo run --features bevy,tea --example render", "feature tea"),
        ("cargo run --example bevy_dungeon", "feature bevy, which"),
        (
            "cargo run --no-default-features --example render",
            "feature render, which",
        ),
        (
            "cargo run --features bevy --example bevy_character",
            "feature bevy-window, which",
        ),
        (
            "cargo run --example render -- assets/none.json",
            "assets/none.json",
        ),
        ("cargo run --example render -- SHOT.json --brew DIR", "--brew"),
        (
            "cargo test --all-features --test gpu no_such_test",
            "test no_such_test",
        ),
        ("cargo test --test gpu -- --brew", "feature reference, which"),
        ("cargo test --all-features --test gpu -- --brew", "--brew"),
        ("rm -r out", "another program"),
    ] {
        let found = missing(command, &manifest);
        assert!(
            found.as_ref().is_some_and(|found| found.contains(lacking)),
            "{command}: {found:?}"
        );
    }
    // Features bring others with them, and all of them suffice for everything.
    for command in [
        "cargo run --features bevy-window --example bevy_dungeon",
        "cargo run --all-features --example bevy_character",
        "cargo run --example render -- SHOT.json --out DIR [--size 320x180]",
    ] {
        assert_eq!(missing(command, &manifest), None, "{command}");
    }
}

#[test]
fn commands_are_found_in_blocks_and_in_code() {
    let text = "Run `make tea`, not `making`.\n```sh\ncargo run # why\n\n```\n```rust\ncargo no\n```\nand `cargo run\nx`";
    assert_eq!(commands(text), ["make tea", "cargo run", "cargo run x"]);
    let source = "//! One\n//! `make tea`\nfn a() {} // `make no`\n/// Two\n";
    assert_eq!(documentation(source), ["One\n`make tea`\n", "Two\n"]);
}
