//! A shot's pictures, and its lights against the ray caster.

use std::path::Path;
use std::time::Instant;

use antumbra::prelude::*;
use antumbra::reference::{
    DifferenceImage, HardError, LightSource, RayScene, ReferenceError, VisibilityImage, compare_hard,
    difference_image, edge_band, hard_visibility, primary_hits,
};
use bevy_transform::prelude::GlobalTransform;
use glam::UVec2;
use serde_json::Value;

use super::cost::{self, Cost};
use super::page::{Page, PageShot, PageStage};
use super::panels;
use super::support::solid::make_alpha_solid;
use super::support::stage::{Rendered, Stage, one_line};
use super::support::{picture, stats};

/// What renders all pages.
pub struct Workbench {
    /// The device.
    pub context: RenderContext,
    /// Of the pictures, pixels.
    pub size: UVec2,
}

/// What a page gave.
pub struct PageResult {
    /// Wall time.
    pub seconds: f64,
    /// Triangles of the scene.
    pub triangle_count: usize,
    /// Objects with alpha-tested surfaces, which the judged panels take as solid.
    pub made_solid: usize,
    /// Shot by shot.
    pub shots: Vec<ShotResult>,
}

/// What a shot gave.
pub struct ShotResult {
    /// Files of the panels, in the order of [`panels::TITLES`].
    pub files: Vec<String>,
    /// Index of the light that the panels show.
    pub light: usize,
    /// Name of each light and its judgement; `None` for one that could not be judged.
    pub lights: Vec<(String, Option<Judgement>)>,
    /// Statistics of the first frame, as of `examples/render`.
    pub stats: Value,
    /// CPU milliseconds by system set while nothing moves, and of the light.
    pub cost: Cost,
}

/// How wrong a light's rendered visibility is.
#[derive(Clone, Copy, Debug)]
pub struct Judgement {
    /// In numbers.
    pub error: HardError,
    /// The first wrong pixel off the edge band.
    pub first_wrong: Option<UVec2>,
}

/// The five pictures of a shot, sRGB RGBA.
pub struct Panels {
    /// All lights.
    pub picture: Vec<u8>,
    /// The light alone, its volumes over it.
    pub volumes: Vec<u8>,
    /// Rendered visibility of the light.
    pub visibility: Vec<u8>,
    /// Ray-cast visibility of the light.
    pub truth: Vec<u8>,
    /// Where both differ.
    pub difference: DifferenceImage,
}

impl Workbench {
    /// Renders and judges a page; its pictures go to `out`.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn judge_page(&mut self, page: &Page, out: &Path) -> Result<PageResult, String> {
        let begin = Instant::now();
        let (mut shown, mut shots) = (self.prepare(page)?, Vec::new());
        let mut pictures = Vec::new();
        for shot in &page.shots {
            pictures.push(self.picture(page, &mut shown, shot)?);
        }
        let made_solid = make_alpha_solid(&mut shown.stage);
        let scene = RayScene::from_world(&mut shown.stage.world);
        for (shot, (rendered, stats, cpu_ms)) in page.shots.iter().zip(pictures) {
            let light = shown.light(page, shot.light)?;
            let (panels, errors, cost) =
                self.judge_shot(page, &mut shown, shot, &scene, rendered, made_solid > 0)?;
            let stem = format!("{}-{}", page.name, shot.name);
            shots.push(ShotResult {
                files: write_panels(&panels, self.size, out, &stem)?,
                light,
                lights: shown.light_names.iter().cloned().zip(errors).collect(),
                stats,
                cost: Cost { cpu_ms, ..cost },
            });
        }
        Ok(PageResult {
            seconds: begin.elapsed().as_secs_f64(),
            triangle_count: shown.triangle_count,
            made_solid,
            shots,
        })
    }

    /// The five panels of one shot.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn panels(&mut self, page: &Page, shot: &PageShot) -> Result<Panels, String> {
        let mut shown = self.prepare(page)?;
        let (rendered, ..) = self.picture(page, &mut shown, shot)?;
        let made_solid = make_alpha_solid(&mut shown.stage);
        let scene = RayScene::from_world(&mut shown.stage.world);
        let (panels, ..) = self.judge_shot(page, &mut shown, shot, &scene, rendered, made_solid > 0)?;
        Ok(panels)
    }

    /// The picture of one shot alone.
    ///
    /// # Errors
    /// One line that names the file and the element.
    pub fn hero(&mut self, page: &Page, shot: &PageShot) -> Result<Vec<u8>, String> {
        let mut shown = self.prepare(page)?;
        shown
            .look(shot, self.size)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        set(&mut shown.stage, shot.exposure, false);
        Ok(shown
            .stage
            .render()
            .map_err(|error| in_page(page, &error))?
            .picture)
    }

    /// A page's stage with a renderer.
    fn prepare(&self, page: &Page) -> Result<PageStage, String> {
        let mut shown = page.stage(self.size)?;
        let settings = RenderSettings {
            ambient: page.ambient,
            background: page.background,
            ..Default::default()
        };
        let added = shown.stage.add_renderer(self.context.clone(), settings);
        added.map_err(|error| in_page(page, &error))?;
        Ok(shown)
    }

    /// The picture under all lights, what it was made of, and CPU milliseconds of steady frames.
    fn picture(
        &self,
        page: &Page,
        shown: &mut PageStage,
        shot: &PageShot,
    ) -> Result<(Rendered, Value, Vec<f64>), String> {
        shown
            .look(shot, self.size)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        let stage = &mut shown.stage;
        set(stage, shot.exposure, false);
        let rendered = stage.render().map_err(|error| in_page(page, &error))?;
        stats::print_new_reports(&format!("page {}", page.name), stage);
        let stats = stats::collect(stage, &rendered);
        Ok((rendered, stats, cost::steady_cpu_ms(stage)))
    }

    /// The other panels, the error of every light, and the cost of the shot's light.
    fn judge_shot(
        &self,
        page: &Page,
        shown: &mut PageStage,
        shot: &PageShot,
        scene: &RayScene,
        rendered: Rendered,
        again: bool,
    ) -> Result<(Panels, Vec<Option<Judgement>>, Cost), String> {
        let failed = |error: &dyn std::error::Error| in_page(page, error);
        let light = shown.light(page, shot.light)?;
        shown
            .look(shot, self.size)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        let stage = &mut shown.stage;
        set(stage, shot.exposure, false);
        let picture = rendered.picture;
        let visibility = if again {
            stage.render().map_err(|error| failed(&error))?.visibility
        } else {
            stage.schedule.run(&mut stage.world); // the camera's transform is that of this shot again
            rendered.visibility
        };
        let mut judged = Vec::new();
        for (index, got) in visibility.into_iter().enumerate() {
            let got = VisibilityImage::new(self.size, got).map_err(|error| failed(&error))?;
            judged.push(match truth(stage, scene, index)? {
                Some(truth) => {
                    let error = judgement(&truth, &got).map_err(|error| failed(&error))?;
                    (Some(truth), got, Some(error))
                }
                None => (None, got, None),
            });
        }
        let (Some(truth), got, _) = &judged[light] else {
            return Err(format!("page {}: light {} cannot shine", page.name, shot.light));
        };
        let difference = difference_image(truth, got).map_err(|error| failed(&error))?;
        let others = cost::isolate(stage, light);
        set(stage, shot.exposure, true);
        let volumes = stage.render().map_err(|error| failed(&error))?.picture;
        set(stage, shot.exposure, false);
        let cost = cost::of_light(stage, light).map_err(|error| failed(&error))?;
        cost::restore(stage, others);
        let panels = Panels {
            picture,
            volumes,
            visibility: panels::visibility(got, truth),
            truth: panels::visibility(truth, truth),
            difference,
        };
        let errors = judged.into_iter().map(|(_, _, error)| error).collect();
        Ok((panels, errors, cost))
    }
}

