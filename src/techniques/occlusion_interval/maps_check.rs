//! Checks that maps are whole, so that whoever reads them may index without a care.

use std::ops::Range;

use super::intervals::PER_PAIR;
use super::maps::{IntervalMaps, MAX_BYTES, MAX_LAYERS, MAX_SIZE, bytes_of};

/// A part of maps that cannot be used.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{element}: {problem}")]
pub struct MapsFault {
    /// The part of the maps.
    pub element: String,
    /// Description of the fault.
    pub problem: String,
}

fn fault(element: impl Into<String>, problem: impl Into<String>) -> MapsFault {
    MapsFault {
        element: element.into(),
        problem: problem.into(),
    }
}

/// Checks the size of pages, given by the number of pairs of each.
pub(super) fn check_pages(size: u32, pairs: impl Iterator<Item = usize>) -> Result<(), MapsFault> {
    if !(1..=MAX_SIZE).contains(&size) {
        let problem = format!("{size} is not from 1 to {MAX_SIZE} texels");
        return Err(fault("size", problem));
    }
    let (mut layers, mut is_any_empty) = (0usize, false);
    for pairs in pairs {
        layers = layers.saturating_add(pairs);
        is_any_empty |= pairs == 0;
    }
    if layers > MAX_LAYERS || is_any_empty {
        let problem =
            format!("{layers} pairs; every page needs one, and all together have at most {MAX_LAYERS}");
        return Err(fault("pages", problem));
    }
    let bytes = bytes_of(size, layers);
    if bytes > MAX_BYTES {
        return Err(fault("pages", format!("{bytes} bytes are more than {MAX_BYTES}")));
    }
    Ok(())
}

/// Checks that the corners of surfaces are triangles, and follow on each other.
pub(super) fn check_ranges(
    surfaces: impl Iterator<Item = Range<u32>>,
    count: usize,
) -> Result<(), MapsFault> {
    let mut next = 0;
    for (index, Range { start, end }) in surfaces.enumerate() {
        if start != next || end < start || (end - start) % 3 != 0 {
            let problem = format!("{start} to {end} are no triangles that begin at {next}");
            return Err(fault(format!("surfaces[{index}].corners"), problem));
        }
        next = end;
    }
    if next as usize != count {
        let problem = format!("{count} are not the {next} of the surfaces");
        return Err(fault("corners.count", problem));
    }
    Ok(())
}

impl IntervalMaps {
    /// Checks that the maps are whole: sizes, ranges, the path, and that every number is finite. Maps that are read from a
    /// folder or added to an [`IntervalLibrary`](super::IntervalLibrary) are checked.
    ///
    /// # Errors
    /// The first part that cannot be used.
    pub fn check(&self) -> Result<(), MapsFault> {
        self.path
            .check()
            .map_err(|error| fault("path", error.to_string()))?;
        let density = self.texels_per_metre;
        if !(density > 0.0 && density.is_finite()) {
            let problem = format!("{density} is not greater than 0");
            return Err(fault("texels_per_metre", problem));
        }
        check_pages(self.size, self.pages.iter().map(|page| page.pairs.len()))?;
        let bytes = self.size as usize * self.size as usize * PER_PAIR;
        for (index, page) in self.pages.iter().enumerate() {
            for (pair, textures) in page.pairs.iter().enumerate() {
                let lengths = [textures.rise.len(), textures.fall.len()];
                if lengths != [bytes; 2] {
                    let problem = format!("{lengths:?} bytes are not {bytes} each");
                    return Err(fault(format!("pages[{index}].pairs[{pair}]"), problem));
                }
            }
        }
        let ranges = self.surfaces.iter().map(|surface| surface.corners.clone());
        check_ranges(ranges, self.corners.len())?;
        for (index, surface) in self.surfaces.iter().enumerate() {
            if !surface.world_from_local.iter().all(|value| value.is_finite()) {
                let element = format!("surfaces[{index}].world_from_local");
                return Err(fault(element, "it is not finite"));
            }
        }
        self.check_corners()
    }

    fn check_corners(&self) -> Result<(), MapsFault> {
        for (triangle, corners) in self.corners.chunks(3).enumerate() {
            for (at, corner) in corners.iter().enumerate() {
                let element = || format!("corner {}", 3 * triangle + at);
                if corner.page as usize >= self.pages.len() {
                    let problem = format!("page {} of {}", corner.page, self.pages.len());
                    return Err(fault(element(), problem));
                }
                if corner.page != corners[0].page {
                    return Err(fault(element(), "its triangle is on two pages"));
                }
                if !corner.texel.is_finite() {
                    return Err(fault(element(), format!("{} is not finite", corner.texel)));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::super::maps::{BakeStatistics, BakedSurface, Corner, Page};
    use super::*;
    use crate::scene::LightPath;

    fn maps() -> IntervalMaps {
        let corner = Corner {
            page: 1,
            texel: Vec2::ONE,
        };
        IntervalMaps {
            key: 0,
            path: LightPath::Arc {
                direction: Vec3::NEG_Y,
                axis: Vec3::Z,
                degrees: 90.0,
            },
            texels_per_metre: 8.0,
            size: 4,
            pages: vec![Page::dark(4, 2), Page::dark(4, 1)],
            surfaces: vec![BakedSurface {
                mesh: "board".to_owned(),
                hash: 1,
                world_from_local: [1.0; 12],
                is_two_sided: false,
                casts: true,
                corners: 0..6,
            }],
            corners: vec![corner; 6],
            statistics: BakeStatistics::default(),
        }
    }

    #[test]
    fn the_part_that_is_wrong_is_named() {
        assert_eq!(maps().check(), Ok(()));
        let changes: [(fn(&mut IntervalMaps), &str); 12] = [
            (|maps| maps.size = 5, "pages[0].pairs[0]"),
            (|maps| maps.size = 0, "size"),
            (|maps| maps.pages[1].pairs.clear(), "pages"),
            (
                |maps| maps.pages[0].pairs[1].fall.truncate(7),
                "pages[0].pairs[1]",
            ),
            (|maps| maps.pages.truncate(1), "corner 0"),
            (|maps| maps.corners[4].page = 0, "corner 4"),
            (|maps| maps.corners[2].texel.y = f32::NAN, "corner 2"),
            (|maps| maps.corners.truncate(3), "corners.count"),
            (|maps| maps.surfaces[0].corners = 0..9, "corners.count"),
            (|maps| maps.surfaces[0].corners = 3..6, "surfaces[0].corners"),
            (
                |maps| maps.surfaces[0].world_from_local[7] = f32::INFINITY,
                "surfaces[0].world_from_local",
            ),
            (|maps| maps.path = LightPath::Positions(Vec::new()), "path"),
        ];
        for (change, element) in changes {
            let mut maps = maps();
            change(&mut maps);
            let fault = maps.check().expect_err(element);
            assert_eq!(fault.element, element, "{fault}");
        }
    }

    #[test]
    fn more_bytes_than_a_limit_are_refused_before_anything_is_read() {
        assert_eq!(check_pages(MAX_SIZE, [8, 24].into_iter()), Ok(()));
        let fault = check_pages(MAX_SIZE, [8, 25].into_iter()).expect_err("too much");
        assert!(fault.to_string().contains("bytes are more than"), "{fault}");
        assert!(check_pages(MAX_SIZE, [usize::MAX, 2].into_iter()).is_err());
    }
}
