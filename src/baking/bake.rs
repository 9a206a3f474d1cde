//! Bakes the maps of one light: lays surfaces flat, casts rays, packs pages.

use std::path::{Path, PathBuf};
use std::time::Instant;

use bevy_ecs::prelude::*;
use rayon::prelude::*;

use super::chart::Chart;
use super::pack::{Packed, Wanted, pack};
use super::partial::{Batch, PartialFile};
use super::surfaces::{StillScene, Surface, gather};
use super::texels::{Texel, texels_of};
use super::trace::{RayOrigin, Targets};
use super::unwrap::{UnwrapNote, unwrap};
use crate::scene::{LightPath, PathError};
use crate::techniques::occlusion_interval::intervals::Intervals;
use crate::techniques::occlusion_interval::maps::{
    BakeStatistics, BakedSurface, Corner, IntervalMaps, MAX_LAYERS, MAX_SIZE, Page, pairs_for,
};
use crate::techniques::occlusion_interval::surface::StableHash;
use crate::techniques::occlusion_interval::{MANIFEST, MapsError};

/// How maps are baked.
#[derive(Clone, Debug, PartialEq)]
pub struct BakeSettings {
    /// Texels per metre of surfaces; greater than 0. Twice as many take four times the memory and time. Default: 8.
    pub texels_per_metre: f32,
    /// Most texels along each side of a page, 16 to 4096. Surfaces that need more are coarser. Default: 2048.
    pub page_size: u32,
    /// Layers of the objects that block the light, as in [`LightSelection`](crate::scene::LightSelection). Default: all.
    pub casts_for: u32,
    /// Objects that will move. They neither show nor cast shadows in the maps. Skinned and morphed ones need not be named.
    pub moving: Vec<Entity>,
}

impl Default for BakeSettings {
    fn default() -> Self {
        Self {
            texels_per_metre: 8.0,
            page_size: 2048,
            casts_for: u32::MAX,
            moving: Vec::new(),
        }
    }
}

/// How far a bake is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BakeProgress {
    /// Texels that are done.
    pub done: u64,
    /// All texels.
    pub all: u64,
    /// Texels that an interrupted bake had done.
    pub resumed: u64,
}

/// Why maps cannot be baked.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BakeError {
    /// The path of the light cannot be used.
    #[error("path: {0}")]
    Path(#[from] PathError),
    /// A setting cannot be used.
    #[error("{setting} is {value}, it must be {allowed}")]
    Setting {
        /// Name of the setting.
        setting: &'static str,
        /// Value of the setting.
        value: f32,
        /// Values that are allowed.
        allowed: &'static str,
    },
    /// Nothing in the scene stands still and shows shadows.
    #[error("nothing in the scene stands still and shows shadows")]
    Nothing,
    /// The maps would need more layers than a device holds.
    #[error(
        "{texels} texels with up to {pairs} pairs of textures need more than {MAX_LAYERS} layers; use fewer texels per metre"
    )]
    TooLarge {
        /// Number of texels.
        texels: u64,
        /// Most pairs that a texel needs.
        pairs: usize,
    },
    /// The file of an interrupted bake cannot be read or written.
    #[error("{}: {error}", file.display())]
    Partial {
        /// The file.
        file: PathBuf,
        /// What the system says.
        error: std::io::Error,
    },
    /// The maps cannot be written.
    #[error(transparent)]
    Maps(#[from] MapsError),
}

/// Something that a bake did otherwise than asked.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BakeNote {
    /// The texture coordinates of a mesh are not used, or some of its triangles are left out.
    #[error("mesh \"{mesh}\": {note}")]
    Unwrap {
        /// Name of the mesh.
        mesh: String,
        /// What was wrong.
        note: UnwrapNote,
    },
    /// A chart is larger than a page.
    #[error(
        "mesh \"{mesh}\": a part has {texels_per_metre} texels per metre only, because a page is too small for more"
    )]
    Coarser {
        /// Name of the mesh.
        mesh: String,
        /// Density of the chart.
        texels_per_metre: f32,
    },
    /// No texel sees the light at any time: it never rises, or its path lies inside of geometry.
    #[error("nothing sees the light at any time: it never rises, or its path lies inside of geometry")]
    NeverSeen,
}

/// Baked maps, and what is to be said about them.
#[derive(Clone, Debug, PartialEq)]
pub struct Bake {
    /// The maps.
    pub maps: IntervalMaps,
    /// What was done otherwise than asked.
    pub notes: Vec<BakeNote>,
}

/// Number of texels whose rays are cast, and saved, together.
const BATCH: usize = if cfg!(test) { 64 } else { 4096 };

/// Name of the file of an interrupted bake.
const PARTIAL: &str = "bake.partial";

/// Bakes the maps of a light with a path through what stands still in a world. Work runs on the threads of the current
/// `rayon` pool; the result does not depend on their number.
///
/// `GlobalTransform`s are read as they are, so run the schedule once before.
///
/// # Errors
/// [`BakeError`] says what cannot be baked.
pub fn bake_intervals(
    world: &mut World,
    path: &LightPath,
    settings: &BakeSettings,
    progress: impl FnMut(BakeProgress),
) -> Result<Bake, BakeError> {
    let job = Job::new(world, path, settings)?;
    let batches = job.cast(Vec::new(), |_| Ok(()), progress)?;
    job.finish(&batches)
}

