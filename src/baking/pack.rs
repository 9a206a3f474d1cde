//! Packs charts into pages. Charts with many intervals stand together, because all texels of a page have as many pairs of
//! textures as the one with most.

use glam::UVec2;

use crate::techniques::occlusion_interval::maps::{MAX_BYTES, MAX_LAYERS, bytes_of};

/// The room that a chart needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Wanted {
    /// Width and height, texels.
    pub size: UVec2,
    /// Pairs of textures.
    pub pairs: usize,
}

/// The place of a chart.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Placed {
    /// Index of the page.
    pub page: u32,
    /// Upper left corner, texels.
    pub origin: UVec2,
}

/// Charts on pages.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Packed {
    /// Texels along each side of a page.
    pub size: u32,
    /// Number of pairs of each page.
    pub pairs: Vec<usize>,
    /// The places of the charts.
    pub placed: Vec<Placed>,
}

impl Packed {
    /// Number of layers of the textures.
    pub fn layers(&self) -> usize {
        self.pairs.iter().sum()
    }

    fn texels(&self) -> u64 {
        u64::from(self.size).pow(2) * self.layers() as u64
    }

    /// Texels, and a little more for each page: of two packings that are nearly as small, the one with fewer is better.
    fn cost(&self) -> u64 {
        self.texels() * (64 + self.pairs.len() as u64)
    }
}

/// Sizes of pages are multiples of this.
const STEP: u32 = 4;

/// Packs charts into pages of at most `page_size` texels along each side, so that the textures are small. `None` if they
/// would have more than [`MAX_LAYERS`] or [`MAX_BYTES`].
pub fn pack(charts: &[Wanted], page_size: u32) -> Option<Packed> {
    let largest = charts
        .iter()
        .map(|chart| chart.size.max_element())
        .max()
        .unwrap_or(1);
    let area: u64 = charts
        .iter()
        .map(|chart| u64::from(chart.size.element_product()))
        .sum();
    let least = largest.next_multiple_of(STEP).min(page_size.max(largest));
    let mut order: Vec<usize> = (0..charts.len()).collect();
    order.sort_by_key(|&at| {
        let Wanted { size, pairs } = charts[at];
        (std::cmp::Reverse((pairs, size.y, size.x)), at)
    });
    // One page that holds all, and smaller ones.
    let whole = (area as f64 * 1.1).sqrt();
    let candidates = (0..8).map(|halves| whole * 0.5f64.powf(f64::from(halves) * 0.5 - 0.5));
    let sizes = candidates.map(|size| {
        let size = (size.ceil() as u32).next_multiple_of(STEP);
        size.clamp(least, page_size.max(least))
    });
    let packed = sizes.map(|size| shelves(charts, &order, size));
    packed
        .filter(|packed| packed.layers() <= MAX_LAYERS && bytes_of(packed.size, packed.layers()) <= MAX_BYTES)
        .min_by_key(Packed::cost)
}

/// Fills pages with shelves: rows that are as high as their first chart.
fn shelves(charts: &[Wanted], order: &[usize], size: u32) -> Packed {
    let mut packed = Packed {
        size,
        pairs: Vec::new(),
        placed: vec![Placed::default(); charts.len()],
    };
    let (mut at, mut shelf) = (UVec2::ZERO, 0);
    for &index in order {
        let Wanted { size: room, pairs } = charts[index];
        if at.x + room.x > size || room.y > shelf {
            // Charts with fewer pairs may be higher than the shelf of the last ones with more.
            at = UVec2::new(0, at.y + shelf);
            shelf = room.y;
        }
        if packed.pairs.is_empty() || at.y + room.y > size {
            packed.pairs.push(pairs);
            at = UVec2::ZERO;
            shelf = room.y;
        }
        packed.placed[index] = Placed {
            page: packed.pairs.len() as u32 - 1,
            origin: at,
        };
        at.x += room.x;
    }
    if packed.pairs.is_empty() {
        packed.pairs.push(1);
    }
    packed
}

#[cfg(test)]
mod tests {
    use super::*;

    fn charts(count: u32) -> Vec<Wanted> {
        (0..count)
            .map(|i| Wanted {
                size: UVec2::new(5 + i * 7 % 31, 5 + i * 11 % 23),
                pairs: 1 + usize::from(i % 10 == 0) + 2 * usize::from(i % 50 == 0),
            })
            .collect()
    }

    /// Whether every chart is on its page, alone, and has its pairs.
    fn is_valid(charts: &[Wanted], packed: &Packed) -> bool {
        let inside = charts.iter().zip(&packed.placed).all(|(chart, placed)| {
            (placed.origin + chart.size).max_element() <= packed.size
                && chart.pairs <= packed.pairs[placed.page as usize]
        });
        let apart = |a: usize, b: usize| {
            let (p, q) = (packed.placed[a], packed.placed[b]);
            p.page != q.page
                || (p.origin + charts[a].size).cmple(q.origin).any()
                || (q.origin + charts[b].size).cmple(p.origin).any()
        };
        inside && (0..charts.len()).all(|a| (0..a).all(|b| apart(a, b)))
    }

    #[test]
    fn charts_stand_apart_and_most_of_the_room_is_used() {
        for (count, page_size) in [(1, 64), (10, 64), (200, 128), (200, 1024)] {
            let charts = charts(count);
            let packed = pack(&charts, page_size).expect("they fit");
            assert!(is_valid(&charts, &packed), "{count} {page_size}");
            assert!(packed.size <= page_size);
            let needed: u64 = charts
                .iter()
                .map(|chart| u64::from(chart.size.element_product()) * chart.pairs as u64)
                .sum();
            if count == 200 {
                assert!(
                    packed.texels() < needed * 3 / 2,
                    "{} for {needed}",
                    packed.texels()
                );
            }
        }
    }

    #[test]
    fn a_chart_that_is_moved_is_noticed() {
        let charts = charts(40);
        let mut packed = pack(&charts, 128).expect("they fit");
        packed.placed[7].origin += 1;
        assert!(!is_valid(&charts, &packed));
    }

    #[test]
    fn more_layers_than_a_device_holds_are_refused() {
        let many = vec![
            Wanted {
                size: UVec2::splat(60),
                pairs: 32,
            };
            9
        ];
        assert_eq!(pack(&many, 64), None);
        assert!(pack(&many, 128).is_some());
    }

    #[test]
    fn nothing_is_one_page() {
        let packed = pack(&[], 64).expect("nothing fits");
        assert_eq!((packed.pairs.len(), packed.placed.len()), (1, 0));
    }
}
