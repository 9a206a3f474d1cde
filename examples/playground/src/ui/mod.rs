//! The window's contents.

mod help;
mod legend;
mod lights;
mod techniques;
pub mod theme;
mod times;
mod top;
mod view;

use egui::{CentralPanel, Frame, Key, Margin, Modifiers, Panel, ScrollArea, Ui};

use crate::app::App;

/// Width below which a window has no room for the panels beside the picture, points.
const NARROW: f32 = 560.0;

impl App {
    /// Shows everything and handles its input.
    pub fn ui(&mut self, ui: &mut Ui) {
        self.keys(ui);
        self.dropped(ui);
        let screen = ui.max_rect();
        let is_wide = screen.width() >= NARROW && screen.height() >= 240.0;
        if is_wide {
            Panel::top("top").show_inside(ui, |ui| self.top_bar(ui));
            Panel::bottom("status").show_inside(ui, |ui| self.status_bar(ui));
            if self.shown.times {
                Panel::bottom("times")
                    .default_size(210.0)
                    .size_range(120.0..=340.0)
                    .show_inside(ui, |ui| self.times_panel(ui));
            }
            Panel::left("lights")
                .default_size(270.0)
                .size_range(220.0..=420.0)
                .show_inside(ui, |ui| {
                    ScrollArea::vertical().show(ui, |ui| self.lights_panel(ui));
                });
            Panel::right("techniques")
                .default_size(300.0)
                .size_range(240.0..=460.0)
                .show_inside(ui, |ui| {
                    ScrollArea::vertical().show(ui, |ui| self.techniques_panel(ui));
                });
        }
        let frame = Frame::new().fill(theme::BEHIND).inner_margin(Margin::ZERO);
        CentralPanel::no_frame()
            .frame(frame)
            .show_inside(ui, |ui| self.view_panel(ui));
        self.help_window(ui);
        self.code_window(ui);
        if !ui.input(|input| input.pointer.any_down()) && ui.memory(|memory| memory.focused().is_none()) {
            self.history.close();
        }
    }

    fn keys(&mut self, ui: &Ui) {
        let pressed =
            |modifiers: Modifiers, key: Key| ui.input_mut(|input| input.consume_key(modifiers, key));
        if pressed(Modifiers::NONE, Key::F1) {
            self.shown.help = !self.shown.help;
        }
        if ui.memory(|memory| memory.focused().is_some()) {
            return; // keys are typed into a field
        }
        let redo = Modifiers::COMMAND | Modifiers::SHIFT;
        if pressed(redo, Key::Z) || pressed(Modifiers::COMMAND, Key::Y) {
            self.step(false);
        }
        if pressed(Modifiers::COMMAND, Key::Z) {
            self.step(true);
        }
        if pressed(Modifiers::COMMAND, Key::D) {
            self.duplicate();
        }
        if pressed(Modifiers::COMMAND, Key::S) {
            let path = self.free_name("json");
            self.save(crate::document::Side::A, &path);
        }
        if pressed(Modifiers::NONE, Key::Delete) {
            self.delete();
        }
        if pressed(Modifiers::NONE, Key::Escape) {
            self.shown.help = false;
            self.shown.code = None;
        }
        if pressed(Modifiers::NONE, Key::Space) {
            self.shown.playing = !self.shown.playing && self.clip_length(0) > 0.0;
        }
        if pressed(Modifiers::NONE, Key::F) {
            let target = self.bounds.0;
            if let Some(view) = &mut self.document.view {
                let step = target - view.target;
                view.eye += step;
                view.target = target;
            }
        }
    }

    fn dropped(&mut self, ui: &Ui) {
        let files = ui.input(|input| input.raw.dropped_files.clone());
        let paths: Vec<_> = files.into_iter().filter_map(|file| file.path).collect();
        let Some(first) = paths.first() else { return };
        if self.open(first) && paths.len() > 1 {
            self.tell(format!(
                "Of {} files the first was opened: {}",
                paths.len(),
                first.display()
            ));
        }
    }
}
