//! The pictures that are compared: those of both sides, the truth, and the errors against it.

use std::sync::Arc;

use antumbra::prelude::*;
use antumbra::reference::{
    HardError, LightSource, RayScene, SoftError, VisibilityImage, compare_hard, compare_soft,
    difference_image,
};
use antumbra::render::Gpu;
use antumbra::scene::gltf_import::LoadedGltf;
use antumbra::techniques::Techniques;
use antumbra_stage::stage::one_line;
use bevy_transform::prelude::GlobalTransform;
use glam::UVec2;
use serde::Deserialize;

use crate::document::{Document, Side};
use crate::side::{Shading, SideStage};
use crate::target::Target;
use crate::truth::{Question, Truth};

/// What a half of the view shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Show {
    /// The techniques of side A.
    A,
    /// The techniques of side B.
    B,
    /// The ray-traced truth.
    Truth,
    /// The error of side A against the truth, for the selected light.
    ErrorA,
    /// The error of side B against the truth, for the selected light.
    ErrorB,
}

impl Show {
    /// Everything that a half can show.
    pub const ALL: [Self; 5] = [Self::A, Self::B, Self::Truth, Self::ErrorA, Self::ErrorB];

    /// Name in the menu.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::Truth => "Truth",
            Self::ErrorA => "Error of A",
            Self::ErrorB => "Error of B",
        }
    }

    /// What it means.
    pub fn help(self) -> &'static str {
        match self {
            Self::A => "The picture with technique A of each light.",
            Self::B => "The picture with technique B of each light.",
            Self::Truth => {
                "The same light pass with ray-traced visibility, which refines in the background. Cut-out and \
                 blended surfaces block whole there."
            }
            Self::ErrorA => {
                "Where the visibility of the selected light with technique A is wrong: green is right, \
                             red is wrong by 1, grey does not count."
            }
            Self::ErrorB => {
                "Where the visibility of the selected light with technique B is wrong: green is right, \
                             red is wrong by 1, grey does not count."
            }
        }
    }

    /// The side whose picture or error it is.
    pub fn side(self) -> Option<Side> {
        match self {
            Self::A | Self::ErrorA => Some(Side::A),
            Self::B | Self::ErrorB => Some(Side::B),
            Self::Truth => None,
        }
    }

    /// Whether it needs the truth.
    pub fn needs_truth(self) -> bool {
        matches!(self, Self::Truth | Self::ErrorA | Self::ErrorB)
    }
}

/// Error of a side's visibility of the selected light.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    /// Counts of wrong pixels.
    pub hard: HardError,
    /// Root mean squared errors; `None` if no pixel counts.
    pub soft: Option<SoftError>,
}

/// What is drawn in a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wanted {
    /// Size of the view, pixels.
    pub size: UVec2,
    /// Left and right half of the view.
    pub panes: [Show; 2],
    /// The light whose error is shown.
    pub selected: Option<usize>,
    /// Whether the truth is traced even if no half shows it.
    pub judge: bool,
    /// Whether the animation plays, so that no truth would be traced in time.
    pub playing: bool,
    /// Whether the techniques' own debug views are drawn over the picture.
    pub debug_volumes: bool,
}

/// All pictures of a document.
#[derive(Debug)]
pub struct Compare {
    /// What all sides share on the GPU.
    pub gpu: Arc<Gpu>,
    /// The scene.
    pub loaded: Arc<LoadedGltf>,
    /// Both sides. Side A is always there.
    pub sides: [Option<SideStage>; 2],
    given: Option<SideStage>,
    /// The ray-traced visibility.
    pub truth: Truth,
    traced: Option<(Arc<RayScene>, u64)>,
    pose_number: u64,
    posed: Option<crate::document::Pose>,
    /// Pictures by [`Show`].
    pub targets: [Option<Target>; 5],
    /// Errors of the sides.
    pub judgements: [Option<Judgement>; 2],
    judged: Option<Judged>,
}

