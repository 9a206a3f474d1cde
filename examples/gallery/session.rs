//! A page while it is judged: every shot under every way to shadow its lights, compared with the ray caster.

use std::path::Path;

use antumbra::prelude::*;
use antumbra::reference::{ReferenceError, VisibilityImage, compare_hard, compare_soft, edge_band};
use glam::UVec2;

use super::cost::{self, Cost};
use super::judge::{Workbench, in_page, of_light};
use super::page::{Page, PageShot, PageStage};
use super::panels;
use super::results::{Judgement, PANELS, ShotResult, WayResult};
use super::support::{picture, stats};
use super::truth::{self, RayScenes, SAMPLES, Truth};
use super::way::{Way, shadow, shadow_all};

/// A page while it is judged.
pub struct Session<'a> {
    /// The workbench.
    pub bench: &'a Workbench,
    /// The page.
    pub page: &'a Page,
    /// Its stage.
    pub shown: PageStage,
    /// Folder of the pictures.
    pub out: &'a Path,
}

/// What was seen of a shot with alpha masks as they are.
pub struct Masked {
    /// Visibility of the shot's light under each way; empty for ways that refuse the light.
    visibility: Vec<Vec<f32>>,
    /// Radiance without shadows, which tells surfaces apart.
    radiance: Vec<f32>,
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

    /// Draws and writes the picture of every way, with alpha masks as they are. Returns what was seen.
    ///
    /// # Errors
    /// One line that names the page.
    pub fn masked_pictures(&mut self, shot: &PageShot) -> Result<Masked, String> {
        let (bench, page) = (self.bench, self.page);
        let light = self.shown.light(page, shot.light)?;
        let mut masks = Vec::new();
        for way in &page.ways {
            if self.refusal(way, light).is_some() {
                masks.push(Vec::new());
                continue;
            }
            shadow_all(&mut self.shown.stage, way, &page.ways);
            self.write_picture(shot, way)?;
            bench.look(page, &mut self.shown, shot, bench.size)?;
            let stage = &mut self.shown.stage;
            let mut rendered = stage.render().map_err(|error| in_page(page, &error))?;
            masks.push(rendered.visibility.swap_remove(light));
        }
        bench.look(page, &mut self.shown, shot, bench.size)?;
        Ok(Masked {
            visibility: masks,
            radiance: self.unshadowed()?,
        })
    }

    /// Draws and writes the picture of a way that shadows the lights already.
    fn write_picture(&mut self, shot: &PageShot, way: &Way) -> Result<(), String> {
        let (bench, page) = (self.bench, self.page);
        bench.look(page, &mut self.shown, shot, bench.drawn())?;
        let picture = self.shown.stage.picture();
        let picture = picture.map_err(|error| in_page(page, &error))?;
        self.write_reduced(&file_name(page, shot, &way.name, PANELS[0]), &picture)
    }

    /// Writes a picture that was drawn larger than it is shown.
    fn write_reduced(&self, file: &str, picture: &[u8]) -> Result<(), String> {
        let shown = self.bench.shown();
        let reduced = panels::reduce(self.bench.drawn(), picture, shown);
        picture::write_png(&self.out.join(file), shown, &reduced)
    }

    /// Returns the radiance of the view without shadows. Removes the techniques from the lights.
    fn unshadowed(&mut self) -> Result<Vec<f32>, String> {
        self.without_shadows();
        let rendered = self.shown.stage.render();
        Ok(rendered.map_err(|error| in_page(self.page, &error))?.radiance)
    }

    /// Removes the techniques from the lights.
    fn without_shadows(&mut self) {
        let stage = &mut self.shown.stage;
        for light in stage.lights.clone() {
            shadow(stage, light, None);
        }
    }

    /// Returns the visibilities with alpha masks, NaN where a pixel shows another surface now that they are solid.
    fn on_same_surfaces(&mut self, mut masked: Masked) -> Result<Vec<Vec<f32>>, String> {
        let solid = self.unshadowed()?;
        for visibility in &mut masked.visibility {
            let pixels = masked.radiance.chunks_exact(4).zip(solid.chunks_exact(4));
            for (seen, (before, now)) in visibility.iter_mut().zip(pixels) {
                if before != now {
                    *seen = f32::NAN;
                }
            }
        }
        Ok(masked.visibility)
    }

