//! Which technique when: what each way has measured over all scenes, and the best way for each thing that a user may want.
//! A want is a question to the measurements, so no technique is named here.

use serde_json::{Value, json};

use super::cost::median;
use super::page::Page;
use super::results::Judged;
use super::way::{Way, light_kinds, refusal};

/// Share of wrong pixels up to which a hard shadow still answers a question about cost.
const GOOD_SHARE: f64 = 0.01;

/// Factor on the least error up to which a soft shadow still answers a question about cost.
const GOOD_FACTOR: f64 = 2.0;

/// Measurements of one way over all shots.
pub struct Summary {
    way: Way,
    /// Shares of wrong pixels of hard shadows.
    hard: Vec<f64>,
    /// Scene and shot with the largest share of wrong pixels.
    worst: Option<(f64, String)>,
    /// Root mean squared errors of soft shadows over the penumbra.
    soft: Vec<f64>,
    /// Costs of a light at rest, as ratios to the light without shadows: of hard shadows, and of soft ones.
    rest: [Vec<f64>; 2],
    /// Costs of a moving light, as ratios to the light without shadows: of hard shadows, and of soft ones.
    moving: [Vec<f64>; 2],
    /// Number of shots whose light it refuses.
    refused: usize,
    /// Whether alpha masks cut holes into its shadows, if that was measured.
    cuts_holes: Option<bool>,
    /// Whether all pages show it. Further settings of a technique, which one page shows, answer no question: their numbers
    /// are of other scenes.
    is_everywhere: bool,
}

/// Sums up the results by way, in the order in which the ways first occur.
pub fn summaries(results: &[Judged]) -> Vec<Summary> {
    let mut all: Vec<Summary> = Vec::new();
    for (page, result) in results {
        for (shot, of_shot) in page.shots.iter().zip(&result.shots) {
            for (way, of_way) in page.ways.iter().zip(&of_shot.ways) {
                let index = all
                    .iter()
                    .position(|summary| summary.way.name == way.name)
                    .unwrap_or_else(|| {
                        all.push(Summary::new(way.clone()));
                        all.len() - 1
                    });
                let summary = &mut all[index];
                let Ok(of_way) = of_way else {
                    summary.refused += 1;
                    continue;
                };
                summary.rest[usize::from(of_shot.is_soft)].extend(of_way.cost.ratio());
                summary.moving[usize::from(of_shot.is_soft)].extend(of_way.cost.moving_ratio());
                let measured = [summary.cuts_holes, of_way.cuts_holes].into_iter().flatten();
                summary.cuts_holes = measured.reduce(|a, b| a || b);
                let Some(error) = of_way.lights[of_shot.light].1 else {
                    continue;
                };
                if of_shot.is_soft {
                    summary
                        .soft
                        .extend(error.soft.and_then(|soft| soft.penumbra_rmse()));
                } else if let Some(share) = error.hard.share() {
                    summary.hard.push(share);
                    if summary.worst.as_ref().is_none_or(|(worst, _)| share > *worst) {
                        summary.worst = Some((share, format!("{}/{}", page.name, shot.name)));
                    }
                }
            }
        }
    }
    for summary in &mut all {
        let shows = |page: &Page| page.ways.iter().any(|way| way.name == summary.way.name);
        summary.is_everywhere = results.iter().all(|(page, _)| shows(page));
    }
    all
}

impl Summary {
    fn new(way: Way) -> Self {
        Self {
            way,
            hard: Vec::new(),
            worst: None,
            soft: Vec::new(),
            rest: Default::default(),
            moving: Default::default(),
            refused: 0,
            cuts_holes: None,
            is_everywhere: true,
        }
    }

    fn hard(&self) -> Option<f64> {
        mean(&self.hard)
    }

    fn soft(&self) -> Option<f64> {
        mean(&self.soft)
    }

    fn rest(&self) -> Option<f64> {
        median(self.rest.concat())
    }

    fn moving(&self) -> Option<f64> {
        median(self.moving.concat())
    }

