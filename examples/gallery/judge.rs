//! The workbench on which pages are judged, and the pictures of one light.

use std::path::Path;
use std::sync::{Arc, PoisonError, RwLock};
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::reference::{DifferenceImage, RayScene, VisibilityImage, difference_image};
use antumbra::render::Gpu;
use glam::UVec2;

use super::cost;
use super::page::{Page, PageShot, PageStage};
use super::panels;
use super::results::PageResult;
use super::session::Session;
use super::support::frames::Rendered;
use super::support::shared_gpu::shared_gpu;
use super::support::solid::{count_alpha_tested, make_alpha_solid};
use super::support::stage::{Stage, one_line};
use super::support::stats;
use super::truth::{self, RayScenes, SAMPLES, Truth};
use super::way::{Way, shadow_all};

/// A device that draws pages. Several workbenches draw at once; while one of them measures times, the others wait.
pub struct Workbench {
    /// Device that draws.
    pub context: RenderContext,
    /// Keeps the pipelines of the device from page to page.
    _gpu: Arc<Gpu>,
    /// Held by those who draw, and held alone by those who measure.
    quiet: Arc<RwLock<()>>,
    /// Size of what is judged, pixels.
    pub size: UVec2,
    /// Factor by which pictures are larger than what is judged.
    pub scale: u32,
    /// Called with a name for people before each shot is judged under each way.
    pub progress: Box<dyn Fn(&str) + Send + Sync>,
}

/// Pictures of one light of a shot, under one way to shadow it.
pub struct Panels {
    /// The picture under the light alone, with its shadow geometry drawn over it, sRGB RGBA.
    pub volumes: Vec<u8>,
    /// Rendered visibility of the light, sRGB RGBA.
    pub visibility: Vec<u8>,
    /// Ray-cast visibility of the light, sRGB RGBA.
    pub truth: Vec<u8>,
    /// Pixels where rendered and ray-cast visibility differ.
    pub difference: DifferenceImage,
    /// Errors over a transparent picture, sRGB RGBA.
    pub overlay: Vec<u8>,
}

impl Workbench {
    /// Makes a workbench that draws on a device, beside no other.
    ///
    /// # Errors
    /// One line on what the device refuses.
    pub fn on(context: RenderContext, size: UVec2, scale: u32) -> Result<Self, String> {
        Ok(Self {
            _gpu: shared_gpu(context.clone()).map_err(|error| one_line(&error))?,
            context,
            quiet: Arc::default(),
            size,
            scale,
            progress: Box::new(|_| {}),
        })
    }

    /// Makes a number of workbenches that draw at once, each on a device of its own.
    ///
    /// # Errors
    /// One line on why there is no device.
    pub fn several(
        count: usize,
        size: UVec2,
        scale: u32,
        progress: impl Fn(&str) + Clone + Send + Sync + 'static,
    ) -> Result<Vec<Self>, String> {
        let quiet = Arc::default();
        let one = |_| {
            let requested = RequestedFeatures {
                timestamps: true,
                ..Default::default()
            };
            let context =
                pollster::block_on(RenderContext::headless(requested)).map_err(|error| one_line(&error))?;
            Ok(Self {
                quiet: Arc::clone(&quiet),
                progress: Box::new(progress.clone()),
                ..Self::on(context, size, scale)?
            })
        };
        (0..count).map(one).collect()
    }

    /// Draws something, while other workbenches may draw and none measures.
    pub fn beside<T>(&self, draw: impl FnOnce() -> T) -> T {
        let _drawing = self.quiet.read().unwrap_or_else(PoisonError::into_inner);
        draw()
    }

    /// Measures something, while other workbenches wait.
    pub fn alone<T>(&self, measure: impl FnOnce() -> T) -> T {
        let _measuring = self.quiet.write().unwrap_or_else(PoisonError::into_inner);
        measure()
    }