    /// Judges every way on one shot. `masked` is what was seen with holes of alpha masks, if there are any; their pictures
    /// are written already.
    ///
    /// # Errors
    /// One line that names the page.
    pub fn judge_shot(
        &mut self,
        shot: &PageShot,
        scenes: &RayScenes,
        masked: Option<Masked>,
    ) -> Result<ShotResult, String> {
        let (bench, page) = (self.bench, self.page);
        let light = self.shown.light(page, shot.light)?;
        let truth_picture = match masked {
            None => Some(bench.beside(|| self.truth_picture(shot, scenes))?),
            Some(_) => None,
        };
        let (masks, truths) = bench.beside(|| {
            bench.look(page, &mut self.shown, shot, bench.size)?;
            let masks = masked.map(|masked| self.on_same_surfaces(masked)).transpose()?;
            self.shown.stage.run();
            let truths = truth::of_lights(&self.shown.stage, &scenes.all, SAMPLES)?;
            Ok::<_, String>((masks, truths))
        })?;
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
                None => {
                    let mask = masks.as_ref().map(|masks| &masks[index][..]);
                    let result = bench.beside(|| self.judge_way(shot, way, &truths, mask))?;
                    // Last, so that what lights keep from frame to frame is not drawn again.
                    if mask.is_none() {
                        bench.beside(|| self.write_picture(shot, way))?;
                        bench.look(page, &mut self.shown, shot, bench.size)?;
                    }
                    Ok(result)
                }
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

    /// Draws and writes the picture with ray-cast visibility. Returns its file.
    fn truth_picture(&mut self, shot: &PageShot, scenes: &RayScenes) -> Result<String, String> {
        let (bench, page) = (self.bench, self.page);
        bench.look(page, &mut self.shown, shot, bench.drawn())?;
        let large = truth::picture(&mut self.shown.stage, scenes)
            .map_err(|error| format!("page {}: {error}", page.name))?;
        let file = file_name(page, shot, "truth", PANELS[0]);
        self.write_reduced(&file, &large)?;
        Ok(file)
    }

    /// Times the light of a shot without shadows and under each way that was judged.
    ///
    /// # Errors
    /// One line that names the page.
    pub fn measure(&mut self, shot: &PageShot, judged: &mut ShotResult) -> Result<(), String> {
        let (bench, page) = (self.bench, self.page);
        let failed = |error| in_page(page, &error);
        bench.look(page, &mut self.shown, shot, bench.size)?;
        self.without_shadows();
        let stage = &mut self.shown.stage;
        let unshadowed_ms = cost::unshadowed_ms(stage, judged.light).map_err(failed)?;
        for (way, result) in page.ways.iter().zip(&mut judged.ways) {
            if let Ok(result) = result {
                shadow_all(stage, way, &page.ways);
                result.cost = cost::of_light(stage, judged.light, unshadowed_ms).map_err(failed)?;
            }
        }
        Ok(())
    }

    /// Judges one way on one shot, with the truths of all lights. Measures no times.
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
        let truth = truths[light].as_ref().ok_or("the light cannot shine")?;
        let stage = &mut self.shown.stage;
        shadow_all(stage, way, &page.ways);
        let rendered = stage.render().map_err(|error| failed(&error))?;
        let stats = stats::collect(stage, &rendered);
        let panels = of_light(stage, light, truth, &rendered)?;
        let mut judged = Vec::new();
        for (truth, got) in truths.iter().zip(&rendered.visibility) {
            judged.push(match truth {
                Some(truth) => Some(judgement(truth, got.clone()).map_err(|error| failed(&error))?),
                None => None,
            });
        }
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
            cost: Cost::default(),
            cuts_holes,
        })
    }
}

fn file_name(page: &Page, shot: &PageShot, way: &str, panel: &str) -> String {
    format!("{}-{}-{way}-{panel}.png", page.name, shot.name)
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
