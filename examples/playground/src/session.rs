//! The playground without a window: frames are drawn into a texture, and the input comes from a script.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use antumbra::prelude::*;
use antumbra::reference::SoftError;
use antumbra::techniques::Techniques;
use antumbra_stage::stage::one_line;
use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};
use glam::{UVec2, Vec2, Vec3};
use serde_json::{Map, Value, json};

use crate::app::{App, write_texture};
use crate::command::Command;
use crate::compare::Show;
use crate::document::Side;
use crate::handles::place;
use crate::ui::theme;

/// Format of the texture that stands for the window.
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Unorm;

/// Seconds of a frame of a script, by which animations advance.
const FRAME: f32 = 1.0 / 60.0;

/// The longest wait for the truth.
const PATIENCE: Duration = Duration::from_secs(600);

/// The largest window of a script, pixels on a side: that of WebGPU's baseline.
const LARGEST: u32 = 8192;

/// A playground that a script drives.
pub struct Session {
    /// The playground.
    pub app: App,
    context: egui::Context,
    size: UVec2,
    scale: f32,
    out: PathBuf,
    events: Vec<Event>,
    dropped: Vec<egui::DroppedFile>,
    pointer: Pos2,
    frames: u64,
    window: Option<wgpu::Texture>,
    texts: Vec<(String, Rect)>,
}

impl std::fmt::Debug for Session {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Session")
            .field("app", &self.app)
            .finish_non_exhaustive()
    }
}

/// Makes a device without a window.
///
/// # Errors
/// One line that says what to install.
pub fn headless_context() -> Result<RenderContext, String> {
    let requested = RequestedFeatures {
        timestamps: true,
        ..Default::default()
    };
    pollster::block_on(RenderContext::headless(requested)).map_err(|error| one_line(&error))
}

