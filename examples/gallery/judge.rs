//! The workbench on which pages are judged, and the pictures of one light.

use std::path::Path;
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::reference::{DifferenceImage, RayScene, VisibilityImage, difference_image};
use glam::UVec2;

use super::cost;
use super::page::{Page, PageShot, PageStage};
use super::panels;
use super::results::PageResult;
use super::session::Session;
use super::support::solid::make_alpha_solid;
use super::support::stage::{Rendered, Stage, one_line};
use super::support::stats;
use super::truth::{self, SAMPLES, Truth};
use super::way::{Way, shadow_all};

/// Renders all pages.
pub struct Workbench {
    /// Device that draws.
    pub context: RenderContext,
    /// Size of what is judged, pixels.
    pub size: UVec2,
    /// Factor by which pictures are larger than what is judged. They are drawn twice as large as that and averaged.
    pub scale: u32,
    /// Called with a name for people before each shot is judged under each way.
    pub progress: Box<dyn Fn(&str)>,
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
    /// Renders and judges a page. Writes its pictures to `out`.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn judge_page(&self, page: &Page, out: &Path) -> Result<PageResult, String> {
        let begin = Instant::now();
        let shown = self.prepare(page)?;
        let triangle_count = shown.triangle_count;
        let mut session = Session {
            bench: self,
            page,
            shown,
            out,
        };
        // Pictures as they are, before alpha-tested surfaces are made solid for the ray caster.
        let mut masks = Vec::new();
        for shot in &page.shots {
            masks.push(session.pictures(shot)?);
        }
        let made_solid = make_alpha_solid(&mut session.shown.stage);
        let scene = RayScene::from_world(&mut session.shown.stage.world);
        let mut shots = Vec::new();
        for (shot, masks) in page.shots.iter().zip(masks) {
            shots.push(session.judge_shot(shot, &scene, (made_solid > 0).then_some(masks))?);
        }
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
        set(&mut shown.stage, shot.exposure, false);
        Ok(())
    }

    /// Returns the size at which pictures are drawn before they are averaged.
    pub(super) fn large(&self) -> UVec2 {
        2 * self.scale * self.size
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

/// Sets the exposure of a stage, and whether its shadow geometry is drawn over the picture.
pub(super) fn set(stage: &mut Stage, exposure: f32, debug_volumes: bool) {
    let settings = &mut stage.world.resource_mut::<Renderer>().settings;
    settings.exposure = exposure;
    settings.debug_volumes = debug_volumes;
}

/// Formats an error as one line that begins with the page.
pub(super) fn in_page(page: &Page, error: &dyn std::error::Error) -> String {
    format!("page {}: {}", page.name, one_line(error))
}
