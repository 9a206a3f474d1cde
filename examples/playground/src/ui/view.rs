//! The picture: two halves with a divider, the lights in it, the handles of the selected one, and the camera.

use egui::{Color32, CursorIcon, PointerButton, Pos2, Rect, Response, Sense, Stroke, Ui, pos2, vec2};
use glam::{UVec2, Vec2, Vec3};

use super::theme;
use crate::app::{App, Drag};
use crate::document::Side;
use crate::handles::{Handle, Place, place};
use crate::measures::Measure;
use crate::orbit::Lens;
use crate::overlay::{self, Canvas};

/// Distance from the divider within which it is grabbed, points.
const GRAB: f32 = 6.0;

/// Distance from a light within which it is picked, points.
const PICK: f32 = 11.0;

/// Radians that the camera turns for each point.
const TURN: f32 = 0.006;

impl App {
    pub(super) fn view_panel(&mut self, ui: &mut Ui) {
        let rect = ui.available_rect_before_wrap();
        self.shown.view = rect;
        if self.compare.is_none() {
            ui.centered_and_justified(|ui| {
                ui.label(
                    "Drop a scene (.glb, .gltf) or a shot (.json) here, or open one from the menu File.",
                );
            });
            return;
        }
        let scale = ui.ctx().pixels_per_point();
        let pixels = (rect.size() * scale).round();
        let size = UVec2::new(pixels.x.max(1.0) as u32, pixels.y.max(1.0) as u32);
        let response = ui.interact(rect, ui.id().with("view"), Sense::click_and_drag());
        let lens = self.document.view.map(|view| view.lens(size));
        if let Some(lens) = lens {
            self.pointer(ui, &response, &lens, scale);
        }
        self.fly_keys(ui, &response);
        self.draw(size);
        self.halves(ui, rect);
        // The camera may have moved.
        if let Some(lens) = self.document.view.map(|view| view.lens(size)) {
            self.lines(ui, rect, lens, scale);
            self.marks(ui, rect, &lens, scale);
        }
        self.legends(ui, rect, scale);
        self.divider(ui, rect);
        let refining = self
            .compare
            .as_ref()
            .is_some_and(|compare| compare.truth.is_refining());
        if self.shown.playing || self.shown.times {
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_millis(16));
        } else if refining {
            // The cores are needed by the threads that trace.
            ui.ctx()
                .request_repaint_after(std::time::Duration::from_millis(100));
        }
    }

    /// Draws each half clipped to its part of the view.
    fn halves(&self, ui: &Ui, rect: Rect) {
        let middle = rect.left() + rect.width() * self.shown.divider;
        let parts = [
            Rect::from_min_max(rect.min, pos2(middle, rect.bottom())),
            Rect::from_min_max(pos2(middle, rect.top()), rect.max),
        ];
        let whole = Rect::from_min_max(Pos2::ZERO, pos2(1.0, 1.0));
        for (show, part) in self.shown.panes.into_iter().zip(parts) {
            let painter = ui.painter().with_clip_rect(part.intersect(ui.clip_rect()));
            let is_known = self
                .compare
                .as_ref()
                .is_some_and(|compare| compare.is_known(show));
            match self.images[show as usize].filter(|_| is_known) {
                Some((_, id)) => {
                    painter.image(id, rect, whole, Color32::WHITE);
                }
                None => {
                    painter.rect_filled(part, 0.0, theme::BEHIND);
                    let text = if show.needs_light() && self.shown.selected.is_none() {
                        "Select a light."
                    } else if show.measure().is_some() {
                        "The light's technique looks up no map here."
                    } else if self.shown.playing {
                        "The truth waits until the animation stops."
                    } else {
                        "Tracing the truth…"
                    };
                    let font = egui::FontId::proportional(13.0);
                    painter.text(part.center(), egui::Align2::CENTER_CENTER, text, font, theme::DIM);
                }
            }
        }
    }

    fn divider(&mut self, ui: &mut Ui, rect: Rect) {
        let middle = rect.left() + rect.width() * self.shown.divider;
        let bar = Rect::from_center_size(pos2(middle, rect.center().y), vec2(2.0 * GRAB, rect.height()));
        let response = ui.interact(bar.intersect(rect), ui.id().with("divider"), Sense::drag());
        if response.dragged()
            && let Some(at) = response.interact_pointer_pos()
        {
            self.shown.divider = ((at.x - rect.left()) / rect.width().max(1.0)).clamp(0.0, 1.0);
        }
        if response.hovered() || response.dragged() {
            ui.ctx().set_cursor_icon(CursorIcon::ResizeHorizontal);
        }
        let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
        let middle = rect.left() + rect.width() * self.shown.divider;
        let stroke = Stroke::new(if response.hovered() { 3.0 } else { 1.5 }, Color32::WHITE);
        painter.line_segment([pos2(middle, rect.top()), pos2(middle, rect.bottom())], stroke);
        let knob = pos2(middle, rect.bottom() - 26.0);
        painter.circle(
            knob,
            9.0,
            Color32::from_rgb(40, 43, 50),
            Stroke::new(1.5, Color32::WHITE),
        );
        let arrows = [[-3.0, -5.5], [3.0, 5.5]];
        for [near, far] in arrows {
            for y in [-3.0, 3.0] {
                let stroke = Stroke::new(1.5, Color32::WHITE);
                painter.line_segment([knob + vec2(near, y), knob + vec2(far, 0.0)], stroke);
            }
        }
        let captions = [
            (0, egui::Align2::RIGHT_TOP, -8.0),
            (1, egui::Align2::LEFT_TOP, 8.0),
        ];
        for (half, align, offset) in captions {
            self.caption(&painter, half, align, pos2(middle + offset, rect.top() + 8.0));
        }
    }

    /// Names what a half shows, with the technique of the selected light.
    fn caption(&self, painter: &egui::Painter, half: usize, align: egui::Align2, at: Pos2) {
        let show = self.shown.panes[half];
        let technique = show.side().zip(self.selected_light());
        let technique = technique.filter(|_| show.measure() != Some(Measure::Lights));
        let technique = technique.map(|(side, light)| crate::schema::label(light.technique(side)));
        let mut text = match technique {
            Some(technique) => format!("{} · {technique}", show.name()),
            None => show.name().to_owned(),
        };
        if show.needs_truth()
            && let Some(answer) = self.compare.as_ref().and_then(|compare| compare.truth.answer())
        {
            text += &format!(" · {} samples", answer.samples);
        }
        let color = match show.side() {
            Some(Side::A) => theme::A,
            Some(Side::B) => theme::B,
            None => Color32::WHITE,
        };
        let galley = painter.layout_no_wrap(text, egui::FontId::proportional(13.0), color);
        let rect = align.anchor_size(at, galley.size());
        painter.rect_filled(rect.expand2(vec2(6.0, 3.0)), 4.0, Color32::from_black_alpha(150));
        painter.galley(rect.min, galley, color);
    }

    fn lines(&mut self, ui: &Ui, rect: Rect, lens: Lens, pixels_per_point: f32) {
        let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
        let selected = self.shown.selected;
        let side = self
            .shown
            .panes
            .iter()
            .find_map(|pane| pane.side())
            .unwrap_or(Side::A);
        let Some(compare) = &mut self.compare else { return };
        let Some(stage) = &mut compare.sides[side.index()] else {
            return;
        };
        let canvas = Canvas {
            painter: &painter,
            rect,
            pixels_per_point,
            lens,
        };
        for &shown in &self.shown.overlays {
            overlay::draw(shown, &canvas, stage, selected);
        }
    }

    /// Draws the lights and the handles of the selected one.
    fn marks(&self, ui: &Ui, rect: Rect, lens: &Lens, scale: f32) {
        let painter = ui.painter().with_clip_rect(rect.intersect(ui.clip_rect()));
        let at = |pixel: Vec2| rect.min + vec2(pixel.x, pixel.y) / scale;
        for (index, light) in self.document.lights().iter().enumerate() {
            let place = place(light, self.bounds);
            let Some(pixel) = lens.pixel(place.position) else {
                continue;
            };
            let is_selected = self.shown.selected == Some(index);
            if is_selected {
                self.draw_handles(&painter, &place, lens, &at);
            }
            let color = light.vector("color").unwrap_or(Vec3::ONE);
            let color = color / color.max_element().max(1e-3) * 255.0;
            let fill = Color32::from_rgb(color.x as u8, color.y as u8, color.z as u8);
            let rim = if is_selected {
                Color32::WHITE
            } else {
                Color32::from_black_alpha(190)
            };
            painter.circle(
                at(pixel),
                if is_selected { 6.5 } else { 5.0 },
                fill,
                Stroke::new(2.0, rim),
            );
        }
    }

    fn draw_handles(&self, painter: &egui::Painter, place: &Place, lens: &Lens, at: &dyn Fn(Vec2) -> Pos2) {
        let colors = [
            Color32::from_rgb(240, 90, 90),
            Color32::from_rgb(130, 220, 90),
            Color32::from_rgb(90, 150, 255),
        ];
        let Some(start) = lens.pixel(place.position) else {
            return;
        };
        let held = self.shown.drag.map(|drag| drag.handle);
        for handle in place.handles() {
            let Some(end) = place.end(handle, lens) else {
                continue;
            };
            let is_held = held == Some(handle);
            let color = match handle {
                _ if is_held => Color32::WHITE,
                Handle::Axis(axis) => colors[axis],
                Handle::Direction => Color32::from_rgb(250, 220, 110),
                Handle::Plane => continue,
            };
            painter.line_segment(
                [at(start), at(end)],
                Stroke::new(if is_held { 3.0 } else { 2.0 }, color),
            );
            painter.circle_filled(at(end), 4.5, color);
        }
    }

    /// Picks and drags lights, and moves the camera.
    fn pointer(&mut self, ui: &Ui, response: &Response, lens: &Lens, scale: f32) {
        let pixel = |at: Pos2| {
            let offset = (at - response.rect.min) * scale;
            Vec2::new(offset.x, offset.y)
        };
        let pointer = response.interact_pointer_pos();
        if response.drag_started_by(PointerButton::Primary)
            && let Some(at) = ui.input(|input| input.pointer.press_origin())
        {
            let handle = self
                .selected_light()
                .and_then(|light| place(light, self.bounds).pick(pixel(at), lens));
            self.shown.drag = handle.map(|handle| Drag {
                handle,
                from: pixel(at),
            });
            if handle.is_none()
                && let Some(light) = self.light_at(pixel(at), lens, scale)
            {
                self.shown.selected = Some(light);
                self.shown.drag = Some(Drag {
                    handle: Handle::Plane,
                    from: pixel(at),
                });
            }
        }
        if response.clicked()
            && let Some(at) = pointer
            && let Some(light) = self.light_at(pixel(at), lens, scale)
        {
            self.shown.selected = Some(light);
        }
        if response.dragged_by(PointerButton::Primary) {
            match (self.shown.drag, pointer) {
                (Some(drag), Some(at)) => self.drag_light(drag, pixel(at), lens),
                (None, _) => self.turn(response.drag_delta(), |view, by| view.orbit(by)),
                _ => {}
            }
        }
        if response.drag_stopped() {
            self.shown.drag = None;
            self.history.close();
        }
        if response.dragged_by(PointerButton::Secondary) {
            self.turn(response.drag_delta(), |view, by| view.look(by));
        }
        if response.dragged_by(PointerButton::Middle)
            && let Some(view) = &mut self.document.view
        {
            let delta = response.drag_delta() * scale * lens.metres_per_pixel(view.target);
            view.fly(Vec3::new(-delta.x, delta.y, 0.0));
        }
        let lines = ui.input(|input| input.smooth_scroll_delta.y);
        if response.hovered()
            && lines != 0.0
            && let Some(view) = &mut self.document.view
        {
            view.dolly((-lines * 0.002).exp());
        }
    }

    fn turn(&mut self, delta: egui::Vec2, turn: impl FnOnce(&mut crate::document::Eye, Vec2)) {
        if let Some(view) = &mut self.document.view {
            turn(view, Vec2::new(-delta.x, delta.y) * TURN);
        }
    }

    /// Returns the light at a pixel, the nearest to the pointer.
    fn light_at(&self, pixel: Vec2, lens: &Lens, scale: f32) -> Option<usize> {
        let lights = self.document.lights().iter().enumerate();
        let near = lights.filter_map(|(index, light)| {
            let at = lens.pixel(place(light, self.bounds).position)?;
            let distance = at.distance(pixel);
            (distance < PICK * scale).then_some((index, distance))
        });
        near.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(index, _)| index)
    }

    fn drag_light(&mut self, drag: Drag, to: Vec2, lens: &Lens) {
        let Some(index) = self.shown.selected else { return };
        let Some(light) = self.selected_light() else {
            return;
        };
        let before = place(light, self.bounds);
        let after = before.dragged(drag.handle, drag.from, to, lens);
        self.change_light("move", index, |light| {
            if after.has_position && after.position != before.position {
                light.set_position(after.position);
            }
            if let Some(direction) = after.direction.filter(|_| after.direction != before.direction) {
                light.set_direction(direction);
            }
        });
        self.shown.drag = Some(Drag { from: to, ..drag });
    }

    fn fly_keys(&mut self, ui: &Ui, response: &Response) {
        if !response.hovered() || ui.memory(|memory| memory.focused().is_some()) {
            return;
        }
        let (held, seconds) = ui.input(|input| {
            let down = |key: egui::Key| f32::from(u8::from(input.key_down(key) && !input.modifiers.command));
            let by = Vec3::new(
                down(egui::Key::D) - down(egui::Key::A),
                down(egui::Key::E) - down(egui::Key::Q),
                down(egui::Key::W) - down(egui::Key::S),
            );
            let faster = if input.modifiers.shift { 4.0 } else { 1.0 };
            (by * faster, input.stable_dt.min(0.1))
        });
        if held != Vec3::ZERO {
            let speed = (self.bounds.1 * 0.35).clamp(0.2, 20.0);
            if let Some(view) = &mut self.document.view {
                view.fly(held * speed * seconds);
            }
            ui.ctx().request_repaint();
        }
    }
}
