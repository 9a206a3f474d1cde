//! What the gallery has measured, and its JSON: `results.json` and the data of the web page.

use antumbra::reference::{HardError, SoftError};
use antumbra::techniques::Techniques;
use glam::UVec2;
use serde_json::{Value, json};

use super::cost::Cost;
use super::page::{Page, PageShot};
use super::way::{light_kinds, refusal};

/// Results of a page.
pub struct PageResult {
    /// Wall-clock time, seconds.
    pub seconds: f64,
    /// Number of triangles of the scene.
    pub triangle_count: usize,
    /// Number of objects with alpha-tested surfaces. What is judged treats them as solid.
    pub made_solid: usize,
    /// Results of each shot.
    pub shots: Vec<ShotResult>,
}

/// Results of a shot.
pub struct ShotResult {
    /// Index of the light that is judged first, and whose visibility is shown.
    pub light: usize,
    /// Whether that light has a size, so that its shadows are soft.
    pub is_soft: bool,
    /// File of the picture with ray-cast visibility; `None` where no picture can be made of it.
    pub truth_picture: Option<String>,
    /// File of the ray-cast visibility of the light.
    pub truth_visibility: String,
    /// Result of each way to shadow the lights, in the page's order: a sentence on why the light cannot be shadowed so,
    /// or what was measured.
    pub ways: Vec<Result<WayResult, String>>,
}

/// What was measured of one way to shadow the lights.
pub struct WayResult {
    /// Files of the pictures, in the order of [`PANELS`].
    pub files: Vec<String>,
    /// Name and judgement of each light; `None` for a light that could not be judged.
    pub lights: Vec<(String, Option<Judgement>)>,
    /// Statistics of the first frame, as in the `stats.json` of `examples/render`.
    pub stats: Value,
    /// Times of a frame in which nothing moves, and of the light.
    pub cost: Cost,
    /// Whether holes of alpha masks let light through; `None` on a page without alpha masks.
    pub cuts_holes: Option<bool>,
}

/// Error of a light's rendered visibility.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    /// Number of wrong pixels.
    pub hard: HardError,
    /// The error as a mean; `None` if no pixel counts.
    pub soft: Option<SoftError>,
    /// First wrong pixel outside the edge band.
    pub first_wrong: Option<UVec2>,
}

/// Names of the pictures of a way, in their order.
pub const PANELS: [&str; 5] = ["picture", "visibility", "difference", "volumes", "overlay"];

/// Results of a page, and the page.
pub type Judged<'a> = (&'a Page, PageResult);

/// Returns all results as JSON.
pub fn json(results: &[Judged], techniques: &Techniques) -> Value {
    let kinds = light_kinds();
    let of_row = |row: &antumbra::techniques::Row| {
        let refused: Vec<Value> = kinds
            .iter()
            .filter_map(|&(name, kind)| Some(json!({"light": name, "why": refusal(*row, kind)?})))
            .collect();
        json!({"name": row.name(), "component": row.component_name(), "refuses": refused})
    };
    json!({
        "kinds": kinds.map(|(name, _)| name),
        "techniques": techniques.rows().iter().map(of_row).collect::<Vec<_>>(),
        "scenes": results.iter().map(scene).collect::<Vec<_>>(),
    })
}

fn scene((page, result): &Judged) -> Value {
    let shots = page.shots.iter().zip(&result.shots);
    json!({
        "name": page.name,
        "title": page.title,
        "about": page.about,
        "seconds": result.seconds,
        "triangles": result.triangle_count,
        "made_solid": result.made_solid,
        "shots": shots.map(|(shot, judged)| of_shot(page, shot, judged)).collect::<Vec<_>>(),
    })
}

fn of_shot(page: &Page, shot: &PageShot, judged: &ShotResult) -> Value {
    let ways = page.ways.iter().zip(&judged.ways);
    let of_way = |(way, result): (&super::way::Way, &Result<WayResult, String>)| {
        let technique = way.settings.row().name();
        let mut value = match result {
            Ok(result) => of_result(result, judged.light, technique),
            Err(reason) => json!({ "refused": reason }),
        };
        value["name"] = json!(way.name);
        value["title"] = json!(way.title);
        value["technique"] = json!(technique);
        value
    };
    json!({
        "name": shot.name,
        "caption": shot.caption,
        "light": shot.light,
        "soft": judged.is_soft,
        "truth": {"picture": judged.truth_picture, "visibility": judged.truth_visibility},
        "ways": ways.map(of_way).collect::<Vec<_>>(),
    })
}