fn set(stage: &mut Stage, exposure: f32, debug_volumes: bool) {
    let settings = &mut stage.world.resource_mut::<Renderer>().settings;
    settings.exposure = exposure;
    settings.debug_volumes = debug_volumes;
}

fn in_page(page: &Page, error: &dyn std::error::Error) -> String {
    format!("page {}: {}", page.name, one_line(error))
}

/// Truth for one light of the frame that ran last; `None` for a light that cannot shine.
fn truth(stage: &Stage, scene: &RayScene, light: usize) -> Result<Option<VisibilityImage>, String> {
    let world = &stage.world;
    let (Some(camera), Some(transform)) = (
        world.get::<Camera>(stage.camera),
        world.get::<GlobalTransform>(stage.camera),
    ) else {
        return Err("the stage has no camera".to_owned());
    };
    let size = world.resource::<ViewportSize>().0;
    let hits = primary_hits(scene, camera, transform, size).map_err(|error| one_line(&error))?;
    let source = LightSource::of_entity(world, stage.lights[light]).ok();
    Ok(source.map(|source| hard_visibility(scene, &hits, &source)))
}

fn judgement(truth: &VisibilityImage, got: &VisibilityImage) -> Result<Judgement, ReferenceError> {
    let error = compare_hard(truth, got)?;
    let pixels = truth.values().iter().zip(got.values()).zip(edge_band(truth, 1));
    let first_wrong = pixels
        .enumerate()
        .find(|(_, ((truth, got), in_band))| !in_band && (**truth - **got).abs() > 0.5)
        .map(|(index, _)| UVec2::new(index as u32 % truth.size().x, index as u32 / truth.size().x));
    Ok(Judgement { error, first_wrong })
}

fn write_panels(panels: &Panels, size: UVec2, out: &Path, stem: &str) -> Result<Vec<String>, String> {
    let all = [
        &panels.picture,
        &panels.volumes,
        &panels.visibility,
        &panels.truth,
        &panels.difference.rgba8,
    ];
    let mut files = Vec::new();
    for (name, pixels) in panels::NAMES.iter().zip(all) {
        let file = format!("{stem}-{name}.png");
        picture::write_png(&out.join(&file), size, pixels)?;
        files.push(file);
    }
    Ok(files)
}

/// One line: the worst share of wrong pixels of any light of any shot.
pub fn verdict(results: &[(&Page, PageResult)]) -> String {
    let mut worst: Option<(f64, String)> = None;
    let (mut judged, mut wrong) = (0, 0);
    for (page, result) in results {
        for (shot, judgement) in page.shots.iter().zip(&result.shots) {
            for (name, error) in &judgement.lights {
                let Some(Judgement { error, first_wrong }) = error else {
                    continue;
                };
                judged += error.inner;
                wrong += error.wrong_inner;
                let Some(share) = error.share() else { continue };
                if worst.as_ref().is_none_or(|(most, _)| share > *most) {
                    let pixel =
                        first_wrong.map_or_else(String::new, |at| format!(" at pixel {},{}", at.x, at.y));
                    let at = format!("{}/{}, light {name}{pixel}", page.name, shot.name);
                    worst = Some((share, at));
                }
            }
        }
    }
    match worst {
        Some((0.0, _)) => {
            format!(
                "exact: 0 of {judged} judged pixels are wrong off the edge band, over all lights of all shots"
            )
        }
        Some((share, at)) => format!(
            "worst share of wrong pixels off the edge band: {:.4} % ({at}); {wrong} of {judged} in all",
            share * 100.0
        ),
        None => "nothing was judged".to_owned(),
    }
}
