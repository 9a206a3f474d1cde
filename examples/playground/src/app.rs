//! The state of the playground and everything that changes it.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::render::Gpu;
use antumbra::scene::gltf_import::load_gltf;
use antumbra::techniques::Techniques;
use antumbra_stage::shot::Shot;
use antumbra_stage::stage::one_line;
use glam::{UVec2, Vec3};
use serde_json::{Map, Value, json};

use crate::compare::{Compare, Show, Wanted};
use crate::document::{Document, LightDoc, Pose, Side, exactly, light_name, shadow_of};
use crate::handles::Handle;
use crate::history::History;
use crate::opening::complete;
use crate::overlay::Overlay;
use crate::paint::Painter;
use crate::schema::Schemas;
use crate::times::Times;

/// Most lights that a document may have.
pub const MOST_LIGHTS: usize = 1000;

/// Something to tell the user.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// One line.
    pub text: String,
    /// Whether something went wrong.
    pub is_error: bool,
}

/// The drag of a handle.
#[derive(Clone, Copy, Debug)]
pub struct Drag {
    /// The handle.
    pub handle: Handle,
    /// Where the pointer was, pixels of the view.
    pub from: glam::Vec2,
}

/// What the window shows beside the document.
#[derive(Debug)]
pub struct Shown {
    /// Index of the selected light.
    pub selected: Option<usize>,
    /// Left and right half of the view.
    pub panes: [Show; 2],
    /// Share of the view's width left of the divider.
    pub divider: f32,
    /// Whether errors are measured even if no half shows the truth.
    pub judge: bool,
    /// Whether the techniques' own debug views are drawn.
    pub debug_volumes: bool,
    /// Lines over the picture.
    pub overlays: Vec<Overlay>,
    /// Whether the animation plays.
    pub playing: bool,
    /// Whether the help is open.
    pub help: bool,
    /// Whether the graph of times is open.
    pub times: bool,
    /// Bevy code that the window shows, if any.
    pub code: Option<String>,
    /// Text in the field for the path of a file to open.
    pub path: String,
    /// The drag in progress.
    pub drag: Option<Drag>,
    /// The view, points.
    pub view: egui::Rect,
    /// Text for the clipboard.
    pub copied: Option<String>,
}

impl Default for Shown {
    fn default() -> Self {
        Self {
            selected: None,
            panes: [Show::A, Show::B],
            divider: 0.5,
            judge: false,
            debug_volumes: false,
            overlays: Vec::new(),
            playing: false,
            help: false,
            times: false,
            code: None,
            path: String::new(),
            drag: None,
            view: egui::Rect::NOTHING,
            copied: None,
        }
    }
}

/// The playground.
#[derive(Debug)]
pub struct App {
    /// What is edited.
    pub document: Document,
    /// What can be undone.
    pub history: History,
    /// The techniques that a light may have.
    pub techniques: Techniques,
    /// What can be set.
    pub schemas: Schemas,
    /// The pictures; `None` without a scene.
    pub compare: Option<Compare>,
    /// The device and what all pictures share on it.
    pub gpu: Arc<Gpu>,
    /// egui's renderer.
    pub painter: Painter,
    /// What the window shows.
    pub shown: Shown,
    /// Something to tell the user.
    pub message: Option<Message>,
    /// Times of the last frames.
    pub times: Times,
    /// Folder into which files are saved.
    pub out: PathBuf,
    /// Centre and radius of the scene, metres.
    pub bounds: (Vec3, f32),
    pub(crate) images: [Option<(UVec2, egui::TextureId)>; Show::COUNT],
}

