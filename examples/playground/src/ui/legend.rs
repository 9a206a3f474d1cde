//! Legends of false colours, in the lower corners of the view.

use egui::{Color32, FontId, Painter, Pos2, Rect, Ui, pos2, vec2};

use super::theme;
use crate::app::App;
use crate::measures::{Measure, Measured};

/// Height of a line, points.
const LINE: f32 = 15.0;

/// Width of a legend, points.
const WIDTH: f32 = 128.0;

/// Space around a legend, points.
const MARGIN: f32 = 8.0;

impl App {
    /// Draws the legend of each half that shows numbers; one if both show the same.
    pub(super) fn legends(&self, ui: &Ui, rect: Rect, pixels_per_point: f32) {
        let [left, right] = self.shown.panes;
        let pointer = ui.input(|input| input.pointer.hover_pos());
        let pointer = pointer.filter(|at| rect.contains(*at));
        for (show, at_left) in [
            (Some(left), true),
            (Some(right).filter(|right| *right != left), false),
        ] {
            let measured = show.and_then(|show| self.compare.as_ref()?.measured[show as usize].as_ref());
            let Some(measured) = measured.filter(|_| show.is_some_and(|show| show.measure().is_some()))
            else {
                continue;
            };
            let here = pointer.map(|at| value_at(measured, (at - rect.min) * pixels_per_point));
            let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
            draw(&painter, rect, at_left, measured, here);
        }
    }
}

/// Returns the value at a place of the view, pixels; NaN where there is none.
fn value_at(measured: &Measured, at: egui::Vec2) -> f32 {
    let (x, y) = (at.x.max(0.0) as usize, at.y.max(0.0) as usize);
    let (width, height) = (measured.size.x as usize, measured.size.y as usize);
    let is_inside = x < width && y < height;
    let value = is_inside.then(|| measured.values.get(y * width + x).copied());
    value.flatten().unwrap_or(f32::NAN)
}

/// Returns a number as the legend shows it.
fn number(measure: Measure, value: f32) -> String {
    match measure {
        _ if value.is_nan() => "none".to_owned(),
        Measure::Lights => format!("{value:.0}"),
        Measure::Texels if value >= 10.0 => format!("{value:.0}"),
        Measure::Texels => format!("{value:.2}"),
    }
}

/// Returns the lines below the colours.
fn lines(measured: &Measured, here: Option<f32>) -> Vec<String> {
    let summary = &measured.summary;
    let of = |value| number(measured.measure, value);
    let mut lines = match measured.measure {
        _ if summary.pixels == 0 => vec!["no pixel".to_owned()],
        Measure::Texels => vec![
            format!("median {}", of(summary.median)),
            format!("5 % below {}", of(summary.p5)),
        ],
        Measure::Lights => vec![
            format!("mean {:.2}", summary.mean),
            format!("most {}", of(summary.most)),
        ],
    };
    lines.extend(here.map(|here| format!("at the pointer {}", of(here))));
    lines
}

fn draw(painter: &Painter, view: Rect, at_left: bool, measured: &Measured, here: Option<f32>) {
    let steps = measured.measure.steps();
    let lines = lines(measured, here);
    // Room for the line at the pointer is always there, so that the legend does not jump.
    let height = LINE * (steps.len() + 4) as f32 + 2.0 * MARGIN;
    let x = if at_left {
        view.left() + MARGIN
    } else {
        view.right() - MARGIN - WIDTH
    };
    let top = (view.bottom() - MARGIN - height).max(view.top() + MARGIN);
    let rect = Rect::from_min_size(pos2(x, top), vec2(WIDTH, height));
    painter.rect_filled(rect, 4.0, Color32::from_black_alpha(190));
    let mut at = rect.min + vec2(MARGIN, MARGIN);
    let text = |at: Pos2, text: &str, color: Color32| {
        let align = egui::Align2::LEFT_CENTER;
        painter.text(
            at + vec2(0.0, 0.5 * LINE),
            align,
            text,
            FontId::proportional(12.0),
            color,
        );
    };
    text(at, measured.measure.title(), Color32::WHITE);
    at.y += LINE;
    for step in steps {
        let [r, g, b] = step.color;
        let sample = Rect::from_min_size(at + vec2(0.0, 1.0), vec2(20.0, LINE - 2.0));
        painter.rect_filled(sample, 2.0, Color32::from_rgb(r, g, b));
        text(at + vec2(28.0, 0.0), step.text, theme::DIM);
        at.y += LINE;
    }
    for line in &lines {
        text(at, line, Color32::WHITE);
        at.y += LINE;
    }
}
