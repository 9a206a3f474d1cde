//! The mathematics of occlusion intervals: when a point sees the light, and how much of a window of time that is.
//!
//! Shader `shaders/techniques/occlusion_interval/resolve.wgsl` computes [`seen_share`] and [`blended`] on the GPU.
//!
//! Source: Donnelly & Demers 2004, "Generating Soft Shadows Using Occlusion Interval Maps", GPU Gems, chapter 13.

use smallvec::SmallVec;

use crate::scene::LightPath;

/// Number of points of the path at which a texel looks for the light. Edges take 8 bits.
pub const STEPS: usize = 256;

/// Number of intervals in a pair of textures, one in each channel.
pub const PER_PAIR: usize = 4;

/// Least width of a window of time, as a share of the path. Shorter windows lie within one step, so they give the hard
/// shadow. It is a sixteenth of a step: shorter ones lose digits in the shader's division.
pub const LEAST_WIDTH: f32 = 1.0 / (16 * STEPS) as f32;

/// A stretch of the path in which a point sees the light.
///
/// Step `i` of the path lasts from `i / 256` to `(i + 1) / 256`. Bytes hold the first and the last step instead of two
/// edges, because there are 257 edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Interval {
    /// First step in which the light is seen: the rising edge is at its start.
    pub rise: u8,
    /// Last step in which the light is seen: the falling edge is at its end.
    pub fall: u8,
}

impl Interval {
    /// The interval of a channel that holds none. It falls before it rises, so it adds nothing.
    pub const NONE: Self = Self { rise: 255, fall: 0 };

    /// The time of the rising edge.
    pub fn start(self) -> f32 {
        f32::from(self.rise) / STEPS as f32
    }

    /// The time of the falling edge.
    pub fn end(self) -> f32 {
        (f32::from(self.fall) + 1.0) / STEPS as f32
    }
}

/// The intervals of one point, in ascending order. Most points have few.
pub type Intervals = SmallVec<[Interval; PER_PAIR]>;

/// Finds the edges of a visibility function, given by its value in each step. A light that is seen in the last and the
/// first step of a closed path has two intervals, because bytes cannot hold one that wraps around.
pub fn intervals_of(seen: impl Fn(usize) -> bool) -> Intervals {
    let mut found = Intervals::new();
    let mut open: Option<u8> = None;
    for step in 0..STEPS {
        let byte = step as u8;
        match (open, seen(step)) {
            (None, true) => open = Some(byte),
            (Some(rise), false) => {
                found.push(Interval { rise, fall: byte - 1 });
                open = None;
            }
            _ => {}
        }
    }
    if let Some(rise) = open {
        found.push(Interval { rise, fall: 255 });
    }
    found
}

/// The intervals in which a light on a path shines at all, as every point in the open would see it.
pub fn shining(path: &LightPath) -> Intervals {
    match path {
        LightPath::Sun { .. } => intervals_of(|step| path.shines(middle_of(step))),
        LightPath::Arc { .. } | LightPath::Positions(_) => intervals_of(|_| true),
    }
}

/// The time in the middle of a step. Rays are cast to where the light is then.
pub fn middle_of(step: usize) -> f32 {
    (step as f32 + 0.5) / STEPS as f32
}

/// A window of time: the stretch of the path that the light fills, in one or two spans.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Start and end of each span. The second one is empty (its end lies before its start) unless the window wraps
    /// around a closed path.
    pub spans: [[f32; 2]; 2],
    /// One divided by the length of both spans.
    pub inverse_width: f32,
}

/// A span that meets no interval.
const NO_SPAN: [f32; 2] = [2.0, -1.0];

