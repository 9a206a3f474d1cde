//! The graph of times: bars of the last frames by GPU pass, and the means by pass and by CPU set.

use egui::{Color32, Rect, RichText, ScrollArea, Sense, Ui, pos2, vec2};

use super::theme;
use crate::app::App;
use crate::document::Side;
use crate::times::{FRAMES, FrameTimes};

/// Passes that have a colour of their own.
const NAMED: usize = 8;

impl App {
    pub(super) fn times_panel(&mut self, ui: &mut Ui) {
        let shown: Vec<Side> = Side::ALL
            .into_iter()
            .filter(|side| !self.times.frames[side.index()].is_empty())
            .collect();
        let means: Vec<FrameTimes> = shown.iter().map(|side| self.times.mean(*side)).collect();
        ui.columns(shown.len().max(1), |columns| {
            for ((ui, side), mean) in columns.iter_mut().zip(&shown).zip(&means) {
                self.times_of(ui, *side, mean);
            }
        });
        if shown.is_empty() {
            ui.weak("No frame was timed yet.");
        }
    }

    fn times_of(&self, ui: &mut Ui, side: Side, mean: &FrameTimes) {
        let color = if side == Side::A { theme::A } else { theme::B };
        ui.horizontal(|ui| {
            ui.label(RichText::new(side.name()).strong().color(color));
            ui.label(format!("GPU {:.2} ms", mean.gpu()));
            ui.label(RichText::new(format!("CPU {:.2} ms", mean.cpu())).color(theme::DIM));
        });
        let frames = &self.times.frames[side.index()];
        if mean.passes.is_empty() {
            ui.weak("This device does not time passes.");
        } else {
            bars(ui, frames, mean);
        }
        ScrollArea::vertical().id_salt(side).show(ui, |ui| {
            ui.columns(2, |columns| {
                for (index, (label, time)) in mean.passes.iter().enumerate() {
                    line(&mut columns[0], label, *time, series(index));
                }
                for (name, time) in &mean.sets {
                    line(&mut columns[1], &crate::schema::label(name), *time, theme::DIM);
                }
            });
        });
    }
}

fn series(index: usize) -> Color32 {
    if index < NAMED {
        theme::series(index)
    } else {
        Color32::from_gray(110)
    }
}

fn line(ui: &mut Ui, name: &str, time: f64, color: Color32) {
    ui.horizontal(|ui| {
        let (dot, _) = ui.allocate_exact_size(vec2(8.0, 8.0), Sense::hover());
        ui.painter().rect_filled(dot, 2.0, color);
        ui.monospace(format!("{time:6.3}"));
        ui.add(egui::Label::new(RichText::new(name).small()).truncate());
    });
}

/// Draws a stacked bar for each frame.
fn bars(ui: &mut Ui, frames: &[FrameTimes], mean: &FrameTimes) {
    let (rect, _) = ui.allocate_exact_size(vec2(ui.available_width(), 56.0), Sense::hover());
    let painter = ui.painter().with_clip_rect(rect);
    painter.rect_filled(rect, 3.0, ui.visuals().extreme_bg_color);
    let most = frames.iter().map(FrameTimes::gpu).fold(1e-6, f64::max);
    let width = rect.width() / FRAMES as f32;
    for (index, frame) in frames.iter().enumerate() {
        let left = rect.right() - (frames.len() - index) as f32 * width;
        let mut base = rect.bottom();
        for (label, time) in &frame.passes {
            let rank = mean.passes.iter().position(|(known, _)| known == label);
            let height = (time / most) as f32 * (rect.height() - 4.0);
            let bar = Rect::from_min_max(pos2(left, base - height), pos2(left + width, base));
            painter.rect_filled(bar, 0.0, series(rank.unwrap_or(NAMED)));
            base -= height;
        }
    }
    let text = format!("{most:.2} ms");
    let font = egui::FontId::proportional(10.0);
    painter.text(
        rect.left_top() + vec2(4.0, 2.0),
        egui::Align2::LEFT_TOP,
        text,
        font,
        theme::DIM,
    );
}