/// What the judgements were made of.
#[derive(Clone, Debug, PartialEq)]
struct Judged {
    document: Document,
    samples: u32,
    selected: Option<usize>,
    size: UVec2,
    panes: [Show; 2],
}

impl Compare {
    /// Makes the stage of side A for a scene. The others are made when they are shown.
    ///
    /// # Errors
    /// One line that says what the device or the scene refuses.
    pub fn new(gpu: Arc<Gpu>, loaded: Arc<LoadedGltf>, techniques: &Techniques) -> Result<Self, String> {
        let side = SideStage::new(&gpu, &loaded, Shading::Techniques(Side::A), techniques)?;
        Ok(Self {
            gpu,
            loaded,
            sides: [Some(side), None],
            given: None,
            truth: Truth::default(),
            traced: None,
            pose_number: 0,
            posed: None,
            targets: [const { None }; 5],
            judgements: [None; 2],
            judged: None,
        })
    }

    /// Draws what is wanted of a document.
    ///
    /// # Errors
    /// One line that says what the device refuses.
    pub fn draw(
        &mut self,
        document: &Document,
        wanted: &Wanted,
        techniques: &Techniques,
    ) -> Result<(), String> {
        let is_asked = wanted.judge || wanted.panes.iter().any(|pane| pane.needs_truth());
        let refining = is_asked && !wanted.playing;
        if document.pose != self.posed {
            self.posed = document.pose;
            self.pose_number += 1;
        }
        let is_shown = |side: Side| wanted.panes.iter().any(|pane| pane.side() == Some(side));
        for side in Side::ALL {
            if side == Side::A || is_shown(side) {
                self.draw_side(side, document, wanted, techniques)?;
            }
        }
        if refining {
            self.ask(wanted.size)?;
            self.judge_again(document, wanted)?;
        } else {
            self.truth.stop();
            self.judged = None;
            self.judgements = [None; 2];
        }
        if wanted.panes.contains(&Show::Truth) && self.truth.answer().is_some() {
            self.draw_truth(document, wanted, techniques)?;
        }
        Ok(())
    }

    /// Whether there is a picture of what is to be shown.
    pub fn is_known(&self, show: Show) -> bool {
        match show {
            Show::A | Show::B => true,
            Show::Truth => self.truth.answer().is_some(),
            Show::ErrorA => self.judgements[Side::A.index()].is_some(),
            Show::ErrorB => self.judgements[Side::B.index()].is_some(),
        }
    }

    /// Judges the sides that are shown, unless they are judged already.
    fn judge_again(&mut self, document: &Document, wanted: &Wanted) -> Result<(), String> {
        let samples = self.truth.answer().map_or(0, |answer| answer.samples);
        let judged = Judged {
            document: document.clone(),
            samples,
            selected: wanted.selected,
            size: wanted.size,
            panes: wanted.panes,
        };
        if self.judged.as_ref() == Some(&judged) {
            return Ok(());
        }
        self.judgements = [None; 2];
        if samples > 0 {
            for side in Side::ALL {
                let is_shown = wanted.panes.iter().any(|pane| pane.side() == Some(side));
                if !is_shown && side == Side::B {
                    continue;
                }
                let Some(mut stage) = self.sides[side.index()].take() else {
                    continue;
                };
                let target = self.target([Show::A, Show::B][side.index()], wanted.size);
                let drawn = stage.draw(target, true).map_err(|error| one_line(&error));
                self.sides[side.index()] = Some(stage);
                self.judge(side, wanted, drawn?)?;
            }
        }
        self.judged = Some(judged);
        Ok(())
    }

    fn target(&mut self, show: Show, size: UVec2) -> &Target {
        let slot = &mut self.targets[show as usize];
        if slot.as_ref().is_some_and(|target| target.size != size) {
            *slot = None;
        }
        slot.get_or_insert_with(|| Target::new(&self.gpu.context, size))
    }

