//! The manifest of maps on disk.

use std::path::Path;

use glam::Vec3;
use serde::{Deserialize, Serialize};

use super::maps_check::{MapsFault, check_pages, check_ranges};
use super::maps_error::{MapsError, content};
use crate::scene::LightPath;

/// Name of the format in the manifest.
pub(super) const FORMAT: &str = "antumbra occlusion interval maps";

/// Version of the format. It increases when older readers would misread newer files.
pub(super) const VERSION: u32 = 2;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Manifest {
    pub format: String,
    pub version: u32,
    pub key: String,
    pub path: ManifestPath,
    pub texels_per_metre: f32,
    pub size: u32,
    /// Hashes of the pairs of each page, those of rise and fall together.
    pub pages: Vec<Vec<String>>,
    pub corners: ManifestCorners,
    pub surfaces: Vec<ManifestSurface>,
    pub statistics: ManifestStatistics,
}

#[derive(Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub(super) enum ManifestPath {
    Arc {
        direction: [f32; 3],
        axis: [f32; 3],
        degrees: f32,
    },
    Sun {
        latitude_deg: f32,
        day: f32,
        hours: [f32; 2],
    },
    Positions(Vec<[f32; 3]>),
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ManifestCorners {
    pub count: u32,
    pub hash: String,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ManifestSurface {
    pub mesh: String,
    pub hash: String,
    pub world_from_local: [f32; 12],
    pub two_sided: bool,
    pub casts: bool,
    /// First and end.
    pub corners: [u32; 2],
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ManifestStatistics {
    pub texels: u64,
    pub rays: u64,
    pub seconds: f64,
    pub most_intervals: u32,
    pub coarser_charts: u32,
}

pub(super) fn manifest_path(path: &LightPath) -> ManifestPath {
    match path {
        LightPath::Arc {
            direction,
            axis,
            degrees,
        } => ManifestPath::Arc {
            direction: direction.to_array(),
            axis: axis.to_array(),
            degrees: *degrees,
        },
        LightPath::Sun {
            latitude_degrees,
            day,
            hours,
        } => ManifestPath::Sun {
            latitude_deg: *latitude_degrees,
            day: *day,
            hours: *hours,
        },
        LightPath::Positions(positions) => {
            ManifestPath::Positions(positions.iter().map(|position| position.to_array()).collect())
        }
    }
}

pub(super) fn light_path(path: ManifestPath) -> LightPath {
    match path {
        ManifestPath::Arc {
            direction,
            axis,
            degrees,
        } => LightPath::Arc {
            direction: direction.into(),
            axis: axis.into(),
            degrees,
        },
        ManifestPath::Sun {
            latitude_deg,
            day,
            hours,
        } => LightPath::Sun {
            latitude_degrees: latitude_deg,
            day,
            hours,
        },
        ManifestPath::Positions(positions) => {
            LightPath::Positions(positions.into_iter().map(Vec3::from).collect())
        }
    }
}

/// Checks the parts of the manifest that must be right before the files beside it are read.
pub(super) fn check_manifest(manifest: &Manifest, file: &Path) -> Result<(), MapsError> {
    if manifest.format != FORMAT {
        let problem = format!("\"{}\" is not \"{FORMAT}\"", manifest.format);
        return Err(content(file, "format", problem));
    }
    if manifest.version != VERSION {
        let problem = format!("{} is not {VERSION}: bake the maps again", manifest.version);
        return Err(content(file, "version", problem));
    }
    let as_content = |fault: MapsFault| content(file, fault.element, fault.problem);
    check_pages(manifest.size, manifest.pages.iter().map(Vec::len)).map_err(as_content)?;
    let ranges = manifest.surfaces.iter().map(|surface| {
        let [first, end] = surface.corners;
        first..end
    });
    check_ranges(ranges, manifest.corners.count as usize).map_err(as_content)
}
