//! The techniques of the selected light on both sides, with their settings, and the errors against the truth.

use egui::{ComboBox, Frame, Margin, RichText, Ui};

use super::theme;
use crate::app::App;
use crate::compare::Judgement;
use crate::document::{LightDoc, NONE, Side};
use crate::widgets;

impl App {
    pub(super) fn techniques_panel(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        let Some(index) = self
            .shown
            .selected
            .filter(|index| *index < self.document.lights().len())
        else {
            ui.heading("Techniques");
            ui.weak("Select a light to choose how it casts its shadows.");
            return;
        };
        for side in Side::ALL {
            let color = if side == Side::A { theme::A } else { theme::B };
            Frame::new()
                .fill(ui.visuals().faint_bg_color)
                .corner_radius(5.0)
                .inner_margin(Margin::same(8))
                .show(ui, |ui| {
                    ui.set_min_width(ui.available_width());
                    ui.push_id(side, |ui| {
                        self.technique_menu(ui, side, index, color);
                        self.settings(ui, side, index);
                        self.errors(ui, side);
                    });
                });
            ui.add_space(4.0);
        }
        self.truth_state(ui);
    }

    fn technique_menu(&mut self, ui: &mut Ui, side: Side, index: usize, color: egui::Color32) {
        let now = self.document.lights()[index].technique(side).to_owned();
        let mut chosen = now.clone();
        ui.horizontal(|ui| {
            ui.label(RichText::new(side.name()).strong().size(16.0).color(color));
            ComboBox::from_id_salt("technique")
                .width(ui.available_width() - 30.0)
                .height(420.0)
                .selected_text(crate::schema::label(&now))
                .show_ui(ui, |ui| {
                    for name in [NONE].into_iter().chain(self.schemas.technique_names()) {
                        let text = crate::schema::label(name);
                        let mut entry = ui.selectable_label(now == name, text);
                        let about = self.schemas.about(name);
                        if !about.is_empty() {
                            entry = entry.on_hover_text(about);
                        }
                        if entry.clicked() {
                            chosen = name.to_owned();
                        }
                    }
                });
        });
        if chosen != now {
            self.choose(side, &chosen);
        }
    }

    fn settings(&mut self, ui: &mut Ui, side: Side, index: usize) {
        let name = self.document.lights()[index].technique(side).to_owned();
        if name == NONE {
            ui.weak("The light shines through everything.");
            return;
        }
        let mut settings = self.document.lights()[index].shadows[side.index()].clone();
        let changed = match self.schemas.technique(&name) {
            Some(schema) => widgets::object(ui, &self.schemas, schema, &mut settings, &[]),
            None => {
                ui.weak("This technique does not describe its settings.");
                None
            }
        };
        if let Some(key) = changed {
            let name = format!("{key} of {}", side.name());
            self.change_light(&name, index, |light| light.shadows[side.index()] = settings);
        }
    }

    fn errors(&self, ui: &mut Ui, side: Side) {
        let judgement = self
            .compare
            .as_ref()
            .and_then(|compare| compare.judgements[side.index()]);
        if let Some(judgement) = judgement {
            ui.separator();
            for (name, value, help) in figures(&judgement) {
                ui.horizontal(|ui| {
                    ui.label(RichText::new(name).color(theme::DIM))
                        .on_hover_text(help);
                    ui.monospace(value);
                });
            }
        }
    }

    fn truth_state(&mut self, ui: &mut Ui) {
        let Some(compare) = &self.compare else { return };
        let Some(answer) = compare.truth.answer() else {
            if compare.truth.is_refining() {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.weak("Tracing the truth…");
                });
            }
            return;
        };
        let limit = compare.truth.limit;
        ui.horizontal(|ui| {
            ui.label(RichText::new("Truth").strong());
            let share = answer.samples as f32 / limit.max(1) as f32;
            let text = format!("{} of {limit} samples", answer.samples);
            ui.add(egui::ProgressBar::new(share).desired_width(150.0).text(text));
        });
        if compare.left_out > 0 {
            ui.weak(format!(
                "The truth leaves out {} lights, whose pictures would take too much memory. They shine through \
                 everything there.",
                compare.left_out
            ));
        }
        for note in self.selected_light().into_iter().flat_map(truth_notes) {
            ui.weak(note);
        }
    }
}

/// Returns what the truth does not know of a light.
fn truth_notes(light: &LightDoc) -> Vec<&'static str> {
    let has = |keys: &[&str]| keys.iter().any(|key| light.keys.contains_key(*key));
    let notes = [
        (
            has(&["shadow_origin", "shadow_direction", "shadow_softness"]),
            "The truth casts shadows from where the light is, with its own size.",
        ),
        (
            light.kind() == "directional",
            "The truth of a directional light has hard edges, because the light has no size.",
        ),
        (
            has(&["path"]),
            "The truth is that of one point of the light's path, without the width of the light.",
        ),
    ];
    notes
        .into_iter()
        .filter_map(|(is_so, note)| is_so.then_some(note))
        .collect()
}

/// Returns the errors as names, values and explanations.
pub fn figures(judgement: &Judgement) -> Vec<(&'static str, String, &'static str)> {
    let unknown = || "–".to_owned();
    let share = judgement
        .hard
        .share()
        .map_or_else(unknown, |share| format!("{:.3} %", share * 100.0));
    let mut all = vec![(
        "Wrong pixels",
        share,
        "Share of the pixels, off a one-pixel band along edges, whose visibility is wrong by more than one half.",
    )];
    if let Some(soft) = &judgement.soft {
        let penumbra = soft.penumbra_rmse();
        all.push((
            "RMSE",
            format!("{:.4}", soft.rmse),
            "Root mean squared error of visibility over all pixels that face the light.",
        ));
        all.push((
            "RMSE of penumbrae",
            penumbra.map_or_else(unknown, |rmse| format!("{rmse:.4}")),
            "Root mean squared error over the pixels that truly see a part of the light.",
        ));
    }
    all
}

#[cfg(test)]
mod tests {
    use antumbra::reference::{HardError, SoftError};
    use antumbra::techniques::Techniques;
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn an_error_of_no_pixel_is_no_number() {
        let hard = HardError {
            counted: 9,
            inner: 0,
            wrong_inner: 0,
            wrong_all: 0,
        };
        let soft = |penumbra: usize| SoftError {
            counted: 9,
            penumbra,
            rmse: 0.25,
            rmse_penumbra: 0.0,
            p99: 0.5,
            umbra_lit: 0.0,
            lit_dark: 0.0,
        };
        let shown = |penumbra: usize| {
            let soft = Some(soft(penumbra));
            figures(&Judgement { hard, soft })
                .into_iter()
                .map(|(_, value, _)| value)
                .collect::<Vec<_>>()
        };
        assert_eq!(shown(0), ["–", "0.2500", "–"]);
        assert_eq!(shown(3), ["–", "0.2500", "0.0000"]);
    }

    #[test]
    fn what_the_truth_does_not_know_is_said() {
        let count = |light: Value| {
            let Value::Object(keys) = light else { panic!() };
            truth_notes(&LightDoc::new(String::new(), keys, &Techniques::default())).len()
        };
        assert_eq!(
            count(json!({"kind": "sphere", "position": [0, 1, 0], "radius": 0.2})),
            0
        );
        assert_eq!(
            count(json!({"kind": "point", "position": [0, 1, 0], "shadow_softness": 0.2})),
            1
        );
        assert_eq!(
            count(json!({"kind": "directional", "path": {"latitude_deg": 50, "day": 172}})),
            2
        );
    }
}
