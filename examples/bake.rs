//! Bakes the occlusion interval maps of a shot's lights.
//!
//! ```sh
//! cargo run --release --features reference --example bake -- SHOT.json
//! cargo run --release --example render -- SHOT.json --out DIR
//! ```
//!
//! Every light with the technique `occlusion_interval` names the folder of its maps, relative to the shot. An interrupted
//! bake is resumed. Maps that are there already and fit the scene are left alone. Any error is
//! one line on stderr that names the file and the element. The exit status is then 1.

use antumbra_stage as support;

use std::path::{Path, PathBuf};
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
    let mut baked: Vec<Baked> = Vec::new();
    for index in 0..stage.lights.len() {
        let light = stage.lights[index];
        let (Some(settings), Some(path)) = (
            stage.world.get::<OcclusionInterval>(light).cloned(),
            stage.world.get::<LightPath>(light).cloned(),
        ) else {
            continue;
        };
        let selection = stage.world.get::<LightSelection>(light).copied();
        let folder = Path::new(&settings.maps);
        let asked = (
            path,
            settings.texels_per_metre,
            selection.unwrap_or_default().casts_for,
        );
        // `maps` and `./maps` are one folder; only a folder that exists has a canonical name.
        let is_same = |other: &&Baked| folder.canonicalize().is_ok_and(|folder| folder == other.folder);
        match baked.iter().find(is_same) {
            Some(other) if other.asked == asked => continue, // both lights share the maps
            Some(_) => {
                return Err(format!(
                    "{file}: lights[{index}].shadow.maps: {} is the folder of a light with another path, density or casters",
                    folder.display()
                ));
            }
            None => {}
        }
        let what = format!("{file}: lights[{index}]");
        let bake = bake_light(arguments, &mut stage, index, (folder, &asked))
            .map_err(|error| format!("{what}: {error}"))?;
        say(&what, folder, &bake);
        let folder = folder
            .canonicalize()
            .map_err(|error| format!("{what}: {}: {error}", folder.display()))?;
        baked.push(Baked { folder, asked });
    }
    if baked.is_empty() {
        return Err(format!("{file}: no light has the technique occlusion_interval"));
    }
    Ok(())
}

/// Path of a light, texels per metre, and the mask of what casts for it.
type Asked = (LightPath, f32, u32);

/// A folder whose maps are baked, and the light that they are for.
struct Baked {
    folder: PathBuf,
    asked: Asked,
}

fn bake_light(
    arguments: &Arguments,
    stage: &mut Stage,
    index: usize,
    (folder, (path, texels_per_metre, casts_for)): (&Path, &Asked),
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
