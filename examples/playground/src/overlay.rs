//! Lines over the picture: what the systems computed for the selected light, and how its technique shadows it.

use antumbra::debug_lines::{DebugLines, DebugSubject, draw_debug_lines};
use antumbra::prelude::*;
use antumbra::techniques::Techniques;
use bevy_ecs::prelude::*;
use egui::{Color32, Painter, Pos2, Rect, Stroke};
use glam::{UVec2, Vec2, Vec3};
use serde::Deserialize;

use crate::orbit::Lens;
use crate::side::SideStage;

/// Lines that can be drawn over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(untagged)]
pub enum Overlay {
    /// Lines that every technique has.
    Subject(DebugSubject),
    /// Lines of the selected light's technique.
    Technique(TechniqueLines),
}

/// The name of [`Overlay::Technique`] in scripts.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TechniqueLines {
    /// Its one value.
    Technique,
}

impl Overlay {
    /// All overlays.
    pub const ALL: [Self; DebugSubject::ALL.len() + 1] = {
        let mut all = [Self::Technique(TechniqueLines::Technique); DebugSubject::ALL.len() + 1];
        let mut index = 0;
        while index < DebugSubject::ALL.len() {
            all[index] = Self::Subject(DebugSubject::ALL[index]);
            index += 1;
        }
        all
    };

    /// Name and meaning.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Subject(subject) => (subject.label(), subject.help()),
            Self::Technique(_) => (
                "Technique",
                "What the technique of the selected light draws: shadow volumes, the shells of wedges, faces and \
                 cascades of maps, slices of occlusion textures.",
            ),
        }
    }
}

/// A view that lines are drawn over.
pub struct Canvas<'a> {
    /// Draws within the view.
    pub painter: &'a Painter,
    /// The view, points.
    pub rect: Rect,
    /// Pixels of the picture for each point.
    pub pixels_per_point: f32,
    /// Projection of the view.
    pub lens: Lens,
}

impl Canvas<'_> {
    /// Returns the place of a pixel of the picture.
    pub fn at(&self, pixel: Vec2) -> Pos2 {
        let point = pixel / self.pixels_per_point;
        self.rect.min + egui::vec2(point.x, point.y)
    }

    /// Draws a line of the scene.
    pub fn line(&self, a: Vec3, b: Vec3, stroke: Stroke) {
        if let Some([a, b]) = self.lens.segment(a, b) {
            self.painter.line_segment([self.at(a), self.at(b)], stroke);
        }
    }
}

/// Draws an overlay of a side's light.
pub fn draw(overlay: Overlay, canvas: &Canvas, side: &mut SideStage, light: Option<usize>) {
    let index = light.and_then(|light| side.stage.light_indices().get(light).copied().flatten());
    let world = &side.stage.world;
    let mut lines = DebugLines::default();
    match (overlay, index) {
        (Overlay::Subject(DebugSubject::Region), _) => scissor(canvas, world, index),
        (Overlay::Subject(subject), _) => draw_debug_lines(subject, world, index, &mut lines),
        (Overlay::Technique(_), Some(index)) => {
            world
                .resource::<Techniques>()
                .debug_lines(world, index, &mut lines);
        }
        (Overlay::Technique(_), None) => {}
    }
    for line in lines.lines() {
        let [red, green, blue] = line.color;
        let stroke = Stroke::new(1.0, Color32::from_rgb(red, green, blue));
        canvas.line(line.ends[0], line.ends[1], stroke);
    }
}

fn scissor(canvas: &Canvas, world: &World, light: Option<usize>) {
    let Some(light) = light.map(|light| &world.resource::<FrameLights>().lights[light]) else {
        return;
    };
    let Some(scissor) = light.region.scissor else {
        return;
    };
    let at = |x: u32, y: u32| canvas.at(UVec2::new(x, y).as_vec2());
    let rect = Rect::from_min_max(
        at(scissor.x, scissor.y),
        at(scissor.x + scissor.width, scissor.y + scissor.height),
    );
    let stroke = Stroke::new(1.5, Color32::from_rgb(250, 160, 60));
    canvas
        .painter
        .rect_stroke(rect.shrink(1.0), 0.0, stroke, egui::StrokeKind::Inside);
}