impl App {
    /// Makes a playground without a scene.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn new(
        context: RenderContext,
        format: wgpu::TextureFormat,
        techniques: Techniques,
        out: PathBuf,
    ) -> Result<Self, String> {
        let painter = Painter::new(&context, format);
        let gpu = Gpu::new(context).map_err(|error| one_line(&error))?;
        Ok(Self {
            document: Document::default(),
            history: History::default(),
            schemas: Schemas::of(&techniques),
            techniques,
            compare: None,
            gpu: Arc::new(gpu),
            painter,
            shown: Shown::default(),
            message: None,
            times: Times::default(),
            out,
            bounds: (Vec3::ZERO, 1.0),
            images: [None; Show::COUNT],
        })
    }

    /// Continues on another device after the first was lost. The document stays.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn revive(&mut self, context: RenderContext, format: wgpu::TextureFormat) -> Result<(), String> {
        let painter = Painter::new(&context, format);
        let gpu = Gpu::new(context).map_err(|error| one_line(&error))?;
        self.gpu = Arc::new(gpu);
        self.painter = painter;
        self.images = [None; Show::COUNT];
        if let Some(compare) = self.compare.take() {
            let loaded = compare.loaded.clone();
            drop(compare);
            self.compare = Some(Compare::new(self.gpu.clone(), loaded, &self.techniques)?);
        }
        self.tell("The device was lost. Everything is on a new one now.");
        Ok(())
    }

    /// Shows a message.
    pub fn tell(&mut self, text: impl Into<String>) {
        self.message = Some(Message {
            text: text.into(),
            is_error: false,
        });
    }

    /// Shows an error.
    pub fn fail(&mut self, text: impl Into<String>) {
        self.message = Some(Message {
            text: text.into().replace('\n', " "),
            is_error: true,
        });
    }

    /// Opens a scene or a shot file. If it does not load, the old one stays and a message says why.
    pub fn open(&mut self, path: &Path) -> bool {
        match self.try_open(path) {
            Ok(()) => true,
            Err(error) => {
                self.fail(error);
                false
            }
        }
    }

    fn try_open(&mut self, path: &Path) -> Result<(), String> {
        let mut document = Document::load(path, &self.techniques)?;
        let loaded = Arc::new(load_gltf(&document.scene).map_err(|error| one_line(&error))?);
        if let Some(pose) = document.pose
            && pose.clip >= loaded.clips.len()
        {
            let count = loaded.clips.len();
            return Err(format!(
                "{}: animation.clip {}: the scene has {count} clips",
                path.display(),
                pose.clip
            ));
        }
        if document.lights().len() > MOST_LIGHTS {
            return Err(format!("{}: more than {MOST_LIGHTS} lights", path.display()));
        }
        let compare = Compare::new(self.gpu.clone(), loaded, &self.techniques)?;
        let bounds = complete(&mut document, &compare.loaded, &self.techniques)
            .map_err(|error| format!("{}: {error}", path.display()))?;
        let count = document.lights().len();
        self.bounds = bounds;
        self.document = document;
        self.compare = Some(compare);
        for (size, _) in self.images.iter_mut().flatten() {
            *size = UVec2::ZERO; // the pictures are new ones
        }
        self.history.clear();
        self.shown.selected = (count > 0).then_some(0);
        self.shown.playing = false;
        self.shown.path = path.display().to_string();
        self.times = Times::default();
        self.message = None;
        if count == 0 {
            self.tell("The scene has no lights. Add one from the menu Add.");
        }
        Ok(())
    }

    /// Changes the document. Changes of the same name that follow one another are undone together.
    pub fn change(&mut self, name: &str, change: impl FnOnce(&mut Document)) {
        let before = self.document.clone();
        change(&mut self.document);
        if self.document != before {
            self.history.record(name, &before);
        }
    }

    /// Changes a light as [`App::change`] changes the document.
    pub fn change_light(&mut self, name: &str, index: usize, change: impl FnOnce(&mut LightDoc)) {
        let techniques = self.techniques.clone();
        self.change(&format!("{name} {index}"), |document| {
            if let Some(light) = document.lights.as_mut().and_then(|lights| lights.get_mut(index)) {
                change(light);
                light.settle_angle(&techniques);
            }
        });
    }

    /// Undoes or redoes a change.
    pub fn step(&mut self, back: bool) {
        let (view, pose) = (self.document.view, self.document.pose);
        let is_done = if back {
            self.history.undo(&mut self.document)
        } else {
            self.history.redo(&mut self.document)
        };
        if is_done {
            // The camera and the animation are not what is edited.
            self.document.view = view;
            self.document.pose = pose;
        }
        let count = self.document.lights().len();
        self.shown.selected = self.shown.selected.filter(|light| *light < count);
    }

    /// Adds a light of a kind where the viewer looks, and selects it.
    pub fn add(&mut self, kind: &str) {
        let Some(schema) = self.schemas.light(kind) else {
            self.fail(format!("no kind of light is called `{kind}`"));
            return;
        };
        let Value::Object(mut keys) = self.schemas.first(schema) else {
            return;
        };
        let (center, radius) = self.bounds;
        let near = self.document.view.map_or(center, |view| view.target);
        let position = near + Vec3::Y * (0.35 * radius).min(1.5);
        let usual = [
            ("kind", json!(kind)),
            ("position", json!(position.to_array().map(exactly))),
            ("direction", json!([-0.35, -1.0, -0.2])),
            ("inner_deg", json!(25)),
            ("outer_deg", json!(35)),
            ("width", json!(0.6)),
            ("height", json!(0.6)),
            ("radius", json!(0.2)),
        ];
        let known = schema.get("properties").and_then(Value::as_object);
        for (key, value) in usual {
            if known.is_some_and(|known| known.contains_key(key)) {
                keys.insert(key.to_owned(), value);
            }
        }
        // By eye: bright in the middle of the scene. Larger scenes need more intensity.
        let reach = (radius.min(6.0) * 0.5).max(0.05);
        if keys.contains_key("position") {
            keys.insert(
                "intensity".to_owned(),
                json!(crate::document::rounded(1.5 * reach * reach)),
            );
        }
        self.insert_light(keys);
    }

    fn insert_light(&mut self, mut keys: Map<String, Value>) {
        if !keys.contains_key("shadow") {
            let bare = LightDoc::new(String::new(), keys.clone(), &self.techniques);
            let all = self.techniques.rows().iter().map(|row| shadow_of(row.name()));
            let fitting = all.into_iter().find(|shadow| bare.fits(shadow, &self.techniques));
            keys.extend(fitting.map(|shadow| ("shadow".to_owned(), Value::Object(shadow))));
        }
        let index = self.document.lights().len();
        let light = LightDoc::new(light_name(index, &keys), keys, &self.techniques);
        self.push_light(light);
    }

    fn push_light(&mut self, light: LightDoc) {
        let index = self.document.lights().len();
        if index >= MOST_LIGHTS {
            self.fail(format!(
                "there are {MOST_LIGHTS} lights already, which is the most"
            ));
            return;
        }
        self.history.close();
        self.change("add", |document| {
            document.lights.get_or_insert_default().push(light);
        });
        self.shown.selected = Some(index);
    }

    /// Adds a copy of the selected light beside it, and selects the copy.
    pub fn duplicate(&mut self) {
        let Some(mut light) = self.selected_light().cloned() else {
            return;
        };
        if let Some(position) = light.vector("position") {
            light.set_position(position + Vec3::X * (0.1 * self.bounds.1).min(0.5));
        }
        light.name = light_name(self.document.lights().len(), &light.keys);
        self.push_light(light);
    }

    /// Deletes the selected light.
    pub fn delete(&mut self) {
        let Some(index) = self.shown.selected else { return };
        self.history.close();
        self.change("delete", |document| {
            if let Some(lights) = &mut document.lights
                && index < lights.len()
            {
                lights.remove(index);
            }
        });
        let count = self.document.lights().len();
        self.shown.selected = (count > 0).then(|| index.min(count - 1));
    }

    /// The selected light.
    pub fn selected_light(&self) -> Option<&LightDoc> {
        self.document.lights().get(self.shown.selected?)
    }

    /// Gives the selected light a technique with its default settings.
    pub fn choose(&mut self, side: Side, name: &str) {
        let Some(index) = self.shown.selected else { return };
        if name != crate::document::NONE && self.techniques.named(name).is_none() {
            self.fail(format!("no technique is called `{name}`"));
            return;
        }
        self.history.close();
        let mut settings = shadow_of(name);
        if let Some(schema) = self.schemas.technique(name)
            && let Value::Object(needed) = self.schemas.first(schema)
        {
            settings.extend(needed); // what has no default
        }
        self.change_light("technique", index, |light| {
            light.shadows[side.index()] = settings;
        });
    }

    /// Poses the scene at a time of a clip. Clips are repeated.
    pub fn pose(&mut self, clip: usize, time: f32) {
        let length = self.clip_length(clip);
        let time = if length > 0.0 && time.is_finite() {
            time.rem_euclid(length)
        } else {
            0.0
        };
        if length > 0.0 {
            self.document.pose = Some(Pose { clip, time });
        }
    }

    /// Length of a clip of the scene, seconds; 0 without it.
    pub fn clip_length(&self, clip: usize) -> f32 {
        let clips = self.compare.as_ref().map(|compare| &compare.loaded.clips);
        clips
            .and_then(|clips| clips.get(clip))
            .map_or(0.0, |clip| clip.duration())
    }

    /// Advances the animation, if it plays.
    pub fn advance(&mut self, seconds: f32) {
        if self.shown.playing {
            let pose = self.document.pose.unwrap_or(Pose { clip: 0, time: 0.0 });
            self.pose(pose.clip, pose.time + seconds);
        }
    }

    /// Draws the pictures of the view at a size, and lets egui show them.
    pub fn draw(&mut self, size: UVec2) {
        let Some(compare) = &mut self.compare else { return };
        let largest = self.gpu.context.device.limits().max_texture_dimension_2d;
        let wanted = Wanted {
            size: size.clamp(UVec2::ONE, UVec2::splat(largest)),
            panes: self.shown.panes,
            selected: self.shown.selected,
            judge: self.shown.judge,
            playing: self.shown.playing,
            debug_volumes: self.shown.debug_volumes,
        };
        let drawn = compare.draw(&self.document, &wanted, &self.techniques);
        for (show, target) in Show::ALL.into_iter().zip(&compare.targets) {
            let Some(target) = target else { continue };
            let slot = &mut self.images[show as usize];
            if slot.is_none_or(|(size, _)| size != target.size) {
                let id = self.painter.show(&target.shown, slot.map(|(_, id)| id));
                *slot = Some((target.size, id));
            }
        }
        if self.shown.times {
            self.times.record(compare);
        }
        if let Err(error) = drawn
            && !self.gpu.context.is_lost()
        {
            self.fail(error);
        }
    }

    /// Returns the text of the shot with the techniques of a side.
    pub fn shot_text(&self, side: Side, folder: &Path) -> String {
        let size = self.images[Show::A as usize].map_or([640, 360], |(size, _)| size.to_array());
        self.document.to_shot(side, size, folder, &self.techniques)
    }

    /// Returns a file name in the folder of results that is not taken yet.
    pub fn free_name(&self, ending: &str) -> PathBuf {
        let stem = self
            .document
            .scene
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy();
        let names = (1..).map(|number| self.out.join(format!("{stem}-{number}.{ending}")));
        let mut free = names.filter(|path| !path.exists());
        free.next().unwrap_or_default()
    }

    /// Writes the shot, and tells where. A shot that does not open again, because a light cannot be used, is written too,
    /// but as an error that says why.
    pub fn save(&mut self, side: Side, path: &Path) -> bool {
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let text = self.shot_text(side, &folder);
        let written = std::fs::create_dir_all(&folder).and_then(|()| std::fs::write(path, &text));
        let opens = || match Shot::parse(&text, self.techniques.clone()) {
            Ok(_) => Ok(()),
            Err(error) => Err(format!("written, but it does not open: {error}")),
        };
        let told = written.map_err(|error| error.to_string()).and_then(|()| opens());
        self.tell_written(path, told)
    }

    /// Writes the picture of a half of the view, and tells where.
    pub fn save_picture(&mut self, show: Show, path: &Path) -> bool {
        let target = self
            .compare
            .as_ref()
            .and_then(|compare| compare.targets[show as usize].as_ref());
        let Some(target) = target else {
            self.fail(format!("{} is not shown", show.name()));
            return false;
        };
        let written = write_texture(&self.gpu.context, &target.texture, target.size, path);
        self.tell_written(path, written)
    }

    fn tell_written(&mut self, path: &Path, written: Result<(), String>) -> bool {
        match written {
            Ok(()) => self.tell(format!("Written: {}", path.display())),
            Err(error) => self.fail(format!("{}: {error}", path.display())),
        }
        self.message.as_ref().is_some_and(|message| !message.is_error)
    }

    /// Returns the lights as Bevy code.
    pub fn bevy_code(&self, side: Side) -> String {
        crate::bevy_code::lights(&self.document, side, &self.techniques, &self.schemas)
    }
}

/// Writes a texture as PNG.
///
/// # Errors
/// What the device or the disk refuses.
pub fn write_texture(
    context: &RenderContext,
    texture: &wgpu::Texture,
    size: UVec2,
    path: &Path,
) -> Result<(), String> {
    let all = wgpu::TextureAspect::All;
    let rows = antumbra::render::readback::read_texture(context, texture, all, "picture")
        .map_err(|error| one_line(&error))?;
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|error| error.to_string())?;
    }
    antumbra_stage::picture::write_small_png(path, size, &rows.bytes)
}
