//! Pages of models that are not in the repository. A folder can hold any of them, at any depth.

use std::path::{Path, PathBuf};

use bevy_transform::prelude::Transform;
use glam::Vec3;

use super::page::{Page, PageShot, PlacedModel, view};
use super::pages::{directional, ground, point};
use super::support::shot::ShotCamera;

/// Returns a page for each known model of the folder.
///
/// # Errors
/// The folder cannot be read, or holds none of the known models.
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

/// A file name, a pose, and the page without the model.
type Known = (&'static str, Option<(&'static str, f32)>, Page);

fn known() -> Vec<Known> {
    let sun = || directional("sun", [-0.5, -1.0, -0.4], [1.0, 0.95, 0.88], 2.6);
    let dungeon = Page::new(
        "dungeon",
        "A dungeon",
        "Modular pieces under the file’s own torches.",
    );
    let town = Page::new("town", "A town", "Many small houses under the file’s own sun.");
    let helmet = Page {
        objects: vec![ground(1.2)],
        lights: vec![sun(), point("lamp", [-0.7, 0.9, 0.8], [0.5, 0.7, 1.0], 0.5, 4.0)],
        ..Page::new(
            "helmet",
            "Flight helmet",
            "Straps, lenses and stitching: open shells, close together.",
        )
    };
    let ship = Page {
        lights: vec![sun()],
        ..Page::new(
            "ship",
            "Pirate ship",
            "Sails and rigging are single sheets that cast from both sides.",
        )
    };
    let knight = Page {
        objects: vec![ground(4.0)],
        lights: vec![sun()],
        ..Page::new(
            "knight",
            "A knight in motion",
            "Skinned: posed first, then the silhouette is found in that pose.",
        )
    };
    let cubes = Page {
        lights: vec![sun()],
        ..Page::new("cubes", "Many cubes", "What many small casters cost.")
    };
    vec![
        (
            "dungeon_A.glb",
            None,
            one_shot(
                dungeon,
                view([20.2, 2.3, 9.0], [25.2, 1.0, 4.2], 65.0),
                "torch_0",
                0.5,
            ),
        ),
        (
            "town_A.glb",
            None,
            one_shot(town, view([6.0, 9.0, 24.0], [-2.0, 1.0, 2.0], 50.0), "sun", 1.0),
        ),
        (
            "flight_helmet.glb",
            None,
            one_shot(
                helmet,
                view([0.55, 0.65, 1.1], [0.0, 0.32, 0.0], 42.0),
                "sun",
                1.0,
            ),
        ),
        (
            "pirate_ship_dark.glb",
            None,
            one_shot(ship, view([6.2, 5.0, 8.0], [-0.4, 2.9, -0.6], 48.0), "sun", 1.0),
        ),
        (
            "knight.glb",
            Some(("chop", 0.4)),
            one_shot(knight, view([2.2, 2.3, 4.2], [-0.2, 1.05, 0.0], 42.0), "sun", 1.0),
        ),
        ("many_cubes.glb", None, one_shot(cubes, None, "sun", 1.0)),
    ]
}

fn one_shot(page: Page, camera: Option<ShotCamera>, light: &'static str, exposure: f32) -> Page {
    Page {
        ambient: Vec3::splat(0.06),
        shots: vec![PageShot {
            name: "view",
            caption: page.title,
            camera,
            light,
            exposure,
        }],
        ..page
    }
}

/// Returns all files below a folder, sorted.
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
