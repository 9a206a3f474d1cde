//! The maps that lights of a world use, by the folder that they are in.

use std::collections::HashMap;
use std::sync::Arc;

use bevy_ecs::prelude::*;

use super::maps::IntervalMaps;

/// The maps of a world, by the name in [`OcclusionInterval::maps`](super::OcclusionInterval::maps). A name that is not
/// here is read from the folder of that name, once; that takes as long as decoding its pictures takes.
///
/// In Bevy every camera has a library of its own, which reads the folders for itself.
#[derive(Resource, Clone, Debug, Default)]
pub struct IntervalLibrary {
    known: HashMap<String, Result<Arc<IntervalMaps>, String>>,
}

impl IntervalLibrary {
    /// Adds maps that are in memory. Maps of the same name are replaced.
    pub fn insert(&mut self, name: impl Into<String>, maps: Arc<IntervalMaps>) {
        self.known.insert(name.into(), Ok(maps));
    }

    /// Forgets maps, so that their folder is read again.
    pub fn forget(&mut self, name: &str) {
        self.known.remove(name);
    }

    /// The maps of a name, or why there are none. `None` if nobody has asked for them yet.
    pub fn get(&self, name: &str) -> Option<Result<&Arc<IntervalMaps>, &str>> {
        let known = self.known.get(name)?;
        Some(known.as_ref().map_err(String::as_str))
    }

    /// Reads the maps of a name unless they are known.
    pub(super) fn read(&mut self, name: &str) {
        if !self.known.contains_key(name) {
            self.known.insert(name.to_owned(), load(name).map(Arc::new));
        }
    }
}

#[cfg(any(feature = "render", feature = "reference"))]
fn load(name: &str) -> Result<IntervalMaps, String> {
    let loaded = IntervalMaps::load(std::path::Path::new(name));
    loaded.map_err(|error| error.to_string().replace('\n', " "))
}

#[cfg(not(any(feature = "render", feature = "reference")))]
fn load(_: &str) -> Result<IntervalMaps, String> {
    Err("folders are read with the feature `render` or `reference` only".to_owned())
}
