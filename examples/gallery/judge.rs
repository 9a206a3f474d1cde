//! Draws a page's shots with every way to shadow its lights, and compares each with the ray caster.

use std::path::Path;
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::reference::{
    DifferenceImage, RayScene, ReferenceError, VisibilityImage, compare_hard, compare_soft, difference_image,
    edge_band,
};
use glam::UVec2;

use super::cost::{self, Cost};
use super::page::{Page, PageShot, PageStage};
use super::panels;
use super::results::{Judgement, PANELS, PageResult, ShotResult, WayResult};
use super::support::solid::make_alpha_solid;
use super::support::stage::{Rendered, Stage, one_line};
use super::support::{picture, stats};
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

/// A page while it is judged.
struct Session<'a> {
    bench: &'a Workbench,
    page: &'a Page,
    shown: PageStage,
    out: &'a Path,
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
        // Pictures and masks as they are, before alpha-tested surfaces are made solid for the ray caster.
        let mut masks = Vec::new();
        for shot in &page.shots {
            masks.push(session.pictures(shot)?);
        }
        let made_solid = make_alpha_solid(&mut session.shown.stage);
        let scene = RayScene::from_world(&mut session.shown.stage.world);
        let mut shots = Vec::new();
        for (shot, masks) in page.shots.iter().zip(masks) {
            shots.push(session.judge_shot(shot, &scene, (made_solid > 0).then_some(&masks))?);
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
        stage.schedule.run(&mut stage.world);
        stats::print_new_reports(&format!("page {}", page.name), stage);
        Ok(shown)
    }

    /// Points the camera at a shot, with pictures of a size.
    fn look(&self, page: &Page, shown: &mut PageStage, shot: &PageShot, size: UVec2) -> Result<(), String> {
        shown.stage.world.insert_resource(ViewportSize(size));
        shown
            .look(shot, size)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        set(&mut shown.stage, shot.exposure, false);
        Ok(())
    }

    /// Returns the size at which pictures are drawn before they are averaged.
    fn large(&self) -> UVec2 {
        2 * self.scale * self.size
    }
}

