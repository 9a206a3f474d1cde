//! The pictures of the README: the flat, one judged light as a strip of panels, and a scene under every technique, whose
//! table is written into the README as well.

use std::path::Path;

use antumbra::prelude::{Light, LightKind};
use bevy_transform::prelude::Transform;
use glam::{UVec2, Vec3};

use super::judge::Workbench;
use super::page::{NamedLight, Page, PageShot, PlacedModel, view};
use super::support::picture;
use super::way::{Way, light_kinds};
use super::{pages, panels};

/// Twice the size of the hero picture, which is averaged down.
const HERO: UVec2 = UVec2::new(1920, 1080);

/// Twice the size of a panel of the strip.
const PANEL: UVec2 = UVec2::new(472, 266);

/// Twice the size of a picture of the scene under every technique.
const CELL: UVec2 = UVec2::new(480, 320);

/// Number of pictures of a line of the table.
const COLUMNS: usize = 4;

/// Lines of the README between which the table is written.
pub const MARKS: [&str; 2] = [
    "<!-- techniques: written by make pictures -->",
    "<!-- end of techniques -->",
];

/// Name of the flat's shot that both pictures show.
const SHOT: &str = "dining";

/// Renders `hero.png`, `judgement.png` and a picture for each technique into `readme/` of the assets, and writes the table
/// of the techniques into the README. Without `all`, leaves out the first two.
///
/// # Errors
/// One line that names the file and the element.
pub fn write(bench: &mut Workbench, assets: &Path, all: bool) -> Result<(), String> {
    let out = assets.join("readme");
    std::fs::create_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    if all {
        flat(bench, assets, &out)?;
    }
    techniques(bench, assets, &out)
}

/// Renders `hero.png` and `judgement.png`.
fn flat(bench: &mut Workbench, assets: &Path, out: &Path) -> Result<(), String> {
    let page = pages::interior(&assets.join("models"));
    let shot: &PageShot = page
        .shots
        .iter()
        .find(|shot| shot.name == SHOT)
        .ok_or_else(|| format!("page {}: no shot {SHOT}", page.name))?;

    let way = page.ways.first().ok_or("there is no technique")?;
    bench.size = PANEL;
    let (picture, shown) = bench.panels(&page, shot, way)?;
    // Visibility and difference are exact to the pixel, so they are rendered at half size and not averaged.
    bench.size = PANEL / 2;
    let (_, exact) = bench.panels(&page, shot, way)?;
    let smooth = panels::reduce(PANEL, &picture, PANEL / 2);
    let volumes = panels::reduce(PANEL, &shown.volumes, PANEL / 2);
    let strip = [
        &smooth[..],
        &volumes,
        &exact.visibility,
        &exact.truth,
        &exact.difference.rgba8,
    ];
    let (size, strip) = panels::side_by_side(PANEL / 2, &strip, 5);
    report(&out.join("judgement.png"), size, &strip)?;

    bench.size = HERO;
    let large = bench.hero(&page, shot, way)?;
    let hero = panels::reduce(HERO, &large, HERO / 2);
    report(&out.join("hero.png"), HERO / 2, &hero)
}

/// Renders a scene under every technique of the list, and writes the table into the README.
fn techniques(bench: &mut Workbench, assets: &Path, out: &Path) -> Result<(), String> {
    bench.size = CELL;
    let page = deer(&assets.join("models"));
    let shot = page.shots.first().ok_or("the page has no shot")?;
    let mut cells = Vec::new();
    for way in &page.ways {
        let lit = lit_for(&page, way);
        if way.settings.check(&lit.lights[0].light).is_err() {
            continue; // It takes no light without settings of its own.
        }
        let large = bench.hero(&lit, shot, way)?;
        let pixels = panels::reduce(CELL, &large, CELL / 2);
        report(&out.join(format!("{}.png", way.name)), CELL / 2, &pixels)?;
        cells.push(&way.name);
    }
    let readme = assets.join("../README.md");
    let named = |error: std::io::Error| format!("{}: {error}", readme.display());
    let text = std::fs::read_to_string(&readme).map_err(named)?;
    let parts = text
        .split_once(MARKS[0])
        .and_then(|(before, rest)| Some((before, rest.split_once(MARKS[1])?.1)));
    let (before, after) = parts.ok_or_else(|| format!("{}: no line {}", readme.display(), MARKS[0]))?;
    let text = format!("{before}{}\n\n{}\n{}{after}", MARKS[0], table(&cells), MARKS[1]);
    std::fs::write(&readme, text).map_err(named)
}

/// Returns a deer before a low square light, whose shadow falls towards the viewer.
fn deer(models: &Path) -> Page {
    let light = Light {
        kind: LightKind::Rect {
            width: 0.6,
            height: 0.6,
        },
        color: Vec3::new(1.0, 0.84, 0.62),
        intensity: 52.0,
        range: f32::INFINITY,
    };
    let place = Transform::from_xyz(2.7, 3.9, 0.2).looking_at(Vec3::new(-0.6, 0.4, 0.0), Vec3::Y);
    Page {
        models: vec![PlacedModel {
            transform: Transform::from_scale(Vec3::splat(0.2)),
            ..pages::model(models, "deer.glb")
        }],
        objects: vec![pages::ground(20.0)],
        lights: vec![NamedLight {
            name: "lamp",
            light,
            transform: place,
        }],
        ambient: Vec3::new(0.035, 0.045, 0.065),
        shots: vec![PageShot {
            name: "deer",
            caption: "",
            camera: view([0.6, 2.1, 5.4], [-0.75, 0.78, 0.0], 27.0),
            light: "lamp",
            exposure: 1.0,
        }],
        ..Page::new("readme", "", "")
    }
}

/// Returns the page with a light that the way takes: its own, or else the first kind that the way does not refuse.
fn lit_for(page: &Page, way: &Way) -> Page {
    let mut page = page.clone();
    for named in &mut page.lights {
        let refused = |light: &Light| way.settings.check(light).is_err();
        let kinds = light_kinds().into_iter().map(|(_, kind)| kind);
        if refused(&named.light)
            && let Some(kind) = kinds.clone().find(|&kind| {
                !refused(&Light {
                    kind,
                    ..named.light.clone()
                })
            })
        {
            named.light.kind = kind;
        }
    }
    page
}

/// Returns names and pictures as a table of Markdown.
fn table(names: &[&String]) -> String {
    let line = |cells: Vec<String>| format!("| {} |\n", cells.join(" | "));
    let mut text = String::new();
    for (index, names) in names.chunks(COLUMNS).enumerate() {
        let padded = |cell: &dyn Fn(&str) -> String| {
            let mut cells: Vec<String> = names.iter().map(|name| cell(name)).collect();
            cells.resize(COLUMNS, String::new());
            line(cells)
        };
        text += &padded(&|name| format!("`{name}`"));
        if index == 0 {
            text += &line(vec!["---".to_owned(); COLUMNS]);
        }
        text += &padded(&|name| format!("![{}](assets/readme/{name}.png)", name.replace('_', " ")));
    }
    text
}

fn report(path: &Path, size: UVec2, rgba8: &[u8]) -> Result<(), String> {
    picture::write_png(path, size, rgba8)?;
    println!("{}", path.display());
    Ok(())
}
