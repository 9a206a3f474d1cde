//! Bakes the occlusion interval maps of a shot's lights.
//!
//! ```sh
//! cargo run --release --features reference --example bake -- SHOT.json
//! cargo run --release --example render -- SHOT.json --out DIR
//! ```
//!
//! Every light with the technique `occlusion_interval` names the folder of its maps, relative to the shot. An interrupted
//! bake is resumed. Maps that are there already and fit the scene are left alone. Lights that want different maps in one folder
//! are an error, and nothing is baked. Any error is one line on stderr that names the file and the element. The exit status is
//! then 1.

use antumbra_stage as support;

use std::path::{Component, Path, PathBuf};
use std::process::ExitCode;

use antumbra::baking::{Bake, BakeSettings, bake_into};
use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use clap::Parser;
use indicatif::{ProgressBar, ProgressStyle};
use support::shot::Shot;
use support::stage::{Stage, one_line};

/// Bakes the occlusion interval maps of a shot's lights.
#[derive(Parser)]
struct Arguments {
    /// The shot file.
    shot: PathBuf,
    /// Most texels along each side of a page.
    #[arg(long, default_value_t = 2048)]
    page_size: u32,
    /// Bakes the front faces alone of materials that are not double-sided, as `render --cull-back-faces` shows them.
    #[arg(long)]
    cull_back_faces: bool,
}

fn main() -> ExitCode {
    match bake(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            eprintln!("{}", line.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn bake(arguments: &Arguments) -> Result<(), String> {
    let file = arguments.shot.display();
    let shot = Shot::load(&arguments.shot, Techniques::default())?;
    let mut stage = Stage::of_shot(&shot)?;
    stage.world.insert_resource(if arguments.cull_back_faces {
        FaceCulling::SingleSided
    } else {
        FaceCulling::None
    });
    stage.run();
    let asked = asked_of_lights(&stage, &file.to_string())?;
    for Asked {
        index, folder, maps, ..
    } in &asked
    {
        let what = format!("{file}: lights[{index}]");
        let bake = bake_light(arguments, &mut stage, *index, (folder, maps))
            .map_err(|error| format!("{what}: {error}"))?;
        say(&what, folder, &bake);
    }
    if asked.is_empty() {
        return Err(format!("{file}: no light has the technique occlusion_interval"));
    }
    Ok(())
}

/// Path of a light, texels per metre, and the mask of what casts for it.
type Maps = (LightPath, f32, u32);

/// The maps that a light asks for.
struct Asked {
    /// Index of the light in the shot.
    index: usize,
    /// The folder as the shot names it.
    folder: PathBuf,
    /// The one name of the folder.
    place: PathBuf,
    maps: Maps,
}

/// Lists the maps that the lights of a shot ask for, each folder once. Lights that ask for other maps in the same folder are
/// an error, which is found before anything is baked.
fn asked_of_lights(stage: &Stage, file: &str) -> Result<Vec<Asked>, String> {
    let mut all: Vec<Asked> = Vec::new();
    for (index, &light) in stage.lights.iter().enumerate() {
        let (Some(settings), Some(path)) = (
            stage.world.get::<OcclusionInterval>(light),
            stage.world.get::<LightPath>(light),
        ) else {
            continue;
        };
        let selection = stage.world.get::<LightSelection>(light).copied();
        let maps = (
            path.clone(),
            settings.texels_per_metre,
            selection.unwrap_or_default().casts_for,
        );
        let folder = PathBuf::from(&settings.maps);
        let place = place_of(&folder);
        match all.iter().find(|other| other.place == place) {
            Some(other) if other.maps == maps => {} // both lights share the maps
            Some(other) => {
                return Err(format!(
                    "{file}: lights[{index}].shadow.maps: {} is the folder of lights[{}], which has another path, density or casters",
                    folder.display(),
                    other.index
                ));
            }
            None => all.push(Asked {
                index,
                folder,
                place,
                maps,
            }),
        }
    }
    Ok(all)
}

/// Returns the one name of a folder that need not exist: `maps` and `./maps` are the same, and links are followed.
fn place_of(folder: &Path) -> PathBuf {
    let whole = std::path::absolute(folder).unwrap_or_else(|_| folder.to_owned());
    whole.components().fold(PathBuf::new(), |mut place, part| {
        if part == Component::ParentDir {
            place.pop();
        } else {
            place.push(part);
        }
        place.canonicalize().unwrap_or(place)
    })
}

fn bake_light(
    arguments: &Arguments,
    stage: &mut Stage,
    index: usize,
    (folder, (path, texels_per_metre, casts_for)): (&Path, &Maps),
) -> Result<Bake, String> {
    let bake_settings = BakeSettings {
        texels_per_metre: *texels_per_metre,
        page_size: arguments.page_size,
        casts_for: *casts_for,
        ..Default::default()
    };
    let bar = ProgressBar::no_length();
    let template = format!("lights[{index}] {{wide_bar}} {{percent}} % of {{len}} texels, {{eta}} left");
    if let Ok(style) = ProgressStyle::with_template(&template) {
        bar.set_style(style);
    }
    let baked = bake_into(folder, &mut stage.world, path, &bake_settings, |progress| {
        bar.set_length(progress.all);
        bar.set_position(progress.done);
    });
    bar.finish_and_clear();
    baked.map_err(|error| one_line(&error))
}

/// Prints what was baked.
fn say(what: &str, folder: &Path, bake: &Bake) {
    for note in &bake.notes {
        eprintln!("{what}: {note}");
    }
    let (maps, statistics) = (&bake.maps, &bake.maps.statistics);
    println!(
        "{}: {} texels, {} pages of {size}×{size}, up to {} pairs, {:.1} bytes a texel",
        folder.display(),
        statistics.texels,
        maps.pages.len(),
        maps.pair_count(),
        maps.bytes() as f64 / statistics.texels.max(1) as f64,
        size = maps.size,
    );
    println!(
        "{} rays in {:.1} s, {:.2} million a second; at most {} intervals a texel",
        statistics.rays,
        statistics.seconds,
        statistics.rays as f64 / statistics.seconds.max(1e-9) / 1e6,
        statistics.most_intervals,
    );
}
