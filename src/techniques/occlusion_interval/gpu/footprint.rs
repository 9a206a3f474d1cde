//! The texels that a triangle reads, and when they see the light.

use std::ops::RangeInclusive;

use glam::Vec2;

use crate::techniques::occlusion_interval::intervals::PER_PAIR;
use crate::techniques::occlusion_interval::maps::Page;
use crate::techniques::occlusion_interval::steps::Steps;

/// Distance by which a fragment's place on the page may lie beside its triangle, texels. The place is interpolated, and so it is
/// rounded.
const SLACK: f32 = 1.0 / 16.0;

/// When some texels see the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Seen {
    /// The steps in which at least one of the texels sees the light.
    pub by_any: Steps,
    /// The steps in which each of the texels sees the light.
    pub by_all: Steps,
}

impl Seen {
    /// No texels at all.
    pub const NOTHING: Self = Self {
        by_any: Steps::NONE,
        by_all: Steps::ALL,
    };

    /// Texels that see the light at all times.
    pub const ALWAYS: Self = Self {
        by_any: Steps::ALL,
        by_all: Steps::ALL,
    };

    /// Adds other texels.
    pub fn add(&mut self, other: &Self) {
        self.by_any.unite(&other.by_any);
        self.by_all.intersect(&other.by_all);
    }

    /// The texels that fragments of a triangle read. `size` is the number of texels along each side of the page.
    pub fn of_triangle(corners: [Vec2; 3], page: &Page, size: u32) -> Self {
        let mut seen = Self::NOTHING;
        visit_rows(corners, size.saturating_sub(1), |row, columns| {
            for column in columns {
                let steps = steps_of_texel(page, row as usize * size as usize + column as usize);
                seen.by_any.unite(&steps);
                seen.by_all.intersect(&steps);
            }
        });
        seen
    }
}

fn steps_of_texel(page: &Page, texel: usize) -> Steps {
    let mut steps = Steps::NONE;
    let channels = texel * PER_PAIR..(texel + 1) * PER_PAIR;
    for pair in &page.pairs {
        let rise = pair.rise.get(channels.clone()).unwrap_or_default();
        let fall = pair.fall.get(channels.clone()).unwrap_or_default();
        for (&rise, &fall) in rise.iter().zip(fall) {
            steps.add(rise, fall);
        }
    }
    steps
}

/// Visits rows of texels that together hold the four texels around each point of a triangle. `last` is the index of the
/// last row and column, at which the shader clamps.
fn visit_rows(corners: [Vec2; 3], last: u32, mut visit: impl FnMut(u32, RangeInclusive<u32>)) {
    let low = corners[0].min(corners[1]).min(corners[2]);
    let high = corners[0].max(corners[1]).max(corners[2]);
    let before = |place: f32| (place - 0.5 - SLACK).floor();
    let behind = |place: f32| (place - 0.5 + SLACK).floor() + 1.0;
    let clamped = |texel: f32| texel.clamp(0.0, last as f32) as u32;
    // A row is read by points up to the centres of both of its neighbours.
    for row in clamped(before(low.y))..=clamped(behind(high.y)) {
        let band = [row as f32 - 0.5 - SLACK, row as f32 + 1.5 + SLACK];
        let band = [
            if row == 0 { f32::NEG_INFINITY } else { band[0] },
            if row == last { f32::INFINITY } else { band[1] },
        ];
        if let Some([from, to]) = columns_in_band(&corners, band) {
            visit(row, clamped(before(from))..=clamped(behind(to)));
        }
    }
}

