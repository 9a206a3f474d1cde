//! A gallery in which a technical artist compares shadow techniques. Each shot of a scene is a row of pictures, one for
//! each technique, with the ray-cast truth beside them, the error in numbers, and the cost of the shadows.
//!
//! ```sh
//! cargo run --example gallery --features reference -- --out DIR [--models FOLDER] [--size 320x180] [--only NAME]
//! ```
//!
//! Writes PNGs, one `index.html` and `results.json`. Any error is one line on stderr that names the file and the element;
//! the exit status is then 1.
//!
//! | file | subject |
//! | --- | --- |
//! | `page` | the description of a page, and its stage |
//! | `pages`, `soft_pages`, `model_pages` | the bundled pages, and those of a folder of models |
//! | `lantern` | the jack-o'-lantern, a hollow caster with holes, made in code |
//! | `way` | every technique of the list with its settings |
//! | `tasks` | the gallery as tasks of several threads |
//! | `judge`, `session` | pictures of every shot under every way, and their comparison with the ray caster |
//! | `truth` | ray-cast visibility, and the picture that it makes |
//! | `cost` | times of a light with and without its shadows, at rest and on the move |
//! | `panels` | visibility as pictures |
//! | `results`, `chooser` | what was measured, and the best way for each thing that a user may want |
//! | `html`, `web/` | the web page that shows them |
//! | `soft_table` | errors and costs of soft shadows, model by model |
//! | `soft_cost` | the time that tight wedges and culling save |
//! | `angles` | a plot of perspective maps beside cascades |
//! | `readme` | the pictures of the README |
//! | `uberlight` | one bust under the light model |
//! | `day` | twelve pictures of a day, from occlusion interval maps |

mod angles;
mod chooser;
mod cost;
mod day;
mod html;
mod judge;
mod lantern;
mod model_pages;
mod page;
mod pages;
mod panels;
mod readme;
mod results;
mod session;
mod soft_cost;
mod soft_pages;
mod soft_table;
mod tasks;
mod truth;
mod uberlight;
mod way;
use antumbra_stage as support;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use clap::Parser;
use glam::UVec2;
use indicatif::{ProgressBar, ProgressStyle};
use judge::Workbench;
use results::Judged;
use support::stage::one_line;
use tasks::{Done, Task};

/// Renders the gallery.
#[derive(Parser)]
struct Arguments {
    /// Folder for the pictures and index.html; created if missing.
    #[arg(long, required_unless_present_any = ["readme", "soft_table", "soft_cost"])]
    out: Option<PathBuf>,
    /// Folder of further models. Adds a page for each one that the gallery knows.
    #[arg(long)]
    models: Option<PathBuf>,
    /// Size of what is judged, pixels.
    #[arg(long, default_value = "320x180", value_parser = parse_size)]
    size: UVec2,
    /// Factor by which pictures are larger than that. They are drawn at one and a half times their size and averaged.
    #[arg(long, default_value_t = 2, value_parser = clap::value_parser!(u32).range(1..=8))]
    scale: u32,
    /// Number of threads that draw, each on a device of its own. While one of them measures times, the others wait.
    #[arg(long, default_value_t = 2, value_parser = parse_jobs)]
    jobs: usize,
    /// Renders only pages whose name contains one of these, separated by commas.
    #[arg(long)]
    only: Option<String>,
    /// Renders the pictures of the README into assets/readme instead; with `--only techniques` those of the techniques alone.
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
    /// Writes the plot of perspective maps and cascades, for the light's angle to the view, to `--out` instead. `--models`
    /// adds a dungeon and a town. An index that is written there later links to it.
    #[arg(long, requires = "out")]
    angles: bool,
}

impl Arguments {
    /// Whether something else than the gallery is asked for.
    fn is_another(&self) -> bool {
        self.readme || self.soft_table || self.soft_cost || self.angles
    }
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
    match &arguments.out {
        Some(out) if !arguments.is_another() => gallery(arguments, &assets, out),
        _ => another(arguments, &assets),
    }
}

