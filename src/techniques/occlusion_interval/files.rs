//! Maps on disk.
//!
//! ```text
//! maps.json                    what the maps are of; sizes and hashes of the other files
//! corners.bin                  12 bytes a corner, little endian: page (u32), x, y (f32), texels
//! page<p>.pair<q>.rise.png     RGBA, 8 bits: first steps of four intervals
//! page<p>.pair<q>.fall.png     RGBA, 8 bits: last steps of four intervals
//! ```
//!
//! Step `i` of 256 lasts from `i / 256` to `(i + 1) / 256` of the path. A channel whose fall is before its rise is empty.
//! The manifest is written last, so an interrupted write leaves no maps that look whole.

use std::path::Path;

use glam::Vec2;

use super::manifest::{
    FORMAT, Manifest, ManifestCorners, ManifestStatistics, ManifestSurface, VERSION, check_manifest,
    light_path, manifest_path,
};
use super::maps::{BakeStatistics, BakedSurface, Corner, IntervalMaps, Page, Pair};
use super::maps_error::{MapsError, content};
use super::surface::StableHash;

/// Name of the manifest.
pub const MANIFEST: &str = "maps.json";

const CORNERS: &str = "corners.bin";

/// Bytes of a corner in its file.
const CORNER_BYTES: usize = 12;

fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

fn picture_name(page: usize, pair: usize, edge: &str) -> String {
    format!("page{page}.pair{pair}.{edge}.png")
}

fn pair_hash(pair: &Pair) -> String {
    let mut hash = StableHash::default();
    hash.add_bytes(&pair.rise);
    hash.add_bytes(&pair.fall);
    hex(hash.value())
}

fn bytes_hash(bytes: &[u8]) -> String {
    let mut hash = StableHash::default();
    hash.add_bytes(bytes);
    hex(hash.value())
}

fn corner_bytes(corners: &[Corner]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(corners.len() * CORNER_BYTES);
    for corner in corners {
        bytes.extend(corner.page.to_le_bytes());
        bytes.extend(corner.texel.x.to_le_bytes());
        bytes.extend(corner.texel.y.to_le_bytes());
    }
    bytes
}

fn corner_of(bytes: &[u8]) -> Corner {
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    Corner {
        page: u32::from_le_bytes(word(0)),
        texel: Vec2::new(f32::from_le_bytes(word(4)), f32::from_le_bytes(word(8))),
    }
}

impl IntervalMaps {
    /// Writes the maps into a folder, which is made if it is missing. Older maps in it are removed.
    ///
    /// # Errors
    /// [`MapsError`] names the file.
    pub fn save(&self, folder: &Path) -> Result<(), MapsError> {
        let in_file = |file: &Path| {
            let file = file.to_owned();
            move |error| MapsError::File { file, error }
        };
        std::fs::create_dir_all(folder).map_err(in_file(folder))?;
        remove_old(folder).map_err(in_file(folder))?;
        for (page_index, page) in self.pages.iter().enumerate() {
            for (pair_index, pair) in page.pairs.iter().enumerate() {
                for (edge, texels) in [("rise", &pair.rise), ("fall", &pair.fall)] {
                    let file = folder.join(picture_name(page_index, pair_index, edge));
                    let format = image::ExtendedColorType::Rgba8;
                    image::save_buffer(&file, texels, self.size, self.size, format)
                        .map_err(|error| MapsError::Picture { file, error })?;
                }
            }
        }
        let corners = corner_bytes(&self.corners);
        let file = folder.join(CORNERS);
        std::fs::write(&file, &corners).map_err(in_file(&file))?;
        let manifest = self.manifest(&corners);
        let file = folder.join(MANIFEST);
        let text = serde_json::to_string_pretty(&manifest).map_err(|error| MapsError::Manifest {
            file: file.clone(),
            error,
        })?;
        std::fs::write(&file, text).map_err(in_file(&file))
    }