    fn refuses(&self) -> Vec<&'static str> {
        let row = self.way.settings.row();
        let kinds = light_kinds().into_iter();
        kinds
            .filter(|&(_, kind)| refusal(row, kind).is_some())
            .map(|(name, _)| name)
            .collect()
    }

    /// Returns the limits that the measurements and the technique's own checks show, a few words each.
    fn limits(&self) -> Vec<String> {
        let mut limits = Vec::new();
        let refused = self.refuses();
        let kinds = light_kinds();
        if refused.len() == kinds.len() {
            // Not for the light: it needs settings that nobody can guess.
            limits.extend(refusal(self.way.settings.row(), kinds[0].1));
        } else if !refused.is_empty() {
            limits.push(format!("refuses {} lights", refused.join(", ")));
        }
        if self.cuts_holes == Some(false) {
            limits.push("alpha masks cast whole".to_owned());
        }
        if let Some((share, at)) = self.worst.as_ref().filter(|(share, _)| *share > GOOD_SHARE) {
            limits.push(format!("{:.1} % wrong in {at}", share * 100.0));
        }
        limits
    }

    /// Returns the summary as JSON.
    pub fn json(&self) -> Value {
        json!({
            "name": self.way.name,
            "title": self.way.title,
            "technique": self.way.settings.row().name(),
            "hard": self.hard(),
            "soft": self.soft(),
            "rest": self.rest(),
            "moving": self.moving(),
            "shots": self.hard.len() + self.soft.len(),
            "refused": self.refused,
            "refuses": self.refuses(),
            "cuts_holes": self.cuts_holes,
            "limits": self.limits(),
        })
    }
}

/// A question to the summaries: who may answer, and whose number is the least.
struct Want {
    text: &'static str,
    number: fn(&Summary) -> Option<f64>,
    allowed: fn(&Summary, &[Summary]) -> bool,
}

fn is_good(summary: &Summary, _: &[Summary]) -> bool {
    summary.hard().is_some_and(|share| share <= GOOD_SHARE)
}

fn is_good_and_soft(summary: &Summary, all: &[Summary]) -> bool {
    let least = all.iter().filter_map(Summary::soft).min_by(f64::total_cmp);
    let pair = summary.soft().zip(least);
    pair.is_some_and(|(error, least)| error <= GOOD_FACTOR * least)
}

const WANTS: [Want; 7] = [
    Want {
        text: "hard shadows that are right",
        number: Summary::hard,
        allowed: |summary, _| summary.refuses().is_empty(),
    },
    Want {
        text: "soft shadows of lights with a size, as right as can be",
        number: Summary::soft,
        allowed: |_, _| true,
    },
    Want {
        text: "soft shadows, the cheapest with at most twice the least error",
        number: |summary| median(summary.rest[1].clone()),
        allowed: is_good_and_soft,
    },
    Want {
        text: "hard shadows of lights at rest, the cheapest with less than 1 % wrong",
        number: |summary| median(summary.rest[0].clone()),
        allowed: is_good,
    },
    Want {
        text: "hard shadows of moving lights, the cheapest with less than 1 % wrong",
        number: |summary| median(summary.moving[0].clone()),
        allowed: is_good,
    },
    Want {
        text: "one technique for every kind of light, the cheapest at rest",
        number: Summary::rest,
        allowed: |summary, _| summary.refuses().is_empty() && summary.hard().is_some(),
    },
    Want {
        text: "leaves and fences cut out by alpha masks",
        number: Summary::hard,
        allowed: |summary, _| summary.cuts_holes == Some(true),
    },
];

/// Returns, for each want, the summary that answers it best. Wants that nothing measured answers are left out.
pub fn choices(summaries: &[Summary]) -> Vec<(&'static str, &Summary)> {
    let best = |want: &Want| {
        let numbers = summaries
            .iter()
            .filter(|summary| summary.is_everywhere && (want.allowed)(summary, summaries))
            .filter_map(|summary| Some((summary, (want.number)(summary)?)));
        // Of equal answers, the first of the list.
        numbers
            .min_by(|a, b| a.1.total_cmp(&b.1))
            .map(|(summary, _)| (want.text, summary))
    };
    WANTS.iter().filter_map(best).collect()
}

/// Returns summaries and choices as JSON.
pub fn json(results: &[Judged]) -> Value {
    let summaries = summaries(results);
    let choices = choices(&summaries);
    let choices: Vec<Value> = choices
        .iter()
        .map(|(text, summary)| json!({"want": text, "name": summary.way.name}))
        .collect();
    json!({
        "choices": choices,
        "summaries": summaries.iter().map(Summary::json).collect::<Vec<_>>(),
    })
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}