/// Renders and judges all pages that are chosen.
fn gallery(arguments: &Arguments, assets: &Path, out: &Path) -> Result<(), String> {
    let mut pages = pages::bundled(&assets.join("models"));
    if let Some(folder) = &arguments.models {
        pages.extend(model_pages::of_folder(folder)?);
    }
    let names: Vec<&str> = pages
        .iter()
        .map(|page| page.name)
        .chain([uberlight::NAME, day::NAME])
        .collect();
    let is_chosen = |name: &str| {
        let only = arguments.only.as_deref().unwrap_or_default();
        only.split(',').any(|part| name.contains(part))
    };
    if let (false, Some(only)) = (names.iter().any(|name| is_chosen(name)), &arguments.only) {
        return Err(format!("--only {only}: there are {}", names.join(", ")));
    }
    pages.retain(|page| is_chosen(page.name));
    let mut tasks: Vec<Task> = pages.iter().map(Task::Page).collect();
    if is_chosen(uberlight::NAME) {
        tasks.push(Task::Uberlight(assets.join("../examples/shots/uberlight")));
    }
    if is_chosen(day::NAME) {
        tasks.push(Task::Day);
    }
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let begin = Instant::now();
    let steps: u64 = pages
        .iter()
        .map(|page| (page.shots.len() * page.ways.len()) as u64)
        .sum();
    let bar = progress_bar(steps)?;
    let shown = bar.clone();
    let progress = move |name: &str| {
        shown.set_message(name.to_owned());
        shown.inc(1);
    };
    let jobs = arguments.jobs.min(tasks.len());
    let benches = Workbench::several(jobs, arguments.size, arguments.scale, progress)?;
    let adapter = &benches[0].context.adapter;
    bar.suspend(|| {
        println!(
            "{} scenes, {steps} pictures with their errors and costs, on {adapter}",
            pages.len()
        );
    });
    let finished = |task: &Task, done: &Done| {
        if let (Task::Page(page), Done::Page(result)) = (task, done) {
            bar.suspend(|| println!("{:<14} {:>6.1} s", page.name, result.seconds));
        }
    };
    let done = tasks::run(&tasks, &benches, out, finished)?;
    bar.finish_and_clear();
    let (mut results, mut looks) = (Vec::<Judged>::new(), Vec::new());
    for (task, done) in tasks.iter().zip(done) {
        match (task, done) {
            (Task::Page(page), Done::Page(result)) => results.push((page, result)),
            (_, Done::Look(look)) => looks.push(look),
            _ => {}
        }
    }
    let index = html::write(out, &results, looks, &benches[0], begin.elapsed().as_secs_f64())?;
    println!("{}", results::verdict(&results));
    println!("{}", index.display());
    Ok(())
}

/// Writes or prints what is asked for instead of the gallery.
fn another(arguments: &Arguments, assets: &Path) -> Result<(), String> {
    let mut bench = Workbench::several(1, arguments.size, arguments.scale, |_| {})?.remove(0);
    if let (true, Some(folder)) = (arguments.soft_table, &arguments.models) {
        let choice = soft_table::Choice {
            only: arguments.only.as_deref(),
            ways: arguments.ways.as_deref(),
        };
        return soft_table::print(&bench.context, folder, arguments.size, &choice);
    }
    if arguments.soft_cost {
        return soft_cost::print(&bench.context, assets, arguments.size);
    }
    if let (true, Some(out)) = (arguments.angles, &arguments.out) {
        return angles::write(&bench.context, arguments.models.as_deref(), out);
    }
    let all = arguments.only.as_deref() != Some("techniques");
    readme::write(&mut bench, assets, all)
}

/// Makes a bar that shows itself on a terminal only.
fn progress_bar(steps: u64) -> Result<ProgressBar, String> {
    let style = ProgressStyle::with_template("{wide_bar} {pos}/{len}, {eta} left\n{msg}")
        .map_err(|error| one_line(&error))?;
    let bar = ProgressBar::new(steps).with_style(style);
    bar.enable_steady_tick(Duration::from_millis(250));
    Ok(bar)
}

fn parse_jobs(text: &str) -> Result<usize, String> {
    let jobs = text.parse().ok().filter(|jobs| (1..=16).contains(jobs));
    jobs.ok_or_else(|| "a number from 1 to 16 is needed".to_owned())
}

fn parse_size(text: &str) -> Result<UVec2, String> {
    let parts = text.split_once('x').and_then(|(width, height)| {
        let size = UVec2::new(width.parse().ok()?, height.parse().ok()?);
        (size.min_element() > 0 && size.max_element() <= 8192).then_some(size)
    });
    parts.ok_or_else(|| "a size such as 320x180 is needed, each side 1..=8192".to_owned())
}
