//! The maps that lights of a world use, by the folder that they are in.

use std::collections::HashMap;
use std::path::{Component, Path, PathBuf};
use std::sync::Arc;
use std::time::SystemTime;

use bevy_ecs::prelude::Resource;

use super::maps::IntervalMaps;

/// The folder that the names of maps are relative to. Default: the current one; in Bevy that of the assets.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct IntervalFolder(pub PathBuf);

/// The maps of a world, by the name in [`OcclusionInterval::maps`](super::OcclusionInterval::maps).
///
/// A name that is not here is read from the folder of that name ([`IntervalFolder`]), which takes as long as decoding its
/// pictures takes. Maps that were read are dropped some seconds after no light of the world names them any more. A folder that cannot be read is
/// read again when its manifest changes, as it does when a bake ends.
///
/// In Bevy every camera has a library of its own, which reads the folders for itself.
#[derive(Resource, Clone, Debug, Default)]
pub struct IntervalLibrary {
    known: HashMap<String, Entry>,
    /// The folder that read maps are relative to.
    folder: PathBuf,
}

/// Maps of one name.
#[derive(Clone, Debug)]
struct Entry {
    maps: Result<Arc<IntervalMaps>, String>,
    /// Where the maps were read from, and the state of their manifest before; `None` for maps that were inserted.
    read: Option<(PathBuf, Stamp)>,
    /// Number of frames since a light named them.
    unused_frames: u32,
}

/// Number of frames for which maps that no light names are kept. A light that is switched off and on again finds them.
const KEPT_FRAMES: u32 = 600;

/// Time and length of a manifest; `None` if there is none.
type Stamp = Option<(SystemTime, u64)>;

impl IntervalLibrary {
    /// Adds maps that are in memory. Maps of the same name are replaced. Lights report maps that are not whole
    /// ([`IntervalMaps::check`]).
    pub fn insert(&mut self, name: impl Into<String>, maps: Arc<IntervalMaps>) {
        let maps = match maps.check() {
            Ok(()) => Ok(maps),
            Err(fault) => Err(fault.to_string()),
        };
        let entry = Entry {
            maps,
            read: None,
            unused_frames: 0,
        };
        self.known.insert(name.into(), entry);
    }

    /// Forgets maps, so that their folder is read again.
    pub fn forget(&mut self, name: &str) {
        self.known.remove(name);
    }

    /// The maps of a name, or why there are none. `None` if nobody has asked for them yet.
    pub fn get(&self, name: &str) -> Option<Result<&Arc<IntervalMaps>, &str>> {
        let known = self.known.get(name)?;
        Some(known.maps.as_ref().map_err(String::as_str))
    }

    /// Reads the maps of a name unless they are known. Folders that could not be read are read again when their manifest
    /// has changed.
    pub(super) fn read(&mut self, name: &str, folder: &IntervalFolder) {
        if self.folder != folder.0 {
            self.folder.clone_from(&folder.0);
            self.known.retain(|_, entry| entry.read.is_none());
        }
        if let Some(entry) = self.known.get(name) {
            let is_stale = match (&entry.maps, &entry.read) {
                (Err(_), Some((folder, stamp))) => stamp_of(folder) != *stamp,
                _ => false,
            };
            if !is_stale {
                return;
            }
        }
        // `maps` and `./maps` are one folder, whose maps are read once.
        let folder: PathBuf = folder.0.join(name).components().filter(is_step).collect();
        let read = Some((folder.clone(), stamp_of(&folder)));
        let known = self
            .known
            .values()
            .find(|entry| entry.read == read && entry.maps.is_ok());
        let maps = known.map_or_else(|| load(&folder).map(Arc::new), |entry| entry.maps.clone());
        let entry = Entry {
            maps,
            read,
            unused_frames: 0,
        };
        self.known.insert(name.to_owned(), entry);
    }

    /// Drops maps that were read and that no light has named for [`KEPT_FRAMES`] frames.
    pub(super) fn end_frame(&mut self, is_named: impl Fn(&str) -> bool) {
        self.known.retain(|name, entry| {
            let is_used = entry.read.is_none() || is_named(name);
            entry.unused_frames = if is_used { 0 } else { entry.unused_frames + 1 };
            entry.unused_frames <= KEPT_FRAMES
        });
    }