    fn draw_side(
        &mut self,
        side: Side,
        document: &Document,
        wanted: &Wanted,
        techniques: &Techniques,
    ) -> Result<(), String> {
        let show = [Show::A, Show::B][side.index()];
        let mut stage = match self.sides[side.index()].take() {
            Some(stage) => stage,
            None => SideStage::new(&self.gpu, &self.loaded, Shading::Techniques(side), techniques)?,
        };
        stage.apply(document, wanted.size);
        let mut renderer = stage.stage.world.resource_mut::<Renderer>();
        renderer.settings.debug_volumes = wanted.debug_volumes;
        let target = self.target(show, wanted.size);
        let drawn = stage.draw(target, false).map_err(|error| one_line(&error));
        self.sides[side.index()] = Some(stage);
        drawn.map(|_| ())
    }

    /// Asks for the truth of what side A shows.
    fn ask(&mut self, size: UVec2) -> Result<(), String> {
        let Some(side) = &mut self.sides[Side::A.index()] else {
            return Ok(());
        };
        let world = &mut side.stage.world;
        let number = self.pose_number;
        if self.traced.as_ref().is_none_or(|(_, known)| *known != number) {
            self.traced = Some((Arc::new(RayScene::from_world(world)), number));
        }
        let lights = &side.stage.lights;
        let (Some(camera), Some(place)) = (
            world.get::<Camera>(side.stage.camera),
            world.get::<GlobalTransform>(side.stage.camera),
        ) else {
            return Ok(());
        };
        let question = Question {
            size,
            camera: *camera,
            world_from_camera: *place,
            lights: lights
                .iter()
                .map(|light| LightSource::of_entity(world, *light).ok())
                .collect(),
            scene: number,
        };
        if let Some((scene, _)) = &self.traced {
            self.truth.ask(question, scene);
            self.truth.poll();
        }
        self.truth
            .failure()
            .map_or(Ok(()), |failure| Err(failure.to_owned()))
    }

    fn judge(
        &mut self,
        side: Side,
        wanted: &Wanted,
        mut visibility: Vec<Option<Vec<f32>>>,
    ) -> Result<(), String> {
        self.judgements[side.index()] = None;
        let truth = wanted.selected.and_then(|light| {
            let answer = self.truth.answer()?;
            Some((light, answer.lights.get(light)?.clone()?))
        });
        let Some((light, truth)) = truth else {
            return Ok(());
        };
        let Some(got) = visibility.get_mut(light).and_then(Option::take) else {
            return Ok(());
        };
        if truth.size() != wanted.size {
            return Ok(()); // the truth of this size is still traced
        }
        let failed = |error: antumbra::reference::ReferenceError| one_line(&error);
        let got = VisibilityImage::new(wanted.size, got).map_err(failed)?;
        self.judgements[side.index()] = Some(Judgement {
            hard: compare_hard(&truth, &got).map_err(failed)?,
            soft: compare_soft(&truth, &got).map_err(failed)?,
        });
        let show = [Show::ErrorA, Show::ErrorB][side.index()];
        if wanted.panes.contains(&show) {
            let picture = difference_image(&truth, &got).map_err(failed)?;
            let context = self.gpu.context.clone();
            self.target(show, wanted.size).write(&context, &picture.rgba8);
        }
        Ok(())
    }

    fn draw_truth(
        &mut self,
        document: &Document,
        wanted: &Wanted,
        techniques: &Techniques,
    ) -> Result<(), String> {
        let mut stage = match self.given.take() {
            Some(stage) => stage,
            None => SideStage::new(&self.gpu, &self.loaded, Shading::Given, techniques)?,
        };
        stage.apply(document, wanted.size);
        if let Some(answer) = self.truth.answer() {
            stage.give(&answer.pictures);
        }
        let target = self.target(Show::Truth, wanted.size);
        let drawn = stage.draw(target, false).map_err(|error| one_line(&error));
        self.given = Some(stage);
        drawn.map(|_| ())
    }
}
