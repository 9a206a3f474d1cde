//! The list of lights, and the keys of the selected one.

use egui::{RichText, ScrollArea, Ui};

use super::theme;
use crate::app::App;
use crate::document::Side;
use crate::widgets;

/// Keys that have a place of their own in the window.
const HIDDEN: [&str; 3] = ["kind", "shadow", "angle_deg"];

/// Keys of the light itself; the others are those of the light model.
const OWN: [&str; 11] = [
    "position",
    "direction",
    "up",
    "width",
    "height",
    "radius",
    "inner_deg",
    "outer_deg",
    "range",
    "color",
    "intensity",
];

impl App {
    pub(super) fn lights_panel(&mut self, ui: &mut Ui) {
        ui.add_space(4.0);
        ui.horizontal(|ui| {
            ui.heading(format!("Lights  {}", self.document.lights().len()));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                self.light_buttons(ui);
            });
        });
        self.light_list(ui);
        ui.separator();
        let Some(index) = self.shown.selected else {
            ui.weak("No light is selected. Add one, or click on one in the list or in the picture.");
            return;
        };
        let Some(light) = self.document.lights().get(index) else {
            return;
        };
        let mut keys = light.keys.clone();
        let mut name = light.name.clone();
        let kind = light.kind().to_owned();
        ui.horizontal(|ui| {
            ui.add(egui::TextEdit::singleline(&mut name).desired_width(150.0));
            ui.weak(&kind);
        });
        if name != self.document.lights()[index].name {
            self.change_light("name", index, |light| light.name = name);
        }
        let mut changed = None;
        if let Some(schema) = self.schemas.light(&kind) {
            changed = color_row(ui, &mut keys).then(|| "color".to_owned());
            let rest = |key: &&str| !OWN.contains(key) || *key == "color";
            let all = schema["properties"].as_object();
            let model: Vec<&str> = all
                .into_iter()
                .flatten()
                .map(|(key, _)| key.as_str())
                .filter(rest)
                .collect();
            let hidden: Vec<&str> = model.iter().copied().chain(HIDDEN).collect();
            changed = widgets::object(ui, &self.schemas, schema, &mut keys, &hidden).or(changed);
            egui::CollapsingHeader::new("Light model")
                .default_open(false)
                .show(ui, |ui| {
                    let hidden: Vec<&str> = OWN.into_iter().chain(HIDDEN).collect();
                    let edited = widgets::object(ui, &self.schemas, schema, &mut keys, &hidden);
                    changed = edited.or(changed.take());
                });
        }
        if let Some(key) = changed {
            self.change_light(&key, index, |light| light.keys = keys);
        }
        self.light_faults(ui, index);
    }

    fn light_buttons(&mut self, ui: &mut Ui) {
        let is_one = self.selected_light().is_some();
        let button = |text: &str| egui::Button::new(text.to_owned());
        if ui
            .add_enabled(is_one, button("Delete"))
            .on_hover_text("Deletes the selected light (Delete).")
            .clicked()
        {
            self.delete();
        }
        if ui
            .add_enabled(is_one, button("Copy"))
            .on_hover_text("Adds a copy of the selected light (Ctrl+D).")
            .clicked()
        {
            self.duplicate();
        }
        let kinds: Vec<String> = self
            .schemas
            .light_kinds()
            .into_iter()
            .map(str::to_owned)
            .collect();
        ui.add_enabled_ui(self.compare.is_some(), |ui| {
            ui.menu_button("Add", |ui| {
                for kind in kinds {
                    if ui.button(crate::schema::label(&kind)).clicked() {
                        self.add(&kind);
                        ui.close();
                    }
                }
            });
        });
    }

    fn light_list(&mut self, ui: &mut Ui) {
        let height = ui.spacing().interact_size.y;
        let count = self.document.lights().len();
        let mut selected = self.shown.selected;
        ScrollArea::vertical()
            .id_salt("list")
            .max_height(150.0)
            .auto_shrink([false, true])
            .show_rows(ui, height, count, |ui, rows| {
                for index in rows {
                    let light = &self.document.lights()[index];
                    ui.horizontal(|ui| {
                        let techniques = Side::ALL.map(|side| light.technique(side).replace('_', " "));
                        let text = RichText::new(&light.name);
                        if ui.selectable_label(selected == Some(index), text).clicked() {
                            selected = Some(index);
                        }
                        let [a, b] = techniques;
                        ui.add(
                            egui::Label::new(RichText::new(format!("{a} | {b}")).small().color(theme::DIM))
                                .truncate(),
                        );
                    });
                }
            });
        self.shown.selected = selected;
    }

    fn light_faults(&self, ui: &mut Ui, index: usize) {
        let Some(compare) = &self.compare else { return };
        let mut told: Vec<String> = Vec::new();
        for side in compare.sides.iter().flatten() {
            let error = side.errors.get(index).cloned().flatten();
            for text in error.into_iter().chain(side.reports(Some(index))) {
                if !told.contains(&text) {
                    ui.colored_label(theme::BAD, &text);
                    told.push(text);
                }
            }
        }
    }
}

/// Shows the colour with its picker. Returns whether it changed.
fn color_row(ui: &mut Ui, keys: &mut serde_json::Map<String, serde_json::Value>) -> bool {
    let part = |index: usize| {
        let color = keys.get("color").and_then(|color| color.get(index));
        color
            .and_then(serde_json::Value::as_f64)
            .map_or(1.0, |part| part as f32)
    };
    let mut color = [part(0), part(1), part(2)];
    let changed = ui
        .horizontal(|ui| {
            widgets::name(ui, egui::RichText::new("Color"));
            ui.color_edit_button_rgb(&mut color).changed()
        })
        .inner;
    if changed {
        keys.insert(
            "color".to_owned(),
            serde_json::json!(color.map(crate::document::rounded)),
        );
    }
    changed
}
