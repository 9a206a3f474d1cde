//! The pictures of the README: the flat, and one judged light as a strip of panels.

use std::path::Path;

use glam::UVec2;

use super::judge::Workbench;
use super::page::PageShot;
use super::{pages, panels, support::picture};

/// Twice the size of the hero picture, which is averaged down.
const HERO: UVec2 = UVec2::new(1920, 1080);

/// Twice the size of a panel of the strip.
const PANEL: UVec2 = UVec2::new(472, 266);

/// Name of the flat's shot that both pictures show.
const SHOT: &str = "dining";

/// Renders `hero.png` and `judgement.png` into `readme/` of the assets.
///
/// # Errors
/// One line that names the file and the element.
pub fn write(bench: &mut Workbench, assets: &Path) -> Result<(), String> {
    let out = assets.join("readme");
    std::fs::create_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    let page = pages::interior(&assets.join("models"));
    let shot: &PageShot = page
        .shots
        .iter()
        .find(|shot| shot.name == SHOT)
        .ok_or_else(|| format!("page {}: no shot {SHOT}", page.name))?;

    bench.size = PANEL;
    let shown = bench.panels(&page, shot)?;
    // Visibility and difference are exact to the pixel, so they are rendered at half size and not averaged.
    bench.size = PANEL / 2;
    let exact = bench.panels(&page, shot)?;
    let (size, smooth) = panels::halve(PANEL, &shown.picture);
    let (_, volumes) = panels::halve(PANEL, &shown.volumes);
    let strip = [
        &smooth[..],
        &volumes,
        &exact.visibility,
        &exact.truth,
        &exact.difference.rgba8,
    ];
    let (size, strip) = panels::side_by_side(size, &strip, 5);
    report(&out.join("judgement.png"), size, &strip)?;

    bench.size = HERO;
    let large = bench.hero(&page, shot)?;
    let (size, hero) = panels::halve(HERO, &large);
    report(&out.join("hero.png"), size, &hero)
}

fn report(path: &Path, size: UVec2, rgba8: &[u8]) -> Result<(), String> {
    picture::write_png(path, size, rgba8)?;
    println!("{}", path.display());
    Ok(())
}
