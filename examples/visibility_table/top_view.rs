//! The sets of one light, seen from above: five panels, one for each set.
//!
//! Members are filled with the colour of their panel, but floors and ceilings of the whole scene are only outlined
//! with it. All other objects are outlined in grey. White lines are the edges of the view frustum. The yellow disc is
//! the light, and the yellow ring is its range.

use std::path::Path;

use antumbra::geometry::Aabb;
use antumbra::sets::{FrameLights, FrustumSet, Objects, View, VisibleSet};
use fixedbitset::FixedBitSet;
use glam::{DVec2, UVec2, Vec2};

use crate::support::picture::write_png;
use crate::support::table::{Walked, rows};

const PANEL: u32 = 420;
const MARGIN: f32 = 14.0;
const CAPTION: u32 = 48;

/// Objects that cover more than this share of the scene are only outlined, because they would hide the others.
const GROUND: f32 = 0.2;

type Rgb = [u8; 3];

const PANELS: [(char, Rgb); 5] = [
    ('F', [150, 150, 165]),
    ('V', [70, 150, 255]),
    ('L', [255, 170, 40]),
    ('I', [80, 210, 90]),
    ('S', [225, 60, 170]),
];

/// Rows of the five letters, five bits for each row.
fn letter(letter: char) -> [u8; 7] {
    match letter {
        'F' => [0x1f, 0x10, 0x10, 0x1e, 0x10, 0x10, 0x10],
        'V' => [0x11, 0x11, 0x11, 0x11, 0x11, 0x0a, 0x04],
        'L' => [0x10, 0x10, 0x10, 0x10, 0x10, 0x10, 0x1f],
        'I' => [0x0e, 0x04, 0x04, 0x04, 0x04, 0x04, 0x0e],
        _ => [0x0f, 0x10, 0x10, 0x0e, 0x01, 0x01, 0x1e],
    }
}

struct Canvas {
    size: UVec2,
    rgba: Vec<u8>,
}

impl Canvas {
    fn new(size: UVec2) -> Self {
        let background = [24, 25, 30, 255];
        Self {
            size,
            rgba: background.repeat(size.element_product() as usize),
        }
    }

    /// Mixes a colour over a pixel. Does nothing outside the picture.
    fn blend(&mut self, x: i64, y: i64, color: Rgb, alpha: f32) {
        if x < 0 || y < 0 || x >= i64::from(self.size.x) || y >= i64::from(self.size.y) {
            return;
        }
        let at = 4 * (y as usize * self.size.x as usize + x as usize);
        for (channel, color) in self.rgba[at..at + 3].iter_mut().zip(color) {
            *channel = (f32::from(*channel) * (1.0 - alpha) + f32::from(color) * alpha) as u8;
        }
    }
}

/// One panel: its place in the picture, and the mapping from the world to it.
struct Panel {
    left: f32,
    min: Vec2,
    scale: f32,
}

impl Panel {
    fn pixel(&self, x: f32, z: f32) -> Vec2 {
        let at = (Vec2::new(x, z) - self.min) * self.scale + MARGIN;
        at + Vec2::new(self.left, CAPTION as f32)
    }

    fn holds(&self, x: i64, y: i64) -> bool {
        (x as f32) >= self.left && (x as f32) < self.left + PANEL as f32 && y >= i64::from(CAPTION)
    }

    fn rectangle(&self, canvas: &mut Canvas, aabb: &Aabb, color: Rgb, filled: bool) {
        let (a, b) = (
            self.pixel(aabb.min.x, aabb.min.z),
            self.pixel(aabb.max.x, aabb.max.z),
        );
        let ([x0, y0], [x1, y1]) = ([a.x as i64, a.y as i64], [b.x as i64, b.y as i64]);
        for y in y0..=y1 {
            for x in x0..=x1 {
                let rim = x == x0 || x == x1 || y == y0 || y == y1;
                if (rim || filled) && self.holds(x, y) {
                    canvas.blend(x, y, color, if rim { 0.9 } else { 0.45 });
                }
            }
        }
    }

    fn line(&self, canvas: &mut Canvas, from: Vec2, to: Vec2, color: Rgb) {
        let steps = ((to - from).length() as usize).min(4000) + 1;
        for step in 0..=steps {
            let at = from.lerp(to, step as f32 / steps as f32);
            if self.holds(at.x as i64, at.y as i64) {
                canvas.blend(at.x as i64, at.y as i64, color, 0.9);
            }
        }
    }

    fn ring(&self, canvas: &mut Canvas, center: Vec2, radius: f32, color: Rgb) {
        for step in 0..720 {
            let turn = Vec2::from_angle(step as f32 * 0.5f32.to_radians());
            let next = Vec2::from_angle((step + 1) as f32 * 0.5f32.to_radians());
            self.line(canvas, center + turn * radius, center + next * radius, color);
        }
    }
}

