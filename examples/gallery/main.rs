//! A gallery in which a technical artist compares shadow techniques. Each page is a scene. Each shot is a row of
//! pictures with the ray-cast truth beside them, the error in numbers, and the cost of the shadows.
//!
//! ```sh
//! cargo run --example gallery --features reference -- --out DIR [--models FOLDER] [--size 320x180] [--only NAME]
//! ```
//!
//! Writes PNGs and one `index.html`. Any error is one line on stderr that names the file and the element; the exit
//! status is then 1.
//!
//! | file | subject |
//! | --- | --- |
//! | `page` | the description of a page, and its stage |
//! | `pages`, `model_pages` | the bundled pages, and those of a folder of models |
//! | `lantern` | the jack-o'-lantern, a hollow caster with holes, made in code |
//! | `judge` | a shot's pictures, and the comparison of its lights with the ray caster |
//! | `cost` | times of a light with and without its shadows |
//! | `panels` | visibility as pictures |
//! | `html`, `gallery.css`, `gallery.js` | the web page that shows them |
//! | `soft_pages` | soft shadows side by side, after the figures of their paper |
//! | `soft_table` | errors and costs of soft shadows, model by model |
//! | `soft_cost` | the time that tight wedges and culling save |
//! | `angles` | a plot of perspective maps beside cascades |
//! | `readme` | the pictures of the README |
//! | `uberlight` | one bust under the light model |

mod angles;
mod cost;
mod html;
mod judge;
mod lantern;
mod model_pages;
mod page;
mod pages;
mod panels;
mod readme;
mod soft_cost;
mod soft_pages;
mod soft_table;
mod uberlight;
use antumbra_stage as support;

use std::path::PathBuf;
use std::process::ExitCode;
use std::time::Instant;

use antumbra::prelude::*;
use clap::Parser;
use glam::UVec2;
use judge::{PageResult, Workbench};
use page::Page;
use support::stage::one_line;

/// Renders the gallery.
#[derive(Parser)]
struct Arguments {
    /// Folder for the pictures and index.html; created if missing.
    #[arg(long, required_unless_present_any = ["readme", "soft_table", "soft_cost"])]
    out: Option<PathBuf>,
    /// Folder of further models. Adds a page for each one that the gallery knows.
    #[arg(long)]
    models: Option<PathBuf>,
    /// Size of the pictures, pixels.
    #[arg(long, default_value = "320x180", value_parser = parse_size)]
    size: UVec2,
    /// Renders only pages whose name contains this.
    #[arg(long)]
    only: Option<String>,
    /// Renders the pictures of the README into assets/readme instead.
    #[arg(long)]
    readme: bool,
    /// Prints the errors and costs of soft shadows on every model of `--models` instead; `--only` selects by a part
    /// of the path.
    #[arg(long, requires = "models")]
    soft_table: bool,
    /// Names of the columns of `--soft-table`, such as "wedges,2x2,hard 64". Default: all.
    #[arg(long, requires = "soft_table")]
    ways: Option<String>,
    /// Prints the time that tight wedges and culling save instead.
    #[arg(long)]
    soft_cost: bool,
    /// Writes the page of soft shadows to `--out` instead. An index that is written there later links to it.
    #[arg(long, requires = "out")]
    soft: bool,
    /// Writes the plot of perspective maps and cascades, for the light's angle to the view, to `--out` instead. `--models`
    /// adds a dungeon and a town. An index that is written there later links to it.
    #[arg(long, requires = "out")]
    angles: bool,
    /// Writes the page of the light model to `--out` instead. An index that is written there later links to it.
    #[arg(long, requires = "out")]
    uberlight: bool,
}

fn main() -> ExitCode {
    match run(&Arguments::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(line) => {
            eprintln!("{}", line.replace('\n', " "));
            ExitCode::FAILURE
        }
    }
}

fn run(arguments: &Arguments) -> Result<(), String> {
    let assets = page::assets_folder()?;
    let requested = RequestedFeatures {
        timestamps: true,
        ..Default::default()
    };
    let context = pollster::block_on(RenderContext::headless(requested)).map_err(|error| one_line(&error))?;
    let mut bench = Workbench {
        context,
        size: arguments.size,
    };
    if let (true, Some(folder)) = (arguments.soft_table, &arguments.models) {
        let choice = soft_table::Choice {
            only: arguments.only.as_deref(),
            ways: arguments.ways.as_deref(),
        };
        return soft_table::print(&bench.context, folder, arguments.size, &choice);
    }
    if arguments.soft_cost {
        return soft_cost::print(&bench.context, &assets, arguments.size);
    }
    if let (true, Some(out)) = (arguments.soft, &arguments.out) {
        return soft_pages::write(&bench.context, &assets, arguments.size, out);
    }
    if let (true, Some(out)) = (arguments.angles, &arguments.out) {
        return angles::write(&bench.context, arguments.models.as_deref(), out);
    }
    if let (true, Some(out)) = (arguments.uberlight, &arguments.out) {
        let shots = assets.join("../examples/shots/uberlight");
        return uberlight::write(&bench.context, &shots, arguments.size.y * 2, out);
    }
    if arguments.readme {
        return readme::write(&mut bench, &assets);
    }
    let out = arguments.out.as_ref().ok_or("--out is needed")?;
    let mut pages = pages::bundled(&assets.join("models"));
    if let Some(folder) = &arguments.models {
        pages.extend(model_pages::of_folder(folder)?);
    }
    if let Some(only) = &arguments.only {
        let names: Vec<&str> = pages.iter().map(|page| page.name).collect();
        let names = names.join(", ");
        pages.retain(|page| page.name.contains(only.as_str()));
        if pages.is_empty() {
            return Err(format!("--only {only}: there are {names}"));
        }
    }
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let begin = Instant::now();
    let mut results: Vec<(&Page, PageResult)> = Vec::new();
    for page in &pages {
        let result = bench.judge_page(page, out)?;
        println!("{:<14} {:>6.1} s", page.name, result.seconds);
        results.push((page, result));
    }
    let seconds = begin.elapsed().as_secs_f64();
    let index = out.join("index.html");
    // Calls with `--soft`, `--angles` and `--uberlight` draw these pages.
    let mut more = vec![
        (soft_pages::FILE, "Soft shadows"),
        (angles::FILE, "Perspective maps and the light's angle"),
        (uberlight::FILE, "The cinematographer's light"),
    ];
    more.retain(|(file, _)| out.join(file).is_file());
    let text = html::index(&results, &more, &bench, seconds);
    std::fs::write(&index, text).map_err(|error| format!("{}: {error}", index.display()))?;
    println!("{}", index.display());
    println!("{}", judge::verdict(&results));
    Ok(())
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    let parts = text.split_once('x').and_then(|(width, height)| {
        let size = UVec2::new(width.parse().ok()?, height.parse().ok()?);
        (size.min_element() > 0 && size.max_element() <= 8192).then_some(size)
    });
    parts.ok_or_else(|| "a size such as 320x180 is needed, each side 1..=8192".to_owned())
}
