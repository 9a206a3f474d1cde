//! Reading of maps from their folder. Nothing in the files is believed: sizes are compared before memory is taken, hashes
//! afterwards.

use std::io::Cursor;
use std::path::Path;

use glam::Vec2;
use image::codecs::png::PngDecoder;
use image::{ColorType, ImageDecoder};

use super::files::{CORNER_BYTES, CORNERS, MANIFEST, bytes_hash, pair_hash, picture_name};
use super::intervals::PER_PAIR;
use super::manifest::{Manifest, ManifestSurface, check_manifest, light_path};
use super::maps::{BakeStatistics, BakedSurface, Corner, IntervalMaps, Page, Pair};
use super::maps_error::{MapsError, content};

impl IntervalMaps {
    /// Reads the maps of a folder.
    ///
    /// # Errors
    /// [`MapsError`] names the file and the element: what is missing, truncated, of another size, or not of these maps.
    pub fn load(folder: &Path) -> Result<Self, MapsError> {
        let file = folder.join(MANIFEST);
        let bytes = read(&file)?;
        let manifest: Manifest = serde_json::from_slice(&bytes).map_err(|error| MapsError::Manifest {
            file: file.clone(),
            error,
        })?;
        check_manifest(&manifest, &file)?;
        let mut pages = Vec::with_capacity(manifest.pages.len());
        for (page_index, hashes) in manifest.pages.iter().enumerate() {
            let mut page = Page::default();
            for (pair_index, hash) in hashes.iter().enumerate() {
                page.pairs
                    .push(load_pair(folder, (page_index, pair_index), manifest.size, hash)?);
            }
            pages.push(page);
        }
        let corners = load_corners(folder, &manifest)?;
        let key = hash_of(&manifest.key, &file, "key")?;
        let mut surfaces = Vec::with_capacity(manifest.surfaces.len());
        for (index, surface) in manifest.surfaces.into_iter().enumerate() {
            surfaces.push(baked_surface(surface, index, &file)?);
        }
        let statistics = manifest.statistics;
        let maps = Self {
            key,
            path: light_path(manifest.path),
            texels_per_metre: manifest.texels_per_metre,
            size: manifest.size,
            pages,
            surfaces,
            corners,
            statistics: BakeStatistics {
                texels: statistics.texels,
                rays: statistics.rays,
                seconds: statistics.seconds,
                most_intervals: statistics.most_intervals,
                coarser_charts: statistics.coarser_charts,
            },
        };
        maps.check()
            .map_err(|fault| content(&file, fault.element, fault.problem))?;
        Ok(maps)
    }
}

fn read(file: &Path) -> Result<Vec<u8>, MapsError> {
    std::fs::read(file).map_err(|error| MapsError::File {
        file: file.to_owned(),
        error,
    })
}

fn load_pair(
    folder: &Path,
    (page, pair): (usize, usize),
    size: u32,
    expected: &str,
) -> Result<Pair, MapsError> {
    let load = |edge: &str| load_picture(&folder.join(picture_name(page, pair, edge)), size);
    let loaded = Pair {
        rise: load("rise")?,
        fall: load("fall")?,
    };
    if pair_hash(&loaded) != expected {
        let file = folder.join(picture_name(page, pair, "rise"));
        return Err(content(
            &file,
            "texels",
            "they are not those of the manifest, or those of its fall are not: bake the maps again",
        ));
    }
    Ok(loaded)
}

/// Decodes a picture. Size and format are compared before memory is taken for the texels.
fn load_picture(file: &Path, size: u32) -> Result<Vec<u8>, MapsError> {
    let picture = |error| MapsError::Picture {
        file: file.to_owned(),
        error,
    };
    let decoder = PngDecoder::new(Cursor::new(read(file)?)).map_err(picture)?;
    if decoder.dimensions() != (size, size) {
        let (width, height) = decoder.dimensions();
        let problem = format!("{width}×{height} texels are not {size}×{size}");
        return Err(content(file, "size", problem));
    }
    if decoder.color_type() != ColorType::Rgba8 {
        let problem = format!("{:?} is not Rgba8", decoder.color_type());
        return Err(content(file, "texels", problem));
    }
    let mut texels = vec![0; size as usize * size as usize * PER_PAIR];
    decoder.read_image(&mut texels).map_err(picture)?;
    Ok(texels)
}

fn corner_of(bytes: &[u8]) -> Corner {
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    Corner {
        page: u32::from_le_bytes(word(0)),
        texel: Vec2::new(f32::from_le_bytes(word(4)), f32::from_le_bytes(word(8))),
    }
}

fn load_corners(folder: &Path, manifest: &Manifest) -> Result<Vec<Corner>, MapsError> {
    let file = folder.join(CORNERS);
    let expected = u64::from(manifest.corners.count) * CORNER_BYTES as u64;
    let length = std::fs::metadata(&file).map(|metadata| metadata.len());
    let length = length.map_err(|error| MapsError::File {
        file: file.clone(),
        error,
    })?;
    if length != expected {
        let problem = format!("{length} bytes are not {expected}");
        return Err(content(&file, "length", problem));
    }
    let bytes = read(&file)?;
    if bytes_hash(&bytes) != manifest.corners.hash {
        let problem = "they are not those of the manifest: bake the maps again";
        return Err(content(&file, "corners", problem));
    }
    Ok(bytes.chunks_exact(CORNER_BYTES).map(corner_of).collect())
}

fn hash_of(text: &str, file: &Path, element: &str) -> Result<u64, MapsError> {
    u64::from_str_radix(text, 16).map_err(|_| content(file, element, format!("\"{text}\" is no hash")))
}

fn baked_surface(surface: ManifestSurface, index: usize, file: &Path) -> Result<BakedSurface, MapsError> {
    Ok(BakedSurface {
        hash: hash_of(&surface.hash, file, &format!("surfaces[{index}].hash"))?,
        mesh: surface.mesh,
        world_from_local: surface.world_from_local,
        is_two_sided: surface.two_sided,
        casts: surface.casts,
        corners: surface.corners[0]..surface.corners[1],
    })
}
