//! A bake on its way: surfaces laid flat, rays cast in batches, charts packed into pages.

use std::time::Instant;

use bevy_ecs::prelude::*;
use rayon::prelude::*;

use super::chart::Chart;
use super::key::key_of;
use super::pack::{Packed, Wanted, pack};
use super::partial::{BATCH, Batch};
use super::settings::{Bake, BakeError, BakeNote, BakeProgress, BakeSettings};
use super::surfaces::{StillScene, Surface, gather};
use super::texels::{Texel, texels_of};
use super::trace::{RayOrigin, Targets};
use super::unwrap::unwrap;
use crate::scene::LightPath;
use crate::techniques::occlusion_interval::intervals::Intervals;
use crate::techniques::occlusion_interval::maps::{
    BakeStatistics, BakedSurface, Corner, IntervalMaps, Page, pairs_for,
};

/// A bake whose surfaces are laid flat.
pub(super) struct Job<'a> {
    scene: StillScene,
    charts: Vec<Chart>,
    pub notes: Vec<BakeNote>,
    path: &'a LightPath,
    settings: &'a BakeSettings,
    /// Hash of everything that the result depends on ([`key_of`]).
    pub key: u64,
}

/// Refuses charts that would need more layers or bytes than maps may have, even if every texel had few intervals. A bake
/// takes long, so that is not left to its end.
fn check_size(charts: &[Chart], settings: &BakeSettings) -> Result<(), BakeError> {
    let wanted = |chart: &Chart| Wanted {
        size: chart.size,
        pairs: 1,
    };
    let wanted: Vec<Wanted> = charts.iter().map(wanted).collect();
    if pack(&wanted, settings.page_size).is_some() {
        return Ok(());
    }
    let texels = |chart: &Chart| u64::from(chart.size.x) * u64::from(chart.size.y);
    Err(BakeError::TooLarge {
        texels: charts.iter().map(texels).sum(),
        pairs: 1,
    })
}

impl<'a> Job<'a> {
    pub fn new(
        world: &mut World,
        path: &'a LightPath,
        settings: &'a BakeSettings,
    ) -> Result<Self, BakeError> {
        path.check()?;
        settings.check()?;
        let density = settings.texels_per_metre;
        let scene = gather(world, &settings.moving, settings.casts_for);
        let flat: Vec<_> = scene
            .surfaces
            .par_iter()
            .enumerate()
            .filter(|(_, surface)| surface.receives)
            .map(|(index, surface)| {
                (
                    surface,
                    unwrap(index as u32, surface, density, settings.page_size),
                )
            })
            .collect();
        let (mut charts, mut notes) = (Vec::new(), Vec::new());
        for (surface, unwrapped) in flat {
            let mesh = || surface.mesh.clone();
            notes.extend(
                unwrapped
                    .notes
                    .into_iter()
                    .map(|note| BakeNote::Unwrap { mesh: mesh(), note }),
            );
            let coarsest = unwrapped
                .charts
                .iter()
                .filter_map(|chart| chart.coarser)
                .reduce(f32::min);
            notes.extend(coarsest.map(|texels_per_metre| BakeNote::Coarser {
                mesh: mesh(),
                texels_per_metre,
            }));
            charts.extend(unwrapped.charts);
        }
        if charts.is_empty() {
            return Err(BakeError::Nothing);
        }
        check_size(&charts, settings)?;
        let key = key_of(&scene, &charts, path, settings);
        Ok(Self {
            scene,
            charts,
            notes,
            path,
            settings,
            key,
        })
    }

    /// Casts the rays of all texels, except those of the batches that are known. Hands each new batch to `save`.
    pub fn cast(
        &self,
        mut batches: Vec<Batch>,
        mut save: impl FnMut(&Batch) -> Result<(), BakeError>,
        mut progress: impl FnMut(BakeProgress),
    ) -> Result<Vec<Batch>, BakeError> {
        let count = |chart: &Chart| texels_of(chart).len() as u64;
        let all: u64 = self.charts.par_iter().map(count).sum();
        let resumed: u64 = batches.iter().map(|batch| batch.texels.len() as u64).sum();
        let mut done = resumed.min(all);
        progress(BakeProgress { done, all, resumed });
        let targets = Targets::new(self.path, &self.scene.rays, self.settings.casts_for);
        let of_chart = |chart| texels_of(chart).into_iter().map(move |texel| (chart, texel));
        let mut waiting = self.charts.iter().flat_map(of_chart).skip(resumed as usize);
        loop {
            let texels: Vec<(&Chart, Texel)> = waiting.by_ref().take(BATCH).collect();
            if texels.is_empty() {
                return Ok(batches);
            }
            let batch = self.cast_batch(&targets, &texels);
            save(&batch)?;
            done += batch.texels.len() as u64;
            batches.push(batch);
            progress(BakeProgress { done, all, resumed });
        }
    }

    fn cast_batch(&self, targets: &Targets, texels: &[(&Chart, Texel)]) -> Batch {
        let start = Instant::now();
        let cast = |(chart, texel): &(&Chart, Texel)| {
            let mut rays = 0;
            let intervals = match self.origin(chart, texel) {
                Some(origin) => targets.trace(&self.scene.rays, &origin, &mut rays),
                None => Intervals::new(),
            };
            (intervals, rays)
        };
        let cast: Vec<(Intervals, u64)> = texels.par_iter().map(cast).collect();
        let rays = cast.iter().map(|(_, rays)| rays).sum();
        Batch {
            texels: cast.into_iter().map(|(intervals, _)| intervals).collect(),
            rays,
            seconds: start.elapsed().as_secs_f64(),
        }
    }