impl Session {
    /// Starts a playground with a window of a size, pixels.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn new(
        render: RenderContext,
        techniques: Techniques,
        size: UVec2,
        out: &Path,
    ) -> Result<Self, String> {
        let context = egui::Context::default();
        theme::apply(&context);
        Ok(Self {
            app: App::new(render, FORMAT, techniques, out.to_owned())?,
            context,
            size,
            scale: 1.0,
            out: out.to_owned(),
            events: Vec::new(),
            dropped: Vec::new(),
            pointer: Pos2::ZERO,
            frames: 0,
            window: None,
            texts: Vec::new(),
        })
    }

    /// Runs a script: a command in each line, as JSON. Empty lines and those that begin with `#` are skipped.
    ///
    /// # Errors
    /// One line that names the line of the script and what is wrong.
    pub fn run_script(&mut self, text: &str) -> Result<(), String> {
        for (index, line) in text.lines().enumerate() {
            let line = line.trim();
            if line.is_empty() || line.starts_with('#') {
                continue;
            }
            let number = index + 1;
            let command: Command =
                serde_json::from_str(line).map_err(|error| format!("line {number}: {error}"))?;
            self.run(command)
                .map_err(|error| format!("line {number}: {error}"))?;
        }
        Ok(())
    }

    /// Draws a frame.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn frame(&mut self) -> Result<(), String> {
        if self.app.gpu.context.notice_loss() {
            self.app.revive(headless_context()?, FORMAT)?;
            // What egui has on the old device is made anew.
            self.context = egui::Context::default();
            theme::apply(&self.context);
            self.window = None;
        }
        self.app.advance(FRAME);
        let points = vec2(self.size.x as f32, self.size.y as f32) / self.scale;
        let device = self.app.gpu.context.device.clone();
        let mut input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, points)),
            time: Some(self.frames as f64 * f64::from(FRAME)),
            predicted_dt: FRAME,
            max_texture_side: Some(device.limits().max_texture_dimension_2d as usize),
            events: std::mem::take(&mut self.events),
            dropped_files: std::mem::take(&mut self.dropped),
            focused: true,
            ..Default::default()
        };
        if let Some(viewport) = input.viewports.get_mut(&egui::ViewportId::ROOT) {
            viewport.native_pixels_per_point = Some(self.scale);
        }
        self.frames += 1;
        let app = &mut self.app;
        let output = self.context.run_ui(input, |ui| app.ui(ui));
        self.texts.clear();
        for clipped in &output.shapes {
            texts_of(&clipped.shape, clipped.clip_rect, &mut self.texts);
        }
        let primitives = self.context.tessellate(output.shapes, output.pixels_per_point);
        let size = self.size.max(UVec2::ONE);
        let window = self.window.take().filter(|window| {
            let known = window.size();
            (known.width, known.height) == (size.x, size.y)
        });
        let window = match window {
            Some(window) => window,
            None => {
                let context = &self.app.gpu.context;
                antumbra::render::create_target(context, "window", size, FORMAT)
                    .map_err(|error| one_line(&error))?
            }
        };
        let view = window.create_view(&Default::default());
        self.app.painter.paint(
            &view,
            size,
            output.pixels_per_point,
            &primitives,
            &output.textures_delta,
        );
        self.window = Some(window);
        Ok(())
    }

    /// Returns the pixels of the window, sRGB RGBA.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn pixels(&self) -> Result<Vec<u8>, String> {
        let window = self.window.as_ref().ok_or("no frame was drawn")?;
        let all = wgpu::TextureAspect::All;
        let rows = antumbra::render::readback::read_texture(&self.app.gpu.context, window, all, "window");
        rows.map(|rows| rows.bytes).map_err(|error| one_line(&error))
    }

    /// Returns the pixels of a half's picture, sRGB RGBA.
    ///
    /// # Errors
    /// One line that says that it is not shown, or what the device refuses.
    pub fn picture(&self, show: Show) -> Result<(UVec2, Vec<u8>), String> {
        let compare = self.app.compare.as_ref().ok_or("there is no scene")?;
        let target = compare.targets[show as usize]
            .as_ref()
            .ok_or_else(|| format!("{} is not shown", show.name()))?;
        let all = wgpu::TextureAspect::All;
        let context = &self.app.gpu.context;
        let rows = antumbra::render::readback::read_texture(context, &target.texture, all, "picture");
        rows.map(|rows| (target.size, rows.bytes))
            .map_err(|error| one_line(&error))
    }

    /// Does what a command says, and draws a frame.
    ///
    /// # Errors
    /// One line that says what cannot be done.
    pub fn run(&mut self, command: Command) -> Result<(), String> {
        match command {
            Command::Frames { count } => (0..count).try_for_each(|_| self.frame()),
            Command::Truth { samples } => self.refine(samples),
            Command::Hold { key, frames } => {
                let key = key_of(&key)?;
                self.key(key, true, Modifiers::NONE);
                (0..frames).try_for_each(|_| self.frame())?;
                self.key(key, false, Modifiers::NONE);
                self.frame()
            }
            Command::Click { text } => {
                let place = self.place_of(&text);
                let place = place.ok_or_else(|| format!("the window does not show `{text}`"))?;
                self.point(place);
                self.frame()?;
                for pressed in [true, false] {
                    self.button(0, pressed)?;
                    self.frame()?;
                }
                self.frame() // what opens has its size then
            }
            Command::LoseDevice => {
                self.app.gpu.context.device.destroy();
                self.app.gpu.context.set_lost();
                self.frame()
            }
            Command::Screenshot { file } => {
                self.frame()?;
                let window = self.window.as_ref().ok_or("no frame was drawn")?;
                let size = self.size.max(UVec2::ONE);
                write_texture(&self.app.gpu.context, window, size, &self.out.join(file))
            }
            Command::Picture { show, file } => {
                let path = self.out.join(file);
                self.written(|app| app.save_picture(show, &path))
            }
            Command::Save { side, file } => {
                let path = self.out.join(file);
                self.written(|app| app.save(side, &path))
            }
            Command::Bevy { side, file } => {
                let code = self.app.bevy_code(side);
                self.write(&file, &code)
            }
            Command::Report { file } => {
                let text = format!("{:#}\n", self.report());
                self.write(&file, &text)
            }
            command => {
                self.input(command)?;
                self.frame()
            }
        }
    }

    fn written(&mut self, write: impl FnOnce(&mut App) -> bool) -> Result<(), String> {
        if write(&mut self.app) {
            return Ok(());
        }
        let message = self.app.message.take();
        Err(message.map_or_else(String::new, |message| message.text))
    }

    fn write(&self, file: &Path, text: &str) -> Result<(), String> {
        let path = self.out.join(file);
        let folder = path.parent().unwrap_or(Path::new(""));
        std::fs::create_dir_all(folder)
            .and_then(|()| std::fs::write(&path, text))
            .map_err(|error| format!("{}: {error}", path.display()))
    }

    /// Traces the truth until it has the samples.
    fn refine(&mut self, samples: u32) -> Result<(), String> {
        self.app.shown.judge = true;
        if let Some(compare) = &mut self.app.compare {
            compare.truth.limit = samples.max(1);
            compare.truth.forget();
        }
        let start = Instant::now();
        loop {
            self.frame()?;
            let Some(compare) = &self.app.compare else {
                return Err("there is no scene".to_owned());
            };
            if let Some(failure) = compare.truth.failure() {
                return Err(failure.to_owned());
            }
            if !compare.truth.is_refining() {
                return self.frame(); // judges the last answer
            }
            if start.elapsed() > PATIENCE {
                return Err(format!("the truth took more than {} s", PATIENCE.as_secs()));
            }
            std::thread::sleep(Duration::from_millis(2));
        }
    }

    /// Does a command by a call of the playground or by input to the window.
    fn input(&mut self, command: Command) -> Result<(), String> {
        let app = &mut self.app;
        match command {
            Command::Open { path } => {
                app.open(&path);
            }
            Command::Drop { paths } => {
                self.dropped = paths
                    .into_iter()
                    .map(|path| egui::DroppedFile {
                        path: Some(path),
                        ..Default::default()
                    })
                    .collect();
            }
            Command::Select { light } => {
                let count = app.document.lights().len();
                if light.is_some_and(|light| light >= count) {
                    return Err(format!("there are {count} lights"));
                }
                app.shown.selected = light;
            }
            Command::Technique { side, name } => app.choose(side, &name),
            Command::Set { side, key, value } => {
                let index = app.shown.selected.ok_or("no light is selected")?;
                app.change_light(&key, index, |light| {
                    set_at(&mut light.shadows[side.index()], &key, value);
                });
            }
            Command::Light { key, value } => {
                let index = app.shown.selected.ok_or("no light is selected")?;
                app.change_light(&key, index, |light| set_at(&mut light.keys, &key, value));
            }
            Command::Move { by } => {
                let index = app.shown.selected.ok_or("no light is selected")?;
                app.change_light("move", index, |light| {
                    if let Some(position) = light.vector("position") {
                        light.set_position(position + Vec3::from(by));
                    }
                });
            }
            Command::Add { kind } => app.add(&kind),
            Command::Duplicate => app.duplicate(),
            Command::Delete => app.delete(),
            Command::Undo => app.step(true),
            Command::Redo => app.step(false),
            Command::Show { left, right } => app.shown.panes = [left, right],
            Command::Divider { at } => app.shown.divider = at.clamp(0.0, 1.0),
            Command::Orbit { by } => self.look(|view| view.orbit(radians(by))),
            Command::Look { by } => self.look(|view| view.look(radians(by))),
            Command::Fly { by } => self.look(|view| view.fly(by.into())),
            Command::Dolly { factor } => self.look(|view| view.dolly(factor)),
            Command::Play { on } => app.shown.playing = on,
            Command::Time { clip, seconds } => app.pose(clip, seconds),
            Command::Overlay { name, on } => app.overlay(name, on),
            Command::Debug { on } => app.shown.debug_volumes = on,
            Command::Times { on } => app.shown.times = on,
            Command::Size { to } => {
                self.size = UVec2::from(to).clamp(UVec2::ONE, UVec2::splat(LARGEST));
            }
            Command::Scale { to } => {
                // `frame` gives it to egui as the scale of the screen.
                self.scale = to.clamp(0.25, 8.0);
            }
            other => return self.device_input(other),
        }
        Ok(())
    }

    fn look(&mut self, change: impl FnOnce(&mut crate::document::Eye)) {
        if let Some(view) = &mut self.app.document.view {
            change(view);
        }
    }

    fn device_input(&mut self, command: Command) -> Result<(), String> {
        match command {
            Command::Key { key, ctrl } => {
                let key = key_of(&key)?;
                let modifiers = if ctrl {
                    Modifiers::COMMAND | Modifiers::CTRL
                } else {
                    Modifiers::NONE
                };
                for pressed in [true, false] {
                    self.key(key, pressed, modifiers);
                }
            }
            Command::Pointer { to } => self.point(egui::pos2(to[0], to[1])),
            Command::PointLight { light, offset } => {
                let view = self.app.document.view.ok_or("there is no scene")?;
                let doc = self
                    .app
                    .document
                    .lights()
                    .get(light)
                    .ok_or("there is no such light")?;
                let rect = self.app.shown.view;
                let size = (rect.size() * self.scale).round();
                let lens = view.lens(UVec2::new(size.x as u32, size.y as u32));
                let pixel = lens.pixel(place(doc, self.app.bounds).position);
                let pixel = pixel.ok_or("the light is behind the viewer")? / self.scale + Vec2::from(offset);
                self.point(rect.min + vec2(pixel.x, pixel.y));
            }
            Command::Press { button } => self.button(button, true)?,
            Command::Release { button } => self.button(button, false)?,
            Command::Wheel { lines } => self.events.push(Event::MouseWheel {
                unit: egui::MouseWheelUnit::Line,
                delta: vec2(0.0, lines),
                phase: egui::TouchPhase::Move,
                modifiers: Modifiers::NONE,
            }),
            other => return Err(format!("{other:?} is no input")),
        }
        Ok(())
    }

    fn key(&mut self, key: egui::Key, pressed: bool, modifiers: Modifiers) {
        self.events.push(Event::Key {
            key,
            physical_key: None,
            pressed,
            repeat: false,
            modifiers,
        });
    }

    /// Texts that the last frame showed.
    pub fn texts(&self) -> impl Iterator<Item = &str> {
        self.texts.iter().map(|(text, _)| text.as_str())
    }

    /// Returns the middle of a text that the last frame showed; of several, that drawn last.
    fn place_of(&self, text: &str) -> Option<Pos2> {
        let found = self.texts.iter().rev().find(|(shown, _)| shown == text);
        found.map(|(_, rect)| rect.center())
    }

    fn point(&mut self, to: Pos2) {
        self.pointer = to;
        self.events.push(Event::PointerMoved(to));
    }

    fn button(&mut self, button: usize, pressed: bool) -> Result<(), String> {
        const BUTTONS: [PointerButton; 3] = [
            PointerButton::Primary,
            PointerButton::Secondary,
            PointerButton::Middle,
        ];
        let button = *BUTTONS.get(button).ok_or("a mouse has the buttons 0 to 2")?;
        self.events.push(Event::PointerButton {
            pos: self.pointer,
            button,
            pressed,
            modifiers: Modifiers::NONE,
        });
        Ok(())
    }

    /// Returns what is known about the last frame.
    pub fn report(&self) -> Value {
        let app = &self.app;
        let judgements = app.compare.as_ref().map(|compare| compare.judgements);
        let judgement = |side: Side| {
            let judgement = judgements.and_then(|all| all[side.index()])?;
            Some(json!({
                "wrong_share": judgement.hard.share(),
                "rmse": judgement.soft.as_ref().map(|soft| soft.rmse),
                "rmse_penumbra": judgement.soft.as_ref().and_then(SoftError::penumbra_rmse),
            }))
        };
        let lights = app.document.lights().iter().enumerate().map(|(index, light)| {
            let stage = app.compare.as_ref().and_then(|compare| compare.sides[0].as_ref());
            json!({
                "name": light.name,
                "value": light.to_keys(Side::A),
                "technique": [light.technique(Side::A), light.technique(Side::B)],
                "error": stage.and_then(|stage| stage.errors.get(index).cloned().flatten()),
                "reports": stage.map(|stage| stage.reports(Some(index))),
            })
        });
        let samples = app
            .compare
            .as_ref()
            .and_then(|compare| compare.truth.answer())
            .map(|answer| answer.samples);
        let passes = |side: Side| {
            let mean = app.times.mean(side).passes;
            mean.into_iter()
                .map(|(label, time)| (label, json!(time)))
                .collect::<Map<_, _>>()
        };
        let measured = app.shown.panes.map(|show| {
            let measured = app.compare.as_ref()?.measured[show as usize].as_ref()?;
            let summary = measured.summary;
            show.measure().map(|measure| {
                json!({
                    "title": measure.title(),
                    "pixels": summary.pixels,
                    "mean": summary.mean,
                    "p5": summary.p5,
                    "median": summary.median,
                    "most": summary.most,
                })
            })
        });
        json!({
            "scene": app.document.scene,
            "lights": lights.collect::<Vec<_>>(),
            "selected": app.shown.selected,
            "divider": app.shown.divider,
            "message": app.message.as_ref().map(|message| &message.text),
            "is_error": app.message.as_ref().is_some_and(|message| message.is_error),
            "measured": measured,
            "samples": samples,
            "errors": {"a": judgement(Side::A), "b": judgement(Side::B)},
            "gpu_ms": {"a": passes(Side::A), "b": passes(Side::B)},
            "memory_bytes": memory_stats::memory_stats().map(|memory| memory.physical_mem),
            "time": app.document.pose.map(|pose| pose.time),
        })
    }
}