/// The least and the largest x of the part of a triangle whose y lies in a band.
fn columns_in_band(corners: &[Vec2; 3], [low, high]: [f32; 2]) -> Option<[f32; 2]> {
    let mut columns: Option<[f32; 2]> = None;
    for side in 0..3 {
        let (a, b) = (corners[side], corners[(side + 1) % 3]);
        if a.y.max(b.y) < low || a.y.min(b.y) > high {
            continue;
        }
        let at = |y: f32| {
            let share = (y - a.y) / (b.y - a.y);
            if share.is_finite() {
                a.x + (b.x - a.x) * share.clamp(0.0, 1.0)
            } else {
                a.x
            }
        };
        let ends = if a.y == b.y {
            [a.x, b.x]
        } else {
            [at(a.y.clamp(low, high)), at(b.y.clamp(low, high))]
        };
        for x in ends {
            let [from, to] = columns.unwrap_or([x, x]);
            columns = Some([from.min(x), to.max(x)]);
        }
    }
    columns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::occlusion_interval::intervals::Interval;

    const SIZE: u32 = 24;

    /// Places of a few pages' triangles, from slivers to the whole page and beyond.
    fn triangles() -> Vec<[Vec2; 3]> {
        let mut generator = fastrand::Rng::with_seed(7);
        let mut random = |scale: f32| generator.f32() * scale;
        (0..400)
            .map(|i| {
                let (spread, centre) = (
                    [0.2, 1.0, 3.0, 24.0][i % 4],
                    Vec2::new(random(24.0), random(24.0)),
                );
                let mut corner = || centre + Vec2::new(random(spread), random(spread)) - 0.5 * spread;
                let [a, b, c] = [corner(), corner(), corner()];
                // Every fifth has no height or no width.
                match i % 10 {
                    0 => [a, Vec2::new(b.x, a.y), Vec2::new(c.x, a.y)],
                    5 => [a, Vec2::new(a.x, b.y), Vec2::new(a.x, c.y)],
                    _ => [a, b, c],
                }
            })
            .collect()
    }

    #[test]
    fn all_texels_around_points_of_a_triangle_are_visited_and_few_others() {
        let last = SIZE - 1;
        let (mut visited_count, mut needed_count) = (0, 0);
        for corners in triangles() {
            let mut visited = [[false; SIZE as usize]; SIZE as usize];
            visit_rows(corners, last, |row, columns| {
                columns.for_each(|column| visited[row as usize][column as usize] = true);
            });
            let mut needed = [[false; SIZE as usize]; SIZE as usize];
            for i in 0..=60 {
                for j in 0..=60 - i {
                    let [u, v] = [i, j].map(|part| part as f32 / 60.0);
                    let place = corners[0] * (1.0 - u - v) + corners[1] * u + corners[2] * v;
                    let corner = (place - 0.5).floor();
                    for texel in [Vec2::ZERO, Vec2::X, Vec2::Y, Vec2::ONE] {
                        let texel = (corner + texel)
                            .clamp(Vec2::ZERO, Vec2::splat(last as f32))
                            .as_uvec2();
                        needed[texel.y as usize][texel.x as usize] = true;
                    }
                }
            }
            for (visited, needed) in visited.iter().flatten().zip(needed.iter().flatten()) {
                assert!(*visited || !needed, "{corners:?}");
                visited_count += usize::from(*visited);
                needed_count += usize::from(*needed);
            }
        }
        assert!(
            visited_count < needed_count * 3 / 2,
            "{visited_count} visited, {needed_count} needed"
        );
    }

    #[test]
    fn texels_of_a_triangle_are_seen_by_any_and_by_all() {
        let mut page = Page::dark(4, 2);
        let at = |first, last| Interval {
            rise: first,
            fall: last,
        };
        for texel in 0..16 {
            page.write(texel, &[at(10, 20), at(30, 40)]);
        }
        page.write(5, &[at(10, 15), at(30, 40), at(50, 51), at(60, 61), at(200, 255)]);
        let around = |x: f32, y: f32| [Vec2::new(x, y), Vec2::new(x + 0.1, y), Vec2::new(x, y + 0.1)];
        let seen = Seen::of_triangle(around(1.6, 1.6), &page, 4);
        assert_eq!(
            seen.by_any,
            Steps::of(&[at(10, 20), at(30, 40), at(50, 51), at(60, 61), at(200, 255)])
        );
        assert_eq!(seen.by_all, Steps::of(&[at(10, 15), at(30, 40)]));
        let apart = Seen::of_triangle(around(2.6, 2.6), &page, 4);
        assert_eq!((apart.by_any, apart.by_all), {
            let all = Steps::of(&[at(10, 20), at(30, 40)]);
            (all, all)
        });
    }
}