/// Bakes like [`bake_intervals`] and writes the maps into a folder. A bake that was interrupted is gone on with. Maps that
/// are in the folder already, and are those of this scene, path and settings, are returned as they are.
///
/// # Errors
/// [`BakeError`] says what cannot be baked or written.
pub fn bake_into(
    folder: &Path,
    world: &mut World,
    path: &LightPath,
    settings: &BakeSettings,
    progress: impl FnMut(BakeProgress),
) -> Result<Bake, BakeError> {
    let job = Job::new(world, path, settings)?;
    if folder.join(MANIFEST).exists()
        && let Ok(maps) = IntervalMaps::load(folder)
        && maps.key == job.key
    {
        let notes = job.notes.clone();
        return Ok(Bake { maps, notes });
    }
    let file = folder.join(PARTIAL);
    let in_file = |error| BakeError::Partial {
        file: file.clone(),
        error,
    };
    let (mut partial, known) = PartialFile::open(&file, job.key).map_err(in_file)?;
    let batches = job.cast(known, |batch| partial.append(batch).map_err(in_file), progress)?;
    let bake = job.finish(&batches)?;
    bake.maps.save(folder)?;
    partial.remove().map_err(in_file)?;
    Ok(bake)
}

/// A bake whose surfaces are laid flat.
struct Job<'a> {
    scene: StillScene,
    charts: Vec<Chart>,
    notes: Vec<BakeNote>,
    path: &'a LightPath,
    settings: &'a BakeSettings,
    /// Hash of everything that the result depends on.
    key: u64,
}

impl<'a> Job<'a> {
    fn new(world: &mut World, path: &'a LightPath, settings: &'a BakeSettings) -> Result<Self, BakeError> {
        path.check()?;
        let density = settings.texels_per_metre;
        if !(density > 0.0 && density.is_finite()) {
            return Err(BakeError::Setting {
                setting: "texels_per_metre",
                value: density,
                allowed: "finite and greater than 0",
            });
        }
        if !(16..=MAX_SIZE).contains(&settings.page_size) {
            return Err(BakeError::Setting {
                setting: "page_size",
                value: settings.page_size as f32,
                allowed: "from 16 to 4096",
            });
        }
        let scene = gather(world, &settings.moving);
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
        let key = key_of(&scene.surfaces, &charts, path, settings);
        Ok(Self {
            scene,
            charts,
            notes,
            path,
            settings,
            key,
        })
    }