    fn origin(&self, chart: &Chart, texel: &Texel) -> Option<RayOrigin> {
        let surface = self.scene.surfaces.get(chart.surface as usize)?;
        let index = chart.triangles.get(texel.triangle as usize)?.triangle;
        let triangle = surface.triangles.get(index as usize)?.as_ref()?;
        let [a, b, c] = triangle.corners;
        let weights = texel.weights;
        Some(RayOrigin {
            position: a * weights.x + b * weights.y + c * weights.z,
            normal: triangle.normal,
            is_two_sided: surface.is_two_sided,
            triangle: triangle.slot,
        })
    }

    /// Packs the charts and writes the intervals into pages.
    pub fn finish(self, batches: &[Batch]) -> Result<Bake, BakeError> {
        let mut intervals = batches.iter().flat_map(|batch| &batch.texels);
        // The texels of each chart, in the order in which they were cast.
        let of_charts: Vec<(Vec<Texel>, Vec<&Intervals>)> = self
            .charts
            .iter()
            .map(|chart| {
                let texels = texels_of(chart);
                let own = intervals.by_ref().take(texels.len()).collect();
                (texels, own)
            })
            .collect();
        let most = |own: &[&Intervals]| own.iter().map(|intervals| intervals.len()).max().unwrap_or(0);
        let wanted: Vec<Wanted> = self
            .charts
            .iter()
            .zip(&of_charts)
            .map(|(chart, (_, own))| Wanted {
                size: chart.size,
                pairs: pairs_for(most(own)),
            })
            .collect();
        let most_intervals = of_charts.iter().map(|(_, own)| most(own)).max().unwrap_or(0);
        let texels = of_charts.iter().map(|(texels, _)| texels.len() as u64).sum();
        let packed = pack(&wanted, self.settings.page_size).ok_or(BakeError::TooLarge {
            texels,
            pairs: pairs_for(most_intervals),
        })?;
        let statistics = BakeStatistics {
            texels,
            rays: batches.iter().map(|batch| batch.rays).sum(),
            seconds: batches.iter().map(|batch| batch.seconds).sum(),
            most_intervals: most_intervals as u32,
            coarser_charts: self.charts.iter().filter(|chart| chart.coarser.is_some()).count() as u32,
        };
        let (surfaces, corners) = baked_surfaces(&self.scene.surfaces, &self.charts, &packed);
        let maps = IntervalMaps {
            key: self.key,
            path: self.path.clone(),
            texels_per_metre: self.settings.texels_per_metre,
            size: packed.size,
            pages: write_pages(&packed, &of_charts),
            surfaces,
            corners,
            statistics,
        };
        Ok(self.bake_of(maps))
    }

    /// Maps of this job with their notes.
    pub fn bake_of(self, maps: IntervalMaps) -> Bake {
        let mut notes = self.notes;
        if maps.statistics.most_intervals == 0 {
            notes.push(BakeNote::NeverSeen);
        }
        Bake { maps, notes }
    }
}

fn write_pages(packed: &Packed, of_charts: &[(Vec<Texel>, Vec<&Intervals>)]) -> Vec<Page> {
    let dark = |&pairs: &usize| Page::dark(packed.size, pairs);
    let mut pages: Vec<Page> = packed.pairs.iter().map(dark).collect();
    for (placed, (texels, own)) in packed.placed.iter().zip(of_charts) {
        let Some(page) = pages.get_mut(placed.page as usize) else {
            continue;
        };
        for (texel, intervals) in texels.iter().zip(own) {
            let at = placed.origin + texel.at;
            page.write(at.y as usize * packed.size as usize + at.x as usize, intervals);
        }
    }
    pages
}

/// Lists the surfaces and where their corners are on the pages. Triangles without a chart are nowhere.
fn baked_surfaces(
    surfaces: &[Surface],
    charts: &[Chart],
    packed: &Packed,
) -> (Vec<BakedSurface>, Vec<Corner>) {
    let mut corners = Vec::new();
    let mut baked = Vec::with_capacity(surfaces.len());
    for surface in surfaces {
        let first = corners.len();
        if surface.receives {
            corners.resize(first + 3 * surface.triangles.len(), Corner::NOWHERE);
        }
        baked.push(BakedSurface {
            mesh: surface.mesh.clone(),
            hash: surface.hash,
            world_from_local: surface.world_from_local,
            is_two_sided: surface.is_two_sided,
            casts: surface.casts,
            corners: first as u32..corners.len() as u32,
        });
    }
    for (chart, placed) in charts.iter().zip(&packed.placed) {
        let first = baked[chart.surface as usize].corners.start as usize;
        for triangle in &chart.triangles {
            let at = first + 3 * triangle.triangle as usize;
            for (corner, texel) in corners[at..at + 3].iter_mut().zip(triangle.texels) {
                *corner = Corner {
                    page: placed.page,
                    texel: placed.origin.as_vec2() + texel,
                };
            }
        }
    }
    (baked, corners)
}
