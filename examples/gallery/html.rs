//! Writes `index.html`, a page that needs only the pictures beside it, and `results.json`.

use std::path::{Path, PathBuf};

use antumbra::techniques::Techniques;
use serde_json::{Value, json};

use super::angles;
use super::chooser;
use super::cost::RUNS;
use super::judge::Workbench;
use super::results::{self, Judged, verdict};
use super::truth::SAMPLES;

/// The page, with places for its style, its script and its data.
const PAGE: &str = include_str!("web/page.html");
const STYLE: [&str; 2] = [include_str!("web/page.css"), include_str!("web/viewer.css")];
const SCRIPT: [&str; 4] = [
    include_str!("web/text.js"),
    include_str!("web/scenes.js"),
    include_str!("web/chooser.js"),
    include_str!("web/viewer.js"),
];

/// Writes `results.json` and `index.html`. `looks` are scenes that are shown after those that were judged. Returns the path
/// of `index.html`.
///
/// # Errors
/// One line that names the file.
pub fn write(
    out: &Path,
    results: &[Judged],
    looks: Vec<Value>,
    bench: &Workbench,
    seconds: f64,
) -> Result<PathBuf, String> {
    let mut all = results::json(results, &Techniques::default());
    let adapter = &bench.context.adapter;
    let is_software = ["llvmpipe", "swiftshader", "software", "cpu"]
        .iter()
        .any(|name| adapter.to_lowercase().contains(name));
    all["adapter"] = json!(adapter);
    all["software"] = json!(is_software);
    all["size"] = json!(bench.size.to_array());
    all["scale"] = json!(bench.scale);
    all["runs"] = json!(RUNS);
    all["samples"] = json!(SAMPLES);
    all["seconds"] = json!(seconds);
    all["verdict"] = json!(verdict(results));
    if let Some(scenes) = all["scenes"].as_array_mut() {
        scenes.extend(looks);
    }
    all["more"] = plot(out);
    all["chooser"] = chooser::json(results);
    let save = |name: &str, text: &str| {
        let path = out.join(name);
        std::fs::write(&path, text).map_err(|error| format!("{}: {error}", path.display()))?;
        Ok::<_, String>(path)
    };
    save("results.json", &format!("{all:#}"))?;
    without_statistics(&mut all);
    save("index.html", &page(&all))
}

/// Returns the text of the page that shows some results.
pub fn page(results: &Value) -> String {
    // In a script element, `<` is the only character that could end it.
    let data = results.to_string().replace('<', "\\u003c");
    PAGE.replace("/* style */", &STYLE.concat())
        .replace("/* script */", &SCRIPT.concat())
        .replace("/* results */", &data)
}

/// Returns the plot that `--angles` writes into the folder, if it is there, with its title.
fn plot(out: &Path) -> Value {
    let plot = json!({"file": angles::FILE, "title": angles::TITLE});
    Value::Array(Vec::from_iter(out.join(angles::FILE).exists().then_some(plot)))
}

/// Removes the statistics of frames, which are many and which the page does not show.
fn without_statistics(value: &mut Value) {
    match value {
        Value::Object(members) => {
            members.remove("stats");
            members.values_mut().for_each(without_statistics);
        }
        Value::Array(values) => values.iter_mut().for_each(without_statistics),
        _ => {}
    }
}