    /// Casts the rays of all texels, except of the batches that are known. Hands each new batch to `save`.
    fn cast(
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
        let targets = Targets::new(self.path, self.settings.casts_for);
        let mut skip = batches.len();
        let mut waiting: Vec<(&Chart, Texel)> = Vec::new();
        let mut charts = self.charts.iter();
        loop {
            while waiting.len() < BATCH {
                let Some(chart) = charts.next() else { break };
                waiting.extend(texels_of(chart).into_iter().map(|texel| (chart, texel)));
            }
            if waiting.is_empty() {
                return Ok(batches);
            }
            let rest = waiting.split_off(BATCH.min(waiting.len()));
            let texels = std::mem::replace(&mut waiting, rest);
            if skip > 0 {
                skip -= 1;
                continue;
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
    fn finish(mut self, batches: &[Batch]) -> Result<Bake, BakeError> {
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
        if most_intervals == 0 {
            self.notes.push(BakeNote::NeverSeen);
        }
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
        Ok(Bake {
            maps,
            notes: self.notes,
        })
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

/// Lists the surfaces and where their corners are on the pages. Triangles without a chart have corners at 0.
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
            corners.resize(first + 3 * surface.triangles.len(), Corner::default());
        }
        baked.push(BakedSurface {
            mesh: surface.mesh.clone(),
            hash: surface.hash,
            world_from_local: surface.world_from_local,
            is_two_sided: surface.is_two_sided,
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

/// Hash of everything that the maps depend on: surfaces and their places, charts, path and settings.
fn key_of(surfaces: &[Surface], charts: &[Chart], path: &LightPath, settings: &BakeSettings) -> u64 {
    let mut hash = StableHash::default();
    for surface in surfaces {
        hash.add(surface.hash);
        surface
            .world_from_local
            .into_iter()
            .for_each(|value| hash.add_float(value));
        hash.add(u64::from(surface.is_two_sided) | u64::from(surface.receives) << 1);
        // Whether it blocks rays.
        let blocks = surface
            .triangles
            .iter()
            .flatten()
            .filter(|triangle| triangle.slot.is_some());
        hash.add(blocks.count() as u64);
    }
    for chart in charts {
        hash.add(u64::from(chart.surface) << 32 | chart.triangles.len() as u64);
        hash.add(u64::from(chart.size.x) << 32 | u64::from(chart.size.y));
        for texel in chart.triangles.iter().flat_map(|triangle| triangle.texels) {
            hash.add_float(texel.x);
            hash.add_float(texel.y);
        }
    }
    hash.add_bytes(format!("{path:?}").as_bytes());
    hash.add_float(settings.texels_per_metre);
    hash.add(u64::from(settings.casts_for));
    hash.value()
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_transform::prelude::GlobalTransform;
    use glam::Vec3;

    use super::*;
    use crate::scene::{Material, MeshData, SceneMaterials, SceneMesh, ShadowCaster, ShadowReceiver};

    /// A board over a ground.
    fn world() -> World {
        let mut world = World::new();
        for (size, height) in [(2.0, 0.0), (0.5, 1.0)] {
            world.spawn((
                SceneMesh(Arc::new(MeshData::plane(size))),
                SceneMaterials([Arc::new(Material::matte(Vec3::ONE))].into()),
                (ShadowCaster, ShadowReceiver),
                GlobalTransform::from_xyz(0.0, height, 0.0),
            ));
        }
        world
    }

    fn path() -> LightPath {
        LightPath::Arc {
            direction: Vec3::NEG_X,
            axis: Vec3::Z,
            degrees: 180.0,
        }
    }

    fn settings() -> BakeSettings {
        BakeSettings {
            texels_per_metre: 4.0,
            ..Default::default()
        }
    }

    /// The maps without what depends on the clock.
    fn timeless(mut maps: IntervalMaps) -> IntervalMaps {
        maps.statistics.seconds = 0.0;
        maps
    }

    #[test]
    fn a_bake_that_was_interrupted_goes_on_and_gives_the_same() {
        let folder = std::env::temp_dir().join(format!("antumbra-{}-resumed", std::process::id()));
        let (path, settings) = (path(), settings());
        let whole = bake_intervals(&mut world(), &path, &settings, |_| ()).expect("it is baked");
        let job = Job::new(&mut world(), &path, &settings).expect("it can be baked");
        let (mut partial, known) = PartialFile::open(&folder.join(PARTIAL), job.key).expect("a new file");
        let mut left = 3;
        let interrupted = job.cast(
            known,
            |batch| {
                left -= 1;
                partial.append(batch).expect("it is written");
                if left == 0 {
                    Err(BakeError::Nothing)
                } else {
                    Ok(())
                }
            },
            |_| (),
        );
        assert!(interrupted.is_err());
        drop(partial);
        let mut first = None;
        let resumed = bake_into(&folder, &mut world(), &path, &settings, |progress| {
            first.get_or_insert(progress);
        });
        let resumed = resumed.expect("it is baked");
        assert_eq!(first.expect("progress").resumed, 3 * BATCH as u64);
        assert_eq!(timeless(resumed.maps), timeless(whole.maps));
        assert!(!folder.join(PARTIAL).exists());
        std::fs::remove_dir_all(&folder).expect("it is removed");
    }

    #[test]
    fn the_ground_below_a_board_is_dark_at_noon_and_lit_from_the_sides() {
        let bake = bake_intervals(&mut world(), &path(), &settings(), |_| ()).expect("it is baked");
        let maps = bake.maps;
        assert_eq!(bake.notes, []);
        let ground = maps
            .surfaces
            .iter()
            .find(|surface| surface.world_from_local[10] == 0.0);
        let ground = ground.expect("the ground is baked");
        let corners = &maps.corners[ground.corners.start as usize..ground.corners.end as usize];
        let middle = corners[..3].iter().map(|corner| corner.texel).sum::<glam::Vec2>() / 3.0;
        // The middle of the plane is that of the first triangle's longest side.
        let middle = middle + ((corners[0].texel + corners[2].texel) * 0.5 - middle) * 0.99;
        let at = |time: f32| maps.visibility(corners[0].page, middle, &maps.window(time, 0.0));
        assert!(
            at(0.5) < 0.01 && at(0.1) > 0.99 && at(0.9) > 0.99,
            "{} {} {}",
            at(0.1),
            at(0.5),
            at(0.9)
        );
        // Seen from the middle, the board reaches 26.6 degrees to each side: atan(0.5).
        let lit = maps.visibility(corners[0].page, middle, &maps.window(0.5, 1.0));
        assert!((lit - (1.0 - 2.0 * 26.57 / 180.0)).abs() < 0.04, "{lit}");
        assert!(maps.statistics.most_intervals == 2 && maps.statistics.rays > 0);
    }

    #[test]
    fn objects_that_will_move_are_left_out() {
        let mut world = world();
        let board = world
            .query::<(Entity, &GlobalTransform)>()
            .iter(&world)
            .find(|(_, place)| place.translation().y > 0.5)
            .expect("the board")
            .0;
        let settings = BakeSettings {
            moving: vec![board],
            ..settings()
        };
        let maps = bake_intervals(&mut world, &path(), &settings, |_| ())
            .expect("it is baked")
            .maps;
        assert_eq!((maps.surfaces.len(), maps.statistics.most_intervals), (1, 1));
    }
}
