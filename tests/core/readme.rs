//! The README and the guide name files, targets, examples and features that are there.

use std::path::{Path, PathBuf};

use antumbra::prelude::{Light, LightKind};

const PAGES: [&str; 7] = [
    "README.md",
    "src/guide/engines.md",
    "src/guide/shot_file.md",
    "src/guide/own_technique.md",
    "src/guide/cells_and_portals.md",
    "src/guide/reports.md",
    "src/guide/limits.md",
];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Targets of Markdown links and pictures.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

/// Lines of the shell blocks, without comments.
fn commands(text: &str) -> Vec<&str> {
    let blocks = text
        .split("```sh\n")
        .skip(1)
        .filter_map(|rest| rest.split("```").next());
    let lines = blocks
        .flat_map(str::lines)
        .map(|line| line.split(" #").next().unwrap_or_default().trim());
    lines.filter(|line| !line.is_empty()).collect()
}

/// Names of the packages below `examples`.
fn packages() -> impl Iterator<Item = String> {
    let folders = root()
        .join("examples")
        .read_dir()
        .expect("the examples are there");
    let manifests = folders
        .flatten()
        .filter_map(|entry| std::fs::read_to_string(entry.path().join("Cargo.toml")).ok());
    manifests.filter_map(|text| Some(text.split_once("name = \"")?.1.split_once('"')?.0.to_owned()))
}

/// Says what of a command is not there.
fn missing(command: &str, manifest: &str, makefile: &str) -> Option<String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    let named = |kind: &str, name: &str| {
        let entry = format!("[[{kind}]]\nname = \"{name}\"");
        manifest.contains(&entry) || root().join(format!("{kind}s/{name}.rs")).exists()
    };
    match words[..] {
        ["make", target, ref settings @ ..] => {
            let files = settings.iter().filter_map(|setting| setting.split('=').nth(1));
            let absent = files
                .filter(|file| !root().join(file).exists())
                .map(str::to_owned)
                .next();
            let unknown = !makefile.contains(&format!("\n{target}:"));
            unknown.then(|| format!("make {target}")).or(absent)
        }
        ["cargo", ..] => words.windows(2).find_map(|pair| match *pair {
            ["--example", name] => (!named("example", name)).then(|| format!("example {name}")),
            ["--bench", name] => (!named("bench", name)).then(|| format!("bench {name}")),
            ["--test", name] => (!named("test", name)).then(|| format!("test {name}")),
            ["--features", list] => list
                .split(',')
                .find(|feature| !manifest.contains(&format!("\n{feature} = [")))
                .map(|feature| format!("feature {feature}")),
            ["--package", name] => {
                (!packages().any(|package| package == name)).then(|| format!("package {name}"))
            }
            ["--", path] => ((path.ends_with(".json") || path.starts_with("assets/"))
                && !root().join(path).exists())
            .then(|| path.to_owned()),
            _ => None,
        }),
        _ => Some("a command of another program".to_owned()),
    }
}

#[test]
fn links_lead_somewhere() {
    let mut count = 0;
    for page in PAGES {
        let text = read(page);
        for link in links(&text).filter(|link| !link.starts_with("https://")) {
            count += 1;
            let path: PathBuf = root().join(page).parent().expect("a folder").join(link);
            assert!(path.exists(), "{page}: {link}");
        }
    }
    assert!(count > 5, "only {count} links were found");
}

#[test]
fn commands_are_there() {
    let (manifest, makefile) = (read("Cargo.toml"), read("Makefile"));
    let mut count = 0;
    for page in PAGES {
        for command in commands(&read(page)) {
            count += 1;
            assert_eq!(missing(command, &manifest, &makefile), None, "{page}: {command}");
        }
    }
    assert!(count > 3, "only {count} commands were found");
}

#[test]
fn a_command_that_is_not_there_is_noticed() {
    let (manifest, makefile) = (read("Cargo.toml"), read("Makefile"));
    for command in [
        "make tea",
        "make demo SCENE=assets/none.glb",
        "cargo run --package none",
        "cargo run --example none",
        "cargo run --features bevy,tea --example render",
    ] {
        assert!(missing(command, &manifest, &makefile).is_some(), "{command}");
    }
}

#[test]
fn the_readme_is_short() {
    let lines = read("README.md").lines().count();
    assert!(lines <= 200, "{lines} lines");
}

/// Names in the table of pictures: cells of code, between its marks.
fn pictured(readme: &str) -> Vec<&str> {
    let rest = readme
        .split("<!-- techniques: written by make pictures -->")
        .nth(1);
    let table = rest.and_then(|rest| rest.split("<!-- end of techniques -->").next());
    table.unwrap_or_default().split('`').skip(1).step_by(2).collect()
}

#[test]
fn the_readme_shows_every_technique() {
    let readme = read("README.md");
    let shown = pictured(&readme);
    let light = Light::point(glam::Vec3::ONE, 1.0, 1.0);
    let kinds = [
        LightKind::Point,
        LightKind::Directional,
        LightKind::Rect {
            width: 1.0,
            height: 1.0,
        },
    ];
    for row in antumbra::techniques::Techniques::default().rows() {
        let takes = |kind| {
            row.defaults()
                .check(&Light {
                    kind,
                    ..light.clone()
                })
                .is_ok()
        };
        if kinds.into_iter().any(takes) {
            assert!(shown.contains(&row.name()), "{}: run `make pictures`", row.name());
            let picture = format!("(assets/readme/{}.png)", row.name());
            assert!(readme.contains(&picture), "{picture}");
        }
    }
}

#[test]
fn names_outside_the_table_do_not_count() {
    let text = "`a` <!-- techniques: written by make pictures -->| `b` | `c` |<!-- end of techniques --> `d`";
    assert_eq!(pictured(text), ["b", "c"]);
    assert_eq!(pictured("`a`"), [""; 0]);
}