    /// Renders and judges a page. Writes its pictures to `out`.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn judge_page(&self, page: &Page, out: &Path) -> Result<PageResult, String> {
        let begin = Instant::now();
        let shown = self.beside(|| self.prepare(page))?;
        let triangle_count = shown.triangle_count;
        let mut session = Session {
            bench: self,
            page,
            shown,
            out,
        };
        // Pictures with the masks as they are, before alpha-tested surfaces are made solid for the ray caster.
        let made_solid = count_alpha_tested(&mut session.shown.stage);
        let mut masks = Vec::new();
        for shot in &page.shots {
            let is_masked = made_solid > 0;
            let draw = || self.beside(|| session.masked_pictures(shot));
            masks.push(is_masked.then(draw).transpose()?);
        }
        make_alpha_solid(&mut session.shown.stage);
        let scenes = self.beside(|| RayScenes::of(&mut session.shown.stage));
        let mut shots = Vec::new();
        for (shot, masks) in page.shots.iter().zip(masks) {
            shots.push(session.judge_shot(shot, &scenes, masks)?);
        }
        // All times of a page at once: the fewer times the other threads wait.
        self.alone(|| {
            let mut shots = page.shots.iter().zip(&mut shots);
            shots.try_for_each(|(shot, judged)| session.measure(shot, judged))
        })?;
        Ok(PageResult {
            seconds: begin.elapsed().as_secs_f64(),
            triangle_count,
            made_solid,
            shots,
        })
    }

    /// Renders the panels of one shot under a way, and the picture under all lights.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn panels(&self, page: &Page, shot: &PageShot, way: &Way) -> Result<(Vec<u8>, Panels), String> {
        let mut shown = self.prepare(page)?;
        self.look(page, &mut shown, shot, self.size)?;
        shadow_all(&mut shown.stage, way, &page.ways);
        let picture = shown
            .stage
            .render()
            .map_err(|error| in_page(page, &error))?
            .picture;
        make_alpha_solid(&mut shown.stage);
        let scene = RayScene::from_world(&mut shown.stage.world);
        let light = shown.light(page, shot.light)?;
        let rendered = shown.stage.render().map_err(|error| in_page(page, &error))?;
        let truths = truth::of_lights(&shown.stage, &scene, SAMPLES)?;
        let truth = truths[light].as_ref().ok_or("the light cannot shine")?;
        let panels = of_light(&mut shown.stage, light, truth, &rendered)?;
        Ok((picture, panels))
    }

    /// Renders only the picture of one shot under a way.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn hero(&self, page: &Page, shot: &PageShot, way: &Way) -> Result<Vec<u8>, String> {
        let mut shown = self.prepare(page)?;
        self.look(page, &mut shown, shot, self.size)?;
        shadow_all(&mut shown.stage, way, &page.ways);
        Ok(shown
            .stage
            .render()
            .map_err(|error| in_page(page, &error))?
            .picture)
    }

    /// Builds a page's stage with a renderer.
    fn prepare(&self, page: &Page) -> Result<PageStage, String> {
        let mut shown = page.stage(self.size)?;
        let settings = RenderSettings {
            ambient: page.ambient,
            background: page.background,
            ..Default::default()
        };
        let added = shown.stage.add_renderer(self.context.clone(), settings);
        added.map_err(|error| in_page(page, &error))?;
        // Of the scene, that is: what techniques report is among the results.
        let stage = &mut shown.stage;
        stage.run();
        stats::print_new_reports(&format!("page {}", page.name), stage);
        Ok(shown)
    }

    /// Points the camera at a shot, with pictures of a size.
    pub(super) fn look(
        &self,
        page: &Page,
        shown: &mut PageStage,
        shot: &PageShot,
        size: UVec2,
    ) -> Result<(), String> {
        shown.stage.world.insert_resource(ViewportSize(size));
        shown
            .look(shot, size)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        shown.stage.world.resource_mut::<Renderer>().settings.exposure = shot.exposure;
        Ok(())
    }

    /// Returns the size of pictures, pixels.
    pub(super) fn shown(&self) -> UVec2 {
        self.scale * self.size
    }

    /// Returns the size at which pictures are drawn before they are reduced, pixels: one and a half times theirs in each
    /// direction, so that edges are smooth. Twice theirs looks much the same and takes nearly twice as long.
    pub(super) fn drawn(&self) -> UVec2 {
        (3 * self.shown()).map(|length| length.div_ceil(2))
    }
}

/// Makes the panels of a light from a frame of a stage, and from another one with its shadow geometry.
pub(super) fn of_light(
    stage: &mut Stage,
    light: usize,
    truth: &Truth,
    rendered: &Rendered,
) -> Result<Panels, String> {
    let got = VisibilityImage::new(rendered.size, rendered.visibility[light].clone())
        .map_err(|error| one_line(&error))?;
    let others = cost::isolate(stage, light);
    stage.world.resource_mut::<Renderer>().settings.debug_volumes = true;
    let volumes = stage.render().map_err(|error| one_line(&error))?.picture;
    stage.world.resource_mut::<Renderer>().settings.debug_volumes = false;
    cost::restore(stage, others);
    let truth_image = &truth.image;
    Ok(Panels {
        volumes,
        visibility: panels::visibility(&got, truth_image),
        truth: panels::visibility(truth_image, truth_image),
        difference: difference_image(truth_image, &got).map_err(|error| one_line(&error))?,
        overlay: panels::overlay(truth_image, &got, truth.is_soft)?,
    })
}

/// Formats an error as one line that begins with the page.
pub(super) fn in_page(page: &Page, error: &dyn std::error::Error) -> String {
    format!("page {}: {}", page.name, one_line(error))
}