impl Session<'_> {
    /// Returns why a way cannot shadow the light of a shot.
    fn refusal(&self, way: &Way, light: usize) -> Option<String> {
        let light = self
            .shown
            .stage
            .world
            .get::<Light>(self.shown.stage.lights[light])?;
        way.settings.check(light).err().map(|refusal| refusal.to_string())
    }

    /// Draws and writes the picture of every way. Returns the visibility of the shot's light under each, with alpha masks
    /// as they are; it is empty for ways that refuse the light.
    fn pictures(&mut self, shot: &PageShot) -> Result<Vec<Vec<f32>>, String> {
        let (bench, page) = (self.bench, self.page);
        let light = self.shown.light(page, shot.light)?;
        let mut masks = Vec::new();
        for way in &page.ways {
            if self.refusal(way, light).is_some() {
                masks.push(Vec::new());
                continue;
            }
            bench.look(page, &mut self.shown, shot, bench.large())?;
            let stage = &mut self.shown.stage;
            shadow_all(stage, way, &page.ways);
            let large = stage.render().map_err(|error| in_page(page, &error))?;
            let (size, pixels) = panels::halve(bench.large(), &large.picture);
            let file = file_name(page, shot, &way.name, PANELS[0]);
            picture::write_png(&self.out.join(file), size, &pixels)?;
            bench.look(page, &mut self.shown, shot, bench.size)?;
            let stage = &mut self.shown.stage;
            let mut rendered = stage.render().map_err(|error| in_page(page, &error))?;
            masks.push(rendered.visibility.swap_remove(light));
        }
        Ok(masks)
    }

    /// Judges every way on one shot. `masks` are the visibilities with holes of alpha masks, if there are any.
    fn judge_shot(
        &mut self,
        shot: &PageShot,
        scene: &RayScene,
        masks: Option<&Vec<Vec<f32>>>,
    ) -> Result<ShotResult, String> {
        let (bench, page) = (self.bench, self.page);
        let light = self.shown.light(page, shot.light)?;
        let truth_picture = match masks {
            None => Some(self.truth_picture(shot, scene)?),
            Some(_) => None,
        };
        bench.look(page, &mut self.shown, shot, bench.size)?;
        let stage = &mut self.shown.stage;
        stage.schedule.run(&mut stage.world);
        let truths = truth::of_lights(stage, scene, SAMPLES)?;
        let Some(Truth { image, is_soft }) = &truths[light] else {
            return Err(format!("page {}: light {} cannot shine", page.name, shot.light));
        };
        let truth_visibility = file_name(page, shot, "truth", PANELS[1]);
        let drawn = panels::visibility(image, image);
        picture::write_png(&self.out.join(&truth_visibility), bench.size, &drawn)?;
        let mut ways = Vec::new();
        for (index, way) in page.ways.iter().enumerate() {
            (bench.progress)(&format!("{}/{}: {}", page.name, shot.name, way.title));
            ways.push(match self.refusal(way, light) {
                Some(reason) => Err(reason),
                None => Ok(self.judge_way(shot, way, &truths, masks.map(|masks| &masks[index][..]))?),
            });
        }
        Ok(ShotResult {
            light,
            is_soft: *is_soft,
            truth_picture,
            truth_visibility,
            ways,
        })
    }

    /// Draws and writes the picture with ray-cast visibility.
    fn truth_picture(&mut self, shot: &PageShot, scene: &RayScene) -> Result<String, String> {
        let (bench, page) = (self.bench, self.page);
        bench.look(page, &mut self.shown, shot, bench.large())?;
        let large = truth::picture(&mut self.shown.stage, scene, shot.exposure)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        let (size, pixels) = panels::halve(bench.large(), &large);
        let file = file_name(page, shot, "truth", PANELS[0]);
        picture::write_png(&self.out.join(&file), size, &pixels)?;
        Ok(file)
    }

    /// Judges one way on one shot.
    fn judge_way(
        &mut self,
        shot: &PageShot,
        way: &Way,
        truths: &[Option<Truth>],
        mask: Option<&[f32]>,
    ) -> Result<WayResult, String> {
        let (bench, page) = (self.bench, self.page);
        let failed = |error: &dyn std::error::Error| in_page(page, error);
        let light = self.shown.light(page, shot.light)?;
        let stage = &mut self.shown.stage;
        shadow_all(stage, way, &page.ways);
        let rendered = stage.render().map_err(|error| failed(&error))?;
        let stats = stats::collect(stage, &rendered);
        let cpu_ms = cost::steady_cpu_ms(stage);
        let mut judged = Vec::new();
        for (truth, got) in truths.iter().zip(&rendered.visibility) {
            judged.push(match truth {
                Some(truth) => Some(judgement(truth, got.clone()).map_err(|error| failed(&error))?),
                None => None,
            });
        }
        let truth = truths[light].as_ref().ok_or("the light cannot shine")?;
        let panels = of_light(stage, light, truth, &rendered)?;
        set(stage, shot.exposure, false);
        let others = cost::isolate(stage, light);
        let cost = cost::of_light(stage, light).map_err(|error| failed(&error))?;
        cost::restore(stage, others);
        let mut files = vec![file_name(page, shot, &way.name, PANELS[0])];
        let all = [
            &panels.visibility,
            &panels.difference.rgba8,
            &panels.volumes,
            &panels.overlay,
        ];
        for (name, pixels) in PANELS[1..].iter().zip(all) {
            let file = file_name(page, shot, &way.name, name);
            picture::write_png(&self.out.join(&file), bench.size, pixels)?;
            files.push(file);
        }
        let cuts_holes = mask.map(|mask| {
            let pairs = mask.iter().zip(&rendered.visibility[light]);
            let brighter = pairs.filter(|(open, solid)| **open - **solid > 0.5).count();
            brighter * 1000 > mask.len()
        });
        Ok(WayResult {
            files,
            lights: self.shown.light_names.iter().cloned().zip(judged).collect(),
            stats,
            cost: Cost { cpu_ms, ..cost },
            cuts_holes,
        })
    }
}

fn file_name(page: &Page, shot: &PageShot, way: &str, panel: &str) -> String {
    format!("{}-{}-{way}-{panel}.png", page.name, shot.name)
}

/// Makes the panels of a light from a frame of a stage, and from another one with its shadow geometry.
fn of_light(stage: &mut Stage, light: usize, truth: &Truth, rendered: &Rendered) -> Result<Panels, String> {
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

fn set(stage: &mut Stage, exposure: f32, debug_volumes: bool) {
    let settings = &mut stage.world.resource_mut::<Renderer>().settings;
    settings.exposure = exposure;
    settings.debug_volumes = debug_volumes;
}

fn in_page(page: &Page, error: &dyn std::error::Error) -> String {
    format!("page {}: {}", page.name, one_line(error))
}

fn judgement(truth: &Truth, got: Vec<f32>) -> Result<Judgement, ReferenceError> {
    let truth = &truth.image;
    let got = VisibilityImage::new(truth.size(), got)?;
    let pixels = truth.values().iter().zip(got.values()).zip(edge_band(truth, 1));
    let first_wrong = pixels
        .enumerate()
        .find(|(_, ((truth, got), in_band))| !in_band && (**truth - **got).abs() > 0.5)
        .map(|(index, _)| UVec2::new(index as u32 % truth.size().x, index as u32 / truth.size().x));
    Ok(Judgement {
        hard: compare_hard(truth, &got)?,
        soft: compare_soft(truth, &got)?,
        first_wrong,
    })
}
