//! Sets of the steps of a path. They decide for many texels at once whether a window of time is wholly lit or wholly dark.

use super::intervals::{Interval, STEPS, Window};

const BITS: usize = u64::BITS as usize;

/// A set of steps of the path, one bit each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Steps([u64; STEPS / BITS]);

impl Steps {
    /// The set without any step.
    pub const NONE: Self = Self([0; STEPS / BITS]);

    /// The set of all steps.
    pub const ALL: Self = Self([u64::MAX; STEPS / BITS]);

    /// The steps of some intervals.
    pub fn of(intervals: &[Interval]) -> Self {
        let mut steps = Self::NONE;
        for interval in intervals {
            steps.add(interval.rise, interval.fall);
        }
        steps
    }

    /// The steps that a window overlaps.
    pub fn of_window(window: &Window) -> Self {
        let mut steps = Self::NONE;
        for [start, end] in window.spans {
            if start < end {
                let first = (start * STEPS as f32).floor();
                let last = (end * STEPS as f32).ceil() - 1.0;
                steps.add(first as u8, last as u8); // the cast clamps to 0..=255
            }
        }
        steps
    }

    /// Adds the steps from `first` to `last`, both included. Adds nothing if `last` lies before `first`.
    pub fn add(&mut self, first: u8, last: u8) {
        if first > last {
            return;
        }
        let (first, last) = (usize::from(first), usize::from(last));
        for word in first / BITS..=last / BITS {
            let low = first.saturating_sub(word * BITS);
            let high = (last - word * BITS).min(BITS - 1);
            self.0[word] |= (u64::MAX << low) & (u64::MAX >> (BITS - 1 - high));
        }
    }

    /// Adds all steps of another set.
    pub fn unite(&mut self, other: &Self) {
        self.0
            .iter_mut()
            .zip(other.0)
            .for_each(|(own, other)| *own |= other);
    }

    /// Removes the steps that are not in another set.
    pub fn intersect(&mut self, other: &Self) {
        self.0
            .iter_mut()
            .zip(other.0)
            .for_each(|(own, other)| *own &= other);
    }

    /// Whether the sets have a step in common.
    pub fn meets(&self, other: &Self) -> bool {
        self.0.iter().zip(other.0).any(|(own, other)| own & other != 0)
    }

    /// Whether all steps of another set are in this one.
    pub fn contains(&self, other: &Self) -> bool {
        self.0.iter().zip(other.0).all(|(own, other)| other & !own == 0)
    }
}

#[cfg(test)]
mod tests {
    use super::super::intervals::{intervals_of, seen_share};
    use super::*;

    fn has(steps: &Steps, step: usize) -> bool {
        steps.0[step / BITS] >> (step % BITS) & 1 == 1
    }

    #[test]
    fn sets_have_the_steps_of_their_intervals() {
        for (modulus, lit) in [(2, 1), (20, 7), (100, 64), (256, 255), (256, 256), (3, 0)] {
            let seen = |step: usize| step % modulus < lit;
            let steps = Steps::of(&intervals_of(seen));
            assert!(
                (0..STEPS).all(|step| has(&steps, step) == seen(step)),
                "{modulus} {lit}"
            );
        }
        let mut steps = Steps::NONE;
        steps.add(9, 8);
        assert_eq!(steps, Steps::of(&[Interval::NONE]));
        assert_eq!(steps, Steps::NONE);
        steps.add(0, 255);
        assert_eq!(steps, Steps::ALL);
    }

    #[test]
    fn windows_that_meet_nothing_are_dark_and_windows_within_are_lit() {
        let intervals = intervals_of(|step| step % 40 < 17);
        let steps = Steps::of(&intervals);
        let (mut dark, mut lit, mut mixed) = (0, 0, 0);
        for time in 0..997 {
            for width in [0.0, 0.001, 0.02, 0.11] {
                for is_closed in [false, true] {
                    let window = Window::new(time as f32 / 997.0, width, is_closed);
                    let share = seen_share(&intervals, &window);
                    let of_window = Steps::of_window(&window);
                    match (steps.meets(&of_window), steps.contains(&of_window)) {
                        (false, contains) => {
                            assert_eq!((share, contains), (0.0, false), "{window:?}");
                            dark += 1;
                        }
                        // An interval at each end of a closed path adds up to the window but for rounding.
                        (true, true) => {
                            assert!(share > 1.0 - 1e-5, "{window:?}: {share}");
                            lit += 1;
                        }
                        (true, false) => {
                            assert!(share > 0.0 && share < 1.0, "{window:?}: {share}");
                            mixed += 1;
                        }
                    }
                }
            }
        }
        assert!(dark > 1000 && lit > 1000 && mixed > 1000, "{dark} {lit} {mixed}");
    }
}