    fn manifest(&self, corners: &[u8]) -> Manifest {
        let surface = |surface: &BakedSurface| ManifestSurface {
            mesh: surface.mesh.clone(),
            hash: hex(surface.hash),
            world_from_local: surface.world_from_local,
            two_sided: surface.is_two_sided,
            corners: [surface.corners.start, surface.corners.end],
        };
        let statistics = self.statistics;
        Manifest {
            format: FORMAT.to_owned(),
            version: VERSION,
            key: hex(self.key),
            path: manifest_path(&self.path),
            texels_per_metre: self.texels_per_metre,
            size: self.size,
            pages: self
                .pages
                .iter()
                .map(|page| page.pairs.iter().map(pair_hash).collect())
                .collect(),
            corners: ManifestCorners {
                count: self.corners.len() as u32,
                hash: bytes_hash(corners),
            },
            surfaces: self.surfaces.iter().map(surface).collect(),
            statistics: ManifestStatistics {
                texels: statistics.texels,
                rays: statistics.rays,
                seconds: statistics.seconds,
                most_intervals: statistics.most_intervals,
                coarser_charts: statistics.coarser_charts,
            },
        }
    }

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
        Ok(Self {
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
        })
    }
}

/// Removes the manifest of older maps, and their pictures.
fn remove_old(folder: &Path) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name == MANIFEST || (name.starts_with("page") && name.ends_with(".png")) {
            std::fs::remove_file(entry.path())?;
        }
    }
    Ok(())
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
    let load = |edge: &str| {
        let file = folder.join(picture_name(page, pair, edge));
        let bytes = read(&file)?;
        let decoded = image::load_from_memory_with_format(&bytes, image::ImageFormat::Png);
        let picture = match decoded {
            Ok(image::DynamicImage::ImageRgba8(picture)) => picture,
            Ok(other) => {
                return Err(content(
                    &file,
                    "texels",
                    format!("{:?} is not Rgba8", other.color()),
                ));
            }
            Err(error) => return Err(MapsError::Picture { file, error }),
        };
        if picture.dimensions() != (size, size) {
            let (width, height) = picture.dimensions();
            let problem = format!("{width}×{height} texels are not {size}×{size}");
            return Err(content(&file, "size", problem));
        }
        Ok(picture.into_raw())
    };
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

