//! `index.html`: one file beside its pictures, without anything from elsewhere.

use std::fmt::Write;

use antumbra::schedule::AntumbraSystems;
use glam::UVec2;
use serde_json::Value;

use super::cost::RUNS;
use super::judge::{Judgement, PageResult, ShotResult, Workbench, verdict};
use super::page::{Page, PageShot};
use super::panels::TITLES;

/// The whole text. `more` are further pages in the same folder: file and title.
pub fn index(
    results: &[(&Page, PageResult)],
    more: &[(&str, &str)],
    bench: &Workbench,
    seconds: f64,
) -> String {
    let mut html = String::new();
    // Writing to a string does not fail.
    let _ = write_index(&mut html, results, more, bench, seconds);
    html
}

fn write_index(
    html: &mut String,
    results: &[(&Page, PageResult)],
    more: &[(&str, &str)],
    bench: &Workbench,
    seconds: f64,
) -> std::fmt::Result {
    let adapter = &bench.context.adapter;
    let is_software = ["llvmpipe", "swiftshader", "software", "cpu"]
        .iter()
        .any(|name| adapter.to_lowercase().contains(name));
    let software = if is_software {
        " This is a software renderer: GPU times are those of CPU cores, good for ratios within a run only."
    } else {
        ""
    };
    write!(
        html,
        "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\
         <title>antumbra gallery</title><style>\n{}</style></head><body>\n\
         <h1>Shadows beside the truth</h1>\n\
         <p>Every shot is rendered, and every light of it judged against a ray caster on \
         the CPU, which reads the same scene and shares nothing else with the renderer: one ray from each pixel’s surface \
         to the light.</p>\n\
         <p class=\"verdict\">{}</p>\n",
        include_str!("gallery.css"),
        escaped(&verdict(results)),
    )?;
    html.push_str("<nav>");
    for (page, _) in results {
        write!(html, "<a href=\"#{}\">{}</a>", page.name, escaped(page.title))?;
    }
    for (file, title) in more {
        write!(html, "<a href=\"{file}\">{}</a>", escaped(title))?;
    }
    html.push_str("</nav>\n");
    summary(html, results)?;
    write!(
        html,
        "<p class=\"quiet\">Judged: pixels that face the light within its reach and lie off a band of one pixel \
         around the truth’s edges, where one ray cannot tell. Wrong: off by more than ½. Cost: GPU time of the \
         light’s pass with shadows over that of the same light without, other lights off, median of {RUNS} frames \
         each in this run. Surfaces are seen from both sides, as they block light from both.</p>\n\
         <p class=\"quiet\">Adapter: {}.{software} Pictures of {}×{} pixels; all of it took {seconds:.0} s.</p>\n\
         <ul class=\"legend\"><li><i style=\"background:#2c3240\"></i>does not count: faces away, out of reach, or \
         nothing is there</li><li><i style=\"background:#00ff00\"></i>right, lit</li><li><i \
         style=\"background:#008000\"></i>right, in shadow</li><li><i style=\"background:#ffff00\"></i>off by \
         ½</li><li><i style=\"background:#ff0000\"></i>wrong</li><li><i style=\"background:#4cb24c\"></i>pale: \
         within a pixel of an edge, not judged</li><li><i style=\"background:#606060\"></i>grey in the difference: \
         does not count</li></ul>\n\
         <ul class=\"legend\"><li><i style=\"background:#2f9fe0\"></i>blue, green: volume counted by \
         depth-pass</li><li><i style=\"background:#ef8a2f\"></i>orange, magenta: by depth-fail</li></ul>\n",
        escaped(adapter),
        bench.size.x,
        bench.size.y,
    )?;
    for (page, result) in results {
        section(html, page, result)?;
    }
    write!(
        html,
        "<dialog><div><img alt=\"\"><p></p></div></dialog>\n<script>\n{}</script>\n</body></html>\n",
        include_str!("gallery.js")
    )
}

fn summary(html: &mut String, results: &[(&Page, PageResult)]) -> std::fmt::Result {
    html.push_str(
        "<div class=\"scroll\"><table><tr><th>page<th>shot<th>technique<th>light<th class=\"n\">judged \
         pixels<th class=\"n\">wrong<th class=\"n\">share<th class=\"n\">with all lights<th class=\"n\">cost</tr>\n",
    );
    for (page, result) in results {
        for (shot, judged) in page.shots.iter().zip(&result.shots) {
            let (name, error) = &judged.lights[judged.light];
            let (inner, wrong) =
                error.map_or((0, 0), |Judgement { error, .. }| (error.inner, error.wrong_inner));
            let all = judged
                .lights
                .iter()
                .filter_map(|(_, judgement)| Some((*judgement)?.error));
            let (all_inner, all_wrong) = all.fold((0, 0), |(inner, wrong), error| {
                (inner + error.inner, wrong + error.wrong_inner)
            });
            writeln!(
                html,
                "<tr><td><a href=\"#{0}\">{0}</a><td>{1}<td>{7}<td>{2}<td class=\"n\">{inner}<td \
                 class=\"n\">{3}<td class=\"n\">{4}<td class=\"n\">{5} of {all_inner}<td class=\"n\">{6}</tr>",
                page.name,
                shot.name,
                escaped(name),
                wrong_count(wrong),
                share(error.and_then(|judgement| judgement.error.share())),
                wrong_count(all_wrong),
                judged
                    .cost
                    .ratio()
                    .map_or_else(|| "–".to_owned(), |ratio| format!("{ratio:.2}×")),
                page.technique_names(),
            )?;
        }
    }
    html.push_str("</table></div>\n");
    Ok(())
}

