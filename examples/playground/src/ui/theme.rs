//! Colours and spaces.

use egui::{Color32, CornerRadius, FontId, Stroke, TextStyle, Visuals, vec2};

/// Behind the picture.
pub const BEHIND: Color32 = Color32::from_rgb(16, 17, 20);
/// Panels.
const PANEL: Color32 = Color32::from_rgb(28, 30, 35);
/// Side A.
pub const A: Color32 = Color32::from_rgb(104, 178, 255);
/// Side B.
pub const B: Color32 = Color32::from_rgb(255, 176, 92);
/// What is right.
pub const GOOD: Color32 = Color32::from_rgb(120, 210, 140);
/// What is wrong.
pub const BAD: Color32 = Color32::from_rgb(255, 120, 108);
/// Text that matters less.
pub const DIM: Color32 = Color32::from_rgb(150, 156, 168);

/// Sets the theme.
pub fn apply(context: &egui::Context) {
    context.set_theme(egui::Theme::Dark);
    context.all_styles_mut(|style| {
        let mut visuals = Visuals::dark();
        visuals.panel_fill = PANEL;
        visuals.window_fill = PANEL;
        visuals.extreme_bg_color = Color32::from_rgb(18, 19, 23);
        visuals.faint_bg_color = Color32::from_rgb(34, 36, 42);
        visuals.override_text_color = Some(Color32::from_rgb(222, 226, 234));
        visuals.weak_text_color = Some(DIM);
        visuals.selection.bg_fill = Color32::from_rgb(44, 86, 136);
        visuals.selection.stroke = Stroke::new(1.0, Color32::WHITE);
        visuals.hyperlink_color = A;
        visuals.warn_fg_color = B;
        visuals.error_fg_color = BAD;
        let radius = CornerRadius::same(4);
        for widget in [
            &mut visuals.widgets.noninteractive,
            &mut visuals.widgets.inactive,
            &mut visuals.widgets.hovered,
            &mut visuals.widgets.active,
            &mut visuals.widgets.open,
        ] {
            widget.corner_radius = radius;
        }
        visuals.widgets.noninteractive.bg_stroke = Stroke::new(1.0, Color32::from_rgb(46, 49, 57));
        visuals.widgets.inactive.weak_bg_fill = Color32::from_rgb(48, 52, 61);
        visuals.widgets.inactive.bg_fill = Color32::from_rgb(48, 52, 61);
        visuals.widgets.hovered.weak_bg_fill = Color32::from_rgb(62, 67, 79);
        visuals.widgets.active.weak_bg_fill = Color32::from_rgb(74, 80, 94);
        style.visuals = visuals;
        style.spacing.item_spacing = vec2(8.0, 5.0);
        style.spacing.button_padding = vec2(8.0, 3.0);
        style.spacing.interact_size.y = 21.0;
        style.spacing.combo_width = 120.0;
        style.interaction.tooltip_delay = 0.35;
        for (text, size) in [
            (TextStyle::Body, 13.0),
            (TextStyle::Button, 13.0),
            (TextStyle::Small, 11.0),
            (TextStyle::Heading, 15.0),
        ] {
            style.text_styles.insert(text, FontId::proportional(size));
        }
        style
            .text_styles
            .insert(TextStyle::Monospace, FontId::monospace(12.0));
    });
}

/// Colour of a series of a graph.
pub fn series(index: usize) -> Color32 {
    const COLORS: [Color32; 8] = [
        Color32::from_rgb(104, 178, 255),
        Color32::from_rgb(255, 176, 92),
        Color32::from_rgb(120, 210, 140),
        Color32::from_rgb(236, 118, 150),
        Color32::from_rgb(178, 150, 255),
        Color32::from_rgb(240, 220, 110),
        Color32::from_rgb(110, 214, 214),
        Color32::from_rgb(190, 160, 130),
    ];
    COLORS[index % COLORS.len()]
}
