//! A plot of perspective maps beside uniform maps and cascades: texels near the eye and error, for the light's angle to the
//! view.

use std::fmt::Write;
use std::path::Path;

use antumbra::prelude::*;

use super::support::stage::one_line;
use super::support::texels::{Judged, Row, maps, model_view, plain};

/// Name of the plot.
pub const FILE: &str = "angles.svg";

/// Title of the plot.
pub const TITLE: &str =
    "Perspective maps, uniform maps and cascades of as many texels, for the light's angle to the view";

/// Models of the plot besides the plain, which are drawn if the folder of models has them.
const MODELS: [&str; 2] = ["dungeon_A.glb", "town_A.glb"];

/// Colours of the maps, in the order of [`maps`].
const COLORS: [&str; 5] = ["#c2410c", "#d97706", "#64748b", "#1d4ed8", "#0891b2"];

/// Size of a panel, and space around it, for labels.
const PANEL: [f64; 2] = [300.0, 190.0];
const SPACE: [f64; 2] = [64.0, 54.0];

/// Width of an entry of the legend.
const LEGEND: f64 = 120.0;

/// A quantity that is plotted on a logarithmic axis.
struct Quantity {
    name: &'static str,
    /// Powers of ten between which the axis runs.
    decades: [i32; 2],
    of: fn(&Row, usize) -> f64,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        name: "texels per pixel, nearest tenth",
        decades: [-4, 4],
        of: |row, map| row.maps[map].0.near,
    },
    Quantity {
        name: "RMSE to ray-cast truth",
        decades: [-3, 0],
        of: |row, map| row.maps[map].1,
    },
];

/// Measures the scenes, and writes the plot to a folder.
///
/// # Errors
/// One line that names the file.
pub fn write(context: &RenderContext, models: Option<&Path>, out: &Path) -> Result<(), String> {
    let mut stage = plain();
    stage
        .add_renderer(context.clone(), RenderSettings::default())
        .map_err(|error| one_line(&error))?;
    let mut scenes = vec![("a plain of 4 km", Judged::new(stage)?.rows(true)?)];
    for name in MODELS {
        let found = models.and_then(|folder| find(folder, name));
        if let Some(path) = found {
            let stage = model_view(&path, context)?;
            scenes.push((name, Judged::new(stage)?.rows(true)?));
        }
    }
    std::fs::create_dir_all(out).map_err(|error| format!("{}: {error}", out.display()))?;
    let file = out.join(FILE);
    std::fs::write(&file, plot(&scenes)).map_err(|error| format!("{}: {error}", file.display()))?;
    println!("{}", file.display());
    Ok(())
}

/// Finds a file below a folder by its name.
fn find(folder: &Path, name: &str) -> Option<std::path::PathBuf> {
    let mut entries: Vec<_> = std::fs::read_dir(folder)
        .ok()?
        .flatten()
        .map(|entry| entry.path())
        .collect();
    entries.sort();
    entries.iter().find_map(|path| {
        if path.is_dir() {
            return find(path, name);
        }
        path.ends_with(name).then(|| path.clone())
    })
}

/// Draws the measured rows of each scene: a column of panels for each scene, a row for each quantity.
fn plot(scenes: &[(&str, Vec<Row>)]) -> String {
    let [width, height] = [0, 1].map(|axis: usize| PANEL[axis] + SPACE[axis]);
    let size = [
        (width * scenes.len() as f64 + 30.0).max(SPACE[0] + LEGEND * COLORS.len() as f64),
        height * QUANTITIES.len() as f64 + 50.0,
    ];
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {:.0} {:.0}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <title>Perspective maps, uniform maps and cascades of as many texels, for the light's angle to the view</title>\n\
         <rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n",
        size[0], size[1]
    );
    for (column, (name, rows)) in scenes.iter().enumerate() {
        for (line, quantity) in QUANTITIES.iter().enumerate() {
            let corner = [SPACE[0] + width * column as f64, 30.0 + height * line as f64];
            panel(&mut svg, corner, name, quantity, rows);
        }
    }
    let bottom = size[1] - 14.0;
    for (index, ((name, _), color)) in maps().iter().zip(COLORS).enumerate() {
        let x = SPACE[0] + LEGEND * index as f64;
        let _ = writeln!(
            svg,
            "<rect x=\"{x:.0}\" y=\"{:.0}\" width=\"18\" height=\"4\" fill=\"{color}\"/>\
             <text x=\"{:.0}\" y=\"{bottom:.0}\">{name}</text>",
            bottom - 6.0,
            x + 24.0
        );
    }
    svg.push_str("</svg>\n");
    svg
}

fn panel(svg: &mut String, [left, top]: [f64; 2], name: &str, quantity: &Quantity, rows: &[Row]) {
    let [low, high] = quantity.decades;
    let across = |angle: f64| left + angle / 180.0 * PANEL[0];
    let up = |value: f64| {
        let share = (value.max(1e-12).log10() - f64::from(low)) / f64::from(high - low);
        top + PANEL[1] * (1.0 - share.clamp(0.0, 1.0))
    };
    let _ = writeln!(
        svg,
        "<text x=\"{left:.0}\" y=\"{:.0}\" font-weight=\"bold\">{name}: {}</text>",
        top - 8.0,
        quantity.name
    );
    for decade in low..=high {
        let y = up(10f64.powi(decade));
        let _ = writeln!(
            svg,
            "<path d=\"M{left:.1} {y:.1}h{:.1}\" stroke=\"#ddd\"/>\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
            PANEL[0],
            left - 6.0,
            y + 4.0,
            10f64.powi(decade)
        );
    }
    for angle in (0..=180).step_by(45) {
        let x = across(f64::from(angle));
        let _ = writeln!(
            svg,
            "<path d=\"M{x:.1} {top:.1}v{:.1}\" stroke=\"#eee\"/>\
             <text x=\"{x:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{angle}°</text>",
            PANEL[1],
            top + PANEL[1] + 16.0
        );
    }
    for (map, color) in COLORS.iter().enumerate() {
        let mut line = String::new();
        // Where hardly anything faces the light, nothing is measured.
        for row in rows.iter().filter(|row| row.maps[0].0.pixels >= 50) {
            let (x, y) = (across(f64::from(row.angle)), up((quantity.of)(row, map)));
            let _ = write!(line, "{x:.1},{y:.1} ");
        }
        let _ = writeln!(
            svg,
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>",
            line.trim_end()
        );
    }
}
