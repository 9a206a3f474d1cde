//! Runs of triangles that are drawn together, and which of them a window of time needs.

use std::ops::Range;

use super::footprint::Seen;
use crate::techniques::occlusion_interval::steps::Steps;

/// Number of triangles of a run, but for the last one of a surface. Shorter runs find more that need not be drawn, and take
/// more draws where drawn and left out ones take turns.
pub const RUN_TRIANGLES: usize = 128;

/// Triangles of a surface that follow each other.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Range of [`GpuMaps::indices`](super::gpu_maps::GpuMaps::indices): three for each triangle.
    pub indices: Range<u32>,
    /// When the texels of the triangles see the light.
    pub seen: Seen,
}

/// Adds a triangle, whose three indices begin at `first`, to the runs of a surface. These begin at index `surface`.
pub fn add_triangle(runs: &mut Vec<Run>, surface: usize, first: u32, seen: &Seen) {
    let is_full = |run: &Run| run.indices.len() >= 3 * RUN_TRIANGLES;
    if runs[surface..].last().is_none_or(is_full) {
        runs.push(Run {
            indices: first..first,
            seen: Seen::NOTHING,
        });
    }
    if let Some(run) = runs.last_mut() {
        run.indices.end = first + 3;
        run.seen.add(seen);
    }
}

/// The triangles that a frame need not draw, because the mask is cleared to what they would write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeftOut {
    /// The triangles that are dark during the whole window. The mask is cleared to 0.
    Dark,
    /// The triangles that are lit during the whole window. The mask is cleared to 1.
    Lit,
    /// None of them.
    Nothing,
}

impl LeftOut {
    /// Whether the triangles of a run are left out.
    pub fn has(self, run: &Run, window: &Steps) -> bool {
        match self {
            Self::Dark => !run.seen.by_any.meets(window),
            Self::Lit => run.seen.by_all.contains(window),
            Self::Nothing => false,
        }
    }

    /// Chooses what leaves the fewest indices to draw. `may` says of each kind whether the mask may be cleared to its value.
    pub fn choose<'a>(
        runs: impl Iterator<Item = &'a Run> + Clone,
        window: &Steps,
        may: impl Fn(Self) -> bool,
    ) -> Self {
        let saved = |kind: Self| -> usize {
            let left_out = runs.clone().filter(|run| kind.has(run, window));
            left_out.map(|run| run.indices.len()).sum()
        };
        [Self::Lit, Self::Dark]
            .into_iter()
            .filter(|kind| may(*kind))
            .max_by_key(|kind| saved(*kind))
            .unwrap_or(Self::Nothing)
    }

    /// The ranges of indices that remain to be drawn. Runs beside each other are one range.
    pub fn remaining(self, runs: &[Run], window: &Steps, mut draw: impl FnMut(Range<u32>)) {
        let mut open: Option<Range<u32>> = None;
        for run in runs.iter().filter(|run| !self.has(run, window)) {
            open = Some(match open.take() {
                Some(range) if range.end == run.indices.start => range.start..run.indices.end,
                other => {
                    other.into_iter().for_each(&mut draw);
                    run.indices.clone()
                }
            });
        }
        open.into_iter().for_each(draw);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::techniques::occlusion_interval::intervals::Interval;

    fn seen(any: [u8; 2], all: [u8; 2]) -> Seen {
        let steps = |[rise, fall]: [u8; 2]| Steps::of(&[Interval { rise, fall }]);
        Seen {
            by_any: steps(any),
            by_all: steps(all),
        }
    }

    /// Runs that are dark, lit, lit and mixed in steps 100 to 110.
    fn runs() -> Vec<Run> {
        let all = [
            seen([0, 99], [0, 99]),
            seen([0, 255], [90, 110]),
            Seen::ALWAYS,
            seen([0, 255], [0, 105]),
        ];
        let (mut runs, mut first) = (Vec::new(), 6);
        for seen in all {
            for _ in 0..RUN_TRIANGLES {
                add_triangle(&mut runs, 0, first, &seen);
                first += 3;
            }
        }
        runs
    }

    fn window() -> Steps {
        Steps::of(&[Interval { rise: 100, fall: 110 }])
    }

    #[test]
    fn runs_are_as_long_as_they_may_be_and_end_with_their_surface() {
        let mut runs = runs();
        assert_eq!(runs.len(), 4);
        let long = 3 * RUN_TRIANGLES as u32;
        assert_eq!(runs[1].indices, 6 + long..6 + 2 * long);
        assert_eq!(runs[3].seen, seen([0, 255], [0, 105]));
        let end = runs[3].indices.end;
        add_triangle(&mut runs, 4, end, &Seen::ALWAYS);
        add_triangle(&mut runs, 4, end + 3, &seen([3, 4], [4, 4]));
        assert_eq!((runs.len(), runs[4].indices.clone()), (5, end..end + 6));
        assert_eq!(runs[4].seen, seen([0, 255], [4, 4]));
    }

    #[test]
    fn what_the_clear_value_holds_is_left_out_and_all_else_is_drawn() {
        let (runs, window) = (runs(), window());
        let long = 3 * RUN_TRIANGLES as u32;
        let drawn = |left_out: LeftOut, window: &Steps| {
            let mut ranges = Vec::new();
            left_out.remaining(&runs, window, |range| ranges.push([range.start, range.end]));
            ranges
        };
        let run = |index: u32| 6 + index * long;
        assert_eq!(drawn(LeftOut::Nothing, &window), [[run(0), run(4)]], "one range");
        assert_eq!(drawn(LeftOut::Dark, &window), [[run(1), run(4)]]);
        assert_eq!(drawn(LeftOut::Lit, &window), [[run(0), run(1)], [run(3), run(4)]]);
        // A window of other steps needs others.
        assert_eq!(
            drawn(LeftOut::Lit, &Steps::ALL),
            [[run(0), run(2)], [run(3), run(4)]]
        );
    }

    #[test]
    fn the_kind_that_leaves_out_most_is_chosen_among_those_allowed() {
        let (runs, window) = (runs(), window());
        let choose = |runs: &[Run], may: fn(LeftOut) -> bool| LeftOut::choose(runs.iter(), &window, may);
        assert_eq!(choose(&runs, |_| true), LeftOut::Lit);
        assert_eq!(choose(&runs[..1], |_| true), LeftOut::Dark);
        assert_eq!(choose(&runs[..1], |kind| kind != LeftOut::Dark), LeftOut::Lit);
        assert_eq!(choose(&runs, |kind| kind != LeftOut::Lit), LeftOut::Dark);
        assert_eq!(choose(&runs, |_| false), LeftOut::Nothing);
    }
}
