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
use crate::measures::{Measure, Measured};
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
    /// Texels of the selected light's map for each pixel, on side A.
    TexelsA,
    /// Texels of the selected light's map for each pixel, on side B.
    TexelsB,
    /// Lights drawn at each pixel, on side A.
    LightsA,
    /// Lights drawn at each pixel, on side B.
    LightsB,
}

impl Show {
    /// Everything that a half can show.
    pub const ALL: [Self; Self::COUNT] = [
        Self::A,
        Self::B,
        Self::Truth,
        Self::ErrorA,
        Self::ErrorB,
        Self::TexelsA,
        Self::TexelsB,
        Self::LightsA,
        Self::LightsB,
    ];

    /// Number of things that a half can show.
    pub const COUNT: usize = Self::LightsB as usize + 1;

    /// Name in the menu.
    pub fn name(self) -> &'static str {
        match self {
            Self::A => "A",
            Self::B => "B",
            Self::Truth => "Truth",
            Self::ErrorA => "Error of A",
            Self::ErrorB => "Error of B",
            Self::TexelsA => "Texels of A",
            Self::TexelsB => "Texels of B",
            Self::LightsA => "Lights of A",
            Self::LightsB => "Lights of B",
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
            Self::ErrorA | Self::ErrorB => {
                "Where the visibility of the selected light is wrong with that technique: green is right, red is \
                 wrong by 1, grey does not count."
            }
            Self::TexelsA | Self::TexelsB => {
                "How many texels of the selected light's map each pixel covers: red shows texels as steps, green has \
                 about one, blue has more than are seen."
            }
            Self::LightsA | Self::LightsB => {
                "How many lights are drawn at each pixel, shadowed or not: what their shading costs there."
            }
        }
    }

    /// The side whose picture, error or number it is.
    pub fn side(self) -> Option<Side> {
        match self {
            Self::A | Self::ErrorA | Self::TexelsA | Self::LightsA => Some(Side::A),
            Self::B | Self::ErrorB | Self::TexelsB | Self::LightsB => Some(Side::B),
            Self::Truth => None,
        }
    }

    /// The number that it shows in false colours, if it does.
    pub fn measure(self) -> Option<Measure> {
        match self {
            Self::TexelsA | Self::TexelsB => Some(Measure::Texels),
            Self::LightsA | Self::LightsB => Some(Measure::Lights),
            _ => None,
        }
    }

    /// Whether it is about the selected light.
    pub fn needs_light(self) -> bool {
        !matches!(self, Self::A | Self::B | Self::Truth) && self.measure() != Some(Measure::Lights)
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

impl Wanted {
    /// Whether a half shows the picture of a side or an error of it.
    fn shows(&self, side: Side) -> bool {
        self.panes.iter().any(|pane| pane.side() == Some(side))
    }

    /// The numbers of a side that the halves show in false colours, each once.
    fn measures(&self, side: Side) -> impl Iterator<Item = Show> {
        let [left, right] = self.panes;
        let both = [Some(left), Some(right).filter(|right| *right != left)];
        both.into_iter()
            .flatten()
            .filter(move |show| show.measure().is_some() && show.side() == Some(side))
    }
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
    /// Lights that are not traced, because the pictures of all take too much memory.
    pub left_out: usize,
    traced: Option<(Arc<RayScene>, u64)>,
    pose_number: u64,
    posed: Option<crate::document::Pose>,
    /// Pictures by [`Show`].
    pub targets: [Option<Target>; Show::COUNT],
    /// Numbers in false colours, by [`Show`].
    pub measured: [Option<Measured>; Show::COUNT],
    /// Errors of the sides.
    pub judgements: [Option<Judgement>; 2],
    /// Sides that the last frame drew.
    pub drawn: [bool; 2],
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
            left_out: 0,
            traced: None,
            pose_number: 0,
            posed: None,
            targets: [const { None }; Show::COUNT],
            measured: [const { None }; Show::COUNT],
            judgements: [None; 2],
            drawn: [false; 2],
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
        if refining {
            self.truth.poll();
        }
        let judged = self.to_judge(document, wanted).filter(|_| refining);
        let light = judged.as_ref().and(wanted.selected);
        let mut visibility = [None, None];
        for side in Side::ALL {
            let index = side.index();
            // The truth is that of what side A shows.
            self.drawn[index] = side == Side::A || wanted.shows(side);
            if self.drawn[index] {
                visibility[index] = self.draw_side(side, document, wanted, light, techniques)?;
            }
        }
        if refining {
            self.ask(wanted)?;
            if let Some(judged) = judged {
                for (side, visibility) in Side::ALL.into_iter().zip(visibility) {
                    self.judge(side, wanted, visibility)?;
                }
                self.judged = Some(judged);
            }
            if self.truth.answer().is_none() {
                self.judgements = [None; 2];
                self.judged = None;
            }
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

    /// Returns what a judgement is made of, unless it is made already or there is no truth yet.
    fn to_judge(&self, document: &Document, wanted: &Wanted) -> Option<Judged> {
        let judged = Judged {
            document: document.clone(),
            samples: self.truth.answer()?.samples,
            selected: wanted.selected,
            size: wanted.size,
            panes: wanted.panes,
        };
        (self.judged.as_ref() != Some(&judged)).then_some(judged)
    }

    /// Whether there is a picture of what is to be shown.
    pub fn is_known(&self, show: Show) -> bool {
        match show {
            Show::A | Show::B => true,
            Show::Truth => self.truth.answer().is_some(),
            Show::ErrorA => self.judgements[Side::A.index()].is_some(),
            Show::ErrorB => self.judgements[Side::B.index()].is_some(),
            Show::TexelsA | Show::TexelsB | Show::LightsA | Show::LightsB => {
                self.measured[show as usize].is_some()
            }
        }
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
        judged: Option<usize>,
        techniques: &Techniques,
    ) -> Result<Option<Vec<f32>>, String> {
        let show = [Show::A, Show::B][side.index()];
        let mut stage = match self.sides[side.index()].take() {
            Some(stage) => stage,
            None => SideStage::new(&self.gpu, &self.loaded, Shading::Techniques(side), techniques)?,
        };
        let mut renderer = stage.stage.world.resource_mut::<Renderer>();
        renderer.settings.debug_volumes = wanted.debug_volumes;
        renderer.settings.pixel_measures = wanted.measures(side).next().is_some();
        let applied = stage.apply(document, wanted.size);
        if let (Side::B, Some(a)) = (side, &self.sides[Side::A.index()]) {
            stage.place_as(a);
        }
        let target = self.target(show, wanted.size);
        let drawn = stage.draw(target, judged).map_err(|error| one_line(&error));
        let measured = drawn
            .as_ref()
            .map_or(Ok(()), |_| self.measure(&mut stage, side, wanted));
        self.sides[side.index()] = Some(stage);
        applied.and(measured).and(drawn)
    }

    /// Makes the numbers in false colours that the halves show of a side.
    fn measure(&mut self, stage: &mut SideStage, side: Side, wanted: &Wanted) -> Result<(), String> {
        for show in wanted.measures(side) {
            let measured = match show.measure() {
                Some(Measure::Texels) => stage.texels(wanted.selected)?,
                Some(Measure::Lights) => stage.lights_per_pixel()?,
                None => None,
            };
            if let Some(measured) = &measured {
                let context = self.gpu.context.clone();
                self.target(show, measured.size).write(&context, &measured.rgba8);
            }
            self.measured[show as usize] = measured;
        }
        Ok(())
    }

    /// Asks for the truth of what side A shows.
    fn ask(&mut self, wanted: &Wanted) -> Result<(), String> {
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
        let mut lights: Vec<_> = lights
            .iter()
            .map(|light| LightSource::of_entity(world, *light).ok())
            .collect();
        self.left_out = leave_out(&mut lights, wanted.size, wanted.selected);
        let question = Question {
            size: wanted.size,
            camera: *camera,
            world_from_camera: *place,
            lights,
            scene: number,
        };
        if let Some((scene, _)) = &self.traced {
            self.truth.ask(question, scene);
        }
        self.truth
            .failure()
            .map_or(Ok(()), |failure| Err(failure.to_owned()))
    }

    fn judge(&mut self, side: Side, wanted: &Wanted, visibility: Option<Vec<f32>>) -> Result<(), String> {
        self.judgements[side.index()] = None;
        let truth = wanted.selected.and_then(|light| {
            let answer = self.truth.answer()?;
            answer.lights.get(light)?.clone()
        });
        let (Some(truth), Some(got)) = (truth, visibility) else {
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
        let applied = stage.apply(document, wanted.size);
        if let Some(a) = &self.sides[Side::A.index()] {
            stage.place_as(a);
        }
        if let Some(answer) = self.truth.answer() {
            stage.give(&answer.pictures);
        }
        let target = self.target(Show::Truth, wanted.size);
        let drawn = stage.draw(target, None).map_err(|error| one_line(&error));
        self.given = Some(stage);
        applied.and(drawn.map(|_| ()))
    }
}

/// Most pixels of visibility that the truth holds, in sum over all lights. Each takes up to 24 bytes: the sum of the
/// samples, the mean, and a texel of half floats, the latter two also of the answer before.
const MOST_PIXELS: u64 = 64_000_000;

/// Removes the lights whose pictures would take too much memory; the selected light is the last to go. Returns how many
/// were removed.
fn leave_out(lights: &mut [Option<LightSource>], size: UVec2, selected: Option<usize>) -> usize {
    let pixels = u64::from(size.x) * u64::from(size.y);
    let mut room = (MOST_PIXELS / pixels.max(1)).max(1);
    let first = selected.filter(|light| *light < lights.len());
    let others = (0..lights.len()).filter(|light| Some(*light) != first);
    let mut count = 0;
    for light in first.into_iter().chain(others) {
        if lights[light].is_none() {
            continue;
        }
        if room == 0 {
            lights[light] = None;
            count += 1;
        } else {
            room -= 1;
        }
    }
    count
}

#[cfg(test)]
mod tests {
    use antumbra::prelude::*;

    use super::*;

    #[test]
    fn the_truth_holds_as_many_lights_as_fit_and_the_selected_one_first() {
        let light = LightSource::new(
            &Light::point(glam::Vec3::ONE, 1.0, 5.0),
            &GlobalTransform::IDENTITY,
            LightSelection::default(),
        );
        let light = light.ok();
        assert!(light.is_some());
        let mut lights = vec![light; 40];
        lights[0] = None;
        assert_eq!(leave_out(&mut lights, UVec2::new(1920, 1080), Some(38)), 9);
        let kept: Vec<usize> = (0..40).filter(|index| lights[*index].is_some()).collect();
        assert_eq!(kept, (1..30).chain([38]).collect::<Vec<_>>());
        let mut few = vec![light; 40];
        assert_eq!(leave_out(&mut few, UVec2::new(640, 360), None), 0);
        let mut huge = vec![light; 2];
        assert_eq!(
            leave_out(&mut huge, UVec2::new(15_360, 8640), Some(1)),
            1,
            "one is always traced"
        );
        assert!(huge[0].is_none() && huge[1].is_some());
    }
}
