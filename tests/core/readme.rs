//! The README is short, shows every technique, and links to files that are there.

use std::path::{Path, PathBuf};

use antumbra::prelude::{Light, LightKind};

/// The pages that users read, beside the documentation of items.
pub const PAGES: [&str; 7] = [
    "README.md",
    "src/guide/engines.md",
    "src/guide/shot_file.md",
    "src/guide/own_technique.md",
    "src/guide/cells_and_portals.md",
    "src/guide/reports.md",
    "src/guide/limits.md",
];

pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

pub fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Targets of Markdown links and pictures.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next())
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