/// Draws the sets of a light in a frame of a walk, with everything switched on. A scene without lights has none to draw,
/// which is told.
///
/// # Errors
/// One line that names the file, or the light that does not exist.
pub fn write(walked: &mut Walked, frame: usize, light: Option<usize>, path: &Path) -> Result<(), String> {
    walked.set_row(&rows()[4]);
    walked.set_view(frame);
    let stage = &mut walked.stage;
    stage.run();
    let bounds = stage.scene_bounds();
    let indices = stage.light_indices();
    let world = &stage.world;
    let lights = &world.resource::<FrameLights>().lights;
    let lit_most = || {
        let rank = |index: &usize| {
            let light = &lights[*index];
            (
                light.point_world.w != 0.0,
                light.sets.i.count_ones(..),
                std::cmp::Reverse(*index),
            )
        };
        (0..lights.len())
            .filter(|index| !lights[*index].is_skipped())
            .max_by_key(rank)
    };
    let index = match light {
        Some(light) => indices.get(light).copied().flatten().ok_or_else(|| {
            format!(
                "{}: --light {light}: the scene has {} lights",
                path.display(),
                indices.len()
            )
        })?,
        None => match lit_most().or((!lights.is_empty()).then_some(0)) {
            Some(index) => index,
            None => {
                eprintln!(
                    "{}: not written, because no light shines in the scene",
                    path.display()
                );
                return Ok(());
            }
        },
    };
    let light = &lights[index];
    let objects = world.resource::<Objects>();
    let sets: [&FixedBitSet; 5] = [
        &world.resource::<FrustumSet>().set,
        &world.resource::<VisibleSet>().set,
        &light.sets.l,
        &light.sets.i,
        &light.sets.s,
    ];
    let size = (bounds.max - bounds.min).max(glam::Vec3::splat(1e-3));
    let scale = (PANEL as f32 - 2.0 * MARGIN) / size.x.max(size.z * 0.5);
    let height = (size.z * scale + 2.0 * MARGIN) as u32 + CAPTION;
    let mut canvas = Canvas::new(UVec2::new(PANEL * 5, height));
    for (at, ((name, color), set)) in PANELS.into_iter().zip(sets).enumerate() {
        let panel = Panel {
            left: at as f32 * PANEL as f32,
            min: Vec2::new(bounds.min.x, bounds.min.z),
            scale,
        };
        for object in 0..objects.len() {
            let outline = if set.contains(object) { color } else { [66, 69, 80] };
            let aabb = objects.boxes.get(object);
            let side = (aabb.max - aabb.min) / size;
            let is_ground = side.x * side.z > GROUND;
            panel.rectangle(&mut canvas, &aabb, outline, set.contains(object) && !is_ground);
        }
        if let Some(view) = &world.resource::<View>().data {
            let eye = panel.pixel(view.eye.x as f32, view.eye.z as f32);
            for side in 0..4 {
                let ray = view.frustum.corners[4 + side];
                let flat = DVec2::new(f64::from(ray.x), f64::from(ray.z))
                    .normalize_or_zero()
                    .as_vec2();
                panel.line(&mut canvas, eye, eye + flat * PANEL as f32 * 1.5, [255, 255, 255]);
            }
        }
        if light.point_world.w != 0.0 {
            let center = panel.pixel(light.point_world.x as f32, light.point_world.z as f32);
            (0..6).for_each(|radius| panel.ring(&mut canvas, center, radius as f32, [255, 235, 60]));
            if light.light.range.is_finite() {
                panel.ring(&mut canvas, center, light.light.range * scale, [255, 235, 60]);
            }
        }
        caption(
            &mut canvas,
            &panel,
            name,
            color,
            set.count_ones(..) as f32 / objects.len().max(1) as f32,
        );
    }
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    write_png(path, canvas.size, &canvas.rgba)?;
    let [f, v, l, i, s] = sets.map(|set| set.count_ones(..));
    eprintln!(
        "{}: frame {frame}, light {index}: |F| {f}, |V| {v}, |L| {l}, |I| {i}, |S| {s} of {} objects",
        path.display(),
        objects.len()
    );
    Ok(())
}

/// Draws the set's letter, and a bar whose length is the set's share of all objects.
fn caption(canvas: &mut Canvas, panel: &Panel, name: char, color: Rgb, share: f32) {
    const DOT: i64 = 4;
    let left = panel.left as i64 + 16;
    for (row, bits) in letter(name).into_iter().enumerate() {
        for column in (0..5).filter(|column| bits >> (4 - column) & 1 != 0) {
            for dot in 0..DOT * DOT {
                let (x, y) = (column * DOT + dot % DOT, row as i64 * DOT + dot / DOT);
                canvas.blend(left + x, 10 + y, color, 1.0);
            }
        }
    }
    let width = (PANEL as f32 - 80.0) as i64;
    for x in 0..width {
        for y in 20..28 {
            let filled = (x as f32) < share * width as f32;
            canvas.blend(left + 40 + x, y, if filled { color } else { [52, 54, 62] }, 1.0);
        }
    }
}