fn section(html: &mut String, page: &Page, result: &PageResult) -> std::fmt::Result {
    write!(
        html,
        "<h2 id=\"{}\">{}</h2>\n<p>{}</p>\n",
        page.name,
        escaped(page.title),
        escaped(page.about)
    )?;
    if result.made_solid > 0 {
        html.push_str(
            "<p class=\"quiet\">Alpha-tested surfaces are solid in the judged panels, in the rendered picture and in \
             the truth.</p>\n",
        );
    }
    for (shot, judged) in page.shots.iter().zip(&result.shots) {
        row(html, page, shot, judged)?;
        figures(html, judged, result.triangle_count)?;
    }
    Ok(())
}

fn row(html: &mut String, page: &Page, shot: &PageShot, judged: &ShotResult) -> std::fmt::Result {
    write!(
        html,
        "<h3>{} <small>{}</small></h3>\n<div class=\"row\">",
        escaped(shot.name),
        escaped(shot.caption)
    )?;
    for (index, (title, file)) in TITLES.iter().zip(&judged.files).enumerate() {
        let of_light = if index == 0 {
            String::new()
        } else {
            format!(" of {}", judged.lights[judged.light].0)
        };
        write!(
            html,
            "<figure><a href=\"{file}\"><img src=\"{file}\" loading=\"lazy\" alt=\"{0}, {1}: {2}{3}\"></a>\
             <figcaption>{2}{3}</figcaption></figure>",
            page.name,
            shot.name,
            title,
            escaped(&of_light)
        )?;
    }
    html.push_str("</div>\n");
    Ok(())
}

fn figures(html: &mut String, judged: &ShotResult, triangle_count: usize) -> std::fmt::Result {
    let stats = &judged.stats;
    html.push_str(
        "<div class=\"figures\"><div class=\"scroll\"><table><tr><th>light<th class=\"n\">wrong off band / \
         all<th class=\"n\">judged<th class=\"n\">|L|<th class=\"n\">|I|<th class=\"n\">|S|<th class=\"n\">depth-pass<th \
         class=\"n\">depth-fail<th class=\"n\">edges<th class=\"n\">batches<th class=\"n\">GPU ms</tr>\n",
    );
    let mut active = 0;
    for (index, (name, error)) in judged.lights.iter().enumerate() {
        let light = &stats["lights"][index];
        let chosen = if index == judged.light {
            " class=\"chosen\""
        } else {
            ""
        };
        let Some(Judgement { error, first_wrong }) = error else {
            writeln!(
                html,
                "<tr><td>{}<td colspan=\"10\">{}</tr>",
                escaped(name),
                light["skipped"]
            )?;
            continue;
        };
        let gpu_ms = stats["gpu_ms"][format!("light {active}")].as_f64();
        active += 1;
        writeln!(
            html,
            "<tr{chosen}><td>{}<td class=\"n\">{} / {}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td \
             class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{} + {}<td \
             class=\"n\">{}</tr>",
            escaped(name),
            wrong_at(error.wrong_inner, *first_wrong),
            error.wrong_all,
            error.inner,
            light["L"],
            light["I"],
            light["S"],
            light["casters_depth_pass"],
            light["casters_depth_fail"],
            light["silhouette_edges"],
            light["shadow_batches"],
            light["light_batches"],
            milliseconds(gpu_ms),
        )?;
    }
    let cost = &judged.cost;
    write!(
        html,
        "</table></div>\n<dl><dt>|F|, |V|<dd>{} and {} of {} objects, {triangle_count} triangles\
         <dt>batches<dd>{} a frame<dt>chosen light<dd>{} ms GPU, {} ms without shadows",
        stats["F"],
        stats["V"],
        stats["objects"],
        stats["batches"]["frame"],
        milliseconds(cost.shadowed_ms),
        milliseconds(cost.unshadowed_ms),
    )?;
    cpu(html, &stats["cpu_ms"], &cost.cpu_ms)?;
    html.push_str("</dl></div>\n");
    Ok(())
}

/// CPU times of the first frame, and of one in which nothing moves.
fn cpu(html: &mut String, first: &Value, steady: &[f64]) -> std::fmt::Result {
    for (set, steady) in AntumbraSystems::ALL.iter().zip(steady) {
        write!(
            html,
            "<dt>CPU {}<dd>{} ms first, {steady:.3} ms steady",
            set.name().replace('_', " "),
            milliseconds(first[set.name()].as_f64()),
        )?;
    }
    Ok(())
}

fn milliseconds(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{value:.2}"))
}

fn share(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |value| format!("{:.4} %", value * 100.0))
}

fn wrong_count(count: usize) -> String {
    let class = if count == 0 { "zero" } else { "some" };
    format!("<span class=\"{class}\">{count}</span>")
}

/// The count, and where the first of them is.
fn wrong_at(count: usize, first: Option<UVec2>) -> String {
    let at = first.map_or_else(String::new, |at| format!(" (at {},{})", at.x, at.y));
    format!("{}{at}", wrong_count(count))
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}
