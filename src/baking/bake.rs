//! Bakes the maps of one light, in memory or into a folder.

use std::path::Path;

use bevy_ecs::prelude::*;

use super::job::Job;
use super::partial::PartialFile;
use super::settings::{Bake, BakeError, BakeProgress, BakeSettings};
use crate::scene::LightPath;
use crate::techniques::occlusion_interval::MANIFEST;
use crate::techniques::occlusion_interval::maps::IntervalMaps;

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

/// Bakes like [`bake_intervals`] and writes the maps into a folder. An interrupted bake is resumed. Maps in the folder that
/// were baked from the same scene, path and settings are returned as they are. Waits while another bake, also of another
/// process, writes into the folder.
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
    let file = folder.join(PARTIAL);
    let in_file = |error| BakeError::Partial {
        file: file.clone(),
        error,
    };
    if let Some(maps) = finished(folder, job.key) {
        // It was left if the bake was interrupted between saving the maps and removing it.
        PartialFile::remove_left(&file).map_err(in_file)?;
        return Ok(job.bake_of(maps));
    }
    let (mut partial, known) = PartialFile::open(&file, job.key).map_err(in_file)?;
    // Another bake may have written them while this one waited for its file.
    if let Some(maps) = finished(folder, job.key) {
        partial.remove().map_err(in_file)?;
        return Ok(job.bake_of(maps));
    }
    let batches = job.cast(known, |batch| partial.append(batch).map_err(in_file), progress)?;
    let bake = job.finish(&batches)?;
    bake.maps.save(folder)?;
    partial.remove().map_err(in_file)?;
    Ok(bake)
}

/// The maps in a folder, if they are whole and of the bake with this key.
fn finished(folder: &Path, key: u64) -> Option<IntervalMaps> {
    if !folder.join(MANIFEST).exists() {
        return None;
    }
    IntervalMaps::load(folder).ok().filter(|maps| maps.key == key)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use bevy_transform::prelude::GlobalTransform;
    use glam::Vec3;

    use super::*;
    use crate::baking::BakeNote;
    use crate::baking::partial::BATCH;
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

    /// Both bakes give the same maps, and no error.
    #[test]
    fn two_bakes_of_one_folder_at_once_end_well() {
        let folder = std::env::temp_dir().join(format!("antumbra-{}-at-once", std::process::id()));
        let bake = || bake_into(&folder, &mut world(), &path(), &settings(), |_| ());
        std::thread::scope(|threads| {
            let bakes = [threads.spawn(bake), threads.spawn(bake)];
            let [first, second] = bakes.map(|bake| bake.join().expect("no panic").expect("it is baked"));
            assert_eq!(timeless(first.maps), timeless(second.maps));
        });
        assert!(!folder.join(PARTIAL).exists() && IntervalMaps::load(&folder).is_ok());
        std::fs::remove_dir_all(&folder).expect("it is removed");
    }

    #[test]
    fn finished_maps_keep_their_notes_and_no_file_of_a_bake_stays() {
        let folder = std::env::temp_dir().join(format!("antumbra-{}-finished", std::process::id()));
        let night = LightPath::Sun {
            latitude_degrees: 85.0,
            day: 355.0,
            hours: [0.0, 24.0],
        };
        let bake = || bake_into(&folder, &mut world(), &night, &settings(), |_| ()).expect("it is baked");
        assert_eq!(bake().notes, [BakeNote::NeverSeen]);
        // As if the bake had been interrupted after it saved the maps.
        let (partial, _) = PartialFile::open(&folder.join(PARTIAL), 7).expect("a file");
        drop(partial);
        assert_eq!(bake().notes, [BakeNote::NeverSeen]);
        assert!(!folder.join(PARTIAL).exists());
        std::fs::write(folder.join(PARTIAL), "a user's").expect("it is written");
        assert_eq!(bake().notes.len(), 1);
        assert!(folder.join(PARTIAL).exists(), "it is no file of ours");
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