impl Window {
    /// The window of a width around a time that lies within the path. It wraps around a closed path. At the ends of any
    /// other it is cut: there is no light beyond, so the light is shorter there.
    ///
    /// A width below [`LEAST_WIDTH`] gives a window within the step that holds the time, which is the hard shadow.
    pub fn new(time: f32, width: f32, is_closed: bool) -> Self {
        let time = if time.is_finite() {
            time.clamp(0.0, 1.0)
        } else {
            0.0
        };
        if !(width >= LEAST_WIDTH) {
            let step = (time * STEPS as f32).floor().min(STEPS as f32 - 1.0);
            let end = (step + 1.0) / STEPS as f32;
            let start = time.min(end - LEAST_WIDTH);
            return Self::of([start, start + LEAST_WIDTH], NO_SPAN);
        }
        let half = 0.5 * width.min(1.0);
        let (start, end) = (time - half, time + half);
        if !is_closed {
            return Self::of([start.max(0.0), end.min(1.0)], NO_SPAN);
        }
        if width >= 1.0 {
            Self::of([0.0, 1.0], NO_SPAN)
        } else if start < 0.0 {
            Self::of([0.0, end], [start + 1.0, 1.0])
        } else if end > 1.0 {
            Self::of([start, 1.0], [0.0, end - 1.0])
        } else {
            Self::of([start, end], NO_SPAN)
        }
    }

    fn of(first: [f32; 2], second: [f32; 2]) -> Self {
        let length = |span: [f32; 2]| (span[1] - span[0]).max(0.0);
        Self {
            spans: [first, second],
            inverse_width: 1.0 / (length(first) + length(second)),
        }
    }
}

/// The share of a window of time in which a point sees the light: that of a linear light along the path.
///
/// Source: equation of section 13.4, `1/dt Σ max(0, min(F, end) − max(R, start))`, over each span of the window.
pub fn seen_share(intervals: &[Interval], window: &Window) -> f32 {
    let within = |[start, end]: [f32; 2]| -> f32 {
        let overlap = |interval: &Interval| (interval.end().min(end) - interval.start().max(start)).max(0.0);
        intervals.iter().map(overlap).sum()
    };
    (window.spans.into_iter().map(within).sum::<f32>() * window.inverse_width).min(1.0)
}