    /// Reads the maps of a name, whether they are known or not.
    ///
    /// # Errors
    /// Fault of the files, which lights that use them report too.
    pub(super) fn read_again(&mut self, name: &str, folder: &IntervalFolder) -> Result<(), String> {
        self.known.remove(name);
        self.read(name, folder);
        match self.get(name) {
            Some(Err(error)) => Err(error.to_owned()),
            _ => Ok(()),
        }
    }
}

/// Whether a part of a path leads elsewhere.
fn is_step(part: &Component) -> bool {
    *part != Component::CurDir
}

#[cfg(any(feature = "render", feature = "reference"))]
fn stamp_of(folder: &Path) -> Stamp {
    let manifest = std::fs::metadata(folder.join(super::MANIFEST)).ok()?;
    Some((manifest.modified().ok()?, manifest.len()))
}

#[cfg(any(feature = "render", feature = "reference"))]
fn load(folder: &Path) -> Result<IntervalMaps, String> {
    let loaded = IntervalMaps::load(folder);
    loaded.map_err(|error| error.to_string().replace('\n', " "))
}

#[cfg(not(any(feature = "render", feature = "reference")))]
fn stamp_of(_: &Path) -> Stamp {
    None
}

#[cfg(not(any(feature = "render", feature = "reference")))]
fn load(_: &Path) -> Result<IntervalMaps, String> {
    Err("folders are read with the feature `render` or `reference` only".to_owned())
}

#[cfg(all(test, any(feature = "render", feature = "reference")))]
mod tests {
    use super::super::maps::{BakeStatistics, Page};
    use super::*;
    use crate::scene::LightPath;
    use glam::Vec3;

    fn maps() -> IntervalMaps {
        IntervalMaps {
            key: 5,
            path: LightPath::Arc {
                direction: Vec3::NEG_Y,
                axis: Vec3::Z,
                degrees: 90.0,
            },
            texels_per_metre: 8.0,
            size: 4,
            pages: vec![Page::dark(4, 1)],
            surfaces: Vec::new(),
            corners: Vec::new(),
            statistics: BakeStatistics::default(),
        }
    }

    #[test]
    fn a_folder_that_could_not_be_read_is_read_again_once_it_was_baked() {
        let base = std::env::temp_dir().join(format!("antumbra-{}-library", std::process::id()));
        let folder = IntervalFolder(base.clone());
        let mut library = IntervalLibrary::default();
        library.read("maps", &folder);
        assert!(library.get("maps").is_some_and(|maps| maps.is_err()));
        maps().save(&base.join("maps")).expect("they are saved");
        library.read("maps", &folder);
        let read = library.get("maps").expect("it is known").expect("it was read");
        assert_eq!(**read, maps());
        let first = read.clone();
        library.read("maps", &folder);
        let again = library.get("maps").expect("it is known").expect("it was read");
        assert!(Arc::ptr_eq(&first, again), "once");
        for same in ["./maps", "maps/", "././maps/."] {
            library.read(same, &folder);
            let read = library.get(same).expect("it is known").expect("it was read");
            assert!(Arc::ptr_eq(&first, read), "{same} is the same folder");
        }
        library.read("maps", &IntervalFolder(base.join("elsewhere")));
        assert!(
            library.get("maps").is_some_and(|maps| maps.is_err()),
            "names are relative"
        );
        std::fs::remove_dir_all(&base).expect("it is removed");
    }

    #[test]
    fn maps_that_no_light_names_are_dropped_and_inserted_ones_are_not() {
        let mut library = IntervalLibrary::default();
        library.insert("own", Arc::new(maps()));
        library.read("no/such/folder", &IntervalFolder::default());
        for _ in 0..KEPT_FRAMES {
            library.end_frame(|_| false);
        }
        assert!(library.get("no/such/folder").is_some());
        library.end_frame(|name| name == "no/such/folder");
        library.end_frame(|_| false);
        assert!(library.get("no/such/folder").is_some(), "it was named in between");
        for _ in 0..KEPT_FRAMES {
            library.end_frame(|_| false);
        }
        assert!(library.get("no/such/folder").is_none() && library.get("own").is_some());
    }

    #[test]
    fn maps_that_are_not_whole_are_not_used() {
        let mut library = IntervalLibrary::default();
        let mut broken = maps();
        broken.size = 5;
        library.insert("broken", Arc::new(broken));
        let error = library
            .get("broken")
            .expect("it is known")
            .expect_err("it is broken");
        assert!(error.contains("pages[0].pairs[0]"), "{error}");
    }
}
