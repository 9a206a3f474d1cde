//! The bars above and below: files, what the halves show, the animation, and messages.

use egui::{Align, ComboBox, Layout, RichText, TextEdit, Ui};

use super::theme;
use crate::app::App;
use crate::compare::Show;
use crate::document::Side;
use crate::overlay::Overlay;

impl App {
    pub(super) fn top_bar(&mut self, ui: &mut Ui) {
        ui.add_space(2.0);
        ui.horizontal(|ui| {
            self.file_menu(ui);
            self.edit_menu(ui);
            self.look_menu(ui);
            ui.separator();
            for (index, side) in ["Left", "Right"].into_iter().enumerate() {
                ui.label(RichText::new(side).color(theme::DIM));
                let pane = &mut self.shown.panes[index];
                ComboBox::from_id_salt(("pane", index))
                    .width(88.0)
                    .selected_text(pane.name())
                    .show_ui(ui, |ui| {
                        for show in Show::ALL {
                            ui.selectable_value(pane, show, show.name())
                                .on_hover_text(show.help());
                        }
                    });
            }
            if ui.button("Swap").on_hover_text("Swaps the halves.").clicked() {
                self.shown.panes.swap(0, 1);
            }
            ui.checkbox(&mut self.shown.judge, "Judge").on_hover_text(
                "Traces the truth in the background even if no half shows it, and measures the errors.",
            );
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if ui.button("Help  F1").clicked() {
                    self.shown.help = !self.shown.help;
                }
                ui.toggle_value(&mut self.shown.times, "Times");
            });
        });
        ui.add_space(1.0);
    }

    fn file_menu(&mut self, ui: &mut Ui) {
        ui.menu_button("File", |ui| {
            ui.set_min_width(300.0);
            ui.label("A scene (.glb, .gltf) or a shot (.json):");
            ui.horizontal(|ui| {
                ui.add(TextEdit::singleline(&mut self.shown.path).desired_width(230.0));
                if ui.button("Open").clicked() {
                    let path = std::path::PathBuf::from(self.shown.path.trim());
                    self.open(&path);
                    ui.close();
                }
            });
            ui.weak("Or drop a file on the window.");
            ui.separator();
            for side in Side::ALL {
                let text = format!("Save the shot with techniques {}", side.name());
                if ui.button(text).clicked() {
                    let path = self.free_name("json");
                    self.save(side, &path);
                    ui.close();
                }
            }
            for show in self.shown.panes {
                if ui.button(format!("Save the picture: {}", show.name())).clicked() {
                    let path = self.free_name("png");
                    self.save_picture(show, &path);
                    ui.close();
                }
                if self.shown.panes[0] == self.shown.panes[1] {
                    break;
                }
            }
            ui.separator();
            for side in Side::ALL {
                if ui
                    .button(format!("Lights as Bevy code, techniques {}", side.name()))
                    .clicked()
                {
                    self.shown.code = Some(self.bevy_code(side));
                    ui.close();
                }
            }
        });
    }

    fn edit_menu(&mut self, ui: &mut Ui) {
        let (past, future) = self.history.steps();
        let undo = egui::Button::new("⟲");
        if ui
            .add_enabled(past > 0, undo)
            .on_hover_text("Undo (Ctrl+Z)")
            .clicked()
        {
            self.step(true);
        }
        let redo = egui::Button::new("⟳");
        if ui
            .add_enabled(future > 0, redo)
            .on_hover_text("Redo (Ctrl+Shift+Z)")
            .clicked()
        {
            self.step(false);
        }
    }

    fn look_menu(&mut self, ui: &mut Ui) {
        ui.menu_button("View", |ui| {
            ui.set_min_width(180.0);
            for overlay in Overlay::ALL {
                let (name, help) = overlay.text();
                let mut on = self.shown.overlays.contains(&overlay);
                if ui.checkbox(&mut on, name).on_hover_text(help).changed() {
                    self.overlay(overlay, on);
                }
            }
            ui.checkbox(&mut self.shown.debug_volumes, "Technique's own debug view")
                .on_hover_text(
                    "Draws the shadow geometry of the techniques that show theirs over the picture.",
                );
            ui.separator();
            let mut exposure = self.document.exposure;
            ui.horizontal(|ui| {
                ui.label("Exposure");
                let slider = egui::Slider::new(&mut exposure, 0.05..=20.0).logarithmic(true);
                if ui.add(slider).changed() {
                    self.change("exposure", |document| document.exposure = exposure);
                }
            });
            let mut ambient = self.document.ambient;
            ui.horizontal(|ui| {
                ui.label("Ambient");
                if ui.color_edit_button_rgb(&mut ambient).changed() {
                    self.change("ambient", |document| document.ambient = ambient);
                }
            });
        });
    }

    pub(crate) fn overlay(&mut self, overlay: Overlay, on: bool) {
        self.shown.overlays.retain(|shown| *shown != overlay);
        if on {
            self.shown.overlays.push(overlay);
        }
    }

    pub(super) fn status_bar(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            self.animation(ui);
            let mut is_closed = false;
            match &self.message {
                Some(message) => {
                    let color = if message.is_error { theme::BAD } else { theme::GOOD };
                    is_closed = ui.small_button("x").clicked();
                    ui.add(egui::Label::new(RichText::new(&message.text).color(color)).truncate())
                        .on_hover_text(&message.text);
                }
                None => {
                    let text = match &self.compare {
                        Some(compare) => format!(
                            "{} · {} triangles · {}",
                            self.document
                                .scene
                                .file_name()
                                .unwrap_or_default()
                                .to_string_lossy(),
                            compare.loaded.triangle_count(),
                            self.gpu.context.adapter
                        ),
                        None => self.gpu.context.adapter.clone(),
                    };
                    ui.add(egui::Label::new(RichText::new(text).color(theme::DIM)).truncate());
                }
            }
            if is_closed {
                self.message = None;
            }
        });
    }

    fn animation(&mut self, ui: &mut Ui) {
        let clips = self
            .compare
            .as_ref()
            .map_or(0, |compare| compare.loaded.clips.len());
        if clips == 0 {
            return;
        }
        let pose = self.document.pose;
        let mut clip = pose.map_or(0, |pose| pose.clip);
        let mut time = pose.map_or(0.0, |pose| pose.time);
        let sign = if self.shown.playing { "⏸" } else { "▶" };
        if ui
            .button(sign)
            .on_hover_text("Plays the animation (space).")
            .clicked()
        {
            self.shown.playing = !self.shown.playing;
        }
        let length = self.clip_length(clip);
        let slider = egui::Slider::new(&mut time, 0.0..=length.max(0.001)).suffix(" s");
        let is_moved = ui.add(slider.max_decimals(2)).changed();
        let mut is_other = false;
        if clips > 1 {
            let drag = egui::DragValue::new(&mut clip)
                .range(0..=clips - 1)
                .prefix("clip ");
            is_other = ui.add(drag).changed();
        }
        if is_moved || is_other {
            self.shown.playing &= is_other;
            // The end of a clip is its last pose, not its first.
            self.pose(clip, if is_other { 0.0 } else { time.min(length * 0.9999) });
        }
        ui.separator();
    }
}
