//! The help, and the window with Bevy code.

use egui::{Grid, ScrollArea, Ui, Window};

use crate::app::App;
use crate::compare::Show;
use crate::overlay::Overlay;

/// What the keys and the mouse do.
const KEYS: [(&str, &str); 15] = [
    ("Left drag", "Go around the target; on a light: move it"),
    ("Right drag", "Look around"),
    ("Middle drag", "Move the camera sideways"),
    ("Wheel", "Go nearer or farther"),
    ("W A S D, Q E", "Fly, down and up; with Shift faster"),
    ("F", "Look at the middle of the scene"),
    ("Click on a light", "Select it; its handles move and turn it"),
    ("Drag the divider", "Compare the halves"),
    ("Ctrl+Z, Ctrl+Shift+Z", "Undo, redo"),
    ("Ctrl+D, Delete", "Copy or delete the selected light"),
    ("Ctrl+S", "Save the shot with techniques A"),
    ("Space", "Play the animation"),
    ("Click on a bright setting", "Set its default"),
    ("F1", "This help"),
    ("Drop a file", "Open a scene or a shot"),
];

impl App {
    pub(super) fn help_window(&mut self, ui: &Ui) {
        let mut is_open = self.shown.help;
        Window::new("Help")
            .open(&mut is_open)
            .collapsible(false)
            .resizable(false)
            .anchor(egui::Align2::CENTER_CENTER, [0.0, 0.0])
            .show(ui.ctx(), |ui| {
                ScrollArea::vertical()
                    .max_height((ui.ctx().content_rect().height() - 80.0).max(60.0))
                    .show(ui, help);
            });
        self.shown.help = is_open;
    }

    pub(super) fn code_window(&mut self, ui: &Ui) {
        let Some(code) = &self.shown.code else { return };
        let mut is_open = true;
        let mut copied = None;
        Window::new("Lights as Bevy code")
            .open(&mut is_open)
            .default_width(620.0)
            .show(ui.ctx(), |ui| {
                if ui.button("Copy to the clipboard").clicked() {
                    copied = Some(code.clone());
                }
                ScrollArea::both().max_height(420.0).show(ui, |ui| {
                    ui.add(
                        egui::TextEdit::multiline(&mut code.as_str())
                            .code_editor()
                            .desired_width(f32::INFINITY),
                    );
                });
            });
        if let Some(text) = copied {
            ui.ctx().copy_text(text.clone());
            self.shown.copied = Some(text);
        }
        if !is_open {
            self.shown.code = None;
        }
    }
}

fn help(ui: &mut Ui) {
    ui.set_width(560.0);
    ui.strong("Mouse and keys");
    table(ui, "keys", &KEYS);
    ui.add_space(6.0);
    ui.strong("What a half of the view shows");
    table(ui, "halves", &Show::ALL.map(|show| (show.name(), show.help())));
    ui.add_space(6.0);
    ui.strong("Lines over the picture, in the menu View");
    table(ui, "lines", &Overlay::ALL.map(Overlay::text));
    ui.add_space(6.0);
    ui.label(
        "Each light has two techniques, A and B. Hover over a name to see what the setting does. Errors are those of \
         the selected light. Lights and the camera of a scene are taken from it as it opens; they do not move with its \
         animation.",
    );
}

fn table(ui: &mut Ui, id: &str, rows: &[(&str, &str)]) {
    Grid::new(id).num_columns(2).spacing([16.0, 3.0]).show(ui, |ui| {
        for (name, text) in rows {
            ui.monospace(*name);
            ui.add(egui::Label::new(*text).wrap());
            ui.end_row();
        }
    });
}