fn key_of(name: &str) -> Result<egui::Key, String> {
    egui::Key::from_name(name).ok_or_else(|| format!("no key is called `{name}`"))
}

/// Collects the texts of a shape, as far as they are visible.
fn texts_of(shape: &egui::Shape, clip: Rect, to: &mut Vec<(String, Rect)>) {
    match shape {
        egui::Shape::Vec(shapes) => shapes.iter().for_each(|shape| texts_of(shape, clip, to)),
        egui::Shape::Text(text) => {
            let rect = text.galley.rect.translate(text.pos.to_vec2()).intersect(clip);
            if rect.is_positive() {
                to.push((text.galley.text().to_owned(), rect));
            }
        }
        _ => {}
    }
}

fn radians(degrees: [f32; 2]) -> Vec2 {
    Vec2::from(degrees.map(f32::to_radians))
}

/// Sets a value by its path; `null` removes it.
fn set_at(object: &mut Map<String, Value>, path: &str, value: Value) {
    match path.split_once('/') {
        None if value.is_null() => {
            object.remove(path);
        }
        None => {
            object.insert(path.to_owned(), value);
        }
        Some((key, rest)) => {
            let inner = object.entry(key).or_insert_with(|| json!({}));
            if !inner.is_object() {
                *inner = json!({});
            }
            if let Value::Object(inner) = inner {
                set_at(inner, rest, value);
            }
        }
    }
}