/// Visibility between four texels: each is evaluated by itself, and the results are blended. Edges themselves cannot be
/// blended, since the first interval of one texel may be the second one of its neighbour.
///
/// `texels` are upper left, upper right, lower left, lower right; `between` is the place between their centres, 0 to 1.
pub fn blended(texels: [&[Interval]; 4], between: [f32; 2], window: &Window) -> f32 {
    let [a, b, c, d] = texels.map(|intervals| seen_share(intervals, window));
    let mix = |from: f32, to: f32, share: f32| from + (to - from) * share;
    mix(mix(a, b, between[0]), mix(c, d, between[0]), between[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The share by counting: `of` sees the light in small pieces of the window.
    fn counted(seen: &[bool; STEPS], time: f32, width: f32, is_closed: bool) -> f32 {
        const PIECES: u32 = 20_000;
        let pieces = (0..PIECES).map(|i| time + width * ((i as f32 + 0.5) / PIECES as f32 - 0.5));
        let (mut inside, mut lit) = (0, 0);
        for at in pieces {
            let at = if is_closed { at.rem_euclid(1.0) } else { at };
            if (0.0..1.0).contains(&at) {
                inside += 1;
                lit += u32::from(seen[(at * STEPS as f32) as usize]);
            }
        }
        lit as f32 / inside as f32
    }

    fn pattern(seed: u32) -> [bool; STEPS] {
        std::array::from_fn(|step| {
            (step as u32 / (3 + seed % 29)).wrapping_mul(0x9e37_79b9 ^ seed) >> 30 & 1 == 1
        })
    }

    #[test]
    fn shares_are_those_of_counting_open_and_closed() {
        let mut nonzero = 0;
        for seed in 0..12 {
            let seen = pattern(seed);
            let intervals = intervals_of(|step| seen[step]);
            for (time, width) in [
                (0.0, 0.1),
                (0.5, 0.02),
                (0.37, 0.3),
                (1.0, 0.25),
                (0.97, 0.2),
                (0.4, 1.0),
            ] {
                for is_closed in [false, true] {
                    let share = seen_share(&intervals, &Window::new(time, width, is_closed));
                    let expected = counted(&seen, time, width, is_closed);
                    assert!(
                        (share - expected).abs() < 2e-3,
                        "{seed} {time} {width} {is_closed}: {share} {expected}"
                    );
                    nonzero += u32::from(share > 0.0 && share < 1.0);
                }
            }
        }
        assert!(nonzero > 40, "most windows are partly lit: {nonzero}");
    }

    #[test]
    fn a_wrong_edge_is_noticed_by_counting() {
        let seen = pattern(3);
        let mut intervals = intervals_of(|step| seen[step]);
        let window = Window::new(f32::from(intervals[1].fall) / 256.0, 0.05, false);
        let right = seen_share(&intervals, &window);
        intervals[1].fall -= 1;
        assert!((seen_share(&intervals, &window) - right).abs() > 0.05);
    }

    #[test]
    fn no_width_is_the_hard_shadow_of_the_step() {
        for seed in 0..12 {
            let seen = pattern(seed);
            let intervals = intervals_of(|step| seen[step]);
            for i in 0..=4 * STEPS {
                let time = i as f32 / (4 * STEPS) as f32;
                let step = ((time * STEPS as f32) as usize).min(STEPS - 1);
                let share = seen_share(&intervals, &Window::new(time, 0.0, false));
                assert!(
                    (share - f32::from(u8::from(seen[step]))).abs() < 1e-3,
                    "{seed} {time}: {share}"
                );
            }
        }
    }

    #[test]
    fn a_point_lit_twelve_times_has_twelve_intervals() {
        let seen = |step: usize| step % 20 < 7 && step < 240;
        let intervals = intervals_of(seen);
        assert_eq!(intervals.len(), 12);
        for (at, interval) in intervals.iter().enumerate() {
            assert_eq!((interval.rise, interval.fall), (20 * at as u8, 20 * at as u8 + 6));
            let within = Window::new(interval.start() + 3.5 / 256.0, 7.0 / 256.0, false);
            assert!((seen_share(&intervals, &within) - 1.0).abs() < 1e-4);
        }
        let all = seen_share(&intervals, &Window::new(0.5, 1.0, false));
        assert!((all - 84.0 / 256.0).abs() < 1e-5);
    }

    #[test]
    fn always_never_and_the_ends_are_exact() {
        let always = intervals_of(|_| true);
        assert_eq!(always.as_slice(), [Interval { rise: 0, fall: 255 }]);
        assert!(intervals_of(|_| false).is_empty());
        let last = intervals_of(|step| step == 255);
        assert_eq!(last.as_slice(), [Interval { rise: 255, fall: 255 }]);
        for time in [0.0, 0.5, 1.0] {
            for width in [0.0, 0.01, 0.3, 1.0, 5.0, f32::NAN] {
                for is_closed in [false, true] {
                    let window = Window::new(time, width, is_closed);
                    assert!(
                        (seen_share(&always, &window) - 1.0).abs() < 1e-3,
                        "{time} {width}"
                    );
                    assert_eq!(seen_share(&[Interval::NONE], &window), 0.0);
                }
            }
        }
    }

    #[test]
    fn a_light_that_rises_within_the_window_is_seen_in_part() {
        let rises_at_noon = intervals_of(|step| step >= 128);
        let share = |time: f32| seen_share(&rises_at_noon, &Window::new(time, 0.1, false));
        assert_eq!(share(0.44), 0.0);
        assert!((share(0.5) - 0.5).abs() < 1e-5);
        assert!((share(0.56) - 1.0).abs() < 1e-5);
    }

    #[test]
    fn the_sun_shines_while_it_is_above_the_horizon() {
        let day = LightPath::Sun {
            latitude_degrees: 50.0,
            day: 81.0,
            hours: [0.0, 24.0],
        };
        let shining = shining(&day);
        assert_eq!(shining.as_slice(), [Interval { rise: 64, fall: 191 }]);
        let share = |time: f32| seen_share(&shining, &Window::new(time, 0.02, true));
        assert_eq!([share(0.0), share(0.2), share(0.9)], [0.0; 3]);
        assert!((share(0.25) - 0.5).abs() < 1e-3 && (share(0.5) - 1.0).abs() < 1e-3);
    }

    #[test]
    fn texels_are_evaluated_before_they_are_blended() {
        // One texel is lit before noon, the other one after it. Blended edges would be lit at no time at all.
        let before = intervals_of(|step| step < 128);
        let after = intervals_of(|step| step >= 128);
        let window = Window::new(0.25, 0.1, false);
        let at = |x: f32| blended([&before, &after, &before, &after], [x, 0.5], &window);
        assert_eq!([at(0.0), at(0.5), at(1.0)], [1.0, 0.5, 0.0]);
    }
}
