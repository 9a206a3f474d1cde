//! Lines over the picture: what the sets of the selected light hold, its silhouettes, its scissor and its reach.

use antumbra::prelude::*;
use antumbra::sets::{FrustumSet, Objects, VisibleSet};
use antumbra::silhouettes::{CasterShape, Silhouettes};
use bevy_ecs::prelude::*;
use egui::{Color32, Painter, Pos2, Rect, Stroke};
use glam::{UVec2, Vec2, Vec3};
use serde::Deserialize;

use crate::orbit::Lens;
use crate::side::SideStage;

/// Lines that can be drawn over the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Overlay {
    /// Boxes of all objects, coloured by the smallest set of the selected light that holds them.
    Sets,
    /// The silhouette edges that the selected light's technique uses.
    Silhouettes,
    /// The part of the picture that the selected light can change.
    Scissor,
    /// Range, cone and extent of the selected light.
    Reach,
}

impl Overlay {
    /// All overlays.
    pub const ALL: [Self; 4] = [Self::Sets, Self::Silhouettes, Self::Scissor, Self::Reach];

    /// Name and meaning.
    pub fn text(self) -> (&'static str, &'static str) {
        match self {
            Self::Sets => (
                "Sets",
                "Boxes of all objects, coloured by the sets of the selected light: red casts (S), yellow is lit (I), \
                 blue is in its reach (L), white is seen (V), dark grey is in the frustum but hidden (F).",
            ),
            Self::Silhouettes => (
                "Silhouettes",
                "The silhouette edges of the casters of the selected light, for techniques that use them.",
            ),
            Self::Scissor => (
                "Scissor",
                "The rectangle outside of which the selected light changes no pixel.",
            ),
            Self::Reach => ("Reach", "Range, cone and extent of the selected light."),
        }
    }
}

/// Edges that are drawn at most: more would be a blot.
const MOST_EDGES: usize = 20_000;

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

    fn circle(&self, center: Vec3, axes: [Vec3; 2], stroke: Stroke) {
        const STEPS: usize = 48;
        let point = |step: usize| {
            let (sin, cos) = (step as f32 / STEPS as f32 * std::f32::consts::TAU).sin_cos();
            center + axes[0] * cos + axes[1] * sin
        };
        (0..STEPS).for_each(|step| self.line(point(step), point(step + 1), stroke));
    }
}

/// Draws an overlay of a side's light.
pub fn draw(overlay: Overlay, canvas: &Canvas, side: &mut SideStage, light: Option<usize>) {
    let index = light.and_then(|light| side.stage.light_indices().get(light).copied().flatten());
    match overlay {
        Overlay::Sets => sets(canvas, &side.stage.world, index),
        Overlay::Silhouettes => silhouettes(canvas, &mut side.stage.world, index),
        Overlay::Scissor => scissor(canvas, &side.stage.world, index),
        Overlay::Reach => reach(canvas, &side.stage.world, index),
    }
}

fn sets(canvas: &Canvas, world: &World, light: Option<usize>) {
    let objects = world.resource::<Objects>();
    let light = light.map(|light| &world.resource::<FrameLights>().lights[light].sets);
    let (f, v) = (world.resource::<FrustumSet>(), world.resource::<VisibleSet>());
    for (index, entity) in objects.entities.iter().enumerate() {
        let Some(bounds) = world.get::<antumbra::scene::WorldBounds>(*entity) else {
            continue;
        };
        let color = match light {
            Some(sets) if sets.s.contains(index) => Color32::from_rgb(240, 90, 80),
            Some(sets) if sets.i.contains(index) => Color32::from_rgb(250, 210, 90),
            Some(sets) if sets.l.contains(index) => Color32::from_rgb(90, 150, 250),
            _ if v.set.contains(index) => Color32::from_gray(220),
            _ if f.set.contains(index) => Color32::from_gray(90),
            _ => continue,
        };
        let (min, max) = (bounds.0.min, bounds.0.max);
        if !(min.is_finite() && max.is_finite()) {
            continue;
        }
        let corner = |bits: usize| {
            let pick = |axis: usize| {
                if bits >> axis & 1 == 0 {
                    min[axis]
                } else {
                    max[axis]
                }
            };
            Vec3::new(pick(0), pick(1), pick(2))
        };
        for bits in 0..8_usize {
            for axis in (0..3).filter(|axis| bits >> axis & 1 == 0) {
                canvas.line(corner(bits), corner(bits | 1 << axis), Stroke::new(1.0, color));
            }
        }
    }
}

fn silhouettes(canvas: &Canvas, world: &mut World, light: Option<usize>) {
    let Some(light) = light.map(|light| world.resource::<FrameLights>().lights[light].entity) else {
        return;
    };
    let mut shapes = world.query::<CasterShape>();
    let Some(known) = world.resource::<Silhouettes>().of_light(light) else {
        return;
    };
    let stroke = Stroke::new(1.5, Color32::from_rgb(110, 230, 160));
    let mut left = MOST_EDGES;
    let casters = known.slots.iter().filter(|slot| slot.revision != 0);
    for slot in casters {
        let Ok(shape) = shapes.get(world, slot.entity) else {
            continue;
        };
        let Some(world_from_local) = shape.world_from_local() else {
            continue;
        };
        let positions = shape.positions();
        let place = |vertex: u32| -> Option<Vec3> {
            let local = positions.get(vertex as usize)?;
            Some(world_from_local.transform_point3(local.as_dvec3()).as_vec3())
        };
        for [a, b] in slot.contour.all_edges().take(left) {
            left -= 1;
            if let (Some(a), Some(b)) = (place(a), place(b)) {
                canvas.line(a, b, stroke);
            }
        }
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

fn reach(canvas: &Canvas, world: &World, light: Option<usize>) {
    let Some(light) = light.map(|light| &world.resource::<FrameLights>().lights[light]) else {
        return;
    };
    let stroke = Stroke::new(1.0, Color32::from_rgba_unmultiplied(250, 220, 120, 140));
    let affine = light.world_from_light.affine();
    let at = Vec3::from(affine.translation);
    let [x, y, z] = [0, 1, 2].map(|axis| Vec3::from(affine.matrix3.col(axis)).normalize_or_zero());
    let range = light.light.range;
    match light.light.kind {
        LightKind::Point | LightKind::Sphere { .. } if range.is_finite() => {
            for axes in [[x, y], [y, z], [z, x]] {
                canvas.circle(at, axes.map(|axis| axis * range), stroke);
            }
        }
        LightKind::Spot { outer_angle, .. } => {
            let depth = if range.is_finite() {
                range * outer_angle.cos()
            } else {
                3.0
            };
            let radius = depth * outer_angle.tan().min(50.0);
            let end = at - z * depth;
            canvas.circle(end, [x * radius, y * radius], stroke);
            for side in [x, -x, y, -y] {
                canvas.line(at, end + side * radius, stroke);
            }
        }
        _ => {}
    }
    match light.light.kind {
        LightKind::Sphere { radius } => {
            for axes in [[x, y], [y, z], [z, x]] {
                canvas.circle(at, axes.map(|axis| axis * radius), stroke);
            }
        }
        LightKind::Rect { width, height } => {
            let (x, y) = (x * width * 0.5, y * height * 0.5);
            let corners = [x + y, y - x, -x - y, x - y].map(|corner| at + corner);
            (0..4).for_each(|side| canvas.line(corners[side], corners[(side + 1) % 4], stroke));
        }
        _ => {}
    }
}
