//! Pages of models that are not part of the repository; a folder may hold any of them, at any depth.

use std::path::{Path, PathBuf};

use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::page::{NamedLight, Page, PageShot, PlacedModel};
use super::pages::{directional, ground, point};

/// A page for each known model of the folder.
///
/// # Errors
/// If the folder cannot be read, or holds none of them.
pub fn of_folder(folder: &Path) -> Result<Vec<Page>, String> {
    let files = files_below(folder)?;
    let pages: Vec<Page> = known()
        .into_iter()
        .filter_map(|(file_name, pose, mut page)| {
            let file = files
                .iter()
                .find(|file| file.file_name().is_some_and(|name| name == file_name))?;
            page.models.push(PlacedModel {
                file: file.clone(),
                transform: Transform::IDENTITY,
                pose,
            });
            Some(page)
        })
        .collect();
    if pages.is_empty() {
        let names: Vec<&str> = known().into_iter().map(|(name, ..)| name).collect();
        return Err(format!(
            "{}: none of {} is there",
            folder.display(),
            names.join(", ")
        ));
    }
    Ok(pages)
}

type Known = (&'static str, Option<(&'static str, f32)>, Page);

fn known() -> Vec<Known> {
    let sun = || directional("sun", [-0.5, -1.0, -0.4], [1.0, 0.95, 0.88], 2.6);
    vec![
        (
            "dungeon_A.glb",
            None,
            page(
                "dungeon",
                "A dungeon",
                "Modular pieces under the file's own torches.",
                "torch_2",
                Vec::new(),
                0.2,
            ),
        ),
        (
            "town_A.glb",
            None,
            page(
                "town",
                "A town",
                "Many small houses under one sun.",
                "sun",
                Vec::new(),
                1.0,
            ),
        ),
        (
            "flight_helmet.glb",
            None,
            with_ground(page(
                "helmet",
                "Flight helmet",
                "Straps, lenses and stitching: open shells, close together.",
                "sun",
                vec![sun(), point("lamp", [-0.7, 0.9, 0.8], [0.5, 0.7, 1.0], 0.5, 4.0)],
                1.0,
            )),
        ),
        (
            "pirate_ship_dark.glb",
            None,
            page(
                "ship",
                "Pirate ship",
                "Sails and rigging are single sheets that cast from both sides.",
                "sun",
                vec![sun()],
                1.0,
            ),
        ),
        (
            "knight.glb",
            Some(("chop", 0.4)),
            with_ground(page(
                "knight",
                "A knight in motion",
                "Skinned: posed first, then his silhouette is found in that pose.",
                "sun",
                vec![sun()],
                1.0,
            )),
        ),
        (
            "many_cubes.glb",
            None,
            page(
                "cubes",
                "Many cubes",
                "What many small casters cost.",
                "sun",
                vec![sun()],
                1.0,
            ),
        ),
    ]
}

fn page(
    name: &'static str,
    title: &'static str,
    about: &'static str,
    light: &'static str,
    lights: Vec<NamedLight>,
    exposure: f32,
) -> Page {
    Page {
        lights,
        ambient: Vec3::splat(0.06),
        shots: vec![PageShot {
            name: "all",
            caption: "The whole of it.",
            camera: None,
            light,
            exposure,
        }],
        ..Page::new(name, title, about)
    }
}

fn with_ground(mut page: Page) -> Page {
    page.objects.push(ground(4.0));
    page
}

/// All files below a folder, sorted.
fn files_below(folder: &Path) -> Result<Vec<PathBuf>, String> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        let named = |error: std::io::Error| format!("{}: {error}", folder.display());
        for entry in std::fs::read_dir(&folder).map_err(named)? {
            let path = entry.map_err(named)?.path();
            if path.is_dir() {
                open.push(path);
            } else {
                found.push(path);
            }
        }
    }
    found.sort();
    Ok(found)
}
