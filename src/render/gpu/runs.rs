//! Ranges that are written together, because each call that writes to a buffer has a cost of its own.

use std::iter::from_fn;
use std::ops::Range;

/// Joins ranges that lie at most `gap` elements apart, in the order in which they come. Ranges must ascend and not overlap.
///
/// A call that writes to a buffer costs as much as copying some ten kilobytes.
pub fn joined(
    ranges: impl IntoIterator<Item = Range<usize>>,
    gap: usize,
) -> impl Iterator<Item = Range<usize>> {
    let mut ranges = ranges.into_iter().peekable();
    from_fn(move || {
        let mut run = ranges.next()?;
        while let Some(next) = ranges.next_if(|next| next.start - run.end <= gap) {
            run.end = next.end;
        }
        Some(run)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_are_joined_over_gaps_that_are_small_enough() {
        let ranges = || [0..1, 1..3, 4..5, 8..9];
        let of = |gap| joined(ranges(), gap).collect::<Vec<_>>();
        assert_eq!(of(0), [0..3, 4..5, 8..9]);
        assert_eq!(of(1), [0..5, 8..9]);
        assert_eq!(of(3), vec![0..9; 1]);
        assert_eq!(joined([], 3).count(), 0);
    }
}