/// Returns what a technique reported of the frame, each message once.
fn notes(stats: &Value, technique: &str) -> Vec<Value> {
    let mut notes: Vec<Value> = Vec::new();
    for report in stats["reports"].as_array().into_iter().flatten() {
        if report["topic"] == technique && !notes.contains(&report["message"]) {
            notes.push(report["message"].clone());
        }
    }
    notes
}

fn of_result(result: &WayResult, light: usize, technique: &str) -> Value {
    let lights = result.lights.iter().enumerate();
    let files = PANELS.iter().zip(&result.files);
    let files: serde_json::Map<String, Value> = files
        .map(|(name, file)| ((*name).to_owned(), json!(file)))
        .collect();
    let cost = &result.cost;
    json!({
        "pictures": files,
        "error": result.lights[light].1.map(of_judgement),
        "lights": lights
            .map(|(index, (name, judgement))| json!({
                "name": name,
                "technique": result.stats["lights"][index]["technique"],
                "error": judgement.map(of_judgement),
            }))
            .collect::<Vec<_>>(),
        "cost": {
            "rest": cost.ratio(),
            "moving": cost.moving_ratio(),
            "rest_ms": cost.shadowed_ms,
            "moving_ms": cost.moving_ms,
            "moving_cpu_ms": cost.moving_cpu_ms,
            "rest_cpu_ms": cost.cpu_ms.iter().sum::<f64>(),
            "unshadowed_ms": cost.unshadowed_ms,
        },
        "cuts_holes": result.cuts_holes,
        "notes": notes(&result.stats, technique),
        "batches": result.stats["lights"][light]["shadow_batches"],
        "edges": result.stats["lights"][light]["silhouette_edges"],
        "casters": result.stats["lights"][light]["S"],
        "stats": result.stats,
    })
}

fn of_judgement(judgement: Judgement) -> Value {
    let Judgement {
        hard,
        soft,
        first_wrong,
    } = judgement;
    json!({
        "wrong": hard.wrong_inner,
        "judged": hard.inner,
        "share": hard.share(),
        "at": first_wrong.map(|at| at.to_array()),
        "rmse": soft.map(|soft| soft.rmse),
        "rmse_penumbra": soft.and_then(|soft| soft.penumbra_rmse()),
    })
}

/// Returns one line on the technique that is exact off the edges, if any is, and the worst share of wrong pixels of any
/// hard light in any shot.
pub fn verdict(results: &[Judged]) -> String {
    let mut worst: Option<(f64, String)> = None;
    let (mut judged, mut wrong) = (0, 0);
    for (page, result) in results {
        for (shot, of_shot) in page
            .shots
            .iter()
            .zip(&result.shots)
            .filter(|(_, shot)| !shot.is_soft)
        {
            for (way, of_way) in page.ways.iter().zip(&of_shot.ways) {
                let Ok(of_way) = of_way else { continue };
                let (
                    name,
                    Some(Judgement {
                        hard, first_wrong, ..
                    }),
                ) = &of_way.lights[of_shot.light]
                else {
                    continue;
                };
                judged += hard.inner;
                wrong += hard.wrong_inner;
                let Some(share) = hard.share() else { continue };
                if worst.as_ref().is_none_or(|(most, _)| share > *most) {
                    let pixel =
                        first_wrong.map_or_else(String::new, |at| format!(" at pixel {},{}", at.x, at.y));
                    let at = format!("{}/{}, {}, light {name}{pixel}", page.name, shot.name, way.title);
                    worst = Some((share, at));
                }
            }
        }
    }
    match worst {
        Some((0.0, _)) => format!("exact: 0 of {judged} judged pixels are wrong off the edge band"),
        Some((share, at)) => format!(
            "worst share of wrong pixels off the edge band: {:.4} % ({at}); {wrong} of {judged} in all",
            share * 100.0
        ),
        None => "no hard shadow was judged".to_owned(),
    }
}
