//! The surfaces of one occluder over one texel, as intervals of keys.
//!
//! **What a texel may claim.** Take the triangles of one occluder that face the same way in the picture: a
//! chain of triangles of equal orientation. Its boundary consists of the directed edges that do not cancel.
//! The number of times that the chain covers a point (its degree) can change only where that boundary is
//! crossed. So a texel that no boundary edge touches is covered either everywhere or nowhere, and its centre
//! decides which.
//!
//! The same holds for any part of the chain that no edge inside the texel connects with the rest. The
//! triangles over a texel are therefore sorted into clusters of overlapping key intervals. Two triangles that
//! share an edge over the texel share its keys, so such neighbours are never in different clusters. A cluster
//! that covers the centre and that no boundary edge reaches covers the whole texel, with surfaces no farther
//! than its farthest key. That key is what the texel may claim: at every one of its points, wherever a pixel
//! of any picture samples it, a surface stands at least that near.
//!
//! Rounding cannot break this. The degree does not change while no boundary edge moves across the texel, and
//! boundary edges are widened by far more than the error of coordinates ([`SLACK`](super::raster::SLACK)).

/// Clusters of one texel, nearest first. Two clusters are stored; everything behind the second is merged into
/// one unknown rest.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Layers {
    near: [f32; 2],
    far: [f32; 2],
    /// Greatest key of the unknown rest. Nothing is known at keys up to this one.
    rest: f32,
    count: u8,
    /// Bit `i` is set if a boundary edge reaches cluster `i`.
    open: u8,
    /// Bit `i` is set if cluster `i` covers the texel's centre.
    centered: u8,
}

/// One triangle or boundary edge over one texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    /// Greatest key over the texel.
    pub near: f32,
    /// Smallest key over the texel.
    pub far: f32,
    /// Whether this is a boundary edge.
    pub open: bool,
    /// Whether this covers the texel's centre.
    pub centered: bool,
}

impl Layers {
    pub(super) const EMPTY: Self = Self {
        near: [0.0; 2],
        far: [0.0; 2],
        rest: f32::NEG_INFINITY,
        count: 0,
        open: 0,
        centered: 0,
    };

    /// Adds a triangle or a boundary edge.
    pub(super) fn insert(&mut self, interval: Interval) {
        let Interval {
            mut near,
            mut far,
            mut open,
            mut centered,
        } = interval;
        // Merges the interval with all clusters that it overlaps.
        let mut kept = 0;
        for i in 0..usize::from(self.count) {
            if self.near[i] >= far && near >= self.far[i] {
                near = near.max(self.near[i]);
                far = far.min(self.far[i]);
                open |= self.open >> i & 1 != 0;
                centered |= self.centered >> i & 1 != 0;
            } else {
                self.move_cluster(i, kept);
                kept += 1;
            }
        }
        if far <= self.rest {
            self.rest = self.rest.max(near);
            self.count = kept as u8;
            return;
        }
        // Finds the cluster's place by depth.
        let mut at = kept;
        while at > 0 && self.near[at - 1] < near {
            at -= 1;
        }
        if kept == 2 {
            if at == 2 {
                self.rest = self.rest.max(near);
                self.count = 2;
                return;
            }
            self.rest = self.rest.max(self.near[1]);
            kept = 1;
        }
        for i in (at..kept).rev() {
            self.move_cluster(i, i + 1);
        }
        self.near[at] = near;
        self.far[at] = far;
        let bit = 1u8 << at;
        self.open = self.open & !bit | u8::from(open) << at;
        self.centered = self.centered & !bit | u8::from(centered) << at;
        self.count = kept as u8 + 1;
    }

    fn move_cluster(&mut self, from: usize, to: usize) {
        if from == to {
            return;
        }
        self.near[to] = self.near[from];
        self.far[to] = self.far[from];
        for bits in [&mut self.open, &mut self.centered] {
            *bits = *bits & !(1 << to) | (*bits >> from & 1) << to;
        }
    }

    /// A key such that surfaces at least this near cover every point of the texel. Minus infinity if no cover
    /// is known.
    pub(super) fn covered(&self) -> f32 {
        (0..usize::from(self.count))
            .filter(|i| self.open >> i & 1 == 0 && self.centered >> i & 1 != 0 && self.far[*i] > self.rest)
            .map(|i| self.far[i])
            .next()
            .unwrap_or(f32::NEG_INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layers(intervals: &[(f32, f32, bool, bool)]) -> Layers {
        let mut layers = Layers::EMPTY;
        for &(near, far, open, centered) in intervals {
            layers.insert(Interval {
                near,
                far,
                open,
                centered,
            });
        }
        layers
    }

    #[test]
    fn the_nearest_whole_cluster_counts() {
        assert_eq!(layers(&[(3.0, 2.0, false, true)]).covered(), 2.0);
        assert_eq!(layers(&[(3.0, 2.0, false, false)]).covered(), f32::NEG_INFINITY);
        // A relief in front of a wall spoils only its own claim.
        let relief = [(5.0, 4.5, true, true), (3.0, 2.0, false, true)];
        assert_eq!(layers(&relief).covered(), 2.0);
        let mut turned = relief;
        turned.reverse();
        assert_eq!(layers(&turned).covered(), 2.0);
    }

    #[test]
    fn overlapping_intervals_are_one_cluster() {
        let chain = [
            (3.0, 2.0, false, true),
            (1.0, 0.5, true, false),
            (2.5, 0.8, false, false),
        ];
        assert_eq!(layers(&chain).covered(), f32::NEG_INFINITY);
        assert_eq!(layers(&chain[..2]).covered(), 2.0);
    }

    #[test]
    fn what_was_forgotten_never_joins_a_cluster_unseen() {
        let three = [
            (9.0, 8.0, true, true),
            (6.0, 5.0, false, true),
            (3.0, 2.0, true, true),
        ];
        assert_eq!(layers(&three).covered(), 5.0);
        // A triangle that reaches from the second cluster into the third, which was forgotten.
        let mut bridged = three.to_vec();
        bridged.push((5.5, 2.5, false, false));
        assert_eq!(layers(&bridged).covered(), f32::NEG_INFINITY);
    }

    #[test]
    fn order_does_not_matter_to_what_is_safe() {
        // Compares with keeping every interval: whatever is claimed must be true.
        let mut state = 7u64;
        let mut random = |n: u64| {
            state = state
                .wrapping_mul(6364136223846793005)
                .wrapping_add(1442695040888963407);
            (state >> 33) % n
        };
        for _ in 0..20_000 {
            let intervals: Vec<_> = (0..1 + random(7))
                .map(|_| {
                    let far = random(20) as f32;
                    (far + random(4) as f32, far, random(4) == 0, random(2) == 0)
                })
                .collect();
            let claimed = layers(&intervals).covered();
            if claimed == f32::NEG_INFINITY {
                continue;
            }
            let mut sorted = intervals.clone();
            sorted.sort_by(|a, b| b.0.total_cmp(&a.0));
            let mut clusters: Vec<(f32, f32, bool, bool)> = Vec::new();
            for interval in sorted {
                match clusters.last_mut() {
                    Some(last) if interval.0 >= last.1 => {
                        last.1 = last.1.min(interval.1);
                        last.2 |= interval.2;
                        last.3 |= interval.3;
                    }
                    _ => clusters.push(interval),
                }
            }
            let truth = clusters.iter().find(|c| !c.2 && c.3).map(|c| c.1);
            assert!(truth.is_some_and(|truth| truth >= claimed), "{intervals:?}");
        }
    }
}
