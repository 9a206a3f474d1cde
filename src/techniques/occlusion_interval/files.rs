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

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder};

use super::manifest::{
    FORMAT, Manifest, ManifestCorners, ManifestStatistics, ManifestSurface, VERSION, manifest_path,
};
use super::maps::{BakedSurface, Corner, IntervalMaps, Pair};
use super::maps_error::MapsError;
use super::surface::StableHash;

/// Name of the manifest.
pub const MANIFEST: &str = "maps.json";

pub(super) const CORNERS: &str = "corners.bin";

/// Name of the manifest while it is written.
const UNFINISHED: &str = "maps.json.unfinished";

/// Bytes of a corner in its file.
pub(super) const CORNER_BYTES: usize = 12;

fn hex(hash: u64) -> String {
    format!("{hash:016x}")
}

pub(super) fn picture_name(page: usize, pair: usize, edge: &str) -> String {
    format!("page{page}.pair{pair}.{edge}.png")
}

pub(super) fn pair_hash(pair: &Pair) -> String {
    let mut hash = StableHash::default();
    hash.add_bytes(&pair.rise);
    hash.add_bytes(&pair.fall);
    hex(hash.value())
}

pub(super) fn bytes_hash(bytes: &[u8]) -> String {
    let mut hash = StableHash::default();
    hash.add_bytes(bytes);
    hex(hash.value())
}

/// Names the file of an operating system's error.
fn in_file(file: &Path) -> impl FnOnce(std::io::Error) -> MapsError {
    let file = file.to_owned();
    move |error| MapsError::File { file, error }
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

impl IntervalMaps {
    /// Writes the maps into a folder, which is made if it is missing. Older maps in it are removed; other files stay.
    ///
    /// # Errors
    /// [`MapsError`] names the file.
    pub fn save(&self, folder: &Path) -> Result<(), MapsError> {
        std::fs::create_dir_all(folder).map_err(in_file(folder))?;
        remove_old(folder)?;
        for (page_index, page) in self.pages.iter().enumerate() {
            for (pair_index, pair) in page.pairs.iter().enumerate() {
                for (edge, texels) in [("rise", &pair.rise), ("fall", &pair.fall)] {
                    let file = folder.join(picture_name(page_index, pair_index, edge));
                    // In memory first: an encoder with a file of its own drops what a full disk does not take.
                    let mut bytes = Vec::new();
                    PngEncoder::new(&mut bytes)
                        .write_image(texels, self.size, self.size, ExtendedColorType::Rgba8)
                        .map_err(|error| MapsError::Picture {
                            file: file.clone(),
                            error,
                        })?;
                    std::fs::write(&file, bytes).map_err(in_file(&file))?;
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
        // Whoever looks for the manifest finds all of it or nothing.
        let unfinished = folder.join(UNFINISHED);
        std::fs::write(&unfinished, text).map_err(in_file(&unfinished))?;
        std::fs::rename(&unfinished, &file).map_err(in_file(&file))
    }

    fn manifest(&self, corners: &[u8]) -> Manifest {
        let surface = |surface: &BakedSurface| ManifestSurface {
            mesh: surface.mesh.clone(),
            hash: hex(surface.hash),
            world_from_local: surface.world_from_local,
            two_sided: surface.is_two_sided,
            casts: surface.casts,
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
}

/// Removes the manifest of older maps, and their pictures. Only names that maps have are touched.
fn remove_old(folder: &Path) -> Result<(), MapsError> {
    for entry in std::fs::read_dir(folder).map_err(in_file(folder))? {
        let entry = entry.map_err(in_file(folder))?;
        let (file, name) = (entry.path(), entry.file_name());
        if name
            .to_str()
            .is_some_and(|name| name == MANIFEST || is_picture(name))
        {
            std::fs::remove_file(&file).map_err(in_file(&file))?;
        }
    }
    Ok(())
}

/// Whether a file has a name that [`picture_name`] gives.
fn is_picture(name: &str) -> bool {
    let numbers = || {
        let (page, rest) = name.strip_prefix("page")?.split_once(".pair")?;
        let (pair, rest) = rest.split_once('.')?;
        let edge = rest.strip_suffix(".png")?;
        let (page, pair): (usize, usize) = (page.parse().ok()?, pair.parse().ok()?);
        let is_edge = ["rise", "fall"].contains(&edge);
        Some(is_edge && picture_name(page, pair, edge) == name)
    };
    numbers().unwrap_or(false)
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use glam::{Vec2, Vec3};

    use super::super::intervals::intervals_of;
    use super::super::manifest::light_path;
    use super::super::maps::{BakeStatistics, Page};
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
                casts: true,
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
    fn older_maps_are_removed_and_a_users_pictures_are_not() {
        let scratch = Scratch::new("old");
        let names = || {
            let entries = std::fs::read_dir(&scratch.0).expect("the folder");
            let mut names: Vec<_> = entries
                .filter_map(|entry| entry.ok()?.file_name().into_string().ok())
                .collect();
            names.sort();
            names
        };
        let own = names();
        assert!(own.contains(&MANIFEST.to_owned()) && own.len() == 8, "{own:?}");
        let users = [
            "page1.png",
            "page0.pair0.png",
            "page01.pair0.rise.png",
            "page0.pair1.rise.png.bak",
        ];
        for name in users.into_iter().chain(["page7.pair3.fall.png"]) {
            std::fs::write(scratch.0.join(name), b"a user's").expect("it is written");
        }
        maps().save(&scratch.0).expect("they are saved again");
        let mut expected: Vec<String> = own.into_iter().chain(users.map(str::to_owned)).collect();
        expected.sort();
        assert_eq!(names(), expected);
    }

    /// A folder in the place of a file is named, and so is the file that it stands for.
    #[test]
    fn folders_in_the_place_of_files_are_named() {
        let scratch = Scratch::new("folders");
        for name in [CORNERS, MANIFEST, "page0.pair0.rise.png", UNFINISHED] {
            let file = scratch.0.join(name);
            let _ = std::fs::remove_file(&file);
            std::fs::create_dir(&file).expect("a folder");
            if name != UNFINISHED {
                let error = IntervalMaps::load(&scratch.0).expect_err("no file").to_string();
                assert!(error.contains(name), "{name}: {error}");
            }
            let error = maps().save(&scratch.0).expect_err("no file").to_string();
            assert!(error.contains(name), "{name}: {error}");
            std::fs::remove_dir(&file).expect("it is removed");
            maps().save(&scratch.0).expect("they are saved");
        }
    }

    #[test]
    fn pictures_of_another_size_or_format_are_refused_before_they_are_decoded() {
        let scratch = Scratch::new("pictures");
        let picture = |picture: image::DynamicImage| {
            move |_: Vec<u8>| {
                let mut bytes = std::io::Cursor::new(Vec::new());
                picture
                    .write_to(&mut bytes, image::ImageFormat::Png)
                    .expect("a picture");
                bytes.into_inner()
            }
        };
        let large = scratch.change(
            "page0.pair0.rise.png",
            picture(image::DynamicImage::new_rgba8(64, 4)),
        );
        assert!(large.contains("64×4 texels are not 4×4"), "{large}");
        let gray = scratch.change(
            "page0.pair0.rise.png",
            picture(image::DynamicImage::new_luma8(4, 4)),
        );
        assert!(gray.contains("L8 is not Rgba8"), "{gray}");
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
            ("\"version\": 2", "\"version\": 1", "version"),
            ("\"casts\": true", "\"casts\": 7", "boolean"),
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