fn load_corners(folder: &Path, manifest: &Manifest) -> Result<Vec<Corner>, MapsError> {
    let file = folder.join(CORNERS);
    let bytes = read(&file)?;
    let expected = manifest.corners.count as usize * CORNER_BYTES;
    if bytes.len() != expected {
        let problem = format!("{} bytes are not {expected}", bytes.len());
        return Err(content(&file, "length", problem));
    }
    if bytes_hash(&bytes) != manifest.corners.hash {
        let problem = "they are not those of the manifest: bake the maps again";
        return Err(content(&file, "corners", problem));
    }
    let corners: Vec<Corner> = bytes.chunks_exact(CORNER_BYTES).map(corner_of).collect();
    for (index, corner) in corners.iter().enumerate() {
        if corner.page as usize >= manifest.pages.len().max(1) || !corner.texel.is_finite() {
            let problem = format!("page {} of {}", corner.page, manifest.pages.len());
            return Err(content(&file, format!("corner {index}"), problem));
        }
    }
    Ok(corners)
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
        corners: surface.corners[0]..surface.corners[1],
    })
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use glam::Vec3;

    use super::super::intervals::intervals_of;
    use super::*;
    use crate::scene::LightPath;

    fn maps() -> IntervalMaps {
        let mut page = Page::dark(4, 2);
        page.write(5, &intervals_of(|step| step % 40 < 3));
        let corner = |at: u32| Corner {
            page: 0,
            texel: Vec2::new(at as f32, 0.25),
        };
        IntervalMaps {
            key: 0x0123_4567_89ab_cdef,
            path: LightPath::Sun {
                latitude_degrees: 50.3,
                day: 172.0,
                hours: [0.1, 23.7],
            },
            texels_per_metre: 8.1,
            size: 4,
            pages: vec![page, Page::dark(4, 1)],
            surfaces: vec![BakedSurface {
                mesh: "a \"mesh\"".to_owned(),
                hash: u64::MAX,
                world_from_local: std::array::from_fn(|i| 0.1 * i as f32),
                is_two_sided: true,
                corners: 0..3,
            }],
            corners: (0..3).map(corner).collect(),
            statistics: BakeStatistics {
                texels: 7,
                rays: 1 << 40,
                seconds: 0.1,
                most_intervals: 7,
                coarser_charts: 1,
            },
        }
    }

    /// A folder with the maps, gone when it is dropped.
    struct Scratch(PathBuf);

    impl Scratch {
        fn new(name: &str) -> Self {
            let folder = std::env::temp_dir().join(format!("antumbra-{}-{name}", std::process::id()));
            maps().save(&folder).expect("they are saved");
            Self(folder)
        }

        fn change(&self, file: &str, change: impl FnOnce(Vec<u8>) -> Vec<u8>) -> String {
            let path = self.0.join(file);
            let bytes = std::fs::read(&path).expect("the file");
            std::fs::write(&path, change(bytes.clone())).expect("it is written");
            let error = IntervalMaps::load(&self.0)
                .expect_err("it is noticed")
                .to_string();
            std::fs::write(&path, bytes).expect("it is put back");
            assert!(
                error.contains(file) || error.contains(&file.replace("fall", "rise")),
                "{error}"
            );
            error
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            let _ = std::fs::remove_dir_all(&self.0);
        }
    }

    #[test]
    fn maps_are_read_as_they_were_written() {
        let scratch = Scratch::new("round");
        assert_eq!(IntervalMaps::load(&scratch.0).expect("they are read"), maps());
        for path in [
            LightPath::Positions(vec![Vec3::new(0.1, -2.5, 1e-7), Vec3::X]),
            LightPath::Arc {
                direction: Vec3::NEG_Y,
                axis: Vec3::Z,
                degrees: 33.3,
            },
        ] {
            assert_eq!(light_path(manifest_path(&path)), path);
        }
    }

    #[test]
    fn truncated_and_foreign_files_are_named_with_the_element() {
        let scratch = Scratch::new("faults");
        let cut = |bytes: Vec<u8>| bytes[..bytes.len() / 2].to_vec();
        for file in [
            "page0.pair1.rise.png",
            "page1.pair0.fall.png",
            "corners.bin",
            MANIFEST,
        ] {
            scratch.change(file, cut);
        }
        assert!(scratch.change("corners.bin", cut).contains("18 bytes are not 36"));
        let other = std::fs::read(scratch.0.join("page1.pair0.rise.png")).expect("the file");
        assert!(
            scratch
                .change("page0.pair0.rise.png", |_| other)
                .contains("bake the maps again")
        );
        assert!(
            scratch
                .change("page0.pair0.fall.png", |_| b"no picture".to_vec())
                .contains("fall")
        );
        let text = |from: &'static str, to: &'static str| {
            move |bytes: Vec<u8>| {
                String::from_utf8(bytes)
                    .expect("text")
                    .replace(from, to)
                    .into_bytes()
            }
        };
        for (from, to, element) in [
            ("\"version\": 1", "\"version\": 2", "version"),
            ("interval maps", "cookies", "format"),
            ("\"size\": 4", "\"size\": 8", "size"),
            ("\"size\": 4", "\"size\": 99999", "size"),
            ("\"count\": 3", "\"count\": 6", "corners.count"),
            ("ffffffffffffffff", "nothing", "surfaces[0].hash"),
            ("texels_per_metre", "texels", "texels"),
        ] {
            let path = scratch.0.join(MANIFEST);
            let bytes = std::fs::read(&path).expect("the file");
            std::fs::write(&path, text(from, to)(bytes.clone())).expect("it is written");
            let error = IntervalMaps::load(&scratch.0)
                .expect_err("it is noticed")
                .to_string();
            std::fs::write(&path, bytes).expect("it is put back");
            assert!(error.contains(element), "{element}: {error}");
        }
        std::fs::remove_file(scratch.0.join("page0.pair1.fall.png")).expect("it is removed");
        let error = IntervalMaps::load(&scratch.0)
            .expect_err("it is noticed")
            .to_string();
        assert!(error.contains("page0.pair1.fall.png"), "{error}");
    }
}
